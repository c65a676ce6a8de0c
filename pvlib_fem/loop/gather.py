"""Evidence for effects that a fitted model lacks, from one pass over a record."""

from collections.abc import Callable
from dataclasses import dataclass, fields, replace

import numpy as np

from pvlib_fem.drivers import needed_for
from pvlib_fem.effects.effect import Effect, Terms, tabled
from pvlib_fem.loop.evidence import Evidence
from pvlib_fem.reasons import Reason, because
from pvlib_fem.record.columns import COLUMNS
from pvlib_fem.record.inputs import Inputs
from pvlib_fem.relaxation import FADED, relax
from pvlib_fem.statistics.clusters import calendar_weeks
from pvlib_fem.thermal.model import ThermalModel

FEW = 18  # effects of which the tangents are made at a time


def gather(
    model, coefficients, record, seen, candidates, criteria, family, fixed=()
) -> Evidence:
    """
    Evidence for candidates beside a model at its minimum.

    Parameters
    ----------
    model : ThermalModel
    coefficients : dict
        All of the model's.
    record : Record
        With every measured driver of the candidates.
    seen : array of bool
        Rows that count. Where a driver lacks they do not count for its effect.
    candidates : sequence of Effect
    criteria : Criteria
    family : Family
        Number of hypotheses.
    fixed : sequence of str
        Coefficients that are held, or at a bound, where they stay.
    """
    model = replace(model, base=model.base or coefficients)
    inputs = model.with_base(model.with_drivers(record.inputs))
    inputs, tried, failed = ready(model, inputs, seen, candidates)
    temperature = model.temperature(inputs, coefficients)
    rows = np.flatnonzero(seen & np.isfinite(temperature))
    at = Tangents.of(model, inputs, coefficients, rows)
    own = at.slopes()
    base = [n for n in model.free if n not in fixed and own[n].any()]
    wrong = misfits(temperature - coefficients["bias"], record, rows)
    found = Evidence(
        {name: own[name] for name in base} | wrong,
        (record["temp_module"] - temperature)[rows],
        record.dates[rows],
        rows,
        tuple(base),
        tuple(wrong),
        family=family,
        criteria=criteria,
        snowy=snowy(record, rows),
    )
    scanned, changing = [], []
    for one, own in tangents(tried, failed, inputs, at):
        known = record.known(needed_for(one.wide.drivers))[rows]
        if not all(are_numbers(column, known) for column in own.values()):
            failed |= {name: because(Reason.NOT_A_NUMBER) for name in one.names}
        elif one.scan:
            scanned.append((one.scan, one.wide, own, known))
        elif one.courses:
            (column,) = own
            found = found.on_some(column, own, known)
            changing += [(course, column) for course in one.courses]
        else:
            found = found.with_effect(one.wide, own, known)
    for scan, wide, own, known in scanned:
        effect = narrowed(found, scan, wide, own, known, inputs)
        if effect is None:
            failed[wide.name] = because(Reason.NO_WINDOW)
            continue
        there = replace(model, effects=(effect,)).with_drivers(inputs)
        for _, own in tangents([Tried(effect)], failed, there, at):
            found = found.with_effect(effect, own, known)
    return with_changes(found, tuple(changing), failed)


@dataclass(frozen=True, eq=False)
class Tried:
    """What is tried first of an effect, or of a channel along its courses."""

    wide: Effect
    scan: Callable | None = None  # that takes the effect from the wide one
    courses: tuple = ()  # effects whose dates are to be found

    @property
    def names(self):
        return [one.name for one in self.courses or (self.wide,)]


def ready(model, inputs, seen, candidates):
    """
    Inputs with the drivers of all effects, what is tried of them, and why not.

    An effect that is scanned enters as the wide one from which its scan takes it, and
    all courses of a channel as the channel, whole.
    """
    tried, failed = {}, {}
    for effect in candidates:
        try:
            if effect.prepare:
                effect = effect.prepare(inputs.columns, seen)
            wide, name = effect.scanned_from or effect, effect.name
            if effect.dates:
                wide, name = replace(wide, name=effect.channel), effect.channel
                if name in tried:
                    courses = (*tried[name].courses, effect)
                    tried[name] = replace(tried[name], courses=courses)
                    continue
            inputs = replace(model, effects=(wide,)).with_drivers(inputs)
            courses = (effect,) if effect.dates else ()
            tried[name] = Tried(wide, effect.scan, courses)
        except Exception as error:  # whatever an effect does, the others go on
            failed[effect.name] = broken(error)
    return inputs, [*tried.values()], failed


def broken(error):
    """Why an effect cannot be tried that raises an error of its own."""
    return because(Reason.BROKEN, error=f"{type(error).__name__}: {error}")


@dataclass(frozen=True, eq=False)
class Tangents:
    """Slopes of a model's temperature at some rows, by these and what they remember."""

    model: ThermalModel  # which knows its effects on those that are read
    inputs: Inputs  # of those
    coefficients: dict
    read: np.ndarray  # rows of the record
    places: np.ndarray  # of those asked for among them

    @classmethod
    def of(cls, model, inputs, coefficients, rows):
        """Those at some rows, which are in order."""
        model = model.knowing(inputs, coefficients)
        lasting = FADED * model.longest(inputs, coefficients)
        read = remembered(rows, inputs.seconds, lasting)
        names = (*COLUMNS[:3], *model.drivers)
        inputs = inputs.only(names).taken(read)
        places = np.searchsorted(read, rows)
        return cls(model.on(read), inputs, coefficients, read, places)

    def slopes(self, also=None):
        """By the model's own parameters, or by further terms, which are of all rows."""
        wanted, terms = also is None, also or {}
        terms = {name: held(one.part(self.read)) for name, one in terms.items()}
        slopes = self.model.slopes(self.inputs, self.coefficients, wanted, terms)[1]
        names = [*slopes] if wanted else terms
        return {name: slopes.pop(name)[self.places] for name in names}


def remembered(rows, seconds, lasting):
    """Some rows, and those before each that are no older than so long. [s]"""
    ahead = np.full(len(seconds), np.inf)
    ahead[rows] = seconds[rows]
    ahead = np.minimum.accumulate(ahead[::-1])[::-1]
    return np.flatnonzero(ahead - seconds <= lasting)


def tangents(tried, failed, inputs, at):
    """
    What is tried with the tangents of its parameters, one by one.

    Of a few at a time terms and slopes are held on many rows.
    """
    for first in range(0, len(tried), FEW):
        terms, there = {}, []
        for one in tried[first : first + FEW]:
            try:
                terms |= terms_of(one.wide, inputs.columns)
                there.append(one)
            except Exception as error:
                failed |= dict.fromkeys(one.names, broken(error))
        slopes = at.slopes(terms)
        for one in there:
            yield one, {key: slopes.pop(key) for key in one.wide.rows()}


def are_numbers(column, known):
    """Whether a column is a number on all rows that are known."""
    # a sum that is one says it of all, in one fast pass
    return bool(np.isfinite(column.sum()) or np.isfinite(column[known]).all())


def with_changes(found, changing, failed):
    """The evidence with the channels along those courses whose dates are found."""
    found = found.along(found.shown(changing, found.confounders))
    dateless = [e.name for e, _ in changing if e.name not in found.effects]
    failed |= dict.fromkeys(dateless, because(Reason.NO_DATE))
    return replace(found, changing=changing, failed=failed)


def snowy(record, rows):
    """Which of some rows have snow on the ground; None where that is not measured."""
    depth = record.inputs.columns.get("snow_depth")
    return None if depth is None else depth[rows] > 0.0


def terms_of(effect, columns):
    """Slopes of an effect's terms from where it adds nothing."""
    return tabled(effect, columns).slopes(columns, effect.start)


def held(terms):
    """
    Terms over gaps as the kernel takes them: the next sample counts for all of it.

    So the rows after a gap have a memory; those in it do not count.
    """
    return Terms(*(filled(getattr(terms, column.name)) for column in fields(terms)))


def filled(column):
    """A column of terms with the next number in each gap, at its end the last one."""
    if not np.ndim(column) or not np.isnan(column.sum()):
        return column
    lacks = np.flatnonzero(np.isnan(column))
    if len(lacks) == len(column):
        return column
    begins = np.diff(lacks, prepend=-2) > 1
    after = lacks[np.append(begins[1:], True)] + 1  # the row behind each gap
    if after[-1] == len(column):
        after[-1] = lacks[begins][-1] - 1
    column = column.copy()
    column[lacks] = column[after[np.cumsum(begins) - 1]]
    return column


def narrowed(found, scan, wide, own, known, inputs):
    """The effect where a scan of what is left shows it, or None."""
    places = {name: inputs[name][found.rows[known]] for name in wide.drivers}
    names, given = list(found.columns), found.places(found.confounders)
    tangents = own | {names[i]: found.columns[names[i]] for i in given}
    if not known.all():
        tangents = {key: column[known] for key, column in tangents.items()}
    rest = found.rest(found.confounders)[known]
    weeks = calendar_weeks(found.dates[known])
    return scan(rest, tangents, places, weeks, found.criteria)


def misfits(temperature, record, rows):
    """
    What a misshapen steady model leaves at some rows, beside other confounders.

    Functions of the usual inputs alone, which every cause without a driver of
    its own shares: curvature in the over-temperature, its fall with air
    temperature, a slower mass, and a record that is late.
    """
    air, hour = record["temp_air"], 3600.0 / record.inputs.unit
    over = temperature - air
    slow = relax(np.nan_to_num(over), record.inputs.steps, hour)[rows]
    steps = np.maximum(record.inputs.steps, 1.0)  # the first has no row before it
    late = np.diff(temperature, prepend=temperature[:1]) / steps
    over = over[rows]
    columns = {
        "curved": over * np.sqrt(np.abs(over)),
        "warm": over * (air[rows] - np.nanmean(air)),
        "slow": slow - over,
        "late": np.nan_to_num(late[rows]),
    }
    return {f"misfit:{name}": column for name, column in columns.items()}
