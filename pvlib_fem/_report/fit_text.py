"""The printed report of a fit."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from pvlib_fem._report.formatting import (
    constants_of,
    two_decimals,
    value_and_error,
)

if TYPE_CHECKING:
    from pvlib_fem._fitting.fem_fit import FemFit


def lines(fit: "FemFit") -> Iterator[str]:
    """
    Yield the lines of the printed report.

    Parameters
    ----------
    fit : FemFit
        Fit with or without its rows.

    Yields
    ------
    str
    """
    record = fit.summary
    days = f"{fit.train_days} day{'s' * (fit.train_days != 1)}"
    added = "".join(f" + {effect.name}" for effect in fit.effects)
    yield f"pvlib_fem: {fit.model}{added}, {fit.dynamics}, {fit.method}"
    yield (
        f"{record.rows:,} rows, {record.start:%Y-%m-%d} to {record.end:%Y-%m-%d}, "
        f"step {record.step:g} s; {days} fitted, {fit.test_days} held out"
    )
    yield ""
    model = fit.thermal_model
    rows, constants = model.parameters, model.steady_model.constants
    names = *rows, *constants, *fit.scores.index
    wide = max(12, *(len(name) + 1 for name in names))
    yield f"{'coefficient':<{wide}}{'value':>12}{'± error':>12}   unit"
    for name, row in rows.items():
        value, error = value_and_error(fit, name)
        bound = "   at its bound" if name in fit.at_bound else ""
        yield f"{name:<{wide}}{value:>12}{error:>12}   {row.unit}{bound}"
    for name, value, source in constants_of(fit):
        unit = constants[name].unit
        yield f"{name:<{wide}}{value:>12}{source:>12}   {unit}"
    yield ""
    yield f"error after each step, {'day and night' if fit.night else 'daytime'} [K]"
    wide = wide if fit.effects else 10
    yield f"{'':<{wide}}{'fitted days':^24}  {'held-out days':^24}".rstrip()
    yield f"{'step':<{wide}}" + "  ".join(
        "".join(f"{score:>8}" for score in ("RMSE", "MAE", "MBE")) for _ in range(2)
    )
    for name, line in fit.scores.iterrows():
        cells = [f"{two_decimals(value):>8}" for value in line]
        yield f"{name:<{wide}}{''.join(cells[:3])}  {''.join(cells[3:])}"
    yield ""
    for what, counts in (
        ("missing", record.missing),
        ("impossible, not used", record.impossible),
    ):
        if counted := [f"{name} {count:,}" for name, count in counts.items() if count]:
            yield f"{what}: {', '.join(counted)}"
    if record.clipped:
        yield f"negative irradiance, clipped to 0: {record.clipped:,}"
    if not np.isnan(list(fit.stderr.values())).all():
        yield f"errors: clustered by day, from the spread of {days}"
    yield from (f"note: {note}" for note in fit.notes)
