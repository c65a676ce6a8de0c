"""From a frame to a fit or a loop."""

import sys
from zoneinfo import available_timezones

from pvlib.location import Location

from pvlib_fem.cli.words import note
from pvlib_fem.drivers import geometry, needed_for
from pvlib_fem.effects import find
from pvlib_fem.effects.candidates import candidates
from pvlib_fem.fitting.fit import fit_fem
from pvlib_fem.loop.close import close_loop
from pvlib_fem.loop.progress import line
from pvlib_fem.record.columns import COLUMNS, with_aliases
from pvlib_fem.recovery.recover import recover


def closed(data, model="faiman", no_unit_check=False, site=None, **options):
    """The loop of a frame, with its progress on a terminal."""
    with line() as bar:
        return close_loop(
            data,
            model,
            **(site or {}),
            **options,
            check_units=not no_unit_check,
            progress=bar.set_description_str,
        )


def injected(data, no_unit_check=False, site=None, **options):
    """What is found of effects that are put into a frame."""
    return recover(
        data,
        **(site or {}),
        **options,
        check_units=not no_unit_check,
        progress=sys.stderr.isatty(),
    )


def fitted(data, effects, site, no_unit_check=False, **options):
    """The fit of a frame, with the drivers of its effects."""
    columns = with_aliases(data)
    there = {**geometry(data.index, **site), **columns} if effects else columns
    chosen, lacking = candidates(there, {}, effects)
    for name, why in lacking.items():
        raise ValueError(
            f"the effect {name} cannot be fitted: {why}; name a column with --map, the "
            "place with --lat, --lon, --tilt and --azimuth"
        )
    wanted = {name for effect in chosen for name in needed_for(effect.drivers)}
    drivers = {name: there[name] for name in there if name in wanted}
    return fit_fem(
        *(columns[name] for name in COLUMNS),
        effects=chosen,
        check_units=not no_unit_check,
        **options,
        **drivers,
    )


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


def site_of(index, lat, lon, tilt, azimuth):
    """The place as the loop takes it."""
    return {
        "location": None if lat is None else location(index, lat, lon),
        "surface_tilt": tilt,
        "surface_azimuth": azimuth,
    }


def location(index, lat, lon):
    """Where the record is from, in its zone or in local standard time."""
    tz = str(index.tz) if getattr(index, "tz", None) is not None else ""
    if not tz:
        tz = standard_zone(lon)
    elif tz not in available_timezones():  # an offset, which is no zone
        tz = "UTC"
    return Location(lat, lon, tz=tz)


def in_local_days(data, lon, told):
    """Instants in UTC, of which nobody told the zone, with the days of their place."""
    if lon is None or told or str(data.index.tz) != "UTC":
        return data
    zone = standard_zone(lon)
    note(f"the times are instants; days and hours are told in {zone}, by --lon")
    return data.tz_convert(zone)


def standard_zone(lon):
    """Standard time by the longitude alone."""
    return f"Etc/GMT{-round(lon / 15):+d}"  # this zone's sign is reversed


def check_partners(options):
    """Refuse half a place."""
    for pair in (("lat", "lon"), ("tilt", "azimuth")):
        given = [name for name in pair if options[name] is not None]
        if len(given) == 1:
            (other,) = set(pair) - set(given)
            raise ValueError(f"--{given[0]} needs --{other} beside it")
