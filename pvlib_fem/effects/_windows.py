"""
Find windows of the sky in which the residual of a fit is proportional to the beam.

An obstacle is a mask of small cells of the sky with one share of the beam. The search
starts with the best rectangle. It then adds or cuts the best further rectangle as long
as that reduces the error enough.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from pvlib_fem._statistics.extremes import ALIKE, as_normal, rounded_argmax
from pvlib_fem._statistics.weekly_sums import effective_number

UNSEEN = 1e-6  # of a column's square; a smaller independent part counts as zero
BLOCK = (5.0, 10.0)  # ° of elevation and azimuth of the rectangle that starts a search
STARTS = 5  # number of starts
CELL = (1.0, 2.0)  # ° of elevation and azimuth; the sun crosses one in ten minutes
LEAST_SHARE = 0.1  # least share of the beam that an obstacle blocks
MOST_SHARE = 1.5  # above 1, because the estimated beam may be too small
LEAST_ERRORS = 4.0  # least ratio of a share to its standard error: best of thousands
MOST_WINDOWS = 8  # largest number of rectangles
TURNS = 20  # largest number of moves of the edges


def find_windows(
    rest: np.ndarray,
    tangent: np.ndarray,
    basis: np.ndarray,
    sun: tuple,
    weeks: np.ndarray,
    sign: float,
    least: float,
    rows: int | None = None,
) -> tuple[float, tuple]:
    """
    Windows of the sky in which the beam to the module, or to its sensor, is blocked.

    Parameters
    ----------
    rest : array
        Residual of a fit. [K]
    tangent : array
        Response of the temperature to the loss of all beam. [K]
    basis : array
        Rows by columns: an orthonormal basis of the tangents of all fitted
        coefficients.
    sun : (array, array)
        Azimuth and elevation of the sun whose beam is in the temperature. [°]
    weeks : array of int
    sign : float
        1 if the module loses beam, -1 if the sensor does.
    least : float
        Least gain of each rectangle. [K]
    rows : int, optional
        Number of rows of the record, by default of these sunny rows.

    Returns
    -------
    float
        Decrease of the sum of squares. [K²]
    tuple
        The windows, as azimuth from and to, elevation from and to. [°]
    """
    sunny = np.flatnonzero((sun[1] > 0) & (sun[1] < 90) & (tangent < 0))
    if not len(sunny):
        return 0.0, ()
    basis = basis.T.take(sunny, axis=1).T  # contiguous columns
    floor = (rows or len(rest)) * least**2
    rest, tangent, weeks = rest[sunny], tangent[sunny], weeks[sunny]
    sky = Sky.from_rows(rest, tangent, basis, *(angle[sunny] for angle in sun))
    mask, gain = np.zeros(sky.squares.shape, dtype=bool), 0.0
    weigh = partial(gain_of, sign=sign, most=MOST_SHARE)
    for _ in range(MOST_WINDOWS):
        steps = [sky.step(mask, cut, weigh) for cut in (False, True)]
        new, its = steps[rounded_argmax([gain for _, gain in steps])]
        if its - gain < floor:
            break
        # the new cells as a column, given the cells of the mask so far
        column = tangent * (new ^ mask).ravel()[sky.place]
        known = basis
        if mask.any():
            known = np.column_stack([basis, tangent * mask.ravel()[sky.place]])
        # the existence of an obstacle needs more evidence than its shape
        errors = certainty(rest, column, known, weeks, few=not mask.any())
        if errors < LEAST_ERRORS:
            break
        mask, gain = new, its
    if not sign * sky.share(mask) >= LEAST_SHARE:
        return 0.0, ()
    return gain, tuple(sky.edges(mask))


@dataclass(frozen=True, eq=False)
class Sky:
    """
    The sky in cells of elevation and azimuth, with sums of products per cell.

    ``sums`` are products of the tangent: with the residual, with itself, and with each
    of the orthonormal columns of the fit. So the share of any part of the sky, given
    all fitted coefficients, follows from sums over its cells.
    """

    sums: np.ndarray  # columns, elevation, azimuth
    place: np.ndarray  # cell of each row
    origin: float  # azimuth of the first cell [°]
    size: tuple  # of a cell in elevation and azimuth [°]

    @classmethod
    def from_rows(
        cls,
        rest: np.ndarray,
        tangent: np.ndarray,
        basis: np.ndarray,
        azimuth: np.ndarray,
        elevation: np.ndarray,
    ) -> "Sky":
        """The sums of some rows by solar position."""
        up, across = size = CELL
        origin = darkest(azimuth, tangent, across)
        high = (elevation // up).astype(int)
        far = ((azimuth - origin) % 360.0 // across).astype(int)
        shape = high.max() + 1, far.max() + 1  # there is no sun beyond
        place = high * shape[1] + far
        sums = [
            np.bincount(place, tangent * column, shape[0] * shape[1]).reshape(shape)
            for column in (rest, tangent, *basis.T)
        ]
        return cls(np.array(sums), place, origin, size)

    @property
    def squares(self) -> np.ndarray:
        return self.sums[1]

    def share(self, mask: np.ndarray) -> float:
        """Share of the beam that is blocked in a part of the sky."""
        product, square, *known = self.sums[:, mask].sum(axis=1)
        return float(share_of(product, square, np.sum(np.square(known))))

    def step(
        self, mask: np.ndarray, cut: bool, weigh: Callable
    ) -> tuple[np.ndarray, float]:
        """The mask with the best rectangle added or cut, and its gain."""
        some = mask if cut else ~mask
        seen = (self.squares > 0) & some
        if not seen.any():
            return mask, 0.0
        there, total = self.sums[:, mask].sum(axis=1), cumulative_sums(self.sums * some)
        ends = [
            np.flatnonzero(seen.any(axis=axis))[[0, -1]] + [0, 1] for axis in (1, 0)
        ]
        total = -total if cut else total
        starts = self.starts(total, there, weigh, ends)
        climbs = [climb(total, there, weigh, start, ends) for start in starts]
        if not climbs:
            return mask, 0.0
        best = rounded_argmax([gain for _, gain in climbs])
        (low, high, start, end), gain = climbs[best]
        new = mask.copy()
        new[low:high, start:end] = not cut
        return new, gain

    def starts(
        self, total: np.ndarray, there: np.ndarray, weigh: Callable, ends: Any
    ) -> Iterator:
        """Blocks of the sky with the largest gains."""
        steps = [max(1, round(wide / cell)) for wide, cell in zip(BLOCK, self.size)]
        first = [np.arange(*[*end, step]) for end, step in zip(ends, steps)]
        low, start = (edges.ravel() for edges in np.meshgrid(*first, indexing="ij"))
        high = np.minimum(low + steps[0], ends[0][1])
        end = np.minimum(start + steps[1], ends[1][1])
        product, square, *known = there[:, None] + rectangle_sums(
            total, low, high, start, end
        )
        gains = weigh(product, square, np.square(known).sum(axis=0))
        for i in np.argsort(-gains, kind="stable")[:STARTS]:
            if gains[i] > 0:
                yield int(low[i]), int(high[i]), int(start[i]), int(end[i])

    def edges(self, mask: np.ndarray) -> Iterator:
        """Windows of a mask: runs of azimuth over the elevations that share them."""
        up, across = self.size
        open_runs = {}
        for row in range(len(mask) + 1):
            line = mask[row] if row < len(mask) else np.zeros(mask.shape[1], dtype=bool)
            turns = np.flatnonzero(np.diff(np.concatenate(([0], line, [0]))))
            runs = set(zip(turns[::2].tolist(), turns[1::2].tolist()))
            for run in sorted(set(open_runs) - runs):
                around = [(self.origin + edge * across) % 360.0 for edge in run]
                yield (*around, open_runs.pop(run) * up, row * up)
            open_runs |= dict.fromkeys(runs - set(open_runs), row)


def darkest(azimuth: np.ndarray, tangent: np.ndarray, across: float) -> float:
    """Azimuth in the middle of the longest range without sun. [°]"""
    cells = int(np.ceil(360.0 / across))
    light = np.bincount((azimuth % 360.0 // across).astype(int), tangent**2, cells)
    dark = np.flatnonzero(np.tile(light <= light.min(), 2))
    longest = max(np.split(dark, np.flatnonzero(np.diff(dark) > 1) + 1), key=len)
    return float(longest[len(longest) // 2] % cells * across)


def cumulative_sums(sums: np.ndarray) -> np.ndarray:
    """Sums over all cells before each edge."""
    return np.pad(sums, [(0, 0), (1, 0), (1, 0)]).cumsum(axis=1).cumsum(axis=2)


def rectangle_sums(
    total: np.ndarray,
    low: np.ndarray,
    high: np.ndarray,
    start: np.ndarray,
    end: np.ndarray,
) -> np.ndarray:
    """Sums over rectangles of cells."""
    above = total[:, high, end] - total[:, high, start]
    return above - total[:, low, end] + total[:, low, start]


def share_of(product: np.ndarray, square: np.ndarray, known: np.ndarray) -> np.ndarray:
    """Share of the beam blocked in parts of the sky, given all fitted coefficients."""
    remaining = square - known
    return np.divide(
        product,
        remaining,
        out=np.zeros_like(product),
        where=remaining > UNSEEN * np.abs(square),
    )


def gain_of(
    product: np.ndarray, square: np.ndarray, known: np.ndarray, sign: float, most: float
) -> np.ndarray:
    """Decrease of the sum of squares by parts of the sky; 0 if impossible."""
    share = share_of(product, square, known)
    return np.where((sign * share > 0) & (sign * share < most), share * product, 0.0)


def climb(
    total: np.ndarray, there: np.ndarray, weigh: Callable, window: tuple, ends: list
) -> tuple[tuple, float]:
    """Move pairs of edges of a rectangle while its gain grows."""
    gain, stays = 0.0, 0
    for turn in range(TURNS):
        first, last = ends[turn % 2]
        low, high, start, end = window
        if turn % 2:
            strip = total[:, high, first : last + 1] - total[:, low, first : last + 1]
        else:
            strip = total[:, first : last + 1, end] - total[:, first : last + 1, start]
        gains = of_pairs(strip, there, weigh)
        best = np.unravel_index(rounded_argmax(gains), gains.shape)
        stays = 0 if gains[best] > gain * (1.0 + ALIKE) else stays + 1
        if stays == 2:
            break
        if not stays:
            gain = float(gains[best])
            pair = tuple(first + int(edge) for edge in best)
            window = (low, high, *pair) if turn % 2 else (*pair, start, end)
    return window, gain


def of_pairs(strip: np.ndarray, there: np.ndarray, weigh: Callable) -> np.ndarray:
    """Gains of the mask with each part of a strip, by its first and last edge."""
    end = strip + there[:, None]
    product, square = (end[i] - strip[i][:, None] for i in (0, 1))
    # the square of a difference, from the products of its ends
    known, also = end[2:], strip[2:]
    squares = (also**2).sum(axis=0)[:, None] + (known**2).sum(axis=0)
    return np.triu(weigh(product, square, squares - 2.0 * also.T @ known), 1)


def certainty(
    rest: np.ndarray,
    column: Any,
    known: np.ndarray,
    weeks: np.ndarray,
    few: bool = False,
) -> Any:
    """
    Ratio of a share to its standard error, from the spread between weeks.

    With ``few``, Student's t is converted to a normal deviate of equal probability. The
    sun crosses a small window in few weeks, whose spread is uncertain.
    """
    slopes = np.linalg.lstsq(known, np.column_stack([column, rest]), rcond=None)[0]
    column, rest = column - known @ slopes[:, 0], rest - known @ slopes[:, 1]
    share = (column @ rest) / max(column @ column, 1e-300)
    week = np.unique(weeks, return_inverse=True)[1]
    scores = np.bincount(week, column * (rest - share * column))
    errors = abs(column @ rest) / max(np.sqrt(scores @ scores), 1e-300)
    if not few:
        return errors
    draws = effective_number(np.bincount(week, column**2))
    return as_normal(errors, max(draws - 1.0, 1.0))
