"""What a page is made of: texts, lists, tables, pictures; and numbers for readers."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any, ClassVar

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from pvlib_fem._record.column_names import printable

#: kinds of columns by the first sign of their head: of numbers, of dates
KINDS = {"#": "n", "@": "date"}


@dataclass(frozen=True)
class Section:
    """A part of a page under a title."""

    kind: ClassVar = "section"
    title: str
    body: "list[Block]"


@dataclass(frozen=True)
class Heading:
    """A heading of a level, such as ``h1``."""

    kind: ClassVar = "heading"
    text: str
    level: str


@dataclass(frozen=True)
class Paragraph:
    """Text with a style: a class of the style sheet, such as ``"soft"``."""

    kind: ClassVar = "paragraph"
    text: str
    style: str = ""


@dataclass(frozen=True)
class Listing:
    """Items of a list: pairs of a name and the text on it, or texts."""

    kind: ClassVar = "listing"
    pairs: list[tuple[str, str]]
    texts: list[str]
    ordered: bool = False


@dataclass(frozen=True)
class Table:
    """A table whose cells are texts or links; each column has a style."""

    kind: ClassVar = "table"
    head: list[str]
    styles: list[str]
    rows: "list[list[str | Link]]"
    caption: str = ""
    wraps: bool = False


@dataclass(frozen=True)
class Figure:
    """An ``svg`` element, what it shows, and a title."""

    svg: Markup
    caption: str
    title: str = ""


@dataclass(frozen=True)
class Figures:
    kind: ClassVar = "figures"
    figures: list[Figure]


@dataclass(frozen=True)
class Verbatim:
    """Text as it is, behind a line that opens it if it has a summary."""

    kind: ClassVar = "verbatim"
    text: str
    summary: str = ""


@dataclass(frozen=True)
class Link:
    """A link, for a cell of a table."""

    text: str
    address: str


#: what a page is made of
Block = Section | Heading | Paragraph | Listing | Table | Figures | Verbatim
#: blocks, and sequences of them
Parts = Sequence["Block | Parts"]


@cache
def environment() -> Environment:
    """Templates that escape every value, and show what would steer a page or a file."""

    def shown(value: Any) -> Any:
        return value if isinstance(value, Markup) else printable(value, "\n\t")

    return Environment(
        loader=PackageLoader("pvlib_fem._report"),
        autoescape=True,
        finalize=shown,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )


def flat(parts: Parts) -> list[Block]:
    """Blocks of nested lists, in order."""
    blocks: list[Block] = []
    for one in parts:
        blocks += flat(one) if isinstance(one, Sequence) else [one]
    return blocks


def document(title: str, parts: Parts) -> str:
    """
    One self-contained HTML file that runs no script.

    Parameters
    ----------
    title : str
    parts : sequence
        Blocks in order, such as a `Section`, or lists of them.

    Returns
    -------
    str
    """
    return (
        environment().get_template("page.html").render(title=title, parts=flat(parts))
    )


def fragment(parts: Parts) -> str:
    """
    Blocks as HTML inside another page, such as a notebook.

    Parameters
    ----------
    parts : sequence
        Blocks in order, or lists of them.

    Returns
    -------
    str
    """
    return environment().get_template("fragment.html").render(parts=flat(parts))


def section(title: str, *body: Block | Parts) -> Section:
    """
    Blocks under a title.

    Parameters
    ----------
    title : str
        Title of the section.
    *body : Block or sequence
        Blocks in order, or lists of them.

    Returns
    -------
    Section
    """
    return Section(title, flat(body))


def listed(items: Iterable[tuple[str, str]], ordered: bool = False) -> Listing:
    """
    A list of pairs: a name, and the text on it.

    Parameters
    ----------
    items : iterable of (str, str)
        Name and text of each item.
    ordered : bool, default False
        Number the items.

    Returns
    -------
    Listing
    """
    return Listing(list(items), [], ordered)


def table(
    head: Sequence[str],
    rows: Iterable[Sequence[str | Link]],
    caption: str = "",
    wraps: bool = False,
) -> Table:
    """
    A table of formatted cells.

    Columns whose head begins with ``#`` hold numbers, with ``@`` dates.

    Parameters
    ----------
    head : sequence of str
        Heads of the columns.
    rows : iterable of sequence of str or Link
        A cell for each column.
    caption : str, optional
    wraps : bool, default False
        Break long cells into lines.

    Returns
    -------
    Table
    """
    styles = [KINDS.get(name[:1], "") for name in head]
    names = [name[1:] if style else name for name, style in zip(head, styles)]
    return Table(names, styles, [list(row) for row in rows], caption, wraps)


def figures(pictures: Iterable[tuple[str, ...]]) -> Figures:
    """
    A grid of ``svg`` elements, each with what it shows and perhaps a title.

    Parameters
    ----------
    pictures : iterable of tuple of str
        An ``svg`` element, which is not escaped, its caption and, optionally, its
        title.

    Returns
    -------
    Figures
    """
    return Figures([Figure(Markup(svg), *words) for svg, *words in pictures])
