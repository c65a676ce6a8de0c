"""Options of a fit: site, model and effects."""

from collections.abc import Callable

import click

from pvlib_fem._cli.headings import (
    COLUMNS,
    EFFECTS,
    MODEL,
    SITE,
    option_maker,
    with_options,
)
from pvlib_fem._fit import METHODS
from pvlib_fem._loop.criteria import Criteria
from pvlib_fem._thermal.model import MEMORY
from pvlib_fem._thermal.steady_models import STEADY_MODELS
from pvlib_fem.drivers._transposition import TRANSPOSITIONS

column, site, model, effect = map(option_maker, (COLUMNS, SITE, MODEL, EFFECTS))
site_options = with_options(
    site("--lat", type=click.FloatRange(-90, 90), help="North positive [°]."),
    site("--lon", type=click.FloatRange(-180, 180), help="East positive [°]."),
    site("--tilt", type=click.FloatRange(0, 180), help="Of the module [°]."),
    site(
        "--azimuth",
        type=click.FloatRange(-360, 360),
        help="Of the module, from north by east [°].",
    ),
    site(
        "--axis-tilt",
        type=click.FloatRange(0, 90),
        help="Of the axis of a tracker, instead of --tilt; 0 by default, as pvlib has "
        "it [°].",
    ),
    site(
        "--axis-azimuth",
        type=click.FloatRange(-360, 360),
        help="Of the axis, from north by east; 0 by default [°].",
    ),
    site(
        "--max-angle",
        type=click.FloatRange(0, 180),
        help="Largest rotation of the tracker to either side; 90 by default [°].",
    ),
    site(
        "--gcr",
        type=click.FloatRange(0.01, 1),
        help="Width of a row of trackers over the distance of rows; 2/7 by default.",
    ),
    site(
        "--backtrack/--no-backtrack",
        default=None,
        help="Whether rows turn back from a low sun, the default.",
    ),
)
transposition_option = site(
    "--transposition",
    type=click.Choice(TRANSPOSITIONS),
    help="Where there is no poa_global, the model of the sky by which it is made of "
    "ghi; it takes --lat, --lon, --tilt and --azimuth.",
)
stand_in_option = column(
    "--stand-in",
    "stand_ins",
    multiple=True,
    metavar="NAME",
    help="Second source of air or wind that replaces missing values of the first, such "
    "as temp_air_2 or wind_speed_2; once for each.",
)
effects_option = effect(
    "--effects",
    multiple=True,
    metavar="NAME,NAME,…",
    help="Physical effects: fit adds these, loop and fleet try no others, recover "
    "puts them in.",
)
fix_option = model(
    "--fix",
    multiple=True,
    metavar="NAME=NUMBER",
    help="Coefficient that is known, such as tau=378; once for each.",
)
shared_options = with_options(
    effects_option,
    effect(
        "--effect-setting",
        "settings",
        multiple=True,
        metavar="NAME.SETTING=VALUE",
        help="Setting of one of --effects, such as soiling.cleaning=6 or "
        "sky_radiation.source=humidity; once for each.",
    ),
    model(
        "--holdout",
        multiple=True,
        metavar="DAY | DAY..DAY",
        help="Days that no fit sees, such as 2024-07-01..2024-07-07; once for each.",
    ),
    fix_option,
)
min_rmse_reduction_option = effect(
    "--min-rmse-reduction",
    "--min-gain",
    type=click.FloatRange(min=0),
    default=Criteria().min_rmse_reduction,
    show_default=True,
    help="Reduction of the RMSE below which no effect is added [K].",
)


def model_option(default: str, instead: str) -> Callable:
    """
    Option for the steady model.

    Parameters
    ----------
    default : str
        Steady model without the option.
    instead : str
        What the help says of the default, without a full stop.

    Returns
    -------
    callable
        Decorator of a command, which gets ``model``.
    """
    return model(
        "--model",
        type=click.Choice(list(STEADY_MODELS)),
        default=default,
        show_default=True,
        help=f"Steady model; {instead}.",
    )


fit_options = with_options(
    model_option("wm1", "the paper's first by default, where loop takes faiman"),
    model(
        "--dynamics",
        type=click.Choice(list(MEMORY)),
        default="ewm",
        show_default=True,
        help="The paper's by default; loop takes the better of ewm and balance.",
    ),
    model(
        "--method",
        type=click.Choice(METHODS),
        default="least_squares",
        show_default=True,
    ),
    model(
        "--calm-wind",
        type=float,
        default=0.5,
        show_default=True,
        help="Wind that the paper's recipe takes as calm [m/s].",
    ),
)
