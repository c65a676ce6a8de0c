"""Faults of sensors and loggers, found before any model is fitted.

What is checked needs no thermal model: a sensor that stands still while the others
move, a file whose noon is at one o'clock (`noon`), a module that answers before the
sun asks (`clock`), a driver in another unit (`doubts`).
"""

from dataclasses import dataclass, field

import numpy as np

from pvlib_fem.quality.clock import Clock, clock_shift
from pvlib_fem.quality.noon import SolarNoon, solar_noon_shift
from pvlib_fem.quality.stuck import stuck, stuck_line
from pvlib_fem.quality.units import doubtful


@dataclass(frozen=True, eq=False)
class Health:
    """What is wrong with a record before anything is fitted, from :func:`check`."""

    mask: np.ndarray  # True: a row that must not be used
    stuck: dict[str, int]  # rows by column
    clock: Clock
    noon: SolarNoon
    doubtful: dict[str, str]  # drivers that must not be used, and why
    faults: dict[str, str] = field(default_factory=dict)  # name: one line

    @property
    def unchecked(self) -> tuple:
        """What could not be checked, one line each."""
        return () if self.clock.fault else tuple(filter(None, (self.clock.why,)))

    @property
    def notes(self) -> tuple:
        """One line each, with its remedy: the faults, and what was not checked."""
        return (*self.faults.values(), *self.unchecked)


def check(record, location=None, surface_tilt=None, surface_azimuth=None) -> Health:
    """
    Find faults of sensors and loggers in a measured record.

    Parameters
    ----------
    record : Record
        From ``records.measured``, with the drivers that are to be used.
    location : pvlib.location.Location, optional
        For :func:`solar_noon_shift`.
    surface_tilt, surface_azimuth : float, optional
        Of the irradiance sensor. [°]

    Returns
    -------
    Health
        ``faults`` by name: ``stuck``, ``clock_shift``, ``clock_drift``, ``dst``,
        ``file_shift``, ``file_dst``, ``units:<column>``. ``mask`` has the rows of
        stuck sensors; a clock is corrected by ``clock.corrected``.
    """
    frozen = stuck(record)
    mask = np.any(list(frozen.values()), axis=0)
    clock = clock_shift(record, skip=mask)
    noon = solar_noon_shift(
        record["poa_global"], record.index, location, surface_tilt, surface_azimuth
    )
    doubts = doubtful(record.inputs.columns)
    faults = {"stuck": stuck_line(record, frozen)} if mask.any() else {}
    faults |= clock.faults | noon.faults
    faults |= {f"units:{name}": line for name, line in doubts.items()}
    counts = {name: int(rows.sum()) for name, rows in frozen.items()}
    return Health(mask, counts, clock, noon, doubts, faults)
