"""Every public signature says its types, and they can be read."""

import ast
import inspect
import sys
from functools import cache
from types import ModuleType
from typing import get_type_hints

import pytest

import pvlib_fem


def functions_of(name, thing):
    """A public function, or those of a public class that the package wrote."""
    if inspect.isclass(thing):
        for member, value in vars(thing).items():
            value = value.fget if isinstance(value, property) else value
            value = getattr(value, "__func__", getattr(value, "func", value))
            written = (
                inspect.isfunction(value) and "<" not in value.__code__.co_filename
            )
            if written and (member == "__init__" or not member.startswith("_")):
                yield f"{name}.{member}", value
    elif inspect.isfunction(thing):
        yield name, thing


def public():
    for name in pvlib_fem.__all__:
        thing = getattr(pvlib_fem, name)
        names = getattr(thing, "__all__", ()) if isinstance(thing, ModuleType) else ()
        for inner in names:
            yield from functions_of(f"{name}.{inner}", getattr(thing, inner))
        yield from functions_of(name, thing)


PUBLIC = dict(public())


@cache
def names_for_types(module):
    """What a module imports under ``if TYPE_CHECKING:``, by name."""
    names = {}
    for node in ast.parse(inspect.getsource(sys.modules[module])).body:
        if isinstance(node, ast.If) and getattr(node.test, "id", "") == "TYPE_CHECKING":
            exec(compile(ast.Module(node.body, []), module, "exec"), names)
    return names


def test_there_are_many():
    assert {"fit_fem", "FemFit.predict", "scores.rmse", "simulator.record"} <= {*PUBLIC}


@pytest.mark.parametrize("name", PUBLIC)
def test_a_public_signature_is_typed(name):
    function = PUBLIC[name]
    signature = inspect.signature(function)
    wanted = {p for p in signature.parameters if p not in ("self", "cls")} | {"return"}
    assert wanted == {
        *get_type_hints(function, localns=names_for_types(function.__module__))
    }
