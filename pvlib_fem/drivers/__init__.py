"""Drivers of effects that are computed from the measured columns."""

from pvlib_fem.drivers.derived import (  # noqa: F401  for other packages
    DERIVED,
    MEASURED,
    MODELLED,
    Driver,
    behind,
    completed,
    constants,
    is_modelled,
    lost_without,
    needed_for,
    own_constants,
    remembered,
    short_memory,
    with_constants,
)
from pvlib_fem.drivers.solar import (  # noqa: F401
    checked_place,
    geometry,
    standard_time,
    sun,
)

__all__ = ["sun"]
