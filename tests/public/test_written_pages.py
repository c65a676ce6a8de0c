"""Pages that scripts write have the sentences of these scripts as they are."""

import importlib
import re
from pathlib import Path

import pytest

DOCS = Path(__file__).parents[2] / "docs"
PAGES = {
    "study": "study",
    "study_ceiling": "ceiling",
    "study_coverage": "coverage",
    "study_detectors": "detectors",
    "study_events": "study_events",
    "study_gate": "gate",
    "study_measured": "study_measured",
    "study_parameters": "study_parameters",
    "study_recovery": "study_recovery",
    "study_reliability": "study_reliability",
    "study_trackers": "study_trackers",
    "study_weather": "study_weather",
    "sweep": "sensitivity",
}
TEXTS = ("INTRO", "METHOD", "APART", "OUTRO", "WITHOUT", "LASTING", "LIMITS")
TEXTS += ("SHIFTS", "QUOTED", "DATA", "PUT_IN", "TOTAL", "EDGES")
MADE = (
    r"^Made by `make ([a-z-]+)` on \d{4}-\d\d-\d\d: "
    r"pvlib_fem at commit [0-9a-f]{7}[,.]$"
)


def joined(text):
    return " ".join(text.split())


def pieces(template):
    """What a template has between the values that it takes."""
    whole = template.replace("{{", "\0").replace("}}", "\1")
    for piece in re.split(r"\{[^{}]*\}|\n\n", whole):
        yield joined(piece.replace("\0", "{").replace("\1", "}"))


@pytest.mark.parametrize(("script", "page"), PAGES.items())
def test_a_page_has_the_sentences_of_its_script(script, page):
    module = importlib.import_module(script)
    texts = [getattr(module, name, None) for name in TEXTS]
    texts = [text for text in texts if isinstance(text, str)]
    assert texts
    shown = joined((DOCS / f"{page}.md").read_text("utf-8"))
    # a page with the rows of the oracle says so, and one without, too
    if rules := [
        getattr(module, n) for n in ("RULES", "NO_RULES") if hasattr(module, n)
    ]:
        assert sum(joined(text) in shown for text in rules) == 1
    for text in texts:
        assert [piece for piece in pieces(text) if piece not in shown] == []


@pytest.mark.parametrize("page", [*PAGES.values(), "study_instruments"])
def test_a_page_says_when_and_with_which_version_it_was_made(page):
    lines = (DOCS / f"{page}.md").read_text("utf-8").splitlines()
    made = [match for line in lines if (match := re.match(MADE, line))]
    assert len(made) == 1
    makefile = (DOCS.parent / "Makefile").read_text("utf-8")
    assert f"\n{made[0][1]}:" in makefile


def test_a_study_writes_that_line_after_the_title(tmp_path):
    path = tmp_path / "page.md"
    importlib.import_module("study_page").publish("# Title\n\nText.", path, "make gate")
    title, gap, made, versions, *rest = path.read_text("utf-8").splitlines()
    assert (title, gap, rest) == ("# Title", "", ["", "Text."])
    assert re.match(MADE, made)
    assert versions.startswith("pvlib ") and "numpy " in versions
