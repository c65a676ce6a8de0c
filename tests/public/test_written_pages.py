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
    "study_gate": "gate",
    "study_measured": "study_measured",
    "study_parameters": "study_parameters",
    "study_recovery": "study_recovery",
    "sweep": "sensitivity",
}
TEXTS = ("INTRO", "METHOD", "RULES", "APART", "OUTRO", "WITHOUT", "LASTING", "LIMITS")
TEXTS += ("SHIFTS", "QUOTED", "DATA", "PUT_IN", "TOTAL")


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
    texts = [getattr(module, name) for name in TEXTS if hasattr(module, name)]
    assert texts
    shown = joined((DOCS / f"{page}.md").read_text("utf-8"))
    for text in texts:
        assert [piece for piece in pieces(text) if piece not in shown] == []
