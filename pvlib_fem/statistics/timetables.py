"""Timetables that a residual keeps: every third day, 35 of every 150 minutes."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.fft import fft, next_fast_len, rfft
from scipy.ndimage import median_filter, uniform_filter1d
from scipy.special import fdtrc

from pvlib_fem.statistics.axes import Axis, rounded
from pvlib_fem.statistics.tables import DAY, held_out_gain

HOUR = 3600.0  # s
HOURS, WEEK = 24, 7
#: independent powers that a median of one is worth: its variance is 1/(n ln²2)
WORTH = np.log(2.0) ** 2


@dataclass(frozen=True, eq=False)
class Days(Axis):
    """Days by their place in a timetable; the labels are dates."""

    def strongest(self, squares, share):
        """Fewest days that hold a share of the squares, the strongest first."""
        order = np.argsort(-squares, kind="stable")
        held = np.cumsum(squares[order])
        return np.sort(order[: 1 + np.searchsorted(held, share * held[-1])])

    def words(self, bins, share):
        every = len(self.labels)
        if len(bins) == every:
            return ""
        return f"on {len(bins)} of every {every} days, as on {self.labels[bins[0]][0]}"


@dataclass(frozen=True, eq=False)
class Minutes(Axis):
    """Rows by their place in a timetable of minutes; the labels are its phase."""

    def words(self, bins, share):
        if len(bins) == len(self.labels):
            return ""
        period = self.period / 60.0
        on = share * period
        return f"in {on:.{0 if on >= 10.0 else 1}f} of every {period:.3g} min"


def timetables(residual, seconds, dates, folds, step, criteria):
    """
    Timetables that a residual keeps, to sort its rows by.

    It costs two Fourier transforms: a loop calls it once for all tables of a round.
    A search among many periods finds one by chance, so a period counts only where
    its lines stand above the spectrum around them by more than
    ``criteria.timetable_chance`` lets the largest of all be [1]_. The day's own
    lines are the hour's.

    Parameters
    ----------
    residual : array
        [K]
    seconds : array
        Time of each row. [s]
    dates : array of int
        Calendar day of each row, from 1970-01-01.
    folds : array of int
        Group of weeks of each row.
    step : float
        Usual time between rows. [s]
    criteria : Criteria
        Thresholds of the stage *structure*.

    Returns
    -------
    list of Axis
        ``timetable_days`` and ``timetable_minutes``, as far as there are any. Days
        and minutes may both say the same, as 48 times 150 min are 5 days: that is
        for tables to decide.

    References
    ----------
    .. [1] J. D. Scargle, "Studies in astronomical time series analysis. II",
       Astrophysical Journal 263, 835-853, 1982. :doi:`10.1086/160554`
    """
    residual = residual - residual.mean()
    found = list(of_days(residual, seconds, dates, folds, step, criteria))
    if (axis := of_minutes(residual, seconds, folds, step, criteria)) is not None:
        found.append(axis)
    return found


def of_days(residual, seconds, dates, folds, step, criteria):
    """The strongest timetables of whole days, one beside the other."""
    day, hour = dates - dates[0], (seconds // HOUR).astype(int) % HOURS
    count = day[-1] + 1
    longest = min(criteria.timetable_days, count // criteria.timetable_repeats)
    if longest < 2:
        return
    shape, place = (HOURS, count), hour * count + day
    rows = np.bincount(place, minlength=HOURS * count).reshape(shape)
    table = np.bincount(place, residual, HOURS * count).reshape(shape)
    table = steadied(table / np.maximum(rows, 1), rows > 0, 2 * longest)
    fold = np.zeros(count, dtype=int)
    fold[day] = folds
    shrink = criteria.cell_weight / step
    for _ in range(criteria.most_timetables):
        days = Table(table, rows, fold, shrink)
        every = days.again(longest, criteria)
        if every is None:
            return
        weekend = (dates[0] + np.arange(count) + 3) % WEEK >= 5
        enough = days.gain(every) / criteria.pair_gain
        # what the weekend says as well is the weekend's
        if every != WEEK or days.gain(2, weekend.astype(int)) < enough:
            start = np.datetime64(int(dates[0]), "D")
            names = (str(start + np.timedelta64(i, "D")) for i in range(every))
            labels = tuple((name, name) for name in names)
            yield Days("timetable_days", day % every, labels, period=every * DAY)
        table = days.without(every)


@dataclass(frozen=True, eq=False)
class Table:
    """Mean residual of each hour and day less its trend, and the rows in it."""

    means: np.ndarray  # 0 where there are no rows [K]
    rows: np.ndarray
    folds: np.ndarray  # of each day
    shrink: float

    def again(self, longest, criteria):
        """Days after which something comes again, or nothing."""
        size = self.rows.sum(axis=0)
        whole = (self.means * self.rows).sum(axis=0) / np.maximum(size, 1)
        series = np.vstack([self.means, whole])
        level, days = background(series, criteria), series.shape[1]
        worth = WORTH * min(criteria.timetable_lines, days // 2)
        tests, found = (longest - 1) * len(series), {}
        for every in range(2, longest + 1):
            lines = np.arange(1, every // 2 + 1)
            folded = [series[:, i::every].sum(axis=1) for i in range(every)]
            power = np.abs(fft(folded, axis=0)[lines].T) ** 2
            place = np.round(lines / every * days).astype(int)
            noise = level[:, np.minimum(place, level.shape[1] - 1)]
            # half a period is one number, where others are two
            weight = np.where(2 * lines == every, 0.5, 1.0)
            freedom, there = weight.sum(), (size > 0).sum()
            square = 2.0 * (power - noise) @ weight / there**2
            material = square >= criteria.timetable_gain**2
            if not material.any() or square[:HOURS].mean() < criteria.timetable_gain**2:
                continue
            above = (power / noise @ weight)[material].max()
            chance = fdtrc(2 * freedom, 2 * worth, above / freedom)  # Fisher's law
            score = above - freedom * np.log(days)  # Schwarz's criterion
            if score > 0 and chance * tests < criteria.timetable_chance:
                found[every] = score
        if not found:
            return None
        best = max(found, key=found.get)
        # what gaps take from a strong line, a multiple of its period takes up
        enough = found[best] / criteria.pair_gain
        alike = [n for n, score in found.items() if best % n == 0 and score >= enough]
        return min(alike, default=best)

    def gain(self, every, phase=None):
        """Held-out gain of a table of days, alone or with the hour. [K²]"""
        phase = np.arange(len(self.folds)) % every if phase is None else phase
        alone = np.tile(phase, (HOURS, 1))
        both = alone + every * np.arange(HOURS)[:, None]
        sums, rows = (self.means * self.rows).ravel(), self.rows.ravel()
        folds = np.tile(self.folds, HOURS)
        return max(
            held_out_gain(bins.ravel(), count, sums, rows, folds, self.shrink)[0].sum()
            for bins, count in ((alone, every), (both, HOURS * every))
        )

    def without(self, every):
        """The means less those of a timetable."""
        means = self.means.copy()
        for i in range(every):
            part, rows = means[:, i::every], self.rows[:, i::every]
            size = (part * rows).sum(axis=1) / np.maximum(rows.sum(axis=1), 1)
            means[:, i::every] = np.where(rows > 0, part - size[:, None], 0.0)
        return means


def background(table, criteria):
    """Mean power of each series' noise, by frequency, whatever lines there are."""
    power = np.abs(rfft(table, axis=1)) ** 2
    # what remembers days is red, within the width of a median
    lagged = np.einsum("ij,ij->i", table[:, 1:], table[:, :-1])
    memory = lagged / np.maximum(np.einsum("ij,ij->i", table, table), 1e-300)
    turn = np.exp(-2j * np.pi * np.arange(power.shape[1]) / table.shape[1])
    red = 1.0 / np.abs(1.0 - np.clip(memory, -0.95, 0.95)[:, None] * turn) ** 2
    width = min(criteria.timetable_lines, power.shape[1])
    level = red * median_filter(power / red, (1, width)) / np.log(2.0)
    return np.maximum(level, np.finfo(float).tiny)


def steadied(table, there, days):
    """Series less their moving mean, 0 where there is nothing."""
    table = np.where(there, table, 0.0)
    near = uniform_filter1d(table, days, axis=1, mode="constant")
    share = uniform_filter1d(there.astype(float), days, axis=1, mode="constant")
    return np.where(there, table - near / np.maximum(share, 1e-9), 0.0)


def of_minutes(residual, seconds, folds, step, criteria):
    """The strongest timetable of minutes, or nothing."""
    slots = int(np.ceil(DAY / step - 1e-6))
    width = DAY / slots  # s; the day is whole, rows off the grid leave gaps
    place = np.round((seconds - seconds[0]) / width).astype(int)
    days = -(-(place[-1] + 1) // slots)
    if days < criteria.timetable_trend:
        return None
    rows = np.bincount(place, minlength=days * slots).reshape(days, slots).T
    table = np.bincount(place, residual, days * slots).reshape(days, slots).T
    table = steadied(table / np.maximum(rows, 1), rows > 0, criteria.timetable_trend)
    series = table.T.ravel()
    line = strongest_line(series, width, step, criteria)
    if line is None:
        return None
    series = series[place]
    shrink = criteria.cell_weight / step
    line = refined(line, series, seconds, folds, shrink, criteria)
    if line is None:
        return None
    fine = phases(seconds, line, criteria.timetable_phases)
    edges = segments(fine, series, criteria)
    bins = np.searchsorted(edges, fine, side="right") - 1
    ends = [rounded(edge / criteria.timetable_phases / line / 60.0) for edge in edges]
    labels = tuple(pairwise([*ends, rounded(1.0 / line / 60.0)]))
    period = float(1.0 / line)
    return Minutes("timetable_minutes", bins, labels, cyclic=True, period=period)


def strongest_line(series, width, step, criteria):
    """Frequency of the strongest line above the noise around it, or nothing. [Hz]"""
    size = next_fast_len(2 * len(series), real=True)  # between the lines, too
    power = np.abs(rfft(series, size)) ** 2
    frequency = np.arange(len(power)) / (size * width)
    off = frequency * DAY - np.round(frequency * DAY)  # turns a day from the day's
    free = np.abs(off) > 1.0 / criteria.timetable_trend
    free &= frequency > 1.0 / criteria.timetable_longest
    free &= frequency < 1.0 / (criteria.timetable_steps * step)
    if not free.any():
        return None
    frequency, off, power = frequency[free], off[free], power[free]
    power /= (1.0 - np.sinc(criteria.timetable_trend * off)) ** 2  # the mean's ripple
    level = median_filter(power, 2 * criteria.timetable_lines) / np.log(2.0)
    ratio = np.divide(power, level, out=np.zeros_like(power), where=level > 0)
    worth = WORTH * criteria.timetable_lines
    chance = (1.0 + ratio / worth) ** -worth * len(power)
    clear = chance < criteria.timetable_chance
    # effects of the day alone have weaker lines beside it, a turn a day away
    return frequency[np.argmax(np.where(clear, power, 0.0))] if clear.any() else None


def segments(fine, residual, criteria):
    """First phases of a few bins, of which neighbours of like mean are joined."""
    count = criteria.timetable_phases
    sums, rows = np.bincount(fine, residual, count), np.bincount(fine, minlength=count)
    first = np.arange(count)
    while len(first) > criteria.timetable_bins:
        held, size = np.add.reduceat(sums, first), np.add.reduceat(rows, first)
        means = held / np.maximum(size, 1)
        both = size[1:] * size[:-1] / np.maximum(size[1:] + size[:-1], 1)
        # Ward's criterion: what the squares within them rise by
        first = np.delete(first, 1 + np.argmin(both * np.diff(means) ** 2))
    return first


def phases(seconds, line, bins):
    """Bin of each row in the period of a line."""
    turns = seconds * line
    return ((turns - np.floor(turns)) * bins).astype(int)


def refined(line, residual, seconds, folds, shrink, criteria):
    """The line, or one that it is a multiple of, by the gain of the folded table."""
    rows, bins = np.ones(len(residual)), criteria.timetable_phases
    apart = 1.0 / (seconds[-1] - seconds[0])

    def gain(line):
        phase = phases(seconds, line, bins)
        return held_out_gain(phase, bins, residual, rows, folds, shrink)[0].sum()

    def best(line, width):
        around = line + apart * np.linspace(-width, width, 7)
        return max(around, key=gain)

    line = best(best(line, 0.6), 0.2)
    gains = {
        times: gain(line / times)
        for times in range(1, criteria.timetable_multiples + 1)
        if times == 1 or line / times > 1.0 / criteria.timetable_longest
    }
    if max(gains.values()) < criteria.timetable_gain**2:
        return None
    # the period of the strongest line itself, unless a longer one says clearly more
    enough = max(gains.values()) / criteria.pair_gain
    alike = [times for times, value in gains.items() if value >= enough]
    times = min(alike, default=max(gains, key=gains.get))
    return best(line / times, 0.2 / times)
