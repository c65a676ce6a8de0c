"""The clock that a record kept on each day, by the middle of each day's light."""

import numpy as np

from pvlib_fem._statistics.changing_level import Law, Path, most_probable

GRID = 15.0  # min, of zones, and of the least change that is looked for
FARTHEST = 720.0  # min
ODDS = 1e-4  # chance that a clock is set anew on a day, to any time
HOURLY = 1e-3  # chance that it is set by an hour, as for summer time
ACCIDENT = 0.1  # share of days whose light shows nothing: snow, faults, shade
NOISE = 2.0  # min, that clouds leave in the middle of a day, at least
FINE = 1.0  # min
EDGE = 0.125  # of a step: where between two rows the light begins
MEMORY = 2.0  # days that weather and faults last
SWING = 5.0  # min, of each harmonic: what plane and horizon do to the edges of light


def clock_of(day: np.ndarray, minutes: np.ndarray, step: float = GRID) -> Path:
    """
    The clock on each day, on a grid of 15 min.

    Parameters
    ----------
    day : array of int
        Number of each day.
    minutes : array
        How much later than due the middle of its light is. [min]
    step : float
        Of the rows. [min]

    Returns
    -------
    Path
    """
    law = Law(
        np.arange(-FARTHEST, FARTHEST, GRID),
        odds=ODDS,
        accident=ACCIDENT,
        least=max(NOISE, EDGE * step),
        fine=FINE,
        memory=MEMORY,
        swing=SWING,
        period=2.0 * FARTHEST,
        steps=((round(60.0 / GRID), HOURLY),),
    )
    return most_probable(day, minutes, law)
