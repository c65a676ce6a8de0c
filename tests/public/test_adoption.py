"""What is written for those who cite, build, ship or contribute says what is there."""

import importlib.metadata
import re
import runpy
import sys
import tomllib
from pathlib import Path

import numpy as np
import pvlib
import pytest
import yaml
from pvlib.temperature import TEMPERATURE_MODEL_PARAMETERS

import pvlib_fem as fem

ROOT = Path(__file__).parents[2]
METHOD = "10.22541/au.166922866.68736478"
SECTIONS = (  # of the journal's format
    "Summary",
    "Statement of need",
    "State of the field",
    "Software design",
    "Research impact statement",
    "AI usage disclosure",
    "Acknowledgements",
    "References",
)
STEADY = {  # pvlib's own coefficients, by model
    "faiman": {"u0": 25.0, "u1": 6.84},
    "sapm_cell": TEMPERATURE_MODEL_PARAMETERS["sapm"]["open_rack_glass_polymer"],
    "pvsyst_cell": {"u_c": 29.0, "u_v": 0.0},
}


def text(name):
    return (ROOT / name).read_text(encoding="utf-8")


PROJECT = tomllib.loads(text("pyproject.toml"))["project"]


def bounds(rows):
    """Lower bounds by package, of ``name>=version``."""
    return dict(re.split(" *>=", row) for row in rows)


def test_the_version_to_come_is_the_same_everywhere():
    recipe = yaml.safe_load(text("conda.recipe/recipe.yaml"))["context"]["version"]
    (built,) = re.findall(r'default="(.+?)"', recipe)
    cited = yaml.safe_load(text("CITATION.cff"))["version"]
    assert built == cited == re.search(r"^## (\S+)", text("CHANGELOG.md"), re.M)[1]


def test_the_version_is_of_a_tag_and_known_where_it_is_installed(monkeypatch):
    assert "version" in PROJECT["dynamic"] and "version" not in PROJECT
    assert fem.__version__ == importlib.metadata.version("pvlib_fem")
    monkeypatch.setattr(sys, "path", [str(ROOT / "docs")])  # nothing is installed here
    assert fem.__version__ == "0.0"


def test_the_recipe_needs_what_the_package_needs():
    recipe = yaml.safe_load(text("conda.recipe/recipe.yaml"))
    python, *rest = recipe["requirements"]["run"]
    assert bounds(rest) == bounds(PROJECT["dependencies"])
    assert python == "python >=${{ python_min }}"
    assert f">={recipe['context']['python_min']}" == PROJECT["requires-python"]
    (command,) = recipe["build"]["python"]["entry_points"]
    assert dict([command.split(" = ")]) == PROJECT["scripts"]


def test_the_oldest_dependencies_are_the_lower_bounds():
    extras = PROJECT["optional-dependencies"].values()
    asked = [*PROJECT["dependencies"], *(row for rows in extras for row in rows)]
    lowest = dict(re.findall(r"^(\S+)==(\S+)$", text(".github/oldest.txt"), re.M))
    assert lowest
    for name, version in bounds(PROJECT["dependencies"]).items():
        assert lowest[name] == version
    for name, version in lowest.items():
        bound = next(row for row in asked if row.split(">=")[0] == name)
        assert (version + ".0").startswith(bound.split(">=")[1])


def test_nothing_claims_an_address_that_is_not_there():
    # the package has no public home yet; the paper of its method has
    assert [*PROJECT["urls"].values()] == [f"https://doi.org/{METHOD}"]
    assert "github.com/pvlib/pvlib_fem" not in text("benchmarks/asv.conf.json")


def test_the_paper_is_in_the_form_of_the_journal():
    _, head, body = text("paper.md").split("---\n", 2)
    head = yaml.safe_load(head)
    assert {"title", "tags", "authors", "affiliations", "date"} < {*head}
    assert {author["affiliation"] for author in head["authors"]} == {
        place["index"] for place in head["affiliations"]
    }
    assert tuple(re.findall("^# (.+)$", body, re.M)) == SECTIONS
    assert 750 <= len(body.split()) <= 1750


def test_every_reference_is_cited_and_has_a_doi():
    cited = {*re.findall(r"@(\w+)", text("paper.md").split("---\n", 2)[2])}
    entries = re.findall(r"^@\w+\{(\w+),(.*?)^\}", text("paper.bib"), re.M | re.S)
    assert {name for name, _ in entries} == cited
    assert entries
    for name, fields in entries:
        assert re.search(r"doi +=\s\{10\.\d{4,}/\S+\}", fields), name


@pytest.mark.parametrize(
    "number", ["4.1 K", "2.2 K", "1.49 K", "1.15 K", "16 times", "ten draws of ten"]
)
def test_numbers_of_the_paper_are_those_of_the_readme(number):
    assert number in text("README.md")
    assert number.replace("16 times", "16 changes") in text("paper.md")


def test_its_figure_is_drawn_by_the_script(tmp_path):
    script = runpy.run_path(str(ROOT / "docs" / "paper_figure.py"))
    path = tmp_path / "paper.png"
    script["draw"](script["closed"](days=70, start="2023-04-01"), path)
    assert path.stat().st_size > 10_000
    assert "](paper.png)" in text("paper.md")


def test_the_page_of_stable_names_has_all_of_them():
    page = text("docs/stability.md").split("## Stable\n")[1].split("\n## ")[0]
    listed = re.findall(r"(?<!\})`(\w+)`", "".join(re.findall(r"^\|.*", page, re.M)))
    assert sorted(listed) == sorted({*fem.__all__} - {"__version__"})


@pytest.mark.parametrize(
    "name", ["README.md", "CONTRIBUTING.md", "docs/contributing.md"]
)
def test_links_to_files_lead_to_files(name):
    links = re.findall(r"\]\(([^)#]+)[^)]*\)", text(name))
    files = [link for link in links if not link.startswith("http")]
    assert all((ROOT / name).parent.joinpath(link).exists() for link in files), files


def test_steady_and_dynamic_errors_of_the_page_for_pvlib(week):
    page = text("docs/for_pvlib.md")
    rows = re.findall(r"^\| `(\w+)`.*\| ([\d.]+) \| ([\d.]+) \|$", page, re.M)
    assert [name for name, *_ in rows] == [*STEADY]
    sun = week["poa_global"] > 20
    for name, *stated in rows:
        for tau, error in zip((1e-6, 378.0), stated):
            modelled = fem.fem_temperature(
                *(week[n] for n in ("poa_global", "temp_air", "wind_speed")),
                model=getattr(pvlib.temperature, name),
                tau=tau,
                **STEADY[name],
            )
            left = (week["temp_module"] - modelled)[sun]
            assert float(error) == pytest.approx(np.sqrt((left**2).mean()), abs=0.051)
