"""Names of effects, verdicts, results and thresholds that have changed."""

import re
import sys
import warnings
from collections.abc import Callable, Mapping
from functools import wraps
from pathlib import Path
from typing import Any, TypeVar, cast

F = TypeVar("F", bound=Callable)
T = TypeVar("T", bound=type)

RENAMED = {
    "sensitivity": "irradiance_sensor",
    "contact": "module_sensor_contact",
    "wind_gain": "anemometer",
    "wind_stall": "anemometer_stall",
    "air_shelter": "air_sensor_shield",
}
OLD = re.compile(rf"(?<![a-z_])({'|'.join(RENAMED)})_(step|drift|episode)(?![a-z_])")
VERDICTS = {
    "named": "identified",
    "class": "ambiguous",
    "suggestive": "hint",
    "unknown": "unexplained",
}
OLD_VERDICT = re.compile(rf'("verdict": *")({"|".join(VERDICTS)})"')
PACKAGE = str(Path(__file__).parent)


def in_new_names(text: str) -> str:
    """
    A text with the present names of sensor faults.

    Parameters
    ----------
    text : str
        A name of an effect or coefficient, or a text with such names.

    Returns
    -------
    str

    Warns
    -----
    FutureWarning
        If it has an old name, one for each.
    """
    found = {old[0]: f"{RENAMED[old[1]]}_{old[2]}" for old in OLD.finditer(text)}
    for old, new in found.items():
        warn_of_new_name(f"the effect {old}", new)
    return OLD.sub(lambda old: found[old[0]], text)


def file_in_new_names(text: str) -> str:
    """
    The text of a result's file with the present names and verdicts.

    Parameters
    ----------
    text : str
        JSON.

    Returns
    -------
    str

    Warns
    -----
    FutureWarning
        If it has an old name of a sensor fault; an old verdict is replaced without.
    """
    text = OLD_VERDICT.sub(lambda old: f'{old[1]}{VERDICTS[old[2]]}"', text)
    return in_new_names(text)


def keys_in_new_names(named: Mapping[str, Any]) -> dict[str, Any]:
    """
    A dict by effect or coefficient, with the present names.

    Parameters
    ----------
    named : mapping of str
        Keys such as ``"irradiance_sensor_step"`` or ``"sensitivity_step.change"``.

    Returns
    -------
    dict

    Warns
    -----
    FutureWarning
        If it has an old name.
    """
    return {in_new_names(name): value for name, value in named.items()}


def arguments_in_new_names(renamed: Mapping[str, str]) -> Callable[[F], F]:
    """
    Make a decorator of a function whose keyword arguments have new names.

    Parameters
    ----------
    renamed : mapping of str
        The present name of each former argument, which works and warns.

    Returns
    -------
    callable
        Decorator.
    """

    def decorator(function: F) -> F:
        @wraps(function)
        def with_new_names(*args: Any, **kwargs: Any) -> Any:
            for old in renamed.keys() & kwargs.keys():
                new = renamed[old]
                if new in kwargs:
                    raise TypeError(f"{old} is called {new} now; give one of them")
                warn_of_new_name(f"the argument {old}", new)
                kwargs[new] = kwargs.pop(old)
            return function(*args, **kwargs)

        return cast(F, with_new_names)

    return decorator


def fields_in_new_names(renamed: Mapping[str, str]) -> Callable[[T], T]:
    """
    Make a decorator of a dataclass whose fields have new names.

    Parameters
    ----------
    renamed : mapping of str
        The present name of each former field, which can be given, and read from objects
        and files, with a warning.

    Returns
    -------
    callable
        Decorator.
    """

    def decorator(kind: T) -> T:
        def former(self: Any, name: str) -> Any:
            if name not in renamed:
                words = f"{kind.__name__!r} object has no attribute {name!r}"
                raise AttributeError(words)
            warn_of_new_name(f"{kind.__name__}.{name}", renamed[name])
            return getattr(self, renamed[name])

        changed: Any = kind
        changed.__init__ = arguments_in_new_names(renamed)(changed.__init__)
        changed.__getattr__ = former  # of names that are no fields
        changed.renamed_in_file = dict(renamed)
        return kind

    return decorator


def warn_of_new_name(old: str, new: str) -> None:
    """
    Warn that an effect, or an attribute of a result or its key in a file, is renamed.

    Parameters
    ----------
    old, new : str
        The old name with its class, such as ``"Finding.witnesses"``; the new one
        without.

    Warns
    -----
    FutureWarning
    """
    warnings.warn(
        f"{old} is called {new} now, and 0.2 will not know the old name: write {new}",
        FutureWarning,
        stacklevel=of_the_caller(),
    )


def of_the_caller() -> int:
    """Frames up to the first outside the package, as ``stacklevel`` counts them."""
    level, frame = 1, sys._getframe(1)
    while frame.f_back and frame.f_code.co_filename.startswith(PACKAGE):
        level, frame = level + 1, frame.f_back
    return level
