"""A record in files as the loop takes it: means to search, its own steps to confirm."""

from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from pvlib_fem._findings import Check
from pvlib_fem._fitting.parquet_fit import FileFit, fitted, given_days
from pvlib_fem._fitting.parquet_rows import first_pass
from pvlib_fem._loop.divided_record import STEP_PRESENT
from pvlib_fem._loop.refit_checks import bounds, sureness
from pvlib_fem._loop.weeks import Part
from pvlib_fem._record.checks import dates_of
from pvlib_fem._record.column_names import COLUMNS, GEOMETRY, ROTATION
from pvlib_fem._record.join_steps import JoinedColumns
from pvlib_fem._record.resampling import Sums
from pvlib_fem._statistics.clusters import root
from pvlib_fem._thermal.model import ThermalModel
from pvlib_fem.drivers._mounts import by_night
from pvlib_fem.drivers._planes import ANGLES, ByColumns, rotated
from pvlib_fem.quality._parquet_screen import Screened, screened_blocks
from pvlib_fem.reasons import Reason, because

KEEPS = 0.5  # share of its gain on means that a finding keeps on the own steps


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
        parts = [block.inputs.frame() for block in blocks]
        return pd.concat(parts).drop(columns=[*source.absent]), screened
    sums = Sums(step, STEP_PRESENT * step / usual)
    for block in screened.record.blocks():
        sums.add(block.index, block.inputs.columns)
    means = sums.inputs()
    return means.frame().drop(columns=[*source.absent]), screened


def on_days(holdout, index):
    """Rows of a user's choice of days."""
    dates = given_days(holdout)
    return pd.Series(np.isin(dates_of(index), dates), index)


@dataclass(eq=False)
class OwnSteps:
    """The own steps of a record in files, which confirm what its means show."""

    screened: Screened
    fit: FileFit | None = None  # of the last model
    why: str = ""  # there is none

    def against(self, case, step, inputs, corrected, falls):
        """
        The first of some findings that a fit to the own steps speaks against, or None.

        Parameters
        ----------
        case : Case
            Of the means.
        step : Step
            The last one of the means.
        inputs : Inputs
            The means with all drivers of its model.
        corrected : bool
            Whether a clock was.
        falls : sequence of tuple
            Each finding that is in its model, and by how much the mean square of the
            means fell by it. [K²]

        Returns
        -------
        tuple of Finding, Check, Because, or None
        """
        self.fit, self.why = None, impossible(step.model, corrected)
        if self.why or self.screened.look.step == case.whole.inputs.step:
            return None
        self.fit = self.fitted(case, step.model, inputs)
        for finding, fall in falls:
            for check, why in own_checks(finding, fall, self.fit):
                if not check.passed:
                    return finding, check, why
        return None

    def fitted(self, case, model, inputs):
        """The model fitted to the own steps of the fitting weeks."""
        target = ThermalModel(
            model.steady_model, model.dynamics, model.effects, held=model.held
        )
        screened = self.screened
        names = (*COLUMNS, *target.drivers)
        own = screened.record.names
        turning = Turning(case.place["mount"], case.standings)
        lacks = [n for n in names if n not in own and n not in turning.columns]
        names = (*names, ROTATION) if turning.described else names
        record = replace(screened.record, names=tuple(n for n in names if n in own))
        if lacks:  # the sun, whose place is known at the times of the means
            record = record.with_columns(JoinedColumns.of(inputs, lacks))
        if {*turning.columns} & {*names}:
            record = record.with_columns(turning)
        own = first_pass(replace(screened, record=record), target, night=True)
        out = np.unique(case.whole.dates[case.parts != Part.FITTING])
        return fitted(own.without(out), target, list(screened.notes))

    def told(self, loop):
        """The loop with the fit to the own steps, and told of it."""
        record, step = self.screened.record, self.screened.look.step
        if step == loop.fit.step:
            return replace(loop, notes=(*self.screened.notes, *loop.notes))
        many = f"{self.screened.look.rows:,} rows in {len(record.source.files)} files"
        line = f"the loop is of means over {loop.fit.step:g} s of {many}; {self.why}"
        if self.fit is not None:
            scores = self.fit.scores["rmse_test"]
            line += (
                "loop.own_steps is its model fitted to their steps of "
                f"{step:g} s, which confirm it: {scores.iloc[-1]:.3g} K on the weeks "
                f"that are not fitted, {scores.loc['fem']:.3g} K without effects"
            )
        notes = (*self.screened.notes, line, *loop.notes)
        return replace(loop, notes=notes, own_steps=self.fit)


@dataclass(frozen=True)
class Turning:
    """Angles of a plane that moves, at the own steps of files."""

    mount: object  # None of a fixed plane
    standings: tuple = ()  # days on which it is stuck

    @property
    def columns(self):
        """Names of the angles that it has."""
        return getattr(self.mount, "columns", ANGLES if self.mount else ())

    @property
    def described(self):
        """The tracker whose rotations were recorded, or None."""
        return getattr(self.mount, "described", None)

    def begun(self):
        """What follows the blocks of a record from the first on."""
        return self

    def at(self, inputs):
        """The angles at the times of inputs that have the sun, level by night."""
        zenith, azimuth = (inputs[name] for name in GEOMETRY[:2])
        if self.described:
            found = rotated(inputs[ROTATION], self.described)
        elif isinstance(self.mount, ByColumns):
            found = inputs
        else:
            found = self.mount.get_orientation(zenith, azimuth)
        angles = by_night({name: found[name] for name in self.columns}, zenith)
        for one in self.standings:
            rows = one.rows(inputs.index)
            for name, values in angles.items():
                values[rows] = getattr(one, name)
        return angles


def impossible(model, corrected):
    """Why a model of means cannot be fitted to the own steps; "" if it can."""
    if corrected:
        return "its own steps are not fitted, since a clock was corrected"
    if long := [e.name for e in model.effects if "elapsed" in e.drivers]:
        return (
            f"its own steps are not fitted, since {', '.join(long)} looks at the hours "
            "around each"
        )
    return ""


def own_checks(finding, worth, fit):
    """Checks of a finding by a fit to the own steps, each with why it fails."""
    yield bounds(finding.coefficients, fit)
    yield sureness(finding, fit.coefficients, fit.stderr)
    stages = list(fit.scores.index)
    after = stages.index(f"+ {finding.effect}")
    before, after = stages[after - 1], stages[after]
    # what means alone follow is none of the module's
    squares, words = fit.scores["rmse_train"] ** 2, "share kept on the own steps"
    fall = float(squares[before] - squares[after])
    keeps = fall / worth if worth > 0.0 else 1.0
    yield (
        Check(words, "", keeps, KEEPS),
        because(Reason.LESS_ON_OWN_STEPS, gain=root(fall), means=root(worth)),
    )
