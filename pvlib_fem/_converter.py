"""Between results and JSON: the fields of a result are its format."""

import json
import math
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import fields, is_dataclass
from enum import Enum, StrEnum
from functools import cache
from itertools import repeat
from typing import Annotated, Any, get_args, get_origin

import numpy as np
import pandas as pd

from pvlib_fem._former_names import warn_of_new_name

#: a number that may be NaN or infinite; a float is finite
AnyFloat = Annotated[float, "may be NaN or infinite"]
WHOLE = 2**63
MOST = sys.float_info.max  # a whole number of JSON can be larger


class WrongValue(Exception):
    """A value in a file that is not of the type of the result."""

    def __init__(self, value: Any, words: str) -> None:
        super().__init__(f"is {json.dumps(value)[:60]}, where {words} belongs")


def checked(value: Any, words: str, *types: type) -> Any:
    """A value of some types; True is an int of Python, and no number."""
    if type(value) not in types:
        raise WrongValue(value, words)
    return value


def write_number(value: Any) -> Any:
    value = value.item() if isinstance(value, np.generic) else value
    if isinstance(value, float) and not math.isfinite(value):
        return None if math.isnan(value) else str(value)
    return value


def read_float(value: Any, _: Any) -> float:
    if abs(checked(value, "a number", int, float)) > MOST:
        raise WrongValue(value, "a number of double precision")
    # numpy has no number for a whole one of more than 64 bits
    return value if abs(value) < WHOLE else float(value)


def read_time(value: Any, _: Any) -> pd.Timestamp:
    found = pd.Timestamp(checked(value, "a time", str))
    if pd.isna(found):
        raise WrongValue(value, "a time")
    return found


def read_any_float(value: Any, _: Any) -> float:
    if value is None or value in ("inf", "-inf"):
        return math.nan if value is None else float(value)
    return read_float(value, _)


def read_count(value: Any, _: Any) -> int:
    if checked(value, "a whole number", int) < 0:
        raise WrongValue(value, "a count")
    return value


def write_member(member: Enum) -> str:
    """The value if it is a text, else the name."""
    return member.value if isinstance(member, str) else member.name


def read_member(value: Any, kind: Any) -> Any:
    members = {write_member(member): member for member in kind}
    words = f"one of {', '.join(members)}"
    if checked(value, words, str) not in members:
        raise WrongValue(value, words)
    return members[value]


@cache
def converter() -> Any:
    """
    The converter between results and JSON; cattrs is imported only here.

    Fields and annotations of a dataclass are its format, of which a file has null for
    NaN, "inf" for infinity, a list for a tuple and a text for a time. If a class has
    ``in_file``, these fields alone are in a file. Properties in ``also_in_file`` are
    written and not read. ``renamed_in_file`` has former names of fields, which are read
    with a warning. A class with methods ``content`` and ``stored`` is converted by
    these.

    Returns
    -------
    cattrs.Converter
        One for the process. ``structure`` raises what :func:`error_in_words` reads.
    """
    from cattrs import Converter, IterableValidationError, IterableValidationNote
    from cattrs.gen import make_dict_structure_fn, override

    made = Converter()
    write, read = made.unstructure, made.structure

    def write_object(result: Any) -> dict:
        names = (*names_in_file(result), *getattr(result, "also_in_file", ()))
        return {name: write(getattr(result, name)) for name in names}

    def object_reader(kind: Any) -> Any:
        names = names_in_file(kind)
        omitted = {one.name for one in fields(kind)} - {*names}
        how: Any = {name: override(omit=True) for name in omitted}
        read_fields = make_dict_structure_fn(kind, made, **how)

        def read_object(value: Any, kind: Any) -> Any:
            value = in_new_keys(checked(value, "an object", dict), kind)
            for name in names:  # those with a default, too
                if name not in value:
                    raise KeyError(name)
            return read_fields(value, kind)

        return read_object

    def read_each(values: Iterable, kinds: Iterable) -> Iterator:
        for (key, value), kind in zip(values, kinds):
            try:
                yield read(value, kind)
            except Exception as error:
                error.add_note(IterableValidationNote("", key, kind))
                raise IterableValidationError("", [error], kind) from error

    def read_list(value: Any, kind: Any) -> Any:
        kinds = get_args(kind)
        if get_origin(kind) is list or ... in kinds:
            kinds = kinds[:1] * len(checked(value, "a list", list))
        elif len(checked(value, "a list", list)) != len(kinds):
            raise WrongValue(value, f"a list of {len(kinds)}")
        return get_origin(kind)(read_each(enumerate(value), kinds))

    def read_dict(value: Any, kind: Any) -> dict:
        checked(value, "an object", dict)
        _, inner = get_args(kind) or (str, Any)
        return dict(zip(value, read_each(value.items(), repeat(inner))))

    write_as = made.register_unstructure_hook_func
    write_as(is_a(float, np.generic), write_number)
    write_as(is_a(list, tuple), lambda values: [write(one) for one in values])
    write_as(is_a(Mapping), lambda d: {str(key): write(one) for key, one in d.items()})
    write_as(is_a(pd.Timestamp), pd.Timestamp.isoformat)
    write_as(is_dataclass, write_object)
    write_as(by_hand, lambda result: write(result.content()))

    made.register_structure_hook(str, lambda v, _: checked(v, "a text", str))
    made.register_structure_hook(bool, lambda v, _: checked(v, "true or false", bool))
    made.register_structure_hook(int, read_count)
    made.register_structure_hook(float, read_float)
    made.register_structure_hook(pd.Timestamp, read_time)
    for kind in (Enum, StrEnum):  # the latter is a str, too
        made.register_unstructure_hook(kind, write_member)
        made.register_structure_hook(kind, read_member)
    read_as = made.register_structure_hook_func
    read_as(lambda kind: kind == AnyFloat, read_any_float)
    read_as(lambda kind: get_origin(kind) in (list, tuple), read_list)
    read_as(lambda kind: dict in (kind, get_origin(kind)), read_dict)
    made.register_structure_hook_factory(is_dataclass, object_reader)
    read_as(by_hand, lambda value, kind: kind.stored(value))
    return made


def names_in_file(kind: Any) -> Iterable[str]:
    """The fields of a class, or of an object, that a file has."""
    return getattr(kind, "in_file", [one.name for one in fields(kind)])


def in_new_keys(value: dict[str, Any], kind: Any) -> dict[str, Any]:
    """An object of a file with the present names of the fields of a class."""
    renamed = getattr(kind, "renamed_in_file", {})
    for old in (name for name in renamed if name in value):
        warn_of_new_name(f"{kind.__name__}.{old}", renamed[old])
    return {renamed.get(key, key): part for key, part in value.items()}


def is_a(*kinds: type) -> Callable[[Any], bool]:
    """Whether a type is a subclass of one of some."""
    return lambda kind: isinstance(kind, type) and issubclass(kind, kinds)


def by_hand(kind: Any) -> bool:
    """Whether a class converts itself."""
    return hasattr(kind, "content") and hasattr(kind, "stored")


def error_in_words(error: Any, file: str, place: str) -> str:
    """
    The first error of the converter, with its place in the file.

    Parameters
    ----------
    error : Exception
        Raised by ``converter().structure``; of a group, the first error is taken.
    file : str
    place : str
        Keys above the value that was read, each with a point behind it; "" at the top.

    Returns
    -------
    str
    """
    while isinstance(error, ExceptionGroup):
        error = error.exceptions[0]
        if not (notes := getattr(error, "__notes__", [])):  # of the whole object
            continue
        note = notes[-1]  # of cattrs: a field, or a key
        place += f"{getattr(note, 'name', None) or note.index}."
    if isinstance(error, KeyError):
        return f"{file} has no {place.removesuffix(f'{error.args[0]}.')}{error.args[0]}"
    if isinstance(error, WrongValue):
        return f"{file}: {place[:-1]} {error}"
    return (
        f"{file}: {place[:-1]} is what no to_json wrote: {type(error).__name__}, "
        f"{error}"
    )
