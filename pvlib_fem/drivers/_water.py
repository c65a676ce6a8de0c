"""Rain, the water film, soiling, and snow."""

from itertools import accumulate

import numpy as np

from pvlib_fem._record.inputs import Inputs
from pvlib_fem.drivers._lagged_inputs import HOUR, smoothed

MAGNUS = 17.62, 243.12  # constants of vapour pressure over water: -, °C
#: latent loss per hPa relative to all other loss: Lewis's 1.5 for one wet face, divided
#: among two faces that lose heat to the air, with a fifth by radiation [K/hPa]
LATENT = 0.6
NEWTON = 6  # steps, to an error far below a thousandth: the balance is convex
DAY = 86400.0  # s
SOAKED = 5.0  # the module is fully wet if the smoothed rain times this exceeds 1
#: °C, below which precipitation may be snow: 95 % of stations have equal parts of rain
#: and snow below it (Jennings et al., 2018, doi:10.1038/s41467-018-03629-7)
FROST = 2.4
SNOWFALL = 1.0  # mm/h of water, of an hour with steady snow: 1 cm of fresh snow
#: mm of water per K and day, which melt above 0 °C; 2.5 to 5.5 are usual (Hock, 2003,
#: doi:10.1016/S0022-1694(03)00257-9)
MELTS = 4.0
DEEP = 60.0  # mm of water, of 60 cm of fresh snow


def saturation(celsius: np.ndarray) -> np.ndarray:
    """
    Saturation vapour pressure over water, by Magnus. [hPa]

    Parameters
    ----------
    celsius : float or array
        Temperature. [°C]

    Returns
    -------
    float or array
        Of the shape of ``celsius``.
    """
    return 6.112 * np.exp(MAGNUS[0] * celsius / (MAGNUS[1] + celsius))


def wetness(
    precipitation: np.ndarray, inputs: Inputs, *, drying: float = 1800.0
) -> np.ndarray:
    """
    Share of a module that is wet: 1 in rain, and drying after it. [-]

    Parameters
    ----------
    precipitation : array, shape (rows,)
        [mm/h]
    inputs : Inputs
        For the steps.
    drying : float, default 1800
        Time constant of drying. [s]

    Returns
    -------
    array, shape (rows,)
        From 0 to 1; NaN where ``precipitation`` is.
    """
    falling = np.where(np.isnan(precipitation), np.nan, precipitation > 0)
    return np.minimum(1.0, SOAKED * smoothed(falling, inputs, drying))


def film_vapour(
    wetness: np.ndarray,
    relative_humidity: np.ndarray,
    temp_air: np.ndarray,
    temp_base: np.ndarray,
    inputs: Inputs | None,
) -> np.ndarray:
    """
    Excess vapour pressure of a wet module over the air, times wetness. [hPa]

    The film makes the module colder than a dry one, ``temp_base``. In balance, its loss
    by evaporation and to the air equals the loss of the dry module to the air, as for
    a wet-bulb thermometer.

    Parameters
    ----------
    wetness : array, shape (rows,)
        Share of the module that is wet. [-]
    relative_humidity : array, shape (rows,)
        [%]
    temp_air, temp_base : array, shape (rows,)
        Temperature of the air, and of a dry module. [°C]
    inputs : Inputs or None
        Not used.

    Returns
    -------
    array, shape (rows,)
        At least 0.
    """
    air = relative_humidity / 100.0 * saturation(temp_air)
    wet, latent = temp_base, LATENT * wetness
    for _ in range(NEWTON):
        full = saturation(wet)
        slope = full * MAGNUS[0] * MAGNUS[1] / (MAGNUS[1] + wet) ** 2
        over = wet - temp_base + latent * (full - air)
        wet = wet - over / (1.0 + latent * slope)
    return wetness * np.maximum(saturation(wet) - air, 0.0)


def days_since_rain(
    precipitation: np.ndarray,
    inputs: Inputs,
    *,
    cleaning: float = 1.0,
    within: float = 3.0,
    dirtiest: float = 60.0,
    grace: float = 0.0,
) -> np.ndarray:
    """
    Time since rain cleaned the module, or the record began [1]_ [2]_. [days]

    Rain cleans the module if enough of it falls within some hours: 1 mm as in
    :func:`pvlib.soiling.hsu`, 6 mm in 24 h as in :func:`pvlib.soiling.kimber`.

    Parameters
    ----------
    precipitation : array, shape (rows,)
        NaN counts as no rain. [mm/h]
    inputs : Inputs
        For the times.
    cleaning : float, default 1
        Rain that cleans the module. [mm]
    within : float, default 3
        Duration in which it falls. [h]
    dirtiest : float, default 60
        Time after which soiling is constant. [days]
    grace : float, default 0
        Time after a rain that cleaned, in which damp ground gives no dust; 14 days by
        Kimber et al. It is not counted. [days]

    Returns
    -------
    array, shape (rows,)
        From 0 to ``dirtiest``.

    References
    ----------
    .. [1] M. Coello and L. Boyle, "Simple Model for Predicting Time Series Soiling
       of Photovoltaic Panels", IEEE J. Photovoltaics 9, 1382 (2019),
       :doi:`10.1109/JPHOTOV.2019.2919628`.
    .. [2] A. Kimber et al., "The Effect of Soiling on Large Grid-Connected
       Photovoltaic Systems in California and the Southwest Region of the United
       States", WCPEC 2006, :doi:`10.1109/WCPEC.2006.279690`.
    """
    seconds = inputs.seconds
    rain = np.nan_to_num(precipitation)
    hours = np.diff(seconds, prepend=seconds[0]) / HOUR
    fallen = np.cumsum(rain * hours)
    wet = np.flatnonzero(rain > 0)
    before = np.interp(seconds[wet] - within * HOUR, seconds, fallen, left=0.0)
    cleans = np.zeros(len(rain), dtype=bool)
    cleans[wet] = fallen[wet] - before >= cleaning
    # a record begins without a rain, and so without its days of grace
    start = seconds[0] - grace * DAY
    return np.clip(seconds_since(cleans, seconds, start) / DAY - grace, 0.0, dirtiest)


def hours_since_rain(
    precipitation: np.ndarray, inputs: Inputs, *, longest: float = 72.0
) -> np.ndarray:
    """
    Time since the last rain; a record begins dry. [h]

    Parameters
    ----------
    precipitation : array, shape (rows,)
        NaN counts as no rain. [mm/h]
    inputs : Inputs
        For the times.
    longest : float, default 72
        Time after which all is dry. [h]

    Returns
    -------
    array, shape (rows,)
        From 0 to ``longest``.
    """
    falls = np.nan_to_num(precipitation) > 0.0
    since = seconds_since(falls, inputs.seconds, -np.inf)
    return np.minimum(since / HOUR, longest)


def seconds_since(rows: np.ndarray, seconds: np.ndarray, start: float) -> np.ndarray:
    """Time since the last of some rows; before the first of them, since a start."""
    return seconds - np.maximum.accumulate(np.where(rows, seconds, start))


def snow_cover(
    snow_depth: np.ndarray,
    temp_air: np.ndarray,
    poa_global: np.ndarray,
    inputs: Inputs,
    *,
    snowfall: float = 0.5,
) -> np.ndarray:
    """
    Whether snow lies on the module, from snow depth on the ground [1]_. [-]

    Snow covers the module when the depth grows by more than ``snowfall`` in about an
    hour. It has slid off after one and a half hours with more than 50 W/m² and air
    warmer than −G/80.

    Parameters
    ----------
    snow_depth : array, shape (rows,)
        On the ground. [cm]
    temp_air : array, shape (rows,)
        [°C]
    poa_global : array, shape (rows,)
        [W/m²]
    inputs : Inputs
        For the steps.
    snowfall : float, default 0.5
        Half a step of the usual gauge. [cm]

    Returns
    -------
    array of float, shape (rows,)
        1 or 0; NaN where an input is.

    References
    ----------
    .. [1] B. Marion et al., "Measured and modeled photovoltaic system energy
       losses from snow for Colorado and Wisconsin locations", Solar Energy 97,
       112 (2013), :doi:`10.1016/j.solener.2013.07.029`, as in
       :func:`pvlib.snow.coverage_nrel`.
    """
    known = 0.0 * (snow_depth + temp_air + poa_global)
    grows = snow_depth - smoothed(snow_depth, inputs, HOUR) > snowfall
    warm = may_slide(temp_air, poa_global) & (poa_global > 50.0)
    slid = smoothed(warm * 1.0, inputs, HOUR) > 1.0 - np.exp(-1.5)
    rows = np.arange(len(known))
    grew, slid = (
        np.maximum.accumulate(np.where(event, rows, -1)) for event in (grows, slid)
    )
    return known + (grew > slid)


def snow_left(
    snow_cover: np.ndarray,
    snow_depth: np.ndarray,
    temp_air: np.ndarray,
    poa_global: np.ndarray,
    inputs: Inputs,
    *,
    lying: float = 1.0,
    sliding: float = 10.0,
) -> np.ndarray:
    """
    Part of the module under remaining snow where ``snow_cover`` is 0. [-]

    In air warmer than −G/80 snow slides off gradually: two tenths of the module per
    hour, times the sine of the tilt [1]_. No snow remains with little on the
    ground [2]_.

    Parameters
    ----------
    snow_cover : array, shape (rows,)
        1 where snow covers the module. [-]
    snow_depth : array, shape (rows,)
        On the ground. [cm]
    temp_air : array, shape (rows,)
        [°C]
    poa_global : array, shape (rows,)
        [W/m²]
    inputs : Inputs
        For the times.
    lying : float, default 1
        Depth up to which no snow remains on the module. [cm]
    sliding : float, default 10
        Time in such air until all snow has slid off; the default is that of a tilt of
        30°. [h]

    Returns
    -------
    array, shape (rows,)
        From 0 to 1; NaN where ``snow_cover`` is.

    References
    ----------
    .. [1] B. Marion et al., "Measured and modeled photovoltaic system energy
       losses from snow for Colorado and Wisconsin locations", Solar Energy 97,
       112 (2013), :doi:`10.1016/j.solener.2013.07.029`, as in
       :func:`pvlib.snow.coverage_nrel`.
    .. [2] D. Ryberg and J. Freeman, "Integration, Validation, and Application of a PV
       Snow Coverage Model in SAM", NREL/TP-6A20-68705 (2017).
    """
    seconds = inputs.seconds
    hours = np.diff(seconds, prepend=seconds[0]) / HOUR
    warm = np.cumsum(may_slide(temp_air, poa_global) * hours)
    rows = np.arange(len(hours))
    covered = np.maximum.accumulate(np.where(snow_cover > 0.0, rows, 0))
    remaining = np.clip(1.0 - (warm - warm[covered]) / sliding, 0.0, 1.0)
    return (1.0 - snow_cover) * remaining * (snow_depth > lying)


def may_slide(temp_air: np.ndarray, poa_global: np.ndarray) -> np.ndarray:
    """Whether snow can slide off a module at this air temperature and irradiance."""
    return temp_air > poa_global / -80.0


def snow_at_most(temp_air: np.ndarray, hours: np.ndarray) -> np.ndarray:
    """
    Snow that can lie on modules, sensors and ground, as far as the air tells. [mm]

    It snows in every hour below 2.4 °C, and in each without a value, up to a depth of
    60 cm; and what lies melts by degree-days [1]_. Where the result is 0, no snow lies.

    Parameters
    ----------
    temp_air : array, shape (rows,)
        Hourly means. [°C]
    hours : array of int, shape (rows,)
        Time of each, increasing. [h]

    Returns
    -------
    array, shape (rows,)
        Water of it at the end of each hour. Before the first, as much as can lie.

    References
    ----------
    .. [1] R. Hock, "Temperature index melt modelling in mountain areas", Journal of
       Hydrology 282, 104 (2003), :doi:`10.1016/S0022-1694(03)00257-9`.
    """
    unknown = np.isnan(temp_air)
    known = np.where(unknown, 0.0, temp_air)
    change = SNOWFALL * (unknown | (known < FROST))
    change -= MELTS * np.maximum(known, 0.0) / 24.0
    change += SNOWFALL * (np.diff(hours, prepend=hours[:1] - 1) - 1)

    def after(depth: float, change: float) -> float:
        depth += change
        return 0.0 if depth < 0.0 else min(depth, DEEP)

    lying = accumulate(change.tolist(), after, initial=DEEP)
    return np.fromiter(lying, float, len(change) + 1)[1:]
