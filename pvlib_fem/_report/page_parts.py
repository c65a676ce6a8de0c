"""Parts of pages that a fit and a loop have alike."""

import hashlib
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from pvlib_fem._findings import Correction
from pvlib_fem._record.file_summary import present
from pvlib_fem._report.document import (
    Block,
    Heading,
    Listing,
    Paragraph,
    Table,
    Verbatim,
    table,
)
from pvlib_fem._report.formatting import (
    constants_of,
    range_text,
    two_decimals,
    two_digits,
    value_and_error,
)
from pvlib_fem._report.treatment import Treatment
from pvlib_fem.scores import energy_error

if TYPE_CHECKING:
    from pvlib_fem._fitting.fem_fit import FemFit

DONE = "What was done to the data"
NO_ROWS = Paragraph("A result that was read from a file has no rows to draw or add up.")


def heading(
    words: str,
    title: str = "",
    corrections: Iterable[Correction] = (),
    site: str = "",
    tag: str = "h1",
) -> list[Block]:
    """
    The name of the plant, its site, a clock that is off, and the main result.

    Parameters
    ----------
    words : str
        The main result.
    title, site : str, optional
        Name of the plant, and a line on its site.
    corrections : iterable of Correction, optional
    tag : str, default "h1"

    Returns
    -------
    list of Block
    """
    body = [Paragraph(one, "plant") for one in (title, site) if one]
    for one in corrections:
        body.append(Paragraph(clock_words(one), "" if one.applied else "alert"))
    return [*body, Heading(words, tag)]


def clock_words(correction: Correction) -> str:
    """A clock that is off, as a sentence."""
    words = f"{correction.why}{'; corrected before any fit' * correction.applied}."
    return words[:1].upper() + words[1:]


def coefficients(
    fit: "FemFit",
    corrections: Iterable[Correction] = (),
    ranges: Mapping[str, tuple[float, float]] | None = None,
) -> Table:
    """
    Values, errors and ranges of a fit, and what clocks are out by.

    Parameters
    ----------
    fit : FemFit
    corrections : iterable of Correction, optional
    ranges : dict of (float, float), optional
        90 % range by coefficient; without any the table has no column for them.

    Returns
    -------
    Table
    """
    rows, ranges = [], ranges or {}
    for name, row in fit.thermal_model.parameters.items():
        share = f" of {row.share_of}" if row.share_of else ""
        bound = "at its bound" if name in fit.at_bound else ""
        value, error = value_and_error(fit, name)
        span = f"{row.lower:g} … {row.upper:g}{share}"
        other = range_text(*ranges[name]) if name in ranges else ""
        rows.append((name, value, error, row.unit, other, span, bound))
    for name, value, source in constants_of(fit):
        unit = fit.thermal_model.steady_model.constants[name].unit
        rows.append((name, value, source, unit, "", "", ""))
    for one in corrections:  # a clock has numbers and no place in the model
        for name, value in one.values.items():
            error = two_digits(one.stderr.get(name, np.nan))
            unit = "s/day" if name == "drift" else "min"
            what = "corrected" if one.applied else "not corrected"
            rows.append((f"clock: {name}", f"{value:.4g}", error, unit, "", "", what))
    head = ["coefficient", "#value", "#± error", "unit", "range", "possible", ""]
    words = (
        "Standard errors from leaving out each fitted day in turn, with errors that "
        "last from day to day."
    )
    if ranges:
        words += (
            " A range of 90 % adds the error of the effect's law, and the difference "
            "of two estimates."
        )
    else:
        del head[4]
        rows = [(*row[:4], *row[5:]) for row in rows]
    return table(head, rows, words)


def in_energy(
    fit: "FemFit", residuals: Mapping[str, pd.Series | None], gamma: float
) -> Table | Paragraph:
    """
    What the errors in K are worth in yield, on the days that were held out.

    Parameters
    ----------
    fit : FemFit
    residuals : dict of Series
        Measured minus modelled temperature on the rows of the fit, by the name of the
        model. [K]
    gamma : float
        Temperature coefficient of power. [1/K]

    Returns
    -------
    Table or Paragraph
        A row for each residual; a sentence where the fit has no rows.
    """
    if fit.record is None:
        return NO_ROWS
    index = fit.record.index
    poa = pd.Series(fit.record["poa_global"], index)
    rows, which = present(fit.holdout), "test"
    if not fit.test_days:
        rows, which = ~rows, "fitted"
    lines, sun = [], 0.0
    for name, residual in residuals.items():
        seen = present(residual).where(rows)
        error = energy_error(poa, seen, 0.0 * seen, gamma)
        sun = error.insolation
        parts = (error.total, error.over_estimate, error.under_estimate, error.net)
        share = 100.0 * error.total / sun if sun else np.nan
        lines.append((name, two_decimals(share), *map(two_decimals, parts)))
    head = (
        "model",
        "#% of yield",
        "#absolute [kWh/kWp]",
        "#too much [kWh/kWp]",
        "#too little [kWh/kWp]",
        "#net [kWh/kWp]",
    )
    return table(
        head,
        lines,
        f"Error of the modelled DC energy that results from the temperature, at a "
        f"temperature coefficient of {100 * gamma:g} %/K, on the {which} days with "
        f"{sun:,.0f} kWh/m² in the plane of the modules. Too much: modelled too cold. "
        "The first column is the absolute error as a share of the yield at 25 °C.",
    )


def done_to_data(rows: Sequence[Treatment], notes: Sequence[str]) -> list[Block]:
    """
    What was done to the data, with the number of rows, and notes on them.

    Parameters
    ----------
    rows : sequence of (str, str, int or None, str)
        Step, column, number of rows and what was done, see :func:`.treatment`.
    notes : sequence of str

    Returns
    -------
    list of Block
    """
    body: list[Block] = [Paragraph("Nothing: no value is missing or impossible.")]
    if rows:
        cells = (
            (step, column, "–" if count is None else f"{count:,}", words)
            for step, column, count, words in rows
        )
        body = [table(("step", "column", "#rows", "what was done"), cells, wraps=True)]
    return [*body, Listing([], list(notes))] if notes else body


def made_by(fit: "FemFit", call: str) -> list[Block]:
    """
    Version, call, and hashes that say whether the data are the same.

    Parameters
    ----------
    fit : FemFit
        Fit with the hash of its data.
    call : str
        Python code of the call that made it.

    Returns
    -------
    list of Block
    """
    from pvlib_fem import __version__  # the package is complete by now

    columns = ", ".join(fit.summary.measured)
    words = (
        f"The first hash is of the times (UTC, ns) and of {columns} as they were used, "
        "after the checks"
    )
    hashes = [f"sha256 of the data    {fit.summary.sha256}"]
    if fit.holdout is not None:
        test = hashlib.sha256(np.packbits(fit.holdout.to_numpy()).tobytes())
        hashes.append(f"sha256 of test rows   {test.hexdigest()}")
        words += "; the second of np.packbits(fit.holdout)"
    text = "\n".join((f"pvlib_fem {__version__}", "", call, "", *hashes))
    return [Verbatim(text), Paragraph(f"{words}.", "soft")]


def printed_report(result: object) -> Verbatim:
    """
    The printed report, behind a line.

    Parameters
    ----------
    result : object
        Result whose text is the report, or the report itself.

    Returns
    -------
    Verbatim
    """
    return Verbatim(str(result), "The printed report")
