"""Faults of sensors and loggers, found before any model is fitted.

No check needs a thermal model: a sensor that is stuck while the others
move, a file whose noon is at one o'clock (`noon`), a module that answers before the
sun asks (`clock`), a driver in another unit (`units`).
"""

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from pvlib.location import Location

from pvlib_fem._record.inputs import Record
from pvlib_fem.quality._file_scan import Look
from pvlib_fem.quality._limits import POSSIBLE, Limits
from pvlib_fem.quality._module_lag import Clock, clock_shift
from pvlib_fem.quality._noon import SolarNoon, solar_noon_shift
from pvlib_fem.quality._screening import stuck_rows
from pvlib_fem.quality._stray_times import refuse_stray
from pvlib_fem.quality._stuck import refuse_always_stuck, stuck_line
from pvlib_fem.quality._unit_checks import doubtful, in_step, module_lag


@dataclass(frozen=True, eq=False)
class Health:
    """What is wrong with a record before anything is fitted, from :func:`check`."""

    frozen: dict[str, np.ndarray]  # rows of stuck sensors, by column
    clock: Clock
    noon: SolarNoon
    doubtful: dict[str, str]  # drivers that must not be used, and why
    faults: dict[str, str] = field(default_factory=dict)  # name: one line

    @property
    def mask(self) -> np.ndarray:
        """Rows in which one of the four sensors is stuck."""
        return unusable_rows(self.frozen)

    @property
    def stuck(self) -> dict[str, int]:
        """Rows of each stuck sensor."""
        return {name: int(rows.sum()) for name, rows in self.frozen.items()}

    @property
    def unchecked(self) -> tuple[str, ...]:
        """What could not be checked, one line each."""
        whys = (self.clock.why if not self.clock.fault else "", self.noon.why)
        return tuple(filter(None, whys))

    @property
    def notes(self) -> tuple[str, ...]:
        """One line each, with its remedy: the faults, and what was not checked."""
        return (*self.faults.values(), *self.unchecked)


def unusable_rows(frozen: dict) -> np.ndarray:
    """Rows in which one of the four sensors is stuck."""
    return np.any([frozen[name] for name in POSSIBLE], axis=0)


def frozen_in(
    record: Record, limits: Limits, known: Look | None = None
) -> dict[str, np.ndarray]:
    """Rows of stuck sensors whose drivers change, by one clock."""
    frozen = stuck_rows(record, limits, known)
    # their drivers are known without the module's column, which may be off by hours
    others = any(rows.any() for n, rows in frozen.items() if n != "temp_module")
    if not others or (off := module_lag(record.inputs, limits)) is None:
        return frozen
    timed = replace(record, inputs=in_step(record.inputs, off))
    in_time = stuck_rows(timed, limits, known)
    return in_time | {"temp_module": frozen["temp_module"]}


def check(
    record: Record,
    location: Location | None = None,
    surface_tilt: float | None = None,
    surface_azimuth: float | None = None,
    limits: Limits | None = None,
    light: Any = None,
    mount: Any = None,
    known: Look | None = None,
) -> Health:
    """
    Find faults of sensors and loggers in a measured record.

    Parameters
    ----------
    record : Record
        From ``record.inputs.as_record``, with the drivers that are to be used.
    location : pvlib.location.Location, optional
        For :func:`solar_noon_shift`.
    surface_tilt, surface_azimuth : float, optional
        Of the irradiance sensor. [°]
    limits : Limits, optional
        The thresholds.
    light : array, optional
        Irradiance of that plane, by default ``poa_global``. [W/m²]
    mount : pvlib.pvsystem.AbstractMount, optional
        Of a sensor that moves.
    known : Look, optional
        At some of the columns, which are not read again.

    Returns
    -------
    Health
        ``faults`` by name: ``stuck``, ``clock_shift``, ``clock_drift``, ``dst``,
        ``file_shift``, ``file_dst``, ``units:<column>``. ``mask`` has the rows that
        must not be used; a clock is corrected by ``clock.corrected``.

    Raises
    ------
    ValueError
        If a sensor is stuck for the whole record, so that no row remains, or
        some rows are years from all others.
    """
    limits = limits or Limits()
    refuse_stray(record.index, limits)
    frozen = frozen_in(record, limits, known)
    refuse_always_stuck(record, frozen)
    clock = clock_shift(record, unusable_rows(frozen), limits)
    place = (location, surface_tilt, surface_azimuth)
    light = record["poa_global"] if light is None else light
    noon = solar_noon_shift(light, record.index, *place, limits, mount)
    doubts = doubtful(record.inputs.columns, limits)
    still = any(rows.any() for rows in frozen.values())
    faults = {"stuck": stuck_line(record, frozen)} if still else {}
    faults |= clock.faults | noon.faults
    faults |= {f"units:{name}": f"{name} {line}" for name, line in doubts.items()}
    return Health(frozen, clock, noon, doubts, faults)
