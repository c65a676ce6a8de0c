"""Options, and what their texts mean."""

import glob
import json
from pathlib import Path

import click
import pandas as pd

from pvlib_fem.drivers.transposition import TRANSPOSITIONS
from pvlib_fem.fit import METHODS
from pvlib_fem.fleet.tasks import TASKS
from pvlib_fem.record.columns import COLUMNS, in_new_names, vouches
from pvlib_fem.record.layout import Layout
from pvlib_fem.record.units import QUANTITIES, unit_of
from pvlib_fem.thermal.model import MEMORY
from pvlib_fem.thermal.steady import STEADY_MODELS

WRITTEN = click.Path(dir_okay=False, path_type=Path)
#: options that fit.thermal_parameters() has as arguments
PARAMETERS = (
    "wind_height",
    "exponent",
    "surface_tilt",
    "module_efficiency",
    "absorptance",
    "deltaT",
    "with_bias",
)
EACH = "Once for all files, or once for each."
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
    "header_rows": Layout.header_rows,
    "skip_end": Layout.skip_end,
    "sheet": 0,
}

#: fields of a layout that are the same for all files
SAME = ("missing", "sort", "drop_doubled", "drop_untimed")


def added(*options):
    """A decorator of a command with options, in this order."""

    def decorated(command):
        for option in options[::-1]:
            command = option(command)
        return command

    return decorated


class Readable(click.Path):
    """A file or a folder that is there, or a pattern of files."""

    def convert(self, value, param, ctx):
        if glob.has_magic(str(value)) and not Path(value).exists():
            return Path(value)
        return super().convert(value, param, ctx)


def files_argument(required=True):
    return click.argument(
        "files",
        metavar="FILE..." if required else "[FILE...]",
        nargs=-1,
        required=required,
        type=Readable(exists=True, path_type=Path),
    )


layout_options = added(
    click.option(
        "--guess",
        is_flag=True,
        help="Propose a command for these files, and run nothing.",
    ),
    click.option(
        "--map",
        "renames",
        multiple=True,
        metavar="NAME=COLUMN",
        help=f"Column of the file that is {', '.join(COLUMNS)} or another that the "
        "command knows; once for each.",
    ),
    click.option(
        "--time",
        multiple=True,
        metavar="COLUMN",
        help="Column of the times, or those of their parts, as Date,Time or Year,Month,"
        f"Day,Hour,Minute; by default the first. {EACH}",
    ),
    click.option(
        "--time-format",
        multiple=True,
        help="Format of the times, such as '%d/%m/%Y %H:%M', or unix, unix-ms, "
        "excel or matlab for times that are counted; by default ISO 8601. "
        f"{EACH}",
    ),
    click.option(
        "--tag",
        multiple=True,
        metavar="COLUMN",
        help="Of a table with a row for each reading: the column of what is read, of "
        f"which each becomes a column. {EACH}",
    ),
    click.option(
        "--value",
        multiple=True,
        metavar="COLUMN",
        help=f"Of such a table: the column of the readings. {EACH}",
    ),
    click.option(
        "--tz",
        multiple=True,
        help=f"Zone of the times, such as Europe/Brussels or Etc/GMT+7. {EACH}",
    ),
    click.option(
        "--sep", multiple=True, help=f"Between CSV columns, by default ','. {EACH}"
    ),
    click.option(
        "--decimal", multiple=True, help=f"In CSV numbers, by default '.'. {EACH}"
    ),
    click.option(
        "--thousands",
        multiple=True,
        metavar="SIGN",
        help=f"Between the thousands of numbers, by default none. {EACH}",
    ),
    click.option("--encoding", multiple=True, help=f"Of CSV, by default utf-8. {EACH}"),
    click.option(
        "--skip-rows",
        multiple=True,
        metavar="N | N,N,…",
        help="How many lines stand before the header; or the lines to leave out, from "
        f"0: 0,2,3 for a TOA5 file. {EACH}",
    ),
    click.option(
        "--header-rows",
        multiple=True,
        metavar="N",
        type=click.IntRange(min=1),
        help=f"How many lines the header has, whose labels are joined. {EACH}",
    ),
    click.option(
        "--skip-end",
        multiple=True,
        metavar="N",
        type=click.IntRange(min=0),
        help=f"How many lines stand after the last row, such as totals. {EACH}",
    ),
    click.option(
        "--sheet", multiple=True, help=f"Of a workbook, by default the first. {EACH}"
    ),
    click.option(
        "--missing",
        multiple=True,
        metavar="TEXT",
        help="Text that stands for a missing value, such as ---; once for each.",
    ),
    click.option(
        "--sort", is_flag=True, help="Put the rows in the order of their times."
    ),
    click.option(
        "--drop-doubled",
        is_flag=True,
        help="Of rows with the same time keep the first.",
    ),
    click.option(
        "--drop-untimed",
        is_flag=True,
        help="Leave out rows that hold no time, such as a header within the file.",
    ),
    click.option(
        "--convert",
        is_flag=True,
        help="Convert columns whose headers name another unit, such as (mph).",
    ),
    click.option(
        "--unit",
        "units",
        multiple=True,
        metavar="NAME=UNIT",
        help="Unit of a column that is to be converted, such as wind_speed=km/h; once "
        "for each.",
    ),
    click.option(
        "--module-area",
        type=click.FloatRange(min=0, min_open=True),
        help="Area of the modules whose power p_dc_per_area is in W or kW [m²].",
    ),
    click.option(
        "--no-unit-check",
        is_flag=True,
        help="Accept columns that look to be in another unit.",
    ),
)
reading_options = added(files_argument(), layout_options)
site_options = added(
    click.option("--lat", type=click.FloatRange(-90, 90), help="North positive [°]."),
    click.option("--lon", type=click.FloatRange(-180, 180), help="East positive [°]."),
    click.option("--tilt", type=click.FloatRange(0, 180), help="Of the module [°]."),
    click.option(
        "--azimuth",
        type=click.FloatRange(-360, 360),
        help="Of the module, from north by east [°].",
    ),
)
transposition_option = click.option(
    "--transposition",
    type=click.Choice(TRANSPOSITIONS),
    help="Where there is no poa_global, the model of the sky by which it is made of "
    "ghi; it takes --lat, --lon, --tilt and --azimuth.",
)
stand_in_option = click.option(
    "--stand-in",
    "stand_ins",
    multiple=True,
    metavar="NAME",
    help="Second source of air or wind that replaces missing values of the first, such "
    "as temp_air_2 or wind_speed_2; once for each.",
)
effects_option = click.option(
    "--effects",
    multiple=True,
    metavar="NAME,NAME,…",
    help="Physical effects: fit adds these, loop and fleet try no others, recover "
    "puts them in.",
)
fix_option = click.option(
    "--fix",
    multiple=True,
    metavar="NAME=NUMBER",
    help="Coefficient that is known, such as tau=378; once for each.",
)
shared_options = added(
    effects_option,
    click.option(
        "--effect-setting",
        "settings",
        multiple=True,
        metavar="NAME.SETTING=VALUE",
        help="Setting of one of --effects, such as soiling.cleaning=6 or "
        "sky_radiation.source=humidity; once for each.",
    ),
    click.option(
        "--holdout",
        multiple=True,
        metavar="DAY | DAY..DAY",
        help="Days that no fit sees, such as 2024-07-01..2024-07-07; once for each.",
    ),
    fix_option,
)
recovery_options = added(
    click.option(
        "--draws",
        type=click.IntRange(1),
        default=3,
        show_default=True,
        help="Dates and signs that are drawn for each effect.",
    ),
    click.option("--seed", type=click.IntRange(0), default=0, show_default=True),
    click.option(
        "--processes", type=click.IntRange(1), help="By default one for each core."
    ),
    click.option(
        "--reliability",
        is_flag=True,
        help="Close the loop on scrambled records, too: what they have lost and is "
        "still named is false.",
    ),
    click.option(
        "--trials",
        type=click.IntRange(1),
        default=10,
        show_default=True,
        help="Scrambled records of each kind, for --reliability.",
    ),
)
out_option = click.option("--out", type=WRITTEN, help="Write the result as JSON.")
parameter_options = added(
    click.option(
        "--wind-height",
        type=click.FloatRange(0, 200, min_open=True),
        help="Of the anemometer, for parameters by the wind at 10 m [m].",
    ),
    click.option(
        "--exponent",
        type=click.FloatRange(0, 1),
        default=1 / 7,
        show_default="1/7",
        help="Of the power law that takes the wind to 10 m.",
    ),
    click.option(
        "--tilt",
        "surface_tilt",
        type=click.FloatRange(0, 180),
        help="Of the module, for the conditions [°].",
    ),
    click.option(
        "--efficiency",
        "module_efficiency",
        type=click.FloatRange(0, 1),
        default=0.2,
        show_default=True,
        help="Of the module, which goes with parameters of PVsyst and SAM.",
    ),
    click.option(
        "--absorptance",
        type=click.FloatRange(0, 1, min_open=True),
        default=0.9,
        show_default=True,
        help="The same, alpha of PVsyst and tau-alpha of SAM.",
    ),
    click.option(
        "--deltaT",
        "deltaT",
        type=click.FloatRange(-5, 20),
        help="From the back of the module to its cells at 1000 W/m², by default as the "
        "fit keeps it [K].",
    ),
    click.option(
        "--with-bias/--without-bias",
        default=True,
        show_default=True,
        help="Take the bias of the fit for the module's own, or for the thermometer's.",
    ),
    click.option(
        "--typical-year",
        type=click.Path(exists=True, dir_okay=False, path_type=Path),
        help="File with poa_global, temp_air and wind_speed of a year, for T98.",
    ),
    click.option("--csv", type=WRITTEN, help="Write the table as CSV."),
)
report_option = click.option(
    "--report",
    type=WRITTEN,
    help="Write the report with pictures as one HTML file (needs matplotlib).",
)
title_option = click.option(
    "--title", help="Of the report; by default the name of the file."
)
correction_options = added(
    click.option(
        "--details",
        is_flag=True,
        help="Print every check, hint and note instead of the summary.",
    ),
    click.option(
        "--corrected",
        type=WRITTEN,
        help="Write FILE as CSV without the faults of instruments that are found, "
        "under its own names; what was measured is NAME_original.",
    ),
    click.option(
        "--resolve",
        multiple=True,
        metavar="NAME",
        help="The cause of an ambiguous finding, such as sensitivity_step, for "
        "--corrected; once for each.",
    ),
)
ceiling_option = click.option(
    "--ceiling",
    is_flag=True,
    help="Add how much of the error the columns of FILE could still explain, by "
    "boosted trees (needs scikit-learn; takes up to a minute).",
)
plot_option = click.option(
    "--plot",
    type=WRITTEN,
    help="Draw a held-out day to this file, .png, .svg or .pdf (needs matplotlib).",
)


def model_option(default, instead):
    return click.option(
        "--model",
        type=click.Choice(list(STEADY_MODELS)),
        default=default,
        show_default=True,
        help=f"Steady model; {instead}.",
    )


fit_options = added(
    model_option("wm1", "the paper's first by default, where loop takes faiman"),
    click.option(
        "--dynamics",
        type=click.Choice(list(MEMORY)),
        default="ewm",
        show_default=True,
        help="The paper's by default; loop takes the better of ewm and balance.",
    ),
    click.option(
        "--method",
        type=click.Choice(METHODS),
        default="least_squares",
        show_default=True,
    ),
    click.option(
        "--calm-wind",
        type=float,
        default=0.5,
        show_default=True,
        help="Wind that the paper's recipe takes as calm [m/s].",
    ),
)


fleet_options = added(
    click.option(
        "--out",
        required=True,
        type=click.Path(file_okay=False, path_type=Path),
        help="Folder of the results, which all workers see.",
    ),
    click.option(
        "--task",
        type=click.Choice(list(TASKS)),
        default="loop",
        show_default=True,
        help="What is done with each system.",
    ),
    click.option(
        "--scheduler",
        "client",
        metavar="ADDRESS",
        help="Of a running Dask cluster, such as tcp://10.0.0.7:8786; by default one "
        "on this machine, for as long as the command runs.",
    ),
    click.option(
        "--workers",
        type=click.IntRange(min=0),
        help="Processes on this machine, by default one a core; 0 works without any.",
    ),
    click.option(
        "--memory-limit",
        default="auto",
        show_default=True,
        help="Of each worker on this machine, such as 4GiB.",
    ),
    click.option(
        "--resume/--anew",
        default=True,
        show_default=True,
        help="Keep what was done of the same files in the same way.",
    ),
    click.option(
        "--pages", is_flag=True, help="Write each system's page with pictures, too."
    ),
    model_option("faiman", "for all systems"),
    effects_option,
    fix_option,
    click.option(
        "--min-gain",
        type=click.FloatRange(min=0),
        help="Gain below which loop adds no effect [K].",
    ),
)


def bad(text, option, why):
    return click.BadParameter(f"{text!r} {why}", param_hint=option)


def pairs(texts, option, form):
    """Texts of the form NAME=VALUE, each name once."""
    found = {}
    for text in texts:
        name, equals, value = text.partition("=")
        if not equals or not value:
            raise bad(text, option, f"is not {form}")
        if name in found:
            raise bad(text, option, f"comes after {name}={found[name]}; give one")
        found[name] = value
    return found


def columns_of(renames):
    """The map of --map, from the package's names to those of the file."""
    mapped = in_new_names(pairs(renames, "--map", "NAME=COLUMN"))
    for name, column in mapped.items():
        if column == "COLUMN":
            why = "stands for the name of a column of the file: put that"
            raise bad(f"{name}=COLUMN", "--map", why)
        if name == "time":
            why = f"are the times: give --time {column!r}"
            raise bad(f"time={column}", "--map", why)
        if name not in QUANTITIES and not vouches(name):
            why = (
                f"is none of {', '.join(QUANTITIES)}, nor a cross-check of an "
                "instrument: power_ac, power_dc, poa_global_2, temp_module_2 …"
            )
            raise bad(name, "--map", why)
    if twice := [c for c in mapped.values() if list(mapped.values()).count(c) > 1]:
        names = [name for name, column in mapped.items() if column == twice[0]]
        raise bad(twice[0], "--map", f"is given as {' and as '.join(names)}; give one")
    return mapped


def units_of(texts):
    """The units of --unit by the package's names."""
    found = in_new_names(pairs(texts, "--unit", "NAME=UNIT"))
    try:
        return {name: unit_of(name, unit) for name, unit in found.items()}
    except ValueError as error:
        raise click.BadParameter(str(error), param_hint="--unit") from error


def held(texts):
    """The coefficients of --fix."""
    found = {}
    for name, value in pairs(texts, "--fix", "NAME=NUMBER").items():
        try:
            found[name] = float(value)
        except ValueError as error:
            raise bad(value, "--fix", f"is no number for {name}") from error
    return found


def settings_of(texts):
    """The settings of --effect-setting by the names of the effects."""
    form, found = "NAME.SETTING=VALUE", {}
    for key, text in pairs(texts, "--effect-setting", form).items():
        name, dot, setting = key.partition(".")
        if not dot or not setting:
            raise bad(f"{key}={text}", "--effect-setting", f"is not {form}")
        try:
            value = json.loads(text)
        except ValueError:  # a word, such as a source
            value = text
        found.setdefault(name, {})[setting] = value
    return found


def layouts_of(options, files):
    """How each file is written."""
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
    values["skip_rows"] = [lines_of(text) for text in values["skip_rows"]]
    values["sep"] = ["\t" if sep == r"\t" else sep for sep in values["sep"]]
    if wrong := [text for text in values["decimal"] if len(text) != 1]:
        raise bad(wrong[0], "--decimal", "is not one sign")
    same = {name: options[name] for name in SAME}
    return [
        Layout(**{name: values[name][i] for name in values}, **same)
        for i in range(len(files))
    ]


def lines_of(text):
    """A number of lines, or the numbers of some; ``3,`` is the fourth alone."""
    if not text:
        return 0
    try:
        numbers = tuple(int(number) for number in text.removesuffix(",").split(","))
    except ValueError as error:
        raise bad(text, "--skip-rows", "are no line numbers") from error
    if min(numbers) < 0:
        raise bad(text, "--skip-rows", "are no line numbers")
    return numbers if "," in text else numbers[0]


def days_of(texts, index):
    """The rows of --holdout, or None without it."""
    if not texts:
        return None
    local = index.tz_localize(None).normalize()
    out = pd.Series(False, index)
    for text in texts:
        first, dots, last = text.partition("..")
        try:
            start, end = pd.Timestamp(first), pd.Timestamp(last if dots else first)
        except ValueError as error:
            raise bad(text, "--holdout", "is not DAY or DAY..DAY") from error
        rows = (local >= start) & (local <= end)
        if not rows.any():
            raise ValueError(
                f"--holdout {text}: the record has no such day; it is from "
                f"{index[0]:%Y-%m-%d} to {index[-1]:%Y-%m-%d}"
            )
        out |= rows
    return out
