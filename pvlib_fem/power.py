"""Expected power of a plant from its own record, without its area."""

import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
import pandas as pd

from pvlib_fem._record.inputs import read

__all__ = ["PowerRelation", "expected_power", "fit_power"]

STANDARD = 1000.0  # W/m², of the power that a kWp is
BRIGHT = 100.0  # W/m², above which power is proportional to efficiency
FEWEST = 100  # bright rows with power
MOST = 20_000  # rows of a fit; more rows would not reduce its error
YEAR = 365.25  # days
#: temperature coefficient of power, between -0.0047 of standard and -0.0035 of premium
#: modules in PVWatts, and its bounds [1/K]
GAMMA, GAMMAS = -0.004, (-0.008, 0.0)
OWNS = (0.0, 50.0)  # W/m², bounds of the irradiance lost to inverter and low light
#: prior standard deviations: of the temperature coefficient [1/K], of the irradiance
#: lost to inverter and low light [W/m²], and, both in logarithms, of each harmonic of
#: the year and of the change from year to year
PRIOR = {"gamma": 0.001, "own": 20.0, "season": 0.1, "year": 0.05}
CUT = 4.685  # spreads beyond which a row has no weight (Tukey's bisquare)
NEAR = 3.0  # spreads within which rows determine the spread
NORMAL = 1.4826  # standard deviation over median absolute deviation
LEAST_SPREAD = 0.005  # of a logarithm: no two instruments agree better
TURNS, STILL = 50, 1e-6  # steps of the search at most, and the step that ends it
AT_LIMIT = 0.02  # relative distance within which a row is at the limit
PILE = 4.0  # least ratio of rows at the limit to rows in an equal range below
ABOVE = 0.02  # largest ratio of rows above the limit to rows at the limit


@dataclass(frozen=True)
class PowerRelation:
    r"""
    Power of a module or a plant by irradiance and module temperature.

    .. math::

        P = \min\bigl(\mathrm{limit},\; s(t)\,(G - \mathrm{own})\,
        (1 + \gamma\,(T_m - 25\,°C))\bigr)

    This is PVWatts [1]_ with a scale in place of area and efficiency. The logarithm of
    the scale is linear between dates one year apart and has two harmonics of the year.

    Attributes
    ----------
    days : tuple of float
        Dates of ``levels``, since 1970-01-01. [days]
    levels : tuple of float
        Logarithm of power per irradiance at 25 °C. [unit of power per W/m²]
    season : tuple of float
        Cosine and sine of one and of two cycles a year in that logarithm.
    gamma : float
        Temperature coefficient of power. [1/K]
    own : float
        Irradiance below which no power is fed, because of the inverter's own
        consumption and losses at low light. [W/m²]
    limit : float
        Power at which the inverter clips; infinite without a limit. [unit of power]
    spread : float
        Relative standard deviation of the rows that follow the relation. [-]

    References
    ----------
    .. [1] A. P. Dobos, "PVWatts Version 5 Manual", NREL/TP-6A20-62641 (2014).
    """

    days: tuple[float, ...]
    levels: tuple[float, ...]
    season: tuple[float, ...]
    gamma: float
    own: float
    limit: float
    spread: float

    def __format__(self, spec: str) -> str:
        """Digits that tell it from others, since the name of a driver has them."""
        return f"{zlib.crc32(repr(self).encode()):08x}"

    @property
    def usual(self) -> float:
        """Mean of the scale over the dates. [unit of power per W/m²]"""
        return float(np.exp(np.mean(self.levels)))

    @property
    def nominal(self) -> float:
        """Power at 1000 W/m² and 25 °C, also above the limit. [unit of power]"""
        return self.usual * (STANDARD - self.own)

    def scale(self, day: Any) -> np.ndarray:
        """Power per irradiance at 25 °C by day since 1970-01-01."""
        columns = seasonal(np.asarray(day, dtype=float))
        season = columns @ np.array(self.season)
        return np.exp(np.interp(day, self.days, self.levels) + season)

    def expected(self, poa_global: Any, temp_module: Any, day: Any) -> np.ndarray:
        """
        Expected power of rows.

        Parameters
        ----------
        poa_global : array
            [W/m²]
        temp_module : array
            [°C]
        day : array
            Time since 1970-01-01. [days]

        Returns
        -------
        array
            Expected power in the unit of the fitted power.
        """
        light = np.maximum(np.asarray(poa_global, dtype=float) - self.own, 0.0)
        warm = 1.0 + self.gamma * (np.asarray(temp_module, dtype=float) - 25.0)
        return np.minimum(self.scale(day) * light * np.maximum(warm, 0.0), self.limit)

    def light(self, power: Any, temp_module: Any, day: Any) -> np.ndarray:
        """
        Irradiance at which a plant gives a power; 0 for no power.

        Parameters
        ----------
        power : array
            Power in the unit of the fitted power.
        temp_module, day : array
            See :meth:`expected`.

        Returns
        -------
        array
            [W/m²]
        """
        warm = 1.0 + self.gamma * (np.asarray(temp_module, dtype=float) - 25.0)
        power = np.asarray(power, dtype=float)
        light = power / (self.scale(day) * np.maximum(warm, 0.1)) + self.own
        return np.where(power <= 0.0, 0.0, light)

    def content(self) -> dict[str, Any]:
        """The attributes for a file, in which no number may be infinite."""
        attributes = {
            n: list(v) if isinstance(v, tuple) else v for n, v in vars(self).items()
        }
        return attributes | {"limit": self.limit if np.isfinite(self.limit) else None}

    @classmethod
    def stored(cls, content: Mapping[str, Any]) -> Self:
        """The relation of a part of a file."""
        limit = content["limit"]
        return cls(
            days=tuple(map(float, content["days"])),
            levels=tuple(map(float, content["levels"])),
            season=tuple(map(float, content["season"])),
            gamma=float(content["gamma"]),
            own=float(content["own"]),
            limit=np.inf if limit is None else float(limit),
            spread=float(content["spread"]),
        )


def expected_power(
    poa_global: pd.Series, temp_module: pd.Series, power: pd.Series
) -> pd.Series:
    """
    Expected power of a plant, by the relation that most of its rows follow.

    Parameters
    ----------
    poa_global : Series
        Irradiance in the plane of the array, with a DatetimeIndex. [W/m²]
    temp_module : Series
        [°C]
    power : Series
        DC or AC power of a module or a plant, in any unit.

    Returns
    -------
    Series
        Power in the unit of ``power``; NaN where irradiance or temperature is missing.

    See Also
    --------
    fit_power : the relation itself.
    """
    relation = fit_power(poa_global, temp_module, power)
    day = days_of(power.index)
    expected = relation.expected(poa_global, temp_module, day)
    return pd.Series(expected, power.index, name="expected_power")


def fit_power(
    poa_global: pd.Series, temp_module: pd.Series, power: pd.Series
) -> PowerRelation:
    """
    Fit the relation of a plant's power to irradiance and module temperature.

    The fit is robust: up to a third of the rows may have an outage, snow, curtailment
    or a cover [1]_. Rows at a limit have no weight.

    Parameters
    ----------
    poa_global, temp_module, power : Series
        See :func:`expected_power`.

    Returns
    -------
    PowerRelation

    Raises
    ------
    ValueError
        If fewer than 100 rows above 100 W/m² have power, or power below its limit.

    References
    ----------
    .. [1] A. E. Beaton and J. W. Tukey, "The Fitting of Power Series, Meaning
       Polynomials, Illustrated on Band-Spectroscopic Data", Technometrics 16, 147
       (1974), :doi:`10.1080/00401706.1974.10489171`.
    """
    columns = {"poa_global": poa_global, "temp_module": temp_module, "power": power}
    for name, column in columns.items():
        if not isinstance(getattr(column, "index", None), pd.DatetimeIndex):
            raise ValueError(
                f"expected power has a season, and {name} has no DatetimeIndex; give "
                "it as a Series with one"
            )
    inputs = read(columns, purpose="expected power")
    poa, temp, given = (inputs[name] for name in columns)
    return fit_power_arrays(poa, temp, given, days_of(inputs.index))


def days_of(index: Any) -> pd.Index:
    """
    Time since 1970-01-01 by the record's own clock. [days]

    Parameters
    ----------
    index : DatetimeIndex
        With or without a zone.

    Returns
    -------
    Index of float, shape (rows,)
    """
    return (index.tz_localize(None) - pd.Timestamp(0)) / pd.Timedelta("1D")


def seasonal(day: np.ndarray) -> np.ndarray:
    """One and two cycles a year, as columns."""
    angle = 2.0 * np.pi * day / YEAR
    cycles = [wave(n * angle) for n in (1, 2) for wave in (np.cos, np.sin)]
    return np.stack(cycles, axis=-1)


def fit_power_arrays(
    poa: np.ndarray, temp: np.ndarray, power: np.ndarray, day: np.ndarray | pd.Index
) -> PowerRelation:
    """
    The relation of a plant, as in :func:`fit_power`, by arrays.

    Parameters
    ----------
    poa : array, shape (rows,)
        Irradiance in the plane of the array. [W/m²]
    temp : array, shape (rows,)
        Module temperature. [°C]
    power : array, shape (rows,)
        DC or AC power, in any unit.
    day : array or Index, shape (rows,)
        Time since 1970-01-01. [days]

    Returns
    -------
    PowerRelation

    Raises
    ------
    ValueError
        If fewer than 100 rows above 100 W/m² have power, or power below its limit.
    """
    day = np.asarray(day, dtype=float)
    rows = (poa > BRIGHT) & (power > 0.0) & np.isfinite(temp + power)
    if (there := int(rows.sum())) < FEWEST:
        below = int(((poa > BRIGHT) & (power < 0.0)).sum())
        remedy = "give a longer record"
        if below >= FEWEST:
            remedy = f"in {below} rows it is negative: turn its sign"
        raise ValueError(
            f"power is there in {there} rows above {BRIGHT:g} W/m², and {FEWEST} are "
            f"needed for the expected power of a plant; {remedy}"
        )
    limit = limit_of(power[rows])
    if (below := int((power[rows] < (1.0 - AT_LIMIT) * limit).sum())) < FEWEST:
        raise ValueError(
            f"power is below {limit:g}, at which it stays, in {below} rows above "
            f"{BRIGHT:g} W/m², and {FEWEST} are needed for the expected power of a "
            "plant; give a longer record, or power that is not stuck"
        )
    rows = np.flatnonzero(rows)[:: -(-there // MOST)]
    return Search.from_rows(poa[rows], temp[rows], power[rows], day[rows]).run(limit)


def limit_of(power: np.ndarray) -> float:
    """The power at which rows pile up, with almost none above; infinite without one."""
    values = np.sort(power)
    starts = values * (1.0 - AT_LIMIT)
    first, below = (
        np.searchsorted(values, starts * (1.0 - AT_LIMIT) ** n) for n in (0, 1)
    )
    # rows in the window that ends at each value, in one below it, and above it
    upto = np.searchsorted(values, values, side="right")
    held, under, above = upto - first, first - below, len(values) - upto
    piled = (held > PILE * np.maximum(under, 1)) & (above <= ABOVE * held)
    piled &= held >= FEWEST / 5
    if not piled.any():
        return np.inf
    best = int(np.argmax(np.where(piled, held, 0)))
    return float(np.median(values[first[best] : upto[best]]))


@dataclass(frozen=True, eq=False)
class Search:
    """Robust fit of bright rows: log power per irradiance by scale and temperature."""

    light: np.ndarray
    warm: np.ndarray  # above 25 °C
    power: np.ndarray
    ratio: np.ndarray  # logarithm of power per irradiance
    table: np.ndarray  # columns of levels and season
    days: np.ndarray  # dates of the levels
    daily: float  # rows per day; rows of one day are not independent

    @classmethod
    def from_rows(
        cls, poa: np.ndarray, temp: np.ndarray, power: np.ndarray, day: np.ndarray
    ) -> "Search":
        first, last = day.min(), day.max()
        years = (last - first) / YEAR
        knots = np.linspace(first, last, int(np.ceil(years)) + 1 if years >= 1 else 1)
        hats = [np.interp(day, knots, one) for one in np.eye(len(knots))]
        table = np.column_stack([*hats, seasonal(day)])
        daily = len(day) / len(np.unique(np.floor(day)))
        ratio = np.log(power / poa)
        return cls(poa, temp - 25.0, power, ratio, table, knots, daily)

    def run(self, limit: float) -> PowerRelation:
        """The relation that most rows follow, found from the shortest half of them."""
        known, gamma, own = np.zeros(self.table.shape[1]), GAMMA, 0.0
        rest = self.log_residual(known, gamma, own)
        level = densest(rest)
        known[: len(self.days)] = level
        spread = max(NORMAL * np.median(np.abs(rest - level)), LEAST_SPREAD)
        # change of a logarithm per unit of each parameter, at 30 K and 500 W/m²
        units = np.append(np.ones(len(known)), [30.0, 1.0 / 500.0])
        for _ in range(TURNS):
            rest = self.log_residual(known, gamma, own)
            free = self.is_free(rest, limit)
            near = free & (np.abs(rest) < NEAR * spread)
            spread = max(NORMAL * np.median(np.abs(rest[near])), LEAST_SPREAD)
            weight = np.clip(1.0 - (rest / (CUT * spread)) ** 2, 0.0, None) ** 2
            step = self.step(rest, weight * free, spread, known, gamma, own)
            known = known + step[:-2]
            gamma = float(np.clip(gamma + step[-2], *GAMMAS))
            own = float(np.clip(own + step[-1], *OWNS))
            if np.abs(step * units).max() < STILL:
                break
        levels, season = known[: len(self.days)], known[len(self.days) :]
        return PowerRelation(
            tuple(map(float, self.days)),
            tuple(map(float, levels)),
            tuple(map(float, season)),
            gamma,
            own,
            limit,
            float(spread),
        )

    def log_residual(self, known: np.ndarray, gamma: float, own: float) -> np.ndarray:
        """Logarithm of measured over expected power."""
        warm = np.log(np.maximum(1.0 + gamma * self.warm, 0.1))
        return self.ratio - self.table @ known - warm - np.log1p(-own / self.light)

    def is_free(self, rest: np.ndarray, limit: float) -> np.ndarray:
        """Mask of rows with measured and expected power below the limit."""
        most = np.maximum(self.power, self.power * np.exp(-rest))
        return most < (1.0 - AT_LIMIT) * limit

    def step(
        self,
        rest: np.ndarray,
        weight: np.ndarray,
        spread: float,
        known: np.ndarray,
        gamma: float,
        own: float,
    ) -> np.ndarray:
        """Step of weighted least squares with the prior."""
        columns = np.column_stack(
            [
                self.table,
                self.warm / np.maximum(1.0 + gamma * self.warm, 0.1),
                -1.0 / (self.light - own),
            ]
        )
        # rows of low irradiance have no smaller error in W than bright ones
        weight = weight * self.light / self.light.mean() / (self.daily * spread**2)
        levels, size = len(self.days), columns.shape[1]
        prior = np.zeros((size, size))
        turns = np.diff(np.eye(levels), axis=0)
        prior[:levels, :levels] = turns.T @ turns / PRIOR["year"] ** 2
        sizes = [PRIOR["season"]] * (size - levels - 2) + [PRIOR["gamma"], PRIOR["own"]]
        prior[range(levels, size), range(levels, size)] = 1.0 / np.square(sizes)
        away = np.append(known, [gamma - GAMMA, own])
        whole = (columns.T * weight) @ columns + prior
        return np.linalg.solve(whole, columns.T @ (weight * rest) - prior @ away)


def densest(values: np.ndarray) -> float:
    """Median of the shortest interval with half of the values."""
    values = np.sort(values)
    half = len(values) // 2
    start = int(np.argmin(values[half:] - values[: len(values) - half]))
    return float(np.median(values[start : start + half + 1]))
