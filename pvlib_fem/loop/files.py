"""A record in files as the loop takes it: means to search, its own steps to confirm."""

from dataclasses import replace

import numpy as np
import pandas as pd

from pvlib_fem.fitting.files import fitted, given_days
from pvlib_fem.fitting.passes import first_pass
from pvlib_fem.loop.weeks import Part
from pvlib_fem.quality.streamed import screened_blocks
from pvlib_fem.record.alongside import Alongside
from pvlib_fem.record.checks import dates_of
from pvlib_fem.record.columns import COLUMNS
from pvlib_fem.record.resampling import Sums
from pvlib_fem.thermal.model import ThermalModel


def in_means(source, criteria):
    """
    Means over the steps of the search, as a frame, and the record as it was screened.

    A record whose own steps are nearly as long comes as it is.
    """
    others = [name for name in source.columns if name not in COLUMNS]
    source.needing(COLUMNS)
    how = dict(check_units=False, needed=COLUMNS)
    screened = screened_blocks(source, others, criteria.limits, **how)
    step, usual = criteria.search_step, screened.look.step
    if not usual <= step / 2.0:
        blocks = list(screened.record.blocks())
        parts = [pd.DataFrame(block.inputs.columns, block.index) for block in blocks]
        return pd.concat(parts), screened
    sums = Sums(step, criteria.step_present * step / usual)
    for block in screened.record.blocks():
        sums.add(block.index, block.inputs.columns)
    means = sums.inputs()
    return pd.DataFrame(means.columns, means.index), screened


def on_days(holdout, index):
    """Rows of a user's choice of days."""
    dates = given_days(holdout)
    return pd.Series(np.isin(dates_of(index), dates), index)


def on_own_steps(loop, screened):
    """The loop with its last model fitted to the record's own steps, and told of it."""
    files = (
        f"{len(screened.record):,} rows in {len(screened.record.source.files)} files"
    )
    step = screened.look.step
    if step == loop.fit.step:
        return replace(loop, notes=(*screened.notes, *loop.notes))
    told = f"the loop is of means over {loop.fit.step:g} s of {files}"
    if why := unconfirmed(loop, screened):
        return replace(loop, notes=(*screened.notes, f"{told}; {why}", *loop.notes))
    target = loop.fit.thermal_model
    target = ThermalModel(
        target.steady_model, target.dynamics, target.effects, held=target.held
    )
    names = (*COLUMNS, *target.drivers)
    lacks = [name for name in names if name not in screened.record.names]
    names = tuple(name for name in names if name not in lacks)
    record = replace(screened.record, names=names)
    if lacks:  # the sun, whose place is known at the times of the means
        inputs = loop.fit.record.inputs
        record = record.with_columns(Alongside.of(inputs, lacks))
    own = first_pass(replace(screened, record=record), target, night=True)
    kept = (loop.weeks == Part.FITTING.name.lower()).to_numpy()
    dates = np.unique(loop.fit.record.dates[~kept])
    fit = fitted(own.without(dates), target, list(screened.notes))
    before, after = fit.scores["rmse_test"].loc["fem"], fit.scores["rmse_test"].iloc[-1]
    line = (
        f"{told}; loop.own_steps is its model fitted to their steps of {step:g} s: "
        f"{after:.3g} K on the weeks that are not fitted, {before:.3g} K without "
        "effects"
    )
    notes = (*screened.notes, line, *loop.notes)
    return replace(loop, notes=notes, own_steps=fit)


def unconfirmed(loop, screened):
    """Why the last model cannot be fitted to the record's own steps; "" if it can."""
    model = loop.fit.thermal_model
    if any(correction.applied for correction in loop.corrections):
        return "its own steps are not fitted, since a clock was corrected"
    if long := [e.name for e in model.effects if "elapsed" in e.drivers]:
        return (
            f"its own steps are not fitted, since {', '.join(long)} looks at the hours "
            "around each"
        )
    return ""
