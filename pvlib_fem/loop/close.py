"""Close the loop: from the residual to the missing effect, and what it was worth."""

from dataclasses import dataclass, field, replace

import numpy as np
import pandas as pd
from threadpoolctl import threadpool_limits

from pvlib_fem.drivers import needed_for
from pvlib_fem.findings import Finding
from pvlib_fem.fitting.fit import errors, finished
from pvlib_fem.loop.case import FEWEST_DAYS, prepared
from pvlib_fem.loop.criteria import Criteria
from pvlib_fem.loop.ranking import COLUMNS, ENOUGH_DAYS, ranked
from pvlib_fem.loop.result import Loop
from pvlib_fem.loop.steps import SCORES, Fits, error_table
from pvlib_fem.quality.clock import left_open
from pvlib_fem.record.columns import leaks
from pvlib_fem.statistics.tables import find_structure
from pvlib_fem.statistics.timetables import timetables
from pvlib_fem.thermal.steady import steady_model

SHARE = 0.015  # of the mean square that a material gain takes off at least
SUGGESTED = 0.10  # K from which a gain is worth a word
LIKELY = 0.05  # chance that any of the candidates looks as good by accident
KEPT = 0.5  # share of its gain that an effect has to keep beside unknown structure
SURE = 3.0  # errors that a coefficient has to be from nothing in the refit
LEFT = 0.4  # share of unknown structure that may be left where an effect explains it
SPILL = 0.1  # of the square of unknown structure, which may look like an effect
UNKNOWNS = 3  # tables that are set aside in one search
MOST = 6  # effects of a kind
ROUNDS = 3


def close_loop(
    data,
    model="faiman",
    location=None,
    surface_tilt=None,
    surface_azimuth=None,
    holdout=None,
    min_gain=0.15,
    effects=None,
    check_units=True,
) -> Loop:
    """
    Trace what a fit leaves to the physical effects that the model lacks.

    The model is fitted to the open weeks of a record. Every effect that has its
    driver is then weighed by what it would explain on open weeks left out in
    turn, beside the tangents of all fitted coefficients and the shapes that any
    misfit leaves. One is added where its gain is material, no accident among all
    that were tried, of a possible size, and not better explained by structure of
    unknown cause. Shapes of the usual inputs alone come after, as classes. The
    sealed weeks are looked at when a finding is tried on them; what they contradict is
    withdrawn.

    Parameters
    ----------
    data : DataFrame
        With a DatetimeIndex and the columns ``poa_global`` [W/m²], ``temp_air``
        [°C], ``wind_speed`` [m/s], ``temp_module`` [°C], and any of
        ``wind_direction`` [° from north], ``relative_humidity`` [%],
        ``longwave_down`` (or ``ir_down``) [W/m²], ``precipitation`` [mm/h],
        ``p_dc`` [W per m² of module], ``snow_depth`` [cm]. Every other numeric
        column is a candidate driver of its own, ``driver:<column>``.
    model : str, default "faiman"
        ``"ross"``, ``"sapm"``, ``"faiman"``, ``"wm1"`` or ``"wm2"``.
    location : pvlib.location.Location, optional
        With both angles below, effects that follow the sun can be tested.
    surface_tilt, surface_azimuth : float, optional
        Of the module; azimuth from north, clockwise. [°]
    holdout : Series of bool, optional
        Rows to seal. By default every fifth week, or every other day of a record
        below five weeks.
    min_gain : float, default 0.15
        Gain below which nothing is added to the model. [K]
    effects : sequence of str or Effect, optional
        Effects to try; by default all, and the user's own columns.
    check_units : bool, default True
        Refuse columns that look to be in another unit.

    Returns
    -------
    Loop

    Raises
    ------
    ValueError
        If the record is unusable: times, columns, units; the message names the
        column, the value and the remedy.
    """
    site = dict(
        location=location, surface_tilt=surface_tilt, surface_azimuth=surface_azimuth
    )
    search = Search.of(data, model, site, holdout, min_gain, effects, check_units)
    return search.run()


#: LAPACK's last bits depend on the number of threads, and its matrices here are small
one_thread = threadpool_limits.wrap(limits=1, user_api="blas")


@dataclass(eq=False)
class Search:
    """A case, and what was found in it so far."""

    fits: Fits
    steady_model: object
    min_gain: float
    steps: dict = field(default_factory=dict)
    findings: list = field(default_factory=list)
    vetoed: dict = field(default_factory=dict)  # what a fit spoke against, by name
    untestable: dict = field(default_factory=dict)

    @classmethod
    @one_thread
    def of(cls, data, model, site, holdout, min_gain, effects, check_units=True):
        """The search in a user's frame, everything checked."""
        case = prepared(data, site, holdout, effects, check_units)
        found = dict(case.untestable)
        return cls(Fits(case), steady_model(model), min_gain, untestable=found)

    @property
    def case(self):
        return self.fits.case

    @one_thread
    def run(self, tell=lambda words: None):
        """The loop itself; ``tell`` hears what is being done."""
        tell("fitting the model without effects")
        self.steps |= self.fits.bases(self.steady_model)
        base = self.fits.better(self.steps)
        if self.case.clock.fault:
            tell("correcting the clock")
            base = self.clock(base)
        self.leave_out_leaks(base)
        found, step = None, base
        for turn in range(ROUNDS if self.case.divisible else 0):
            tell(f"weighing effects, round {turn + 1}")
            found = self.evidence(step)
            new = self.drivers_in(found)
            new += self.shapes_in(found, [finding.effect for finding in new])
            tell(f"fitting {', '.join(f.effect for f in new) or 'no further effect'}")
            further = self.added(new, found, step)
            if further is step:
                break
            step = further
        tell("looking at the sealed days")
        return self.result(step, base, found)

    def clock(self, raw):
        """The case re-timed and fitted again, and the finding of its clock."""
        clock, days = self.case.clock, self.case.days
        before = self.fits.gathered(raw, []).left()
        self.fits = Fits(self.case.corrected())
        step = self.fits.fitted(raw.model, raw).as_base()
        self.steps["+clock_shift"] = step
        gain = before - self.fits.gathered(step, []).left()
        error = left_open(clock.stderr, clock.limit)
        values, stderr = {}, {}
        if {"clock_shift", "clock_drift"} & set(clock.faults):
            values["clock_shift.minutes"] = clock.late / 60.0
            stderr["clock_shift.minutes"] = error / 60.0
        if "clock_drift" in clock.faults:
            values["clock_shift.drift"] = clock.drift
            stderr["clock_shift.drift"] = clock.drift_stderr
        if "dst" in clock.faults:
            hours = [late for _, late in clock.hours]
            values["clock_shift.summer"] = max(hours, key=abs) / 60.0
        named = days >= ENOUGH_DAYS
        finding = Finding(
            "clock_shift",
            ("clock_shift",),
            "named" if named else "suggestive",
            float(np.sign(gain) * np.sqrt(abs(gain))),
            values,
            stderr,
            "; ".join(clock.faults.values()),
        )
        self.findings.append(finding)
        return step

    def evidence(self, step):
        """Evidence of all that a step lacks."""
        there = {effect.name for effect in step.model.effects}
        wanted = [effect for effect in self.case.wanted if effect.name not in there]
        return self.fits.gathered(step, wanted)

    def leave_out_leaks(self, base):
        """Drop columns of the user's own that hold the answer."""
        case, modelled = self.case, base.model.temperature
        own = [e.column for e in case.wanted if e.column]
        if not own:
            return
        record = case.record
        temperature = modelled(record.inputs, base.coefficients)
        for name in leaks(record, case.open, temperature, own):
            effect = f"driver:{name}"
            self.untestable[effect] = "the module temperature itself, or made from it"
            wanted = tuple(e for e in case.wanted if e.name != effect)
            drivers = tuple(d for d in case.drivers if d != name)
            case = replace(case, wanted=wanted, drivers=drivers)
        self.fits.case = case

    def floor(self, found, beside):
        """Gain that is material. [K²]"""
        return max(self.min_gain**2, SHARE * found.left(beside))

    def drivers_in(self, found):
        """Effects with a driver of their own, one after the other."""
        names = [n for n, effect in found.effects.items() if not effect.confounder]
        return self.forward(found, names, found.nuisances)

    def shapes_in(self, found, taken):
        """Shapes of the usual inputs, which are classes."""
        names = [n for n, effect in found.effects.items() if effect.confounder]
        return self.forward(found, names, taken)

    def forward(self, found, names, beside):
        """Forward selection: the best that is material, until none is."""
        new, beside, unknowns, spill = [], list(beside), 0, 0.0
        # what cannot be told from a finding is no finding of its own
        done = {name for finding in self.findings for name in finding.candidates}
        names = [name for name in names if name not in done]
        while len(new) < MOST and names:
            rows = {name: found.weigh(name, beside) for name in names}
            good = {n: row["gain"] for n, row in rows.items() if passes(row, rows)}
            floor = max(self.floor(found, beside), spill)
            material = {n: gain for n, gain in good.items() if gain**2 >= floor}
            if not material:
                break
            best = max(material, key=material.get)
            table = self.dominating(found, best, beside, floor)
            if table is None:
                ties = found.ties(best, good, beside)
                new.append(self.finding(found, best, rows[best], ties))
                beside.append(best)
                names = [name for name in names if name not in (best, *ties)]
                continue
            if unknowns == UNKNOWNS:
                break
            unknowns += 1
            spill = max(spill, SPILL * table.gain**2)
            found = found.with_column(f"unknown:{unknowns}", table.values)
            beside.append(f"unknown:{unknowns}")
        return new

    def dominating(self, found, name, beside, floor):
        """Structure of unknown cause that leaves little for an effect, if any."""
        own = found.effects[name].drivers
        table = self.structure(found, beside, without=[*own, *needed_for(own)])
        if table is None or table.gain**2 < floor:
            return None
        wider = found.with_column("unknown", table.values)
        # several shapes together may make what none of them makes alone
        with_it = found.nuisances if found.effects[name].confounder else [name]
        remains = wider.gain("unknown", [*beside, *with_it])
        keeps = wider.gain(name, [*beside, "unknown"])
        explained = remains < max(floor, LEFT * table.gain**2)
        if explained or keeps >= max(KEPT * found.gain(name, beside), floor):
            return None
        return table

    def structure(self, found, beside, without=()):
        """The strongest table of what is left."""
        case, rows = self.case, found.seen
        seconds = case.record.inputs.seconds[rows]
        step = float(np.median(np.diff(seconds)))
        at = rows[case.open]
        axes = [axis.of(at) for axis in case.axes]
        rest, folds = found.rest(beside), case.folds[at]
        dates, criteria = case.record.dates[rows], Criteria()
        axes += timetables(rest, seconds, dates, folds, step, criteria)
        return find_structure(rest, seconds, folds, axes, step, criteria, without)

    def finding(self, found, name, row, ties):
        """The finding of an effect that is material."""
        effects = [found.effects[n] for n in (name, *ties)]
        if effects[0].confounder or ties:
            words = dict.fromkeys(e.decided_by for e in effects if e.decided_by)
            why = f"{'; or '.join(words) or 'a driver of its own'} would decide"
            verdict = "class"
        else:
            chance = min(1.0, row["p_value"] * len(found.effects))
            why = f"{row['gain']:.2f} K of the held-out error, chance {chance:.1g}"
            verdict = "named"
        if self.case.days < ENOUGH_DAYS:
            verdict, why = "suggestive", too_short(self.case.days)
        numbers = (row["gain"], row["coefficients"], row["stderr"])
        return Finding(name, (name, *ties), verdict, *numbers, why)

    def added(self, new, found, step):
        """The last step that holds, of those with one more effect each."""
        for finding in new:
            if finding.verdict != "suggestive":
                finding, attempt = self.tried(finding, found, step)
                if finding.verdict == "suggestive":
                    # beside effects that come later it may hold
                    self.vetoed[finding.effect] = finding
                    continue
                step = self.steps[f"+{finding.effect}"] = attempt
                self.vetoed.pop(finding.effect, None)
            self.findings.append(finding)
        return step

    def tried(self, finding, found, step):
        """The finding and its fit, by the first of its candidates that holds."""
        tries = []
        for name in finding.candidates:
            effect, mine = found.effects[name], finding
            if name != finding.effect:
                row = found.weigh(name)
                if "coefficients" not in row:
                    continue
                others = (name, *(n for n in finding.candidates if n != name))
                numbers = {k: row[k] for k in ("coefficients", "stderr")}
                mine = replace(finding, effect=name, candidates=others, **numbers)
            larger = replace(step.model, effects=(*step.model.effects, effect))
            fit = self.fits.fitted(larger, step, mine.coefficients, whole=False)
            tries.append((self.confirmed(mine, step, fit), fit))
            if tries[-1][0].verdict != "suggestive":
                return tries[-1]
        return tries[0]

    def confirmed(self, finding, before, after):
        """The finding, unless the fit or the sealed days speak against it."""
        test, seen = self.case.test, self.case.seen
        if np.isnan(after.temperature[seen]).any():
            why = "fitted with all others it leaves rows without a temperature"
            return replace(finding, verdict="suggestive", why=why)
        effects = {key for e in after.model.effects for key in e.rows()}
        if bound := sorted(effects & set(after.at_bound)):
            why = f"fitted with all others, {bound[0]} ends at the bound of its range"
            return replace(finding, verdict="suggestive", why=why)
        values, stderr = after.coefficients, self.fits.errors(after)
        sure = {n: abs(values[n]) / stderr[n] for n in finding.coefficients}
        if max(sure.values()) < SURE:  # NaN, where there are no errors, is no doubt
            name, why = max(sure, key=sure.get), "fitted with all others"
            why = f"{why}, {name} is {values[name]:.2g} ± {stderr[name]:.2g}"
            return replace(finding, verdict="suggestive", why=why)
        if test.any() and (worse := after.error(test) - before.error(test)) > 0:
            why = f"the sealed days contradict it: their error rises by {worse:.2g} K"
            return replace(finding, verdict="suggestive", why=why)
        return finding

    def result(self, last, base, found):
        """All that was found, as a finished thing."""
        case, notes = self.case, []
        if last is not base and case.record is not case.whole:
            last = self.fits.fitted(last.model, last, last.coarse)
            self.steps[list(self.steps)[-1]] = last
        record, tabled = self.fits.prepared(case.whole, last.model)
        stderr = errors(
            tabled, record, case.train, last.coefficients, last.at_bound, notes
        )
        table = error_table(case, self.steps)
        fit = finished(
            last.model,
            record,
            last.temperature,
            (case.train, case.test, case.sealed),
            (last.coefficients, stderr, last.at_bound, last.converged),
            scores=table[SCORES].rename_axis(None),
            notes=tuple(notes),
            method="least_squares",
            night=True,
        )
        findings = [self.with_errors(f, last, stderr) for f in self.findings]
        findings += self.vetoed.values()
        ranking = pd.DataFrame(columns=COLUMNS)
        if found is None:
            few = (
                f"{case.open_days} open days are too few to leave any out, of "
                f"{FEWEST_DAYS}"
            )
            self.untestable |= {effect.name: few for effect in case.wanted}
        else:
            rows = ranked(found, case.days)
            ranking = pd.DataFrame.from_dict(rows, orient="index")
            ranking = ranking.reindex(columns=COLUMNS)
            ranking = ranking.sort_values("gain", ascending=False, kind="stable")
            findings += self.suggested(rows, findings)
            findings += self.unexplained(found)
            self.not_seen(found, rows, findings)
        before = pd.Series(base.measured - base.temperature, record.index)
        return Loop(
            findings=tuple(findings),
            table=table,
            untestable=dict(self.untestable),
            ranking=ranking,
            fit=fit,
            notes=case.notes,
            place=case.site,
            residual_before=before.rename("residual"),
            min_gain=self.min_gain,
            weighed=found is not None,
        )

    def with_errors(self, finding, last, stderr):
        """The finding with the coefficients of the last fit, where it is in it."""
        if finding.effect not in {effect.name for effect in last.model.effects}:
            return finding
        return replace(
            finding,
            coefficients={k: last.coefficients[k] for k in finding.coefficients},
            stderr={k: stderr[k] for k in finding.stderr},
        )

    def suggested(self, rows, findings):
        """Gains worth a word that were not enough for more."""
        done = {name for finding in findings for name in finding.candidates}
        for name, row in rows.items():
            if name in done or not passes(row, rows) or row["gain"] < SUGGESTED:
                continue
            why = f"not enough for a name: material is {self.min_gain:.2f} K"
            if row["gain"] >= self.min_gain:
                why = "structure of unknown cause explains more"
            if self.case.days < ENOUGH_DAYS:
                why = too_short(self.case.days)
            numbers = (row["gain"], row["coefficients"], row["stderr"])
            yield Finding(name, (name, *row["ties"]), "suggestive", *numbers, why)

    def unexplained(self, found):
        """Structure that is left when all is said."""
        beside = []
        for i in range(UNKNOWNS):
            table = self.structure(found, beside)
            if table is None or table.gain**2 < self.floor(found, beside):
                return
            why = (
                f"{table.gain:.2f} K lives in {table.where}: nothing in the catalogue; "
                "a column that follows it would settle it"
            )
            mean = {"mean": table.size}
            yield Finding(
                table.name,
                table.drivers,
                "unknown",
                table.gain,
                mean,
                {},
                why,
                table.ranges,
            )
            found = found.with_column(f"unknown:{i}", table.values)
            beside.append(f"unknown:{i}")

    def not_seen(self, found, rows, findings):
        """Why this record could not see what it did not show."""
        said = {name for finding in findings for name in finding.candidates}
        for name, row in rows.items():
            effect = found.effects.get(name)
            if "gain" not in row:
                self.untestable[name] = row["note"]
            elif effect.confounder and name == "sky_radiation":
                self.untestable[name] = (
                    "no longwave_down, no relative_humidity: only what follows the air "
                    "temperature was tried"
                )
            elif name in said:
                continue
            elif not row["physical"] and row["gain"] > 0:
                self.untestable[name] = row["note"]
            elif row["detectable"] > self.min_gain:
                least = row["detectable"]
                self.untestable[name] = f"this record shows it from {least:.2g} K only"


def passes(row, rows):
    """Whether a candidate is possible, and no accident among all tried."""
    possible = row.get("physical") and row["gain"] > 0
    return bool(possible and row["p_value"] * len(rows) <= LIKELY)


def too_short(days):
    return f"{days} days are too few for a name, of {ENOUGH_DAYS}"
