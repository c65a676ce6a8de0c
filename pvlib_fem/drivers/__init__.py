"""Drivers of effects that are computed from the measured columns."""

from pvlib_fem.drivers._derived import (  # noqa: F401  for other packages
    DERIVED,
    MEASURED,
    MODELLED,
    Driver,
    constants,
    derive_drivers,
    drivers_with_memory,
    is_derived,
    is_modelled,
    lost_without,
    needed_for,
    own_columns,
    own_constants,
    short_memory,
    underived,
    with_constants,
)
from pvlib_fem.drivers._mounts import checked_place, geometry  # noqa: F401
from pvlib_fem.drivers._solar import standard_time, sun  # noqa: F401
from pvlib_fem.drivers._water import FROST, snow_at_most  # noqa: F401

__all__ = ["sun"]
