"""The result of a closed loop: finished, and it prints itself."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Self, TypeVar

import numpy as np
import pandas as pd
from threadpoolctl import threadpool_limits

from pvlib_fem._ceiling.ceiling_result import Ceiling
from pvlib_fem._ceiling.trees import ceiling_of, regressor
from pvlib_fem._correction.correct_record import corrected_record
from pvlib_fem._correction.corrected_record import CorrectedRecord
from pvlib_fem._findings import Correction, Finding, Kind
from pvlib_fem._fitting.fem_fit import FemFit
from pvlib_fem._fitting.horizontal import transposed_again
from pvlib_fem._fitting.stand_ins import StandIn
from pvlib_fem._loop.criteria import Criteria
from pvlib_fem._loop.preparation.planes import is_same_plane, with_series
from pvlib_fem._loop.results.corrected_times import Times
from pvlib_fem._loop.results.loop_files import Reading, loop_content, loop_parts
from pvlib_fem._loop.results.predicted_patterns import Pattern, drivers_of, errors_by
from pvlib_fem._modelchain import LOOP, DynamicCellTemperature
from pvlib_fem._record.column_names import (
    COLUMNS,
    GEOMETRY,
    printable,
    refuse_no_frame,
    with_aliases,
)
from pvlib_fem._statements.statement import Statement, as_table
from pvlib_fem._statements.worth import energies
from pvlib_fem._stored import opened, saved, written
from pvlib_fem._thermal.model import ThermalModel
from pvlib_fem.drivers import checked_place, geometry, underived
from pvlib_fem.drivers._mounts import (
    ANGLES,
    PLANE,
    plane_of_rows,
)
from pvlib_fem.effects import EffectLike
from pvlib_fem.effects._effect import Effect
from pvlib_fem.quality._detached_sensor import Detachment
from pvlib_fem.quality._noon import lateness_of
from pvlib_fem.quality._tracker_standstill import Standing
from pvlib_fem.reasons import Because
from pvlib_fem.scores import GAMMA
from pvlib_fem.types import FilePath

#: at the times of data
Result = TypeVar("Result", pd.DataFrame, pd.Series)


@dataclass(frozen=True, eq=False)
class Loop:
    """
    The closed loop: what a record shows beyond the model, and its gain.

    ``print(loop)`` is a summary of at most 25 lines; ``loop.report()`` has all.

    Attributes
    ----------
    finding_objects : tuple of Finding
        In the order found, then hints, then what no effect explains. The DataFrame
        ``findings`` has a row for each.
    corrections : tuple of Correction
        What was made of clocks that are off.
    table : DataFrame
        A row for each step, ``steady``, ``fem`` (the paper's form), ``balance``,
        ``clock corrected`` where it was, then ``+<effect>``, and ``+patterns``, the
        last effect with ``patterns``; errors on fitting and
        test weeks [K], on test days and nights alone, and the error of the test
        weeks' performance ratio that they cause [percentage points].
    base, last : str
        Rows of the table: the better of ``fem`` and ``balance``, and the last step
        with a cause.
    untestable : dict of Because
        Effect to what it would need, or why this record cannot see it.
    ranking : DataFrame
        What each absent effect would still explain, given the model that is
        returned, see :func:`pvlib_fem.rank_effects`.
    fit : FemFit
        Of the last step, to the fitting weeks.
    notes : tuple of str
        The state of the record, and what was done about it.
    place : dict
        ``location``, ``surface_tilt`` and ``surface_azimuth`` as given, or estimated,
        and ``mount``: a tracker, or ``"columns"`` if the record has the angles.
    residual_before : Series or None
        Measured minus modelled temperature before anything was added. None, as
        ``weeks``, in a loop that was read from a file, which holds no rows. [K]
    weeks : Series of category or None
        What each row was for: ``fitting`` or ``test``.
    budget : DataFrame
        Where the mean square of the steady model went, on the test weeks (on the
        fitting weeks where there are none). Of the rows by ``kind``, those ``taken``
        by a step and ``left`` add up to the ``start``; the ``episodes`` below and,
        of all other days, the time ``scale`` rows add up to the remaining error: means
        of weeks, of days about their week's, of hours about their day's and rows about
        their hour's, each less the part of white noise, which is ``from row to row``.
        Rows ``of which`` are parts of the remaining error and may overlap: tables of
        unknown structure, by what each takes off fitting weeks left out in turn.
        ``mean_square`` [K²], its root with sign ``error`` [K], its ``share`` of the
        start, and the ``weeks``.
    episodes : DataFrame
        Days that stand out of those around them, the largest share first: ``start``
        and ``end``, the last of its ``days``; mean residual by ``day`` and by
        ``night`` [K]; ``share`` of the mean square. Of all weeks, the test weeks
        too: they are reported, and decide nothing.
    events : DataFrame
        Hours on which a plant's power is not what irradiance leads one to expect, and
        the module's temperature shows why, the largest energy first: the ``effect``
        (``outage``, ``modules_covered``, ``sensor_covered``, or ``underperformance``
        where the module is not covered), ``start``, ``end``,
        ``hours`` of light, ``size``, the mean residual without these effects [K],
        ``share`` of its square in the record, hours of frozen modules included,
        ``power`` over that expected, the ``energy`` by which power differs from it, per
        power at 1000 W/m² and 25 °C [kWh/kWp], ``gain``, the reduction of the fit's
        error without the mean residual [K], and means of ``temp_air`` [°C],
        ``wind_speed`` [m/s] and ``snow_depth`` [cm], where there is one. Of all weeks:
        they are reported, and decide nothing.
    plain : tuple of ThermalModel and dict
        The model without effects, and its coefficients.
    criteria : Criteria
        By which it decided.
    weighed : bool
        Whether there were enough fitting days to leave some out in turn.
    given : dict
        Other arguments of the call, as they are written.
    own_steps : FemFit or None
        Of a loop of files, which is of means: its last model fitted to the record's own
        steps, with the weeks that are not fitted held out. None where it could not be,
        as the notes say, and in a loop that was read from a file.
    times : Times or None
        Corrections of the record's clocks, which ``predict``, ``contributions`` and
        ``residual`` apply.
    transposition : str
        Model of the sky by which ``poa_global`` was made of ``ghi``, and is made where
        ``predict`` and the others are given data without it; "" where it was measured.
    stand_ins : tuple of StandIn
        Second sources of air or wind that replace missing values of the first, here as
        in the data of ``predict`` and the others.
    standings : tuple of Standing
        Days on which the irradiance sensor was stuck, while the record describes a
        plane that turns.
    detachments : tuple of Detachment
        Times in which the module's temperature sensor had come off and read the air;
        its rows are not used.
    patterns : tuple of Pattern
        Repeatable errors without a known cause, which ``predict``, ``residual`` and
        ``contributions`` have; ``fit`` and ``temperature_model`` have not. There are
        none in a record of fewer than ``criteria.min_days`` days.
    hint_effects : tuple of Effect
        Effects of the hints with their settings. A loop that was read from a file has
        none.
    label : float
        From the middle of its step to the time of a row: 0.5 steps if each row is a
        mean over the step that ends at its time, -0.5 if it begins there. The sun is
        taken at the middle. [steps]
    """

    finding_objects: tuple[Finding, ...]
    corrections: tuple[Correction, ...]
    table: pd.DataFrame
    base: str
    last: str
    untestable: dict[str, Because]
    ranking: pd.DataFrame = field(repr=False)
    fit: FemFit = field(repr=False)
    notes: tuple[str, ...]
    place: dict[str, Any]
    residual_before: pd.Series | None = field(repr=False)
    weeks: pd.Series | None = field(repr=False)
    budget: pd.DataFrame = field(repr=False)
    episodes: pd.DataFrame = field(repr=False)
    events: pd.DataFrame = field(repr=False)
    plain: tuple[ThermalModel, dict[str, float]] = field(repr=False)
    criteria: Criteria = field(repr=False)
    weighed: bool = True
    given: dict[str, str] = field(repr=False, default_factory=dict)
    own_steps: FemFit | None = field(repr=False, default=None)
    times: Times | None = field(repr=False, default=None)
    transposition: str = ""
    stand_ins: tuple[StandIn, ...] = ()
    reading: Reading = field(repr=False, default_factory=Reading)
    standings: tuple[Standing, ...] = ()
    detachments: tuple[Detachment, ...] = ()
    patterns: tuple[Pattern, ...] = field(repr=False, default=())
    hint_effects: tuple[Effect, ...] = field(repr=False, default=())
    label: float = 0.0

    @cached_property
    def week_rows(self) -> dict[str, int]:
        """Rows of each kind of weeks."""
        # a loop that was read from a file has no weeks, and brings these
        counts = self.weeks.value_counts()  # type: ignore[union-attr]
        return {str(name): int(rows) for name, rows in counts.items()}

    @cached_property
    def own_ceiling(self) -> Ceiling:
        """What :meth:`ceiling` returns; computed once."""
        regressor()  # what is not loaded yet has no threads to limit
        # sums of several threads have other last bits
        with threadpool_limits(limits=1, user_api="openmp"):
            return ceiling_of(self)

    @property
    def known_ceiling(self) -> Ceiling | None:
        """The ceiling, where :meth:`ceiling` has been called; else None."""
        return vars(self).get("own_ceiling")

    def ceiling(self) -> Ceiling:
        r"""
        How much of the error could still be explained by the record's columns.

        Boosted trees (scikit-learn's ``HistGradientBoostingRegressor`` [1]_) describe
        the residual of the model without findings on the fitting weeks, by all columns
        of the record, their past values (three steps before, means of 1, 6 and 24 h
        before), hour, day of the week and season, the place of the sun where the
        location is known, and the date. Their number is that which describes every
        fifth of the fitting weeks best, when trees are grown on the others. They are
        scored on the test weeks once, on the rows of the loop's table. So are trees
        without each group of columns. Nothing is decided by it.

        Returns
        -------
        Ceiling
            It is kept: from then on ``print(loop)``, :meth:`to_html` and
            :meth:`to_json` have it.

        Raises
        ------
        ImportError
            If scikit-learn is missing (``pip install "pvlib_fem[ceiling]"``).
        ValueError
            If the loop was read from a file, or has no test weeks or below 10 fitting
            days.

        Notes
        -----
        With the RMSE of the paper's form :math:`p`, of the loop with its unexplained
        patterns :math:`l` and of the trees :math:`t`, the share of the closable squared
        error that is closed is

        .. math::

            \frac{p^2 - l^2}{p^2 - t^2}

        The trees are no bound: others may reach less. They know no cause. By the date
        they know what lasts from the fitting weeks to the test week between them.
        Second sensors of the module's temperature are none of their columns, nor what
        the loop found to be made from it. Of more than 100 000 fitting rows they have
        every second, third, and so on. The result does not depend on the number of
        threads.

        References
        ----------
        .. [1] F. Pedregosa et al., "Scikit-learn: Machine Learning in Python", J. of
           Machine Learning Research 12, 2825-2830, 2011.
        """
        return self.own_ceiling

    @property
    def findings(self) -> pd.DataFrame:
        """
        The findings as a DataFrame, a row for each of ``finding_objects``.

        Returns
        -------
        DataFrame
            ``effect``, name of the effect, or the drivers of an unexplained pattern;
            ``verdict``, ``"identified"``, ``"ambiguous"``, ``"hint"`` or
            ``"unexplained"``; ``probability`` of the effect [-]
            and ``alternatives``, a tuple of the other candidates; ``value`` with its
            ``standard_error`` and the 90 % range ``low`` to ``high``, all in ``unit``;
            ``from`` and ``to``, the dates between which it acts, NaT where it acts from
            the first or until the last day of the record; ``gain``, the reduction of
            the error [K].

            Of a sensor fault ``value`` is what the sensor reads beyond the truth,
            negative where it reads less. Of another effect it is its coefficient, NaN
            where it has several: ``finding_objects`` have each. Of an unexplained
            pattern it is the mean residual there.
        """
        from pvlib_fem._statements.findings_table import findings_table

        return findings_table(self)

    @property
    def effects(self) -> list[str]:
        """Names of the findings that were added to the model, in order."""
        return [finding.effect for finding in self.finding_objects if finding.added]

    @property
    def ties(self) -> dict[str, tuple[str, ...]]:
        """Name to the other candidates, where there are some."""
        return {
            f.effect: tuple(n for n in f.candidates if n != f.effect)
            for f in self.finding_objects
            if f.kind is not Kind.STRUCTURE and len(f.candidates) > 1
        }

    @property
    def unexplained(self) -> tuple[Finding, ...]:
        """Findings of structure that no effect explains."""
        return tuple(f for f in self.finding_objects if f.kind is Kind.STRUCTURE)

    def inputs(
        self, data: pd.DataFrame, wanted: Iterable[str] | None = None, **place: Any
    ) -> tuple[list[Any], dict[str, pd.Series]]:
        """The usual three columns of ``data``, and those that the effects need."""
        needed, there = self.fit.thermal_model.usual, self.there(data, place)
        columns = self.filled(data, there)
        if lacking := [name for name in needed if name not in columns]:
            with_aliases(data, lacking)  # which refuses them
        wanted = self.fit.thermal_model.drivers if wanted is None else wanted
        columns = {n: c for n, c in columns.items() if n not in ANGLES}
        if {*wanted} & {*GEOMETRY}:
            late = lateness_of(self.label, data.index)
            columns = {**geometry(data.index, **there, late=late), **columns}
        drivers = {name: columns[name] for name in wanted if name in columns}
        usual = [columns[n] if n in needed else None for n in COLUMNS[:3]]
        return usual, drivers

    def there(self, data: pd.DataFrame, place: dict[str, Any]) -> dict[str, Any]:
        """The place of some rows: as it is given, by their columns, or the record's."""
        known, others = self.place, [n for n in data if printable(n) not in place]
        if not {*PLANE} & {*place}:
            return plane_of_rows(data[others], {**known, **place})
        if "mount" in place or known["mount"] is not None:  # which is another plane
            known = {**known, **dict.fromkeys(PLANE)}
        site = checked_place(**{**known, **place})
        return site if "mount" in place else plane_of_rows(data[others], site)

    def timed(
        self, data: pd.DataFrame, correct_times: bool = True
    ) -> tuple[pd.DataFrame, np.ndarray]:
        """Correct the times of ``data``; return rows with a time, and their mask."""
        refuse_no_frame(data)
        if self.times is not None:
            data = data.set_axis(self.times.in_zone(data.index))
        if self.times is None or not correct_times:
            return data, np.ones(len(data), dtype=bool)
        index, known = self.times.corrected(data.index)
        return data[known].set_axis(index[known]), known

    def predict(
        self,
        data: pd.DataFrame,
        fallback: bool = False,
        correct_times: bool = True,
        patterns: bool | None = None,
        **place: Any,
    ) -> pd.Series:
        """
        Module temperature of the last step, with the unexplained patterns.

        Parameters
        ----------
        data : DataFrame
            ``poa_global``, ``temp_air``, ``wind_speed`` and the columns of the
            effects; ``wind_speed`` only where the model depends on it.
        fallback : bool, default False
            Where the column of an effect is missing, take the model without any effect
            instead of NaN. Patterns whose column is missing are left out.
        correct_times : bool, default True
            Apply the clock corrections of this record to times within its period, in
            any zone; times without one are those of its clock. The result has the times
            of ``data``.
        patterns : bool, optional
            Add the errors of ``loop.patterns``, which repeat without a known cause. By
            default they are added, unless another place or plane is given: they are of
            this plant.
        **place
            ``location``, ``surface_tilt`` and ``surface_azimuth``, or ``mount``, where
            they are others than those of this record. Angles that change with time are
            Series or columns of ``data``.

        Returns
        -------
        Series
            [°C]; NaN where a value is missing or a time is unknown.

        Raises
        ------
        ValueError
            If a whole column is missing, and there is no fallback.

        Warns
        -----
        UserWarning
            If the record has no zone and ``data`` have one, so that a clock that was
            corrected is not.
        """
        data, place = with_series(data, place)
        timed, known = self.timed(data, correct_times)
        found = self.by_one_clock(timed, fallback, patterns, place)
        return untimed(found, data.index, known)

    def by_one_clock(
        self,
        data: pd.DataFrame,
        fallback: bool,
        patterns: bool | None,
        place: dict[str, Any],
    ) -> pd.Series:
        """Predict at correct times."""
        usual, drivers = self.inputs(data, **place)
        model, coefficients = self.plain
        plain = None
        if fallback:
            plain = model.predict(*usual, coefficients=coefficients)
        if plain is not None and {*self.fit.thermal_model.drivers} - {*drivers}:
            return plain
        found = self.fit.predict(*usual, **drivers)
        if patterns is None:
            patterns = is_same_plane(data, place, self.place)
        if self.patterns and patterns:
            errors = self.errors_by_pattern(data, fallback, **place)
            found = found + errors.sum(axis=1)
        return found if plain is None else found.fillna(plain)

    def errors_by_pattern(
        self, data: pd.DataFrame, fallback: bool = False, **place: Any
    ) -> pd.DataFrame:
        """Error by each unexplained pattern at the times of ``data``. [K]"""
        wanted = [*COLUMNS[:3], *underived(drivers_of(self.patterns))]
        usual, drivers = self.inputs(data, wanted, **place)
        columns = dict(zip(COLUMNS, usual)) | drivers
        return errors_by(self.patterns, columns, fallback)

    def residual(
        self,
        data: pd.DataFrame,
        correct_times: bool = True,
        patterns: bool | None = None,
        **place: Any,
    ) -> pd.Series:
        """
        Measured minus modelled temperature, with the clocks of the record corrected.

        Parameters
        ----------
        data : DataFrame
            As in :meth:`predict`, and ``temp_module`` [°C].
        correct_times, patterns, **place
            As in :meth:`predict`; the module's clock is corrected in the same rows.

        Returns
        -------
        Series
            [K]
        """
        data, place = with_series(data, place)
        timed, known = self.timed(data, correct_times)
        measured = with_aliases(timed, ["temp_module"])["temp_module"]
        if self.times is not None and correct_times:
            rows = self.times.inside(self.times.in_zone(data.index))[known]
            measured = measured.where(
                ~rows, self.times.of_module(timed.index, measured)
            )
        found = measured - self.by_one_clock(timed, False, patterns, place)
        return untimed(found, data.index, known)

    def contributions(
        self, data: pd.DataFrame, correct_times: bool = True
    ) -> pd.DataFrame:
        """
        What each effect and each unexplained pattern adds to the temperature.

        Of an effect it is the difference to the model without it, with all others.

        Parameters
        ----------
        data : DataFrame
            As in :meth:`predict`.
        correct_times : bool, default True
            As in :meth:`predict`.

        Returns
        -------
        DataFrame
            A column for each effect, then for each of ``loop.patterns`` unless ``data``
            have angles of another plane. [K]
        """
        timed, known = self.timed(data, correct_times)
        usual, drivers = self.inputs(timed)
        fit, model = self.fit, self.fit.thermal_model
        whole = model.predict(*usual, coefficients=fit.coefficients, **drivers)
        parts = {}
        for effect in fit.effects:
            without = {**fit.coefficients, **effect.start}
            part = model.predict(*usual, coefficients=without, **drivers)
            parts[effect.name] = whole - part
        if is_same_plane(data, {}, self.place):
            parts |= dict(self.errors_by_pattern(timed).items())
        return untimed(pd.DataFrame(parts, index=timed.index), data.index, known)

    def corrected(
        self, data: pd.DataFrame, resolve: str | Iterable[str] | Mapping[str, str] = ()
    ) -> CorrectedRecord:
        r"""
        Take the faults of instruments that the loop found out of a record.

        Corrected are the clocks of the file and of the module's logger, the module's
        temperature while its sensor is off, which is left out, the unit of humidity
        and wind direction, and of the named findings those that are faults of an
        instrument: the gain of the irradiance sensor (``irradiance_sensor``, and
        ``soiling`` where the sensor soils), the anemometer (``anemometer``,
        ``anemometer_stall``), the air's thermometer (``air_offset``,
        ``air_sensor_shield``, ``air_shield``) and the module's (``module_offset``,
        ``module_sensor_contact``). What happens to the module itself, such as
        ``mounting`` or ``module_irradiance``, and another ``time_constant`` change no
        column.

        Parameters
        ----------
        data : DataFrame
            The record that the loop was closed on, or a part of it, with the names and
            units that the loop took.
        resolve : str, sequence of str, or dict of str, optional
            For ambiguous findings the candidate that is the cause, such as
            ``["irradiance_sensor_step"]``. Without it they change no column. If two
            findings have the same candidates, a dict has the cause of each by the name
            of the finding: ``{"module_offset_step": "air_offset_step"}``.

        Returns
        -------
        CorrectedRecord
            ``data`` with each corrected column and its original, and ``actions``.

        Raises
        ------
        ValueError
            If no row is within the period of the record, data are corrected already,
            a time comes twice, or ``resolve`` has no candidate of a finding.

        Notes
        -----
        The equation of the model, solved for the reading of a sound instrument: with
        the terms ``heat``, ``loss``, ``offset`` and ``gain`` of the fault and the
        ``bias`` of the fit,

        .. math::

            G &= \mathrm{poa\_global} + \mathrm{heat} \\
            w &= \mathrm{wind\_speed} + \mathrm{loss} / u_1 \\
            T_m &= T_a + \mathrm{bias} + (\mathrm{temp\_module}
            - \mathrm{offset} - T_a - \mathrm{bias}) / (1 + \mathrm{gain})

        The gain of the irradiance sensor is *effective*: it makes the irradiance that
        the module's temperature shows, so that a module that itself absorbs more or
        gives less power is in it. A step or an episode is relative to before, a trend
        to its ``start`` in ``actions``, the first day of the record that could be
        fitted. What an instrument had wrong from the first day on is in the
        coefficients of the model, and in no correction.

        Sizes are of the fitting weeks, and test weeks are corrected by the same. Rows
        outside the record stay as they were and are flagged. A missing value stays
        missing. A row gets NaN where a value that its correction needs is missing.
        Values that :func:`pvlib_fem.screen_record` finds stay as they are.
        """
        found = corrected_record(self, self.whole(data), resolve)
        # what stood in and was not corrected is as it came
        made = {one.usual for one in self.stand_ins}
        made |= {"poa_global"} if self.transposition else set()
        applied = {*found.actions["column"][found.actions["applied"]]}
        _, known = self.timed(data)  # rows without a sure time are dropped
        for name in made & {*found.data} - applied:
            if name in data:
                found.data[name] = data[name].to_numpy()[known]
            else:
                found.data.pop(name)
        return found

    def filled(self, data: pd.DataFrame, place: dict[str, Any]) -> dict[str, pd.Series]:
        """The columns of ``data`` with what stood in for others in this loop."""
        columns = with_aliases(data, ())
        for one in self.stand_ins:
            columns = one.fill_columns(columns)
        how = place, self.transposition, self.label
        return transposed_again(columns, data.index, *how)

    def whole(self, data: pd.DataFrame) -> pd.DataFrame:
        """``data`` with those columns."""
        timed, known = self.timed(data)
        columns = self.filled(timed, self.there(timed, {}))
        names = [one.usual for one in self.stand_ins if one.column in columns]
        names += ["poa_global"] if self.transposition else []
        labels: dict[str, Any] = {printable(label): label for label in data}
        return data.assign(
            **{
                labels.get(name, name): untimed(columns[name], data.index, known)
                for name in names
            }
        )

    def temperature_model(
        self, weather: pd.DataFrame | None = None, **options: Any
    ) -> DynamicCellTemperature:
        """
        The last step as a temperature model for pvlib's ModelChain.

        Parameters
        ----------
        weather : DataFrame, optional
            Of the run, with the columns that the effects need; by default those of
            this record. The sun's place comes from the chain.
        **options
            ``deltaT`` or ``k_bs_c``, see :class:`DynamicCellTemperature`, and the
            drivers of the effects by name, at the times of the run.

        Returns
        -------
        DynamicCellTemperature
        """
        record = self.fit.record
        if weather is None and record is not None:
            weather = pd.DataFrame(
                {name: record[name] for name in self.fit.thermal_model.drivers},
                record.index,
            )
        if weather is not None:
            place = [name for name in GEOMETRY if name in weather]
            weather = weather.drop(columns=place)
        return self.fit.temperature_model(weather, **options)

    def plot(self, ax: Any = None) -> Any:
        """
        Measured temperature on the most variable test day, modelled before and after.

        Parameters
        ----------
        ax : matplotlib Axes, optional

        Returns
        -------
        matplotlib Axes
        """
        if self.fit.record is None:
            raise ValueError(
                "a loop that was read from a file has no rows to plot; close it again"
            )
        from pvlib_fem import plotting

        return plotting.plot_before_after(self, ax)

    def to_html(
        self,
        path: FilePath | None = None,
        title: str | None = None,
        gamma: float = GAMMA,
    ) -> str:
        """
        The report with pictures as one self-contained HTML file.

        Parameters
        ----------
        path : str or path-like, optional
            File to write.
        title : str, optional
            Of the plant or the file; by default the name of the location.
        gamma : float, default -0.0035
            Temperature coefficient of power, by which K become yield. [1/K]

        Returns
        -------
        str
        """
        from pvlib_fem._report.loop_page import page
        from pvlib_fem._report.loop_text import not_identifiable
        from pvlib_fem._statements.make import statements_of

        statements = self.statement_objects
        if gamma != GAMMA:
            statements = statements_of(self, energies(self, gamma))
        table = as_table(statements)
        return saved(page(self, table, not_identifiable(self.fit), title, gamma), path)

    def _repr_html_(self) -> str:
        from pvlib_fem._report.loop_page import brief

        return brief(self)

    def to_json(self, path: FilePath | None = None, **cell: float) -> str:
        """
        The loop as JSON, of which :meth:`from_json` makes the same again.

        Findings, corrections, table, ranking, what was not testable, criteria and
        the fit; all numbers keep their bits. The rows of the record are not in it.

        Parameters
        ----------
        path : str or path-like, optional
            File to write.
        **cell
            ``deltaT`` or ``k_bs_c``, as in :meth:`FemFit.to_json`.

        Returns
        -------
        str
        """
        return written(LOOP, self.content(**cell), path)

    def content(self, **cell: float) -> dict[str, Any]:
        """What is in a file of the loop."""
        return loop_content(self, cell)

    @classmethod
    def from_json(
        cls, path: FilePath, effects: EffectLike | Iterable[EffectLike] = ()
    ) -> Self:
        """
        The loop that :meth:`to_json` or the command ``pvlib-fem`` wrote.

        It prints its report, predicts, and goes into a ModelChain. What needs the
        rows of the record (pictures, ``weeks``, ``residual_before``) is not in it.

        Parameters
        ----------
        path : str or path-like
        effects : Effect or sequence of these, optional
            Your own effects, which the file knows by name and settings only.

        Returns
        -------
        Loop

        Raises
        ------
        ValueError
            If the file is of another kind or version, or a number is missing or none;
            the message names the key.
        """
        with opened(path, [LOOP]) as stored:
            attributes, computed = loop_parts(stored, effects)
            loop = cls(**attributes, residual_before=None, weeks=None)
            vars(loop).update(computed)
            return loop

    @cached_property
    def yearly_energy(self) -> dict[str, float]:
        """Energy that each finding changes, by its effect. [kWh/kWp per year]"""
        return energies(self)

    @cached_property
    def statement_objects(self) -> list[Statement]:
        """The statements as objects, made once for page, file and print."""
        from pvlib_fem._statements.make import statements_of

        return statements_of(self, self.yearly_energy)

    @property
    def statements(self) -> pd.DataFrame:
        """
        What was found in sentences, a row each, with the numbers in them.

        Clocks, module temperature sensors that came off and stuck irradiance sensors
        come first, hints last. Between them are causes in the model, events,
        unexplained patterns and days that stand out, those that change most energy
        first.

        Returns
        -------
        DataFrame
            ``cause``, ``device``, ``verdict``, ``text``, ``action``, ``certainty``,
            ``gain`` [K]; ``energy``, the absolute change of the expected DC energy by
            the finding at -0.35 %/K, of a fault of the irradiance sensor with that of
            the irradiance, and of events that of the measured power [kWh/kWp per
            year]; ``value`` with ``error``, ``low`` and
            ``high`` in ``unit``: what the device reads beyond the truth, negative
            where it reads less, or of a clock the minutes by which its timestamps are
            ahead; ``since``, ``until``, ``probability`` and ``alternatives``.
        """
        return as_table(self.statement_objects)

    @property
    def conclusion(self) -> tuple[str, ...]:
        """The error before and after, and what was found, in sentences."""
        from pvlib_fem._statements.loop_summary import conclusion

        return tuple(conclusion(self, self.statement_objects))

    def report(self) -> str:
        """
        The whole report: every step, finding, check, hint and note.

        Returns
        -------
        str
        """
        from pvlib_fem._report.loop_text import lines

        return printable("\n".join(lines(self)), "\n")

    def __str__(self) -> str:
        from pvlib_fem._statements.loop_summary import summary

        return printable("\n".join(summary(self)), "\n")


def untimed(found: Result, index: pd.Index, known: np.ndarray) -> Result:
    """Put a result back on the times of the data; NaN where a time is unknown."""
    if known.all():
        return found.set_axis(index)
    rows = np.where(known, np.cumsum(known) - 1, -1)
    return found.reset_index(drop=True).reindex(rows).set_axis(index)
