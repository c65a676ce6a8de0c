"""Files as a frame, and what a fit or a loop of it takes."""

import glob
import stat
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import click
import pandas as pd

from pvlib_fem._cli.option_texts import (
    PER_FILE,
    PLACE,
    TRACKER,
    columns_of,
    days_of,
    effects_of,
    fixed_coefficients,
    layouts_of,
    settings_of,
    units_of,
)
from pvlib_fem._cli.printing import Otherwise, Refused, note, safe, say, waiting
from pvlib_fem._cli.proposal import ANEW, check_columns, command, proposal, shell_words
from pvlib_fem._fitting.stand_ins import stand_in_names
from pvlib_fem._loop.preparation.replacements import Replacements
from pvlib_fem._record.checks import datetime_steps
from pvlib_fem._record.column_names import ALWAYS, COLUMNS, numeric
from pvlib_fem._record.footers import parquet_file
from pvlib_fem._record.guess import Guess
from pvlib_fem._record.header_units import (
    ForeignUnit,
    SwappedTemperatures,
    named_unit,
    own_unit,
)
from pvlib_fem._record.layout import PARQUET
from pvlib_fem._record.logger_files import frame
from pvlib_fem._record.names import unmapped
from pvlib_fem._record.parquet import ParquetRecord, open_parquet
from pvlib_fem._spelling import in_shell
from pvlib_fem._thermal.steady_models import steady_model
from pvlib_fem.drivers import checked_place
from pvlib_fem.drivers._record_site import in_local_days, site_of
from pvlib_fem.quality._limits import Limits
from pvlib_fem.quality._unit_checks import options_of


def needed_by(
    model: str, transposition: str | None = None, stand_ins: Sequence[str] = ()
) -> list[str]:
    """
    Columns that a fit of a steady model needs.

    Parameters
    ----------
    model : str
        Steady model.
    transposition : str, optional
        Model that makes ``poa_global`` of horizontal irradiance.
    stand_ins : sequence of str
        Columns that replace missing values of others, such as ``temp_air_2``.

    Returns
    -------
    list of str
        Names of columns, without those that are made or replaced.
    """
    usual = COLUMNS if steady_model(model).takes_wind else ALWAYS
    # those that the fit looks for, or makes
    made = [*stand_in_names(stand_ins), *(["poa_global"] if transposition else [])]
    return [name for name in usual if name not in made]


def frame_of_files(
    files: Sequence[Path],
    options: dict[str, Any],
    drivers: bool = False,
    needed: Sequence[str] = COLUMNS,
) -> tuple[pd.DataFrame, Otherwise]:
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
    propose_only, place = options.pop("guess"), options.get("lon")
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

    def otherwise(error: Exception) -> Refused:
        try:
            with waiting(f"looking for what reads {named_files(files)} …"):
                proposed, line = proposal(files, layouts, columns, how, place, needed)
        except Exception:  # a proposal is an extra, and the error is reported anyway
            return Refused(after_conversion(error, done))
        same = line == command(Guess(layouts, columns), [], how)
        return Refused(after_conversion(error, done), "" if same else proposed)

    if propose_only:
        try:
            with waiting(f"looking at {named_files(files)} …"):
                proposed, _ = proposal(files, layouts, columns, how, place, needed)
        except Exception as error:
            told = isinstance(error, (ValueError, OSError))
            why = f": {in_shell(error)}" if told else ""
            raise ValueError(
                f"no command is found that reads {files[0].name}{why}"
            ) from error
        say(proposed)
        raise click.exceptions.Exit(0)
    try:
        with waiting(f"reading {named_files(files)} …"):
            data = frame(files, layouts, columns, **how)
        check_columns(data, needed)
        datetime_steps(data.index, "the time")
    except (ValueError, OSError) as error:
        raise otherwise(error) from error
    done |= data.attrs.pop("converted")
    # a header that names another unit is that of no converted column
    data.attrs["headers"] = {
        n: c
        for n, c in columns.items()
        if n not in done or named_unit(n, c) in (None, own_unit(n))
    }
    for line in data.attrs["notes"]:
        note(line)
    looks = unmapped(numeric(data)) if drivers else {}
    likely = {n: c for c, n in [*looks.items()][::-1] if n not in data}
    if likely:
        maps = [w for n, c in likely.items() for w in options_of(c, n, data[c])]
        what = ", ".join(f"{c!r} looks like {n}" for n, c in likely.items())
        note(
            f"{what}. Under another name a column is only a driver of unknown meaning; "
            f"if it is that, run again with {shell_words(maps)}"
        )
    return data, otherwise


def named_files(files: Sequence[Path]) -> str:
    """Files in a few words."""
    name = safe(files[0].name)
    return name if len(files) == 1 else f"{name} and {len(files) - 1} more"


@contextmanager
def or_propose(otherwise: Otherwise) -> Iterator[None]:
    """
    Add a proposal to the error of a fit that finds another unit or swapped columns.

    Parameters
    ----------
    otherwise : callable
        Makes of an error its refusal, see :func:`read`.

    Yields
    ------
    None

    Raises
    ------
    Refused
        With the command that may read the files, where one is found.
    """
    try:
        yield
    except (ForeignUnit, SwappedTemperatures) as error:
        raise otherwise(error) from error


def after_conversion(error: Exception, units: Iterable[str]) -> Exception | str:
    """An error that does not ask for a conversion that was made."""
    if not isinstance(error, ForeignUnit) or not error.columns:
        return error
    if not {*error.columns} <= {*units}:
        return error
    look = "looks" if len(error.columns) == 1 else "look"
    return (
        f"{' and '.join(error.columns)} still {look} to be in {error.unit} after the "
        f"conversion: {error.why}; give --no-unit-check if that is right"
    )


def is_data_set(files: Sequence[Path]) -> bool:
    """
    Whether files follow each other, as a folder, a pattern or some of one kind.

    Parameters
    ----------
    files : sequence of Path
        Files, or one folder or pattern.

    Returns
    -------
    bool
        True for a folder, a pattern, or several Parquet files with the same columns.
    """
    if len(files) == 1:
        return files[0].is_dir() or glob.has_magic(str(files[0]))
    if any(file.suffix.lower() not in PARQUET for file in files):
        return False
    columns = {
        tuple(parquet_file(str(file), None).schema_arrow.names) for file in files
    }
    return len(columns) == 1


def opened_parquet(files: Sequence[Path], options: dict[str, Any]) -> ParquetRecord:
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
    with waiting(f"looking at the parts of {named_files(files)} …"):
        return open_parquet(data, renames, **times, **how)


def in_their_days(
    data: pd.DataFrame, lon: float | None, zones: Sequence[str]
) -> pd.DataFrame:
    """
    UTC times in the standard time of their longitude, with a note, if no zone is given.

    Parameters
    ----------
    data : DataFrame
        Record with a DatetimeIndex.
    lon : float or None
        Longitude, positive east. [°]
    zones : sequence of str
        Zones of the files that are given; empty if none is.

    Returns
    -------
    DataFrame
        All rows with local times; the frame itself without a longitude, with a zone,
        or if its times are not in UTC.
    """
    local = in_local_days(data, lon, zones)
    if local is not data:
        index = pd.DatetimeIndex(local.index)
        note(
            f"the times are instants; days and hours are those of {index.tz}, by --lon"
        )
    return local


def check_partners(options: Mapping[str, Any]) -> None:
    """Refuse half a place."""
    for pair in (("lat", "lon"), ("tilt", "azimuth")):
        given = [name for name in pair if options[name] is not None]
        if len(given) == 1:
            (other,) = set(pair) - set(given)
            raise ValueError(f"--{given[0]} needs --{other}, too")


def site_in(index: pd.DatetimeIndex, place: Mapping[str, Any]) -> dict[str, Any]:
    """The site of a record, from the options of its place."""
    fixed = (place[name] for name in PLACE[:4])
    site = site_of(index, *fixed, **{name: place[name] for name in TRACKER})
    checked_place(**site)
    return site


def prepared_files(
    files: Sequence[Path], options: dict[str, Any], sun: bool = False
) -> dict[str, Any]:
    """
    What a fit takes of Parquet files that follow each other, or a loop.

    Parameters
    ----------
    files : sequence of Path
    options : dict
        Options of the command; those of reading are taken out of it.
    sun : bool, default False
        Whether the place counts, as for a loop.

    Returns
    -------
    dict
        Arguments: ``record``, ``effects``, ``fixed``, ``holdout``, of a loop ``site``,
        and the other options.
    """
    check_partners(options)
    how = options.pop("transposition"), options.pop("stand_ins")
    settings, days = settings_of(options.pop("settings")), options.pop("holdout")
    place = {name: options.pop(name) for name in PLACE}
    for name, value in place.items():
        if value is not None and not (sun or how[0]):
            raise ValueError(
                f"--{name.replace('_', '-')} does not go with Parquet files that "
                "follow each other: the sun's place is found for files that are read "
                "as a whole"
            )
    effects, fixed = effects_of(options.pop("effects"), settings), options.pop("fix")
    record = opened_parquet(files, options)
    start, end = (time.tz_localize(None).normalize() for time in record.ends)
    site = site_in(pd.DatetimeIndex(record.ends), place)
    if sun:
        options |= {"site": site, "transposition": how[0], "stand_ins": how[1]}
    elif any(how):
        with waiting(f"looking at the light in {named_files(files)} …"):
            instead = Replacements.of_arguments(*how)
            record, _ = instead.of_files(record, checked_place(**site), Limits())
    return options | {
        "record": record,
        "effects": effects,
        "fixed": fixed_coefficients(fixed) or None,
        "holdout": days_of(days, pd.date_range(start, end)),
    }


def frame_and_arguments(
    files: Sequence[Path], options: dict[str, Any], drivers: bool = False
) -> tuple[pd.DataFrame, dict[str, Any], Otherwise]:
    """
    The frame, and what a fit or a loop takes; all that is wrong is refused here.

    Parameters
    ----------
    files : sequence of Path
    options : dict
        Options of the command; those of reading are taken out of it.
    drivers : bool, default False
        Whether further columns count, so that likely ones are proposed.

    Returns
    -------
    DataFrame
        In the package's names.
    dict
        Arguments of the fit or the loop: ``effects``, ``fixed``, ``holdout``, ``site``
        and the other options.
    callable
        Makes of an error its refusal, as that of `read`.
    """
    check_partners(options)
    settings = settings_of(options.pop("settings"))
    effects = effects_of(options.pop("effects"), settings)
    fixed = fixed_coefficients(options.pop("fix"))
    days, zones = options.pop("holdout"), options["tz"]
    how = options.get("transposition"), options.get("stand_ins", ())
    needed = needed_by(options["model"], *how)
    data, otherwise = frame_of_files(files, options, drivers, needed)
    place = {name: options.pop(name) for name in PLACE}
    data = in_their_days(data, place["lon"], zones)
    index = pd.DatetimeIndex(data.index)
    options |= {
        "effects": effects,
        "fixed": fixed or None,
        "holdout": days_of(days, index),
        "site": site_in(index, place),
    }
    return data, options, otherwise
