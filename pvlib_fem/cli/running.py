"""From a frame to a fit or a loop."""

import sys

from pvlib_fem.cli.words import note
from pvlib_fem.drivers.place import in_local_days
from pvlib_fem.effects import find
from pvlib_fem.fit import fit_fem, fit_frame
from pvlib_fem.loop.close import close_loop
from pvlib_fem.loop.progress import line
from pvlib_fem.recovery.recover import recover_effects


def closed(
    data, model="faiman", no_unit_check=False, site=None, ceiling=False, **options
):
    """The loop of a frame, with its progress on a terminal."""
    with line() as bar:
        found = close_loop(
            data,
            model,
            **(site or {}),
            **options,
            check_units=not no_unit_check,
            progress=bar.set_description_str,
        )
        if ceiling:
            bar.set_description_str("growing trees")
            found.ceiling()
        return found


def injected(data, no_unit_check=False, site=None, **options):
    """What is found of effects that are put into a frame."""
    return recover_effects(
        data,
        **(site or {}),
        **options,
        check_units=not no_unit_check,
        progress=sys.stderr.isatty(),
    )


def fitted(data, effects, site, no_unit_check=False, **options):
    """The fit of a frame."""
    return fit_frame(data, effects, **site, check_units=not no_unit_check, **options)


def fitted_files(record, effects, no_unit_check=False, **options):
    """The fit of Parquet files that follow each other."""
    effects = [find(one) for one in effects]
    return fit_fem(record, effects=effects, check_units=not no_unit_check, **options)


def effects_of(texts, settings):
    """The effects of --effects from the catalogue, with their settings."""
    names = [name.strip() for text in texts for name in text.split(",")]
    for name in names:
        find(name)
    if twice := [name for name in names if names.count(name) > 1]:
        raise ValueError(f"--effects has {twice[0]} twice")
    if strange := [name for name in settings if name not in names]:
        raise ValueError(
            f"--effect-setting is given for {strange[0]}, which is not among --effects"
        )
    chosen = [{"name": name, **settings.get(name, {})} for name in names]
    return [find(one).spec for one in chosen]


def in_their_days(data, lon, told):
    """Instants with the days of their place, and a note where nobody told the zone."""
    local = in_local_days(data, lon, told)
    if local is not data:
        note(
            f"the times are instants; days and hours are those of {local.index.tz}, by "
            "--lon"
        )
    return local


def check_partners(options):
    """Refuse half a place."""
    for pair in (("lat", "lon"), ("tilt", "azimuth")):
        given = [name for name in pair if options[name] is not None]
        if len(given) == 1:
            (other,) = set(pair) - set(given)
            raise ValueError(f"--{given[0]} needs --{other}, too")
