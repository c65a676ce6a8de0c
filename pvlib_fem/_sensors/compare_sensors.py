"""Fit and compare several module temperature sensors of one plant."""

from collections.abc import Iterable

import numpy as np
import pandas as pd

from pvlib_fem._fit import fit_fem
from pvlib_fem._loop.criteria import Criteria
from pvlib_fem._record.column_names import printable, with_aliases
from pvlib_fem._record.inputs import Record, as_record
from pvlib_fem._sensors.module_comparison import ModuleComparison
from pvlib_fem._sensors.sensor_errors import (
    SUNNY,
    compared_with_others,
    is_sensor,
    plausible_values,
    steps_of,
)
from pvlib_fem._spelling import ShellText, no_columns, refusal
from pvlib_fem._thermal.model import thermal_model
from pvlib_fem.scores import rmse

NAMED = ShellText("columns=[...]", "--map temp_module_1=COLUMN")
FEWEST = 2  # sensors
USUAL = ("poa_global", "temp_air", "wind_speed")
COLUMNS = ["share", "offset", "spread", "step", "change", "stderr"]
COLUMNS += ["left", "common", "own", "rows", "used", "note"]


def compare_modules(
    data: pd.DataFrame,
    columns: Iterable[str] | None = None,
    criteria: Criteria | None = None,
    model: str = "faiman",
    dynamics: str = "balance",
) -> ModuleComparison:
    """
    Separate errors of single module sensors from errors common to all.

    An error common to all sensors is one of the weather, the weather station or the
    plant. An error of one sensor is one of that sensor or its module. Each sensor is
    compared with the median of the others and fitted separately. Its residual is
    divided into a part that the other fits have, too, and its own part. With two
    sensors, a step can be in either.

    Parameters
    ----------
    data : DataFrame
        Record with a DatetimeIndex and ``poa_global`` [W/m²], ``temp_air`` [°C],
        ``wind_speed`` [m/s], which the model ``"ross"`` does not need, and the sensors
        [°C].
    columns : iterable of str, optional
        The sensors; by default all columns whose names begin with ``temp_module``.
    criteria : Criteria, optional
        Thresholds.
    model, dynamics : str, default "faiman", "balance"
        Model of the fits, see :func:`fit_fem`.

    Returns
    -------
    ModuleComparison

    Raises
    ------
    ValueError
        If a column is missing, or fewer than two sensors are there or can be used.

    Notes
    -----
    A copy of another sensor, a stuck sensor and a sensor with less than half of the
    values are reported and not used. Steps are searched as in :func:`close_loop`, in
    over-temperatures in sun, and reported from ``criteria.min_hint_reduction`` on. The
    largest step is removed before the next search, because it is in the median of the
    other sensors. With two sensors, one step is searched and both have it. To find
    which of them changed, call :func:`close_loop` with one as ``temp_module`` and the
    other as ``temp_module_2``.

    Examples
    --------
    >>> import pvlib_fem as fem
    >>> data = fem.datasets.synthetic(days=10, step=600)
    >>> over = data["temp_module"] - data["temp_air"]
    >>> for i, share in enumerate((1.0, 1.02, 0.9)):
    ...     data[f"temp_module_{i}"] = data["temp_air"] + share * over + 0.1 * i
    >>> comparison = fem.compare_modules(data.drop(columns="temp_module"))
    >>> comparison.table["share"].round(2).to_list()
    [1.04, 1.07, 0.89]
    >>> loop = fem.close_loop(comparison.common)
    """
    criteria = criteria or Criteria()
    series = with_aliases(data, needed=USUAL[:2])
    thermal_model(model, dynamics).refuse_without_wind(series)
    names = list(columns or (n for n in series if is_sensor(n)))
    if missing := [name for name in names if name not in series]:
        raise ValueError(f"{no_columns(missing)}; they have {', '.join(series)}")
    if len(names) < FEWEST:
        there = f" ({', '.join(names)})" if names else ""
        raise refusal(
            f"{len(names)} module sensors are there{there}, and at least {FEWEST} are "
            "needed; name others with ",
            NAMED,
        )
    usual = (series["poa_global"], series["temp_air"], series.get("wind_speed"))
    sensors, notes = plausible_values(usual, {n: series[n] for n in names}, criteria)
    off = {name for name, why in notes.items() if name not in sensors or why[0]}
    good = [name for name in names if name not in off]
    if len(good) < FEWEST:
        why = "; ".join(f"{n}: {notes[n][1]}" for n in names if n in off)
        raise ValueError(f"fewer than {FEWEST} module sensors can be used: {why}")
    record = as_record(*usual, series[good[0]])
    steps, level = steps_of(record, sensors, good, criteria)
    fits = {}
    for name in good:
        column = pd.Series(sensors[name], record.index)
        fits[name] = fit_fem(*usual, column, model, dynamics, check_units=False)
    parts = shared_residuals(record, fits)
    rows = {}
    for name in names:
        rows[name] = {"used": name in good, "note": notes[name][1]}
        rows[name] |= {"rows": 0, "step": ""} | parts.get(name, {})
        if name in level:
            over, others, (share, offset) = compared_with_others(
                record, name, level, good
            )
            row = {"share": share, "offset": offset}
            row["spread"] = rmse(over, share * others)
            row["rows"] = int(np.isfinite(sensors[name]).sum())
            rows[name] |= row | steps.get(name, {})
    table = pd.DataFrame.from_dict(rows, orient="index").reindex(columns=COLUMNS)
    # with two sensors, a step of one is in their mean
    kept = level if len(good) > 2 else sensors
    mean = np.mean([kept[name] for name in good], axis=0)
    common = data.drop(columns=[label for label in data if printable(label) in names])
    return ModuleComparison(
        table.rename_axis("sensor"), fits, common.assign(temp_module=mean)
    )


def shared_residuals(record: Record, fits: dict) -> dict[str, dict[str, float]]:
    """RMS residual of each fit in sun, its part common with the others, and its own."""
    residuals = {name: fit.residual.to_numpy() for name, fit in fits.items()}
    rows = np.isfinite(sum(residuals.values())) & (record["poa_global"] > SUNNY)
    parts = {}
    pair = len(residuals) == 2
    for name, own in residuals.items():
        # the common part of two sensors is their mean
        others = [residuals[n][rows] for n in residuals if pair or n != name]
        others = np.median(others, axis=0)
        parts[name] = {
            "left": rmse(own[rows], 0.0),
            "common": rmse(others, 0.0),
            "own": rmse(own[rows], others),
        }
    return parts
