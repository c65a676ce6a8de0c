"""A checked record, divided into rows by what each is for."""

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from pvlib_fem._findings import Correction
from pvlib_fem._fitting.stand_ins import StandIn
from pvlib_fem._loop.criteria import Criteria
from pvlib_fem._record.column_names import GEOMETRY, is_power
from pvlib_fem._record.filters import counted
from pvlib_fem._record.inputs import Record
from pvlib_fem._record.resampling import coarse, covered_rows
from pvlib_fem.drivers import geometry
from pvlib_fem.effects._effect import Effect
from pvlib_fem.quality._detached_sensor import Detachment
from pvlib_fem.quality._lag import by_module_logger
from pvlib_fem.quality._module_lag import Clock
from pvlib_fem.quality._noon import lateness_of
from pvlib_fem.quality._plane import Plane
from pvlib_fem.quality._tracker_standstill import Standing
from pvlib_fem.reasons import Because

STEP_PRESENT = 0.5  # share of a step's rows that have to be there
FEWEST_FITTING_DAYS = 10  # below which none can be left out in turn
#: models without effects by the name of their step, and their dynamics
BASES = {"steady": "steady", "fem": "ewm", "balance": "balance"}


@dataclass(frozen=True, eq=False)
class Case:
    """
    A record, which of its rows may be looked at when, and what may explain it.

    The search goes over coarse steps, of which five minutes lose nothing that an
    effect would show; every fit ends on the record's own.
    """

    whole: Record
    record: Record  # on coarse steps
    seen: np.ndarray  # rows of the whole that count
    held_out: np.ndarray  # rows of the whole that are of test weeks
    drivers: tuple[str, ...]
    cross_check_columns: tuple[str, ...]  # of instruments
    wanted: tuple[Effect, ...]  # whose drivers are there
    untestable: dict[str, Because]
    site: dict[str, Any]  # if it gives the position of the sun
    place: dict[str, Any]  # as it was given
    clock: Clock
    criteria: Criteria
    kept: np.ndarray  # rows of the file that the whole has
    fixed: dict[str, float] = field(default_factory=dict)  # coefficients that are held
    notes: tuple[str, ...] = ()
    corrections: tuple[Correction, ...] = ()  # of the whole file

    late: float = 0.0  # of the file's times against the sun [s]
    #: from the middle of its step to the time of a row, in steps
    label: float = 0.0
    transposed: bool = False  # whether poa_global is, from the horizontal
    standing: tuple[StandIn, ...] = ()  # columns that stand in for others
    #: days on which the irradiance sensor does not turn
    standings: tuple[Standing, ...] = ()
    another_plane: Plane | None = None  # that of the light, if not the stated one
    #: times in which the module's temperature sensor is off
    detachments: tuple[Detachment, ...] = ()

    @property
    def powers(self) -> list[str]:
        """Columns of power that instruments are compared with."""
        return [*filter(is_power, self.cross_check_columns)]

    @cached_property
    def fitting(self) -> np.ndarray:
        return self.seen & ~self.held_out

    @cached_property
    def test(self) -> np.ndarray:
        return self.seen & self.held_out

    @cached_property
    def searched(self) -> np.ndarray:
        """Rows of the coarse record that the search may look at."""
        seen = np.asarray(counted(self.record.inputs.columns, with_night=True))
        masks = self.seen, self.held_out
        some, kept = covered_rows(masks, self.whole, self.record)
        return seen & some & ~kept

    @cached_property
    def days(self) -> int:
        """
        Number of days that count.

        These are the days of the fitting rows, and as many test days as the division
        gives them. The module temperature of test days has no influence.
        """
        every = self.whole.count_days(np.ones_like(self.held_out))
        share = self.whole.count_days(~self.held_out) / every
        return round(self.whole.count_days(self.fitting) / share) if share else 0

    @cached_property
    def fitting_days(self) -> int:
        return self.record.count_days(self.searched)

    @property
    def divisible(self) -> bool:
        """Whether there are days to leave out in turn."""
        return self.fitting_days >= FEWEST_FITTING_DAYS

    @property
    def enough(self) -> bool:
        """Whether the record is long enough for a name."""
        return self.days >= self.criteria.min_days

    def placed(self, record: Record) -> Record:
        """A record with the place of sun and module, where that is known."""
        late = lateness_of(self.label, record.index)
        places = geometry(record.index, **self.site, late=late)
        return record.having({name: c.to_numpy() for name, c in places.items()})

    def placed_for(self, record: Record, names: Iterable[str]) -> Record:
        """The record with the geometry, if columns need it and it is not there."""
        missing = {*names} & {*GEOMETRY} - {*record.inputs.columns}
        return self.placed(record) if missing else record

    def without(self, effect: Effect) -> "Case":
        """The case without an effect, and the column that it follows."""
        wanted = tuple(other for other in self.wanted if other.name != effect.name)
        drivers = tuple(name for name in self.drivers if name not in effect.drivers)
        return replace(self, wanted=wanted, drivers=drivers)

    def divided(self, whole: Record) -> "Case":
        """The case with this record of the same rows, and its coarse steps."""
        seen = self.seen & counted(whole.inputs.columns, with_night=True)
        short = whole
        if whole.inputs.seconds[-1] > 0:
            hidden = whole.lacking({"temp_module": self.held_out})
            short = coarse(hidden, self.criteria.search_step, STEP_PRESENT)
            short = whole if short is hidden else short
        # the sun is where it is, and nothing is averaged over a horizon
        record = self.placed(short)
        whole = record if short is whole else whole
        return replace(self, whole=whole, record=record, seen=seen)

    def corrected(self) -> "Case":
        """The case with the module's record re-timed."""
        whole, seconds = self.whole, self.whole.inputs.seconds
        moved = by_module_logger(
            whole.inputs.columns, lambda column: self.clock.corrected(seconds, column)
        )
        return replace(self, clock=Clock()).divided(whole.having(moved))
