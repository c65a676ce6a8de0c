"""Errors of a modelled temperature: in K, in energy, and as a sensor's delay."""

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pandas as pd

from pvlib_fem._record.checks import as_numbers
from pvlib_fem._record.inputs import Inputs, read
from pvlib_fem.types import Numeric

__all__ = [
    "EnergyError",
    "delayed_sensor",
    "energy_error",
    "mae",
    "mbe",
    "rmse",
]

GAMMA = -0.0035  # 1/K, the paper's temperature coefficient of power
HOUR = 3600.0
LATE = range(60, 601, 60)  # s, the paper's delays
CLOSE = 0.1  # of a step, which a logger's clock may wander


def rmse(measured: Numeric, modelled: Numeric) -> float:
    """
    Root mean square of measured minus modelled temperature.

    Parameters
    ----------
    measured, modelled : numeric
        Temperatures, of one shape, or one of them a number; pairs with a NaN do not
        count. [°C]

    Returns
    -------
    float
        RMSE; NaN without a pair. [K]

    Raises
    ------
    ValueError
        If the lengths or indexes differ, one is a table, or a value is infinite.
    """
    return float(np.sqrt(mean_of(difference(measured, modelled) ** 2)))


def mae(measured: Numeric, modelled: Numeric) -> float:
    """
    Mean absolute difference of measured and modelled temperature.

    Parameters
    ----------
    measured, modelled : numeric
        Temperatures, as in :func:`rmse`. [°C]

    Returns
    -------
    float
        MAE; NaN without a pair. [K]

    Raises
    ------
    ValueError
        See :func:`rmse`.
    """
    return mean_of(np.abs(difference(measured, modelled)))


def mbe(measured: Numeric, modelled: Numeric) -> float:
    """
    Mean of measured minus modelled temperature, the paper's MBE.

    Its sign [1]_ makes it the bias that is *added* to the model.

    Parameters
    ----------
    measured, modelled : numeric
        Temperatures, as in :func:`rmse`. [°C]

    Returns
    -------
    float
        MBE, positive if the model is too cold; NaN without a pair. [K]

    Raises
    ------
    ValueError
        See :func:`rmse`.

    References
    ----------
    .. [1] B. Herteleer et al., "Investigating methods to improve photovoltaic
       thermal models at second-to-minute timescales", 2022, Eq. 28.
       :doi:`10.22541/au.166922866.68736478`
    """
    return mean_of(difference(measured, modelled))


@dataclass(eq=False)
class ErrorSums:
    """Running sums of errors, measured minus modelled, for the scores."""

    rows: int = 0
    sums: np.ndarray = field(default_factory=lambda: np.zeros(3))

    def add(self, error: np.ndarray) -> None:
        total = error.sum()
        if not np.isfinite(total):
            error = error[np.isfinite(error)]
            total = error.sum()
        self.rows += len(error)
        # not by BLAS, whose last bits depend on the number of threads
        self.sums += np.einsum("i,i", error, error), np.abs(error).sum(), total

    def scores(self, part: str) -> dict[str, float]:
        """RMSE, MAE and MBE; the name of each ends with the part of a record. [K]"""
        with np.errstate(invalid="ignore"):
            square, size, mean = self.sums / (self.rows or np.nan)
        values = {"rmse": np.sqrt(square), "mae": size, "mbe": mean}
        return {f"{score}_{part}": float(value) for score, value in values.items()}


def scores_of(error: Any, part: Any) -> Any:
    """
    RMSE, MAE and MBE of some errors. [K]

    Parameters
    ----------
    error : array, shape (rows,)
        Measured minus modelled temperature; NaN does not count. [K]
    part : str
        Part of the record, at the end of each name.

    Returns
    -------
    dict of float
        ``rmse_<part>``, ``mae_<part>`` and ``mbe_<part>``; NaN without rows.
    """
    tally = ErrorSums()
    tally.add(error)
    return tally.scores(part)


def new_error_sums() -> dict:
    """
    Running sums of the errors of one model, on fitting days and on test days.

    Returns
    -------
    dict of ErrorSums
        ``train`` and ``test``.
    """
    return {"train": ErrorSums(), "test": ErrorSums()}


def score_table(tallies: dict) -> pd.DataFrame:
    """
    A row of scores for each model.

    Parameters
    ----------
    tallies : dict of dict of ErrorSums
        From :func:`new_error_sums`, by name of the model.

    Returns
    -------
    DataFrame
        By model ``rmse_train``, ``mae_train``, ``mbe_train``, and the same for
        ``test``. [K]
    """
    rows = {
        name: {
            n: v for part, tally in parts.items() for n, v in tally.scores(part).items()
        }
        for name, parts in tallies.items()
    }
    return pd.DataFrame.from_dict(rows, orient="index")


def difference(measured: Any, modelled: Any) -> np.ndarray:
    columns = {"measured": measured, "modelled": modelled}
    same_rows(columns)
    measured, modelled = (
        as_numbers(name, column, column.index if isinstance(column, pd.Series) else ())
        for name, column in columns.items()
    )
    error = measured - modelled
    return error[np.isfinite(error)]


def same_rows(columns: dict) -> None:
    """Refuse columns that numpy would not pair row by row."""
    for name, column in columns.items():
        if np.ndim(column) > 1:
            raise ValueError(
                f"{name} has {np.ndim(column)} dimensions; give one column, for "
                "example data['temp_module']"
            )
    lengths = {name: len(c) for name, c in columns.items() if np.ndim(c)}
    if len(set(lengths.values())) > 1:
        raise ValueError(
            f"the lengths differ: {lengths}; give all columns the same rows"
        )
    indexes = [c.index for c in columns.values() if isinstance(c, pd.Series)]
    if any(not index.equals(indexes[0]) for index in indexes[1:]):
        raise ValueError("the series have different indexes; align them first")


def mean_of(values: np.ndarray) -> float:
    return float(values.mean()) if len(values) else np.nan


@dataclass(frozen=True)
class EnergyError:
    """Error of the modelled energy that temperature errors cause."""

    total: float  # sum of the absolute errors [kWh/kWp]
    over_estimate: float  # modelled too cold, energy too high: >= 0 [kWh/kWp]
    under_estimate: float  # modelled too hot, energy too low: <= 0 [kWh/kWp]
    insolation: float  # in the plane of the array [kWh/m²]

    @property
    def net(self) -> float:
        """Net error: over-estimate plus under-estimate. [kWh/kWp]"""
        return self.over_estimate + self.under_estimate

    @property
    def performance_ratio(self) -> float:
        """Total error of the performance ratio. [percentage points]"""
        return 100.0 * self.total / self.insolation if self.insolation else np.nan


def energy_error(
    poa_global: pd.Series | np.ndarray,
    measured: pd.Series | np.ndarray,
    modelled: pd.Series | np.ndarray,
    gamma: float = GAMMA,
    step: float | None = None,
) -> EnergyError:
    r"""
    Energy error of a modelled temperature, in total and by sign [1]_.

    .. math:: \Delta E = \sum_i G_i\,(T_{model} - T_{meas})_i\,\gamma\,\Delta t

    The total is the sum of absolute values over all samples. Samples with
    :math:`T_{model} < T_{meas}` over-estimate the energy; the others under-estimate it.

    Parameters
    ----------
    poa_global : Series or array
        Irradiance in the plane of the array. [W/m²]
    measured, modelled : Series or array
        Temperatures. [°C]
    gamma : float, default -0.0035
        Temperature coefficient of power. [1/K]
    step : float, optional
        Time step of arrays; a Series has its own. Each sample counts for the
        step before it, at most twice the median step. [s]

    Returns
    -------
    EnergyError

    Raises
    ------
    ValueError
        If there are no times or they are not sorted, the indexes differ, or a value is
        infinite.

    References
    ----------
    .. [1] B. Herteleer et al., "Investigating methods to improve photovoltaic
       thermal models at second-to-minute timescales", 2022, Eqs. 30 to 34.
       :doi:`10.22541/au.166922866.68736478`
    """
    columns = dict(poa_global=poa_global, measured=measured, modelled=modelled)
    inputs = read(columns, step, purpose="energy_error")
    too_hot = inputs["modelled"] - inputs["measured"]
    return energy_of(kilowatt_hours(inputs), too_hot, gamma)


def kilowatt_hours(inputs: Inputs) -> np.ndarray:
    """
    Irradiation of each row. [kWh/m²]

    Parameters
    ----------
    inputs : Inputs
        With ``poa_global``. [W/m²]

    Returns
    -------
    array, shape (rows,)
        Each row counts for the step before it, at most for two usual steps.
    """
    return inputs["poa_global"] / 1000.0 * row_hours(inputs)


def row_hours(inputs: Inputs) -> np.ndarray | float:
    """
    Time that each row stands for. [h]

    Parameters
    ----------
    inputs : Inputs

    Returns
    -------
    float or array, shape (rows,)
        One number where the steps are equal.
    """
    seconds = inputs.step
    if np.ndim(inputs.steps):  # the first row counts for a usual step
        seconds = np.minimum(inputs.steps * inputs.unit, 2.0 * inputs.step)
        seconds[0] = inputs.step
    return seconds / HOUR


def energy_of(
    kilowatt_hours: np.ndarray, too_hot: np.ndarray, gamma: float = GAMMA
) -> EnergyError:
    """
    Energy error of rows by their irradiation and their temperature error.

    Parameters
    ----------
    kilowatt_hours : array, shape (rows,)
        Irradiation of each row. [kWh/m²]
    too_hot : array, shape (rows,)
        Modelled minus measured temperature; NaN does not count. [K]
    gamma : float, default -0.0035
        Temperature coefficient of power. [1/K]

    Returns
    -------
    EnergyError
    """
    error = kilowatt_hours * too_hot * gamma
    seen = np.isfinite(error)
    over = error[seen & (too_hot < 0)].sum()
    under = error[seen & (too_hot > 0)].sum()
    return EnergyError(
        total=float(abs(over) + abs(under)),
        over_estimate=float(over),
        under_estimate=float(under),
        insolation=float(kilowatt_hours[seen].sum()),
    )


def delayed_sensor(
    measured: pd.Series,
    delays: Iterable[float] | None = None,
    rows: pd.Series | None = None,
) -> pd.DataFrame:
    """
    Error of a perfect sensor that is read late, as a yardstick for models [1]_.

    Parameters
    ----------
    measured : Series
        Measured temperature with a DatetimeIndex. [°C]
    delays : iterable of float, optional
        Delays, in whole steps of the record; by default the paper's 1, 2, … 10 min, as
        far as they are whole steps. [s]
    rows : Series of bool, optional
        Rows to compare, by default all. For a yardstick, give the rows on which the
        model is scored: little changes at night, so all rows make a late sensor look
        better (5 min late is 1.1 K in the measured week, and 1.6 K in daytime).

    Returns
    -------
    DataFrame
        Rows by delay [s]; ``rmse`` and ``mae`` [K], ``points`` compared.

    Raises
    ------
    ValueError
        If ``measured`` has no DatetimeIndex or its times are not sorted, ``rows`` has
        another index, or a delay is no whole number of steps.

    References
    ----------
    .. [1] B. Herteleer et al., "Investigating methods to improve photovoltaic
       thermal models at second-to-minute timescales", 2022, section
       "Contextualisation".
       :doi:`10.22541/au.166922866.68736478`
    """
    if not isinstance(getattr(measured, "index", None), pd.DatetimeIndex):
        raise ValueError("measured has no DatetimeIndex; set one with pd.to_datetime")
    step = read({"measured": measured}, purpose="delayed_sensor").step
    delays, near = whole_delays(delays, step), pd.Timedelta(seconds=step) / 2
    there = measured
    if rows is not None:
        same_rows({"measured": measured, "rows": rows})
        there = measured.where(rows.astype(bool))
    table = {}
    for delay in delays:
        late = measured.copy()
        late.index = measured.index + pd.Timedelta(seconds=float(delay))
        late = late.reindex(measured.index, method="nearest", tolerance=near)
        table[delay] = {
            "rmse": rmse(there, late),
            "mae": mae(there, late),
            "points": len(difference(there, late)),
        }
    return pd.DataFrame.from_dict(table, orient="index").rename_axis("delay")


def whole_delays(delays: Any, step: float) -> list | range:
    """Delays in whole steps, by default the paper's; ValueError for other delays."""
    chosen = LATE if delays is None else list(delays)
    # a delay of much less than a step is none of no steps
    whole = {d: np.rint(d / step) or float(d != 0) for d in chosen}
    between = [d for d, steps in whole.items() if not abs(d / step - steps) < CLOSE]
    if delays is None:
        chosen = [delay for delay in chosen if delay not in between]
    if not chosen or (delays is not None and between):
        raise ValueError(
            f"delays of {', '.join(f'{d:g}' for d in between)} s are no whole steps of "
            f"{step:g} s, and the record has no values between its steps; give "
            f"multiples of the step, as delays=[{step:g}, {2 * step:g}]"
        )
    return chosen
