"""Resume a recovery from a file, and add results to it."""

import hashlib
from dataclasses import replace
from pathlib import Path
from typing import Any

import pandas as pd

from pvlib_fem._loop.loop_result import Loop
from pvlib_fem._recovery.judge import Outcome
from pvlib_fem._recovery.recovery_result import Recovery
from pvlib_fem._spelling import written_argument


def resumed(new: Recovery, path: Any) -> Recovery:
    """
    The recovery of a file that an interrupted call wrote.

    Parameters
    ----------
    new : Recovery
        Of this call, before any outcome.
    path : str or path-like
        The file.

    Returns
    -------
    Recovery
        With the outcomes and trials of the file.

    Raises
    ------
    ValueError
        If the file is of another record, version or call.
    """
    there = Recovery.from_json(path)
    for name, words in (("sha256", "record"), ("version", "version of pvlib_fem")):
        if getattr(there, name) != getattr(new, name):
            raise ValueError(
                f"{Path(path)} is of another {words} ({getattr(there, name)[:12]}, "
                f"this is {getattr(new, name)[:12]}); give another path, or remove "
                "the file"
            )
    if other := [n for n, value in new.given.items() if there.given.get(n) != value]:
        name = other[0]
        raise ValueError(
            f"{Path(path)} is of a call with {name}="
            f"{there.given.get(name) or 'the default'}, and this one has "
            f"{new.given[name] or 'the default'}; give another path, or remove the file"
        )
    return there


def of_plan(
    recovery: Recovery, planned: list, notes: dict, loop: Loop, effects: tuple
) -> Recovery:
    """
    The recovery with the outcomes of the present plan.

    Parameters
    ----------
    recovery : Recovery
        Perhaps with outcomes of a file.
    planned : list of Injection
        The plan; other outcomes are dropped.
    notes : dict of str
        Effects that are not injected, and why.
    loop : Loop
        Of the record itself, whose findings are the baseline.
    effects : tuple of Effect
        Effects that the loop tests, for the units of their coefficients.

    Returns
    -------
    Recovery
        A copy.
    """
    keys = {injection.key for injection in planned}
    units = {e.name: {n: r.unit for n, r in e.rows().items()} for e in effects}
    return replace(
        recovery,
        outcomes=tuple(one for one in recovery.outcomes if one.injection.key in keys),
        planned=len(planned),
        baseline=loop.finding_objects,
        units=units,
        notes=notes,
    )


def of_trials(recovery: Any, planned: list, why: Any) -> Any:
    """
    The recovery with the trials of the present plan, and why others cannot be.

    Parameters
    ----------
    recovery : Recovery
        Perhaps with trials of a file.
    planned : list of tuple
        Kind and number of each trial; other trials are dropped.
    why : dict of str
        Kinds of scrambling that the record does not allow, and why.

    Returns
    -------
    Recovery
        A copy.
    """
    trials = tuple(trial for trial in recovery.trials if trial.key in planned)
    count = len(planned)
    return replace(recovery, trials=trials, planned_trials=count, not_scrambled=why)


def with_trial(recovery: Recovery, trial: Any, planned: list) -> Any:
    """
    The recovery with one more trial, in the order of the plan.

    Parameters
    ----------
    recovery : Recovery
        With trials of the plan alone.
    trial : Trial
        The new one.
    planned : list of tuple
        Kind and number of each trial.

    Returns
    -------
    Recovery
        A copy.
    """
    trials = sorted([*recovery.trials, trial], key=lambda one: planned.index(one.key))
    return replace(recovery, trials=tuple(trials))


def with_outcome(recovery: Recovery, outcome: Outcome, planned: list) -> Recovery:
    """
    The recovery with one more outcome, in the order of the plan.

    Parameters
    ----------
    recovery : Recovery
        With outcomes of the plan alone.
    outcome : Outcome
        The new one.
    planned : list of Injection
        The plan.

    Returns
    -------
    Recovery
        A copy.
    """
    order = {injection.key: i for i, injection in enumerate(planned)}
    outcomes = [*recovery.outcomes, outcome]
    outcomes = sorted(outcomes, key=lambda one: order[one.injection.key])
    return replace(recovery, outcomes=tuple(outcomes))


def said_all(
    effects: Any, sizes: Any, draws: int, seed: int, model: str, place: dict, how: dict
) -> dict:
    """
    The arguments that determine the result, as text.

    Parameters
    ----------
    effects, sizes, draws, seed, model
        Arguments of :func:`recover_effects`.
    place : dict
        From :func:`pvlib_fem.drivers.checked_place`.
    how : dict
        Arguments of the loop; ``effects`` among them are called ``tried``.

    Returns
    -------
    dict of str
        By the name of the argument; of ``holdout`` its hash.
    """
    where = None if place["location"] is None else repr(place["location"])
    said = dict(effects=effects, sizes=sizes, draws=draws, seed=seed, model=model)
    # a fixed plane has no mount, here as in files of before
    said |= {n: v for n, v in place.items() if n != "mount"}
    said |= {"mount": repr(place["mount"])} if place["mount"] else {}
    said |= {"location": where}
    said |= {"tried" if name == "effects" else name: v for name, v in how.items()}
    if (holdout := said["holdout"]) is not None:
        said["holdout"] = digest(holdout.to_frame())
    return {name: written_argument(value) for name, value in said.items()}


def digest(data: pd.DataFrame) -> str:
    """
    Sha256 of a frame's times, names and values.

    Parameters
    ----------
    data : pandas.DataFrame, shape (rows, columns)
        A record.

    Returns
    -------
    str
        64 hexadecimal digits.
    """
    checksum = hashlib.sha256(repr([str(name) for name in data]).encode())
    try:
        values = pd.util.hash_pandas_object(data)
    except TypeError:  # of cells such as lists, which have no hash
        values = pd.util.hash_pandas_object(data.map(repr))
    checksum.update(values.to_numpy("<u8").tobytes())
    return checksum.hexdigest()
