"""Store a fit in a file, and read it."""

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from pvlib_fem._converter import AnyFloat
from pvlib_fem._modelchain import CELL
from pvlib_fem._record.file_summary import Summary
from pvlib_fem._stored import Stored
from pvlib_fem._thermal.model_files import content_of, model_of
from pvlib_fem.effects import EffectLike

if TYPE_CHECKING:
    from pvlib_fem._fitting.fem_fit import FemFit


def fit_content(fit: "FemFit", cell: dict[str, float]) -> dict[str, Any]:
    """
    Content of a file of a fit.

    Parameters
    ----------
    fit : FemFit
        The fit, with its summary.
    cell : dict
        ``deltaT`` [K] or ``k_bs_c`` [K m²/W]; if it is empty, that of the fit.

    Returns
    -------
    dict
        What :func:`fit_parts` reads, without the rows and their daily sums.

    Raises
    ------
    TypeError
        If ``cell`` has another name.
    """
    if unknown := [name for name in cell if name not in CELL]:
        raise TypeError(f"to_json keeps {' and '.join(CELL)}, no {unknown[0]}")
    return {
        **content_of(fit.thermal_model, fit.coefficients),
        "cell": cell or fit.cell,
        "method": fit.method,
        "stderr": fit.stderr,
        "correlation": fit.correlation.to_dict(orient="index"),
        "scores": fit.scores.to_dict(orient="index"),
        "at_bound": fit.at_bound,
        "converged": fit.converged,
        "notes": fit.notes,
        "train_days": fit.train_days,
        "test_days": fit.test_days,
        "night": fit.night,
        "record": fit.summary,
    }


def fit_parts(
    content: Stored, own: EffectLike | Iterable[EffectLike]
) -> tuple[dict[str, Any], dict[str, Any]]:
    """
    Attributes of a fit in a part of a file, and those that are computed from rows.

    Parameters
    ----------
    content : Stored
        The part that holds the fit.
    own : Effect or sequence of these
        The user's own effects, of which the file has only name and settings.

    Returns
    -------
    attributes : dict
        Arguments of :class:`FemFit`, without ``residual``, ``holdout`` and ``record``.
    computed : dict
        ``summary`` and ``correlation``, which a fit with rows computes on access.

    Raises
    ------
    ValueError
        If an entry is missing or invalid; the message names the key.
    """
    model, coefficients = model_of(content, own)
    scores = content.read("scores", dict[str, dict[str, AnyFloat]])
    stderr = content.read("stderr", dict[str, AnyFloat])
    attributes = dict(
        model=model.steady_model.name,
        dynamics=model.dynamics,
        method=content.read("method", str),
        effects=model.effects,
        coefficients=coefficients,
        stderr=stderr,
        scores=pd.DataFrame.from_dict(scores, orient="index"),
        at_bound=content.read("at_bound", tuple[str, ...]),
        converged=content.read("converged", bool),
        notes=content.read("notes", tuple[str, ...]),
        train_days=content.read("train_days", int),
        test_days=content.read("test_days", int),
        night=content.read("night", bool),
        base=model.base,
        fixed=dict(model.held),
        cell=content.read("cell", dict[str, float]),
    )
    summary, table = content.read("record", Summary), correlation_of(content, stderr)
    return attributes, {"summary": summary, "correlation": table}


def correlation_of(content: Stored, stderr: dict) -> pd.DataFrame:
    """The correlations of a part of a file; ValueError if they are not valid."""
    by_name = content.read("correlation", dict[str, dict[str, float]])
    known = {name for name, error in stderr.items() if error > 0.0}
    place = f"{content.file}: {content.place}correlation"
    if {*by_name} - known or any({*row} != {*by_name} for row in by_name.values()):
        raise ValueError(
            f"{place} is of {', '.join(by_name)}, where a table of coefficients with "
            f"an error belongs: {', '.join(sorted(known)) or 'there are none'}"
        )
    table = pd.DataFrame.from_dict(by_name, orient="index", dtype=float)[[*by_name]]
    values = table.to_numpy()
    ones = np.diag(values) == 1.0 if by_name else True
    within = np.abs(values) <= 1.0 + 1e-9
    if not (np.all(ones) and within.all() and (values == values.T).all()):
        raise ValueError(
            f"{place} holds no correlations: from -1 to 1, the same both ways, and 1 "
            "of each with itself"
        )
    return table
