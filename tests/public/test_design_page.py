"""The page of the design and the records of decisions stay short and whole."""

import re
from pathlib import Path

DOCS = Path(__file__).parents[2] / "docs"
PAGE = (DOCS / "design.md").read_text("utf-8")
RECORDS = sorted((DOCS / "decisions").glob("0*.md"))


def test_the_design_and_its_decisions_are_short():
    assert len(PAGE.splitlines()) <= 200
    assert 8 <= len(RECORDS) <= 20
    for record in RECORDS:
        text = record.read_text("utf-8")
        assert len(text.splitlines()) <= 25, record.name
        heads = re.findall(r"^## (.*)$", text, re.M)
        assert heads == ["Context", "Decision", "Consequence"], record.name


def test_the_decisions_are_all_listed():
    index = (DOCS / "decisions" / "index.md").read_text("utf-8")
    listed = index.split("```{toctree}")[1].split()[2:-1]
    assert listed == [record.stem for record in RECORDS]
