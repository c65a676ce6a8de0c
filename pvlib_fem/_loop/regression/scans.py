"""Effects where scans of the remaining error find them, such as an obstacle."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from pvlib_fem._loop.regression.evidence import Evidence, without_gaps
from pvlib_fem._loop.regression.tangents import Tangents, Tried, tangents
from pvlib_fem._record.inputs import Inputs
from pvlib_fem._statistics.clusters import calendar_weeks
from pvlib_fem._thermal.model import ThermalModel
from pvlib_fem.drivers import derive_drivers, own_columns
from pvlib_fem.effects._effect import Effect
from pvlib_fem.reasons import because


class Scanned(NamedTuple):
    """A wide effect with its tangents, of which a scan takes the effect."""

    scan: Callable
    wide: Effect
    own: dict[str, np.ndarray]
    known: np.ndarray  # rows on which its drivers are known


@dataclass(frozen=True, eq=False)
class Places(Mapping):
    """Drivers at some rows, each derived when it is read."""

    inputs: Inputs
    rows: np.ndarray
    names: Sequence[str]  # of those that are there without being derived

    def __getitem__(self, name: str) -> np.ndarray:
        return derive_drivers(self.inputs, [name])[name][self.rows]

    def __iter__(self) -> Iterator[str]:
        return iter(self.names)

    def __len__(self) -> int:
        return len(self.names)


@dataclass(frozen=True, eq=False)
class Scans:
    """Scans of the remaining error of a model."""

    model: ThermalModel
    inputs: Inputs
    at: Tangents  # of the model
    least: float  # gain from which the edges of an obstacle are fitted [K]

    def added(
        self,
        evidence: Evidence,
        scanned: Iterable[Scanned],
        located: Mapping[str, Effect],
    ) -> Evidence:
        """
        The evidence with the effects that are found, or were ``located`` before.

        Functions of the usual inputs are scanned first: an obstacle is searched for
        given these.
        """
        scanned = [*scanned]
        for shapes in (True, False):
            unlocated = evidence
            for one in scanned:
                wide = one.wide
                if wide.confounder is not shapes:
                    continue
                found = self.found(unlocated, one) or located.get(wide.name)
                if found is None:
                    evidence.failed[wide.name] = because(wide.not_found)
                elif (own := self.tangents_of(found, evidence)) is not None:
                    evidence = evidence.with_effect(found, own, one.known)
        return evidence

    def found(self, evidence: Evidence, scanned: Scanned) -> Effect | None:
        """The effect that a scan finds; if it has a scan, what that finds near it."""
        inputs = self.with_drivers(scanned.wide)
        effect = located_effect(evidence, scanned, inputs, self.least)
        if effect is None or not effect.scan:
            return effect
        wide = effect.scanned_from or effect
        own = self.tangents_of(wide, evidence)
        if own is None:
            return None
        return self.found(evidence, Scanned(effect.scan, wide, own, scanned.known))

    def tangents_of(
        self, effect: Effect, evidence: Evidence
    ) -> dict[str, np.ndarray] | None:
        """Tangents of an effect; None if its terms raise an error."""
        every = tangents(
            [Tried(effect)], evidence.failed, self.with_drivers(effect), self.at
        )
        return next((own for _, own in every), None)

    def with_drivers(self, effect: Effect) -> Inputs:
        """Inputs with the drivers of an effect."""
        return replace(self.model, effects=(effect,)).with_drivers(self.inputs)


def located_effect(
    evidence: Evidence, scanned: Scanned, inputs: Inputs, least: float
) -> Effect | None:
    """
    The effect where a scan of the remaining error shows it, or None.

    A change that is in the model may stand for an effect with a driver of its own, such
    as a trend for dirt since the last rain. So this is searched in both together.
    """
    scan, wide, own, known = scanned
    drivers = wide.drivers
    (rest, with_changes), shapes = evidence.without_shape
    if own_columns(drivers):
        rest = with_changes
    some = slice(None) if known.all() else known
    # of a shape whose driver is missing, as in the residual
    columns = {key: without_gaps(c[some]) for key, c in (own | shapes).items()}
    places = Places(inputs, evidence.rows[some], drivers)
    weeks = calendar_weeks(evidence.dates[some])
    return scan(rest[some], columns, places, weeks, least)
