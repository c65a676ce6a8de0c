"""Errors of a misshapen steady model, and of rows that are no means."""

import numpy as np

from pvlib_fem._record.inputs import Record
from pvlib_fem._relaxation import relax
from pvlib_fem._statistics.weekly_sums import least_squares_coefficients

#: of a step, from which a module temperature is not its mean but that of its end, which
#: is half a step early
EARLY = 0.125


def shape_errors(
    temperature: np.ndarray, record: Record, rows: np.ndarray
) -> dict[str, np.ndarray]:
    """
    Errors of a misshapen steady model at some rows, given other confounders.

    Functions of the usual inputs alone, which every cause without a driver of its own
    shares: curvature in the over-temperature, its fall with air temperature, a slower
    mass, a record that is late, and a sky that follows the air.

    Parameters
    ----------
    temperature : array, shape (n,)
        Of the model without bias and without changes of instruments. [°C]
    record : Record
    rows : array of int
        Of the record.

    Returns
    -------
    dict of array
        By name, on the rows.
    """
    air, hour = record["temp_air"], 3600.0 / record.inputs.unit
    over = temperature - air
    slow = relax(np.nan_to_num(over), record.inputs.steps, hour)[rows]
    late = slope_from_before(temperature, record)
    over = over[rows]
    columns = {
        "curved": over * np.sqrt(np.abs(over)),
        "warm": over * (air[rows] - np.nanmean(air)),
        "slow": slow - over,
        "late": np.nan_to_num(late[rows]),
        "air": air[rows] - np.nanmean(air),
    }
    return {f"misfit:{name}": column for name, column in columns.items()}


def early_errors(
    temperature: np.ndarray,
    record: Record,
    rows: np.ndarray,
    others: dict[str, np.ndarray],
    residual: np.ndarray,
) -> dict[str, np.ndarray]:
    """
    Error of a module temperature at the end of each step, whose irradiance is a mean.

    It is half a step early, by the slope to the next row.

    Parameters
    ----------
    temperature : array, shape (n,)
        Of the model without changes of instruments. [°C]
    record : Record
    rows : array of int
        Of the record.
    others : dict of array
        Columns given which it is, on the rows.
    residual : array
        Of the model, on the rows. [K]

    Returns
    -------
    dict of array
        By name. Where all columns are means, it is not early, and there is none.
    """
    after = np.append(slope_from_before(temperature, record)[1:], 0.0)
    early = np.nan_to_num(after[rows])
    table = np.column_stack([np.nan_to_num(c) for c in (*others.values(), early)])
    size = least_squares_coefficients(table, residual[:, None])[-1, 0]
    if size < EARLY * np.median(unit_steps(record)):
        return {}
    return {"misfit:early": early}


def slope_from_before(temperature: np.ndarray, record: Record) -> np.ndarray:
    """Change of a temperature from the row before, per unit of the record's steps."""
    return np.diff(temperature, prepend=temperature[:1]) / unit_steps(record)


def unit_steps(record: Record) -> np.ndarray:
    """Steps of a record; the first row has none before it."""
    return np.maximum(record.inputs.steps, 1.0)
