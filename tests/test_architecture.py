"""Imports go down only; outside libraries stay where they belong."""

import ast
from pathlib import Path

import pvlib_fem

PACKAGE = Path(pvlib_fem.__file__).parent
FLOORS = {
    0: {"records", "parameter", "leastsquares", "layers"},
    1: {"relaxation", "laws", "scores"},
    2: {"temperature", "translate", "paper"},
    3: {"model", "modelchain", "plotting", "datasets"},
    4: {"result"},
    5: {"fitting"},
    7: {"cli"},
}
FLOOR = {name: floor for floor, names in FLOORS.items() for name in names}


def imports(path):
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from ((alias.name, alias.name) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            yield from ((node.module, f"{node.module}.{a.name}") for a in node.names)


def test_imports_go_down_only():
    for path in PACKAGE.glob("*.py"):
        if path.stem == "__init__":
            continue
        for module, name in imports(path):
            if module.split(".")[0] == "pvlib_fem" and name != "pvlib_fem.__version__":
                below = (name if module == "pvlib_fem" else module).split(".")[1]
                assert FLOOR[below] < FLOOR[path.stem], f"{path.stem} imports {below}"


def test_matplotlib_click_and_pooch_have_one_place_each():
    places = {"matplotlib": "plotting", "click": "cli", "pooch": "datasets"}
    for path in PACKAGE.glob("*.py"):
        for module, _ in imports(path):
            assert places.get(module.split(".")[0], path.stem) == path.stem
