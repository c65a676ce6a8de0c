"""How good a modelled temperature is: in K, in energy, and as a delayed sensor."""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from pvlib_fem.record.checks import instants

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


def rmse(measured, modelled) -> float:
    """
    Root mean square of measured minus modelled temperature.

    Parameters
    ----------
    measured, modelled : numeric
        Temperatures; pairs with a NaN do not count. [°C]

    Returns
    -------
    float
        RMSE; NaN without a pair. [K]
    """
    return float(np.sqrt(mean_of(difference(measured, modelled) ** 2)))


def mae(measured, modelled) -> float:
    """
    Mean absolute difference of measured and modelled temperature.

    Parameters and result as in :func:`rmse`. [K]
    """
    return mean_of(np.abs(difference(measured, modelled)))


def mbe(measured, modelled) -> float:
    """
    Mean of measured minus modelled temperature, the paper's MBE.

    Its sign [1]_ makes it the bias that is *added* to the model. Parameters and
    result as in :func:`rmse`. [K]

    References
    ----------
    .. [1] B. Herteleer et al., "Investigating methods to improve photovoltaic
       thermal models at second-to-minute timescales", 2022, Eq. 28.
       :doi:`10.22541/au.166922866.68736478`
    """
    return mean_of(difference(measured, modelled))


def difference(measured, modelled):
    same_index(measured, modelled)
    error = np.asarray(measured, dtype=float) - np.asarray(modelled, dtype=float)
    return error[np.isfinite(error)]


def same_index(*columns):
    indexes = [column.index for column in columns if isinstance(column, pd.Series)]
    if any(not index.equals(indexes[0]) for index in indexes[1:]):
        raise ValueError("the series have different indexes; align them first")


def mean_of(values):
    return float(values.mean()) if len(values) else np.nan


@dataclass(frozen=True)
class EnergyError:
    """What temperature errors do to the modelled energy of a record."""

    total: float  # sum of both without their signs [kWh/kWp]
    over_estimate: float  # modelled too cold, energy too high: >= 0 [kWh/kWp]
    under_estimate: float  # modelled too hot, energy too low: <= 0 [kWh/kWp]
    insolation: float  # in the plane of the array [kWh/m²]

    @property
    def net(self):
        """What is left where both cancel. [kWh/kWp]"""
        return self.over_estimate + self.under_estimate

    @property
    def performance_ratio(self):
        """Total error of the performance ratio. [percentage points]"""
        return 100.0 * self.total / self.insolation if self.insolation else np.nan


def energy_error(poa_global, measured, modelled, gamma=GAMMA, step=None):
    r"""
    Energy error of a modelled temperature, to either side.

    .. math:: \Delta E = \sum_i G_i\,(T_{model} - T_{meas})_i\,\gamma\,\Delta t

    [1]_ over all samples (without signs), over those with :math:`T_{model} <
    T_{meas}` (energy over-estimated) and over the others.

    Parameters
    ----------
    poa_global : Series or array
        Irradiance in the plane of the array. [W/m²]
    measured, modelled : Series or array
        Temperatures. [°C]
    gamma : float, default -0.0035
        Temperature coefficient of power. [1/K]
    step : float, optional
        Time step of arrays; a Series brings its own: each sample stands for
        the step before it, at most twice the median one. [s]

    Returns
    -------
    EnergyError

    Raises
    ------
    ValueError
        If there are no times, or the indexes differ.

    References
    ----------
    .. [1] B. Herteleer et al., "Investigating methods to improve photovoltaic
       thermal models at second-to-minute timescales", 2022, Eqs. 30 to 34.
       :doi:`10.22541/au.166922866.68736478`
    """
    if step is None:
        if not isinstance(getattr(poa_global, "index", None), pd.DatetimeIndex):
            raise ValueError("arrays bring no times; give step in seconds")
        times = poa_global.index
        seconds = np.diff(instants(times)) / np.timedelta64(1, "s")
        usual = np.median(seconds) if len(seconds) else np.nan
        step = np.minimum(np.concatenate(([usual], seconds)), 2.0 * usual)
    same_index(poa_global, measured, modelled)
    poa = np.asarray(poa_global, dtype=float)
    too_hot = np.asarray(modelled, dtype=float) - np.asarray(measured, dtype=float)
    kilowatt_hours = poa / 1000.0 * step / HOUR
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


def delayed_sensor(measured, delays=range(60, 601, 60), rows=None) -> pd.DataFrame:
    """
    Error of a perfect sensor that is read late, as a yardstick for models.

    The comparison is that of [1]_.

    Parameters
    ----------
    measured : Series
        Measured temperature with a DatetimeIndex. [°C]
    delays : iterable of float
        Delays. [s]
    rows : Series of bool, optional
        Rows to compare, by default all. For a yardstick these are the rows that the
        model is scored on: by night little changes, so that all rows together make a
        late sensor look better (5 min late 1.1 K in the measured week, 1.6 K by day).

    Returns
    -------
    DataFrame
        Rows by delay [s]; ``rmse`` and ``mae`` [K], ``points`` compared.

    Raises
    ------
    ValueError
        If ``measured`` has no DatetimeIndex, or ``rows`` another one.

    References
    ----------
    .. [1] B. Herteleer et al., "Investigating methods to improve photovoltaic
       thermal models at second-to-minute timescales", 2022, section
       "Contextualisation".
       :doi:`10.22541/au.166922866.68736478`
    """
    if not isinstance(getattr(measured, "index", None), pd.DatetimeIndex):
        raise ValueError("measured has no DatetimeIndex; set one with pd.to_datetime")
    usual = np.median(np.diff(instants(measured.index)))
    there = measured
    if rows is not None:
        same_index(measured, rows)
        there = measured.where(rows.astype(bool))
    table = {}
    for delay in delays:
        late = measured.copy()
        late.index = measured.index + pd.Timedelta(seconds=float(delay))
        late = late.reindex(measured.index, method="nearest", tolerance=usual / 2)
        table[delay] = {
            "rmse": rmse(there, late),
            "mae": mae(there, late),
            "points": len(difference(there, late)),
        }
    return pd.DataFrame.from_dict(table, orient="index").rename_axis("delay")
