"""The pages of effects have all of the registry; the how-to runs as it stands."""

import inspect
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import pvlib_fem
from pvlib_fem.drivers import DERIVED, MEASURED, needed_for
from pvlib_fem.effects import CHANGES, PHYSICS as EFFECTS, SENSOR_FAULTS, find

DOCS = Path(__file__).parents[2] / "docs"
sys.path.insert(0, str(DOCS / "_ext"))
import effects_page  # noqa: E402

every = pytest.mark.parametrize("name", EFFECTS)
COLUMNS = ("heat", "loss", "capacity", "offset")


PAGES = effects_page.pages()


def equations(function):
    """Left and right side of the equations in a docstring, names as in the code."""
    text = inspect.getdoc(function).replace("\\_", "_")
    for lines in re.findall(r"\.\. math::\s+(.*?)\n\n", text, re.DOTALL):
        yield " ".join(lines.split()).split(" = ", 1)


@every
def test_every_effect_has_all_that_a_reader_needs(name):
    said, effect = PAGES[f"effects/{name}.rst"], find(name)
    assert f".. _effect-{name}:" in said
    assert re.search(r"\.\. math::\s+\\mathrm\{(heat|loss|capacity|offset)\} = ", said)
    assert effect.rows() and effect.forms
    for parameter, row in effect.rows().items():
        bounds = [effects_page.number(edge) for edge in (row.lower, row.upper)]
        unit = re.escape(row.unit if row.unit != "-" else "\\-")
        cells = rf"``{parameter}``\n +- {unit}\n +- {bounds[0]} to {bounds[1]}\n"
        assert re.search(cells, said), parameter
    for variant in effect.forms:
        assert not effect.variants or variant.source in said
        for driver in variant.drivers:
            assert re.search(rf":ref:`{driver} <\w+-{driver}>`\n +- \S", said), driver
    assert effect.confused_with and effect.decided_by
    assert f":Would decide: {effect.decided_by}\n" in said
    alike = said.split(":Looks like: ")[1].split("\n")[0]
    assert all(other in alike for other in effect.confused_with)
    assert re.search(r":Source: .{20}", said)


@every
def test_an_equation_has_the_names_of_the_code(name):
    effect = find(name)
    left, right = next(equations(effects_page.forms(effect)[0]))
    assert effect.drivers and effect.parameters
    for driver in effect.drivers:
        assert f"\\mathrm{{{driver}}}" in right
    for parameter in effect.parameters:
        assert f"\\mathrm{{{parameter}}}" in right
    assert left.removeprefix("\\mathrm{").removesuffix("}") in COLUMNS


@every
def test_an_equation_stands_for_the_column_that_the_terms_add_to(name):
    for effect in (find(name), *find(name).variants):
        # low sun in the east, where the window of shading is
        drivers = [
            np.array([80.0 if "solar" in driver else 7.0 + i])
            for i, driver in enumerate(effect.drivers)
        ]
        own = {key: 0.5 * row.upper for key, row in effect.parameters.items()}
        terms = effect.terms(*drivers, **own)
        adds = {c for c in COLUMNS if np.any(getattr(terms, c) != 0)}
        function = getattr(effect.terms, "func", effect.terms)
        assert {f"\\mathrm{{{c}}}" for c in adds} == {e[0] for e in equations(function)}


@every
def test_what_looks_like_an_effect_by_name_is_another_one(name):
    for other in find(name).confused_with:
        assert " " in other or other in EFFECTS | CHANGES, other
        assert other != name


@pytest.mark.parametrize(
    "variant", [v for effect in EFFECTS.values() for v in effect.variants]
)
def test_a_variant_is_confused_with_what_the_effect_is(variant):
    assert variant.confused_with == find(variant.name).confused_with


def test_every_column_and_driver_says_what_it_is_in_its_unit():
    effects = [form for effect in EFFECTS.values() for form in effect.forms]
    behind = {c for effect in effects for c in needed_for(effect.drivers)}
    assert set(MEASURED) >= behind
    said = {
        name: effects_page.words(compute)[0] for name, (_, compute) in DERIVED.items()
    }
    for name, words in {**MEASURED, **said}.items():
        assert re.fullmatch(r"[A-Z:].* \[.+\]", words), name


def test_the_first_page_leads_to_all_others():
    first, *others = PAGES
    assert others
    for path in others:
        assert f"\n   {path.removesuffix('.rst')}\n" in PAGES[first]
    for name in [*EFFECTS, *(c.name for c in SENSOR_FAULTS)]:
        assert PAGES[first].count(f":ref:`{name} <effect-{name}>`") == 1


def test_a_driver_has_the_source_of_what_it_is_computed_by():
    page = PAGES["effects/drivers.rst"]
    rows = page.split("Derived drivers\n---")[1].split("   * - ")
    found = {row.split("``")[1]: row for row in rows if "driver-" in row}
    assert set(DERIVED) <= set(found)
    assert "10.1002/qj.49712253306" in found["sky_deficit_moist"]  # Prata
    assert "10.1016/0038-092X(82)90302-4" in found["clearness"]  # Erbs


def test_a_report_explains_shade_by_shade():
    """And not by what Python says of functions with some arguments given."""
    assert find("shading").terms.__doc__.strip().startswith("Beam that a module loses")
    sensor = find({"name": "shading", "windows": [[90, 120, 0, 15]], "sensor": True})
    assert "irradiance sensor" in sensor.terms.__doc__


def test_a_page_that_has_not_changed_is_not_written(tmp_path):
    effects_page.write(tmp_path)
    same, stale = tmp_path / "effects.rst", tmp_path / "effects" / "rain.rst"
    gone = tmp_path / "effects" / "effect_of_another_branch.rst"
    text = stale.read_text(encoding="utf-8")
    for path in (stale, gone):
        path.write_text("stale", encoding="utf-8")
    os.utime(same, (1, 1))
    effects_page.write(tmp_path)
    assert same.stat().st_mtime == 1
    assert stale.read_text("utf-8") == text
    assert not gone.exists()


def test_a_file_and_a_line_make_an_effect(tmp_path):
    """The blocks of the how-to, in a copy of the package: it is on the page."""
    how_to = (DOCS / "adding_an_effect.md").read_text(encoding="utf-8")
    blocks = re.findall(r"```python\n(.*?)```", how_to, re.DOTALL)
    file, line, driver, row = (block for block in blocks if ">>>" not in block)
    package = tmp_path / "pvlib_fem"
    leave = shutil.ignore_patterns("__pycache__")
    shutil.copytree(Path(pvlib_fem.__file__).parent, package, ignore=leave)
    (package / "effects" / "catalogue" / "water.py").write_text(file, encoding="utf-8")
    registry = package / "effects" / "__init__.py"
    text = registry.read_text(encoding="utf-8")
    text = text.replace("\n__all__ =", f"\n{line}\n__all__ =", 1)
    text = text.replace("        season,\n", "        season,\n        water,\n")
    registry.write_text(text, encoding="utf-8")
    with (package / "drivers" / "_derived.py").open("a", encoding="utf-8") as drivers:
        drivers.write(f"\n\n{driver}\n\n{row}")
    script = (
        "import effects_page, pvlib_fem, numpy as np;"
        "from pvlib_fem.drivers import derive_drivers, needed_for;"
        "from pvlib_fem._record.inputs import read;"
        "assert needed_for(['water_excess']) == ['temp_water'];"
        "data = {'temp_water': np.array([9., 9.]), 'temp_air': np.array([5., 6.])};"
        "found = derive_drivers(read(data, step=60.0), ['water_excess']);"
        "assert (found['water_excess'] == [4, 3]).all();"
        "effects_page.write('.')"
    )
    paths = os.pathsep.join([str(tmp_path), str(DOCS / "_ext")])
    environment = {**os.environ, "PYTHONPATH": paths, "PYTHONUTF8": "1"}
    subprocess.run(
        [sys.executable, "-c", script], cwd=tmp_path, env=environment, check=True
    )
    assert "<effect-water>" in (tmp_path / "effects.rst").read_text(encoding="utf-8")
    said = (tmp_path / "effects" / "water.rst").read_text(encoding="utf-8")
    assert "exchange} \\cdot" in said and "``water.exchange``" in said
    assert "a module of the same kind on land" in said
    assert "doi:`10.1016/j.solener.2020.11.029`" in said
    drivers = (tmp_path / "effects" / "drivers.rst").read_text(encoding="utf-8")
    assert "Water temperature above that of the air" in drivers
