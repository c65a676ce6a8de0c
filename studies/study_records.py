"""One record of the study: the loop's result and the truth."""

import math
import time

import numpy as np
import pandas as pd
from study_worlds import (
    FLOOR,
    IN_PHYSICS,
    SECOND_GENERATOR,
    TRUTHS,
    UNKNOWN,
    Case,
    skyline,
)

from pvlib_fem import fem_temperature, fit_fem, heat_balance, simulator
from pvlib_fem._loop.close import close_loop
from pvlib_fem._loop.search import LONGWAVE
from pvlib_fem._record.column_names import COLUMNS
from pvlib_fem._record.filters import counted
from pvlib_fem._statements.make import REFLECTED
from pvlib_fem._thermal.model import thermal_model
from pvlib_fem.drivers import underived
from pvlib_fem.effects import EFFECTS, find
from pvlib_fem.effects._testable_effects import driver
from pvlib_fem.effects.catalogue.shading import window_effect
from pvlib_fem.effects.catalogue.soiling import soiling_by_rain
from pvlib_fem.simulator._deposits import DIRTIEST, PER_DAY
from pvlib_fem.simulator._schedules import undeclared_heat
from pvlib_fem.simulator._switches import amplitudes


def seen(data, case, forms):
    """The columns that a user would have."""
    data = data.copy()
    data.attrs = {}
    if case.form is not None:
        data["temp_module"] = formed(data, **case.form)
    if case.neighbour:
        on = amplitudes(case.sizes)
        heats = undeclared_heat(data.index, data["temp_air"], on, forms)
        data["neighbour"] = (np.asarray(heats[0]) + np.asarray(heats[1])) / 10.0
    data["temp_module"] += case.offset
    return data.drop(columns=list(case.drop))


def formed(data, seed, dynamics, u0, u1, memory, noise, hours, by_day):
    """The fitted form on measured columns, with autoregressive noise. [°C]"""
    usual = [data[name] for name in ("poa_global", "temp_air", "wind_speed")]
    if dynamics == "ewm":
        truth = fem_temperature(*usual, tau=memory, model="faiman", u0=u0, u1=u1)
    else:
        truth = heat_balance(
            *usual, capacity=30.0 * memory, model="faiman", u0=u0, u1=u1
        )
    step = (data.index[1] - data.index[0]).total_seconds()
    random = np.random.default_rng([seed, 77])
    error = simulator._constants.wander(random, len(data), hours * 3600.0 / step)
    scale = 0.5 + data["poa_global"] / 700.0 if by_day else 1.0
    return truth + noise * scale * error


def refit(loop, effects):
    """Test-week error of the same base with other effects. [K]"""
    return test_error(refitted(loop, effects), loop.weeks)


def test_error(fit, weeks):
    """Error of the test weeks' rows that count. [K]"""
    rows = np.asarray(counted(fit.record.inputs.columns, with_night=True))
    rows &= (weeks == "test").to_numpy() & fit.residual.notna().to_numpy()
    return float(np.sqrt((fit.residual[rows] ** 2).mean()))


test_error.__test__ = False  # no test, whatever its name


def refitted(loop, effects):
    """The base with other effects, fitted to the same rows."""
    record, fit = loop.fit.record, loop.fit
    others = {effect.name for effect in effects}
    longwave = [e for e in fit.effects if e.name == LONGWAVE and e.name not in others]
    effects = [*longwave, *effects]
    model = thermal_model(fit.model, fit.dynamics, effects)
    columns = {
        name: pd.Series(record[name], record.index)
        for name in (*COLUMNS, *model.drivers)
        if name not in record.absent
    }
    return fit_fem(
        **columns,
        model=fit.model,
        dynamics=fit.dynamics,
        effects=effects,
        holdout=loop.weeks != "fitting",
        night=True,
        check_units=False,
    )


def as_recorded(loop, data):
    """Test-week error of the base on the record as it came. [K]"""
    weeks = loop.weeks.reindex(data.index, fill_value="fitting")
    fit = fit_fem(
        *(data[name] for name in COLUMNS),
        model="faiman",
        dynamics=loop.fit.dynamics,
        holdout=weeks != "fitting",
        night=True,
    )
    return test_error(fit, weeks)


def catalogue(loop, data, case, site):
    """The true effects by switch, as terms of the catalogue; without a driver none."""
    record = loop.fit.record
    terms = {}
    for switch in case.sizes:
        if switch in ("shading", "shading_sensor"):
            windows = list(skyline(site.forms.obstacles))
            terms[switch] = window_effect(windows, sensor=switch == "shading_sensor")
        elif switch == "electrical_output":
            rows = (loop.weeks == "fitting").to_numpy()
            own = loop.fit.model, loop.fit.dynamics
            base = thermal_model(*own, (), loop.plain[1])
            columns = base.with_base(record.inputs).columns
            terms[switch] = EFFECTS[switch].prepare(columns, rows)
        elif switch == "sky_radiation" and "longwave_down" in case.drop:
            humid = "relative_humidity" not in case.drop
            source = "humidity" if humid else "clouds of the day"
            terms[switch] = find({"name": switch, "source": source})
        elif switch == "rain" and "precipitation" in case.drop:
            continue
        elif switch == "rain" and "relative_humidity" not in case.drop:
            terms[switch] = find({"name": switch, "source": "humidity"})
        elif switch in ("soiling", "soiling_sensor"):
            terms[switch] = soiling_by_rain(**cleaning_of(site.forms))
        elif switch == "tracker_stuck":
            terms[switch] = find({"name": switch, **standstill(site.tracker)})
        elif switch in TRUTHS and TRUTHS[switch].effect in EFFECTS:
            terms[switch] = find(TRUTHS[switch].effect)
        elif switch in UNKNOWN and case.neighbour:
            terms[switch] = driver("neighbour", data["neighbour"])
    return terms


def cleaning_of(forms):
    """The rain that cleans, and what follows it; mass that settles is not linear."""
    if forms.cleaning == "kimber":
        rain = {"cleaning": 6.0, "within": 24.0, "grace": 14.0}
    else:
        amount, hours = forms.washed_by if forms.cleaning == "rain" else (1.0, 1.0)
        rain = {"cleaning": amount, "within": hours}
    return rain | {"dirtiest": DIRTIEST / PER_DAY}


def standstill(tracker):
    """The true days and the true plane of a row that is stuck."""
    plane = (float(np.ravel(a)[0]) for a in tracker.plane(tracker.stuck.angle))
    days = dict(start=tracker.stuck.start, end=tracker.stuck.end)
    return days | dict(zip(("surface_tilt", "surface_azimuth"), plane))


def clear_days(world):
    """Days without clouds among those on which the irradiance sensor is stuck."""
    how = world.days, world.step, world.start, world.seed
    sky = simulator.weather(world.site, *how)
    there = world.site.tracker.stuck.during(sky.index) & (sky["elevation"] > 0)
    cloud = sky["cloud"][there].groupby(sky.index[there].date).max()
    return int((cloud < CLOUDLESS).sum())


CLOUDLESS = 0.3  # largest share of clouds on a day


def judged(world, cases):
    """A row for each record of a world."""
    # the nulls come first, each once
    nulls = {key(case.off): case.off for case in cases if case.off is not None}
    scenarios = [*nulls.values(), *(case.on for case in cases)]
    made = simulator.records(
        world.site,
        scenarios,
        world.days,
        world.step,
        world.seed,
        world.start,
        generator=world.generator,
    )
    known, rows = {}, []
    for name, off in nulls.items():
        second = world.generator == "fuentes"
        null = Case(SECOND_GENERATOR if second else "physics null", off)
        if "wind_speed" in cases[0].drop or world.site.tracker is not None:
            null = Case(cases[0].family, off, drop=cases[0].drop)
        known[name], row = looked(world, null, next(made))
        rows.append(row)
    for case, data in zip(cases, made):
        off = known.get(key(case.off)) if case.off is not None else None
        rows.append(looked(world, case, data, off)[1])
    return rows


def key(switches):
    return tuple(sorted(switches.items())) if switches is not None else None


def looked(world, case, data, off=None):
    """The loop of one record, and its row."""
    row = {
        "family": case.family,
        "seed": world.seed,
        "site": world.name,
        "days": world.days,
        "generator": "fitted form" if case.form is not None else world.generator,
        "truth": case.label,
        "truths": case.truths,
        "sizes": dict(case.sizes),
    }
    data = seen(data, case, world.site.forms)
    begin = time.perf_counter()
    try:
        loop = close_loop(data, case.model, **world.place)
    except np.linalg.LinAlgError as error:  # a ValueError, and no refusal
        return None, row | {"broken": f"LinAlgError: {error}", "first": "broken"}
    except ValueError as error:
        return None, row | {"refused": str(error), "first": "refused"}
    except Exception as error:
        broken = f"{type(error).__name__}: {error}"
        return None, row | {"broken": broken, "first": "broken"}
    row["seconds"] = time.perf_counter() - begin
    row |= said(loop, case, world) | errors(loop, data, case, off, world.site)
    row["told"] = coefficients_of(loop, world, case, off)
    row["coefficients"] = ratios(row["told"], case)
    return loop, row


def said(loop, case, world):
    """What the loop found, and whether that is right."""
    added = [
        f for f in loop.finding_objects if f.verdict in ("identified", "ambiguous")
    ]
    # one of the whole file is none of the module's logger
    corrections = [c for c in loop.corrections if c.applied]
    clocks = [c for c in corrections if not c.fault.startswith("file_")]
    groups = [{"clock_shift"} for _ in clocks]
    groups += [causes(finding.candidates, case) for finding in added]
    there = set(case.truths) | (IN_PHYSICS if case.form is None else set())
    known = set(case.truths)
    if world.generator == "fuentes":  # which has a sky that follows the air
        known |= {"sky_radiation"}
    there |= known
    wrong = [
        f.effect
        for f in added
        if f.verdict == "identified" and not causes([f.effect], case) & known
    ]
    wrong += ["clock_shift"] * (len(clocks) > 0 and "clock_shift" not in case.truths)
    misled = [
        "|".join(f.candidates)
        for f in added
        if f.verdict == "ambiguous"
        and not causes(f.candidates, case) & there
        and not ("reflection" in case.sizes and tells_of_reflection(loop, f.effect))
    ]
    verdicts = [f.verdict for f in loop.finding_objects]
    first = added[0].effect if added else "nothing"
    if clocks:
        first = "clock_shift"
    elif not added and verdicts:
        first = "unexplained" if "unexplained" in verdicts else "hint"
    return {
        "findings": "; ".join(
            f"{f.verdict} {'|'.join(f.candidates)} ({f.gain:.2f} K)"
            for f in loop.finding_objects
        ),
        "sets": sets(loop, case.covers),
        "verdicts": tuple(verdicts),
        "first": first,
        "first_ok": first_ok(groups, case),
        "found": tuple(
            name for name in case.truths if any(name in group for group in groups)
        ),
        "set_size": max(
            (len(g) for g in groups if g & set(case.truths)), default=math.nan
        ),
        "named_wrong": tuple(wrong),
        "class_wrong": tuple(misled),
        "unexplained_ok": unexplained_ok(loop, case),
        "untestable": tuple(loop.untestable),
        "mentioned": mentioned(loop, case),
        "clear_days": clear_days(world) if "tracker_stuck_sensor" in case.sizes else 0,
        "stuck": standstill(world.site.tracker) if world.site.tracker else {},
        "standings": [vars(one) for one in loop.standings],
        "standstills": [e.settings for e in loop.fit.effects if e.turns],
        "fitted_weeks": sum("not a test week" in line for line in loop.notes),
        "notes": "; ".join(loop.notes),
        "whys": "; ".join(correction.why for correction in loop.corrections),
    }


def causes(names, case):
    """Names of effects, covers under the names of the truths that they show."""
    return {cause for name in names for cause in case.covers.get(name, [name])}


def tells_of_reflection(loop, effect=None):
    """Whether a statement, or that on an effect, has a reflection onto the modules."""
    return any(
        REFLECTED.words in one.text
        for one in loop.statement_objects
        if effect in (None, one.cause)
    )


def sets(loop, covers=None):
    """Every finding that has probabilities, covers under the name of a cause."""
    covers, found = covers or {}, []
    for f in loop.finding_objects:
        shares = {}
        for name, share in f.probabilities.items():
            name = covers.get(name, [name])[0]
            shares[name] = shares.get(name, 0.0) + share
        if shares:
            effect = covers.get(f.effect, [f.effect])[0]
            found.append(dict(effect=effect, verdict=str(f.verdict), shares=shares))
    return found


def first_ok(groups, case):
    """Whether the first finding holds a truth; of confounders, any set of causes."""
    truths = set(case.truths)
    if not truths or not groups:
        return False
    alike = all(name in EFFECTS and EFFECTS[name].confounder for name in truths)
    return bool(truths & (set().union(*groups) if alike else groups[0]))


def unexplained_ok(loop, case):
    """Whether structure of unknown cause is said to live where it does."""
    hidden = [UNKNOWN[switch] for switch in case.sizes if switch in UNKNOWN]
    if [*case.sizes] == ["reflection"] and tells_of_reflection(loop):
        return True
    drivers = {*underived([n for f in loop.unexplained for n in f.candidates])}
    return bool(hidden) and all(g & drivers for groups in hidden for g in groups)


def mentioned(loop, case):
    """Whether the truth is among what could not be tested, or only ambiguous."""
    listed = set()
    for finding in loop.finding_objects:
        listed |= causes(finding.candidates, case)
    return set(case.truths) <= {*loop.untestable, *listed}


def errors(loop, data, case, off, site):
    """Test-week errors, and how large the effects are. [K]"""
    table = loop.table["rmse_test"]
    before, after = float(table[loop.base]), float(table.iloc[-1])
    terms = catalogue(loop, data, case, site)
    best = refit(loop, list(terms.values())) if terms else before
    row = {"before": before, "after": after, "oracle": best}
    if "clock_shift" in case.sizes and off is not None:
        row["oracle"] = best = float(off.table["rmse_test"][loop.base])
        late = as_recorded(loop, data)  # the loop may have set the clock already
        row["gains"] = {"clock_shift": root(late**2 - best**2)}
        row["detectable"] = {"clock_shift": FLOOR}
    elif off is not None:
        row["gains"] = sizes(loop, terms, before, best, off)
        row["detectable"] = {
            switch: smallest(off, TRUTHS[switch].effect if switch in TRUTHS else "")
            for switch in terms
        }
        change = (loop.residual_before - off.residual_before)[loop.fit.holdout]
        row["change"] = float(np.sqrt((change**2).mean()))
    return row


def sizes(loop, terms, before, best, off):
    """What each effect's terms take off, beyond what they do where it is not. [K]"""
    gains, null = {}, off.table["rmse_test"]
    for switch in terms:
        others = [term for name, term in terms.items() if name != switch]
        without = refit(loop, others) if others else before
        own = terms[switch]
        if not set(thermal_model(loop.fit.model, "ewm", [own]).drivers) <= {
            *off.fit.record.inputs.columns
        }:
            gains[switch] = root(without**2 - best**2)
            continue
        idle = refit(off, [own])
        repaired = max(float(null[off.base]) ** 2 - idle**2, 0.0)
        gains[switch] = root(without**2 - best**2 - repaired)
    return gains


def smallest(off, name):
    """Smallest detectable size, from the record without the effect. [K]"""
    known = off.ranking["minimum_detectable"].get(name, math.nan)
    return max(FLOOR, known) if np.isfinite(known) else FLOOR


def root(square):
    return math.copysign(math.sqrt(abs(square)), square)


def coefficients_of(loop, world, case, off):
    """Each coefficient with its truth, error and range, by switch."""
    known = {}
    for switch, size in sizes_of(world, case).items():
        truth = TRUTHS[switch]
        name = f"{truth.effect}.{truth.coefficient}"
        fitted = [f for f in loop.finding_objects if f.effect == truth.effect]
        if truth.effect == "clock_shift":
            late = [c.values["late"] for c in loop.corrections if c.applied]
            one = dict(value=late[0]) if late else None
        elif fitted and name in fitted[0].coefficients:
            one = dict(value=fitted[0].coefficients[name])
            one["stderr"] = fitted[0].stderr[name]
            one["range"] = fitted[0].ranges.get(name)
        else:
            continue
        expected = truth.expected(world, size)
        if one is None or math.isnan(expected):
            continue  # this world's law has no such coefficient
        if truth.added and off is not None:
            # of what physics leaves, the other confounders of the loop take their part
            others = IN_PHYSICS.intersection(loop.effects) - {truth.effect}
            beside = [find(other) for other in sorted(others)]
            alone = refitted(off, [*beside, find(truth.effect)])
            expected += alone.coefficients[name]
        known[switch] = {"name": name, "truth": expected, **one}
    return known


def sizes_of(world, case):
    """Sizes of what was added, and of what all modules emit, where that is known."""
    sizes = {name: size for name, size in case.sizes.items() if name in TRUTHS}
    if world.generator == "nodes" and case.form is None:
        sizes.setdefault("radiative_loss", case.on.get("radiative_loss", 0.0))
    return {n: s for n, s in sizes.items() if s and TRUTHS[n].coefficient}


def ratios(known, case):
    """Fitted over true coefficients of what was added, by switch."""
    return {n: k["value"] / k["truth"] for n, k in known.items() if n in case.sizes}
