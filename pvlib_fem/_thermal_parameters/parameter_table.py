"""The table of a fit's thermal parameters."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd

from pvlib_fem._thermal_parameters.given_record import NEEDED, Measured, measured_of
from pvlib_fem._thermal_parameters.nmot import nmot_rows
from pvlib_fem._thermal_parameters.parameter_rows import Row, table_of
from pvlib_fem._thermal_parameters.steady_parameters import (
    HEIGHT,
    Steady,
    conventions,
    memory_rows,
    nmot_row,
    steady_rows,
)
from pvlib_fem._thermal_parameters.t98 import hottest_rows
from pvlib_fem._thermal_parameters.unit_mass import unit_mass_rows
from pvlib_fem._translation import USUAL_WINDS


def thermal_parameters(
    fit: Any,
    out_of: Callable,
    data: pd.DataFrame | None = None,
    holdout: Any = None,
    typical_year: Any = None,
    wind_height: float | None = None,
    exponent: float = 1 / 7,
    surface_tilt: Any = None,
    module_efficiency: float = 0.2,
    absorptance: float = 0.9,
    deltaT: float | None = None,
    with_bias: bool = True,
) -> pd.DataFrame:
    """
    The thermal parameters of a fit, see :meth:`pvlib_fem.FemFit.thermal_parameters`.

    Parameters
    ----------
    fit : FemFit
    out_of : callable
        Function from a record, its fitted rows and ``holdout`` to the held-out rows.
    data : DataFrame, optional
        The record; by default that of the fit.
    holdout : Series of bool, optional
        Held-out rows of ``data``.
    typical_year : DataFrame, optional
        Weather of a year for T98.
    wind_height : float, optional
        Height of the anemometer above ground. [m]
    exponent : float, default 1/7
        Exponent of the wind profile. [-]
    surface_tilt : float, optional
        Tilt of the module, for the conditions. [°]
    module_efficiency, absorptance : float, default 0.2 and 0.9
        Of the module. [-]
    deltaT : float, optional
        Cell minus back temperature at 1000 W/m²; by default that of the fit's file. [K]
    with_bias : bool, default True
        Whether the fit's bias is part of the module's temperature.

    Returns
    -------
    DataFrame
        See :func:`~pvlib_fem._thermal_parameters.parameter_rows.table_of`.

    Raises
    ------
    ValueError
        If an argument is out of range, or a column is missing.
    """
    check(wind_height, exponent, surface_tilt, module_efficiency, absorptance, deltaT)
    if deltaT is None:
        deltaT = cell_of(fit)
    measured = measured_of(fit, data, out_of, holdout)
    steady = Steady(
        fit,
        deltaT,
        with_bias,
        None if wind_height is None else (wind_height / HEIGHT) ** exponent,
        USUAL_WINDS if measured is None else measured.winds,
        measured,
    )
    why = "" if measured is not None else NEEDED
    rows = [
        *steady_rows(steady, conventions(module_efficiency, absorptance)),
        nmot_row(steady),
        *nmot_rows(measured, why, surface_tilt),
        *unit_mass_rows(measured, why),
        *memory_rows(steady),
        *hottest_rows(measured, why, steady, typical_year),
    ]
    words = conditions(fit, measured, steady, wind_height, exponent, surface_tilt)
    return table_of(replace(one, conditions=words(one)) for one in rows)


def cell_of(fit: Any) -> float | None:
    """Cell minus back temperature at 1000 W/m² in the fit's file, or None. [K]"""
    if "deltaT" in fit.cell:
        return fit.cell["deltaT"]
    return 1000.0 * fit.cell["k_bs_c"] if "k_bs_c" in fit.cell else None


def check(
    wind_height: float | None,
    exponent: float,
    surface_tilt: Any,
    module_efficiency: float,
    absorptance: float,
    deltaT: float | None,
) -> None:
    """Refuse arguments out of range."""
    if wind_height is not None and not 0.0 < wind_height <= 200.0:
        raise ValueError(f"wind_height = {wind_height} must be a height, above 0 m")
    if not 0.0 <= exponent <= 1.0:
        raise ValueError(f"exponent = {exponent} of the wind must be from 0 to 1")
    if surface_tilt is not None and not 0.0 <= surface_tilt <= 180.0:
        raise ValueError(f"surface_tilt = {surface_tilt} must be from 0 to 180°")
    if not 0.0 < absorptance <= 1.0:
        raise ValueError(f"absorptance = {absorptance} must be a share, above 0 to 1")
    if not 0.0 <= module_efficiency < absorptance:
        raise ValueError(
            f"module_efficiency = {module_efficiency} must be a share below the "
            f"absorptance, {absorptance}"
        )
    if deltaT is not None and not -5.0 <= deltaT <= 20.0:
        raise ValueError(
            f"deltaT = {deltaT} K at 1000 W/m² cannot be; pvlib's sets have 0 to 3 K"
        )


def conditions(
    fit: Any,
    measured: Measured | None,
    steady: Steady,
    wind_height: float | None,
    exponent: float,
    surface_tilt: Any,
) -> Callable:
    """A function that returns the conditions of a row."""
    record = fit.summary
    start, end, sun = record.start, record.end, "more than 20 W/m² by day"
    if measured is not None:
        start, end = measured.record.index[[0, -1]]
        poa = measured.record["poa_global"][measured.counts]
        if len(poa):
            sun = f"{poa.min():.0f} to {poa.max():.0f} W/m²"
    period = f"{start:%Y-%m-%d} to {end:%Y-%m-%d}"
    tilt = "tilt unknown" if surface_tilt is None else f"tilt {surface_tilt:g}°"
    at = "unknown height" if wind_height is None else f"{wind_height:g} m"
    winds = f"{steady.winds[0]:.1f} to {steady.winds[-1]:.1f} m/s"
    wind_at = f"wind {winds} at {at}"
    if measured is not None and "wind_speed" in measured.record.absent:
        wind_at = "winds that nobody measured"
    bias, names = fit.coefficients["bias"], [effect.name for effect in fit.effects]
    taken = (
        f"bias {bias:+.2f} K {'added at 800 W/m²' if steady.with_bias else 'ignored'}"
    )
    if names and measured is None:
        taken += f"; without {', '.join(names)}"
    elif names:
        mean = steady.effects(fit.coefficients)
        taken += f"; {', '.join(names)}, in the mean {mean:+.2f} K, added at 800 W/m²"

    def words(row: Row) -> str:
        wind = wind_at
        if row.convention.endswith("10 m"):
            wind += f", taken to 10 m by (10 m / {at})^{exponent:.3g}"
        kind = f"; {taken}" if np.isfinite(row.mismatch) else ""
        return f"{period}; {sun}; {wind}; {tilt}{kind}"

    return words
