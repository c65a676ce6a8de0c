"""T98 of IEC TS 63126: the temperature that a module exceeds in 2 % of a year."""

from collections.abc import Iterator
from typing import Any

import numpy as np
import pandas as pd
from scipy.stats import t as student

from pvlib_fem._record.checks import usual_step
from pvlib_fem._record.column_names import with_aliases
from pvlib_fem._statistics.clusters import calendar_weeks
from pvlib_fem._statistics.weekly_sums import effective_number
from pvlib_fem._thermal_parameters.given_record import Measured
from pvlib_fem._thermal_parameters.parameter_rows import LEVEL, Row
from pvlib_fem._thermal_parameters.steady_parameters import (
    NO_ERROR,
    Steady,
    joined_notes,
)

SHARE = 0.98
WEATHER = ("poa_global", "temp_air", "wind_speed")
YEAR = 365.25  # days
WHOLE = 0.9  # least share of a year's time with data
FEWEST_YEARS = 3
FEWEST_WEEKS = 8
#: upper limits of T98 [°C] and the classes of modules for them
LEVELS = {70.0: "no level needed", 80.0: "Level 1", 90.0: "Level 2"}
SOURCE = "IEC TS 63126; levels as pvdeg.standards has them"
EQUATION = "98th percentile of T over all hours of a year, nights included"
GAPS = "{} for {:.0f} % of its time, and T98 is of all hours, nights included"
NO_YEAR = (
    f"needs a record of {FEWEST_YEARS} whole years, or typical_year with the weather "
    "in the plane of the modules"
)


def hottest_rows(
    measured: Any, why: str, steady: Steady, typical_year: Any
) -> Iterator:
    """
    Rows of T98 of the record and of a typical year.

    Parameters
    ----------
    measured : Measured or None
    why : str
        Why there is no record.
    steady : Steady
    typical_year : DataFrame or None
        Weather of a year, with ``poa_global``.

    Yields
    ------
    Row
    """
    like: dict[str, Any] = dict(of="module", equation=EQUATION, source=SOURCE)
    columns, years = dict(value=np.nan, note=why), []
    if measured is not None:
        columns, years = t98_of_record(measured)
    yield Row("T98", "of the record", unit="°C", **columns, **like)
    if typical_year is not None:
        columns = t98_of_weather(steady, typical_year)
    elif measured is not None and len(years) >= FEWEST_YEARS:
        columns = t98_of_years(years)
    else:
        columns = dict(value=np.nan, note=NO_YEAR)
    yield Row("T98", "of a typical year", unit="°C", **columns, **like)


def t98_of_record(measured: Measured) -> Any:
    """T98 of all rows with Woodruff's range by weeks, and T98 of each whole year."""
    module = measured.series("temp_module")
    kept = module.notna().to_numpy()
    module, dates = module[kept], measured.dates[kept]
    value = float(module.quantile(SHARE))
    days = np.ptp(dates) + 1
    share = len(module) * measured.step / (days * 86400.0)
    if share < WHOLE:
        note = GAPS.format("the record has module temperatures", 100 * share)
        return dict(value=np.nan, note=note), []
    note, span, error = module_class_note(value), (np.nan, np.nan), np.nan
    if days < WHOLE * YEAR:
        note = f"of {days} days and not of a year; {note}"
    at, draws = share_error(module.to_numpy() > value, dates)
    if np.isfinite(at):
        reach = student.ppf(0.5 + LEVEL / 2, max(draws - 1.0, 1.0)) * at
        ends = SHARE + np.array([-at, at]), SHARE + np.array([-reach, reach])
        (low, high), span = (
            module.quantile(np.clip(one, 0.0, 1.0)).to_numpy() for one in ends
        )
        error = (high - low) / 2.0
    else:
        note = f"no error: it needs {FEWEST_WEEKS} weeks; {note}"
    columns = dict(value=value, stderr=error, span=tuple(map(float, span)), note=note)
    return columns, whole_years(measured, module, dates)


def share_error(above: np.ndarray, dates: np.ndarray) -> tuple[float, float]:
    """
    Standard error of the share of rows above a temperature, and effective weeks.

    The weather of a week is one independent draw about a seasonal mean of two
    harmonics.
    """
    weeks = pd.Series(above).groupby(calendar_weeks(dates)).agg(["sum", "size"])
    if len(weeks) < FEWEST_WEEKS:
        return np.nan, np.nan
    rows, phase = weeks["size"].to_numpy(), 2.0 * np.pi * 7.0 * weeks.index / YEAR
    waves = [f(n * phase) for n in (1, 2) for f in (np.cos, np.sin)]
    season = np.transpose([np.ones(len(weeks)), *waves]) * rows[:, None]
    season_coefficients, _, rank, _ = np.linalg.lstsq(season, weeks["sum"], rcond=None)
    squares = (weeks["sum"].to_numpy() - season @ season_coefficients) ** 2
    squares *= len(weeks) / max(len(weeks) - rank, 1)
    if not squares.sum() > 0.0:
        return np.nan, np.nan
    # hot hours are in a few weeks
    draws = effective_number(squares)
    return float(np.sqrt(squares.sum()) / rows.sum()), draws


def whole_years(measured: Measured, module: pd.Series, dates: np.ndarray) -> list:
    """T98 of each complete year, counted from the record's first day."""
    number = np.floor((dates - dates[0]) / YEAR).astype(int)
    full = WHOLE * YEAR * 86400.0 / measured.step
    years = module.groupby(number)
    return [float(one.quantile(SHARE)) for _, one in years if len(one) >= full]


def t98_of_years(years: list) -> dict[str, Any]:
    """T98 of a typical year: the mean over the years of the record."""
    many, spread = len(years), np.std(years, ddof=1)
    return dict(
        value=float(np.mean(years)),
        stderr=float(spread / np.sqrt(many)),
        freedom=many - 1.0,
        note=f"mean of {many} years, whose own are {min(years):.1f} to "
        f"{max(years):.1f} °C",
    )


def t98_of_weather(steady: Any, weather: pd.DataFrame) -> dict[str, Any]:
    """T98 of a year of weather, modelled by the fit."""
    fit, model = steady.fit, steady.fit.thermal_model
    there = with_aliases(weather, (*model.usual, *model.drivers))

    def temperature(coefficients: dict) -> pd.Series:
        columns = {name: there.get(name) for name in WEATHER}
        columns |= {name: there[name] for name in model.drivers}
        if not steady.with_bias:
            coefficients = coefficients | {"bias": 0.0}
        return model.predict(coefficients=coefficients, **columns).dropna()

    def hottest(coefficients: dict) -> Any:
        return np.array([temperature(coefficients).quantile(SHARE)])

    known = temperature(fit.coefficients)
    # months of a typical year may be of different years
    days = pd.DatetimeIndex(weather.index).normalize().nunique()
    step = usual_step(weather.index)
    share = np.nan_to_num(len(known) * step / (days * 86400.0))
    if share < WHOLE:
        words = "the weather that was given has what the fit needs"
        return dict(value=np.nan, note=GAPS.format(words, 100 * share))
    value, (error,) = float(known.quantile(SHARE)), steady.error(hottest)
    note = f"by the fit, of the weather that was given; {module_class_note(value)}"
    if days < WHOLE * YEAR:
        note = f"of {days} days and not of a year; {note}"
    if not np.isfinite(error):
        note = joined_notes(note, NO_ERROR)
    return dict(value=value, stderr=error, freedom=fit.train_days - 1.0, note=note)


def module_class_note(value: float) -> str:
    """The required class of modules."""
    for most, words in LEVELS.items():
        if value <= most:
            return f"up to {most:g} °C: {words}"
    return f"above {most:g} °C: beyond Level 2"
