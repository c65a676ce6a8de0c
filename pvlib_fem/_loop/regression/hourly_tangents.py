"""The design of a fitted model: its tangents, and those of all effects, per hour."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace

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
    coefficients: Mapping[str, float],
    lifted: Sequence[Effect] = (),
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
    coefficients : dict of float
        All of the model's.
    lifted : sequence of Effect, optional
        Effects of the model that the selection may add or not: what they explain is
        added to the residual.

    Returns
    -------
    Design
    """
    hours = Hours.from_record(record, evidence.rows)
    rows = hours.count
    columns = hourly_columns(evidence, hours, coefficients, lifted)
    cells = np.array([*columns.values()]).T
    scale = np.sqrt(rows @ cells**2 / rows.sum())
    scale[(scale == 0) | (np.arange(len(scale)) == 0)] = 1.0
    order = {name: i for i, name in enumerate(columns)}
    own = {
        name: independent_columns(cells, rows, [order[key] for key in keys])
        for name, keys in keys_of(evidence, lifted).items()
    }
    effects = {e.name: e for e in lifted if e.name in own} | evidence.effects
    measured = drivers_of(record, evidence.rows, drivers)
    derived = derived_of(record, evidence.rows, effects.values())
    places = hours.means_of_drivers(measured)
    places |= calendar_of(record.index[evidence.rows][hours.first])
    return Design(
        names=(*columns,),
        cells=cells / scale,
        scale=scale,
        rows=rows,
        days=evidence.dates[hours.first],
        base=tuple(order[name] for name in base_of(evidence, lifted)),
        own=own,
        effects=effects,
        sensor_faults={
            one.sensor_fault: order[column] for one, column in evidence.changing
        },
        changing=tuple(effect for effect, _ in evidence.changing),
        places=places,
        derived=hours.means_of_drivers(derived),
    )


def with_added(
    design: Design,
    record: Record,
    coefficients: Mapping[str, float],
    lifted: Sequence[Effect],
    without: Iterable[tuple[Effect, Evidence]],
) -> Design:
    """
    The design with what some lifted effects add to its columns.

    Parameters
    ----------
    design : Design
    record : Record
        Of whose rows the evidence is.
    coefficients : dict of float
        All of the model's.
    lifted : sequence of Effect
        Effects of the model that the selection may add or not.
    without : iterable of (Effect, Evidence)
        Some of these, each with the evidence by the model without it.

    Returns
    -------
    Design
    """
    added = {}
    for effect, evidence in without:
        if effect.name not in design.own:
            continue
        rest = [one for one in lifted if one is not effect]
        hours = Hours.from_record(record, evidence.rows)
        columns = hourly_columns(evidence, hours, coefficients, rest)
        more = np.zeros_like(design.cells)
        for place, name in enumerate(design.names):
            if name in columns:
                less = columns[name] / design.scale[place]
                more[:, place] = design.cells[:, place] - less
        added[design.own[effect.name]] = more
    return replace(design, added=added)


def keys_of(evidence: Evidence, lifted: Iterable[Effect]) -> dict[str, tuple[str, ...]]:
    """Names of the tangents of each effect that has no date, lifted or a candidate."""
    own = {
        effect.name: tuple(key for key in effect.rows() if key in evidence.columns)
        for effect in lifted
        if not effect.sensor_fault
    }
    return {name: keys for name, keys in own.items() if keys} | evidence.own


def base_of(evidence: Evidence, lifted: Iterable[Effect]) -> list[str]:
    """Names of the tangents that are given always: no lifted effect has them."""
    taken = {key for effect in lifted for key in effect.rows()}
    return [*(n for n in evidence.base if n not in taken), *evidence.misfits]


def hourly_columns(
    evidence: Evidence,
    hours: Hours,
    coefficients: Mapping[str, float],
    lifted: Iterable[Effect],
) -> dict[str, np.ndarray]:
    """Hourly means of the residual, with what lifted effects explain, and tangents."""
    base = base_of(evidence, lifted)
    faults = {effect.sensor_fault: column for effect, column in evidence.changing}
    own = [key for keys in keys_of(evidence, lifted).values() for key in keys]
    wanted = dict.fromkeys([*base, *own, *faults.values()])
    columns = {name: hours.means(evidence.columns[name]) for name in wanted}
    usual = np.nan_to_num([columns[name] for name in base])
    for name in wanted:
        missing = np.isnan(evidence.columns[name])
        if missing.any():
            known = 1.0 - hours.means(missing.astype(float))
            columns[name] = filled(columns[name], known, usual, hours.count)
    residual = evidence.residual
    for effect in lifted:
        for name, column in tangents_of(effect, evidence):
            size = coefficients[name] - effect.start.get(name, 0.0)
            residual = residual + size * np.nan_to_num(column)
    return {"residual": hours.means(residual), **columns}


def tangents_of(effect: Effect, evidence: Evidence) -> Iterator[tuple[str, np.ndarray]]:
    """Tangents of a lifted effect by name, that of a change with its time profile."""
    column = evidence.column_of_fault(effect.sensor_fault)
    if column is not None:
        (name,) = effect.rows()
        weights = weights_of(effect, evidence.dates)
        yield name, weights * evidence.columns[column]
    else:
        for name in effect.rows():
            if name in evidence.columns:
                yield name, evidence.columns[name]


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
