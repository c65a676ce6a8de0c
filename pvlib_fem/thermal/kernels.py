"""
The dynamics row by row, compiled by numba: one loop, no temporaries.

The same equations as in :mod:`pvlib_fem.thermal.dynamics`, which is their reference.
Here a steady model is a straight line in wind on a scale of its own. What is called in
the loops takes numbers alone, since numba counts references to arrays.
"""

import numpy as np
from numba import njit

from pvlib_fem.relaxation import FORGOTTEN
from pvlib_fem.thermal.steady import LOGARITHM, LOSS

TILE = 1 << 10  # rows of which slopes are held at a time
APART = 8  # numbers between columns side by side, else all are of one set of the cache
STEADY, EWM, BALANCE = range(3)  # dynamics, by their names in capitals

inlined = njit(inline="always", error_model="numpy")
compiled = njit(cache=True, error_model="numpy")


@inlined
def resistance(scale, value, slope, clip, wind, loss):
    """Resistance with further losses, its slopes by the line, and by wind."""
    felt = min(wind, clip)
    r_eq, by_line = value + slope * felt, 1.0
    if scale == LOGARITHM:
        r_eq = by_line = np.exp(r_eq)
    elif scale == LOSS:
        r_eq = 1.0 / r_eq
        by_line = -(r_eq**2)
    if loss != 0.0:
        share = 1.0 / (1.0 + loss * r_eq)
        share = share if share > 0.0 else np.nan
        r_eq, by_line = r_eq * share, by_line * share**2
    by_wind = by_line * slope if wind < clip else 0.0
    return r_eq, by_line, by_line * felt, by_wind


@inlined
def fade(step, tau, usual):
    """Share of the past that is left after a step; 0 after a gap."""
    gap = step > FORGOTTEN * tau and step > 2.0 * usual
    return 0.0 if gap else np.exp(-step / tau)


@inlined
def faded(step, tau, usual):
    """The same, and its slope by tau."""
    decay = fade(step, tau, usual)
    return decay, decay * step / tau / tau


@inlined
def smooth(value, step, fading, tau, usual, since, begun, state, by_tau):
    """One row of a smoothed column: what is left of the past, and its next state."""
    if np.isnan(value):
        return np.nan, since + step, begun, state, by_tau
    decay, growth = fading
    if since > 0.0:
        decay, growth = faded(step + since, tau, usual)
    if not begun:
        decay = growth = 0.0
    by_tau = decay * by_tau + growth * (state - value)
    return decay, 0.0, 1.0, decay * state + (1.0 - decay) * value, by_tau


@inlined
def keep(state, since, begun, value, by_memory):
    state[0], state[1], state[2], state[3] = since, begun, value, by_memory


@compiled
def steady(law, _, columns, more, seen, __, slopes):
    scale, value, slope, clip = law
    _, air, heat, wind, loss, offset, temperature = columns
    (hot, by_heat), (lossy, by_loss), (aside, by_offset) = more
    (counts, measured), wanted, j = seen, slopes.size > 0, 0
    for i in range(len(air)):
        found = resistance(scale, value, slope, clip, wind[i], loss[i])
        r_eq, by_0, by_1, _ = found
        temperature[i] = air[i] + heat[i] * r_eq + offset[i]
        if not (wanted and counts[i]):
            continue
        slopes[0, j], slopes[1, j] = heat[i] * by_0, heat[i] * by_1
        slopes[4:-1, j] = 0.0
        for k in range(len(hot)):
            slopes[4 + hot[k], j] += by_heat[k, i] * r_eq
        for k in range(len(lossy)):
            slopes[4 + lossy[k], j] -= heat[i] * r_eq**2 * by_loss[k, i]
        for k in range(len(aside)):
            slopes[4 + aside[k], j] += by_offset[k, i]
        slopes[-1, j] = measured[i] - temperature[i]
        j += 1
    return j


@compiled
def ewm(law, memory, columns, more, seen, state, slopes):
    scale, value, slope, clip = law
    tau, unit, usual, leaky = memory
    steps, air, heat, wind, loss, offset, temperature = columns
    (hot, by_heat), (lossy, by_loss), (aside, by_offset) = more
    (counts, measured), wanted, j = seen, slopes.size > 0, 0
    part, lost = state[0, 4:], state[1, 4:]
    since_h, begun_h, felt, felt_by_tau = state[0, :4]
    since_w, begun_w, windy, windy_by_tau = state[1, :4]
    since_l, begun_l, leaks, leaks_by_tau = state[2, :4]
    last, fading, stays = np.nan, (0.0, 0.0), np.nan
    for i in range(len(air)):
        step = steps[i]
        if step != last:
            last, fading = step, faded(step, tau, usual)
        left, since_h, begun_h, felt, felt_by_tau = smooth(
            heat[i], step, fading, tau, usual, since_h, begun_h, felt, felt_by_tau
        )
        there, since_w, begun_w, windy, windy_by_tau = smooth(
            wind[i], step, fading, tau, usual, since_w, begun_w, windy, windy_by_tau
        )
        known = not (np.isnan(left) or np.isnan(there))
        if leaky:
            stays, since_l, begun_l, leaks, leaks_by_tau = smooth(
                loss[i], step, fading, tau, usual, since_l, begun_l, leaks, leaks_by_tau
            )
            known = known and not np.isnan(stays)
        found = resistance(scale, value, slope, clip, windy, leaks)
        r_eq, by_0, by_1, by_wind = found
        temperature[i] = air[i] + felt * r_eq + offset[i] if known else np.nan
        if not wanted:
            continue
        if not np.isnan(left):
            for k in range(len(hot)):
                part[k] = left * part[k] + (1.0 - left) * by_heat[k, i]
        if not np.isnan(stays):
            for k in range(len(lossy)):
                lost[k] = stays * lost[k] + (1.0 - stays) * by_loss[k, i]
        if not counts[i]:
            continue
        slopes[0, j], slopes[1, j] = felt * by_0, felt * by_1
        by_tau = by_wind * windy_by_tau - r_eq**2 * leaks_by_tau
        slopes[2, j] = (felt_by_tau * r_eq + felt * by_tau) / unit
        slopes[4:-1, j] = 0.0
        for k in range(len(hot)):
            slopes[4 + hot[k], j] += part[k] * r_eq
        for k in range(len(lossy)):
            slopes[4 + lossy[k], j] -= felt * r_eq**2 * lost[k]
        for k in range(len(aside)):
            slopes[4 + aside[k], j] += by_offset[k, i]
        slopes[-1, j] = measured[i] - temperature[i]
        j += 1
    keep(state[0], since_h, begun_h, felt, felt_by_tau)
    keep(state[1], since_w, begun_w, windy, windy_by_tau)
    keep(state[2], since_l, begun_l, leaks, leaks_by_tau)
    return j


@compiled
def balance(law, memory, columns, more, seen, state, slopes):
    scale, value, slope, clip = law
    capacity, unit, usual, _ = memory
    steps, air, heat, wind, loss, offset, temperature = columns
    (hot, by_heat), (lossy, by_loss), (aside, by_offset) = more
    (counts, measured), wanted, j, own = seen, slopes.size > 0, 0, state[1, 4:]
    since, begun, module, by_memory = state[0, :4]
    of_0, of_1 = state[1, 0], state[1, 1]
    for i in range(len(air)):
        step = steps[i] + since
        found = resistance(scale, value, slope, clip, wind[i], loss[i])
        r_eq, by_0, by_1, _ = found
        target = air[i] + heat[i] * r_eq
        if np.isnan(target):
            since, temperature[i] = step, np.nan
        else:
            tau, since = capacity * r_eq, 0.0
            decay = fade(step, tau, usual) if begun else 0.0
            fall, rise = (module - target) * decay * (step / tau), 1.0 - decay
            module, begun = decay * module + rise * target, 1.0
            temperature[i] = module + offset[i]
        if not wanted:
            continue
        if not np.isnan(target):
            by_r = rise * heat[i] + fall / r_eq
            of_0 = decay * of_0 + by_r * by_0
            of_1 = decay * of_1 + by_r * by_1
            by_memory = decay * by_memory + fall / (capacity * unit)
            for k in range(len(own) - 1):
                own[k] *= decay
            for k in range(len(hot)):
                own[hot[k]] += rise * r_eq * by_heat[k, i]
            for k in range(len(lossy)):
                own[lossy[k]] -= by_r * r_eq**2 * by_loss[k, i]
        if not counts[i]:
            continue
        slopes[0, j], slopes[1, j], slopes[2, j] = of_0, of_1, by_memory
        for k in range(len(own) - 1):
            slopes[4 + k, j] = own[k]
        for k in range(len(aside)):
            slopes[4 + aside[k], j] += by_offset[k, i]
        slopes[-1, j] = measured[i] - temperature[i]
        j += 1
    keep(state[0], since, begun, module, by_memory)
    state[1, 0], state[1, 1] = of_0, of_1
    return j


@njit(cache=True, error_model="numpy", fastmath={"reassoc", "contract"})
def add_products(slopes, rows, total):
    """Add products of all columns with each other, over the first rows."""
    for a in range(len(slopes)):
        for b in range(a + 1):
            product = 0.0
            for j in range(rows):
                product += slopes[a, j] * slopes[b, j]
            total[a, b] += product
            if a != b:
                total[b, a] += product


@inlined
def tile(column, first, last, rows):
    """Rows of a column, or as many of one that is the same in all."""
    return column[first:last] if len(column) == rows else column[: last - first]


@compiled
def answer(dynamics, law, memory, columns, more, seen, edges, state, total):
    """
    Temperature of rows that follow each other, and products over parts of them.

    So few rows at a time that their slopes stay in the innermost cache. A column of
    no more than these is the same in all of them.
    """
    steps, air, heat, wind, loss, offset, temperature = columns
    (hot, by_heat), (lossy, by_loss), (aside, by_offset) = more
    counts, measured = seen
    wanted, end = len(total) > 0, len(air)
    slopes = np.empty((state.shape[1], TILE + APART if wanted else 0))
    if wanted:
        slopes[2], slopes[3] = 0.0, 1.0
    for part in range(len(edges) - 1):
        for first in range(edges[part], edges[part + 1], TILE):
            a, b = first, min(first + TILE, edges[part + 1])
            given = (
                law,
                memory,
                (
                    tile(steps, a, b, end),
                    air[a:b],
                    heat[a:b],
                    wind[a:b],
                    tile(loss, a, b, end),
                    tile(offset, a, b, end),
                    tile(temperature, a, b, end),
                ),
                (
                    (hot, by_heat[:, a:b]),
                    (lossy, by_loss[:, a:b]),
                    (aside, by_offset[:, a:b]),
                ),
                (counts[a:b], measured[a:b]),
                state,
                slopes,
            )
            if dynamics == STEADY:
                rows = steady(*given)
            elif dynamics == EWM:
                rows = ewm(*given)
            else:
                rows = balance(*given)
            if wanted:
                add_products(slopes, rows, total[part])
