"""
The dynamics tile by tile, compiled by numba: temporaries are as long as a tile.

The equations are documented in :mod:`pvlib_fem._thermal.dynamics`, the reference that
the tests compare with. Here a steady model is a straight line in wind on a scale of its
own. Only the recursions run row by row. All else is loops without branches over the
rows of a tile, which the compiler vectorizes. So rows that do not count have slopes of
zero instead of being skipped. Only rows before the first and after the last that count
in a tile are skipped.
"""

from math import factorial
from typing import Any

import numpy as np
from numba import njit

from pvlib_fem._relaxation import FADED, FORGOTTEN
from pvlib_fem._thermal.steady_models import LOGARITHM, LOSS

TILE = 1 << 9  # rows, so that the slopes and their inputs stay in the cache
APART = 8  # padding between columns; without it all map to one set of the cache
WORK = 10  # columns of a tile that are held in addition to its slopes
SMALL = 0.5  # exponent up to which the series below is as exact as the function
SERIES = tuple(1.0 / factorial(k) for k in range(14, -1, -1))
STEADY, EWM, BALANCE = range(3)  # dynamics, by their names in capitals

unsigned = np.uint64  # type of row numbers; else numba tests each for a negative index

inlined = njit(inline="always", error_model="numpy")
# fused multiply-add: each recursion waits for its product and sum
compiled = njit(cache=True, error_model="numpy", fastmath={"contract"})


@inlined
def resistances(
    law: tuple,
    leaky: bool,
    winds: np.ndarray,
    losses: np.ndarray,
    r_eq: np.ndarray,
    by_line: np.ndarray,
    shown: tuple,
) -> None:
    """Write resistances with further losses, and their slopes by the model's line."""
    scale, value, slope, clip = law
    first, last = shown
    for i in range(first, last):
        r_eq[i], by_line[i] = value + slope * min(winds[i], clip), 1.0
    if scale == LOGARITHM:
        for i in range(first, last):
            r_eq[i] = by_line[i] = np.exp(r_eq[i])
    elif scale == LOSS:
        for i in range(first, last):
            r_eq[i] = 1.0 / r_eq[i]
            by_line[i] = -r_eq[i] * r_eq[i]
    if leaky:
        for i in range(first, last):
            share = 1.0 / (1.0 + losses[i] * r_eq[i])
            share = share if share > 0.0 else np.nan
            r_eq[i], by_line[i] = r_eq[i] * share, by_line[i] * share * share


@inlined
def fade(step: float, ratio: float, usual: float) -> float:
    """Weight of the past after ``ratio`` time constants; 0 after a gap."""
    gap = ratio > FORGOTTEN and step > 2.0 * usual
    return 0.0 if gap else np.exp(-ratio)


@inlined
def decay_all(
    steps: np.ndarray, ratios: np.ndarray, usual: float, decays: np.ndarray
) -> None:
    """Write the weight of the past of some rows, by a series for small ratios."""
    small = True
    for i in range(len(ratios)):
        small &= ratios[i] <= SMALL
    for i in range(len(ratios) if small else 0):
        x = -ratios[i]
        decays[i] = SERIES[0]
        for k in range(1, len(SERIES)):
            decays[i] = decays[i] * x + SERIES[k]
    for i in range(0 if small else len(ratios)):
        decays[i] = fade(steps[i], ratios[i], usual)


@inlined
def fade_with_slope(step: float, tau: float, usual: float) -> tuple[float, float]:
    """Weight of the past after a step, and its slope by tau."""
    decay = fade(step, step / tau, usual)
    return decay, decay * step / tau / tau


@inlined
def write_state(
    state: np.ndarray, since: float, begun: float, value: float, by_memory: float
) -> None:
    state[0], state[1], state[2], state[3] = since, begun, value, by_memory


@inlined
def is_unbroken(values: np.ndarray, state: np.ndarray) -> bool:
    """Whether a column has no NaN, and the row before it had none."""
    whole = state[0] == 0.0 and state[1] == 1.0
    for i in range(len(values)):
        whole &= values[i] == values[i]
    return whole


@inlined
def has_even_steps(steps: np.ndarray) -> bool:
    """Whether all steps are equal."""
    same = True
    for i in range(len(steps)):
        same &= steps[i] == steps[0]
    return same


@compiled
def smooth(
    values: np.ndarray,
    steps: np.ndarray,
    tau: float,
    usual: float,
    state: np.ndarray,
    means: np.ndarray,
    by_tau: np.ndarray,
    decays: np.ndarray,
) -> None:
    """Write a smoothed column, its slopes by tau, and the weight of the past."""
    since, begun, mean, slope = state[:4]
    last, fading = np.nan, (0.0, 0.0)
    for i in range(len(values)):
        step = steps[i]
        if step != last:
            last, fading = step, fade_with_slope(step, tau, usual)
        means[i], by_tau[i], decays[i] = mean, slope, np.nan
        if np.isnan(values[i]):
            since += step
            continue
        decay, growth = (
            fading if since == 0.0 else fade_with_slope(step + since, tau, usual)
        )
        if not begun:
            decay = growth = 0.0
        slope = decay * slope + growth * (mean - values[i])
        mean = decay * mean + (1.0 - decay) * values[i]
        means[i], by_tau[i], decays[i] = mean, slope, decay
        since, begun = 0.0, 1.0
    write_state(state, since, begun, mean, slope)


@compiled
def smooth_both(
    one: np.ndarray,
    two: np.ndarray,
    step: float,
    tau: float,
    usual: float,
    state: np.ndarray,
    into: tuple,
    into_two: tuple,
) -> float:
    """Smooth two columns without gaps in one loop: their recursions run in parallel."""
    decay, growth = fade_with_slope(step, tau, usual)
    (mean, slope), (mean_two, slope_two) = state[0, 2:4], state[1, 2:4]
    (means, slopes), (means_two, slopes_two) = into, into_two
    for i in range(len(one)):
        slope = decay * slope + growth * (mean - one[i])
        mean = decay * mean + (1.0 - decay) * one[i]
        slope_two = decay * slope_two + growth * (mean_two - two[i])
        mean_two = decay * mean_two + (1.0 - decay) * two[i]
        means[i], slopes[i] = mean, slope
        means_two[i], slopes_two[i] = mean_two, slope_two
    state[0, 2:4], state[1, 2:4] = (mean, slope), (mean_two, slope_two)
    return decay


@inlined
def write_residual(
    kept: tuple, measured: np.ndarray, temperature: np.ndarray, slopes: np.ndarray
) -> None:
    """Write the residual and the slope by a bias; set the other slopes to zero."""
    counts, first, last = kept
    slopes[4:-1, first:last] = 0.0
    for i in range(first, last):
        slopes[3, i] = 1.0 if counts[i] else 0.0
        slopes[-1, i] = measured[i] - temperature[i] if counts[i] else 0.0


@inlined
def set_aside(
    kept: tuple, aside: np.ndarray, by_offset: np.ndarray, slopes: np.ndarray
) -> None:
    """Add the slopes by terms that add to the temperature itself."""
    counts, first, last = kept
    for k in range(len(aside)):
        for i in range(first, last):
            slopes[4 + aside[k], i] += by_offset[k, i] if counts[i] else 0.0


@compiled
def steady(
    law: tuple,
    memory: tuple,
    columns: tuple,
    more: tuple,
    seen: tuple,
    _: np.ndarray,
    slopes: np.ndarray,
    work: np.ndarray,
) -> None:
    clip, leaky = law[3], memory[3]
    __, air, heat, wind, loss, offset, temperature = columns
    (hot, by_heat), (lossy, by_loss), (aside, by_offset) = more
    (kept, shown, measured), rows = seen, len(air)
    counts, first, last = kept
    r_eq, by_line = work[0, :rows], work[1, :rows]
    resistances(law, leaky, wind, loss, r_eq, by_line, shown)
    for i in range(shown[0], shown[1]):
        temperature[i] = air[i] + heat[i] * r_eq[i] + offset[i]
    if slopes.size == 0:
        return
    write_residual(kept, measured, temperature, slopes)
    for i in range(first, last):
        by_0 = heat[i] * by_line[i]
        slopes[0, i] = by_0 if counts[i] else 0.0
        slopes[1, i] = by_0 * min(wind[i], clip) if counts[i] else 0.0
    for k in range(len(hot)):
        for i in range(first, last):
            slopes[4 + hot[k], i] += by_heat[k, i] * r_eq[i] if counts[i] else 0.0
    for k in range(len(lossy)):
        for i in range(first, last):
            by_r = heat[i] * r_eq[i] * r_eq[i] * by_loss[k, i]
            slopes[4 + lossy[k], i] -= by_r if counts[i] else 0.0
    set_aside(kept, aside, by_offset, slopes)


@compiled
def ewm(
    law: tuple,
    memory: tuple,
    columns: tuple,
    more: tuple,
    seen: tuple,
    state: np.ndarray,
    slopes: np.ndarray,
    work: np.ndarray,
) -> None:
    slope, clip = law[2], law[3]
    tau, unit, usual, leaky = memory
    steps, air, heat, wind, loss, offset, temperature = columns
    (hot, by_heat), (lossy, by_loss), (aside, by_offset) = more
    (kept, shown, measured), rows = seen, len(air)
    counts, first, last = kept
    felts, felts_by_tau, decays = work[0, :rows], work[1, :rows], work[2, :rows]
    winds, winds_by_tau = work[3, :rows], work[4, :rows]
    leaks, leaks_by_tau, stays = work[5, :rows], work[6, :rows], work[7, :rows]
    r_eq, by_line = work[8, :rows], work[9, :rows]
    if (
        has_even_steps(steps)
        and is_unbroken(heat, state[0])
        and is_unbroken(wind, state[1])
    ):
        into = (felts, felts_by_tau), (winds, winds_by_tau)
        decays[:] = smooth_both(heat, wind, steps[0], tau, usual, state, *into)
    else:
        smooth(heat, steps, tau, usual, state[0], felts, felts_by_tau, decays)
        smooth(wind, steps, tau, usual, state[1], winds, winds_by_tau, stays)
        for i in range(rows):
            if np.isnan(decays[i]) or np.isnan(stays[i]):
                felts[i] = np.nan
    if leaky:
        smooth(loss, steps, tau, usual, state[2], leaks, leaks_by_tau, stays)
        for i in range(shown[0], shown[1]):
            if np.isnan(stays[i]):
                leaks[i] = np.nan
    resistances(law, leaky, winds, leaks, r_eq, by_line, shown)
    for i in range(shown[0], shown[1]):
        temperature[i] = air[i] + felts[i] * r_eq[i] + offset[i]
    if slopes.size == 0:
        return
    write_residual(kept, measured, temperature, slopes)
    for i in range(first, last):
        by_0 = felts[i] * by_line[i]
        by_wind = by_line[i] * slope if winds[i] < clip else 0.0
        by_tau = felts_by_tau[i] * r_eq[i] + felts[i] * by_wind * winds_by_tau[i]
        slopes[0, i] = by_0 if counts[i] else 0.0
        slopes[1, i] = by_0 * min(winds[i], clip) if counts[i] else 0.0
        slopes[2, i] = by_tau / unit if counts[i] else 0.0
    if leaky:
        for i in range(first, last):
            by_leak = felts[i] * r_eq[i] * r_eq[i] * leaks_by_tau[i]
            slopes[2, i] -= by_leak / unit if counts[i] else 0.0
    part, lost = state[0, 4:], state[1, 4:]
    for i in range(rows if len(hot) else 0):
        decay = decays[i]
        if np.isnan(decay):
            continue
        for k in range(len(hot)):
            part[k] = decay * part[k] + (1.0 - decay) * by_heat[k, i]
            slopes[4 + hot[k], i] += part[k] * r_eq[i] if counts[i] else 0.0
    for i in range(rows if len(lossy) else 0):
        stay = stays[i]
        if np.isnan(stay):
            continue
        by_r = felts[i] * r_eq[i] * r_eq[i]
        for k in range(len(lossy)):
            lost[k] = stay * lost[k] + (1.0 - stay) * by_loss[k, i]
            slopes[4 + lossy[k], i] -= by_r * lost[k] if counts[i] else 0.0
    set_aside(kept, aside, by_offset, slopes)


@inlined
def relax(
    targets: np.ndarray,
    steps: np.ndarray,
    offset: np.ndarray,
    r_eq: np.ndarray,
    memory: tuple,
    state: np.ndarray,
    decays: np.ndarray,
    falls: np.ndarray,
    into: np.ndarray,
) -> bool:
    """Write temperature and slopes by the memory; return whether no row is missing."""
    capacity, usual, rows = memory[0], memory[2], len(targets)
    since, begun, module, by_memory = state[:4]
    whole = is_unbroken(targets, state)
    for i in range(rows if whole else 0):
        into[i] = (1.0 - decays[i]) * targets[i]
    for i in range(rows if whole else 0):
        falls[i] *= (module - targets[i]) * decays[i]
        module = decays[i] * module + into[i]
        into[i] = module + offset[i]
    for i in range(0 if whole else rows):
        target = targets[i]
        if np.isnan(target):
            since, into[i] = since + steps[i], np.nan
            continue
        if since > 0.0:
            falls[i] = (steps[i] + since) / (capacity * r_eq[i])
            decays[i] = fade(steps[i] + since, falls[i], usual)
        if not begun:
            decays[i] = 0.0
        decay = decays[i]
        falls[i] *= (module - target) * decay
        module, begun, since = decay * module + (1.0 - decay) * target, 1.0, 0.0
        into[i] = module + offset[i]
    write_state(state, since, begun, module, by_memory)
    return whole


@compiled
def balance(
    law: tuple,
    memory: tuple,
    columns: tuple,
    more: tuple,
    seen: tuple,
    state: np.ndarray,
    slopes: np.ndarray,
    work: np.ndarray,
) -> None:
    clip = law[3]
    capacity, unit, usual, leaky = memory
    steps, air, heat, wind, loss, offset, temperature = columns
    (hot, by_heat), (lossy, by_loss), (aside, by_offset) = more
    (kept, __, measured), rows, wanted = seen, len(air), slopes.size > 0
    counts = kept[0]
    r_eq, by_line, targets = work[0, :rows], work[1, :rows], work[2, :rows]
    decays, falls = work[3, :rows], work[4, :rows]
    resistances(law, leaky, wind, loss, r_eq, by_line, (unsigned(0), unsigned(rows)))
    for i in range(rows):
        targets[i] = air[i] + heat[i] * r_eq[i]
        falls[i] = steps[i] / (capacity * r_eq[i])
    decay_all(steps, falls, usual, decays)
    whole = relax(
        targets, steps, offset, r_eq, memory, state[0], decays, falls, temperature
    )
    if not wanted:
        return
    write_residual(kept, measured, temperature, slopes)
    by_r, adds_0, adds_1 = work[5, :rows], work[6, :rows], work[7, :rows]
    by_capacity = 1.0 / (capacity * unit)
    for i in range(rows):
        by_r[i] = (1.0 - decays[i]) * heat[i] + falls[i] / r_eq[i]
        adds_0[i] = by_r[i] * by_line[i]
        adds_1[i] = adds_0[i] * min(wind[i], clip)
        falls[i] *= by_capacity
    by_memory, of_0, of_1, own = state[0, 3], state[1, 0], state[1, 1], state[1, 4:]
    for i in range(rows):
        if whole or not np.isnan(targets[i]):
            decay = decays[i]
            of_0 = decay * of_0 + adds_0[i]
            of_1 = decay * of_1 + adds_1[i]
            by_memory = decay * by_memory + falls[i]
        slopes[0, i], slopes[1, i], slopes[2, i] = of_0, of_1, by_memory
    for k in range(3):
        for i in range(kept[1], kept[2]):
            slopes[k, i] = slopes[k, i] if counts[i] else 0.0
    state[0, 3], state[1, 0], state[1, 1] = by_memory, of_0, of_1
    for i in range(rows if len(hot) + len(lossy) else 0):
        if not np.isnan(targets[i]):
            for k in range(len(own) - 1):
                own[k] *= decays[i]
            for k in range(len(hot)):
                own[hot[k]] += (1.0 - decays[i]) * r_eq[i] * by_heat[k, i]
            for k in range(len(lossy)):
                own[lossy[k]] -= by_r[i] * r_eq[i] * r_eq[i] * by_loss[k, i]
        if counts[i]:
            for k in range(len(own) - 1):
                slopes[4 + k, i] = own[k]
    set_aside(kept, aside, by_offset, slopes)


@njit(cache=True, error_model="numpy", fastmath={"reassoc", "contract"})
def add_products(slopes: np.ndarray, first: Any, last: Any, total: np.ndarray) -> None:
    """Add the products of all pairs of columns over some rows to ``total``."""
    for a in range(len(slopes)):
        for b in range(a + 1):
            product = 0.0
            for j in range(first, last):
                product += slopes[a, j] * slopes[b, j]
            total[a, b] += product
            if a != b:
                total[b, a] += product


@inlined
def counted_span(counts: np.ndarray) -> Any:
    """The first row that counts, and the row after the last that counts."""
    first, last = 0, len(counts)
    while first < last and not counts[first]:
        first += 1
    while last > first and not counts[last - 1]:
        last -= 1
    return first, last


@inlined
def tile(column: np.ndarray, first: int, last: int, rows: int) -> np.ndarray:
    """Rows of a column, or as many rows of a constant column."""
    return column[first:last] if len(column) == rows else column[: last - first]


@inlined
def longest_time_constant(
    dynamics: int, law: tuple, memory: tuple, losses: np.ndarray
) -> float:
    """Longest time constant of any row, in the unit of the steps; inf if not known."""
    if dynamics == STEADY:
        return 0.0
    if dynamics == EWM:
        return memory[0]
    scale, value, slope, _ = law
    calm = value
    if scale == LOGARITHM:
        calm = np.exp(value)
    elif scale == LOSS:
        calm, slope = 1.0 / value, -slope
    least = 0.0
    for i in range(len(losses)):
        least = min(least, losses[i])
    share = 1.0 + least * calm
    if slope > 0.0 or not calm > 0.0 or not share > 0.0:
        return np.inf
    return memory[0] * calm / share


@inlined
def next_counted_row(
    counts: np.ndarray, steps: np.ndarray, first: int, reach: float
) -> tuple[int, int]:
    """The next row that counts, or the end; and the first row that influences it."""
    ahead, rows = first, len(counts)
    while ahead < rows and not counts[ahead]:
        ahead += 1
    since, past = ahead, 0.0
    while since > first and past < reach:
        since -= 1
        past += steps[since] if len(steps) == rows else steps[0]
    return ahead, since


@compiled
def solve_rows(
    dynamics: int,
    law: tuple,
    memory: tuple,
    columns: tuple,
    more: tuple,
    seen: tuple,
    edges: np.ndarray,
    state: np.ndarray,
    total: Any,
    responses: np.ndarray,
) -> None:
    """
    Temperature of consecutive rows, and products of their slopes over parts of them.

    It also writes the responses to the further terms of ``more`` to ``responses``, if
    that has rows. The rows are solved in tiles whose slopes stay in the innermost
    cache. A column as long as a tile is constant. Rows that influence no row that
    counts are skipped: most nights and days held out. If both products and temperature
    are wanted, no row is skipped.

    Parameters
    ----------
    dynamics : int
        ``STEADY``, ``EWM`` or ``BALANCE``.
    law : (int, float, float, float)
        The steady model as a line: place of its scale in :data:`.SCALES`, value in calm
        air, slope by wind, and the wind from which it is constant. [m/s]
    memory : (float, float, float, bool)
        Time constant or capacity, over the seconds of a unit; these seconds; median
        step of the record in units, NaN if unknown; and whether any loss is added.
    columns : tuple of array
        Steps, air temperature [°C], heat [W/m²], wind [m/s], added loss [W/(m² K)],
        offset [K], and an array that the temperature is written to. [°C]
    more : tuple of (array of int, array)
        For heat, loss and offset: positions, shape (n,), of the further terms that add
        to it, and their slopes, shape (n, rows + APART).
    seen : (array of bool, array)
        Mask of the rows that count, and measured temperature. [°C]
    edges : array of int, shape (parts + 1,)
        First row of each part, from 0 on, and the end of the last.
    state : array, shape (3, columns)
        State of the recursions before the rows; it is updated to their end. It has as
        many columns as the products.
    total : array, shape (parts, columns, columns) or (0, columns, columns)
        Takes the products; without parts none are computed.
    responses : array, shape (terms, rows) or (0, rows)
        Takes the responses to the further terms. [K per unit]
    """
    steps, air, heat, wind, loss, offset, temperature = columns
    (hot, by_heat), (lossy, by_loss), (aside, by_offset) = more
    counts, measured = seen
    wanted, end = len(total) + len(responses) > 0, len(air)
    slopes = np.zeros((state.shape[1], TILE + APART if wanted else 0))
    work = np.empty((WORK, TILE + APART))
    reach, ahead, since = np.inf, -1, 0
    if not (wanted and len(temperature) == end):
        reach = FADED * longest_time_constant(dynamics, law, memory, loss)
    for part in range(len(edges) - 1):
        b = edges[part]
        while b < edges[part + 1]:
            if b > ahead and reach < np.inf:
                ahead, since = next_counted_row(counts, steps, b, reach)
            a = max(b, since)
            b = min(a + TILE, edges[part + 1])
            if a >= b:
                break
            low, high = 0, b - a
            if wanted or reach < np.inf:
                low, high = counted_span(counts[a:b])
            if reach < np.inf and a + high < b:
                ahead, since = next_counted_row(counts, steps, a + high, reach)
                b = min(b, a + high) if since > a + high else b
            low, high, rows = unsigned(low), unsigned(high), unsigned(b - a)
            shown = (low, high) if len(temperature) != end else (unsigned(0), rows)
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
                ((counts[a:b], low, high), shown, measured[a:b]),
                state,
                slopes,
                work,
            )
            if dynamics == STEADY:
                steady(*given)
            elif dynamics == EWM:
                ewm(*given)
            else:
                balance(*given)
            if len(total):
                add_products(slopes, low, high, total[part])
            for k in range(len(responses)):
                responses[k, a:b] = slopes[4 + k, : b - a]
