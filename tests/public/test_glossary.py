"""The glossary: each term once, and names that the code has."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "glossary.md").read_text("utf-8")
CODE = "\n".join(
    path.read_text("utf-8") for path in sorted((ROOT / "pvlib_fem").rglob("*.py"))
)
ENTRY = re.compile(r"^(\S.*)\n((?:  \S.*\n?)+)", re.M)
BLOCKS = re.findall(r"```\{glossary\}\n:sorted:\n\n(.*?)```", PAGE, re.S)
ENTRIES = [entry for block in BLOCKS for entry in ENTRY.findall(block)]
#: parts of names, and names that files and reports make from parts
WORD = re.compile(r"`([A-Za-z_.\"]+?)(?:_\*)?`")
NAMES = [
    (term, name)
    for term, meaning in ENTRIES
    for name in WORD.findall(meaning.partition("Code:")[2].partition("Before:")[0])
]


def test_each_term_stands_once():
    terms = [term for term, _ in ENTRIES]
    assert len(terms) > 40 and len(terms) == len(set(terms))


@pytest.mark.parametrize(("term", "name"), NAMES)
def test_the_code_has_the_names_that_a_term_has_there(term, name):
    last = name.strip('"').rpartition(".")[2].strip("_")
    assert re.search(rf"\b_?{last}_?\b", CODE), f"{term}: no {name} in the code"


def test_terms_that_point_to_others_point_to_terms():
    terms = {term for term, _ in ENTRIES}
    used = re.findall(r"\{term\}`([^`<]+)`", PAGE)
    assert used and set(used) <= terms
