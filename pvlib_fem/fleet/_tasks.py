"""Tasks for a system, and the rows of their results in the tables."""

import inspect
import json
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from pvlib_fem import scores
from pvlib_fem._findings import Correction, Finding
from pvlib_fem._fit import fit_fem, fit_frame
from pvlib_fem._fitting.fem_fit import FemFit
from pvlib_fem._loop.close import close_loop
from pvlib_fem._loop.results.loop_result import Loop
from pvlib_fem._modelchain import FIT, LOOP
from pvlib_fem._record.column_names import COLUMNS
from pvlib_fem._record.file_summary import present
from pvlib_fem._recovery.recover import recover_effects
from pvlib_fem._recovery.recovery_result import FORMAT, Recovery
from pvlib_fem._report.formatting import with_error
from pvlib_fem._report.loop_page import coefficient_words
from pvlib_fem._spelling import did_you_mean
from pvlib_fem._statements.make import LEFT_OUT
from pvlib_fem._stored import as_json
from pvlib_fem.quality._detached_sensor import DETACHED, Detachment
from pvlib_fem.reasons import Reason

HOURS_A_YEAR = 8766.0
#: columns of the table of systems from a task, with their types
ROW = {
    "start": str,
    "end": str,
    "rows": int,
    "days": int,
    "step": float,  # s
    "test_days": int,
    "model": str,
    "dynamics": str,
    "rmse_before": float,  # K
    "rmse_after": float,  # K
    "energy_error_before": float,  # points of the performance ratio
    "energy_error_after": float,
    "insolation": float,  # kWh/m² a year
    "effects": str,
    "weighed": str,  # JSON: gain and minimum detectable gain by effect [K]
}
#: columns of the table of coefficients
COEFFICIENT = {"coefficient": str, "value": float, "stderr": float, "unit": str}
#: columns of the table of findings
FINDING = {
    "effect": str,
    "candidates": str,
    "verdict": str,
    "kind": str,
    "added": bool,
    "gain": float,  # K
    "size": str,
    "place": str,
    "first": str,
    "last": str,
    "why": str,
}
JOIN = " | "


@dataclass(frozen=True)
class Task:
    """
    A task: one line in :data:`TASKS`.

    Attributes
    ----------
    function : callable
        The public function, whose options are those of the task.
    run : callable
        ``run(data, location=, surface_tilt=, surface_azimuth=, mount=,
        check_units=, **options)``, to a result with ``to_json``, ``to_html`` and
        ``from_json``.
    row, coefficients, findings : callable
        Functions of the result: to a dict of :data:`ROW`, and to lists of dicts of
        :data:`COEFFICIENT` and :data:`FINDING`. A missing key is empty in the table.
    result : type
        Type of the result, which has ``content``.
    format : str
        Format of its files.
    paged : bool
        Whether a result has a page.
    """

    function: Callable[..., Any]
    run: Callable[..., Any]
    row: Callable[[Any], Mapping]
    coefficients: Callable[[Any], list]
    findings: Callable[[Any], list]
    result: Any
    format: str
    paged: bool = True


def row_of_fit(fit: FemFit) -> dict[str, Any]:
    """Row of a fit: its record, and its error before and after the dynamics."""
    end = "test" if fit.test_days else "train"
    errors = fit.scores[f"rmse_{end}"]
    held, record = present(fit.holdout), present(fit.record)
    rows = held if fit.test_days else ~held
    poa = pd.Series(record["poa_global"], record.index)
    seen = present(fit.residual).where(rows)
    energy = scores.energy_error(poa, seen, 0.0 * seen)
    return {
        **record_facts(fit),
        "rmse_before": errors.get("filter", errors.iloc[0]),
        "rmse_after": errors.iloc[-1],
        "energy_error_after": energy.performance_ratio,
        "effects": ", ".join(effect.name for effect in fit.effects),
    }


def row_of_loop(loop: Loop) -> dict[str, Any]:
    """Row of a loop: its record, and its error before and after the findings."""
    end = "test" if loop.fit.test_days else "train"
    before, after = loop.table.loc[loop.base], loop.table.loc[loop.last]
    return {
        **record_facts(loop.fit),
        "rmse_before": before[f"rmse_{end}"],
        "rmse_after": after[f"rmse_{end}"],
        "energy_error_before": before["energy_error_test"],
        "energy_error_after": after["energy_error_test"],
        "effects": ", ".join(loop.effects),
        "weighed": weighed_of(loop),
    }


def weighed_of(loop: Loop) -> str:
    """JSON of the gain and minimum detectable gain of effects that were not found."""
    known = loop.ranking[["gain", "minimum_detectable"]]
    gains = {name: [*map(float, row)] for name, row in zip(known.index, known.values)}
    for name, why in loop.untestable.items():
        if why.reason is Reason.NO_DATE:  # every date was tested
            gains[name] = [0.0, 0.0]
    return json.dumps(as_json(gains))


def record_facts(fit: FemFit) -> dict[str, Any]:
    """Size and times of the record, the form of the model, and insolation per year."""
    size, record = fit.summary, present(fit.record)
    poa = pd.Series(record["poa_global"], record.index)
    sun = scores.energy_error(poa, 0.0 * poa, 0.0 * poa).insolation
    hours = (size.end - size.start) / pd.Timedelta("1h")
    return {
        "start": size.start.isoformat(),
        "end": size.end.isoformat(),
        "rows": size.rows,
        "days": size.days,
        "step": size.step,
        "test_days": fit.test_days,
        "model": fit.model,
        "dynamics": fit.dynamics,
        "insolation": sun * HOURS_A_YEAR / hours if hours > 0 else np.nan,
    }


def coefficients_of(fit: FemFit) -> list[dict[str, Any]]:
    """Rows of all coefficients with their errors."""
    return [
        {
            "coefficient": name,
            "value": fit.coefficients[name],
            "stderr": fit.stderr.get(name, np.nan),
            "unit": row.unit,
        }
        for name, row in fit.thermal_model.parameters.items()
    ]


CLOCK = "CLOCK"  # kind of a clock fault among findings
SENSOR = "SENSOR"  # kind of a fault of a sensor whose rows are not used


def findings_of(loop: Loop) -> list[dict[str, Any]]:
    """Rows of the findings of a loop; clocks and detached sensors first."""
    effects = {effect.name: effect for effect in loop.fit.effects}
    clocks = [of_clock(correction) for correction in loop.corrections]
    detached = [of_detachment(one) for one in loop.detachments]
    others = [of_finding(finding, effects) for finding in loop.finding_objects]
    return clocks + detached + others


def of_clock(correction: Correction) -> dict[str, Any]:
    """Row of a clock fault."""
    values = correction.values.items()
    sizes = [
        f"{n} {with_error(v, correction.stderr.get(n, np.nan))}" for n, v in values
    ]
    return {
        "effect": correction.fault,
        "candidates": correction.fault,
        "verdict": "corrected" if correction.applied else "not corrected",
        "kind": CLOCK,
        "added": correction.applied,
        "size": ", ".join(sizes),
        "place": ", ".join(correction.columns),
        "why": correction.why,
    }


def of_detachment(one: Detachment) -> dict[str, Any]:
    """Row of a time in which the module's temperature sensor had come off."""
    return {
        "effect": DETACHED,
        "candidates": DETACHED,
        "verdict": LEFT_OUT,
        "kind": SENSOR,
        "added": False,
        "size": f"{one.rows} rows",
        "place": one.when,
        "first": one.after[:10] or None,
        "last": one.start[:10] or None,
        "why": str(one),
    }


def of_finding(finding: Finding, effects: Mapping) -> dict[str, Any]:
    """Row of a finding, with the interval of its date, if it has one."""
    dates = effects[finding.effect].settings if finding.effect in effects else {}
    first, last = dates.get("between") or (None, None)
    return {
        "effect": finding.effect,
        "candidates": JOIN.join(finding.candidates),
        "verdict": str(finding.verdict),
        "kind": finding.kind.name,
        "added": finding.added,
        "gain": finding.gain,
        "size": coefficient_words(finding),
        "place": finding.place,
        "first": first,
        "last": last,
        "why": finding.why,
        "content": as_json(finding),
    }


#: arguments that belong to one system, and not to all
OWN = {"data", "location", "surface_tilt", "surface_azimuth", "mount", "holdout"}
ENGINES = {"processes", "path", "progress"}  # arguments that the fleet itself sets


def check_task(name: str, options: Iterable[str]) -> None:
    """
    Refuse an unknown task, and options that a task does not have.

    Parameters
    ----------
    name : str
        Task: ``"fit"``, ``"loop"`` or ``"recover"``.
    options : iterable of str
        Names of options that are the same for all systems.

    Raises
    ------
    ValueError
        If there is no such task, or an option is of a single system or unknown.
    """
    if name not in TASKS:
        raise ValueError(f"unknown task {name!r}; there are {', '.join(TASKS)}")
    there = inspect.signature(TASKS[name].function).parameters.values()
    named = [p.name for p in there if p.kind is not p.VAR_KEYWORD]
    taken = [one for one in named if one not in {*OWN, *ENGINES, *COLUMNS}]
    for option in options:
        if option in OWN:
            raise ValueError(
                f"{option} belongs to one system: put it into the table, if it is one "
                "of its columns, or do that system by itself"
            )
        if option not in taken:
            raise ValueError(
                f"the task {name} has no option {option}"
                f"{did_you_mean(option, taken)}; it has {', '.join(taken)}"
            )


def recover_one(data: pd.DataFrame, **options: Any) -> Recovery:
    """A recovery in this process, which is one of many workers."""
    return recover_effects(data, processes=1, progress=False, **options)


def row_of_recovery(recovery: Recovery) -> dict[str, Any]:
    """Row of a recovery: the effects of its baseline."""
    added = [finding.effect for finding in recovery.baseline if finding.added]
    return {"effects": ", ".join(added)}


def sizes_of(recovery: Recovery) -> Iterator[dict[str, Any]]:
    """Rows of the size at which half of the injections are found, by effect."""
    half = recovery.half
    for name, size in half["size"].items():
        units = {*recovery.units.get(str(name), {}).values()}
        unit = units.pop() if len(units) == 1 else ""
        row = {"coefficient": f"{name}, half found", "value": size, "unit": unit}
        yield {**row, "stderr": np.nan}


def baseline_of(recovery: Recovery) -> list[dict[str, Any]]:
    """Rows of the findings in the record itself."""
    return [of_finding(finding, {}) for finding in recovery.baseline]


def no_rows(result: object) -> list[dict[str, Any]]:
    """No rows: a fit has no findings."""
    return []


#: every task by its name
TASKS = {
    "fit": Task(fit_fem, fit_frame, row_of_fit, coefficients_of, no_rows, FemFit, FIT),
    "loop": Task(
        close_loop,
        close_loop,
        row_of_loop,
        lambda loop: coefficients_of(loop.fit),
        findings_of,
        Loop,
        LOOP,
    ),
    "recover": Task(
        recover_effects,
        recover_one,
        row_of_recovery,
        lambda recovery: list(sizes_of(recovery)),
        baseline_of,
        Recovery,
        FORMAT,
        paged=False,
    ),
}
