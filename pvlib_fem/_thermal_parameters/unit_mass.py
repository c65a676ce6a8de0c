"""
The unit mass of Prilliman's model, for pvlib and PVsyst.

The rate of the model, a0 + a1 WS + a2 m + a3 WS m, falls with the mass m. At 20 kg/m²
it is zero in still air, so the model is the mean of the last 20 min for any module. At
a larger mass, older temperatures have more weight than newer ones. So a mass of
20 kg/m² or more is neither used nor returned.
"""

import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import pandas as pd
import pvlib
from scipy.optimize import minimize_scalar
from scipy.stats import t as student

from pvlib_fem._record.checks import instants, usual_step
from pvlib_fem._statistics.clusters import FEWEST_DAYS, cluster_sums
from pvlib_fem._statistics.leastsquares import orthonormal
from pvlib_fem._thermal_parameters.given_record import Measured
from pvlib_fem._thermal_parameters.parameter_rows import LEVEL, Row

HEAVIEST = 20.0  # kg/m², mass at which the rate is zero in still air
WINDOW = 1200.0  # s, window of Prilliman's mean
FEWEST = 3  # samples that pvlib needs to detect an even step
CELLS = 5_000_000  # size of pvlib's matrices, 40 MB each
FINEST = 60.0  # s; at finer steps one evaluation by pvlib takes 10 s per day
FINE = 5e-3  # kg/m², tolerance of the search
EDGE = 0.02  # kg/m², distance from an end of the range that counts as the end

RATE = (
    "T = mean of T_steady over the last 20 min, weights exp(-P age), P = 0.0046 + "
    "0.00046 WS - (0.00023 + 0.000016 WS) unit_mass [1/s]"
)
SOURCE = (
    "M. Prilliman et al. (2020), doi:10.1109/JPHOTOV.2020.2992351, Eqs. 7 and 9, as "
    "pvlib.temperature.prilliman; PVsyst 8.1 help, Transient thermal model"
)
MODELS = {
    "prilliman": "RMSE of the steady model under Prilliman's mean, both fitted",
    "this fit": "RMSE of the fit",
    "without memory": "RMSE of the fit's steady temperature",
}
TOO_SLOW = (
    "the best mass would be 20 kg/m² or more, where Prilliman's rate is zero or "
    "negative in still air: this module is slower than the model can describe. PVsyst "
    "uses its default mass there"
)
TOO_QUICK = (
    "the best mass would be zero or less: this module, or its sensor, is faster than "
    "the model can describe"
)
WORSE = (
    "on held-out days worse than no memory: the model takes no part of the step "
    "itself; use a finer record"
)
NO_TEST = "no days are held out"
NO_WIND = "needs wind, which nobody measured"


def prilliman_mean(
    steady: pd.DataFrame, wind_speed: pd.Series, unit_mass: float
) -> pd.DataFrame:
    """
    Smooth steady temperature by Prilliman's moving mean, each even part separately.

    pvlib's function [1]_ refuses gaps, and its memory grows with the number of samples
    times the samples of the window. Here even parts are separated by a window of NaN,
    which pvlib ignores, and smoothed in blocks of rows.

    Parameters
    ----------
    steady : Series or DataFrame
        Steady temperature; several columns are smoothed with equal weights. [°C]
    wind_speed : Series
        [m/s]
    unit_mass : float
        Mass of the module divided by its area, 0 to below 20. [kg/m²]

    Returns
    -------
    Series or DataFrame
        Smoothed temperature; a copy of the input for steps of 20 min or more. [°C]

    Raises
    ------
    ValueError
        If the mass is 20 kg/m² or more, where the rate is zero or negative in still
        air, or negative.

    References
    ----------
    .. [1] M. Prilliman et al., "Transient Weighted Moving-Average Model of
       Photovoltaic Module Back-Surface Temperature", IEEE J. Photovoltaics 10, 1053
       (2020). :doi:`10.1109/JPHOTOV.2020.2992351`, as in
       :func:`pvlib.temperature.prilliman`.
    """
    if not 0.0 <= unit_mass < HEAVIEST:
        raise ValueError(
            f"unit_mass = {unit_mass:g} kg/m² must be from 0 to below {HEAVIEST:g}: "
            "from there on Prilliman's rate is zero or negative in still air, and old "
            "temperatures weigh more than new ones"
        )
    step = usual_step(steady.index)
    if not step < WINDOW:
        return steady.copy()
    behind = int(WINDOW // step)
    seconds = np.diff(instants(steady.index)) / np.timedelta64(1, "s")
    begins = np.append(True, np.abs(seconds - step) > 1e-6 * step)
    place = np.arange(len(begins)) + behind * np.cumsum(begins)
    values = steady.to_numpy().reshape(len(begins), -1).T
    # concatenated columns, with a window of NaN before each even part
    apart = np.full((len(values), place[-1] + 1), np.nan)
    apart[:, place] = values
    wind = np.zeros(place[-1] + 1)
    wind[place] = wind_speed
    answer = moving_mean(
        apart.ravel(), np.tile(wind, len(values)), step, behind, unit_mass
    )
    answer = answer.reshape(apart.shape)[:, place]
    answer[:, begins] = values[:, begins]  # no row is before these
    if isinstance(steady, pd.Series):
        return pd.Series(answer[0], steady.index, name=steady.name)
    return pd.DataFrame(answer.T, steady.index, steady.columns)


def moving_mean(
    steady: np.ndarray, wind: np.ndarray, step: float, behind: int, unit_mass: float
) -> np.ndarray:
    """Pvlib's function on even steps, applied to blocks of rows."""
    answer, rows = np.empty(len(steady)), max(CELLS // behind, behind, FEWEST)
    for first in range(0, len(steady), rows):
        part = slice(max(first - behind, 0), first + rows)
        few = max(FEWEST - len(steady[part]), 0)  # pvlib infers steps from three
        given = np.pad(steady[part], (0, few), constant_values=np.nan)
        times = pd.date_range(
            "2000-01-01", periods=len(given), freq=pd.Timedelta(seconds=step)
        )
        winds = pd.Series(np.pad(wind[part], (0, few)), times)
        # pvlib divides by zero if a window is empty, and uses a call for which newer
        # pandas warns
        with warnings.catch_warnings(), np.errstate(invalid="ignore"):
            warnings.filterwarnings("ignore", "A future version of pandas")
            smooth = pvlib.temperature.prilliman(
                pd.Series(given, times), winds, unit_mass
            ).to_numpy()
        answer[first : first + rows] = smooth[: len(smooth) - few][first - part.start :]
    return answer


def unit_mass_rows(measured: Any, why: str) -> Iterator:
    """
    Rows of the unit mass, and of the errors on held-out days.

    Parameters
    ----------
    measured : Measured or None
    why : str
        Why there is no record.

    Yields
    ------
    Row
    """
    best_mass, scores, note = None, {}, why
    if measured is not None and "wind_speed" in measured.record.absent:
        measured, note = None, NO_WIND
    if measured is not None:
        given = PrillimanFit(measured)
        best_mass, note = given.best_mass()
        scores = given.scores(best_mass)
        worst = scores.get("prilliman", (0.0,))[0] > scores["without memory"][0]
        note = "; ".join(filter(None, [note, WORSE * worst]))
    mass = best_mass or Mass(np.nan, np.nan, np.inf)
    reach = student.ppf(0.5 + LEVEL / 2, max(mass.days - 1.0, 1.0)) * mass.stderr
    yield Row(
        "prilliman",
        "unit_mass",
        mass.value,
        "kg/m²",
        mass.stderr,
        of="module",
        equation=RATE,
        source=SOURCE,
        note=note,
        span=(max(mass.value - reach, 0.0), min(mass.value + reach, HEAVIEST)),
    )
    for name, words in MODELS.items():
        score, spread, days = scores.get(name, (np.nan, np.nan, np.inf))
        why_not = note or NO_TEST
        if np.isfinite(score):
            why_not = "" if np.isfinite(spread) else few_days_note(days)
        yield Row(
            "held-out error",
            name,
            score,
            "K",
            spread,
            days - 1.0,
            of="module",
            equation=words,
            source="this package",
            note=why_not,
        )


def few_days_note(days: int) -> str:
    return f"no error: {days} days, and it needs {FEWEST_DAYS}"


@dataclass(frozen=True, eq=False)
class Mass:
    """A unit mass, its standard error, the fitted days, and the temperature."""

    value: float
    stderr: float
    days: float
    modelled: pd.Series | None = None


@dataclass(frozen=True, eq=False)
class PrillimanFit:
    """Fit of Prilliman's model to a record."""

    measured: Measured

    @cached_property
    def table(self) -> pd.DataFrame:
        """Table of the record, as means over a minute if steps are shorter."""
        own, record = self.measured, self.measured.record
        fit, steady, slopes = own.modelled
        table = pd.DataFrame(
            {
                "fit": fit,
                "steady": steady,
                "wind_speed": record["wind_speed"],
                "measured": record["temp_module"],
                "train": own.counts & ~own.out,
                "test": own.counts & own.out,
                "date": own.dates,
                **{(name,): slope for name, slope in slopes.items()},
            },
            record.index,
        )
        if own.step < FINEST:
            table = table.astype(float).resample(pd.Timedelta(seconds=FINEST)).mean()
            flags = {name: table[name] > 0.5 for name in ("train", "test")}
            table = table.assign(**flags, date=table["date"].ffill().round())
        return table[looked_at(table["train"] | table["test"])]

    @cached_property
    def slopes(self) -> list:
        """Names of the columns with slopes of the steady temperature."""
        return [name for name in self.table if isinstance(name, tuple)]

    def smoothed(self, unit_mass: float) -> list:
        """Steady temperature and its slopes, smoothed by Prilliman's mean."""
        columns = self.table[["steady", *self.slopes]]
        means = prilliman_mean(columns, self.table["wind_speed"], unit_mass)
        return [means[name] for name in columns]

    def fit_with_mass(
        self, unit_mass: float
    ) -> tuple[np.ndarray, pd.Series, pd.Series, np.ndarray]:
        """
        Fit the steady coefficients for a mass, linearised about those of the fit.

        The best coefficients of the heat balance and of this model differ slightly, and
        fixed ones would bias the mass. Returns the changes of the coefficients, the
        temperature, the residual on fitted rows, and the columns of the regression.
        """
        steady, *columns = self.smoothed(unit_mass)
        rest = (self.table["measured"] - steady)[self.fitted]
        matrix = np.transpose([column[self.fitted] for column in columns])
        kept = np.isfinite(matrix).all(axis=1) & rest.notna().to_numpy()
        moved, *_ = np.linalg.lstsq(matrix[kept], rest[kept], rcond=None)
        modelled = steady + sum(m * c for m, c in zip(moved, columns))
        return moved, modelled, rest[kept] - matrix[kept] @ moved, matrix[kept].T

    def temperature(self, moved: np.ndarray, unit_mass: float) -> pd.Series:
        """Temperature for a mass and changed coefficients. [°C]"""
        steady, *columns = self.smoothed(unit_mass)
        return steady + sum(m * c for m, c in zip(moved, columns))

    @cached_property
    def fitted(self) -> pd.Series:
        """Mask of complete rows of the fitted days."""
        return self.table["train"] & self.table.notna().all(axis=1)

    def cost(self, unit_mass: float) -> float:
        return float((self.fit_with_mass(unit_mass)[2] ** 2).mean())

    def best_mass(self) -> Any:
        """The best mass with its error, or None and the reason."""
        step = usual_step(self.table.index)
        if not step < WINDOW:
            return None, (
                f"steps of {step:g} s: the model is of steps below {WINDOW:g} s; use a "
                "finer record"
            )
        how = dict(bounds=(0.0, HEAVIEST), method="bounded", options={"xatol": FINE})
        unit_mass = minimize_scalar(self.cost, **how).x
        if unit_mass > HEAVIEST - EDGE:
            return None, TOO_SLOW
        if unit_mass < EDGE:
            return None, TOO_QUICK
        moved, modelled, residual, columns = self.fit_with_mass(unit_mass)
        dates = self.table["date"][residual.index].to_numpy().astype(int)
        days = len(np.unique(dates))
        if days < FEWEST_DAYS:
            return Mass(unit_mass, np.nan, days, modelled), few_days_note(days)
        ends = [
            self.temperature(moved, unit_mass + step) for step in (-EDGE / 2, EDGE / 2)
        ]
        slope = ((ends[1] - ends[0]) / EDGE)[residual.index].to_numpy()
        # without wind that varies, some coefficients depend on others
        others = orthonormal([*columns]).T
        covariance = cluster_sums([slope, *others], residual, dates).by_day()
        return Mass(unit_mass, float(np.sqrt(covariance[0, 0])), days, modelled), ""

    def scores(self, mass: Any) -> dict:
        """RMSE on held-out days, with standard errors. [K]"""
        table = self.table
        modelled = {"this fit": table["fit"], "without memory": table["steady"]}
        if mass is not None:
            modelled["prilliman"] = mass.modelled
        return {
            name: rms_of((table["measured"] - one)[table["test"]], table["date"])
            for name, one in modelled.items()
        }


def looked_at(rows: pd.Series) -> np.ndarray:
    """Mask of the given rows and of rows within the window before them."""
    behind = int(WINDOW // usual_step(rows.index)) + 1
    last = np.cumsum(rows.to_numpy())
    ahead = np.minimum(np.arange(len(rows)) + behind, len(rows) - 1)
    return rows.to_numpy() | (last[ahead] > last)


def rms_of(residual: pd.Series, dates: pd.Series) -> tuple:
    """A root mean square, its error by the jackknife over days, and the days."""
    squares = (residual**2).dropna()
    if squares.empty:
        return np.nan, np.nan, np.inf
    by_day = squares.groupby(dates[squares.index].to_numpy()).agg(["sum", "size"])
    total, days = by_day.sum(), len(by_day)
    value = float(np.sqrt(total["sum"] / total["size"]))
    if days < FEWEST_DAYS:
        return value, np.nan, days
    without = total - by_day
    spread = np.sqrt(without["sum"] / without["size"])
    square = (days - 1) / days * ((spread - spread.mean()) ** 2).sum()
    return value, float(np.sqrt(square)), days
