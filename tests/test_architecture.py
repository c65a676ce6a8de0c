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
        "simulator",
    },
    1: {"dailysums", "relaxation", "laws", "scores", "clock", "doubts", "coarse"},
    2: {"temperature", "translate", "paper", "drivers"},
    3: {"effects", "model", "plotting", "datasets", "noon"},
    4: {"modelchain", "evidence", "recipe", "health"},
    5: {"result", "diagnosis", "report"},
    6: {"fitting", "prepared", "findings"},
    7: {"steps"},
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
    for module, name in imports(path):
        if module.split(".")[0] == "pvlib_fem" and name != "pvlib_fem.__version__":
            yield (name if module == "pvlib_fem" else module).removeprefix("pvlib_fem.")


@pytest.mark.parametrize("path", FILES, ids=lambda p: str(p.relative_to(PACKAGE)))
def test_imports_go_down_only(path):
    is_registry = path.name == "__init__.py"
    # an effect stands on the floors below its registry's, beside no other
    floor = FLOOR[path.stem if path.parent == PACKAGE else "effects"]
    for name in own_imports(path):
        if is_registry and name.startswith("effects."):
            continue
        assert FLOOR[name.split(".")[0]] < floor, f"{path.name} imports {name}"


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
        for module, _ in imports(path):
            assert places.get(module.split(".")[0], path.stem) == path.stem
