"""The command ``pvlib-fem``: the one module that talks."""

import textwrap
from importlib.util import find_spec
from pathlib import Path
from zoneinfo import available_timezones

import click
from pvlib.location import Location

from pvlib_fem import __version__, datasets, simulator
from pvlib_fem.findings import Kind, Verdict
from pvlib_fem.fitting.fit import METHODS, fit_fem
from pvlib_fem.loop.close import close_loop
from pvlib_fem.loop.criteria import Criteria
from pvlib_fem.loop.progress import line
from pvlib_fem.record.columns import COLUMNS
from pvlib_fem.record.files import read_file
from pvlib_fem.thermal.model import MEMORY
from pvlib_fem.thermal.steady import STEADY_MODELS

#: columns by which the loop knows an effect
OPTIONAL = (
    "wind_direction",
    "relative_humidity",
    "longwave_down",
    "precipitation",
    "p_dc",
    "snow_depth",
)
HIDDEN = ("sky_radiation", "wind_direction", "electrical_output")  # in the demo


@click.group(context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="pvlib-fem")
def main():
    """The temperature of PV modules, second by second, from measured data."""


def fit_options(command):
    """Options of every command that fits."""
    for option in (
        click.option("--model", type=click.Choice(list(STEADY_MODELS)), default="wm1"),
        click.option("--dynamics", type=click.Choice(list(MEMORY)), default="ewm"),
        click.option("--method", type=click.Choice(METHODS), default="least_squares"),
        click.option(
            "--calm-wind",
            type=float,
            default=0.5,
            help="Wind that the paper's recipe takes as calm [m/s].",
        ),
        click.option(
            "--out",
            type=click.Path(dir_okay=False, path_type=Path),
            help="Write the fit as JSON.",
        ),
        click.option(
            "--plot",
            type=click.Path(dir_okay=False, path_type=Path),
            help="Draw a held-out day to this file (needs matplotlib).",
        ),
    )[::-1]:
        command = option(command)
    return command


def reading_options(command):
    """The file, and options of every command that reads one."""
    for option in (
        click.argument(
            "file", type=click.Path(exists=True, dir_okay=False, path_type=Path)
        ),
        click.option(
            "--map",
            "renames",
            multiple=True,
            metavar="NAME=COLUMN",
            help="Column of the file that is poa_global, temp_air, wind_speed, "
            "temp_module, another that the command knows, or time; once for each.",
        ),
        click.option(
            "--tz", help="Zone of the times, such as Europe/Brussels or Etc/GMT+7."
        ),
        click.option(
            "--time-format",
            default="ISO8601",
            show_default=True,
            help="Format of the times, such as '%d/%m/%Y %H:%M'.",
        ),
        click.option(
            "--sep", default=",", show_default=True, help="Between CSV columns."
        ),
        click.option(
            "--decimal", default=".", show_default=True, help="In CSV numbers."
        ),
        click.option(
            "--encoding", default="utf-8", show_default=True, help="Of a CSV file."
        ),
        click.option(
            "--skip-rows",
            metavar="N,N,…",
            help="CSV lines to leave out, from 0: 0,2,3 for a TOA5 file.",
        ),
        click.option(
            "--no-unit-check",
            is_flag=True,
            help="Accept columns that look to be in another unit.",
        ),
    )[::-1]:
        command = option(command)
    return command


report_option = click.option(
    "--report",
    type=click.Path(dir_okay=False, path_type=Path),
    help="Write the report with pictures as one HTML file (needs matplotlib).",
)


@main.command()
@reading_options
@fit_options
def fit(file, **options):
    """Fit a CSV or Parquet FILE and print the report.

    The first column, or the one mapped to time, holds the times.
    """
    with one_line_errors():
        run(frame(file, options), **options)


@main.command()
@reading_options
@click.option(
    "--model",
    type=click.Choice(list(STEADY_MODELS)),
    default="faiman",
    show_default=True,
)
@click.option("--lat", type=click.FloatRange(-90, 90), help="North positive [°].")
@click.option("--lon", type=click.FloatRange(-180, 180), help="East positive [°].")
@click.option("--tilt", type=click.FloatRange(0, 180), help="Of the module [°].")
@click.option(
    "--azimuth",
    type=click.FloatRange(-360, 360),
    help="Of the module, from north by east [°].",
)
@click.option(
    "--min-gain",
    type=click.FloatRange(min=0),
    default=Criteria().min_gain,
    show_default=True,
    help="Gain below which no effect is added [K].",
)
@report_option
@click.option(
    "--out",
    type=click.Path(dir_okay=False, path_type=Path),
    help="Write the loop as JSON.",
)
def loop(file, report, out, **options):
    """Find which physical effects the model lacks in a CSV or Parquet FILE.

    Beside the columns of a fit it takes wind_direction [° from north],
    relative_humidity [%], longwave_down [W/m²], precipitation [mm/h], p_dc [W per
    m² of module] and snow_depth [cm]; every other numeric column is tried as a
    cause of its own. With --lat, --lon, --tilt and --azimuth it tries effects that
    follow the sun, too; times without a zone are then local standard time.
    """
    with one_line_errors():
        check_partners(options)
        check_writable(report, out)
        data = frame(file, options, (*COLUMNS, *OPTIONAL))
        found = closed(data, **options)
        click.echo(str(found))
        if out is not None:
            found.to_json(out)
            click.echo(f"\nwrote {out}")
        write_report(found, report, file.name)


@main.command()
@click.option("--days", type=click.IntRange(1), default=365, show_default=True)
@click.option(
    "--step",
    type=click.FloatRange(1, 3600),
    default=60,
    show_default=True,
    help="Of the simulated record [s].",
)
@click.option("--seed", type=click.IntRange(0), default=0, show_default=True)
@report_option
def demo(days, step, seed, report):
    """Find effects hidden in a simulated site, then look at a measured week.

    The simulation is made from first principles; its truth is told after the
    answer.
    """
    with one_line_errors():
        check_writable(report)
        demo_site(days, step, seed, report)
        demo_week()


def demo_site(days, step, seed, report):
    """A simulated site as a user has it, the answer, and then the truth."""
    click.echo(
        f"a simulated site, {days} days at {step / 60:g} min, with {len(HIDDEN)} "
        "effects that the loop is not told of\n"
    )
    site = simulator.RHINE
    with line() as bar:
        bar.set_description_str("simulating")
        effects = simulator.PHYSICS | dict.fromkeys(HIDDEN, 1.0)
        data = simulator.record(site, effects, days, step, seed)
    # few sites have these, so the sky has to come from the humidity
    found = closed(
        data.drop(columns=["longwave_down", "snow_depth"]),
        lat=site.latitude,
        lon=site.longitude,
        tilt=site.surface_tilt,
        azimuth=site.surface_azimuth,
    )
    click.echo(f"{found}\n\nthe truth, which the loop has not seen")
    for name in HIDDEN:
        what = simulator.SWITCHES[name].split(";")[0]
        click.echo(f"  {name:<22}{what}: {answer(name, found)}")
    always = [name for name in simulator.PHYSICS if name not in HIDDEN]
    click.echo(f"  {'in every module':<22}{', '.join(always)}")
    for name in found.effects:
        if name not in effects:
            click.echo(f"  {name:<22}is not in the simulation")
    write_report(found, report, "A simulated site")


def answer(name, found):
    """What a loop said of an effect that is there."""
    for finding in found.findings:
        if name in finding.candidates and finding.kind is not Kind.STRUCTURE:
            under = "" if name == finding.effect else f", under {finding.effect}"
            how = "a hint only" if finding.verdict is Verdict.SUGGESTIVE else "found"
            return f"{how}{under}, {finding.gain:.2f} K"
    return "not found"


def demo_week():
    """The measured week, or the reason why it cannot be had."""
    try:
        data = datasets.load("sandia_week")
    except (OSError, ValueError) as error:
        reason = textwrap.shorten(str(error), 60, placeholder=" …")
        click.echo(f"\nthe measured week cannot be had ({reason})")
        return
    found = closed(data)
    days = found.fit.train_days + found.fit.test_days
    click.echo(
        f"\na measured week: {data.attrs['source']}\n\n{found}\n\n"
        f"what {days} days can say: what memory and bias are worth, on days that the "
        f"fit has not seen\nwhat they cannot: the name of an effect, which takes "
        f"{Criteria().enough_days} days and its driver"
    )


def closed(
    data,
    model="faiman",
    lat=None,
    lon=None,
    tilt=None,
    azimuth=None,
    min_gain=None,
    no_unit_check=False,
):
    """The loop of a frame, with its progress on a terminal."""
    check_columns(data)
    with line() as bar:
        return close_loop(
            data,
            model,
            None if lat is None else location(data.index, lat, lon),
            tilt,
            azimuth,
            min_gain=min_gain,
            check_units=not no_unit_check,
            progress=bar.set_description_str,
        )


def location(index, lat, lon):
    """Where the record is from, in its zone or in local standard time."""
    tz = str(index.tz) if getattr(index, "tz", None) is not None else ""
    if not tz:
        tz = f"Etc/GMT{-round(lon / 15):+d}"  # this zone's sign is reversed
    elif tz not in available_timezones():  # an offset, which is no zone
        tz = "UTC"
    return Location(lat, lon, tz=tz)


def check_partners(options):
    """Refuse half a place."""
    for pair in (("lat", "lon"), ("tilt", "azimuth")):
        given = [name for name in pair if options[name] is not None]
        if len(given) == 1:
            (other,) = set(pair) - set(given)
            raise ValueError(f"--{given[0]} needs --{other} beside it")


def check_writable(picture, out=None):
    """Refuse before the work what cannot be written after it."""
    if picture is not None and find_spec("matplotlib") is None:
        raise ValueError(
            "a picture or a report needs matplotlib: pip install 'pvlib_fem[plot]'"
        )
    for path in (picture, out):
        if path is not None and not path.absolute().parent.is_dir():
            raise ValueError(f"there is no folder {path.parent} for {path.name}")


def write_report(found, path, title):
    """The page, which names the file that it is of."""
    if path is not None:
        found.to_html(path, title=title)
        click.echo(f"\nwrote {path}")


def check_columns(data):
    if lacking := [name for name in COLUMNS if name not in data]:
        raise ValueError(
            f"no column {', '.join(lacking)} among "
            f"{', '.join(map(str, data.columns))}; name it with --map "
            f"{lacking[0]}=COLUMN"
        )


def run(data, model, dynamics, method, calm_wind, no_unit_check, out, plot):
    """The one path from a frame to the report, the JSON and the picture."""
    check_writable(plot, out)
    check_columns(data)
    result = fit_fem(
        *(data[name] for name in COLUMNS),
        model=model,
        dynamics=dynamics,
        method=method,
        calm_wind=calm_wind,
        check_units=not no_unit_check,
    )
    click.echo(str(result))
    if out is not None:
        result.to_json(out)
        click.echo(f"\nwrote {out}")
    if plot is not None:
        result.plot().figure.savefig(plot, dpi=150)
        click.echo(f"\nwrote {plot}")


def columns_of(renames, names=COLUMNS):
    """The map of --map, from the package's names to those of the file."""
    mapped = {}
    for entry in renames:
        name, equals, column = entry.partition("=")
        if not equals or not column:
            raise click.BadParameter(
                f"{entry!r} is not NAME=COLUMN", param_hint="--map"
            )
        if name not in (*names, "time"):
            raise click.BadParameter(
                f"{name!r} is none of {', '.join(names)}, time", param_hint="--map"
            )
        mapped[name] = column
    return mapped


def frame(file, options, names=COLUMNS):
    """The file as a frame, by those of the options that say how to read it."""
    mapped = columns_of(options.pop("renames"), names)
    tz, time_format = options.pop("tz"), options.pop("time_format")
    csv = {name: options.pop(name) for name in ("sep", "decimal", "encoding")}
    csv["skiprows"] = line_numbers(options.pop("skip_rows"))
    return read_file(file, mapped, tz, time_format, **csv)


def line_numbers(text):
    try:
        return [int(number) for number in text.split(",")] if text else None
    except ValueError as error:
        raise click.BadParameter(
            f"{text!r} are no line numbers", param_hint="--skip-rows"
        ) from error


class one_line_errors:
    """Bad data end with exit code 1 and the reason in one line."""

    def __enter__(self):
        return self

    def __exit__(self, kind, error, trace):
        if isinstance(error, (ValueError, OSError)):
            raise click.ClickException(" ".join(str(error).split())) from error
        return False


if __name__ == "__main__":
    main()
