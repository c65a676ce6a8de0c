"""
Dynamic models of others, each as one function in pvlib's shape.

Models that smooth a steady temperature use the Sandia model for it, as Prilliman's
does. Equations are from the original sources unless a note says otherwise.
`COMPARATORS` lists the parameters that :func:`pvlib_fem.compare_models` fits.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
from scipy.optimize import least_squares

from pvlib_fem._record.checks import usual_step
from pvlib_fem._relaxation import ewm
from pvlib_fem._thermal.steady_models import STEADY_MODELS
from pvlib_fem._thermal_parameters.unit_mass import prilliman_mean
from pvlib_fem.drivers._sky_deficit import STEFAN_BOLTZMANN, ZERO_CELSIUS
from pvlib_fem.effects._effect import Parameter

GLASS_TEDLAR = 6032.0  # J/(m² K), Armstrong and Hurley's Table 1
FREE = 2.5  # W/(m² K) per face, between the 2.1 and 2.9 of their Table 3


def prilliman(
    poa_global: pd.Series,
    temp_air: pd.Series,
    wind_speed: pd.Series,
    a: float,
    b: float,
    unit_mass: float = 11.1,
    bias: float = 0.0,
) -> Any:
    """
    Sandia's model smoothed by Prilliman's moving mean of 20 min, as in pvlib.

    Each part of the record with even steps is smoothed separately, in blocks of rows:
    pvlib's function [1]_ refuses gaps, and its memory grows with the number of samples
    times the samples of the window.

    Parameters
    ----------
    poa_global, temp_air, wind_speed : Series
        [W/m²], [°C], [m/s]
    a, b : float
        Coefficients of the Sandia model. [ln(K m²/W)], [s/m]
    unit_mass : float, default 11.1
        Mass of the module per area, below 20. [kg/m²]
    bias : float, default 0
        Constant that is added. [K]

    Returns
    -------
    Series
        Module temperature; the steady temperature for steps of 20 min or more. [°C]

    References
    ----------
    .. [1] M. Prilliman et al., "Transient Weighted Moving-Average Model of
       Photovoltaic Module Back-Surface Temperature", IEEE J. Photovoltaics 10, 1053
       (2020). :doi:`10.1109/JPHOTOV.2020.2992351`, as in
       :func:`pvlib.temperature.prilliman`.
    """
    steady = sapm(poa_global, temp_air, wind_speed, a, b)
    return prilliman_mean(steady, wind_speed, unit_mass) + bias


def veldhuis(
    poa_global: pd.Series,
    temp_air: pd.Series,
    wind_speed: pd.Series,
    a: float,
    b: float,
    tau: Any,
    bias: float = 0.0,
) -> Any:
    """
    Exponential moving average of a steady module temperature, as Veldhuis et al.

    It smooths the temperature of the model [1]_, including air temperature; the paper
    smooths irradiance and wind instead. Peters and Nobre [2]_ apply this model to
    floating modules.

    Parameters
    ----------
    poa_global, temp_air, wind_speed : Series
        [W/m²], [°C], [m/s]
    a, b : float
        Coefficients of the Sandia model. [ln(K m²/W)], [s/m]
    tau : float
        Time constant; they have 17 min, 7 min afloat and 35 min on a roof. [s]
    bias : float, default 0
        Constant that is added; theirs is :func:`pvlib_fem.paper.night_bias`. [K]

    Returns
    -------
    Series
        Module temperature. [°C]

    Notes
    -----
    The implementation follows the description by Herteleer et al. [3]_: a recursive
    average of the module temperature, and a bias from nights. The original steady
    part has a term in relative humidity and six parameters. Its form could not be
    verified, so Sandia's model is used instead.

    References
    ----------
    .. [1] A. J. Veldhuis et al., "An Empirical Model for Rack-Mounted PV Module
       Temperatures for Southeast Asian Locations Evaluated for Minute Time Scales",
       IEEE J. Photovoltaics 5, 774 (2015). :doi:`10.1109/JPHOTOV.2015.2405762`
    .. [2] I. M. Peters and A. M. Nobre, "Deciphering the thermal behavior of floating
       photovoltaic installations", Solar Energy Advances 2, 100007 (2022).
       :doi:`10.1016/j.seja.2021.100007`
    .. [3] B. Herteleer et al., 2022. :doi:`10.22541/au.166922866.68736478`
    """
    return ewm(sapm(poa_global, temp_air, wind_speed, a, b), tau) + bias


def armstrong_hurley(
    poa_global: pd.Series,
    temp_air: pd.Series,
    wind_speed: pd.Series,
    a: float,
    b: float,
    bias: float = 0.0,
    **module: Any,
) -> Any:
    """
    Sandia's model, relaxed with Armstrong and Hurley's time constant.

    Parameters
    ----------
    poa_global, temp_air, wind_speed : Series
        [W/m²], [°C], [m/s]
    a, b : float
        Coefficients of the Sandia model. [ln(K m²/W)], [s/m]
    bias : float, default 0
        Constant that is added. [K]
    **module
        ``capacity`` and ``free`` of :func:`armstrong_hurley_tau`.

    Returns
    -------
    Series
        Module temperature. [°C]
    """
    steady = sapm(poa_global, temp_air, wind_speed, a, b)
    tau = armstrong_hurley_tau(wind_speed, **module)
    # the steady temperature is NaN without wind, so any tau will do
    return ewm(steady, np.where(np.isfinite(tau), tau, 1.0)) + bias


def armstrong_hurley_tau(
    wind_speed: pd.Series, capacity: Any = GLASS_TEDLAR, free: Any = FREE
) -> Any:
    r"""
    Time constant of a module on a rack from its layers and the wind.

    .. math:: \tau = \frac{C}{h_{front} + h_{free}}, \qquad
       h_{front} = \sqrt[3]{(2.56\,WS + 8.55)^3 + h_{free}^3}

    Wind cools the front, and natural convection cools both faces. Radiation and the
    resistance of the layers are neglected, as in [1]_.

    Parameters
    ----------
    wind_speed : numeric
        [m/s]
    capacity : float, default 6032
        Heat capacity of the layers; the default is their module of 3 mm glass and
        Tedlar, see :func:`pvlib_fem.layers.stack` for others. [J/(m² K)]
    free : float, default 2.5
        Natural convection from one face. It depends on over-temperature: their three
        cases have 2.9, 2.4 and 2.1. [W/(m² K)]

    Returns
    -------
    numeric
        [s]

    References
    ----------
    .. [1] S. Armstrong and W. G. Hurley, "A thermal model for photovoltaic panels
       under varying atmospheric conditions", Appl. Therm. Eng. 30, 1488 (2010), Eqs.
       3, 11 and 19 and Tables 1 and 3. :doi:`10.1016/j.applthermaleng.2010.03.012`

    Examples
    --------
    >>> print(round(armstrong_hurley_tau(2.14, free=2.44) / 60, 1), "min")
    6.1 min
    """
    forced = 2.56 * wind_speed + 8.55
    return capacity / (np.cbrt(forced**3 + free**3) + free)


def barry(
    poa_global: pd.Series,
    temp_air: pd.Series,
    wind_speed: pd.Series,
    longwave_down: Any,
    u1: float,
    u2: Any,
    u3: Any,
    tau: Any,
    bias: float = 0.0,
) -> Any:
    r"""
    Faiman's model with radiation to the sky and smoothed inputs, by Barry et al.

    .. math:: T_m = \langle T_a\rangle + \frac{\langle G\rangle}{u_1 + u_2 \langle
       WS\rangle} + u_3 \langle T_{sky} - T_a\rangle

    The brackets are exponential means of one time constant [1]_. The effect
    ``sky_radiation`` has this loss in the heat balance, where it is divided by the
    loss that depends on wind: :math:`u_3 \approx share\; 4\sigma T_a^3 / (u_0 + u_1
    WS)`.

    Parameters
    ----------
    poa_global, temp_air, wind_speed : Series
        [W/m²], [°C], [m/s]
    longwave_down : Series
        Longwave irradiance from the sky, which gives its temperature. [W/m²]
    u1, u2, u3 : float
        [W/(m² K)], [W s/(m³ K)], [-]
    tau : float
        Time constant; they found 589, 509 and 547 s. [s]
    bias : float, default 0
        Constant that is added; their model has none. [K]

    Returns
    -------
    Series
        Module temperature. [°C]

    References
    ----------
    .. [1] J. Barry et al., "Dynamic model of photovoltaic module temperature as a
       function of atmospheric conditions", Adv. Sci. Res. 17, 165 (2020).
       :doi:`10.5194/asr-17-165-2020`; the order of smoothing as in their PVRAD.
    """
    sky = (longwave_down / STEFAN_BOLTZMANN) ** 0.25 - ZERO_CELSIUS
    sun, air, wind, deficit = (
        ewm(column, tau)
        for column in (poa_global, temp_air, wind_speed, sky - temp_air)
    )
    return air + sun / (u1 + u2 * wind) + u3 * deficit + bias


def sapm(
    poa_global: pd.Series,
    temp_air: pd.Series,
    wind_speed: pd.Series,
    a: float,
    b: float,
) -> Any:
    """The back temperature of the Sandia model, by the same coefficients. [°C]"""
    return temp_air + poa_global * STEADY_MODELS["sapm"].resistance(wind_speed, a, b)


@dataclass(frozen=True)
class Comparator:
    """A model of others: its function, fitted parameters and additional columns."""

    function: Callable
    parameters: Mapping[str, Parameter]
    columns: tuple = ()
    fit_step: float = 0.0  # s; finer records are averaged to this step for the fit


BIAS = {"bias": Parameter(0.0, -30.0, 30.0, "K")}
SAPM = {**STEADY_MODELS["sapm"].parameters, **BIAS}
TAU = {"tau": Parameter(378.0, 1.0, 7200.0, "s")}

COMPARATORS = {
    "prilliman": Comparator(prilliman, SAPM, fit_step=60.0),
    "armstrong_hurley": Comparator(armstrong_hurley, SAPM),
    "veldhuis": Comparator(veldhuis, {**SAPM, **TAU}),
    "barry": Comparator(
        barry,
        {
            "u1": STEADY_MODELS["faiman"].parameters["u0"],
            "u2": STEADY_MODELS["faiman"].parameters["u1"],
            "u3": Parameter(0.1, 0.0, 2.0, "-"),
            **TAU,
        },
        ("longwave_down",),
    ),
}


def fitted(comparator: Any, drivers: Any, temp_module: pd.Series, rows: Any) -> dict:
    """
    Coefficients of a comparator by least squares over some rows.

    Prilliman's model is fitted to means over at least one minute: at 1 s, one
    evaluation by pvlib takes 10 s per day.

    Parameters
    ----------
    comparator : Comparator
    drivers : sequence of Series
        ``poa_global``, ``temp_air``, ``wind_speed`` and the additional columns.
    temp_module : Series
        [°C]
    rows : boolean array

    Returns
    -------
    dict

    Raises
    ------
    ValueError
        If there are no more rows than coefficients.
    """
    if usual_step(temp_module.index) < comparator.fit_step:
        *drivers, temp_module, rows = (
            column.resample(pd.Timedelta(seconds=comparator.fit_step)).mean()
            for column in (
                *drivers,
                temp_module,
                mask_as_series(rows, temp_module.index),
            )
        )
        rows = rows.to_numpy() > 0.5
    names = list(comparator.parameters)
    table = list(comparator.parameters.values())
    measured = temp_module.to_numpy()[rows]
    if np.isfinite(measured).sum() <= len(names):
        raise ValueError(
            f"{len(names)} coefficients need more rows than the "
            f"{np.isfinite(measured).sum()} that count; use a longer record"
        )

    def residual(x: Any) -> Any:
        answer = comparator.function(*drivers, **dict(zip(names, x)))
        error = measured - answer.to_numpy()[rows]
        return error[np.isfinite(error)]

    minimum = least_squares(
        residual,
        [row.start for row in table],
        bounds=([row.lower for row in table], [row.upper for row in table]),
        x_scale=[max(abs(row.start), 0.1) for row in table],
        diff_step=1e-4,
        xtol=1e-6,
        ftol=1e-8,
    )
    return dict(zip(names, minimum.x.tolist()))


def mask_as_series(rows: Any, index: Any) -> Any:
    """A mask of rows as a Series of ones and zeros."""
    marks = pd.Series(0.0, index)
    marks[rows] = 1.0
    return marks
