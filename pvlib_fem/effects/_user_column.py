"""A user's column as an effect: heat proportional to it."""

from functools import partial

import numpy as np

from pvlib_fem._record.column_names import is_other_light
from pvlib_fem.effects._effect import Effect, Parameter, Terms

#: the same sunlight in other planes: no independent cause
IRRADIANCES = ("ghi", "dni", "dhi")


def deviation_from_mean(values: np.ndarray, *, heat: float, mean: float) -> Terms:
    """Heat per unit of the column above its mean."""
    return Terms(heat=heat * (values - mean))


def of_column(column: str, mean: float, most: float) -> Effect:
    """
    The effect of a column.

    Parameters
    ----------
    column : str
    mean : float
        Mean of the column in the tested record, in the column's unit.
    most : float
        Bound of its heat. [W/m² per unit]

    Returns
    -------
    Effect
        Its name is ``driver:<column>``.
    """
    return Effect(
        f"driver:{column}",
        partial(deviation_from_mean, mean=mean),
        {"heat": Parameter(0.0, -most, most, f"W/m² per unit of {column}")},
        columns=(column,),
        column=column,
        confounder=column in IRRADIANCES or is_other_light(column),
        decided_by=f"what {column} stands for",
        settings={"column": column, "mean": mean, "most": most},
    )
