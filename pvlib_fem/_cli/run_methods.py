"""From a frame to a fit or a loop."""

import sys

from pvlib_fem._cli.printing import waiting
from pvlib_fem._fit import fit_fem, fit_frame
from pvlib_fem._loop.close import close_loop
from pvlib_fem._loop.progress import line
from pvlib_fem._recovery.recover import recover_effects
from pvlib_fem.effects import find


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
    options["check_units"] = not no_unit_check
    with waiting("fitting …"):
        return fit_frame(data, effects, **site, **options)


def fitted_files(record, effects, no_unit_check=False, **options):
    """The fit of Parquet files that follow each other."""
    effects = [find(one) for one in effects]
    options["check_units"] = not no_unit_check
    with waiting("fitting, part by part …"):
        return fit_fem(record, effects=effects, **options)
