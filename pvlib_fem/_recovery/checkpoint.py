"""Resume a recovery from a file, and add results to it."""

import hashlib
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import pandas as pd

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


def in_plan(done: Iterable, planned: Sequence) -> tuple:
    """
    What is done of a plan, in its order.

    Parameters
    ----------
    done : iterable of Outcome or of Trial
        Perhaps with some of another plan, as a file may have; they are dropped.
    planned : sequence
        Key of each injection or trial, in order.

    Returns
    -------
    tuple of Outcome or of Trial
    """
    order = {key: i for i, key in enumerate(planned)}
    kept = (one for one in done if one.key in order)
    return tuple(sorted(kept, key=lambda one: order[one.key]))


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
