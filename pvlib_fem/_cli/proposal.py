"""The command that may read a file, and what refuses a frame that it read."""

import re
import shlex
import subprocess
import sys
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import click
import pandas as pd
from click.core import ParameterSource

from pvlib_fem._cli.option_texts import PER_FILE, PLACE, SAME, TRACKER
from pvlib_fem._fitting.stand_ins import SERVED
from pvlib_fem._record.column_names import (
    COLUMNS,
    ROTATION,
    numeric,
    of_several,
    twin_of,
    with_aliases,
)
from pvlib_fem._record.guess import Guess, guess
from pvlib_fem._record.header_units import QUANTITIES, ForeignUnit, named_unit
from pvlib_fem._record.inputs import Columns, as_record
from pvlib_fem._record.layout import Layout
from pvlib_fem._record.logger_files import frame
from pvlib_fem._sensors.compare_sensors import FEWEST
from pvlib_fem._sensors.sensor_errors import is_sensor
from pvlib_fem._spelling import refusal
from pvlib_fem.drivers._mounts import ANGLES
from pvlib_fem.quality._screen import screened
from pvlib_fem.quality._unit_checks import doubtful, unit_of_driver

COMMANDLINE = ParameterSource.COMMANDLINE
#: what loggers call horizontal irradiance
GHI = re.compile(
    r"(^|[\W_])ghi(\b|_|\d)|glob\w*[\s_.-]*horiz|horiz\w*[\s_.-]*(glob|irr|rad)",
    re.IGNORECASE,
)
LOOK = "this command may read it; look at it before you run it:"
#: options that a proposal says anew
ANEW = (*PER_FILE, *SAME, "renames", "convert", "units", "guess")


def check_columns(data: pd.DataFrame, needed: Iterable[str] = COLUMNS) -> None:
    """
    Refuse a frame without the columns that a command needs.

    Parameters
    ----------
    data : DataFrame
        Frame with the package's names.
    needed : iterable of str, optional
        Columns without which nothing can be done; by default irradiance, both
        temperatures and wind speed.

    Raises
    ------
    ValueError
        With the missing columns and the option that names them.
    """
    if absent := [name for name in needed if name not in data]:
        there = ", ".join(map(str, data.columns))
        raise refusal(
            f"no column {', '.join(absent)} among {there}; name it with --map "
            f"{absent[0]}=COLUMN{remedy_for(absent, data)}",
            *of_several(data.columns),
        )


def remedy_for(absent: Sequence[str], data: pd.DataFrame) -> str:
    """What a fit can do without columns."""
    given = options_given()
    others = [name for name in data if len(absent) == 1 and twin_of(name) in absent]
    if others and absent[0] in SERVED and "stand_ins" in given:
        return f", or give --stand-in {others[0]}"
    if absent == ["wind_speed"] and "model" in given:
        return ", or give --model ross if there is none"
    if absent == ["poa_global"] and "ghi" in data and "transposition" in given:
        return ", or make it of ghi: --transposition perez"
    return ""


def check_record(data: pd.DataFrame) -> None:
    """Refuse what a fit would, such as a unit that only the numbers show."""
    screened(as_record(*map(with_aliases(data, ()).get, COLUMNS)))
    for name in QUANTITIES:
        if name in data and (unit := unit_of_driver(name, data[name])):
            most = f"it is {data[name].max():.2g} at most"
            raise ForeignUnit(f"{name} is in {unit}", (name,), unit, most)


def proposal(
    files: Sequence[Path],
    layouts: list[Layout],
    columns: Mapping[str, str],
    how: Mapping[str, Any],
    place: float | None,
    needed: Iterable[str] = COLUMNS,
) -> tuple[str, str]:
    """
    What to look at, and the command that may read files.

    Parameters
    ----------
    files : sequence of Path
    layouts : list of Layout
        How each file is read, as far as it is given.
    columns : dict of str
        Columns of the files by the package's names, as far as they are given.
    how : dict
        ``convert``, ``units``, ``check_units`` and ``module_area`` of reading.
    place : float or None
        Longitude. [°]
    needed : iterable of str
        Columns without which nothing can be done.

    Returns
    -------
    (str, str)
        The proposal for a person, and its line with the command.

    Raises
    ------
    Exception
        Of any kind, where the files hold no table that can be read so.
    """
    several = click.get_current_context().info_name == "modules"
    guessed = guess(files, layouts, columns, how, place, check_record, several)
    absent = [name for name in needed if name not in guessed.there]
    level = of_the_sky(guessed) if "poa_global" in absent else []
    calm = "wind_speed" in absent and "model" in options_given()
    spared = ["poa_global"] * bool(level) + ["wind_speed"] * calm
    absent = [name for name in absent if name not in spared]
    calm = calm and not absent
    absent += lacking_sensors(guessed.there) if several else []
    if not absent:
        needed = [name for name in needed if name not in spared]
        check = {**how, "convert": how["convert"] or guessed.headers}
        check["units"] = {**how["units"], **guessed.units}
        if guessed.area and not how["module_area"]:
            check["module_area"] = 1.0
        data = frame(files, guessed.layouts, guessed.columns, **check)
        check_columns(data, needed)
        arrays = {n: column.to_numpy() for n, column in numeric(data).items()}
        doubts = doubtful(Columns(arrays))
        guessed.doubts += [f"{name} {reason}" for name, reason in doubts.items()]
    line = command(guessed, absent, how, ["--model", "ross"] * calm, level)
    lines = [LOOK, "", f"  {line}", ""]
    lines += [f"- {doubt}" for doubt in guessed.doubts]
    if power := guessed.columns.get("power_ac"):
        unit = (
            "--convert"
            if named_unit("p_dc_per_area", power)
            else "--unit p_dc_per_area=W"
        )
        lines.append(
            f"- {power!r} as power_ac cross-checks instruments and shows outages and "
            "covered modules; with the area of the modules "
            f"{shell_words(['--map', f'p_dc_per_area={power}'])} {unit} "
            "--module-area AREA gives loop power for each m²"
        )
    lines += [
        f"- not mapped, {reason}: {', '.join(map(repr, columns))}"
        for reason, columns in guessed.unused.items()
    ]
    searches = click.get_current_context().info_name in ("loop", "recover")
    if guessed.unused and searches:
        lines.append("- of those the numeric ones that vary are tried as causes, too")
    if searches and not level and (words := options_of_place(guessed)):
        lines.append(
            f"- not given: {', '.join(words)}; without the place and the plane of the "
            "modules no clock is checked by the sun, and effects that follow it are "
            "not tested"
        )
    if calm:
        lines.append(
            "- no column looks like wind_speed, and the model ross needs none; if "
            "there is one, give it with --map wind_speed=COLUMN and drop --model ross"
        )
    if level:
        lines.append(
            "- there is no irradiance in the plane of the module: it is made of the "
            "horizontal one, which takes the place and the plane"
        )
    if absent:
        free = (
            f"There are {', '.join(guessed.free)}"
            if guessed.free
            else "No other is left"
        )
        lines.append(f"- which column is {', '.join(absent)}? {free}")
    if guessed.area and not how["module_area"]:
        lines.append("- the area of the modules is not in the file: put it for AREA")
    return "\n".join(lines).rstrip(), line


def options_of_place(guessed: Guess) -> list[str]:
    """Options of the place and of the plane of the modules that are not given."""
    given = click.get_current_context().params
    turns = any(given[name] is not None for name in TRACKER)
    turns |= bool(guessed.there & {*ANGLES, ROTATION})
    names = PLACE[:2] if turns else PLACE[:4]
    return [f"--{name}" for name in names if given[name] is None]


def lacking_sensors(names: Iterable[str]) -> list[str]:
    """Module sensors that a comparison needs in addition."""
    there = [name for name in names if is_sensor(name)]
    two = [name for name in ("temp_module", "temp_module_2") if name not in there]
    return two[: max(FEWEST - len(there), 0)]


def of_the_sky(guessed: Guess) -> list[str]:
    """Words that make irradiance in the plane of a column of horizontal one, if any."""
    context = click.get_current_context()
    columns = [c for c in (*guessed.columns.values(), *guessed.free) if GHI.search(c)]
    if not columns or "transposition" not in options_given():
        return []
    if "ghi" not in (*guessed.columns, columns[0]):
        guessed.columns["ghi"] = columns[0]
    guessed.free = [column for column in guessed.free if column != columns[0]]
    unused = {
        why: [c for c in some if c != columns[0]]
        for why, some in guessed.unused.items()
    }
    guessed.unused = {why: some for why, some in unused.items() if some}
    words = [] if context.params["transposition"] else ["--transposition", "perez"]
    for option in options_of_place(guessed):
        words += [option, option.removeprefix("--").upper()]
    return words


def options_given() -> list[str | None]:
    """Names of the options that the command has."""
    return [param.name for param in click.get_current_context().command.params]


def command(
    guessed: Guess,
    absent: Iterable[str],
    how: Mapping[str, Any],
    model: Sequence[str] = (),
    more: Iterable[str] = (),
) -> str:
    """
    The command as it was given, with the reading as it was found, and more.

    Parameters
    ----------
    guessed : Guess
        Layouts, columns and units.
    absent : iterable of str
        Columns that are missing, for which the line has a placeholder.
    how : dict
        Options of reading.
    model, more : sequence of str
        Words of the option for the model, and at the end.

    Returns
    -------
    str
    """
    context = click.get_current_context()
    source = context.get_parameter_source
    words, files = ["pvlib-fem", str(context.info_name)], []
    for param in context.command.params:
        value = context.params[param.name]
        if isinstance(param, click.Argument):
            files = [str(file) for file in value]
        elif param.name == "model" and model:
            words += model
        elif isinstance(param, click.Option) and (
            param.name not in ANEW and source(param.name) is COMMANDLINE
        ):
            words += option_words(param, value)
    words[2:2] = files
    for name, default in PER_FILE.items():
        values = fields_of(name, guessed.layouts)
        if len(set(values)) == 1 and values[0] == default:
            continue
        values = values[:1] if len(set(values)) == 1 else values
        for value in values:
            words += [f"--{name.replace('_', '-')}", as_option(name, value)]
    for text in dict.fromkeys(t for one in guessed.layouts for t in one.missing):
        words += ["--missing", text]
    for text in dict.fromkeys(t for one in guessed.layouts for t in one.keep):
        words += ["--keep", text]
    words += ["--sort"] * any(one.sort for one in guessed.layouts)
    words += ["--drop-doubled"] * any(one.drop_doubled for one in guessed.layouts)
    words += ["--drop-untimed"] * any(one.drop_untimed for one in guessed.layouts)
    for name, column in guessed.columns.items():
        words += ["--map", f"{name}={column}"]
    for name in absent:
        words += ["--map", f"{name}=COLUMN"]
    words += ["--convert"] * (guessed.headers or how["convert"])
    for name, unit in {**how["units"], **guessed.units}.items():
        words += ["--unit", f"{name}={unit}"]
    if guessed.area and not how["module_area"]:
        words += ["--module-area", "AREA"]
    return shell_words([*words, *more])


def fields_of(name: str, layouts: Sequence[Layout]) -> list[Any]:
    """What each layout has for an option; of lines that are left out one of the two."""
    if name not in ("skip_rows", "skip_lines"):
        return [getattr(layout, name) for layout in layouts]
    lines = [layout.skip_rows for layout in layouts]
    # where some files have lines before the header, the option of these takes both
    if all(isinstance(line, tuple) for line in lines) == (name == "skip_lines"):
        return lines
    return [PER_FILE[name]] * len(layouts)


def shell_words(words: Iterable[str]) -> str:
    """
    Words as a shell takes them.

    Parameters
    ----------
    words : iterable of str
        Words of a command line.

    Returns
    -------
    str
        One line, quoted as the shell of this system needs it.
    """
    join = subprocess.list2cmdline if sys.platform == "win32" else shlex.join
    return join(words)


def option_words(param: click.Option, value: Any) -> list[str]:
    """An option as it was given."""
    option = max(param.opts, key=len)
    if param.is_flag:
        return [option if value else max(param.secondary_opts, key=len)]
    values = value if param.multiple else [value]
    return [word for one in values for word in (option, str(one))]


def as_option(name: str, value: Any) -> str:
    """A field of a layout as its option has it."""
    if value is None or value == () or (name == "sheet" and value == 0):
        return ""
    if name == "sep":
        return value.replace("\t", r"\t")
    if isinstance(value, tuple):
        single = name == "skip_rows" and len(value) == 1
        return ",".join(map(str, value)) + "," * single
    return str(value)
