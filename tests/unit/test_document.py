"""Pages escape whatever comes from a user's file, in every place of every template."""

import re
from importlib.resources import files

import numpy as np
import pytest
from test_report import Page

from pvlib_fem._report import document as made
from pvlib_fem._report.formatting import two_decimals

HOSTILE = (
    "<script>alert(1)</script>",
    '" onload="alert(1)',
    "' onmouseover='alert(1)",
    "</pre></style><img src=x onerror=alert(1)>",
    "{{ 7 * 7 }}{% raw %}",
    "a & b &lt; c",
)
SVG = '<svg viewBox="0 0 1 1"><text>a picture</text></svg>'


def page_of(words):
    """A page with these words in each place that takes any."""
    blocks = [
        made.Heading(words, "h1"),
        made.Paragraph(words),
        made.listed([(words, words)]),
        made.Listing([], [words]),
        made.table((words, "#n", "@since"), [(words, "1", words)], words),
        made.table(("page",), [(made.Link(words, words),)]),
        made.figures([(SVG, words, words)]),
        made.Verbatim(words),
        made.Verbatim(words, words),
    ]
    return made.document(words, [made.section(words, blocks)])


@pytest.mark.parametrize("words", HOSTILE)
def test_every_place_shows_the_text_and_nothing_else(words):
    text = page_of(words)
    page, harmless = Page(text), Page(page_of("harmless"))
    assert page.tags == harmless.tags
    assert [n for n, _ in page.attributes] == [n for n, _ in harmless.attributes]
    assert page.texts.count(words) == harmless.texts.count("harmless") > 12
    values = [value for _, value in page.attributes]
    assert values.count(words) == 2  # a label and an address


def test_what_steers_a_terminal_or_a_line_is_shown():
    text = page_of("a\x1b[2J\u202eb\nc")
    assert "\x1b" not in text and "\u202e" not in text and "a�[2J�b\nc" in text


def test_an_svg_stands_as_it_is_and_a_number_as_it_is_printed():
    assert SVG in page_of("x")
    table = made.table(("a", "#b"), [("one", 2)])
    assert '<td>one</td><td class="n">2</td>' in made.fragment([table])
    assert two_decimals(-0.001) == "0.00" and two_decimals(np.nan) == "–"


def test_a_value_that_a_template_does_not_know_is_an_error():
    with pytest.raises(Exception, match="style"):
        made.fragment([type("Half", (), {"kind": "paragraph", "text": "x"})()])


def test_templates_switch_off_no_escape():
    """Only svg elements are markup, and no template says so itself."""
    folder = files("pvlib_fem._report") / "templates"
    names = {path.name for path in folder.iterdir()}
    assert names == {"page.html", "fragment.html", "blocks.html", "style.css"}
    for path in folder.iterdir():
        text = path.read_text("utf-8")
        assert not re.search(r"\|\s*safe|autoescape|Markup", text), path.name
    assert made.environment().autoescape is True
