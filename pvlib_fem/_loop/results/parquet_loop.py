"""A record in files as the loop takes it: means to search, its own steps to confirm."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Self, cast

import numpy as np
import pandas as pd
from pvlib.pvsystem import SingleAxisTrackerMount

from pvlib_fem._findings import Check, Finding
from pvlib_fem._fitting.parquet_fit import FileFit, fit_in_files
from pvlib_fem._fitting.parquet_rows import first_pass
from pvlib_fem._loop.criteria import Criteria
from pvlib_fem._loop.preparation.divided_record import STEP_PRESENT, Case
from pvlib_fem._loop.results.conclude import check_of_bounds
from pvlib_fem._record.checks import dates_of
from pvlib_fem._record.column_names import COLUMNS, GEOMETRY, ROTATION, STATED
from pvlib_fem._record.inputs import Inputs
from pvlib_fem._record.join_steps import JoinedColumns
from pvlib_fem._record.parquet import ParquetRecord
from pvlib_fem._record.resampling import Sums
from pvlib_fem._thermal.model import ThermalModel
from pvlib_fem.drivers._mounts import by_night
from pvlib_fem.drivers._planes import ANGLES, ByColumns, angles_of_rotation
from pvlib_fem.quality._detached_sensor import Detachment
from pvlib_fem.quality._parquet_screen import Screened, screened_blocks
from pvlib_fem.quality._tracker_standstill import Standing
from pvlib_fem.reasons import Because, Reason, because

if TYPE_CHECKING:
    from pvlib_fem._loop.regression.refits import Step
    from pvlib_fem._loop.results.loop_result import Loop

SURE = 3.0  # standard errors of a coefficient from nothing, on the own steps
KEEPS = 0.5  # share of its gain on means that a finding keeps on the own steps


def in_means(
    source: ParquetRecord, criteria: Criteria
) -> tuple[pd.DataFrame, Screened]:
    """
    Means over the steps of the search, as a frame, and the record as it was screened.

    A record whose own steps are nearly as long comes as it is.

    Parameters
    ----------
    source : ParquetRecord
    criteria : Criteria

    Returns
    -------
    DataFrame, Screened
    """
    others = [name for name in source.columns if name not in COLUMNS]
    source.needing(COLUMNS)
    screened = screened_blocks(
        source, others, criteria.limits, check_units=False, needed=COLUMNS
    )
    step, usual = criteria.search_step, screened.look.step
    if not usual <= step / 2.0:
        blocks = list(screened.record.blocks())
        parts = [block.inputs.frame() for block in blocks]
        return stating(pd.concat(parts), source), screened
    sums = Sums(step, STEP_PRESENT * step / usual)
    for block in screened.record.blocks():
        sums.add(block.index, block.inputs.columns)
    means = sums.inputs()
    return stating(means.frame(), source), screened


def stating(frame: pd.DataFrame, source: ParquetRecord) -> pd.DataFrame:
    """The columns of files that there are, with those whose unit is stated."""
    frame = frame.drop(columns=[*source.absent])
    frame.attrs[STATED] = [*source.stated]
    return frame


@dataclass(eq=False)
class OwnSteps:
    """The own steps of a record in files, which confirm what its means show."""

    screened: Screened
    fit: FileFit | None = None  # of the last model
    why: str = ""  # there is none

    def against(
        self,
        case: Case,
        step: "Step",
        inputs: Inputs,
        corrected: bool,
        falls: Iterable[tuple[Finding, float]],
    ) -> tuple[Finding, Check, Because] | None:
        """
        The first of some findings that a fit to the own steps contradicts, or None.

        The case, the last step and ``inputs``, which have all drivers of its model, are
        of the means. ``falls`` has each finding that is in that model, and by how much
        the mean square of the means fell by it. [K²]
        """
        self.fit, self.why = None, why_impossible(step.model, corrected)
        if self.why or self.screened.look.step == case.whole.inputs.step:
            return None
        self.fit = self.fitted(case, step.model, inputs)
        for finding, fall in falls:
            for check, why in own_checks(finding, fall, self.fit):
                if not check.passed:
                    return finding, check, why
        return None

    def fitted(self, case: Case, model: ThermalModel, inputs: Inputs) -> FileFit:
        """The model fitted to the own steps of the fitting weeks."""
        target = ThermalModel(
            model.steady_model, model.dynamics, model.effects, held=model.held
        )
        screened = self.screened
        names = [*COLUMNS, *target.drivers]
        own = screened.record.names
        turning = Turning(case.place["mount"], case.standings)
        missing = [n for n in names if n not in own and n not in turning.columns]
        if turning.described:
            names.append(ROTATION)
        record = replace(screened.record, names=tuple(n for n in names if n in own))
        if missing:  # the sun, whose place is known at the times of the means
            record = record.with_columns(JoinedColumns.from_inputs(inputs, missing))
        if {*turning.columns} & {*names}:
            record = record.with_columns(turning)
        out = np.unique(case.whole.dates[case.held_out])
        if case.detachments:
            record = record.with_columns(Attached(case.detachments, out))
        files = first_pass(replace(screened, record=record), target, night=True)
        return fit_in_files(files.without(out), target, list(screened.notes))

    def confirmed(self, loop: "Loop") -> "Loop":
        """The loop with the fit to the own steps, and a note on it."""
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


@dataclass(frozen=True, eq=False)
class Attached:
    """Module temperature at the own steps of files, where its sensor is on."""

    detachments: tuple[Detachment, ...]
    test: np.ndarray  # days of the test weeks

    def begun(self) -> Self:
        """What follows the blocks of a record from the first on."""
        return self

    def at(self, inputs: Inputs) -> dict[str, np.ndarray]:
        """Module temperatures at the times of inputs, NaN where the sensor is off."""
        index = cast(pd.DatetimeIndex, inputs.index)
        values = np.array(inputs["temp_module"])
        for one in self.detachments:
            off = one.rows_of(index)
            if not one.fitting:
                off &= np.isin(dates_of(index), self.test)
            values[off] = np.nan
        return {"temp_module": values}


@dataclass(frozen=True)
class Turning:
    """Angles of a plane that moves, at the own steps of files."""

    mount: Any  # of pvlib, or ByColumns; None of a fixed plane
    standings: tuple[Standing, ...] = ()  # days on which it is stuck

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of the angles that it has."""
        return getattr(self.mount, "columns", ANGLES if self.mount else ())

    @property
    def described(self) -> SingleAxisTrackerMount | None:
        """The tracker whose rotations were recorded, or None."""
        return getattr(self.mount, "described", None)

    def begun(self) -> Self:
        """What follows the blocks of a record from the first on."""
        return self

    def at(self, inputs: Inputs) -> dict[str, np.ndarray]:
        """The angles at the times of inputs that have the sun, level by night."""
        zenith, azimuth = (inputs[name] for name in GEOMETRY[:2])
        if self.described:
            angles = angles_of_rotation(inputs[ROTATION], self.described)
        elif isinstance(self.mount, ByColumns):
            angles = inputs.columns
        else:
            angles = self.mount.get_orientation(zenith, azimuth)
        angles = by_night({name: angles[name] for name in self.columns}, zenith)
        for one in self.standings:
            one.put_into(angles, cast(pd.DatetimeIndex, inputs.index))
        return angles


def why_impossible(model: ThermalModel, corrected: bool) -> str:
    """Why a model of means cannot be fitted to the own steps; "" if it can."""
    if corrected:
        return "its own steps are not fitted, since a clock was corrected"
    if long := [e.name for e in model.effects if "elapsed" in e.drivers]:
        return (
            f"its own steps are not fitted, since {', '.join(long)} looks at the hours "
            "around each"
        )
    return ""


def own_checks(
    finding: Finding, fall_on_means: float, fit: FileFit
) -> Iterator[tuple[Check, Because]]:
    """
    Checks of a finding by a fit to the own steps, each with why it fails.

    The finding reduces the mean square of the means by ``fall_on_means``. [K²]
    """
    yield check_of_bounds(finding.coefficients, fit)
    # without an error, or held, there is no doubt
    sizes = {
        name: abs(fit.coefficients[name]) / error if error > 0 else np.inf
        for name in finding.coefficients
        for error in [fit.stderr[name]]
    }
    name = max(sizes, key=sizes.__getitem__)
    value, error = fit.coefficients[name], fit.stderr[name]
    yield (
        Check("distance from nothing", "", sizes[name], SURE, unit="standard errors"),
        because(Reason.UNSURE, coefficient=name, value=value, error=error),
    )
    stages = list(fit.scores.index)
    at = stages.index(f"+ {finding.effect}")
    before, after = stages[at - 1], stages[at]
    # an effect on the means alone is none of the module
    squares, words = fit.scores["rmse_train"] ** 2, "share kept on the own steps"
    fall = float(squares[before] - squares[after])
    keeps = fall / fall_on_means if fall_on_means > 0.0 else 1.0
    yield (
        Check(words, "", keeps, KEEPS),
        because(
            Reason.LESS_ON_OWN_STEPS,
            gain=root(fall),
            means=root(fall_on_means),
        ),
    )


def root(fall: float) -> float:
    """Root of a fall of the mean square; negative for a rise, rounded to 1 µK. [K]"""
    return round(float(np.sign(fall) * np.sqrt(abs(fall))), 6)
