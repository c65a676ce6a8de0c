"""Imports go down only; outside libraries stay where they belong."""

import ast
from pathlib import Path

import pytest

import pvlib_fem

PACKAGE = Path(pvlib_fem.__file__).parent
FLOORS = {
    0: {
        "records",
        "effect",
        "leastsquares",
        "layers",
        "structure",
        "onset",
        "files",
        "document",
        "simulator",
    },
    1: {"dailysums", "relaxation", "laws", "scores", "clock", "doubts", "coarse"},
    2: {"temperature", "translate", "paper", "drivers", "plotting.look"},
    3: {"effects", "model", "plotting", "datasets", "noon"},
    4: {"modelchain", "evidence", "recipe", "health", "advice"},
    5: {"result", "diagnosis", "pictures"},
    6: {"fitting", "prepared", "report"},
    7: {"steps", "findings"},
    8: {"loop"},
    9: {"cli"},
}
FLOOR = {name: floor for floor, names in FLOORS.items() for name in names}
FILES = [
    path
    for path in PACKAGE.rglob("*.py")
    # the simulator imports nothing of the models, which its own test holds
    if path != PACKAGE / "__init__.py" and path.parent.name != "simulator"
]


def imports(path):
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from ((alias.name, alias.name) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            yield from ((node.module, f"{node.module}.{a.name}") for a in node.names)


def own_imports(path):
    """Names below ``pvlib_fem`` that a file imports."""
    for source, name in imports(path):
        if source.split(".")[0] == "pvlib_fem" and name != "pvlib_fem.__version__":
            yield (name if source == "pvlib_fem" else source).removeprefix("pvlib_fem.")


def module(path):
    """Name of a file below ``pvlib_fem``, of a package that of its folder."""
    parts = path.relative_to(PACKAGE).with_suffix("").parts
    return ".".join(part for part in parts if part != "__init__")


def floor_of(name):
    """Floor of a module: its own, or that of the package that it is in."""
    package, *inside = name.split(".")
    return FLOOR.get(".".join([package, *inside[:1]]), FLOOR[package])


@pytest.mark.parametrize("path", FILES, ids=lambda p: str(p.relative_to(PACKAGE)))
def test_imports_go_down_only(path):
    # inside a package no file stands on another, such as an effect on an effect;
    # what all of them need has a floor of its own
    own = module(path)
    for name in own_imports(path):
        if path.name == "__init__.py" and name.startswith(f"{own}."):
            continue
        assert floor_of(name) < floor_of(own), f"{own} imports {name}"


def test_every_effect_has_its_line_in_the_registry():
    files = {path.stem for path in (PACKAGE / "effects").glob("*.py")} - {"__init__"}
    assert files == set(pvlib_fem.effects.EFFECTS)


def test_matplotlib_click_and_pooch_have_one_place_each():
    places = {
        "matplotlib": "plotting",
        "click": "cli",
        "tqdm": "cli",
        "threadpoolctl": "loop",
        "pooch": "datasets",
    }
    for path in FILES:
        own = module(path).split(".")[0]
        for outside, _ in imports(path):
            assert places.get(outside.split(".")[0], own) == own
