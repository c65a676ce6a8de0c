"""What the texts of options mean."""

import json
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import click
import pandas as pd

from pvlib_fem._record.column_names import ROTATION, in_new_names
from pvlib_fem._record.header_units import QUANTITIES, unit_of, usual_name_of
from pvlib_fem._record.layout import Layout
from pvlib_fem._spelling import did_you_mean
from pvlib_fem.drivers._mounts import ANGLES, TRACKER as TRACKED
from pvlib_fem.effects import find

#: fields of a layout that are given once for all files or once for each
PER_FILE = {
    "time": (),
    "time_format": Layout.time_format,
    "tag": Layout.tag,
    "value": Layout.value,
    "tz": None,
    "sep": Layout.sep,
    "decimal": Layout.decimal,
    "thousands": Layout.thousands,
    "encoding": Layout.encoding,
    "skip_rows": 0,
    "skip_lines": (),
    "header_rows": Layout.header_rows,
    "skip_end": Layout.skip_end,
    "sheet": 0,
}

#: fields of a layout that are the same for all files
SAME = ("missing", "keep", "sort", "drop_doubled", "drop_untimed")


def bad_option(text: str, option: str, why: str) -> click.BadParameter:
    return click.BadParameter(f"{text!r} {why}", param_hint=option)


def named_values(texts: Iterable[str], option: str, form: str) -> dict[str, str]:
    """Texts of the form NAME=VALUE, each name once."""
    values = {}
    for text in texts:
        name, equals, value = text.partition("=")
        if not equals or not value:
            raise bad_option(text, option, f"is not {form}")
        if name in values:
            raise bad_option(
                text, option, f"comes after {name}={values[name]}; give one"
            )
        values[name] = value
    return values


#: names that columns of a file may have
NAMED = (*QUANTITIES, *ANGLES, ROTATION)
#: options of a place, and among them those of a tracker
TRACKER = (*TRACKED, "backtrack")
PLACE = ("lat", "lon", "tilt", "azimuth", *TRACKER)


def columns_of(renames: Iterable[str]) -> dict[str, str]:
    """
    The map of --map, from the package's names to those of the file.

    Parameters
    ----------
    renames : iterable of str
        Texts ``NAME=COLUMN``; an older name of the package is replaced by the present
        one.

    Returns
    -------
    dict of str

    Raises
    ------
    click.BadParameter
        If a text has another form, a name is unknown or of the times, or a name or
        column is given twice.
    """
    mapped = in_new_names(named_values(renames, "--map", "NAME=COLUMN"))
    for name, column in mapped.items():
        if column == "COLUMN":
            why = "stands for the name of a column of the file: put that"
            raise bad_option(f"{name}=COLUMN", "--map", why)
        if name == "time":
            why = f"are the times: give --time {column!r}"
            raise bad_option(f"time={column}", "--map", why)
        if name not in NAMED and usual_name_of(name) is None:
            why = (
                f"is none of {', '.join(NAMED)}"
                f"{did_you_mean(name, NAMED)}, nor a cross-check of an "
                "instrument: power_ac, power_dc, poa_global_2, temp_module_2 …"
            )
            raise bad_option(name, "--map", why)
    if twice := [c for c in mapped.values() if list(mapped.values()).count(c) > 1]:
        names = [name for name, column in mapped.items() if column == twice[0]]
        raise bad_option(
            twice[0], "--map", f"is given as {' and as '.join(names)}; give one"
        )
    return mapped


def units_of(texts: Iterable[str]) -> dict[str, str]:
    """
    The units of --unit by the package's names.

    Parameters
    ----------
    texts : iterable of str
        Texts ``NAME=UNIT``.

    Returns
    -------
    dict of str
        Units as the package spells them.

    Raises
    ------
    click.BadParameter
        If a text has another form, or the column has no such unit.
    """
    units = in_new_names(named_values(texts, "--unit", "NAME=UNIT"))
    try:
        return {name: unit_of(name, unit) for name, unit in units.items()}
    except ValueError as error:
        raise click.BadParameter(str(error), param_hint="--unit") from error


def fixed_coefficients(texts: Iterable[str]) -> dict[str, float]:
    """
    The coefficients of --fix.

    Parameters
    ----------
    texts : iterable of str
        Texts ``NAME=NUMBER``.

    Returns
    -------
    dict of float
        By the name of the coefficient, in its own unit.

    Raises
    ------
    click.BadParameter
        If a text has another form.
    """
    numbers = {}
    for name, value in named_values(texts, "--fix", "NAME=NUMBER").items():
        try:
            numbers[name] = float(value)
        except ValueError as error:
            raise bad_option(value, "--fix", f"is no number for {name}") from error
    return numbers


def settings_of(texts: Iterable[str]) -> dict[str, dict[str, Any]]:
    """
    The settings of --effect-setting by the names of the effects.

    Parameters
    ----------
    texts : iterable of str
        Texts ``NAME.SETTING=VALUE``; a value that is no JSON is a word.

    Returns
    -------
    dict of dict
        By the name of the effect and that of the setting.

    Raises
    ------
    click.BadParameter
        If a text has another form.
    """
    form, settings = "NAME.SETTING=VALUE", {}
    for key, text in named_values(texts, "--effect-setting", form).items():
        name, dot, setting = key.partition(".")
        if not dot or not setting:
            raise bad_option(f"{key}={text}", "--effect-setting", f"is not {form}")
        try:
            value = json.loads(text)
        except ValueError:  # a word, such as a source
            value = text
        settings.setdefault(name, {})[setting] = value
    return settings


def layouts_of(options: Mapping[str, Any], files: Sequence[Path]) -> list[Layout]:
    """
    How each file is written.

    Parameters
    ----------
    options : dict
        Options of reading: of ``PER_FILE`` a sequence, of ``SAME`` one value.
    files : sequence of Path
        Files to read.

    Returns
    -------
    list of Layout
        One for each file.

    Raises
    ------
    click.BadParameter
        If an option is given neither once nor once for each file, or is no number of
        lines or no decimal sign.
    """
    values = {}
    for name, default in PER_FILE.items():
        given = options[name]
        option = f"--{name.replace('_', '-')}"
        if len(given) not in (0, 1, len(files)):
            raise click.BadParameter(
                f"it is given {len(given)} times for {len(files)} file"
                f"{'s' * (len(files) > 1)}",
                param_hint=option,
            )
        values[name] = list(given) or [default]
        values[name] *= len(files) if len(values[name]) == 1 else 1
    values["time"] = [tuple(t.split(",")) if t else () for t in values["time"]]
    values["skip_rows"] = skipped_lines(options, values.pop("skip_lines"), values)
    values["sep"] = ["\t" if sep == r"\t" else sep for sep in values["sep"]]
    if wrong := [text for text in values["decimal"] if len(text) != 1]:
        raise bad_option(wrong[0], "--decimal", "is not one sign")
    same = {name: options[name] for name in SAME}
    return [
        Layout(**{name: values[name][i] for name in values}, **same)
        for i in range(len(files))
    ]


def skipped_lines(
    options: Mapping[str, Any], lines: Sequence[str], values: Mapping[str, list[Any]]
) -> list[int | tuple[int, ...]]:
    """The lines before the header of each file, or those that are left out."""
    if not options["skip_lines"]:
        return [lines_of(text, "--skip-rows") for text in values["skip_rows"]]
    if options["skip_rows"]:
        raise click.BadParameter(
            "--skip-lines is given, too; give one of them, where --skip-lines 0,1 is "
            "the same as --skip-rows 2",
            param_hint="--skip-rows",
        )
    return [lines_of(f"{text},", "--skip-lines") if text else 0 for text in lines]


def lines_of(text: str, option: str) -> int | tuple[int, ...]:
    """A number of lines; with a comma the numbers of lines, as ``3,`` the fourth."""
    if not text:
        return 0
    try:
        numbers = tuple(int(number) for number in text.rstrip(",").split(","))
    except ValueError as error:
        raise bad_option(text.rstrip(","), option, "are no line numbers") from error
    if min(numbers) < 0:
        raise bad_option(text.rstrip(","), option, "are no line numbers")
    return numbers if "," in text else numbers[0]


def days_of(texts: Sequence[str], index: pd.DatetimeIndex) -> pd.Series | None:
    """
    The rows of --holdout, or None without it.

    Parameters
    ----------
    texts : sequence of str
        Texts ``DAY`` or ``DAY..DAY``; the last day is included.
    index : DatetimeIndex
        Times of the record; days are those of its zone.

    Returns
    -------
    Series of bool or None
        True on these days, with the index of the record.

    Raises
    ------
    click.BadParameter
        If a text is no day.
    ValueError
        If the record has no such day.
    """
    if not texts:
        return None
    local = index.tz_localize(None).normalize()
    out = pd.Series(False, index)
    for text in texts:
        first, dots, last = text.partition("..")
        try:
            start, end = pd.Timestamp(first), pd.Timestamp(last if dots else first)
        except ValueError as error:
            raise bad_option(text, "--holdout", "is not DAY or DAY..DAY") from error
        rows = (local >= start) & (local <= end)
        if not rows.any():
            raise ValueError(
                f"--holdout {text}: the record has no such day; it is from "
                f"{index[0]:%Y-%m-%d} to {index[-1]:%Y-%m-%d}"
            )
        out |= rows
    return out


def effects_of(
    texts: Iterable[str], settings: Mapping[str, Mapping[str, Any]]
) -> list[str | dict[str, Any]]:
    """
    The effects of --effects from the catalogue, with their settings.

    Parameters
    ----------
    texts : iterable of str
        Names of effects, separated by commas.
    settings : dict of dict
        Settings by the names of their effects, see :func:`settings_of`.

    Returns
    -------
    list of str or dict
        Specification of each effect, see :func:`pvlib_fem.effects.find`.

    Raises
    ------
    ValueError
        If an effect is unknown or given twice, or settings are of an effect that is not
        given.
    """
    names = [name.strip() for text in texts for name in text.split(",")]
    for name in names:
        find(name)
    if twice := [name for name in names if names.count(name) > 1]:
        raise ValueError(f"--effects has {twice[0]} twice")
    if strange := [name for name in settings if name not in names]:
        raise ValueError(
            f"--effect-setting is given for {strange[0]}, which is not among --effects"
            f"{did_you_mean(strange[0], names)}"
        )
    chosen = [{"name": name, **settings.get(name, {})} for name in names]
    return [find(one).spec for one in chosen]
