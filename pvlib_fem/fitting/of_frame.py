"""The fit of a frame, as the loop takes one."""

from pvlib_fem.drivers import geometry, needed_for
from pvlib_fem.effects.candidates import candidates
from pvlib_fem.fitting.fit import fit_fem
from pvlib_fem.record.columns import COLUMNS, with_aliases
from pvlib_fem.spelling import Spelled, refusal

NAMED = Spelled(
    "name its column, and give location, surface_tilt and surface_azimuth",
    "name a column with --map, the place with --lat, --lon, --tilt and --azimuth",
)


def fit_frame(
    data,
    effects=(),
    location=None,
    surface_tilt=None,
    surface_azimuth=None,
    **options,
):
    """
    The fit of a frame, with the drivers that its effects need.

    Parameters
    ----------
    data : DataFrame
        As :func:`pvlib_fem.close_loop` takes it.
    effects : sequence of str, dict or Effect
    location, surface_tilt, surface_azimuth
        As in :func:`pvlib_fem.close_loop`; none is estimated.
    **options
        Of :func:`pvlib_fem.fit_fem`.

    Returns
    -------
    FemFit
    """
    columns = there = with_aliases(data)
    if effects:
        place = geometry(data.index, location, surface_tilt, surface_azimuth)
        there = {**place, **columns}
    chosen, lacking = candidates(there, {}, effects)
    for name, why in lacking.items():
        raise refusal(f"the effect {name} cannot be fitted: {why}; ", NAMED)
    wanted = {name for effect in chosen for name in needed_for(effect.drivers)}
    drivers = {name: there[name] for name in there if name in wanted}
    return fit_fem(
        *(columns[name] for name in COLUMNS), effects=chosen, **options, **drivers
    )
