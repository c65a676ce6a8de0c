"""The design of a fitted model: its tangents, and those of all effects, per hour."""

from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from pvlib_fem._loop.regression.design import Design
from pvlib_fem._loop.regression.evidence import Evidence
from pvlib_fem._record.column_names import COLUMNS, GEOMETRY, is_power
from pvlib_fem._record.inputs import Record
from pvlib_fem._statistics.axes import calendar_of
from pvlib_fem._statistics.hourly_means import Hours
from pvlib_fem._statistics.weekly_sums import least_squares_coefficients
from pvlib_fem.drivers import derive_drivers, is_derived, is_modelled, own_columns
from pvlib_fem.effects._effect import Effect
from pvlib_fem.effects._time_profiles import weights_of

ALIKE = 1e-6  # share of a column's square below which it is a sum of others


def design_of_evidence(
    evidence: Evidence,
    record: Record,
    drivers: Iterable[str],
    lifted: Sequence[Effect],
    coefficients: Mapping[str, float],
) -> Design:
    """
    The design of the evidence of a fitted model with some coefficients.

    Parameters
    ----------
    evidence : Evidence
    record : Record
        Of whose rows the evidence is.
    drivers : iterable of str
        Measured columns beyond the usual ones.
    lifted : sequence of Effect
        Effects of the model that the selection may add or not: what they explain is
        added to the residual.
    coefficients : dict of float
        All of the model's.

    Returns
    -------
    Design
    """
    hours = Hours.from_record(record, evidence.rows)
    first, rows, means = hours.first, hours.count, hours.means
    sensor_faults = {
        effect.sensor_fault: column for effect, column in evidence.changing
    }
    residual = evidence.residual
    own: dict[str, tuple[str, ...]] = {}
    taken: set[str] = set()
    for effect in lifted:
        keys = [key for key in effect.rows() if key in evidence.columns]
        tangents = {name: evidence.columns[name] for name in keys}
        if effect.sensor_fault in sensor_faults:
            (name,), weights = effect.rows(), weights_of(effect, evidence.dates)
            column = evidence.columns[sensor_faults[effect.sensor_fault]]
            tangents = {name: weights * column}
        for name, column in tangents.items():
            size = coefficients[name] - effect.start.get(name, 0.0)
            residual = residual + size * np.nan_to_num(column)
        taken |= {*keys}
        if not effect.sensor_fault and keys:
            own[effect.name] = tuple(keys)
    effects = {e.name: e for e in lifted if e.name in own} | evidence.effects
    own |= evidence.own
    base = [*(n for n in evidence.base if n not in taken), *evidence.misfits]
    tested = [name for names in own.values() for name in names]
    wanted = dict.fromkeys([*base, *tested, *sensor_faults.values()])
    columns = {n: means(evidence.columns[n]) for n in wanted}
    usual = np.nan_to_num([columns[n] for n in base])
    for name in wanted:
        missing = np.isnan(evidence.columns[name])
        if missing.any():
            known = 1.0 - means(missing.astype(float))
            columns[name] = filled(columns[name], known, usual, rows)
    cells = np.array([means(residual), *columns.values()]).T
    scale = np.sqrt(rows @ cells**2 / rows.sum())
    scale[(scale == 0) | (np.arange(len(scale)) == 0)] = 1.0
    order = {name: i + 1 for i, name in enumerate(wanted)}
    measured = drivers_of(record, evidence.rows, drivers)
    derived = derived_of(record, evidence.rows, effects.values())
    places = hours.means_of_drivers(measured)
    places |= calendar_of(record.index[evidence.rows][first])
    return Design(
        names=("residual", *wanted),
        cells=cells / scale,
        scale=scale,
        rows=rows,
        days=evidence.dates[first],
        base=tuple(order[name] for name in base),
        own={
            n: independent_columns(cells, rows, [order[c] for c in names])
            for n, names in own.items()
        },
        effects=effects,
        sensor_faults={n: order[c] for n, c in sensor_faults.items()},
        changing=tuple(effect for effect, _ in evidence.changing),
        places=places,
        derived=hours.means_of_drivers(derived),
    )


def filled(
    column: np.ndarray, known: np.ndarray, usual: np.ndarray, rows: np.ndarray
) -> np.ndarray:
    """
    A column of an effect with the expected value in cells without its driver.

    An effect also acts where its driver is not known. With zeros there, it would seem
    to come and go with the gaps. What ``usual`` columns predict says nothing of it.
    ``known`` is the share of each cell's rows in which the column is known.
    """
    there = known > 0.0
    root = np.sqrt(rows * known)[there]
    slopes = least_squares_coefficients(
        (usual[:, there] * root).T, (column[there] * root)[:, None]
    )
    return np.where(there, column, slopes[:, 0] @ usual)


def independent_columns(
    cells: np.ndarray, rows: np.ndarray, places: Iterable[int]
) -> tuple[int, ...]:
    """Drop columns of an effect that are sums of its others, as in one hour of snow."""
    root = np.sqrt(rows)
    kept: list[int] = []
    for place in places:
        column = cells[:, place] * root
        if kept:
            table = cells[:, kept] * root[:, None]
            rest = column - table @ np.linalg.lstsq(table, column, rcond=None)[0]
            if rest @ rest <= ALIKE * (column @ column):
                continue
        kept.append(place)
    return tuple(kept)


def drivers_of(
    record: Record, rows: np.ndarray, drivers: Iterable[str]
) -> dict[str, np.ndarray]:
    """Inputs, geometry and measured drivers of a record at some rows."""
    # power follows irradiance, and a table by power would explain irradiance
    names = {*COLUMNS[:3], *GEOMETRY, *drivers} & {*record.inputs.columns} - {
        "p_dc_per_area"
    }
    return {name: record[name][rows] for name in sorted(names)}


def derived_of(
    record: Record, rows: np.ndarray, effects: Iterable[Effect]
) -> dict[str, np.ndarray]:
    """What effects derive from measured columns of their own, at some rows."""
    drivers = dict.fromkeys(name for effect in effects for name in effect.drivers)
    names = []
    for name in filter(is_derived, drivers):
        own = own_columns([name])
        # power follows irradiance, and so does what is derived from it
        if own and not is_modelled([name]) and not any(map(is_power, own)):
            names.append(name)
    inputs = derive_drivers(record.inputs, names)
    return {name: inputs[name][rows] for name in names}
