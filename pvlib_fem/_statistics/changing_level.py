"""The most probable level of a daily series, which changes seldom and has a season."""

from dataclasses import dataclass, field

import numpy as np

ROUNDS = 5  # of level and season in turn
TURNS = 20  # of the reweighting
YEAR = 365.2425  # days
SEASON = 1.5  # years, from which a season differs from a change
HARMONICS = 2
NEXT = 1.146  # median change between two draws of Laplace's law over its scale


@dataclass(frozen=True, eq=False)
class Law:
    """How levels change, and how days differ from them."""

    grid: np.ndarray  # of levels
    odds: float  # chance that the level changes on a day, to any other
    accident: float  # share of days that show nothing
    least: float  # scale of Laplace's law, at least
    fine: float  # deviation below which all days weigh alike in the season
    memory: float  # days that the noise lasts
    swing: float  # standard deviation of each harmonic of the year
    trend: float = 0.0  # of the change within a year; 0 without one
    period: float = np.inf  # after which levels are the same again
    steps: tuple = field(default=())  # (cells of the grid, chance): usual changes


@dataclass(frozen=True, eq=False)
class Path:
    """The most probable level of each day, and the usual part."""

    level: np.ndarray
    usual: np.ndarray  # a constant, the season and the trend
    noise: float  # scale of Laplace's law
    cost: float  # −log of the probability, but for a constant


def most_probable(day: np.ndarray, values: np.ndarray, law: Law) -> Path:
    """
    The level on each day, where it changes seldom and the season comes back.

    Parameters
    ----------
    day : array of int
        Number of each day.
    values : array
        Of each day.
    law : Law

    Returns
    -------
    Path
    """
    table, spread = usual_columns(day, law)
    start = robust_fit(table, spread, values, np.median(values), law.least, law)[0]
    path = settled_level(day, values, table, spread, start, law)
    still = np.full(len(day), law.grid[len(law.grid) // 2])
    other = settled_level(day, values, table, spread, still, law, path.level)
    return min(path, other, key=lambda path: path.cost)


def usual_columns(day: np.ndarray, law: Law) -> tuple[np.ndarray, np.ndarray]:
    """A constant, season and trend where the record is long enough, and their sizes."""
    columns, spread = [np.ones(len(day))], [np.inf]
    if np.ptp(day) >= SEASON * YEAR:
        for harmonic in range(1, 1 + HARMONICS):
            angle = 2.0 * np.pi * harmonic * day / YEAR
            columns += [np.cos(angle), np.sin(angle)]
            spread += [law.swing, law.swing]
    if law.trend:
        columns.append((day - day.mean()) / YEAR)
        spread.append(law.trend)
    return np.column_stack(columns), np.array(spread)


def settled_level(
    day: np.ndarray,
    values: np.ndarray,
    table: np.ndarray,
    spread: np.ndarray,
    usual: np.ndarray,
    law: Law,
    before: np.ndarray | None = None,
) -> Path:
    """Level and season in turn, until the level is as before."""
    season = 0.0
    for _ in range(ROUNDS):
        noise = max(scatter(values - usual), law.least)
        level, cost = decoded(day, values - usual, noise, law)
        if before is not None and (level == before).all():
            break
        before = level
        usual, season = robust_fit(table, spread, values - level, 0.0, noise, law)
    return Path(level, usual, noise, cost + season)


def scatter(values: np.ndarray) -> float:
    """Scale of Laplace's law, by the changes from day to day."""
    return float(np.median(np.abs(np.diff(values)))) / NEXT


def robust_fit(
    table: np.ndarray,
    spread: np.ndarray,
    values: np.ndarray,
    start: float,
    noise: float,
    law: Law,
) -> tuple[np.ndarray, float]:
    """
    Least absolute deviations from the columns of a table, and the cost of their sizes.

    The size of each column but the first has a prior: a summer time is no season.
    """
    residual = values - start
    prior = np.diag(law.memory * noise / spread**2)
    coefficients = np.zeros(table.shape[1])
    for _ in range(TURNS):
        weighted = table / np.maximum(np.abs(residual), law.fine)[:, None]
        coefficients = np.linalg.solve(weighted.T @ table + prior, weighted.T @ values)
        residual = values - table @ coefficients
    return table @ coefficients, 0.5 * float(((coefficients / spread) ** 2).sum())


def decoded(
    day: np.ndarray, values: np.ndarray, noise: float, law: Law
) -> tuple[np.ndarray, float]:
    """
    Viterbi's path over the levels of a grid, and its cost.

    A day is off by Laplace's law, or by anything at all. Days remember each other, so
    that each counts as a share of one.
    """
    costs = level_misfits(values, noise, law)
    gap = np.maximum(np.diff(day, prepend=day[:1]), 1)
    anew = -np.log(law.odds * gap / len(law.grid))
    places = np.arange(len(law.grid))
    ways = [(0, 1.0)]
    for cells, chance in law.steps:
        ways += [(cells, chance / 2.0), (-cells, chance / 2.0)]
    sources = np.stack([np.roll(places, cells) for cells, _ in ways])
    prices = -np.log(np.outer(gap, [chance for _, chance in ways]))
    prices[:, 0] = 0.0  # to stay as it was
    total, came = costs[0].copy(), np.tile(places, (len(day), 1))
    for i in range(1, len(day)):
        best = int(np.argmin(total))
        by_way = total[sources] + prices[i][:, None]
        way = np.argmin(by_way, axis=0)
        came[i], reached = sources[way, places], by_way[way, places]
        cheaper = total[best] + anew[i] < reached
        came[i, cheaper] = best
        total = np.minimum(reached, total[best] + anew[i]) + costs[i]
    at, path = int(np.argmin(total)), np.empty(len(day), dtype=int)
    for i in range(len(day) - 1, -1, -1):
        path[i], at = at, came[i, at]
    return law.grid[path], float(total.min())


def level_misfits(values: np.ndarray, noise: float, law: Law) -> np.ndarray:
    """−log of the probability of each day by each level of a grid."""
    apart = np.abs(values[:, None] - law.grid)
    apart = np.minimum(apart, law.period - apart)
    regular = (1.0 - law.accident) * np.exp(-apart / noise) / (2.0 * noise)
    whole = len(law.grid) * (law.grid[1] - law.grid[0])
    return -np.log(regular + law.accident / whole) / law.memory
