"""What a page is made of: escaped text, lists, tables, numbers for readers."""

import html

import numpy as np

from pvlib_fem.record.columns import printable

STYLE = """
:root { color-scheme: light dark;
  --page: #ffffff; --ink: #1c1d1f; --soft: #5c6066; --line: #d9dce0; --card: #f5f6f8;
  --after: #0072b2; --before: #d55e00; --shade: rgb(0 0 0 / 35%); }
@media (prefers-color-scheme: dark) { :root {
  --page: #16181b; --ink: #e8e9eb; --soft: #a0a5ac; --line: #383c42; --card: #1f2226;
  --after: #56b4e9; --before: #f0883e; --shade: rgb(255 255 255 / 45%); } }
* { box-sizing: border-box; }
body { margin: 0 auto; padding: 1.5rem 1rem 3rem; max-width: 66rem; color: var(--ink);
  background: var(--page); font: 16px/1.5 system-ui, sans-serif; }
h1 { font-size: 1.7rem; line-height: 1.2; margin: 0 0 .5rem; }
h2 { font-size: 1.15rem; margin: 2.2rem 0 .6rem; border-bottom: 1px solid var(--line); }
h3 { font-size: 1rem; margin: 1.6rem 0 .5rem; max-width: 46rem;
  overflow-wrap: anywhere; }
p, li { overflow-wrap: anywhere; max-width: 46rem; }
.plant { color: var(--soft); margin: 0; }
.alert { border-left: .3rem solid var(--before); padding: .5rem .8rem;
  background: var(--card); }
.soft, figcaption { color: var(--soft); font-size: .9rem; }
/* a shade at an edge beyond which more follows; it moves with what is there */
.wide, pre { --under: var(--page); overflow-x: auto; background:
  linear-gradient(to right, var(--under) 40%, transparent) 0 0 / 3rem 100% local,
  linear-gradient(to left, var(--under) 40%, transparent) 100% 0 / 3rem 100% local,
  linear-gradient(to right, var(--shade), transparent) 0 0 / 1.1rem 100% scroll,
  linear-gradient(to left, var(--shade), transparent) 100% 0 / 1.1rem 100% scroll;
  background-repeat: no-repeat; }
pre { --under: var(--card); }
table { border-collapse: collapse; font-size: .9rem; }
th, td { padding: .3rem 1.1rem .3rem 0; text-align: left; vertical-align: top;
  border-bottom: 1px solid var(--line); }
th { font-weight: 600; }
th, td { white-space: nowrap; }
.text th, .text td { white-space: normal; }
.text td:first-child { min-width: 16rem; }
.text td:last-child { min-width: 10rem; }
.n { text-align: right; font-variant-numeric: tabular-nums; }
.figures { display: grid; gap: 1rem;
  grid-template-columns: repeat(auto-fill, minmax(min(100%, 24rem), 1fr)); }
figure { margin: 0; padding: .7rem; background: var(--card); border-radius: .5rem; }
figcaption { margin-bottom: .4rem; }
figcaption strong { display: block; color: var(--ink); margin-bottom: .2rem; }
svg { display: block; width: 100%; height: auto; }
svg text { font-family: system-ui, sans-serif !important; }
pre { padding: .8rem; background-color: var(--card); border-radius: .5rem;
  font-size: .8rem; line-height: 1.4; }
@media (max-width: 30rem) {
  th, td { padding-right: .6rem; } ul, ol { padding-left: 1.3rem; }
  .figures > * { margin: 0 -.6rem; padding: .7rem .3rem; }
  figcaption { padding: 0 .4rem; } }
summary { cursor: pointer; }
a { color: var(--after); }
"""


def document(title, parts):
    """
    One self-contained HTML file that runs no script.

    Parameters
    ----------
    title : str
    parts : sequence of str
        HTML, in order.

    Returns
    -------
    str
    """
    policy = "default-src 'none'; style-src 'unsafe-inline'; img-src data:"
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f'<meta http-equiv="Content-Security-Policy" content="{policy}">\n'
        f"<title>{escaped(title)}</title>\n"
        f"<style>{STYLE}</style>\n</head>\n<body>\n"
        + "\n".join(parts)
        + "\n</body>\n</html>\n"
    )


class Markup(str):
    """HTML that stands as it is."""


def link(words, address):
    """A link, for a cell of a table or any other text."""
    return Markup(f'<a href="{html.escape(address)}">{escaped(words)}</a>')


def escaped(text):
    if isinstance(text, Markup):
        return text
    return html.escape(printable(text, "\n\t"))


def section(title, body):
    return f"<section>\n<h2>{escaped(title)}</h2>\n{body}\n</section>"


def paragraph(text, kind=""):
    kind = f' class="{kind}"' if kind else ""
    return f"<p{kind}>{escaped(text)}</p>"


def listed(items, ordered=False):
    """A list of pairs: a name, and the text on it."""
    rows = (
        f"<li><strong>{escaped(name)}</strong>: {escaped(words)}</li>"
        for name, words in items
    )
    tag = "ol" if ordered else "ul"
    return f"<{tag}>\n" + "\n".join(rows) + f"\n</{tag}>"


def table(head, rows, caption="", wraps=False):
    """
    A table whose numbers, formatted already, stand in the columns marked ``#``.

    ``wraps`` breaks long cells into lines.
    """
    kind = ' class="text"' if wraps else ""
    kinds = [' class="n"' if name.startswith("#") else "" for name in head]

    def line(cells, tag):
        cells = (f"<{tag}{k}>{escaped(c)}</{tag}>" for k, c in zip(kinds, cells))
        return f"<tr>{''.join(cells)}</tr>"

    top = line([name.removeprefix("#") for name in head], "th")
    body = "\n".join(line(row, "td") for row in rows)
    return (
        f'<div class="wide" tabindex="0"><table{kind}>\n'
        f"<thead>{top}</thead>\n"
        f"<tbody>\n{body}\n</tbody>\n</table></div>\n"
        + (paragraph(caption, "soft") if caption else "")
    )


def figures(pictures):
    """A grid of ``svg`` elements, each with what it shows and perhaps a title."""
    body = []
    for svg, words, *title in pictures:
        head = "".join(f"<strong>{escaped(one)}</strong>" for one in title)
        named = svg.replace("<svg", f'<svg role="img" aria-label="{escaped(words)}"', 1)
        caption = f"<figcaption>{head}{escaped(words)}</figcaption>"
        body.append(f"<figure>\n{caption}\n{named}\n</figure>")
    return '<div class="figures">\n' + "\n".join(body) + "\n</div>"


def number(value):
    """Two decimals, without a negative zero; a dash where there is none."""
    return f"{value:z.2f}" if np.isfinite(value) else "–"


def rounded(error):
    """Two digits, and never 2e+03; a dash where there is none."""
    return f"{float(f'{error:.2g}'):g}" if np.isfinite(error) else "–"


def spanned(low, high):
    """From and to, to two digits of half of what is between them."""
    half = (high - low) / 2.0
    if not half > 0:
        return f"{low:.4g}"
    digits = max(0, 1 - int(np.floor(np.log10(float(f"{half:.1e}")))))
    return f"{low:z.{digits}f} … {high:z.{digits}f}"


def value_and_error(fit, name):
    """Cells of a table: a coefficient and its error."""
    value, error = fit.coefficients[name], fit.stderr[name]
    if name in fit.fixed:
        return f"{value:.5g}", "held"
    if not error > 0:
        return f"{value:.5g}", "–"
    return tuple(with_error(value, error).split(" ± "))


def with_error(value, error):
    """A value to the two digits of its error, and that; alone without one."""
    if not (np.isfinite(error) and error > 0):
        return f"{value:.4g}"
    last = int(np.floor(np.log10(float(f"{error:.1e}")))) - 1  # place of both
    digits = max(0, -last)
    value, error = round(value, -last), round(error, -last)
    return f"{value:z.{digits}f} ± {error:.{digits}f}"
