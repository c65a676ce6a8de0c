"""The commands: what each reads, does and writes."""

from pathlib import Path

import click
import pandas as pd

from pvlib_fem.cli.demo import check_length, demo_site, demo_week, demo_years
from pvlib_fem.cli.options import (
    PARAMETERS,
    WRITTEN,
    ceiling_option,
    correction_options,
    days_of,
    files_argument,
    fit_options,
    fleet_options,
    held,
    layout_options,
    model_option,
    out_option,
    parameter_options,
    plot_option,
    reading_options,
    recovery_options,
    report_option,
    settings_of,
    shared_options,
    site_options,
    stand_in_option,
    title_option,
    transposition_option,
)
from pvlib_fem.cli.reading import (
    is_data_set,
    needed_by,
    opened,
    or_propose,
    read,
)
from pvlib_fem.cli.running import (
    check_partners,
    closed,
    effects_of,
    fitted,
    fitted_files,
    in_their_days,
    injected,
)
from pvlib_fem.cli.words import Refused, note, plainly, say
from pvlib_fem.cli.writing import (
    as_csv,
    check_ceiling,
    check_outputs,
    picture,
    write,
)
from pvlib_fem.drivers.place import site_of
from pvlib_fem.fitting.result import FemFit
from pvlib_fem.fleet import report as fleet_report, run as run_fleet
from pvlib_fem.loop.criteria import Criteria
from pvlib_fem.quality.screen import screen_record
from pvlib_fem.record.files import read_file
from pvlib_fem.sensors.compare import compare_modules
from pvlib_fem.stored import saved
from pvlib_fem.thermal_parameters.page import as_text, page

FEW = 5  # failures that are reported


@click.command()
@reading_options
@site_options
@transposition_option
@stand_in_option
@fit_options
@shared_options
@report_option
@title_option
@out_option
@plot_option
def fit(files, out, plot, report, title, **options):
    """Fit FILE, or several that are joined on their times, and print the report.

    CSV, Excel and Parquet go; Parquet files that follow each other, as a folder or a
    pattern such as 'plant/*.parquet', are read part by part and may be larger than
    memory. The first column, or what --time says, holds the times.
    The command loop takes the same options but for --dynamics, --method, --calm-wind
    and --plot, and has --min-gain of its own.
    """
    with plainly():
        check_outputs(files, out=out, plot=plot, report=report)
        if is_data_set(files):
            result = fitted_files(**prepared_files(files, options))
        else:
            data, options, otherwise = prepared(files, options)
            with or_propose(otherwise):
                result = fitted(data, **options)
        say(result)
        write(out, result.to_json)
        write(plot, lambda path: picture(result, path))
        write_report(report, result, title, files)


@click.command()
@reading_options
@site_options
@transposition_option
@stand_in_option
@model_option("faiman", "fit takes the paper's wm1 by default")
@shared_options
@click.option(
    "--min-gain",
    type=click.FloatRange(min=0),
    default=Criteria().min_gain,
    show_default=True,
    help="Gain below which no effect is added [K].",
)
@correction_options
@ceiling_option
@report_option
@title_option
@out_option
def loop(files, report, title, out, details, corrected, resolve, **options):
    """Find the effects and faults that the model misses in FILE, or several.

    In addition to the columns of a fit it takes wind_direction [° from north],
    relative_humidity [%], longwave_down [W/m²], precipitation [mm/h], p_dc_per_area
    [W per m² of module], snow_depth [cm] and poa_rear [W/m²]; every other numeric
    column is tried as a cause of its own. With --lat, --lon, --tilt and --azimuth it
    tries effects that follow the sun, too; times without a zone are then local standard
    time. Of a folder or a pattern of Parquet files it is of means over 5 min.
    """
    with plainly():
        check_outputs(files, report=report, out=out, corrected=corrected)
        check_correction(files, corrected, resolve)
        check_ceiling(options["ceiling"])
        if is_data_set(files):
            options = prepared_files(files, options, sun=True)
            data, otherwise = options.pop("record"), Refused
        else:
            data, options, otherwise = prepared(files, options, drivers=not details)
        options["effects"] = options["effects"] or None
        with or_propose(otherwise):
            found = closed(data, **options)
        say(found.report() if details else found)
        write(out, found.to_json)
        write_report(report, found, title, files)
        if corrected:
            whole = found.corrected(data, resolve)
            say(f"\n{whole}")
            table = whole.data.rename(columns=data.attrs["headers"])
            write(corrected, lambda path: saved(as_csv(table), path))


@click.command()
@reading_options
@site_options
@model_option("faiman", "fit takes the paper's wm1 by default")
@shared_options
@recovery_options
@out_option
def recover(files, out, **options):
    """Put effects into FILE, and find from what size the loop sees them.

    --effects are those that are put in, in known sizes, by default all that have their
    columns; the loop tries all. With --out a run that was interrupted goes on where it
    was.
    """
    with plainly():
        check_outputs(files, out=out)
        data, options, otherwise = prepared(files, options, drivers=True)
        options["effects"] = options["effects"] or None
        with or_propose(otherwise):
            say(injected(data, path=out, **options))


@click.command()
@reading_options
@click.option(
    "--cleaned",
    type=WRITTEN,
    help="Write FILE as CSV without what is at fault, in the package's names.",
)
def screen(files, cleaned, **options):
    """Find what FILE holds that was not measured: codes, spikes, stuck sensors …

    fit and loop leave out the same by themselves. Any of their columns will do.
    """
    with plainly():
        check_outputs(files, pictures=False, cleaned=cleaned)
        data, _ = read(files, options, needed=())
        found = screen_record(data)
        say(found)
        write(cleaned, lambda path: saved(as_csv(found.cleaned), path))


@click.command()
@reading_options
@model_option("faiman", "fit takes the paper's wm1 by default")
@click.option(
    "--common",
    type=WRITTEN,
    help="Write FILE as CSV with what the sensors have in common as temp_module, for "
    "the command loop.",
)
def modules(files, common, model, **options):
    """Compare the module sensors of FILE: what is common, what is one's own.

    The sensors are the columns temp_module, temp_module_1, temp_module_2 …, two and
    more; name others with --map temp_module_1=COLUMN.
    """
    with plainly():
        check_outputs(files, common=common)
        wanted = [n for n in needed_by(model) if n != "temp_module"]
        data, _ = read(files, options, needed=wanted)
        found = compare_modules(data, model=model)
        say(found)
        write(common, lambda path: saved(as_csv(found.common), path))


@click.command()
@click.argument(
    "source",
    metavar="FIT",
    type=click.Path(exists=True, dir_okay=False, path_type=Path),
)
@files_argument(required=False)
@layout_options
@click.option(
    "--holdout",
    multiple=True,
    metavar="DAY | DAY..DAY",
    help="Days of FILE that the fit did not see, if they were given to it.",
)
@parameter_options
@click.option("--report", type=WRITTEN, help="Write the table as one HTML file.")
@title_option
def parameters(source, files, holdout, report, csv, title, typical_year, **options):
    """Give the thermal parameters of FIT as pvlib, PVsyst and SAM take them.

    FIT is what fit or loop wrote with --out. FILE is the record, which NMOT by IEC
    61853-2, the unit mass of Prilliman's model and T98 need; without it the others are
    for usual winds. Each has its error, its range, what it holds for and its source.
    """
    with plainly():
        check_outputs([source, *files], pictures=False, report=report, csv=csv)
        if holdout and not files:
            raise ValueError("--holdout is of FILE, the record, which is not given")
        result = FemFit.from_json(source)
        own, otherwise = {name: options.pop(name) for name in PARAMETERS}, Refused
        if files:
            told = options["tz"]
            wanted = (*result.thermal_model.usual, "temp_module")
            data, otherwise = read(files, options, needed=wanted)
            data = in_their_days(data, None, told)
            own |= {"data": data, "holdout": days_of(holdout, data.index)}
        if typical_year is not None:
            own["typical_year"] = read_file(typical_year)
        with or_propose(otherwise):
            table = result.thermal_parameters(**own)
        say(as_text(table))
        write(csv, lambda path: saved(as_csv(table), path))
        title = title or source.name
        write(report, lambda path: saved(page(table, title), path))


@click.command()
@click.argument("systems", type=click.Path(exists=True, dir_okay=False, path_type=Path))
@fleet_options
@click.option(
    "--report",
    type=WRITTEN,
    help="Write one page of all systems, with links to each of the worst.",
)
def fleet(systems, out, report, effects, fix, min_gain, **options):
    """Close the loop on each of the SYSTEMS of a table, or fit them.

    The table is CSV, Excel or Parquet with a row for each system: id, file (path,
    pattern or URL), and where they are needed site, latitude, longitude,
    surface_tilt, surface_azimuth, the options of loop by name (tz, sep, time,
    skip_rows …), and poa_global, temp_air … for the names of the columns in the file.

    What was done of the same files is kept, so that a run that was stopped goes on.
    """
    with plainly():
        check_outputs([systems], [out], report=report)
        options |= {"effects": effects_of(effects, {})} if effects else {}
        options |= {"fixed": held(fix)} if fix else {}
        if min_gain is not None:
            options["min_gain"] = min_gain
        found = run_fleet(systems, out, **options)
        say(found)
        tell_failures(found)
        write(report, lambda path: fleet_report(out, path, title=systems.name))


@click.command()
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
    """Close the loop on a measured plant, a simulated site and a measured week.

    The simulation is made from first principles; its truth is printed after the
    answer. Measured records are public and downloaded once.
    """
    with plainly():
        check_length(days, step)
        check_outputs(report=report)
        demo_years()
        found = demo_site(days, step, seed)
        write(report, lambda path: found.to_html(path, title="A simulated site"))
        demo_week()


def tell_failures(found):
    """Why systems failed, the first few of them; an error where none was done."""
    rows = found.systems
    failed = rows[rows["state"] == "failed"]
    for _, row in failed.head(FEW).iterrows():
        note(f"{row['id']}: {row['message']}")
    if len(failed) > FEW:
        note(f"{len(failed) - FEW:,} more failed: see message in systems.parquet")
    if len(failed) == len(rows):
        raise ValueError("no system could be done; see the notes above")


def check_correction(files, corrected, resolve):
    """Refuse before the work a correction that cannot be written."""
    if resolve and corrected is None:
        raise ValueError("--resolve is for --corrected, which is not given")
    if corrected and is_data_set(files):
        raise ValueError(
            "--corrected does not go with Parquet files that follow each other; in "
            "Python loop.corrected(part) takes them part by part"
        )


def write_report(path, result, title, files):
    """The page of a fit or a loop, headed by the title or the names of the files."""
    title = title or ", ".join(file.name for file in files)
    write(path, lambda whole: result.to_html(whole, title=title))


def prepared_files(files, options, sun=False):
    """What a fit takes of Parquet files that follow each other, or a loop."""
    check_partners(options)
    for name, way in (("transposition", "transpose"), ("stand_ins", "fill")):
        if options.pop(name, None):
            option = name.removesuffix("s").replace("_", "-")
            raise ValueError(
                f"--{option} does not go with Parquet files that follow each other; "
                f"write the columns into them with pvlib_fem.{way}_record"
            )
    settings, days = settings_of(options.pop("settings")), options.pop("holdout")
    place = {name: options.pop(name) for name in ("lat", "lon", "tilt", "azimuth")}
    for name, value in place.items():
        if value is not None and not sun:
            raise ValueError(
                f"--{name} does not go with Parquet files that follow each other: the "
                "sun's place is found for files that are read as a whole"
            )
    effects, fixed = effects_of(options.pop("effects"), settings), options.pop("fix")
    record = opened(files, options)
    ends = [time.tz_localize(None).normalize() for time in record.ends]
    site = (
        {"site": site_of(pd.DatetimeIndex(record.ends), *place.values())} if sun else {}
    )
    return (
        options
        | site
        | {
            "record": record,
            "effects": effects,
            "fixed": held(fixed) or None,
            "holdout": days_of(days, pd.date_range(*ends)),
        }
    )


def prepared(files, options, drivers=False):
    """The frame, and what a fit or a loop takes; all that is wrong is refused here."""
    check_partners(options)
    settings = settings_of(options.pop("settings"))
    effects = effects_of(options.pop("effects"), settings)
    fixed = held(options.pop("fix"))
    days, told = options.pop("holdout"), options["tz"]
    how = options.get("transposition"), options.get("stand_ins", ())
    needed = needed_by(options["model"], *how)
    data, otherwise = read(files, options, drivers, needed)
    place = [options.pop(name) for name in ("lat", "lon", "tilt", "azimuth")]
    data = in_their_days(data, place[1], told)
    options |= {
        "effects": effects,
        "fixed": fixed or None,
        "holdout": days_of(days, data.index),
        "site": site_of(data.index, *place),
    }
    return data, options, otherwise
