"""The command ``pvlib-fem``: the one module that talks."""

import textwrap
from pathlib import Path

import click
import pandas as pd

from pvlib_fem import __version__, datasets
from pvlib_fem.fitting import METHODS, fit_fem
from pvlib_fem.laws import LAWS
from pvlib_fem.model import MEMORY
from pvlib_fem.paper import COLUMNS


@click.group(context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="pvlib-fem")
def main():
    """The temperature of PV modules, second by second, from measured data."""


def fit_options(command):
    """Options of every command that fits."""
    for option in (
        click.option("--model", type=click.Choice(list(LAWS)), default="wm1"),
        click.option("--dynamics", type=click.Choice(list(MEMORY)), default="ewm"),
        click.option("--method", type=click.Choice(METHODS), default="least_squares"),
        click.option(
            "--calm-wind",
            type=float,
            default=0.5,
            help="Wind that the paper's recipe takes as calm [m/s].",
        ),
        click.option(
            "--no-unit-check",
            is_flag=True,
            help="Accept columns that look to be in another unit.",
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


@main.command()
@click.argument("file", type=click.Path(exists=True, dir_okay=False, path_type=Path))
@click.option(
    "--map",
    "renames",
    multiple=True,
    metavar="NAME=COLUMN",
    help="Column of the file that is poa_global, temp_air, wind_speed, temp_module "
    "or time; once for each.",
)
@click.option("--tz", help="Zone of the times, such as Europe/Brussels or Etc/GMT+7.")
@click.option(
    "--time-format",
    default="ISO8601",
    show_default=True,
    help="Format of the times, such as '%d/%m/%Y %H:%M'.",
)
@click.option("--sep", default=",", show_default=True, help="Between CSV columns.")
@click.option("--decimal", default=".", show_default=True, help="In CSV numbers.")
@click.option(
    "--skip-rows",
    metavar="N,N,…",
    help="CSV lines to leave out, from 0: 0,2,3 for a TOA5 file.",
)
@fit_options
def fit(file, renames, tz, time_format, sep, decimal, skip_rows, **options):
    """Fit a CSV or Parquet FILE and print the report.

    The first column, or the one mapped to time, holds the times.
    """
    with one_line_errors():
        csv = {"sep": sep, "decimal": decimal, "skiprows": line_numbers(skip_rows)}
        run(read_file(file, columns_of(renames), tz, time_format, **csv), **options)


@main.command()
@fit_options
def demo(**options):
    """Fit a measured week and print the report.

    Where the public file cannot be had, a made-up month takes its place.
    """
    with one_line_errors():
        try:
            data = datasets.load("sandia_week")
            click.echo(f"measured week: {data.attrs['source']}\n")
        except OSError as error:
            reason = textwrap.shorten(str(error), 60, placeholder=" …")
            click.echo(
                f"the measured week cannot be had ({reason}), so this is a made-up "
                "month\n"
            )
            data = datasets.synthetic(days=30)
        run(data, **options)


def run(data, model, dynamics, method, calm_wind, no_unit_check, out, plot):
    """The one path from a frame to the report, the JSON and the picture."""
    lacking = [name for name in COLUMNS if name not in data]
    if lacking:
        raise ValueError(
            f"no column {', '.join(lacking)} among "
            f"{', '.join(map(str, data.columns))}; name it with --map "
            f"{lacking[0]}=COLUMN"
        )
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


def columns_of(renames):
    """The map of --map, from the package's names to those of the file."""
    mapped = {}
    for entry in renames:
        name, equals, column = entry.partition("=")
        if not equals or not column:
            raise click.BadParameter(
                f"{entry!r} is not NAME=COLUMN", param_hint="--map"
            )
        if name not in (*COLUMNS, "time"):
            raise click.BadParameter(
                f"{name!r} is none of {', '.join(COLUMNS)}, time", param_hint="--map"
            )
        mapped[name] = column
    return mapped


def line_numbers(text):
    try:
        return [int(number) for number in text.split(",")] if text else None
    except ValueError as error:
        raise click.BadParameter(
            f"{text!r} are no line numbers", param_hint="--skip-rows"
        ) from error


def read_file(file, mapped, tz, time_format="ISO8601", **csv):
    """A logger file as a frame with a DatetimeIndex and the package's names."""
    if file.suffix.lower() in (".parquet", ".pq"):
        try:
            data = pd.read_parquet(file)
        except ImportError as error:
            raise ValueError(
                "reading Parquet needs pyarrow: pip install pyarrow"
            ) from error
    else:
        data = pd.read_csv(file, **csv)
        if data.shape[1] == 1:
            raise ValueError(
                f"{file.name} has the one column {data.columns[0]!r}; give --sep, such "
                "as ';'"
            )
    absent = [column for column in mapped.values() if column not in data]
    if absent:
        raise ValueError(
            f"{file.name} has no column {', '.join(absent)}; it has "
            f"{', '.join(map(str, data.columns))}"
        )
    if "time" in mapped or not isinstance(data.index, pd.DatetimeIndex):
        time = mapped.get("time", data.columns[0])
        index = times(data[time], time, time_format)
        data = data.drop(columns=time).set_index(index)
    if tz is not None:
        data.index = zoned(data.index, tz)
    # a mapped column takes the name, whatever else the file calls by it
    return data.assign(**{n: data[c] for n, c in mapped.items() if n != "time"})


def times(column, name, time_format):
    """Times of a column of text; the first bad entry is named."""
    if pd.api.types.is_numeric_dtype(column):
        raise ValueError(
            f"column {name!r} should hold the times and holds numbers; name the "
            "right one with --map time=COLUMN"
        )
    how = {"format": time_format, "errors": "coerce"}
    try:
        parsed = pd.to_datetime(column, **how)
        mixed = parsed.dtype == object  # as older pandas says it
    except ValueError:
        mixed = True
    if mixed:  # offsets that change, as with daylight saving time
        parsed = pd.to_datetime(column, utc=True, **how)
    if parsed.isna().any():
        row = int(parsed.isna().to_numpy().argmax())
        raise ValueError(
            f"column {name!r} holds no time of the format {time_format} in row {row}: "
            f"{column.iloc[row]!r}; give --time-format, such as '%d/%m/%Y %H:%M', or "
            "name the column of times with --map time=COLUMN"
        )
    return pd.DatetimeIndex(parsed, name="time")


def zoned(index, tz):
    """Times in a zone: naive ones are taken as local in it."""
    try:
        if index.tz is None:
            return index.tz_localize(tz)
        return index.tz_convert(tz)
    except Exception as error:  # an unknown zone, or an hour that a clock skips
        raise ValueError(
            f"--tz {tz}: {error}; loggers mostly keep standard time, for example "
            "--tz Etc/GMT-1 for one hour east of Greenwich"
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
