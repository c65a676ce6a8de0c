"""
The linearised fit: hourly tangents and residuals, and their weekly products.

The selection solves least-squares problems of a few columns. Weekly products of all
columns are summed once. A change of an instrument from a date on is a column times a
weight of each day: daily products of its column are summed once, so that no date needs
a pass over the cells.
"""

from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Self

import numpy as np

from pvlib_fem._statistics.axes import Axis, axes
from pvlib_fem._statistics.clusters import FEWEST_CLUSTERS, FOLDS, calendar_weeks
from pvlib_fem._statistics.tables import Table
from pvlib_fem._statistics.weekly_sums import (
    LeastSquares,
    coefficients_from,
    effective_length,
    effective_number,
    held_out,
    products,
    with_ridge,
)
from pvlib_fem.drivers import FROST, snow_at_most
from pvlib_fem.effects._effect import Effect
from pvlib_fem.effects._time_profiles import time_profile_of, weights_of

APART = 7  # days by which an effect is shifted at least to see what chance does


@dataclass(frozen=True)
class Changed:
    """A column of the design times the weight that an effect has on each day."""

    place: int  # of the column
    effect: Effect = field(compare=False)  # with its dates
    key: str = ""  # its name and dates

    @classmethod
    def from_effect(cls, place: int, effect: Effect) -> Self:
        return cls(place, effect, f"{effect.name} {sorted(effect.settings.items())}")


#: a column of the design by its place, or one times the weights of a change
Column = int | Changed


def place_of(column: Column) -> int:
    """
    Place in the design of a column, or of the one that a change is a part of.

    Parameters
    ----------
    column : int or Changed

    Returns
    -------
    int
    """
    return column if isinstance(column, int) else column.place


@dataclass(frozen=True, eq=False)
class Design:
    """Columns in cells of an hour; the first is the residual."""

    names: tuple[str, ...]  # of the columns
    #: means over the rows of each cell, tangents scaled to a mean square of 1, shape
    #: (cells, columns); a column is contiguous in memory [K]
    cells: np.ndarray = field(repr=False)
    scale: np.ndarray = field(repr=False)  # what each column was divided by
    rows: np.ndarray = field(repr=False)  # number of rows in each cell
    days: np.ndarray = field(repr=False)  # day of each cell, from 1970-01-01
    #: columns of the fitted coefficients and of errors of the steady model's shape
    base: tuple[int, ...]
    own: dict[str, tuple[int, ...]]  # columns of each effect that has no date
    effects: dict[str, Effect]
    sensor_faults: dict[str, int]  # column along which each changes instruments
    changing: tuple[Effect, ...]  # changes whose dates are to be found
    #: mean of each driver in each cell, NaN where it is missing, and the clock and
    #: calendar of the cells
    places: dict[str, np.ndarray] = field(repr=False)
    #: mean in each cell of what effects derive from measured columns of their own
    derived: dict[str, np.ndarray] = field(default_factory=dict, repr=False)
    noise: tuple[Table, ...] = ()  # random effects by which the cells are whitened
    #: whether each day is a draw of the weather, and not a week
    daily_draws: bool = False
    #: whether a day may be an outlier, which counts less where dates are looked for
    outliers: bool = True
    plain: "Design | None" = field(default=None, repr=False)  # the same without
    #: what each effect of the fitted model adds to all columns, by its own columns
    added: dict[tuple[int, ...], np.ndarray] = field(default_factory=dict, repr=False)

    @classmethod
    def of_columns(
        cls,
        residual: np.ndarray,
        columns: dict[str, np.ndarray],
        sensor_fault: np.ndarray,
        dates: np.ndarray,
        changing: Collection[Effect],
    ) -> Self:
        """A design of columns by row, and of one along which something changes."""
        first = np.flatnonzero(np.diff(dates, prepend=dates[:1] - 1))
        days = np.repeat(np.arange(len(first)), np.diff(first, append=len(dates)))
        values = np.array([residual, *columns.values(), sensor_fault]).T
        scale = np.sqrt(np.mean(values**2, axis=0))
        scale[0] = 1.0
        size = len(columns)
        return cls(
            names=("residual", *columns, "sensor_fault"),
            cells=values / scale,
            scale=scale,
            rows=np.ones(len(values)),
            days=dates,
            base=tuple(range(1, size + 1)),
            own={},
            effects={},
            sensor_faults={effect.sensor_fault: size + 1 for effect in changing},
            changing=tuple(changing),
            places={"hour": np.arange(len(dates)) - first[days]},
        )

    def at(self, given: Collection[Column]) -> "Design":
        """
        The design of the model with those of its effects that are given.

        To first order: without what each of the others adds to residual and tangents.
        """
        absent = tuple(own for own in self.added if not {*own} & {*given})
        if not absent:
            return self
        if absent not in self.without:
            cells = self.cells - np.sum([self.added[own] for own in absent], axis=0)
            # a column is contiguous in memory
            cells = np.asfortranarray(cells)
            self.without[absent] = replace(self, cells=cells, added={})
        return self.without[absent]

    @cached_property
    def without(self) -> dict[tuple[tuple[int, ...], ...], "Design"]:
        """Designs without some effects of the model, made once."""
        return {}

    @cached_property
    def base_error(self) -> float:
        """Mean square error given the base, on weeks left out in turn. [K²]"""
        return held_out(self.by_week(self.base), self.folds) / self.count

    @cached_property
    def dates(self) -> np.ndarray:
        """Each day that has cells."""
        return self.days[self.first]

    @cached_property
    def first(self) -> np.ndarray:
        """First cell of each day."""
        return np.flatnonzero(np.diff(self.days, prepend=self.days[:1] - 1))

    def in_cells(self, daily: np.ndarray) -> np.ndarray:
        """A value of each day, in its cells."""
        return np.repeat(daily, np.diff(self.first, append=len(self.days)))

    @cached_property
    def daily_sums(self) -> dict[int, np.ndarray]:
        """Of each column that changes, what :meth:`daily` returns, made once."""
        return {}

    def daily(self, place: int) -> np.ndarray:
        """Daily sums of products of a column with all, shape (days, columns)."""
        if place not in self.daily_sums:
            self.daily_sums[place] = self.by_days(self.cells[:, place])
        return self.daily_sums[place]

    def by_days(self, column: np.ndarray) -> np.ndarray:
        """Daily sums of products of values of the cells with every column."""
        each = (column * self.rows)[:, None] * self.cells
        return np.add.reduceat(each, self.first)

    @cached_property
    def clusters(self) -> np.ndarray:
        """First day of each week, whose weather is shared; each day where few weeks."""
        weeks = self.has_weeks and not self.daily_draws
        return self.starts if weeks else np.arange(len(self.dates))

    @cached_property
    def starts(self) -> np.ndarray:
        """First day of each week."""
        weeks = calendar_weeks(self.dates)
        return np.flatnonzero(np.diff(weeks, prepend=weeks[:1] - 1))

    @property
    def has_weeks(self) -> bool:
        """Whether there are enough of them to see how far they differ."""
        return len(self.starts) >= FEWEST_CLUSTERS

    @cached_property
    def weekly(self) -> np.ndarray:
        """Weekly sums of products: an array of (weeks, columns, columns)."""
        return self.weekly_products(self.cells)

    @cached_property
    def edges(self) -> np.ndarray:
        """First cell of each week, and the number of cells."""
        return np.append(self.first[self.clusters], len(self.rows))

    def weekly_products(self, cells: np.ndarray) -> np.ndarray:
        """Weekly sums of products of some columns, as :attr:`weekly` has them."""
        return products(cells, self.rows, self.edges)

    @cached_property
    def total(self) -> np.ndarray:
        """Products over all weeks: an array of (columns, columns)."""
        return self.weekly.sum(axis=0)

    @cached_property
    def in_days(self) -> "Design":
        """The design whose errors come from the spread between days."""
        design = replace(self, daily_draws=True)
        vars(design)["daily_sums"] = self.daily_sums
        return design

    def fit_for(self, effects: Iterable[Effect]) -> "Design":
        """The design for some effects: in days, if one may act in a week alone."""
        return self.in_days if any(one.turns for one in effects) else self

    @cached_property
    def folds(self) -> np.ndarray:
        """Which weeks are in which group, as a table of ones."""
        weeks = np.arange(len(self.clusters))
        return (weeks % FOLDS == np.arange(FOLDS)[:, None]).astype(float)

    def acting(self, columns: Sequence[Column]) -> float:
        """
        Share of the days on which some columns act.

        It is the effective number of days, by their squares: 1 if all are alike.
        """
        places = [place_of(column) for column in columns]
        cells = np.square(self.cells[:, places]).sum(axis=1) * self.rows
        squares = np.add.reduceat(cells, self.first)
        if not squares.any():
            return 1.0
        return effective_number(squares) / len(squares)

    @property
    def count(self) -> float:
        """Number of rows."""
        return float(self.rows.sum())

    @cached_property
    def made(self) -> dict[Changed, tuple[np.ndarray, np.ndarray]]:
        """Weights of changes, and their weekly products with all columns, made once."""
        return {}

    def weights(self, change: Changed) -> np.ndarray:
        """Weight of each day of a change."""
        return weights_of(change.effect, self.dates)

    def strength(self, change: Changed) -> float:
        """Mean square of its weights on the days on which a change acts."""
        weights = self.parts(change)[0]
        return float(weights @ weights) / max(int(np.count_nonzero(weights)), 1)

    def parts(self, change: Changed) -> tuple[np.ndarray, np.ndarray]:
        """
        Weights of a change, shape (days,), and its weekly products with every column.

        The products have the shape (weeks, columns).
        """
        if change not in self.made:
            weights = self.weights(change)
            if self.noise:
                daily = self.by_days(self.values(change))
            else:
                daily = self.daily(change.place) * weights[:, None]
            self.made[change] = weights, np.add.reduceat(daily, self.clusters)
        return self.made[change]

    @cached_property
    def weeks(self) -> np.ndarray:
        """Number of the week of each cell; of the day where weeks are few."""
        starts = np.zeros(len(self.days), dtype=int)
        starts[self.first[self.clusters[1:]]] = 1
        return np.cumsum(starts)

    @cached_property
    def axes(self) -> dict[str, Axis]:
        """Ways to sort the cells, by name."""
        return {axis.name: axis for axis in axes(self.places, self.days)}

    def confounders_beyond(self, given: Collection[Column]) -> list[Column]:
        """Columns of the confounders of the catalogue that are not given."""
        return [
            column
            for name, columns in self.own.items()
            for column in columns
            if self.effects[name].confounder and column not in given
        ]

    @cached_property
    def rows_without_snow(self) -> np.ndarray | None:
        """What :meth:`without_snow` returns for the air temperature as measured."""
        return self.without_snow(0.0)

    def without_snow(self, shift: np.ndarray | float) -> np.ndarray | None:
        """
        Number of rows in each cell where no snow can lie; None if none ever can.

        ``shift`` is added to the measured air temperature. [K] Snow may have fallen in
        hours that the design has not, such as those of test weeks.
        """
        if "temp_air" not in self.places:
            return None
        air = self.places["temp_air"] + shift
        if not np.fmin.reduce(air) < FROST:
            return None
        hours = self.days * 24 + self.places["hour"].astype(int)
        return self.rows * (snow_at_most(air, hours) == 0.0)

    def residual_given(self, columns: Sequence[Column]) -> np.ndarray:
        """Residual of a fit of some columns, by cell. [K]"""
        table = np.array([self.values(c) for c in columns])
        return self.cells[:, 0] - coefficients_from(self.whole(columns)) @ table

    def whitened(self, noise: Sequence[Table]) -> "Design":
        """The design for generalised least squares with some random effects."""
        if not noise:
            return self
        cells = np.array([self.freed(column, noise) for column in self.cells.T]).T
        return replace(self, cells=cells, noise=tuple(noise), plain=self)

    def freed(self, column: np.ndarray, noise: Iterable[Table]) -> np.ndarray:
        """A column less a part of its mean in each group of each random effect."""
        for table in noise:
            sums = np.bincount(table.groups, column * self.rows, len(table.rows))
            means = sums / np.maximum(table.rows, 1.0)
            column = column - (table.free * means)[table.groups]
        return column

    def adding(self, residual: np.ndarray) -> "Design":
        """The design with something added to the residual of each cell. [K]"""
        cells = self.cells.copy(order="F")
        cells[:, 0] += residual
        return replace(self, cells=cells)

    def by_week(self, columns: Sequence[Column]) -> np.ndarray:
        """
        Weekly products of the residual and some columns, changes among them.

        Their shape is (weeks, len(columns) + 1, len(columns) + 1).
        """
        return self.products(columns, self.weekly)

    def whole(self, columns: Sequence[Column]) -> np.ndarray:
        """Products as those of :meth:`by_week`, over all weeks."""
        return self.products(columns, self.total)

    def products(self, columns: Sequence[Column], known: np.ndarray) -> np.ndarray:
        """Products of the residual and some columns, from those of all columns."""

        def sums(rows: np.ndarray) -> np.ndarray:
            return rows if known.ndim > 2 else rows.sum(axis=0)

        places = np.array([0, *map(place_of, columns)])
        size, many = len(places), known.shape[-1]
        # one flat index is faster than two, and the table is contiguous
        flat = (places[:, None] * many + places).ravel()
        table = known.reshape(*known.shape[:-2], -1).take(flat, axis=-1)
        table = table.reshape(*known.shape[:-2], size, size)
        changes = [(i + 1, c) for i, c in enumerate(columns) if not isinstance(c, int)]
        for i, change in changes:
            rows = sums(self.parts(change)[1][:, places])
            table[..., i, :] = table[..., i] = rows
            for j, other in changes:
                table[..., i, j] = table[..., j, i] = sums(self.crossed(change, other))
        return table

    def row(self, change: Changed, columns: Sequence[Column]) -> np.ndarray:
        """Products of a change with the residual, columns and itself, of all weeks."""
        places = [0, *map(place_of, columns)]
        row = self.parts(change)[1].sum(axis=0)[places]
        for i, other in enumerate(columns):
            if not isinstance(other, int):
                row[i + 1] = self.crossed(change, other).sum()
        return np.append(row, self.crossed(change, change).sum())

    def crossed(self, change: Changed, other: Changed) -> np.ndarray:
        """Weekly products of two changes."""
        if self.noise:
            product = self.values(change) * self.values(other) * self.rows
            return np.add.reduceat(product, self.first[self.clusters])
        both = self.parts(change)[0] * self.parts(other)[0]
        daily = self.daily(change.place)[:, other.place]
        return np.add.reduceat(both * daily, self.clusters)

    def by_day(self, place: int, columns: Sequence[Column]) -> np.ndarray:
        """
        Daily products of one column with the residual and some others.

        Their shape is (days, len(columns) + 1).
        """
        table = np.empty((len(self.dates), len(columns) + 1))
        daily = self.daily(place)
        table[:, 0] = daily[:, 0]
        for i, column in enumerate(columns):
            if isinstance(column, int):
                table[:, i + 1] = daily[:, column]
            else:
                weights = self.parts(column)[0]
                table[:, i + 1] = weights * daily[:, column.place]
        return table

    def values(self, column: Column) -> np.ndarray:
        """A column, or a change, in the cells."""
        if isinstance(column, int):
            return self.cells[:, column]
        if self.plain is not None:
            if column not in self.freed_changes:
                values = self.freed(self.plain.values(column), self.noise)
                self.freed_changes[column] = values
            return self.freed_changes[column]
        return self.cells[:, column.place] * self.weight(column)

    def weight(self, change: Changed) -> np.ndarray:
        """Weight of each cell of a change."""
        return self.in_cells(self.weights(change))

    @cached_property
    def freed_changes(self) -> dict[Changed, np.ndarray]:
        """Whitened changes in the cells, made once."""
        return {}

    @cached_property
    def grid(self) -> tuple[np.ndarray, tuple[int, int]]:
        """Place of each cell in a table of days by hours, and the table's shape."""
        days = self.in_cells(np.arange(len(self.dates)))
        hours = int(self.places["hour"].max()) + 1
        return days * hours + self.places["hour"].astype(int), (len(self.dates), hours)

    def placebo(
        self, given: Sequence[Column], own: Sequence[Column], fit: LeastSquares
    ) -> tuple[np.ndarray, float]:
        """
        Covariance that an estimate would have by accident, and its freedom.

        The residual is compared with the effect as it was on other days: each shift by
        a week or more is a draw in which the effect explains nothing. The error of the
        days on which the effect acts may differ from that of others, and the draws are
        scaled by their ratio. Neighbouring shifts of an effect that changes slowly, as
        one by the sun's position, are much the same draw. Such an effect acts in all
        weeks, so that the spread of these shows its error; one of a few weeks has many
        placebos. The two estimates are averaged by their freedom. The fit is of the
        ``given`` columns and then the effect's ``own``.
        """
        size, root = len(own), np.sqrt(self.rows)
        table = np.array([self.values(c) for c in given]).T
        mine = np.array([self.values(c) for c in own]).T
        rest = self.cells[:, 0] - table @ fit.solved[:-size]
        rest = (rest - mine @ fit.estimate) * root
        mine = (mine + table @ fit.mix[:-size]) * root[:, None]
        place, shape = self.grid

        def spectrum(column: np.ndarray) -> np.ndarray:
            laid = np.zeros(shape)
            laid.flat[place] = column
            return np.fft.rfft(laid, axis=0)

        error = spectrum(rest)
        drawn = np.array(
            [
                np.fft.irfft((spectrum(c).conj() * error).sum(axis=1), shape[0])
                for c in mine.T
            ]
        )
        drawn = drawn[:, APART:-APART] if shape[0] > 3 * APART else drawn[:, 1:]
        day, squares = place // shape[1], mine**2
        errors = np.bincount(day, rest**2) / np.bincount(day, self.rows)
        acting = errors[day] @ squares / np.maximum(squares.sum(axis=0), 1e-300)
        usual = max(rest @ rest / self.rows.sum(), 1e-300)
        drawn *= np.sqrt(acting / usual)[:, None]
        inverse = np.linalg.inv(with_ridge(mine.T @ mine))
        covariance = inverse @ (drawn @ drawn.T / drawn.shape[1]) @ inverse
        return fit.averaged(covariance, min(map(effective_length, drawn)))

    def columns_of(self, effect: Effect) -> tuple[Column, ...]:
        """Columns of an effect, with its dates if it is a sensor fault; or none."""
        if not effect.sensor_fault:
            return self.own.get(effect.name, ())
        place = self.sensor_faults.get(effect.sensor_fault)
        return () if place is None else (Changed.from_effect(place, effect),)

    def of_same_law(self, effect: Effect) -> list[Effect]:
        """Other faults along the same column, with the time profile of one, if any."""
        place = self.sensor_faults.get(effect.sensor_fault)
        return [
            other.dates(**effect.settings)
            for other in self.changing
            if other.sensor_fault != effect.sensor_fault
            and self.sensor_faults[other.sensor_fault] == place
            and time_profile_of(other) == time_profile_of(effect)
        ]

    def scales(self, columns: Sequence[Column]) -> np.ndarray:
        """What the coefficients of some columns are to be divided by."""
        return self.scale[[place_of(column) for column in columns]]
