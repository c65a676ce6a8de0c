"""Clocks and places of a file that the sun contradicts: corrected, or reported."""

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
from pvlib.location import Location

from pvlib_fem._findings import Check, Correction
from pvlib_fem.drivers._mounts import ANGLES
from pvlib_fem.drivers._solar import standard_time
from pvlib_fem.quality._daylight import Daylight, daylight_saving
from pvlib_fem.quality._limits import Limits
from pvlib_fem.quality._plane import Plane
from pvlib_fem.reasons import Reason, because

if TYPE_CHECKING:
    from pvlib_fem._loop.preparation.screened_frame import Look

NEAR_HOUR = 0.25  # h from a whole one, as near as a file of half hours shows it
SUNLESS = "until then no effect that follows the sun is tried"


def clock_jumps(
    look: "Look", limits: Limits
) -> tuple[Daylight | None, list[Correction]]:
    """
    The jumps of a file's clock, and what is made of them.

    Parameters
    ----------
    look : Look
    limits : Limits

    Returns
    -------
    Daylight or None
        By which the file is to be corrected; None where nothing is, or no law is sure.
    list of Correction
        One, if the clock jumps and the place is known.
    """
    faults, site = look.health.faults, look.site
    jumps = [faults[name] for name in ("file_dst", "file_jump") if name in faults]
    if not jumps or site["location"] is None:
        return None, []
    place = look.filled.plane(site) | {"limits": limits}
    summer = daylight_saving(look.light, look.whole.index, look.health.noon, **place)
    correction = jumps_correction(summer, "; ".join(jumps))
    return summer if summer.explained else None, [correction]


def faults_of_place(
    look: "Look", site: dict[str, Any], other: Plane | None
) -> Iterator[Correction]:
    """
    Faults of times or place by the sun, which the user alone can set right.

    Parameters
    ----------
    look : Look
    site : dict
        The place, with the plane that is stated.
    other : Plane or None
        Another plane, which the irradiance surely has.

    Yields
    ------
    Correction
    """
    faults = look.health.faults
    if fault := faults.get("file_shift"):
        late = look.health.noon.late
        zone = zone_of_the_sun(look.whole.index, late, site["location"])
        fits = f" (the sun fits {zone})" if zone else ""
        remedy = (
            f"give the times the zone that they are in{fits}, or set the location "
            f"right; {SUNLESS}"
        )
        minutes = late / 60.0
        values = {"late": minutes}
        yield uncorrected("file_shift", fault, remedy, abs(minutes), values)
    if fault := faults.get("file_latitude"):
        yield uncorrected("file_latitude", fault, SUNLESS)
    if other is not None:
        tilt, azimuth = (site[name] for name in ANGLES)
        fault = (
            f"the irradiance is not of the stated plane (tilt {tilt:g}°, azimuth "
            f"{azimuth:g}°): it has {other}"
        )
        remedy = "until then effects of the sun on that plane may be wrong"
        yield uncorrected("file_plane", fault, remedy)


def jumps_correction(summer: Daylight, fault: str) -> Correction:
    """The correction of a file whose clock jumps, or why there is none."""
    noon = "middle of the daily irradiance against the sun, root mean square"
    why = because(Reason.ONE_CLOCK, fault=summer.brief, evidence=summer.evidence)
    if not summer.explained:
        why = because(Reason.NOT_CORRECTED, fault=fault, remedy=summer.line)
    values = {"summer": 60.0} if summer.zone else {}
    values |= {str(day.date()): by / 60.0 for day, by in summer.jumps}
    check = Check(noon, "", summer.after, summer.before, most=True, unit="min")
    return Correction(
        fault=summer.fault,
        columns=("all",),
        values=values,
        stderr={},
        before=summer.before,
        after=summer.after,
        unit="min",
        because=why,
        checks=(check,) if summer.explained else (),
        applied=summer.explained,
    )


def zone_of_the_sun(index: pd.DatetimeIndex, late: float, location: Location) -> str:
    """The zone in which times fit the sun that is late in theirs, or none."""
    utc = index if index.tz is not None else standard_time(index, location)
    own = index.tz_localize(None) - utc.tz_convert("UTC").tz_localize(None)
    hours = own[0] / pd.Timedelta(hours=1) + late / 3600.0
    whole = round(hours)
    if own[0] != own[-1] or abs(hours - whole) > NEAR_HOUR or not -12 <= whole <= 14:
        return ""
    return f"Etc/GMT{-whole:+d}"  # this zone's sign is reversed


def uncorrected(
    name: str,
    fault: str,
    remedy: str,
    error: float = np.nan,
    values: dict[str, float] | None = None,
) -> Correction:
    """The report on a fault of times or place that the user alone can set right."""
    return Correction(
        fault=name,
        columns=("all",),
        values=values or {},
        stderr={},
        before=error,
        after=error,
        unit="min",
        because=because(Reason.NOT_CORRECTED, fault=fault, remedy=remedy),
        applied=False,
    )
