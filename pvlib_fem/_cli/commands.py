"""The commands: what each reads, does and writes."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import click
import pandas as pd

from pvlib_fem._cli.demo import check_length, demo_site, demo_week, demo_years
from pvlib_fem._cli.file_options import files_argument, layout_options, reading_options
from pvlib_fem._cli.fleet_options import fleet_options
from pvlib_fem._cli.headings import (
    MODEL,
    OUTPUT,
    SIMULATED,
    WRITTEN,
    command_with,
    option_maker,
)
from pvlib_fem._cli.model_options import (
    fit_options,
    min_rmse_reduction_option,
    model_option,
    shared_options,
    site_options,
    stand_in_option,
    transposition_option,
)
from pvlib_fem._cli.option_texts import days_of, effects_of, fixed_coefficients
from pvlib_fem._cli.output_files import (
    as_csv,
    check_ceiling,
    check_outputs,
    write,
    write_picture,
    write_report,
)
from pvlib_fem._cli.printing import Refused, note, plainly, say
from pvlib_fem._cli.read_records import (
    frame_and_arguments,
    frame_of_files,
    in_their_days,
    is_data_set,
    needed_by,
    or_propose,
    prepared_files,
)
from pvlib_fem._cli.result_options import (
    ARGUMENTS,
    ceiling_option,
    correction_options,
    out_option,
    parameter_options,
    plot_option,
    recovery_options,
    report_option,
    title_option,
)
from pvlib_fem._cli.run_methods import (
    fit_of_frame,
    fitted_files,
    loop_of_frame,
    recovery_of_frame,
)
from pvlib_fem._fitting.fem_fit import FemFit
from pvlib_fem._record.logger_files import read_file
from pvlib_fem._sensors.compare_sensors import compare_modules
from pvlib_fem._stored import saved
from pvlib_fem._thermal_parameters.parameter_page import as_text, page
from pvlib_fem.fleet import report as fleet_report, run as run_fleet
from pvlib_fem.fleet._results import Results
from pvlib_fem.quality._screen import screen_record

model, simulated, output = map(option_maker, (MODEL, SIMULATED, OUTPUT))
FEW = 5  # failures that are reported


@command_with(
    "pvlib-fem fit plant.csv --guess",
    "pvlib-fem fit plant.csv --map poa_global=Irr --out fit.json",
    "pvlib-fem fit plant.csv --dynamics balance --holdout 2024-07-01..2024-07-07",
)
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
def fit(
    files: tuple[Path, ...],
    out: Path | None,
    plot: Path | None,
    report: Path | None,
    title: str | None,
    **options: Any,
) -> None:
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
            data, options, otherwise = frame_and_arguments(files, options)
            with or_propose(otherwise):
                result = fit_of_frame(data, **options)
        say(result)
        write(out, result.to_json)
        write(plot, lambda path: write_picture(result, path))
        write_report(report, result, title, files)


@command_with(
    "pvlib-fem loop plant.csv --guess",
    "pvlib-fem loop plant.csv --lat 46.5 --lon 11.3 --tilt 30 --azimuth 180",
    "pvlib-fem loop plant.csv --corrected sound.csv --report plant.html",
)
@reading_options
@site_options
@transposition_option
@stand_in_option
@model_option("faiman", "fit takes the paper's wm1 by default")
@shared_options
@min_rmse_reduction_option
@correction_options
@ceiling_option
@report_option
@title_option
@out_option
def loop(
    files: tuple[Path, ...],
    report: Path | None,
    title: str | None,
    out: Path | None,
    details: bool,
    corrected: Path | None,
    resolve: tuple[str, ...],
    **options: Any,
) -> None:
    """Find the effects and faults that the model misses in FILE, or several.

    In addition to the columns of a fit it takes wind_direction [° from north],
    relative_humidity [%], longwave_down [W/m²], precipitation [mm/h], power_dc or
    power_ac [W], p_dc_per_area [W per m² of module], snow_depth [cm] and poa_rear
    [W/m²]; every other numeric column is tried as a cause of its own. With --lat,
    --lon, --tilt and --azimuth, or the options of a tracker instead of the last two, it
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
            data, options, otherwise = frame_and_arguments(
                files, options, drivers=not details
            )
        options["effects"] = options["effects"] or None
        with or_propose(otherwise):
            result = loop_of_frame(data, **options)
        say(result.report() if details else result)
        write(out, result.to_json)
        write_report(report, result, title, files)
        if corrected:
            whole = result.corrected(data, resolve)
            say(f"\n{whole}")
            table = whole.data.rename(columns=data.attrs["headers"])
            write(corrected, lambda path: saved(as_csv(table), path))


@command_with(
    "pvlib-fem recover plant.csv --effects soiling,anemometer_step --out sizes.json"
)
@reading_options
@site_options
@transposition_option
@stand_in_option
@model_option("faiman", "fit takes the paper's wm1 by default")
@shared_options
@recovery_options
@out_option
def recover(files: tuple[Path, ...], out: Path | None, **options: Any) -> None:
    """Put effects into FILE, and find from what size the loop sees them.

    --effects are those that are put in, in known sizes, by default all that have their
    columns; the loop tries all. With --out a run that was interrupted goes on where it
    was.
    """
    again = f"what was done is kept in {out}; run the same command to go on"
    with plainly(lambda: again if out and out.exists() else ""):
        check_outputs(files, out=out)
        data, options, otherwise = frame_and_arguments(files, options, drivers=True)
        options["effects"] = options["effects"] or None
        with or_propose(otherwise):
            say(recovery_of_frame(data, path=out, **options))


@command_with("pvlib-fem screen plant.csv --cleaned clean.csv")
@reading_options
@output(
    "--cleaned",
    type=WRITTEN,
    help="Write FILE as CSV without what is at fault, in the package's names.",
)
def screen(files: tuple[Path, ...], cleaned: Path | None, **options: Any) -> None:
    """Find what FILE holds that was not measured: codes, spikes, stuck sensors …

    fit and loop leave out the same by themselves. Any of their columns will do.
    """
    with plainly():
        check_outputs(files, pictures=False, cleaned=cleaned)
        data, _ = frame_of_files(files, options, needed=())
        screening = screen_record(data)
        say(screening)
        write(cleaned, lambda path: saved(as_csv(screening.cleaned), path))


@command_with(
    "pvlib-fem modules plant.csv --guess",
    "pvlib-fem modules plant.csv --map temp_module=T1 --map temp_module_2=T2",
)
@reading_options
@model_option("faiman", "fit takes the paper's wm1 by default")
@output(
    "--common",
    type=WRITTEN,
    help="Write FILE as CSV with what the sensors have in common as temp_module, for "
    "the command loop.",
)
def modules(
    files: tuple[Path, ...], common: Path | None, model: str, **options: Any
) -> None:
    """Compare the module sensors of FILE: what is common, what is one's own.

    The sensors are the columns temp_module, temp_module_1, temp_module_2 …, two and
    more; name others with --map temp_module_1=COLUMN.
    """
    with plainly():
        check_outputs(files, common=common)
        wanted = [n for n in needed_by(model) if n != "temp_module"]
        data, _ = frame_of_files(files, options, needed=wanted)
        comparison = compare_modules(data, model=model)
        say(comparison)
        write(common, lambda path: saved(as_csv(comparison.common), path))


@command_with(
    "pvlib-fem parameters fit.json",
    "pvlib-fem parameters fit.json plant.csv --wind-height 2.5 --csv table.csv",
)
@click.argument(
    "source",
    metavar="FIT",
    type=click.Path(exists=True, dir_okay=False, path_type=Path),
)
@files_argument(required=False)
@layout_options
@model(
    "--holdout",
    multiple=True,
    metavar="DAY | DAY..DAY",
    help="Days of FILE that the fit did not see, if they were given to it.",
)
@parameter_options
@output("--report", type=WRITTEN, help="Write the table as one HTML file.")
@title_option
def parameters(
    source: Path,
    files: tuple[Path, ...],
    holdout: tuple[str, ...],
    report: Path | None,
    csv: Path | None,
    title: str | None,
    typical_year: Path | None,
    **options: Any,
) -> None:
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
        own, otherwise = {name: options.pop(name) for name in ARGUMENTS}, Refused
        if files:
            zones = options["tz"]
            wanted = (*result.thermal_model.usual, "temp_module")
            data, otherwise = frame_of_files(files, options, needed=wanted)
            data = in_their_days(data, None, zones)
            own |= {
                "data": data,
                "holdout": days_of(holdout, pd.DatetimeIndex(data.index)),
            }
        if typical_year is not None:
            own["typical_year"] = read_file(typical_year)
        with or_propose(otherwise):
            table = result.thermal_parameters(**own)
        say(as_text(table))
        write(csv, lambda path: saved(as_csv(table), path))
        title = title or source.name
        write(report, lambda path: saved(page(table, title), path))


@command_with("pvlib-fem fleet systems.csv --out results --report fleet.html")
@click.argument("systems", type=click.Path(exists=True, dir_okay=False, path_type=Path))
@fleet_options
@output(
    "--report",
    type=WRITTEN,
    help="Write one page of all systems, with links to each of the worst.",
)
def fleet(
    systems: Path,
    out: Path,
    report: Path | None,
    effects: tuple[str, ...],
    fix: tuple[str, ...],
    min_rmse_reduction: float | None,
    **options: Any,
) -> None:
    """Close the loop on each of the SYSTEMS of a table, or fit them.

    The table is CSV, Excel or Parquet with a row for each system: id, file (path,
    pattern or URL), and where they are needed site, latitude, longitude,
    surface_tilt, surface_azimuth, of a tracker axis_tilt, axis_azimuth, max_angle, gcr
    and backtrack, the options of loop by name (tz, sep, time, skip_rows …), and
    poa_global, temp_air … for the names of the columns in the file.

    What was done of the same files is kept, so that a run that was stopped goes on.
    """
    with plainly(lambda: kept_in(out, options["resume"])):
        check_outputs([systems], [out], report=report)
        options |= {"effects": effects_of(effects, {})} if effects else {}
        options |= {"fixed": fixed_coefficients(fix)} if fix else {}
        if min_rmse_reduction is not None:
            options["min_rmse_reduction"] = min_rmse_reduction
        results = run_fleet(systems, out, **options)
        say(results)
        report_failures(results)
        write(report, lambda path: fleet_report(out, path, title=systems.name))


@command_with("pvlib-fem demo --days 90 --report demo.html")
@simulated("--days", type=click.IntRange(1), default=365, show_default=True)
@simulated(
    "--step",
    type=click.FloatRange(1, 3600),
    default=60,
    show_default=True,
    help="Of the simulated record [s].",
)
@simulated("--seed", type=click.IntRange(0), default=0, show_default=True)
@report_option
def demo(days: int, step: float, seed: int, report: Path | None) -> None:
    """Close the loop on a measured plant, a simulated site and a measured week.

    The simulation is made from first principles; its truth is printed after the
    answer. Measured records are public and downloaded once.
    """
    with plainly():
        check_length(days, step)
        check_outputs(report=report)
        demo_years()
        simulated_loop = demo_site(days, step, seed)
        write(
            report, lambda path: simulated_loop.to_html(path, title="A simulated site")
        )
        demo_week()


def kept_in(out: Path, resume: bool) -> str:
    """How a fleet that was interrupted goes on."""
    again = f"run the same command {'' if resume else 'without --anew '}to go on"
    try:
        states = Results(out).systems["state"]
    except (ValueError, OSError):  # before the first system
        return again
    ran = (states != "not run").sum()
    return f"{ran:,} of {len(states):,} systems are kept in {out}; {again}"


def report_failures(results: Results) -> None:
    """Why systems failed, the first few of them; an error where none was done."""
    rows = results.systems
    failed = rows[rows["state"] == "failed"]
    for _, row in failed.head(FEW).iterrows():
        note(f"{row['id']}: {row['message']}")
    if len(failed) > FEW:
        note(f"{len(failed) - FEW:,} more failed: see message in systems.parquet")
    if len(failed) == len(rows):
        raise ValueError("no system could be done; see the notes above")


def check_correction(
    files: Sequence[Path], corrected: Path | None, resolve: Sequence[str]
) -> None:
    """Refuse before the work a correction that cannot be written."""
    if resolve and corrected is None:
        raise ValueError("--resolve is for --corrected, which is not given")
    if corrected and is_data_set(files):
        raise ValueError(
            "--corrected does not go with Parquet files that follow each other; in "
            "Python loop.corrected(part) takes them part by part"
        )
