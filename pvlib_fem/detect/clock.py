"""The clock that a record kept on each day, by the middle of each day's light."""

from dataclasses import dataclass

import numpy as np

GRID = 15.0  # min, of zones, and of the least change that is looked for
FARTHEST = 720.0  # min
ODDS = 1e-4  # chance that a clock is set anew on a day, to any time
HOURLY = 1e-3  # chance that it is set by an hour, as for summer time
ACCIDENT = 0.1  # share of days whose light shows nothing: snow, faults, shade
NOISE = 2.0  # min, that clouds leave in the middle of a day, at least
EDGE = 0.125  # of a step: where between two rows the light begins
MEMORY = 2.0  # days that weather and faults last
ROUNDS = 5  # of clock and season in turn
TURNS, STILL = 20, 1.0  # of the reweighting, and the deviation that weighs most [min]
YEAR = 365.2425  # days
SEASON = 1.5  # years, from which a season differs from a clock
HARMONICS = 2
SWING = 5.0  # min, of each harmonic: what plane and horizon do to the edges of light
NEXT = 1.146  # median change between two draws of Laplace's law over its scale


@dataclass(frozen=True, eq=False)
class Path:
    """The most probable clock of each day, and what is usual beside it."""

    clock: np.ndarray  # [min]
    usual: np.ndarray  # the part of plane, horizon and season [min]
    noise: float  # scale of Laplace's law [min]
    cost: float  # −log of the probability, but for a constant


def most_probable(day, minutes, step=GRID):
    """
    The clock on each day, where it changes seldom and the season comes back.

    Parameters
    ----------
    day : array of int
        Number of each day.
    minutes : array
        How much later than due the middle of its light is. [min]
    step : float
        Of the rows. [min]

    Returns
    -------
    Path
    """
    table = seasons(day)
    least = max(NOISE, EDGE * step)
    season, _ = fitted(table, minutes, np.median(minutes), least)
    path = settled(day, minutes, table, season, least)
    other = settled(day, minutes, table, np.zeros(len(day)), least, path.clock)
    return min(path, other, key=lambda path: path.cost)


def seasons(day):
    """A constant, and what comes back with the year where the record is long enough."""
    columns = [np.ones(len(day))]
    if np.ptp(day) >= SEASON * YEAR:
        for harmonic in range(1, 1 + HARMONICS):
            angle = 2.0 * np.pi * harmonic * day / YEAR
            columns += [np.cos(angle), np.sin(angle)]
    return np.column_stack(columns)


def settled(day, minutes, table, usual, least, before=None):
    """Clock and season in turn, until the clock is as before."""
    season = 0.0
    for _ in range(ROUNDS):
        noise = max(scatter(minutes - usual), least)
        clock, cost = decoded(day, minutes - usual, noise)
        if before is not None and (clock == before).all():
            break
        before = clock
        usual, season = fitted(table, minutes - clock, 0.0, noise)
    return Path(clock, usual, noise, cost + season)


def scatter(values):
    """Scale of Laplace's law, by the changes from day to day. [min]"""
    return float(np.median(np.abs(np.diff(values)))) / NEXT


def fitted(table, values, start, noise):
    """
    Least absolute deviations from the columns of a table, and the cost of the season.

    The size of each column but the first has a prior: a summer time is no season.
    """
    left = values - start
    prior = np.zeros(table.shape[1])
    prior[1:] = MEMORY * noise / SWING**2
    found = np.zeros(table.shape[1])
    for _ in range(TURNS):
        weighted = table / np.maximum(np.abs(left), STILL)[:, None]
        normal = weighted.T @ table + np.diag(prior)
        found = np.linalg.solve(normal, weighted.T @ values)
        left = values - table @ found
    return table @ found, 0.5 * float((found[1:] ** 2).sum()) / SWING**2


def decoded(day, minutes, noise):
    """
    Viterbi's path over the clocks of a grid, and its cost.

    A day is off by Laplace's law, or by any time at all. Days remember each other, so
    that each counts as a share of one.
    """
    grid = np.arange(-FARTHEST, FARTHEST, GRID)
    costs = misfits(minutes, grid, noise)
    gap = np.maximum(np.diff(day, prepend=day[:1]), 1)
    anew, hour = -np.log(ODDS * gap / len(grid)), -np.log(HOURLY * gap / 2.0)
    places, turn = np.arange(len(grid)), round(60.0 / GRID)
    sources = np.stack([places, np.roll(places, turn), np.roll(places, -turn)])
    total, came = costs[0].copy(), np.tile(places, (len(day), 1))
    for i in range(1, len(day)):
        best = int(np.argmin(total))
        by_way = total[sources]
        by_way[1:] += hour[i]
        way = np.argmin(by_way, axis=0)
        came[i], reached = sources[way, places], by_way[way, places]
        cheaper = total[best] + anew[i] < reached
        came[i, cheaper] = best
        total = np.minimum(reached, total[best] + anew[i]) + costs[i]
    at, path = int(np.argmin(total)), np.empty(len(day), dtype=int)
    for i in range(len(day) - 1, -1, -1):
        path[i], at = at, came[i, at]
    return grid[path], float(total.min())


def misfits(minutes, grid, noise):
    """−log of the probability of each day by each clock of a grid."""
    apart = np.abs(minutes[:, None] - grid)
    apart = np.minimum(apart, 2.0 * FARTHEST - apart)  # round the clock
    regular = (1.0 - ACCIDENT) * np.exp(-apart / noise) / (2.0 * noise)
    return -np.log(regular + ACCIDENT / (2.0 * FARTHEST)) / MEMORY
