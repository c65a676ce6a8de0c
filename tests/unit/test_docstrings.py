"""What other modules call describes its parameters and its result."""

import ast
import importlib
import inspect

import click
import pytest
from numpydoc.docscrape import get_doc_object
from numpydoc.validate import validate
from test_architecture import FILES, ORDER, imports, package_of

import pvlib_fem

#: numpydoc's codes for no docstring, parameters that are not described, described
#: parameters that the signature does not have, and results that are not described
CODES = {"GL08", "PR01", "PR02", "RT01", "YD01"}
TREES = {name: ast.parse(path.read_text("utf-8")) for name, path in FILES.items()}
DEFINED = {
    f"{name}.{node.name}"
    for name, tree in TREES.items()
    for node in tree.body
    if isinstance(node, ast.FunctionDef)
}


def called(name):
    """What a module imports of others, alone or with the module that it is in."""
    attributes = [n.attr for n in ast.walk(TREES[name]) if isinstance(n, ast.Attribute)]
    for _, whole in imports(name):
        inner = whole.removeprefix("pvlib_fem.")
        yield inner
        if inner in FILES:
            yield from (f"{inner}.{attribute}" for attribute in attributes)


def public():
    """Names by which the package gives its functions to users."""
    for name in pvlib_fem.__all__:
        one = getattr(pvlib_fem, name)
        if inspect.isfunction(one):
            yield f"{one.__module__}.{one.__name__}".removeprefix("pvlib_fem.")


def errors(name):
    """What numpydoc says of the docstring of a function."""
    module, function = name.rsplit(".", 1)
    found = inspect.unwrap(getattr(importlib.import_module(module), function))
    if isinstance(found, click.Command):  # its docstring is its help
        return {}
    assert inspect.isfunction(found)
    return {
        code: words
        for code, words in validate(get_doc_object(found))["errors"]
        if code in CODES
    }


SHARED = DEFINED & {*public(), *(one for name in FILES for one in called(name))}


@pytest.mark.parametrize("package", ORDER)
def test_functions_that_other_modules_call_describe_parameters_and_result(package):
    names = sorted(name for name in SHARED if package_of(name) == package)
    found = {name: errors(f"pvlib_fem.{name}") for name in names}
    assert {name: wrong for name, wrong in found.items() if wrong} == {}


def scaled(values, factor):
    """
    Values times a factor.

    Parameters
    ----------
    values, offset : float
    """
    return values * factor


def nothing(values):
    return values


def each(values):
    """
    Values one by one.

    Parameters
    ----------
    values : list
    """
    yield from values


def test_what_is_not_described_is_found():
    assert {*errors(f"{__name__}.scaled")} == {"PR01", "PR02", "RT01"}
    assert "factor" in errors(f"{__name__}.scaled")["PR01"]
    assert "offset" in errors(f"{__name__}.scaled")["PR02"]
    assert {*errors(f"{__name__}.each")} == {"YD01"}
    assert {*errors(f"{__name__}.nothing")} == {"GL08"}
