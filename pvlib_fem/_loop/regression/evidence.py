"""Tangents of a fitted model and of absent effects, and the remaining error."""

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from pvlib_fem._statistics.weekly_sums import least_squares_coefficients
from pvlib_fem.effects._effect import Effect
from pvlib_fem.reasons import Because


@dataclass(frozen=True, eq=False)
class Evidence:
    """Tangents of a fitted model and of absent effects, and the remaining error."""

    #: a tangent of each coefficient, misfit and effect on ``rows``; NaN where the
    #: driver of an effect is missing [K per unit of the coefficient]
    columns: dict[str, np.ndarray] = field(repr=False)
    residual: np.ndarray = field(repr=False)  # measured minus modelled on ``rows`` [K]
    #: the same with what the model's changes of sensors and mounting explain [K]
    with_changes: np.ndarray = field(repr=False)
    dates: np.ndarray = field(repr=False)  # day of each of the rows, from 1970-01-01
    rows: np.ndarray = field(repr=False)  # of the record that count
    base: tuple[str, ...]  # the fitted coefficients
    #: columns of errors of the steady model's shape: functions of the usual inputs,
    #: which count for no effect
    misfits: tuple[str, ...]
    #: columns of each effect
    own: dict[str, tuple[str, ...]] = field(default_factory=dict)
    effects: dict[str, Effect] = field(default_factory=dict)
    #: effects that could not be tried
    failed: dict[str, Because] = field(default_factory=dict)
    #: of each effect, on how many of the rows its drivers are known
    known: dict[str, int] = field(default_factory=dict)
    #: changes whose dates are to be found, each with the column that it scales
    changing: tuple[tuple[Effect, str], ...] = ()
    #: effects, of the model too, and columns of changes that are heat or offset alone,
    #: by measured drivers: none of them alters the tangents of others
    heat_alone: frozenset[str] = frozenset()

    def with_effect(
        self, effect: Effect, columns: dict[str, np.ndarray], known: np.ndarray
    ) -> "Evidence":
        """The evidence with the tangents of one more effect, on its known rows."""
        # an absent cause, such as snow that never stays, is not tested
        columns = {n: c for n, c in columns.items() if c[known].any()} or columns
        return replace(
            self,
            columns=self.columns | unknown_columns(columns, known),
            own=self.own | {effect.name: tuple(columns)},
            effects=self.effects | {effect.name: effect},
            known=self.known | {effect.name: int(known.sum())},
        )

    def with_changes_along(
        self,
        time_profiles: Iterable[Effect],
        columns: dict[str, np.ndarray],
        known: np.ndarray,
    ) -> "Evidence":
        """The evidence with the one tangent of a fault, which its changes scale."""
        (column,) = columns
        return replace(
            self,
            columns=self.columns | unknown_columns(columns, known),
            changing=(*self.changing, *((one, column) for one in time_profiles)),
        )

    def column_of_fault(self, sensor_fault: str) -> str | None:
        """The column that changes of a sensor fault scale, or None."""
        same = (c for one, c in self.changing if one.sensor_fault == sensor_fault)
        return next(same, None)

    @cached_property
    def without_shape(self) -> tuple[np.ndarray, dict[str, np.ndarray]]:
        """
        Both residuals given all functions of the usual inputs, and those.

        The first is that of the model, the second has what changes explain.
        """
        shapes = [n for n, effect in self.effects.items() if effect.confounder]
        names = [*self.base, *self.misfits, *(c for n in shapes for c in self.own[n])]
        table = np.array([without_gaps(self.columns[n]) for n in names]).T
        both = np.column_stack([self.residual, self.with_changes])
        both = both - table @ least_squares_coefficients(table, both)
        return both.T, {n: self.columns[n] for n in names}


def unknown_columns(
    columns: dict[str, np.ndarray], known: np.ndarray
) -> dict[str, np.ndarray]:
    """Columns that are unknown on some rows."""
    if known.all():
        return columns
    return {name: np.where(known, column, np.nan) for name, column in columns.items()}


def without_gaps(column: np.ndarray) -> np.ndarray:
    """
    A column with 0 where it is unknown.

    Parameters
    ----------
    column : array, shape (rows,)

    Returns
    -------
    array, shape (rows,)
        The column itself, if it has no gap.
    """
    gaps = np.isnan(column)
    return np.where(gaps, 0.0, column) if gaps.any() else column
