"""The paper's resistances and wind coefficients, from five-minute averages."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from pvlib_fem._record.column_names import COLUMNS
from pvlib_fem._record.filters import daytime, night
from pvlib_fem._spelling import LEAST_SQUARES, ShellText, refusal

INTERVAL = "5min"
MIN_POINTS = 10  # least number of points of a regression
CALM_POINTS = 20  # least number at rare wind speeds, so that no single hour decides


@dataclass(frozen=True)
class Estimate:
    """A value, its unit and the number of points behind it."""

    value: float
    unit: str
    points: int
    intercept: float = 0.0  # intercept of the line whose slope the value is [K]
    note: str = ""  # a remark for the reader of the value


def averages(
    poa_global: pd.Series,
    temp_air: pd.Series,
    wind_speed: pd.Series,
    temp_module: pd.Series,
    interval: str = INTERVAL,
) -> pd.DataFrame:
    """
    Five-minute averages of daytime rows, with the over-temperature.

    Parameters
    ----------
    poa_global, temp_air, wind_speed, temp_module : Series
        [W/m²], [°C], [m/s], [°C]
    interval : str, default "5min"
        Length of an average.

    Returns
    -------
    DataFrame
        Columns ``poa_global`` [W/m²], ``wind_speed`` [m/s] and ``over`` [K] on an even
        grid, NaN without measurements.
    """
    frame = pd.DataFrame(
        dict(zip(COLUMNS, (poa_global, temp_air, wind_speed, temp_module)))
    )
    frame = frame[pd.Series(daytime(*(frame[name] for name in COLUMNS)))]
    frame["over"] = frame["temp_module"] - frame["temp_air"]
    frame = frame[["poa_global", "wind_speed", "over"]]
    return frame.resample(interval).mean() if len(frame) else frame


def require_points(
    step: str, rows: int, at_least: int, condition: str, remedy: str
) -> None:
    """
    Refuse a step of the recipe that has too few points.

    Parameters
    ----------
    step : str
        Name of the step, for the message.
    rows, at_least : int
        Number of points, and the least number.
    condition : str
        Condition of the points, for the message.
    remedy : str or ShellText
        End of the message.

    Raises
    ------
    ValueError
        If there are fewer points than that.
    """
    if rows < at_least:
        raise refusal(
            f"{step} needs {at_least} points and has {rows}: five-minute daytime "
            f"averages with {condition}; ",
            remedy,
        )


def regression_line(x: Any, y: Any, intercept: bool = True) -> tuple[float, float]:
    """
    Slope and intercept of a regression line.

    Parameters
    ----------
    x, y : array or Series, shape (points,)
    intercept : bool, default True
        Without it the line goes through the origin.

    Returns
    -------
    slope : float
        [unit of ``y`` per unit of ``x``]
    intercept : float
        0 without an intercept. [unit of ``y``]
    """
    if not intercept:
        return float(x @ y / (x @ x)), 0.0
    slope, constant = np.polyfit(x, y, 1)
    return float(slope), float(constant)


def night_bias(
    poa_global: pd.Series | np.ndarray,
    temp_air: pd.Series | np.ndarray,
    wind_speed: pd.Series | np.ndarray,
    temp_module: pd.Series | np.ndarray,
    min_points: int = CALM_POINTS,
) -> Estimate:
    """
    Mean over-temperature at night, the bias of Veldhuis et al.

    Over-temperature without irradiance has two causes: radiation to the sky, and the
    offsets of the sensors. The paper compares this bias with its own, the mean error of
    the training days, whose remaining error is slightly smaller. ``method="paper"``
    also subtracts it from over-temperature before its regressions.

    Parameters
    ----------
    poa_global, temp_air, wind_speed, temp_module : Series or array
        [W/m²], [°C], [m/s], [°C]
    min_points : int, default 20
        Least number of night rows (:func:`pvlib_fem.paper.night`).

    Returns
    -------
    Estimate
        [K]

    Raises
    ------
    ValueError
        If there are too few night rows.
    """
    dark = np.asarray(night(poa_global, temp_air, wind_speed, temp_module), bool)
    if dark.sum() < min_points:
        raise ValueError(
            f"the bias at night needs {min_points} rows and has {int(dark.sum())}: "
            "less than 20 W/m², the module at -20 to 80 °C; use a record that has "
            "nights"
        )
    over = np.asarray(temp_module, float)[dark] - np.asarray(temp_air, float)[dark]
    return Estimate(float(over.mean()), "K", int(dark.sum()))


def r_eq_max(
    poa_global: pd.Series,
    temp_air: pd.Series,
    wind_speed: pd.Series,
    temp_module: pd.Series,
    calm_wind: float = 0.5,
    intercept: bool = True,
    min_points: int = CALM_POINTS,
    offset: float = 0.0,
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
        Whether the line has an intercept. A module that loses heat to the night sky has
        a negative intercept. Without an intercept the slope is too small (24.5 instead
        of 33.8 mK/(W/m²) below 1 m/s in the measured week), unless the ``offset`` is
        subtracted.
    min_points : int, default 20
        Least number of five-minute averages.
    offset : float, default 0
        Over-temperature without irradiance, which is subtracted; at night it is
        :func:`night_bias`. [K]

    Returns
    -------
    Estimate
        [K m²/W], with the line's ``intercept`` [K], which includes the ``offset``.

    Raises
    ------
    ValueError
        If there are too few calm averages.
    """
    frame = averages(poa_global, temp_air, wind_speed, temp_module)
    frame = frame[frame["wind_speed"] < calm_wind]
    require_points(
        "r_eq,max",
        len(frame),
        min_points,
        f"wind below {calm_wind:g} m/s",
        ShellText(
            f"raise calm_wind, or use {LEAST_SQUARES}",
            f"raise --calm-wind, or use {LEAST_SQUARES.shell}",
        ),
    )
    return resistance(frame, intercept, offset)


def resistance(frame: pd.DataFrame, intercept: bool, offset: float) -> Estimate:
    """Slope of over-temperature over irradiance."""
    k, at_zero = regression_line(frame["poa_global"], frame["over"] - offset, intercept)
    return Estimate(k, "K m²/W", len(frame), offset + at_zero)


def r_m(
    poa_global: pd.Series,
    temp_air: pd.Series,
    wind_speed: pd.Series,
    temp_module: pd.Series,
    high_wind: float = 6.0,
    intercept: bool = True,
    min_points: int = CALM_POINTS,
    offset: float = 0.0,
) -> Estimate:
    """
    Resistance of the module itself: slope of T_o over irradiance in high wind.

    This is Eq. 13; in high wind the resistance of the air films is neglected.

    Parameters
    ----------
    poa_global, temp_air, wind_speed, temp_module : Series
        [W/m²], [°C], [m/s], [°C]
    high_wind : float, default 6
        Wind speed from which the wind counts as high. [m/s]
    intercept : bool, default True
        Whether the line has an intercept, as in :func:`r_eq_max`.
    min_points : int, default 20
        Least number of five-minute averages.
    offset : float, default 0
        Over-temperature without irradiance, which is subtracted. [K]

    Returns
    -------
    Estimate
        [K m²/W], with the line's ``intercept`` [K], which includes the ``offset``.

    Raises
    ------
    ValueError
        If there are too few averages in high wind.
    """
    frame = averages(poa_global, temp_air, wind_speed, temp_module)
    frame = frame[frame["wind_speed"] >= high_wind]
    require_points(
        "r_M",
        len(frame),
        min_points,
        f"wind of at least {high_wind:g} m/s",
        ShellText("lower high_wind", f"use {LEAST_SQUARES.shell}"),
    )
    return resistance(frame, intercept, offset)


def r_film(r_eq_max: Estimate, r_m: Estimate) -> Estimate:
    """
    Resistance of the air films, ``r_eq,max - r_M`` (Eq. 15).

    Parameters
    ----------
    r_eq_max, r_m : Estimate
        From :func:`r_eq_max` and :func:`r_m`. [K m²/W]

    Returns
    -------
    Estimate
        The smaller number of points of both. [K m²/W]
    """
    points = min(r_eq_max.points, r_m.points)
    return Estimate(r_eq_max.value - r_m.value, "K m²/W", points)


def d(
    poa_global: pd.Series,
    temp_air: pd.Series,
    wind_speed: pd.Series,
    temp_module: pd.Series,
    k: float,
    poa_min: float = 600.0,
    min_points: int = MIN_POINTS,
    offset: float = 0.0,
) -> Estimate:
    """
    Wind coefficient of WM1, from the slope of ln(T_o/(k·G)) over wind.

    It is the second of the two regressions of WM1 (Eq. 18), in high irradiance: a line
    through the origin, whose slope is -1/d.

    Parameters
    ----------
    poa_global, temp_air, wind_speed, temp_module : Series
        [W/m²], [°C], [m/s], [°C]
    k : float
        From the first regression, the ``value`` of :func:`r_eq_max`. [K m²/W]
    poa_min : float, default 600
        Limit of high irradiance; the paper gives no number, this one is the package's.
        [W/m²]
    min_points : int, default 10
        Least number of five-minute averages.
    offset : float, default 0
        Over-temperature without irradiance, which is subtracted. If ``k`` is the slope
        of a line with an intercept, give that intercept; otherwise it biases d. [K]

    Returns
    -------
    Estimate
        [m/s]

    Raises
    ------
    ValueError
        If there are too few averages, or over-temperature does not fall with wind.
    """
    frame = averages(poa_global, temp_air, wind_speed, temp_module)
    frame["over"] = frame["over"] - offset
    frame = frame[(frame["poa_global"] > poa_min) & (frame["over"] > 0)]
    require_points(
        "d of WM1",
        len(frame),
        min_points,
        f"more than {poa_min:g} W/m² and T_o > 0",
        ShellText("lower poa_min", f"use {LEAST_SQUARES.shell}"),
    )
    wind = frame["wind_speed"]
    share = np.log(frame["over"] / (k * frame["poa_global"]))
    slope, _ = regression_line(wind, share, intercept=False)
    if not slope < 0:
        raise ValueError(
            f"d of WM1: the over-temperature does not fall with wind ({len(frame)} "
            f"averages above {poa_min:g} W/m², k = {k:g}); check k and wind_speed"
        )
    return Estimate(-1.0 / slope, "m/s", len(frame))


def k_w_bins(
    poa_global: pd.Series,
    temp_air: pd.Series,
    wind_speed: pd.Series,
    temp_module: pd.Series,
    min_points: int = MIN_POINTS,
) -> pd.DataFrame:
    """
    Slopes of over-temperature over wind by irradiance, for :func:`k_w`.

    For each irradiance bin of 20 W/m² between 200 and 1000 W/m² this is the slope of
    T_o over wind from 0.5 to 8 m/s (Fig. 5).

    Parameters
    ----------
    poa_global, temp_air, wind_speed, temp_module : Series
        [W/m²], [°C], [m/s], [°C]
    min_points : int, default 10
        Least number of averages of a bin.

    Returns
    -------
    DataFrame
        ``poa_global``, the middle of the bin [W/m²], ``slope`` [K s/m] and
        ``points``, without bins of fewer than ``min_points`` averages.
    """
    frame = averages(poa_global, temp_air, wind_speed, temp_module)
    frame = frame[
        frame["poa_global"].between(200, 1000) & frame["wind_speed"].between(0.5, 8)
    ]
    bins = [
        (
            20.0 * bin_ + 10.0,
            regression_line(rows["wind_speed"], rows["over"])[0],
            len(rows),
        )
        for bin_, rows in frame.groupby(frame["poa_global"] // 20)
        if len(rows) >= min_points and np.ptp(rows["wind_speed"]) > 0
    ]
    return pd.DataFrame(bins, columns=["poa_global", "slope", "points"])


def k_w(
    poa_global: pd.Series,
    temp_air: pd.Series,
    wind_speed: pd.Series,
    temp_module: pd.Series,
    min_points: int = MIN_POINTS,
    intercept: bool = False,
) -> Estimate:
    """
    Convection coefficient of WM2: a regression of regression coefficients.

    By Eq. 20 it is minus the slope over irradiance of the slopes of T_o over wind in
    each irradiance bin (:func:`k_w_bins`).

    Parameters
    ----------
    poa_global, temp_air, wind_speed, temp_module : Series
        [W/m²], [°C], [m/s], [°C]
    min_points : int, default 10
        Least number of averages of a bin.
    intercept : bool, default False
        Whether the second line has an intercept. By Eq. 20 the slopes are -k_W·G, so it
        has none. With an intercept and few bins, k_W can be too large for WM2: on every
        other day of the measured week it is 0.0056 K m s/W with k = 0.0356 K m²/W, and
        8·k_W must be below k.

    Returns
    -------
    Estimate
        [K m s/W]

    Raises
    ------
    ValueError
        If fewer than three bins have enough averages.
    """
    bins = k_w_bins(poa_global, temp_air, wind_speed, temp_module, min_points)
    if len(bins) < 3:
        raise refusal(
            f"k_W needs 3 irradiance bins of 20 W/m² with {min_points} points each "
            f"and has {len(bins)}: five-minute daytime averages with 200 to 1000 "
            "W/m² and 0.5 to 8 m/s; ",
            ShellText("lower min_points, or use ", "use "),
            LEAST_SQUARES,
        )
    slope, _ = regression_line(bins["poa_global"], bins["slope"], intercept)
    return Estimate(-slope, "K m s/W", int(bins["points"].sum()))
