"""Files as a frame, and where that fails the command that may read them."""

import glob
import re
import shlex
import stat
import subprocess
import sys
from contextlib import contextmanager

import click
from click.core import ParameterSource

from pvlib_fem.cli.options import PER_FILE, SAME, columns_of, layouts_of, units_of
from pvlib_fem.cli.words import Refused, note, say
from pvlib_fem.fitting.stand_ins import SERVED, chosen
from pvlib_fem.quality.screen import screened
from pvlib_fem.quality.units import options_of, unit_of_driver
from pvlib_fem.record.checks import datetime_steps
from pvlib_fem.record.columns import (
    ALWAYS,
    COLUMNS,
    numeric,
    of_several,
    twin_of,
)
from pvlib_fem.record.files import frame
from pvlib_fem.record.footers import parquet_file
from pvlib_fem.record.guess import Guess, guess
from pvlib_fem.record.inputs import as_record
from pvlib_fem.record.layout import PARQUET
from pvlib_fem.record.names import unmapped
from pvlib_fem.record.parquet import open_parquet
from pvlib_fem.record.units import QUANTITIES, ForeignUnit, Swapped, named_unit
from pvlib_fem.spelling import refusal
from pvlib_fem.thermal.steady import steady_model

COMMANDLINE = ParameterSource.COMMANDLINE
#: what loggers call horizontal irradiance
GHI = re.compile(
    r"(^|[\W_])ghi(\b|_|\d)|glob\w*[\s_.-]*horiz|horiz\w*[\s_.-]*(glob|irr|rad)",
    re.IGNORECASE,
)
LOOK = "this command may read it; look at it before you run it:"
#: options that a proposal says anew
ANEW = (*PER_FILE, *SAME, "renames", "convert", "units", "guess")


def needed_by(model, transposition=None, stand_ins=()):
    """Columns that a fit of a steady model needs."""
    usual = COLUMNS if steady_model(model).takes_wind else ALWAYS
    # those that the fit looks for, or makes
    made = [*chosen(stand_ins), *(["poa_global"] if transposition else [])]
    return [name for name in usual if name not in made]


def read(files, options, drivers=False, needed=COLUMNS):
    """
    The files as a frame in the package's names.

    Parameters
    ----------
    files : sequence of Path
    options : dict
        Options of reading, which are taken out of it.
    drivers : bool
        Whether further columns count, so that likely ones are proposed.
    needed : sequence of str
        Columns without which nothing can be done.

    Returns
    -------
    DataFrame, callable
        The frame, and what makes of an error its refusal, with the command that may
        read the files otherwise.

    Raises
    ------
    Refused
        With the command that may read them, where one is found.
    """
    columns, layouts = columns_of(options["renames"]), layouts_of(options, files)
    asked, place = options.pop("guess"), options.get("lon")
    how = dict(
        convert=options.pop("convert"),
        units=units_of(options.pop("units")),
        check_units=not options["no_unit_check"],
        module_area=options.pop("module_area"),
    )
    for name in ANEW:
        options.pop(name, None)
    for file in files:
        if stat.S_ISCHR(file.stat().st_mode):
            raise ValueError(f"{file} is a device and no file")

    done = {}  # units that columns were converted from

    def otherwise(error):
        proposed, line = proposal(files, layouts, columns, how, place, needed)
        same = line == command(Guess(layouts, columns), [], how)
        return Refused(after_conversion(error, done), "" if same else proposed)

    if asked:
        proposed, _ = proposal(files, layouts, columns, how, place, needed)
        if not proposed:
            raise ValueError(f"{files[0].name} holds no table that could be guessed at")
        say(proposed)
        raise click.exceptions.Exit(0)
    try:
        data = frame(files, layouts, columns, **how)
        check_columns(data, needed)
        datetime_steps(data.index, "the time")
    except (ValueError, OSError) as error:
        raise otherwise(error) from error
    done |= data.attrs.pop("converted")
    # a header that names another unit is that of no converted column
    data.attrs["headers"] = {n: c for n, c in columns.items() if n not in done}
    for line in data.attrs.pop("notes"):
        note(line)
    looks = unmapped(numeric(data)) if drivers else {}
    likely = {n: c for c, n in [*looks.items()][::-1] if n not in data}
    if likely:
        maps = [w for n, c in likely.items() for w in options_of(c, n, data[c])]
        what = ", ".join(f"{c!r} looks like {n}" for n, c in likely.items())
        note(
            f"{what}. Under another name a column is only a driver of unknown meaning; "
            f"if it is that, run again with {quoted(maps)}"
        )
    return data, otherwise


@contextmanager
def or_propose(otherwise):
    """What a fit refuses since the file says something else, with the proposal."""
    try:
        yield
    except (ForeignUnit, Swapped) as error:
        raise otherwise(error) from error


def after_conversion(error, units):
    """An error that does not ask for a conversion that was made."""
    told = getattr(error, "columns", ())
    if not told or not {*told} <= {*units}:
        return error
    look = "looks" if len(told) == 1 else "look"
    return (
        f"{' and '.join(told)} still {look} to be in {error.unit} after the "
        f"conversion: {error.why}; give --no-unit-check if that is right"
    )


def is_data_set(files):
    """Whether files follow each other, as a folder, a pattern or some of one kind."""
    if len(files) == 1:
        return files[0].is_dir() or glob.has_magic(str(files[0]))
    if any(file.suffix.lower() not in PARQUET for file in files):
        return False
    columns = {
        tuple(parquet_file(str(file), None).schema_arrow.names) for file in files
    }
    return len(columns) == 1


def opened(files, options):
    """Parquet files that follow each other, by the options that go with them."""
    times = {name: options.pop(name) for name in ("time", "tz")}
    if long := [name for name, given in times.items() if len(given) > 1]:
        raise ValueError(f"--{long[0]} is given {len(times[long[0]])} times; give one")
    renames = columns_of(options.pop("renames"))
    untimed = options.pop("drop_untimed")
    for name in (*PER_FILE, *ANEW, "module_area"):
        if options.pop(name, None):
            option = {"units": "unit"}.get(name, name.replace("_", "-"))
            raise ValueError(
                f"--{option} does not go with Parquet files that follow each other: "
                "they are read as they are, part by part"
            )
    times = {name: next(iter(given), None) for name, given in times.items()}
    data = files[0] if len(files) == 1 else list(files)
    how = dict(check_units=not options["no_unit_check"], drop_untimed=untimed)
    return open_parquet(data, renames, **times, **how)


def check_columns(data, needed=COLUMNS):
    if lacking := [name for name in needed if name not in data]:
        there = ", ".join(map(str, data.columns))
        raise refusal(
            f"no column {', '.join(lacking)} among {there}; name it with --map "
            f"{lacking[0]}=COLUMN{without(lacking, data)}",
            *of_several(data.columns),
        )


def without(lacking, data):
    """What a fit can do without columns."""
    others = [name for name in data if len(lacking) == 1 and twin_of(name) in lacking]
    if others and lacking[0] in SERVED:
        return f", or give --stand-in {others[0]}"
    if lacking == ["wind_speed"]:
        return ", or give --model ross if there is none"
    if lacking == ["poa_global"] and "ghi" in data:
        return ", or make it of ghi: --transposition perez"
    return ""


def check_record(data):
    """Refuse what a fit would, such as a unit that only the numbers show."""
    screened(as_record(*map(data.get, COLUMNS)))
    for name in QUANTITIES:
        if name in data and (unit := unit_of_driver(name, data[name])):
            most = f"it is {data[name].max():.2g} at most"
            raise ForeignUnit(f"{name} is in {unit}", (name,), unit, most)


def proposal(files, layouts, columns, how, place, needed=COLUMNS):
    """What to look at, and the command that may read files; both empty without any."""
    try:
        several = click.get_current_context().info_name == "modules"
        found = guess(files, layouts, columns, how, place, check_record, several)
        lacking = [name for name in needed if name not in found.there]
        level = of_the_sky(found) if "poa_global" in lacking else []
        calm = "wind_speed" in lacking and "model" in options_given()
        spared = ["poa_global"] * bool(level) + ["wind_speed"] * calm
        lacking = [name for name in lacking if name not in spared]
        calm = calm and not lacking
        if not lacking:
            needed = [name for name in needed if name not in spared]
            check = {**how, "convert": how["convert"] or found.headers}
            check["units"] = {**how["units"], **found.units}
            if found.area and not how["module_area"]:
                check["module_area"] = 1.0
            data = frame(files, found.layouts, found.columns, **check)
            check_columns(data, needed)
    except Exception:  # a proposal is an extra; the error itself is reported anyway
        return "", ""
    line = command(found, lacking, how, ["--model", "ross"] * calm, level)
    lines = [LOOK, "", f"  {line}", ""]
    lines += [f"- {doubt}" for doubt in found.doubts]
    if power := found.columns.get("power_ac"):
        unit = (
            "--convert"
            if named_unit("p_dc_per_area", power)
            else "--unit p_dc_per_area=W"
        )
        lines.append(
            f"- {power!r} as power_ac cross-checks instruments and shows outages and "
            "covered modules; with the area of the modules "
            f"{quoted(['--map', f'p_dc_per_area={power}'])} {unit} "
            "--module-area AREA gives loop power for each m²"
        )
    lines += [
        f"- not mapped, {reason}: {', '.join(map(repr, columns))}"
        for reason, columns in found.unused.items()
    ]
    if found.unused and click.get_current_context().info_name in ("loop", "recover"):
        lines.append("- of those the numeric ones that vary are tried as causes, too")
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
    if lacking:
        lines.append(
            f"- which column is {', '.join(lacking)}? There are {', '.join(found.free)}"
        )
    if found.area and not how["module_area"]:
        lines.append("- the area of the modules is not in the file: put it for AREA")
    return "\n".join(lines).rstrip(), line


def of_the_sky(found):
    """Words that make irradiance in the plane of a column of horizontal one, if any."""
    context = click.get_current_context()
    columns = [c for c in (*found.columns.values(), *found.free) if GHI.search(c)]
    if not columns or "transposition" not in options_given():
        return []
    if "ghi" not in (*found.columns, columns[0]):
        found.columns["ghi"] = columns[0]
    found.free = [column for column in found.free if column != columns[0]]
    left = {
        why: [c for c in some if c != columns[0]] for why, some in found.unused.items()
    }
    found.unused = {why: some for why, some in left.items() if some}
    words = [] if context.params["transposition"] else ["--transposition", "perez"]
    for name in ("lat", "lon", "tilt", "azimuth"):
        words += [f"--{name}", name.upper()] if context.params[name] is None else []
    return words


def options_given():
    """Names of the options that the command has."""
    return [param.name for param in click.get_current_context().command.params]


def command(found, lacking, how, model=(), more=()):
    """The command as it was given, with the reading as it was found, and more."""
    context = click.get_current_context()
    source = context.get_parameter_source
    words, files = ["pvlib-fem", context.info_name], []
    for param in context.command.params:
        value = context.params[param.name]
        if isinstance(param, click.Argument):
            files = [str(file) for file in value]
        elif param.name == "model" and model:
            words += model
        elif param.name not in ANEW and source(param.name) is COMMANDLINE:
            words += spoken(param, value)
    words[2:2] = files
    for name, default in PER_FILE.items():
        values = [getattr(layout, name) for layout in found.layouts]
        if len(set(values)) == 1 and values[0] == default:
            continue
        values = values[:1] if len(set(values)) == 1 else values
        for value in values:
            words += [f"--{name.replace('_', '-')}", as_option(name, value)]
    for text in dict.fromkeys(t for one in found.layouts for t in one.missing):
        words += ["--missing", text]
    words += ["--sort"] * any(one.sort for one in found.layouts)
    words += ["--drop-doubled"] * any(one.drop_doubled for one in found.layouts)
    words += ["--drop-untimed"] * any(one.drop_untimed for one in found.layouts)
    for name, column in found.columns.items():
        words += ["--map", f"{name}={column}"]
    for name in lacking:
        words += ["--map", f"{name}=COLUMN"]
    words += ["--convert"] * (found.headers or how["convert"])
    for name, unit in {**how["units"], **found.units}.items():
        words += ["--unit", f"{name}={unit}"]
    if found.area and not how["module_area"]:
        words += ["--module-area", "AREA"]
    return quoted([*words, *more])


def quoted(words):
    """Words as a shell takes them."""
    join = subprocess.list2cmdline if sys.platform == "win32" else shlex.join
    return join(words)


def spoken(param, value):
    """An option as it was given."""
    option = max(param.opts, key=len)
    if param.is_flag:
        return [option]
    values = value if param.multiple else [value]
    return [word for one in values for word in (option, str(one))]


def as_option(name, value):
    """A field of a layout as its option has it."""
    if value is None or value == () or (name == "sheet" and value == 0):
        return ""
    if name == "sep":
        return value.replace("\t", r"\t")
    if isinstance(value, tuple):
        lonely = name == "skip_rows" and len(value) == 1
        return ",".join(map(str, value)) + "," * lonely
    return str(value)
