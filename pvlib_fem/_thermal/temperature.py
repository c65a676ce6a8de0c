"""Module temperature in the shape of ``pvlib.temperature``, steady and dynamic."""

import inspect
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import pandas as pd

from pvlib_fem._record.checks import at_time, is_number
from pvlib_fem._record.inputs import Inputs, read
from pvlib_fem._relaxation import relax, smoothed
from pvlib_fem._thermal.steady_models import (
    CLIP,
    STEADY_MODELS,
    SteadyModel,
    steady_model,
)
from pvlib_fem.types import Numeric, Times

SEEN = ("poa_global", "wind_speed")  # smoothed
DYNAMIC = ("fuentes", "prilliman", "fem_temperature", "heat_balance")
TAU = 378.0  # s, the paper's mean of fixed mountings (379 ± 60 s)


def wm1(
    poa_global: Numeric, temp_air: Numeric, wind_speed: Numeric, k: float, d: float
) -> Numeric:
    r"""
    Steady module temperature by Wind Model 1 [1]_.

    .. math:: T_m = T_a + k\,G\,e^{-WS/d}

    Parameters
    ----------
    poa_global : numeric
        Irradiance in the plane of the array. [W/m²]
    temp_air : numeric
        Air temperature. [°C]
    wind_speed : numeric
        Wind speed. [m/s]
    k : float
        Over-temperature per irradiance in calm air, the Ross coefficient.
        [K m²/W]
    d : float
        Wind speed at which it has fallen to 1/e. [m/s]

    Returns
    -------
    numeric
        Module temperature. [°C]

    Raises
    ------
    ValueError
        If ``k`` or ``d`` is not positive.

    References
    ----------
    .. [1] B. Herteleer et al., "Investigating methods to improve photovoltaic
       thermal models at second-to-minute timescales", 2022, Eq. 18.
       :doi:`10.22541/au.166922866.68736478`

    Examples
    --------
    >>> print(round(wm1(1000, 20, 2, k=0.035, d=10), 2))
    48.66
    """
    return steady(
        STEADY_MODELS["wm1"], poa_global, temp_air, wind_speed, dict(k=k, d=d)
    )


def wm2(
    poa_global: Numeric,
    temp_air: Numeric,
    wind_speed: Numeric,
    k: float,
    k_w: float,
    wind_speed_max: float = CLIP,
) -> Numeric:
    r"""
    Steady module temperature by Wind Model 2 [1]_.

    .. math:: T_m = T_a + G\,(k - k_W \min(WS, WS_{max}))

    Parameters
    ----------
    poa_global : numeric
        Irradiance in the plane of the array. [W/m²]
    temp_air : numeric
        Air temperature. [°C]
    wind_speed : numeric
        Wind speed. [m/s]
    k : float
        Over-temperature per irradiance in calm air, the Ross coefficient.
        [K m²/W]
    k_w : float
        Irradiance convection coefficient. [K m s/W]
    wind_speed_max : float, default 8
        Wind speed beyond which more wind cools no further. [m/s]

    Returns
    -------
    numeric
        Module temperature. [°C]

    Raises
    ------
    ValueError
        If ``k`` or ``wind_speed_max`` is not positive, or ``k_w * wind_speed_max`` is
        not below ``k``.

    References
    ----------
    .. [1] B. Herteleer et al., "Investigating methods to improve photovoltaic
       thermal models at second-to-minute timescales", 2022, Eq. 20.
       :doi:`10.22541/au.166922866.68736478`

    Examples
    --------
    >>> print(round(wm2(1000, 20, 2, k=0.035, k_w=0.002), 2))
    51.0
    """
    coefficients = dict(k=k, k_w=k_w, wind_speed_max=wind_speed_max)
    return steady(STEADY_MODELS["wm2"], poa_global, temp_air, wind_speed, coefficients)


def steady(
    steady_model: SteadyModel,
    poa_global: Any,
    temp_air: Any,
    wind_speed: Any,
    coefficients: dict,
) -> float | np.ndarray:
    """Temperature by a steady model; numbers, arrays or Series give their own kind."""
    coefficients = steady_model.complete(coefficients)
    return temp_air + poa_global * steady_model.resistance(wind_speed, **coefficients)


def fem_temperature(
    poa_global: Numeric,
    temp_air: Numeric,
    wind_speed: Numeric,
    *,
    tau: float = TAU,
    bias: float = 0.0,
    model: str | Callable[..., Any] = "wm1",
    step: float | None = None,
    times: Times | None = None,
    adjust: bool = False,
    initial: pd.DataFrame | Mapping[str, float | pd.Series] | None = None,
    **coefficients: Numeric,
) -> pd.Series | np.ndarray:
    """
    Module temperature by any steady model on smoothed irradiance and wind.

    The dynamic form of the paper's FEM method [1]_: irradiance and wind speed
    go through an exponential weighted mean (:func:`ewm`), then into the steady
    model, and a constant bias is added.

    Parameters
    ----------
    poa_global : Series or array
        Irradiance in the plane of the array. [W/m²]
    temp_air : numeric
        Air temperature. [°C]
    wind_speed : numeric
        Wind speed. [m/s]
    tau : float, default 378
        Thermal time constant; the default is the paper's mean of fixed
        mountings. [s]
    bias : float, default 0
        Mean of measured minus modelled temperature, the paper's MBE. It is
        added. [K]
    model : str or callable, default "wm1"
        ``"ross"``, ``"sapm"``, ``"faiman"``, ``"wm1"``, ``"wm2"``, ``"pvsyst"``,
        ``"noct"``, ``"noct_sam"``, or a steady model of pvlib's shape
        ``(poa_global, temp_air, wind_speed, **coefficients)`` such as
        :func:`pvlib.temperature.sapm_cell`. Its further series (``ir_down``, say)
        are not smoothed; ``effective_irradiance`` is refused for that reason.
    step : float, optional
        Even time step, when the inputs are arrays. [s]
    times : DatetimeIndex or array, optional
        Times, when the inputs are arrays.
    adjust : bool, default False
        Start up as the paper's pandas listing does, see :func:`ewm`.
    initial : DataFrame or dict, optional
        State at the end of the record before, to continue from: its smoothed
        ``poa_global`` and ``wind_speed``, ``{"poa_global": ewm(poa, tau),
        "wind_speed": ewm(wind, tau)}``, each as in :func:`ewm`. Without it the module
        starts at its steady temperature.
    **coefficients
        Coefficients of the model, by name: ``k`` or ``noct`` (ross), ``a``, ``b``
        (sapm), ``u0``, ``u1`` (faiman, by default pvlib's 25 and 6.84), ``k``, ``d``
        (wm1), ``k``, ``k_w``, ``wind_speed_max`` (wm2, the last by default 8 m/s),
        ``u_c``, ``u_v``, ``module_efficiency``, ``alpha_absorption`` (pvsyst, by
        default pvlib's 29, 0, 0.1 and 0.9),
        ``noct`` (noct), ``noct``, ``module_efficiency``,
        ``transmittance_absorptance`` (noct_sam, the last by default 0.9).

    Returns
    -------
    Series or array
        Module temperature, or cell temperature if the model gives that. It is
        NaN where an input is NaN, and only there. [°C]

    Raises
    ------
    ValueError
        If the inputs are single numbers, their times are missing, unsorted or
        duplicate, wind is negative, the model or a coefficient is unknown, the model
        has a memory of its own, or ``tau`` is not positive.

    See Also
    --------
    heat_balance : the exact heat balance, whose time constant follows the wind.

    References
    ----------
    .. [1] B. Herteleer et al., "Investigating methods to improve photovoltaic
       thermal models at second-to-minute timescales", 2022, Eqs. 24 to 29.
       :doi:`10.22541/au.166922866.68736478`

    Examples
    --------
    >>> sun = np.array([0.0, 1000.0, 1000.0, 1000.0])
    >>> fem_temperature(sun, 20.0, 2.0, step=60.0, k=0.035, d=10).round(1)
    array([20. , 24.2, 27.8, 30.9])
    """
    inputs = driver_inputs(poa_global, temp_air, wind_speed, step, times)
    answer = as_function(model, coefficients)
    states = {
        name: None if initial is None else smoothing_state(initial, name)
        for name in SEEN
    }
    poa, wind = (
        inputs.restore(smoothed(inputs, name, tau, adjust, states[name]))
        for name in SEEN
    )
    temperature = answer(poa, inputs.restore(inputs["temp_air"]), wind)
    return without_name(temperature + bias, poa_global)


def heat_balance(
    poa_global: Numeric,
    temp_air: Numeric,
    wind_speed: Numeric,
    *,
    capacity: float,
    bias: float = 0.0,
    model: str = "faiman",
    step: float | None = None,
    times: Times | None = None,
    initial: float | pd.Series | None = None,
    **coefficients: float,
) -> pd.Series | np.ndarray:
    r"""
    Module temperature by the exact heat balance of one thermal mass.

    .. math::

        C \frac{dT}{dt} = G - \frac{T - T_a}{r_{eq}(WS)}

    The equation is solved exactly over each step [1]_, on which the inputs are
    held constant. Its time constant :math:`C\,r_{eq}` follows the wind.

    Parameters
    ----------
    poa_global : Series or array
        Irradiance in the plane of the array. [W/m²]
    temp_air : numeric
        Air temperature. [°C]
    wind_speed : numeric
        Wind speed. [m/s]
    capacity : float
        Heat capacity per area, relative to incident irradiance like the losses
        of the steady models: ``tau / r_eq``. [J/(m² K)]
    bias : float, default 0
        Mean of measured minus modelled temperature. It is added. [K]
    model : str, default "faiman"
        A steady model by name, as in :func:`fem_temperature`.
    step : float, optional
        Even time step, when the inputs are arrays. [s]
    times : DatetimeIndex or array, optional
        Times, when the inputs are arrays.
    initial : float or Series, optional
        Module temperature to continue from, as in :func:`ewm`. Without it the
        module starts at its steady temperature. [°C]
    **coefficients
        Coefficients of the model, as in :func:`fem_temperature`.

    Returns
    -------
    Series or array
        Module temperature. It is NaN where an input is NaN, and only there.
        [°C]

    Raises
    ------
    ValueError
        If the inputs are single numbers, their times are missing, unsorted or
        duplicate, wind is negative, the model or a coefficient is unknown, or
        ``capacity`` is not positive.

    See Also
    --------
    fem_temperature : the paper's form, for any steady model.

    Notes
    -----
    The next sample counts for the whole of a gap, see :func:`ewm`. After a gap longer
    than five time constants the module starts at its steady temperature.

    References
    ----------
    .. [1] B. Herteleer et al., "Investigating methods to improve photovoltaic
       thermal models at second-to-minute timescales", 2022, Eqs. 10 and 16.
       :doi:`10.22541/au.166922866.68736478`

    Examples
    --------
    >>> sun = np.array([0.0, 1000.0, 1000.0, 1000.0])
    >>> heat_balance(sun, 20.0, 2.0, capacity=12e3, step=60.0).round(1)
    array([20. , 24.5, 28.3, 31.4])
    """
    chosen = steady_model(model, coefficients)
    coefficients = chosen.complete(coefficients)
    inputs = driver_inputs(poa_global, temp_air, wind_speed, step, times)
    if not (is_number(capacity) and capacity > 0):
        what = "capacity" if np.ndim(capacity) else f"capacity = {capacity}"
        raise ValueError(f"{what} must be a positive number [J/(m² K)]")
    r_eq = checked_resistance(chosen, inputs["wind_speed"], coefficients)
    target = inputs["temp_air"] + inputs["poa_global"] * r_eq
    tau = capacity / inputs.unit * r_eq
    begin, steps = inputs.resume(initial)
    begin = None if begin is None else begin - bias
    temperature = relax(target, steps, tau, begin) + bias
    return without_name(inputs.restore(temperature), poa_global)


def driver_inputs(
    poa_global: Any,
    temp_air: Any,
    wind_speed: float | np.ndarray | pd.Series,
    step: float | None,
    times: Any,
) -> Inputs:
    columns = dict(poa_global=poa_global, temp_air=temp_air, wind_speed=wind_speed)
    inputs = read(columns, step, times, purpose="a dynamic temperature")
    wind = inputs["wind_speed"]
    if np.nanmin(wind, initial=0.0) < 0.0:
        at = int(np.nanargmin(wind))
        raise ValueError(
            f"wind_speed = {wind[at]:g} m/s at {at_time(inputs.index, at)} cannot be; "
            "replace such values with NaN, or clip(lower=0) an anemometer's offset"
        )
    return inputs


def checked_resistance(
    chosen: SteadyModel, wind: np.ndarray | pd.Series, coefficients: dict
) -> np.ndarray | pd.Series:
    """
    Resistance of a steady model, if it is positive at all winds.

    Parameters
    ----------
    chosen : SteadyModel
    wind : array or Series, shape (rows,)
        NaN is ignored. [m/s]
    coefficients : dict
        All coefficients of the steady model.

    Returns
    -------
    array or Series, shape (rows,)
        [K m²/W]

    Raises
    ------
    ValueError
        If it is zero or negative at a wind.
    """
    r_eq = chosen.resistance(wind, **coefficients)
    if not np.nanmin(np.asarray(r_eq), initial=np.inf) > 0:
        raise ValueError(
            f"{chosen.name} gives no loss of heat at {np.nanmax(wind):g} or "
            f"{np.nanmin(wind):g} m/s; check {coefficients}"
        )
    return r_eq


def without_name(temperature: Any, like: Any) -> np.ndarray | pd.Series:
    """The temperature without the name of an input, as pvlib's results."""
    return temperature.rename(None) if isinstance(like, pd.Series) else temperature


def smoothing_state(initial: Any, name: Any) -> float | pd.Series:
    """The state of one smoothed input."""
    if not isinstance(initial, Mapping | pd.DataFrame):
        raise ValueError(
            "initial holds the smoothed irradiance and wind of the piece before, as "
            "{'poa_global': ewm(poa_global, tau), 'wind_speed': ewm(wind_speed, tau)}; "
            "they cannot be computed from a temperature"
        )
    if name not in initial:
        raise ValueError(f"initial has no {name}; it holds {', '.join([*initial])}")
    return initial[name]


def refuse_dynamic(model: Callable) -> None:
    """
    Refuse functions of pvlib and of this package that have a memory of their own.

    Parameters
    ----------
    model : callable
        Perhaps a :class:`functools.partial` of such a function.

    Raises
    ------
    ValueError
        If it is one of them.
    """
    model = getattr(model, "func", model)  # of a functools.partial
    name = getattr(model, "__name__", "")
    if name in DYNAMIC and model.__module__.startswith(("pvlib.", "pvlib_fem.")):
        raise ValueError(
            f"{name} has a memory of its own, and smoothing its inputs would add "
            f"another; call {model.__module__}.{name} by itself, or give a steady model"
        )


def as_function(model: Any, coefficients: dict) -> Callable:
    """``f(poa_global, temp_air, wind_speed)`` of a named steady model or a callable."""
    if not callable(model):
        chosen = steady_model(model, coefficients)
        complete = chosen.complete(coefficients)
        return lambda poa, air, wind: (
            air + poa * checked_resistance(chosen, wind, complete)
        )
    refuse_dynamic(model)
    if np.ndim(coefficients.get("effective_irradiance", 0.0)):
        raise ValueError(
            "effective_irradiance is that of the moment, and poa_global is smoothed: "
            "their ratio would be no efficiency; leave it out"
        )
    try:
        signature = inspect.signature(model).parameters
    except (TypeError, ValueError):  # a compiled function has no signature
        return lambda poa, air, wind: model(poa, air, wind, **coefficients)
    drivers = ("poa_global", "temp_air", "wind_speed")
    calm = "wind_speed" not in signature and "poa_global" in signature
    if not any(p.kind is p.VAR_KEYWORD for p in signature.values()):
        free = [p for p in list(signature)[2 if calm else 3 :] if p not in drivers]
        if unknown := [name for name in coefficients if name not in free]:
            name = getattr(model, "__name__", repr(model))
            raise ValueError(
                f"{name} has no coefficient {', '.join(unknown)}; it has "
                f"{', '.join(free)}"
            )
    if calm:  # pvlib.temperature.ross: its third argument is not the wind
        return lambda poa, air, wind: model(poa, air, **coefficients) + 0.0 * wind
    return lambda poa, air, wind: model(poa, air, wind, **coefficients)
