"""The corrections of a record's clocks, to be applied to the record again."""

import warnings
from dataclasses import dataclass, field
from typing import Self

import numpy as np
import pandas as pd

from pvlib_fem._record.checks import no_datetimes
from pvlib_fem.quality._clock_changes import wall_time
from pvlib_fem.quality._module_lag import Clock


@dataclass(frozen=True)
class Times:
    """Clocks of a record and their corrections."""

    zone: str  # of the file; "" without one
    first: str  # time of the file, by its own clock
    last: str
    #: seconds to add, each from a time of the file on
    offsets: tuple[tuple[str, float], ...] = ()
    #: first and last time of each run of rows whose time is unknown
    lost: tuple[tuple[str, str], ...] = ()
    origin: str = ""  # first corrected time
    #: clock of the module's logger, where it was corrected
    module: Clock = field(default_factory=Clock)

    @classmethod
    def from_indices(
        cls,
        index: pd.DatetimeIndex,
        kept: np.ndarray,
        corrected: pd.DatetimeIndex,
        clock: Clock,
    ) -> Self:
        """
        Compare the times of a file with the corrected ones of the rows that are kept.

        Of these the time is known. The clock of the module's logger was corrected by
        ``clock``.
        """
        own = wall_time(index)
        offsets: tuple[tuple[str, float], ...] = ()
        added = np.asarray((wall_time(corrected) - own[kept]).total_seconds())
        if added.any():
            begins = np.flatnonzero(np.diff(added, prepend=np.nan) != 0.0)
            times = own[kept][begins]
            offsets = tuple(zip(map(str, times), map(float, added[begins])))
        edges = np.flatnonzero(np.diff(~kept, prepend=False, append=False))
        lost = [(str(own[a]), str(own[b - 1])) for a, b in zip(edges[::2], edges[1::2])]
        first, last = str(own.min()), str(own.max())
        origin = str(wall_time(corrected[0]))
        return cls(zone_name(index), first, last, offsets, tuple(lost), origin, clock)

    def in_zone(self, index: pd.Index) -> pd.Index:
        """
        Some times in the zone of the record, whose days and hours are meant.

        They are unchanged if one has no zone, or that of the record has a name that
        pandas does not know.
        """
        if not isinstance(index, pd.DatetimeIndex) or index.tz is None:
            return index
        if zone_name(index) == self.zone or not self.zone:
            return index
        try:
            return index.tz_convert(self.zone)
        except (KeyError, ValueError, OSError):  # of a zone that names itself only
            return index

    def inside(self, index: pd.Index) -> np.ndarray:
        """Find the times that lie within the record, in its zone or without any."""
        times = datetimes(index)
        own = wall_time(times)
        within = (own >= pd.Timestamp(self.first)) & (own <= pd.Timestamp(self.last))
        return np.asarray(within) & (times.tz is None or zone_name(times) == self.zone)

    def corrected(self, index: pd.Index) -> tuple[pd.Index, np.ndarray]:
        """
        Correct the times within the record, and say in which rows the time is known.

        It is a ValueError if the record's clock was corrected and the index has no
        times.
        """
        known = np.ones(len(index), dtype=bool)
        if not self.zone and (self.offsets or self.module.fault) and zone_name(index):
            warnings.warn(
                f"data are in {zone_name(index)} and the record of this loop has no "
                "zone, so that its clock is not corrected; give data.tz_localize(None) "
                "for its own times, or correct_times=False",
                stacklevel=4,
            )
        if not self.offsets:
            return index, known
        times = datetimes(index)
        own, rows = wall_time(times), self.inside(times)
        begins = pd.DatetimeIndex([time for time, _ in self.offsets])
        place = np.maximum(begins.searchsorted(own, side="right") - 1, 0)
        added = np.where(rows, np.array([by for _, by in self.offsets])[place], 0.0)
        for first, last in self.lost:
            out = (own >= pd.Timestamp(first)) & (own <= pd.Timestamp(last))
            known &= ~(np.asarray(out) & rows)
        return times + pd.to_timedelta(added, unit="s"), known

    def of_module(self, index: pd.Index, values: np.ndarray | pd.Series) -> np.ndarray:
        """The module's readings at corrected times, by the clock of the irradiance."""
        times = wall_time(datetimes(index)) - pd.Timestamp(self.origin)
        seconds = times.total_seconds().to_numpy()
        return self.module.corrected(seconds, np.asarray(values))


def datetimes(index: pd.Index) -> pd.DatetimeIndex:
    """The times of data whose clock is corrected; refuse an index without any."""
    if not isinstance(index, pd.DatetimeIndex):
        raise ValueError(no_datetimes("data", index))
    return index


def zone_name(index: pd.Index) -> str:
    """Name of the zone of an index; "" for one without times or zone."""
    if not isinstance(index, pd.DatetimeIndex) or index.tz is None:
        return ""
    return str(index.tz)
