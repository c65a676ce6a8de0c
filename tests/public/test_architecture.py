"""Imports go down only; outside libraries stay where they belong."""

import ast
import re
import subprocess
import sys
from functools import cache
from pathlib import Path

import pytest

import pvlib_fem

PACKAGE = Path(pvlib_fem.__file__).parent
#: each may import those before it
ORDER = (
    "types",
    "_spelling",
    "_former_names",
    "_parallel",
    "simulator",
    "layers",
    "reasons",
    "_converter",
    "_stored",
    "_record",
    "_relaxation",
    "_statistics",
    "scores",
    "power",
    "drivers",
    "effects",
    "quality",
    "_thermal",
    "_translation",
    "datasets",
    "_modelchain",
    "plotting",
    "_findings",
    "_budget",
    "_report",
    "_thermal_parameters",
    "_fitting",
    "_correction",
    "_ceiling",
    "_statements",
    *(
        f"_loop.{name}"
        for name in (
            "criteria",
            "progress",
            "threads",
            "preparation",
            "regression",
            "selection",
            "references",
            "ranking",
            "results",
            "search",
            "assemble",
            "close",
        )
    ),
    "paper",
    "_fit",
    "_sensors",
    "detect",
    "_recovery",
    "fleet",
    "_cli",
    "__main__",
)
MOST = 5  # imports of each other, one under the other, inside a package
FILES = {
    ".".join(
        part
        for part in path.relative_to(PACKAGE).with_suffix("").parts
        if part != "__init__"
    ): path
    for path in PACKAGE.rglob("*.py")
    if path != PACKAGE / "__init__.py"
}


def is_of_types(node):
    """Whether a node is ``if TYPE_CHECKING:``, which does not run."""
    return isinstance(node, ast.If) and getattr(node.test, "id", "") == "TYPE_CHECKING"


def nodes(tree):
    """All nodes but those that only a type checker reads."""
    for node in ast.iter_child_nodes(tree):
        if not is_of_types(node):
            yield node
            yield from nodes(node)


@cache
def imports(name, types=False):
    """What a module imports, perhaps for types alone: the module, the name in it."""
    found = []
    tree = ast.parse(FILES[name].read_text(encoding="utf-8"))
    for node in ast.walk(tree) if types else nodes(tree):
        if isinstance(node, ast.Import):
            found += [(alias.name, alias.name) for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            found += [(node.module, f"{node.module}.{a.name}") for a in node.names]
    return found


def own_imports(name, types=False):
    """Modules of the package that a module imports, perhaps for types alone."""
    for source, whole in imports(name, types):
        if source.split(".")[0] == "pvlib_fem" and whole != "pvlib_fem.__version__":
            inner = whole.removeprefix("pvlib_fem.")
            yield inner if inner in FILES else source.removeprefix("pvlib_fem.")


def package_of(name):
    """The package, or the module at the top, that a module is in; rooms of the loop."""
    return ".".join(name.split(".")[: 2 if name.startswith("_loop.") else 1])


def top_of(name):
    """The first part of a name."""
    return name.split(".")[0]


@cache
def depth(name):
    """Longest way down from a module inside its own package."""
    below = [
        n for n in own_imports(name) if package_of(n) == package_of(name) and n != name
    ]
    return 1 + max(map(depth, below), default=0)


def test_the_order_is_of_all_that_there_is():
    assert sorted(ORDER) == sorted({package_of(name) for name in FILES} - {"_loop"})


@pytest.mark.parametrize("name", FILES)
def test_imports_go_down_only(name):
    for other in own_imports(name):
        if package_of(other) != package_of(name):
            assert ORDER.index(package_of(other)) < ORDER.index(package_of(name)), other


@pytest.mark.parametrize("name", [name for name in FILES if top_of(name) == "_loop"])
def test_parts_of_the_loop_do_not_know_types_from_above(name):
    for other in own_imports(name, types=True):
        if top_of(other) == "_loop":
            part = package_of(other)
            assert ORDER.index(part) <= ORDER.index(package_of(name)), other


@pytest.mark.parametrize("name", ORDER)
def test_imports_inside_a_package_are_not_deep(name):
    # a circle of imports would end in a RecursionError
    assert max(depth(n) for n in FILES if package_of(n) == name) <= MOST


def test_effects_do_not_stand_on_each_other():
    catalogue = [n for n in FILES if n.startswith("effects.catalogue.")]
    for name in catalogue:
        assert not set(own_imports(name)) & {*catalogue}, name
    assert {n.split(".")[-1] for n in catalogue} == set(pvlib_fem.effects.PHYSICS)


def test_the_simulator_and_the_models_share_nothing():
    assert all(
        package_of(other) != "simulator" or package_of(name) in ("simulator", "_cli")
        for name in FILES
        for other in own_imports(name)
    )


def test_the_paper_is_asked_by_the_choice_of_a_method_alone():
    asks = {
        name
        for name in FILES
        for other in own_imports(name)
        if package_of(other) == "paper" != package_of(name)
    }
    assert asks == {"_fit"}


def test_outside_libraries_have_one_place_each():
    places = {
        "matplotlib": "plotting",
        "cattrs": "_converter",
        "jinja2": "_report",
        "markupsafe": "_report",
        "click": "_cli",
        "tqdm": "_loop",
        "threadpoolctl": "_loop",
        "joblib": "_parallel",
        "sklearn": "_ceiling",
        "pooch": "datasets",
        "distributed": "fleet",
        "dask": "fleet",
        "fsspec": "fleet",
        "numba": "_thermal",
    }
    for name in FILES:
        for outside, _ in imports(name):
            assert places.get(outside.split(".")[0], top_of(name)) == top_of(name)


DESIGN = Path(__file__).parents[2] / "docs" / "design.md"


def test_packages_stand_in_the_order_of_their_imports():
    table = DESIGN.read_text("utf-8").split("| package | content |\n")[1]
    rows = table.split("\n\n")[0].splitlines()[1:]
    cells = [re.findall(r"`(\S+?)`", row.split("|")[1]) for row in rows]
    packages = [name.rstrip("/") for cell in cells for name in cell]
    tops = dict.fromkeys(top_of(name) for name in ORDER if name != "__main__")
    assert packages == [*tops]


def test_parts_of_the_loop_stand_in_the_order_of_their_imports():
    page = DESIGN.read_text("utf-8").split("### The loop")[1].split("## How")[0]
    names = re.findall(r"`(\w+(?:\.py|/))`", page)
    parts = [
        f"{name.removeprefix('_loop.')}{'/' if (PACKAGE / path).is_dir() else '.py'}"
        for name in ORDER
        if name != (path := name.replace(".", "/"))
    ]
    assert [name for name in names if name in parts] == parts
    files = {path.name for path in (PACKAGE / "_loop").rglob("*.py")}
    assert {name for name in names if name.endswith(".py")} == files - {"__init__.py"}


def test_results_load_pages_and_pictures_when_they_are_asked_for():
    names = ["_fitting.fem_fit", "_loop.close", "_loop.results.loop_result"]
    names += ["_ceiling.ceiling_result", "_recovery.recovery_result"]
    words = "; ".join(f"import pvlib_fem.{name}" for name in names)
    words += "; import sys; print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", words], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    loaded = done.stdout.split()
    assert "pvlib_fem._loop.results.loop_result" in loaded
    pages = ("pvlib_fem.plotting", "pvlib_fem._report.document", "jinja2", "matplotlib")
    assert not [name for name in loaded if name.startswith(pages)]
    assert not [name for name in loaded if name.endswith("_page")]
