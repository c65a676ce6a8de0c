"""Time steps of the module's nodes, in W/m²."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd

from pvlib_fem.simulator._constants import DAY, SIGMA, ZERO, even_step, times_of
from pvlib_fem.simulator._forcing import (
    EMISSIVITY,
    GROUND_EMISSIVITY,
    TO_DEEP,
    forcing,
)
from pvlib_fem.simulator._site import Site
from pvlib_fem.simulator._switches import Effects, amplitudes

BLOCK = DAY  # s; days are solved in parallel, see march

# the module: glass, back sheet with its share of frame, cell [1]_
CAPACITY = np.array([[4800.0], [4900.0], [1400.0]])  # glass, back, cell: J m⁻² K⁻¹
LINK = np.array([[450.0], [330.0]])  # glass, back to cell, 1/r there: W m⁻² K⁻¹
ROOM = 295.0  # K, temperature of the constant radiation coefficient

# water on glass
LATENT = 2.45e6  # J/kg
LEWIS = LATENT * 0.622 / (101325.0 * 1006.0 * 0.908)  # K/Pa, Le^(2/3) = 0.908
FILM_FULL, FILM_WHOLE = 0.25, 0.08  # kg/m²: runs off above, patchy below

JOIN = np.array([5e-5, 5e-5, 5e-5, 5e-5, 1e-5])[:, None]  # K and kg/m², see march


def simulate(weather: pd.DataFrame, site: Site, effects: Effects) -> pd.DataFrame:
    """
    True temperatures and heat flows of a module.

    Parameters
    ----------
    weather : DataFrame
        Result of `weather`, on even steps.
    site : Site
        The site.
    effects : dict
        Amplitudes of `SWITCHES` by name; other switches are off.

    Returns
    -------
    DataFrame
        ``temp_glass``, ``temp_back``, ``temp_cell``, ``temp_ground`` [°C] at the
        end of each step; ``film`` [kg/m²]; over the step ``h_front``, ``h_back``
        (convection [W/(m²K)], at the temperatures before), ``latent`` and
        ``sensible`` (heat to film, rain and snow [W/m²]), ``heat_glass``,
        ``heat_back``, ``heat_cell`` (heat from the sun and other sources minus loss to
        the sky [W/m²]), ``p_dc_per_area`` [W/m²].

    Raises
    ------
    ValueError
        If a switch is unknown, its amplitude is no finite number, or the steps
        are uneven.
    """
    on = amplitudes(effects)
    surfaces, series = forcing(weather, site, on)
    names = ["temp_glass", "temp_back", "temp_cell", "temp_ground", "film"]
    names += ["h_front", "h_back", "latent"]
    truth = dict(
        zip(names, march_days(on, even_step(times_of(weather)), surfaces, series))
    )
    truth["sensible"] = series["drain"] * truth["temp_glass"] - series["cooler"]
    truth["heat_glass"], truth["heat_back"] = series["heat"]
    truth["heat_cell"] = series["cell"]
    truth["p_dc_per_area"] = series["output"] + series["slope"] * truth["temp_cell"]
    for name in names[:4]:
        truth[name] = truth[name] - ZERO
    return pd.DataFrame(truth, index=weather.index)


def march_days(
    on: Mapping[str, float],
    step: float,
    surfaces: Mapping[str, Any],
    series: Mapping[str, np.ndarray],
) -> np.ndarray:
    """
    Nodes over time, with all days in parallel.

    Time constants of the module are minutes, of the ground hours. So all days are
    stepped at once, each from a start that the half day before gives. Then days are
    repeated whose start differs from the end of the day before (`JOIN`).
    """
    rows = len(series["air"])
    block = min(rows, round(BLOCK / step))
    count = -(-rows // block)

    def fold(values: np.ndarray) -> np.ndarray:
        # (…, rows) → (block, …, count); the last row fills up
        pad = [(0, 0)] * (values.ndim - 1) + [(0, count * block - rows)]
        values = np.pad(values, pad, mode="edge")
        values = values.reshape(*values.shape[:-1], count, block)
        return np.ascontiguousarray(np.moveaxis(values, -1, 0))

    series = {name: fold(values) for name, values in series.items()}
    nodes = np.empty((block, 8, count))

    def run(
        start: np.ndarray,
        part: slice = slice(None),
        days: slice | np.ndarray = slice(None),
    ) -> None:
        some = {name: values[part, ..., days] for name, values in series.items()}
        nodes[part, :, days] = advance_nodes(on, step, surfaces, some, start[:, days])

    eve, start = slice(block // 2, None), np.zeros((5, count))
    start[:4] = series["air"][block // 2]
    run(start, eve)
    start[:, 1:] = nodes[-1, :5, :-1]
    start[:, 0] = [series["air"][0, 0]] * 4 + [0.0]
    days = slice(None)
    while days is not None:
        run(start, days=days)
        gap = np.abs(nodes[-1, :5, :-1] - start[:, 1:])
        changed = 1 + np.flatnonzero((gap > JOIN).any(axis=0))
        start[:, changed] = nodes[-1, :5, changed - 1].T
        days = changed if len(changed) else None
    return np.moveaxis(nodes, 0, -1).reshape(8, -1)[:, :rows]


def advance_nodes(
    on: Mapping[str, float],
    step: float,
    surfaces: Mapping[str, Any],
    series: Mapping[str, np.ndarray],
    start: np.ndarray,
) -> np.ndarray:
    """
    Step all columns from ``start``: glass, back, cell, ground [K], film [kg/m²].

    The step is linearly implicit, with coefficients at the old state; the ground is
    explicit. Operations are in place, because this loop takes most of the time.
    """
    store, damp = on["thermal_storage"], max(on["rain"], on["dew"])
    shape, free = on["wind_shape"], on["natural_convection"]
    curved = on["radiative_loss"]
    natural, (a, b, c) = surfaces["natural"], surfaces["saturation"]
    glow = curved * SIGMA * EMISSIVITY
    even_glow = (1 - curved) * 4 * ROOM**3 * SIGMA * EMISSIVITY
    ground_glow = GROUND_EMISSIVITY * SIGMA
    holds, cell_holds = CAPACITY[:2] / step, CAPACITY[2, 0] / step
    cell_gives = cell_holds + LINK.sum()

    skin, (cell, ground, film) = start[:2].copy(), start[2:].copy()
    h, radiation = np.empty_like(skin), np.empty_like(skin)
    states = np.zeros((len(series["air"]), 8, skin.shape[1]))
    for i, air in enumerate(series["air"]):
        # convection: natural and forced in quadrature, or a linear approximation
        calm = natural(series["tilt"][i])(skin - air)
        calm *= free
        calm += (1 - free) * series["calm"][i]
        np.multiply(calm, calm, out=h)
        h += series["forced"][i]
        np.sqrt(h, out=h)
        h *= shape
        calm *= 1 - shape
        h += calm
        h += series["straight"][i]
        # radiation: σ(T⁴ − T_a⁴) = σ(T² + T_a²)(T + T_a)(T − T_a)
        np.multiply(skin, skin, out=radiation)
        radiation += air * air
        radiation *= skin + air
        radiation *= glow
        radiation += even_glow
        # each face: gain·T = load + link·T_cell
        gain = h + radiation
        load = gain * air
        gain += holds + LINK
        load += holds * skin
        load += series["heat"][i]
        gain[0] += series["drain"][i]
        load[0] += series["cooler"][i]
        if damp:
            celsius = skin[0] - ZERO
            pressure = a * np.exp(b * celsius / (c + celsius))
            deficit = pressure - series["vapour"][i]
            patch = damp * np.minimum(film / FILM_WHOLE, 1.0)
            rate = LEWIS * h[0] * np.where(deficit > 0, patch, on["dew"])
            deficit *= rate
            rate *= pressure * (b * c) / (c + celsius) ** 2
            gain[0] += rate
            load[0] += rate * skin[0] - deficit
        if store:
            fourth = ground**4
            load += store * series["view"][i] * (fourth - air**4)
            load[1] += store * surfaces["cavity"] * h[1] * (ground - air)
            flow = series["lit"][i] - ground_glow * fourth
            flow += ground_glow * surfaces["module"] * skin[1] ** 4
            flow -= (surfaces["loss"] + TO_DEEP) * ground
            ground = ground + flow * (step / surfaces["capacity"])
        # the faces in terms of the cell, then the cell, then the faces
        pull = LINK / gain
        given = pull * load
        top = cell_holds * cell
        top += series["cell"][i]
        top -= series["output"][i]
        top += given[0]
        top += given[1]
        pull *= LINK
        bottom = cell_gives + series["slope"][i]
        bottom -= pull[0]
        bottom -= pull[1]
        cell = top / bottom
        load += LINK * cell
        before, skin = skin[0], load / gain
        nodes = states[i]
        if damp:
            nodes[7] = rate * (skin[0] - before) + deficit
            film = film + step * (series["capture"][i] - nodes[7] / (LATENT * damp))
            np.clip(film, 0.0, FILM_FULL, out=film)
        nodes[:2], nodes[2], nodes[3] = skin, cell, ground if store else air
        nodes[4], nodes[5:7] = film, h
    return states
