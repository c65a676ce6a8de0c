"""The paper's time constant from step changes, and the heat capacities from it."""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from pvlib_fem._record.checks import usual_step
from pvlib_fem._spelling import LEAST_SQUARES, ShellText, refusal
from pvlib_fem.paper._estimators import (
    INTERVAL,
    MIN_POINTS,
    Estimate,
    averages,
    regression_line,
)

APART = 4  # intervals between the ends of a step change: 20 min
MARGIN = 20.0  # s, increase of tau up to which it still counts as falling
BRIGHT = 200.0  # W/m², least irradiance of a step change
CALM_BINS = 2  # bins of 1 m/s in which tau_0 is searched


@dataclass(frozen=True, eq=False)
class TimeConstant:
    """Time constants by wind speed, and the one chosen by the paper's rule."""

    value: float  # the chosen one [s]
    tau_0: float  # largest of the bins below 2 m/s [s]
    f: float  # wind speed at which tau has fallen to tau_0/e [m/s]
    points: int
    table: pd.DataFrame  # by lower edge of the wind bin: tau [s], points, used


def time_constant(
    poa_global: pd.Series,
    temp_air: pd.Series,
    wind_speed: pd.Series,
    temp_module: pd.Series,
    r_eq_max: float,
    min_points: int = MIN_POINTS,
    interval: str = INTERVAL,
    apart: int = APART,
) -> TimeConstant:
    r"""
    Time constant from step changes of irradiance, for each wind bin.

    .. math:: \tau(WS) = \frac{\Delta T_o}{\Delta G} \frac{\Delta t}{r_{eq,max}}

    The changes (Eq. 21) are over :math:`\Delta t` = 20 min of five-minute averages with
    more than 200 W/m², wind within one bin of 1 m/s and a change of wind below its
    standard deviation. From its largest value below 2 m/s, tau falls with wind (with a
    margin of 20 s); the last bin up to which it falls is chosen.

    Parameters
    ----------
    poa_global, temp_air, wind_speed, temp_module : Series
        [W/m²], [°C], [m/s], [°C]
    r_eq_max : float
        The ``value`` of :func:`r_eq_max`. [K m²/W]
    min_points : int, default 10
        Least number of step changes of a bin.
    interval : str, default "5min"
        Length of an average, no shorter than the record's step.
    apart : int, default 4
        Intervals between the two ends of a step change.

    Returns
    -------
    TimeConstant
        Its ``f`` is N/ln(tau_0/tau), where N [m/s] is the distance from the bin of
        tau_0 to the chosen bin; infinite if both are equal.

    Raises
    ------
    ValueError
        If the record's step is longer than the interval, no bin below 2 m/s has
        enough step changes, or they give a tau that is not positive.

    Notes
    -----
    **This estimator decreases as the true time constant increases.** For a first-order
    module the slope over r_eq,max is the *share of the response reached* after 20 min,
    which falls as the true time constant grows. It falls with wind by construction.
    On 60 days of :func:`pvlib_fem.datasets.synthetic` at 1 min (seed 1) by WM1 (k =
    0.035 K m²/W, d = 10 m/s) with ``dynamics="ewm"``, without noise and with the true
    r_eq,max:

    ====================  ====  ====  ====  ====  ====  ====
    true tau [s]           120   200   300   400   600   900
    found at 0-1 m/s [s]  1016   886   740   620   445   289
    least squares [s]      120   200   300   400   600   900
    ====================  ====  ====  ====  ====  ====  ====

    Use it to reproduce the paper's numbers; :func:`pvlib_fem.fit_fem` fits tau by
    least squares.

    In every row of the paper's Table 3 (:func:`table_3`) f·ln(tau_0/tau) is a whole
    number from 4 to 10. So its f is computed from the two ends of the fall, and bins
    above the 8 m/s of its text are used.
    """
    steps = step_changes(poa_global, temp_air, wind_speed, temp_module, interval, apart)
    minutes = apart * pd.Timedelta(interval).total_seconds() / 60.0
    rows = {}
    bins = int(max(steps["wind_speed"].max(), CALM_BINS - 1)) if len(steps) else 1
    for low in range(bins + 1):
        step = steps[steps["wind_speed"] == low]
        tau = np.nan
        if len(step) >= min_points and np.ptp(step["poa_global"]) > 0:
            slope, _ = regression_line(step["poa_global"], step["over"])
            tau = slope / r_eq_max * 60.0 * minutes
        rows[low] = {"tau": tau, "points": len(step), "used": False}
    table = pd.DataFrame.from_dict(rows, orient="index").rename_axis("wind_speed")
    calm = table["tau"].iloc[:CALM_BINS]
    if calm.isna().all():
        raise refusal(
            f"tau needs {min_points} step changes over {minutes:g} min in a wind bin "
            f"below 2 m/s and has {int(table['points'].iloc[0])} at 0-1 and "
            f"{int(table['points'].iloc[1])} at 1-2 m/s: {interval} averages above "
            f"{BRIGHT:g} W/m² whose wind stays in the bin; use ",
            LEAST_SQUARES,
        )
    return used_wind_bins(table, int(np.nanargmax(calm)))


def step_changes(
    poa_global: pd.Series,
    temp_air: pd.Series,
    wind_speed: pd.Series,
    temp_module: pd.Series,
    interval: str = INTERVAL,
    apart: int = APART,
) -> pd.DataFrame:
    """
    Step changes that the paper regresses (Fig. 6).

    Parameters
    ----------
    poa_global, temp_air, wind_speed, temp_module : Series
        [W/m²], [°C], [m/s], [°C]
    interval : str, default "5min"
        Length of an average, no shorter than the record's step.
    apart : int, default 4
        Intervals between the two ends of a step change.

    Returns
    -------
    DataFrame
        Changes of ``poa_global`` [W/m²] and ``over`` [K], and the lower edge of the bin
        of ``wind_speed`` [m/s], indexed by the time of their end.

    Raises
    ------
    ValueError
        If the record's step is longer than the interval.
    """
    check_interval(poa_global.index, interval)
    frame = averages(poa_global, temp_air, wind_speed, temp_module, interval)
    change = frame.diff(apart)
    bright = (frame["poa_global"] > BRIGHT) & (
        frame["poa_global"].shift(apart) > BRIGHT
    )
    steady_wind = change["wind_speed"].abs() < wind_speed.std()
    bin_, earlier = frame["wind_speed"] // 1, frame["wind_speed"].shift(apart) // 1
    kept = bright & steady_wind & (bin_ == earlier) & change["over"].notna()
    return change.assign(wind_speed=bin_)[kept]


def check_interval(index: pd.Index, interval: str) -> None:
    """Refuse an average that is shorter than the record's own step."""
    usual = usual_step(index)
    if usual > pd.Timedelta(interval).total_seconds():
        step = f"{usual / 60:g}min"
        apart = f"give interval='{step}' and how many of these are apart, or "
        raise refusal(
            f"the record has a step of {step}, longer than the averages of "
            f"{interval}; ",
            ShellText(apart, ""),
            "use ",
            LEAST_SQUARES,
        )


def used_wind_bins(table: pd.DataFrame, first: int) -> TimeConstant:
    """The last bin up to which tau falls from the ``first``, and the fitted fall."""
    last, tau = first, table["tau"]
    while last + 1 in table.index and tau[last + 1] <= tau[last] + MARGIN:
        last += 1
    table.loc[first:last, "used"] = True
    used = table.loc[first:last]
    if (wrong := used["tau"][used["tau"] <= 0]).size:
        speed = wrong.index[0]
        raise refusal(
            f"the step changes at {speed}-{speed + 1} m/s give tau = "
            f"{wrong[speed]:.0f} s: over-temperature falls as irradiance rises; use a "
            "longer record, or ",
            LEAST_SQUARES,
        )
    fall = np.log(tau[first] / tau[last])
    return TimeConstant(
        value=float(tau[last]),
        tau_0=float(tau[first]),
        f=float((last - first) / fall) if fall > 0 else np.inf,
        points=int(used["points"].sum()),
        table=table,
    )


def heat_capacities(
    tau: TimeConstant, r_eq_max: Estimate, r_m: Estimate
) -> dict[str, Estimate]:
    """
    Heat capacities from time constants and resistances (Eqs. 16 and 17).

    The definitions are those of the paper's Table 3: ``c_eq_max = tau_0/r_M`` and
    ``c_m = tau/r_M``; ``c_film`` is their difference. Eq. 17, tau_0·exp(-WS/f)/r_M,
    equals the table's c_M at the wind of each site's last bin, where tau_0·exp(-WS/f)
    is tau. The table uses the name c_eq,max for the value with tau_0. ``c_eq_min`` is
    ``tau_0/r_eq,max``.

    Parameters
    ----------
    tau : TimeConstant
        From :func:`time_constant`. [s]
    r_eq_max, r_m : Estimate
        From :func:`r_eq_max` and :func:`r_m`. [K m²/W]

    Returns
    -------
    dict of Estimate
        ``c_eq_min``, ``c_eq_max``, ``c_m``, ``c_film``; the points of each are the
        smaller number of its parts. [J/(m² K)]
    """
    parts = {
        "c_eq_min": (tau.tau_0, r_eq_max),
        "c_eq_max": (tau.tau_0, r_m),
        "c_m": (tau.value, r_m),
        "c_film": (tau.tau_0 - tau.value, r_m),
    }
    return {
        name: Estimate(time / r.value, "J/(m² K)", min(tau.points, r.points))
        for name, (time, r) in parts.items()
    }
