"""The paper's estimators; each says how many points it used."""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from pvlib_fem.paper.filters import daytime
from pvlib_fem.record.columns import COLUMNS
from pvlib_fem.relaxation import ewm

INTERVAL = "5min"
APART = 4  # intervals between the ends of a step change: 20 min
MARGIN = 20.0  # s, by which tau may rise and still count as falling
MIN_POINTS = 10  # for a regression
CALM_POINTS = 20  # for one whose wind speeds are rare, so that no hour decides it


@dataclass(frozen=True)
class Estimate:
    """A value, its unit and the number of points behind it."""

    value: float
    unit: str
    points: int


@dataclass(frozen=True, eq=False)
class TimeConstant:
    """Time constants by wind speed, and the one the paper would choose."""

    value: float  # the chosen one [s]
    tau_0: float  # largest of the bins below 2 m/s [s]
    f: float  # wind speed at which tau has fallen to tau_0/e [m/s]
    points: int
    table: pd.DataFrame  # by lower edge of the wind bin: tau [s], points, used


def averages(poa_global, temp_air, wind_speed, temp_module, interval=INTERVAL):
    """
    Five-minute averages of daytime rows, with the over-temperature.

    Returns
    -------
    DataFrame
        On an even grid, NaN where nothing was measured: ``poa_global`` [W/m²],
        ``wind_speed`` [m/s], ``over`` [K].
    """
    frame = pd.DataFrame(
        dict(zip(COLUMNS, (poa_global, temp_air, wind_speed, temp_module)))
    )
    frame = frame[daytime(*(frame[name] for name in COLUMNS))]
    frame["over"] = frame["temp_module"] - frame["temp_air"]
    frame = frame[["poa_global", "wind_speed", "over"]]
    return frame.resample(interval).mean() if len(frame) else frame


def enough(step, rows, at_least, condition, remedy):
    """Refuse a step of the recipe that has too few points."""
    if rows < at_least:
        raise ValueError(
            f"{step} needs {at_least} points and has {rows}: five-minute daytime "
            f"averages with {condition}; {remedy}"
        )


def regression(x, y, intercept=True):
    """Slope and intercept of a regression line."""
    if not intercept:
        return float(x @ y / (x @ x)), 0.0
    slope, constant = np.polyfit(x, y, 1)
    return float(slope), float(constant)


def r_eq_max(
    poa_global,
    temp_air,
    wind_speed,
    temp_module,
    calm_wind=0.5,
    intercept=True,
    min_points=CALM_POINTS,
) -> Estimate:
    """
    Largest thermal resistance: slope of T_o over irradiance in calm air.

    It is the k of WM1 and WM2, e^a of the Sandia model and 1/u0 of Faiman's
    (Eqs. 11 and 12).

    Parameters
    ----------
    poa_global, temp_air, wind_speed, temp_module : Series
        [W/m²], [°C], [m/s], [°C]
    calm_wind : float, default 0.5
        Wind speed below which the air counts as calm. [m/s]
    intercept : bool, default True
        Whether the line may miss the origin. A module that loses heat to the
        night sky has a negative intercept; forced through the origin its slope
        comes out too small (24.5 instead of 33.8 mK/(W/m²) below 1 m/s in the
        measured week).
    min_points : int, default 20
        Fewest five-minute averages to accept.

    Returns
    -------
    Estimate
        [K m²/W]

    Raises
    ------
    ValueError
        If there are too few calm averages.
    """
    frame = averages(poa_global, temp_air, wind_speed, temp_module)
    frame = frame[frame["wind_speed"] < calm_wind]
    enough(
        "r_eq,max",
        len(frame),
        min_points,
        f"wind below {calm_wind:g} m/s",
        "raise calm_wind, or use method='least_squares'",
    )
    k, _ = regression(frame["poa_global"], frame["over"], intercept)
    return Estimate(k, "K m²/W", len(frame))


def r_m(
    poa_global,
    temp_air,
    wind_speed,
    temp_module,
    high_wind=6.0,
    intercept=True,
    min_points=CALM_POINTS,
) -> Estimate:
    """
    Resistance of the module itself: slope of T_o over irradiance in high wind.

    Eq. 13. Parameters as in :func:`r_eq_max`, with
    ``high_wind`` [m/s] the wind speed from which on the air films count as
    blown away.
    """
    frame = averages(poa_global, temp_air, wind_speed, temp_module)
    frame = frame[frame["wind_speed"] >= high_wind]
    enough(
        "r_M",
        len(frame),
        min_points,
        f"wind of at least {high_wind:g} m/s",
        "lower high_wind",
    )
    value, _ = regression(frame["poa_global"], frame["over"], intercept)
    return Estimate(value, "K m²/W", len(frame))


def r_film(r_eq_max, r_m) -> Estimate:
    """
    Resistance of the air films, ``r_eq,max - r_M`` (Eq. 15).

    Parameters
    ----------
    r_eq_max, r_m : Estimate
        [K m²/W]
    """
    points = min(r_eq_max.points, r_m.points)
    return Estimate(r_eq_max.value - r_m.value, "K m²/W", points)


def d(
    poa_global,
    temp_air,
    wind_speed,
    temp_module,
    k,
    poa_min=600.0,
    min_points=MIN_POINTS,
) -> Estimate:
    """
    Wind coefficient of WM1: slope of -WS over ln(T_o/(k·G)) in high irradiance.

    The second of the two regressions of WM1 (Eq. 18), with ``k`` [K m²/W] from the
    first (:func:`r_eq_max`) and irradiance above ``poa_min`` [W/m²]. Other
    parameters as there.

    Returns
    -------
    Estimate
        [m/s]

    Raises
    ------
    ValueError
        If there are too few averages, or wind does not cool in them.
    """
    frame = averages(poa_global, temp_air, wind_speed, temp_module)
    frame = frame[(frame["poa_global"] > poa_min) & (frame["over"] > 0)]
    enough(
        "d of WM1",
        len(frame),
        min_points,
        f"more than {poa_min:g} W/m² and T_o > 0",
        "lower poa_min",
    )
    wind = frame["wind_speed"]
    share = np.log(frame["over"] / (k * frame["poa_global"]))
    slope, _ = regression(wind, share, intercept=False)
    if not slope < 0:
        raise ValueError(
            f"d of WM1: the over-temperature does not fall with wind ({len(frame)} "
            f"averages above {poa_min:g} W/m², k = {k:g}); check k and wind_speed"
        )
    return Estimate(-1.0 / slope, "m/s", len(frame))


def k_w(
    poa_global, temp_air, wind_speed, temp_module, min_points=MIN_POINTS
) -> Estimate:
    """
    Convection coefficient of WM2: a regression of regression coefficients.

    Of Eq. 20. In each irradiance bin of 20 W/m² between 200 and 1000 W/m² the
    slope of T_o over wind of 0.5 to 8 m/s; then the slope of these over
    irradiance, with its sign turned. Bins of fewer than ``min_points`` averages
    do not count. Other parameters as in :func:`r_eq_max`.

    Returns
    -------
    Estimate
        [K m s/W]

    Raises
    ------
    ValueError
        If fewer than three bins are left.
    """
    frame = averages(poa_global, temp_air, wind_speed, temp_module)
    frame = frame[
        frame["poa_global"].between(200, 1000) & frame["wind_speed"].between(0.5, 8)
    ]
    middles, slopes, points = [], [], 0
    for bin_, rows in frame.groupby(frame["poa_global"] // 20):
        if len(rows) >= min_points and np.ptp(rows["wind_speed"]) > 0:
            slope, _ = regression(rows["wind_speed"], rows["over"])
            middles.append(20.0 * bin_ + 10.0)
            slopes.append(slope)
            points += len(rows)
    if len(slopes) < 3:
        raise ValueError(
            f"k_W needs 3 irradiance bins of 20 W/m² with {min_points} points each "
            f"and has {len(slopes)}: five-minute daytime averages with 200 to 1000 "
            "W/m² and 0.5 to 8 m/s; lower min_points, or use method='least_squares'"
        )
    slope, _ = regression(np.array(middles), np.array(slopes))
    return Estimate(-slope, "K m s/W", points)


def time_constant(
    poa_global,
    temp_air,
    wind_speed,
    temp_module,
    r_eq_max,
    min_points=MIN_POINTS,
) -> TimeConstant:
    r"""
    Time constant from step changes of irradiance, for each wind bin.

    .. math:: \tau(WS) = \frac{\Delta T_o}{\Delta G} \frac{\Delta t}{r_{eq,max}}

    (Eq. 21) over :math:`\Delta t` = 20 min of five-minute averages with more than 200
    W/m², wind within one bin of 1 m/s and its change below its standard
    deviation. The chosen one is the last bin up to which tau falls (20 s of
    margin), from its largest value below 2 m/s.

    Parameters
    ----------
    poa_global, temp_air, wind_speed, temp_module : Series
        [W/m²], [°C], [m/s], [°C]
    r_eq_max : float
        From :func:`r_eq_max`. [K m²/W]
    min_points : int, default 10
        Fewest step changes of a bin to accept.

    Returns
    -------
    TimeConstant

    Raises
    ------
    ValueError
        If no bin below 2 m/s has enough step changes, or they give a tau that is
        not positive.

    Notes
    -----
    **This estimator runs backwards.** For a first-order module the slope over
    r_eq,max is the *share of the response reached* after 20 min, which falls
    as the true time constant grows, and it falls with wind by construction.
    On 60 days of :func:`pvlib_fem.datasets.synthetic` at 1 min (seed 1), without
    noise and with the true r_eq,max:

    ====================  ====  ====  ====  ====  ====  ====
    true tau [s]           120   200   300   400   600   900
    found at 0-1 m/s [s]  1016   886   740   620   445   289
    least squares [s]      120   200   300   400   600   900
    ====================  ====  ====  ====  ====  ====  ====

    It is here to reproduce the paper's numbers; :func:`pvlib_fem.fit_fem` fits
    tau by least squares.
    """
    frame = averages(poa_global, temp_air, wind_speed, temp_module)
    gusty = wind_speed.std()
    change = frame.diff(APART)
    seconds = APART * pd.Timedelta(INTERVAL).total_seconds()
    steady_wind = change["wind_speed"].abs() < gusty
    bright = (frame["poa_global"] > 200) & (frame["poa_global"].shift(APART) > 200)
    kept = bright & steady_wind & change["over"].notna()
    speed, earlier = frame["wind_speed"], frame["wind_speed"].shift(APART)
    rows = {}
    for low in range(8):
        inside = kept & (speed // 1 == low) & (earlier // 1 == low)
        step = change[inside]
        tau = np.nan
        if len(step) >= min_points and np.ptp(step["poa_global"]) > 0:
            slope, _ = regression(step["poa_global"], step["over"])
            tau = slope / r_eq_max * seconds
        rows[low] = {"tau": tau, "points": len(step), "used": False}
    table = pd.DataFrame.from_dict(rows, orient="index").rename_axis("wind_speed")
    calm = table["tau"].iloc[:2]
    if calm.isna().all():
        raise ValueError(
            f"tau needs {min_points} step changes over 20 min in a wind bin below 2 "
            f"m/s and has {int(table['points'].iloc[0])} at 0-1 and "
            f"{int(table['points'].iloc[1])} at 1-2 m/s: five-minute averages above "
            "200 W/m² whose wind stays in the bin; use method='least_squares'"
        )
    first = last = int(calm.idxmax())
    while last < 7 and table["tau"][last + 1] <= table["tau"][last] + MARGIN:
        last += 1
    table.loc[first:last, "used"] = True
    used = table.loc[first:last]
    if (wrong := used["tau"][used["tau"] <= 0]).size:
        speed = wrong.index[0]
        raise ValueError(
            f"the step changes at {speed}-{speed + 1} m/s give tau = "
            f"{wrong[speed]:.0f} s: over-temperature falls as irradiance rises; use a "
            "longer record, or method='least_squares'"
        )
    f = np.inf
    if len(used) > 1:
        slope, _ = regression(used.index + 0.5, np.log(used["tau"]))
        f = -1.0 / slope if slope < 0 else np.inf
    return TimeConstant(
        value=float(table["tau"][last]),
        tau_0=float(table["tau"][first]),
        f=float(f),
        points=int(used["points"].sum()),
        table=table,
    )


def heat_capacities(tau, r_eq_max, r_m) -> dict:
    """
    Heat capacities from time constants and resistances (Eqs. 16 and 17).

    As the paper's Table 3 has them: ``c_eq_max = tau_0/r_M`` and ``c_m =
    tau/r_M``, whose difference is ``c_film``; the formula of Eq. 17 with
    exp(-WS/f) does not give that table. ``c_eq_min`` is ``tau_0/r_eq,max``.

    Parameters
    ----------
    tau : TimeConstant
        From :func:`time_constant`. [s]
    r_eq_max, r_m : Estimate
        From :func:`r_eq_max` and :func:`r_m`. [K m²/W]

    Returns
    -------
    dict of Estimate
        ``c_eq_min``, ``c_eq_max``, ``c_m``, ``c_film``; the points of each are
        the fewest behind its parts. [J/(m² K)]
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


def cell_from_back(temp_back, poa_global, k_bs_c, tau, **timing):
    """
    Cell temperature from the back of a module, ``T_back + k_BS-C·G_EWM``.

    Eq. 35.

    Parameters
    ----------
    temp_back : Series or array
        [°C]
    poa_global : Series or array
        [W/m²]
    k_bs_c : float
        Back-to-cell resistance. [K m²/W]
    tau : float
        Thermal time constant. [s]
    **timing
        ``step`` or ``times`` of arrays, see :func:`pvlib_fem.ewm`.

    Returns
    -------
    Series or array
        [°C]
    """
    return temp_back + k_bs_c * ewm(poa_global, tau, **timing)


def k_bs_c(temp_cell, temp_back, poa_global, tau, min_points=MIN_POINTS) -> Estimate:
    """
    Back-to-cell resistance: slope of T_cell - T_back over smoothed irradiance.

    Parameters
    ----------
    temp_cell, temp_back, poa_global : Series
        [°C], [°C], [W/m²]
    tau : float
        Thermal time constant. [s]
    min_points : int, default 10
        Fewest rows above 20 W/m² to accept.

    Returns
    -------
    Estimate
        [K m²/W]

    Raises
    ------
    ValueError
        If there are too few rows.
    """
    poa = ewm(poa_global, tau)
    difference = temp_cell - temp_back
    seen = (poa > 20) & difference.notna()
    if seen.sum() < min_points:
        raise ValueError(
            f"k_BS-C needs {min_points} rows and has {int(seen.sum())}: smoothed "
            "irradiance above 20 W/m² and both temperatures measured"
        )
    slope, _ = regression(poa[seen], difference[seen], intercept=False)
    return Estimate(slope, "K m²/W", int(seen.sum()))
