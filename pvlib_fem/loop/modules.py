"""Several sensors of one plant's modules: what is each one's own."""

from collections.abc import Iterable

import numpy as np
import pandas as pd

from pvlib_fem.effects.courses import find_step, number
from pvlib_fem.loop.criteria import Criteria
from pvlib_fem.quality.screen import screened
from pvlib_fem.record.checks import as_record
from pvlib_fem.record.columns import same, twin_of, with_aliases
from pvlib_fem.statistics.changes import Daily
from pvlib_fem.statistics.clusters import cluster_sums

SUNNY = 200.0  # W/m², above which over-temperatures are compared
FEWEST = 3  # sensors, of which two can say which one is off
PRESENT = 0.5  # of the rows of the one that has most, below which a sensor is not used
FEWEST_ROWS = 100  # in sun
COLUMNS = ["share", "offset", "spread", "step", "change", "stderr"]
COLUMNS += ["rows", "used", "note"]


def compare_modules(
    data: pd.DataFrame,
    columns: Iterable[str] | None = None,
    criteria: Criteria | None = None,
) -> pd.DataFrame:
    """
    What each of several module sensors has of its own, beside the others.

    What all have in common is weather, weather station or plant; what one has alone is
    that sensor, or its module. Each is held against the median of the others.

    Parameters
    ----------
    data : DataFrame
        With a DatetimeIndex and ``poa_global`` [W/m²], ``temp_air`` [°C],
        ``wind_speed`` [m/s] and the sensors [°C].
    columns : iterable of str, optional
        The sensors; by default ``temp_module`` and all whose names begin so.
    criteria : Criteria, optional
        Thresholds other than the usual.

    Returns
    -------
    DataFrame
        A row for each sensor:

        ``share``: its over-temperature in sun over that of the others, before its
        step if it has one [-];
        ``offset``: what it reads more at no over-temperature [K];
        ``spread``: what is left beside both, root mean square in sun [K];
        ``step``: date from which its share is another, "" where none is found;
        ``change``, ``stderr``: by how much, as a share [-];
        ``rows``: number of its values;
        ``used``: whether it counts among the others;
        ``note``: why not, or what of it was left out.

    Raises
    ------
    ValueError
        If a column lacks, fewer than three sensors are there, or two at most can be
        used: of two no one says which is off.

    Notes
    -----
    A copy of another sensor, one that never moves and one with less than half of the
    values are told and not used, so that they spoil no mean. A step is looked for as in
    :func:`close_loop`, in over-temperatures in sun, and told from
    ``criteria.hint_gain`` on; the largest is taken out before the next is looked for,
    since it is in the median of the others. For a loop on the mean of all that are
    used give ``data.assign(temp_module=data[table.index[table["used"]]]
    .mean(axis=1, skipna=False))``.

    Examples
    --------
    >>> import pvlib_fem as fem
    >>> data = fem.datasets.synthetic(days=10, step=600)
    >>> for i, share in enumerate((1.0, 1.02, 0.9)):
    ...     over = data["temp_module"] - data["temp_air"]
    ...     data[f"temp_module_{i}"] = data["temp_air"] + share * over + 0.1 * i
    >>> fem.compare_modules(data[["poa_global", "temp_air", "wind_speed",
    ...     *(f"temp_module_{i}" for i in range(3))]])["share"].round(2).to_list()
    [1.04, 1.07, 0.89]
    """
    criteria = criteria or Criteria()
    found = with_aliases(data, needed=("poa_global", "temp_air", "wind_speed"))
    names = list(columns or (n for n in found if is_sensor(n)))
    if missing := [name for name in names if name not in found]:
        raise ValueError(
            f"data lack {', '.join(missing)}; they have {', '.join(found)}"
        )
    if len(names) < FEWEST:
        raise ValueError(
            f"{len(names)} module sensors are there ({', '.join(names)}), and at least "
            f"{FEWEST} are needed: of two no one says which is off"
        )
    usual = (found["poa_global"], found["temp_air"], found["wind_speed"])
    sensors, notes = clean(usual, {n: found[n] for n in names}, criteria)
    record = as_record(*usual, found[names[0]])
    off = {name for name, why in notes.items() if name not in sensors or why[0]}
    good = [name for name in names if name not in off]
    if len(good) < FEWEST:
        why = "; ".join(f"{n}: {notes[n][1]}" for n in names if n in off)
        raise ValueError(f"fewer than {FEWEST} module sensors can be used: {why}")
    steps, level = steps_of(record, sensors, good, criteria)
    rows = {}
    for name in names:
        rows[name] = {"used": name in good, "note": notes[name][1]}
        rows[name] |= {"rows": 0, "step": ""}
        if name in level:
            over, beside, (share, offset) = compared(record, name, level, good)
            rest = (over - share * beside)[np.isfinite(over)]
            spread = float(np.sqrt(np.mean(rest**2))) if len(rest) else np.nan
            row = {"share": share, "offset": offset, "spread": spread}
            row["rows"] = int(np.isfinite(sensors[name]).sum())
            rows[name] |= row | steps.get(name, {})
    table = pd.DataFrame.from_dict(rows, orient="index").reindex(columns=COLUMNS)
    return table.rename_axis("sensor")


def is_sensor(name):
    """Whether a column is the module's temperature, by its name."""
    return name == "temp_module" or twin_of(name) == "temp_module"


def clean(usual, sensors, criteria):
    """Values of each sensor that were measured, and whether and why one is not used."""
    found, notes = {}, {}
    for name, column in sensors.items():
        try:
            record = as_record(*usual, column)
            record, faults = screened(record, criteria.limits, check_units=False)
        except ValueError as error:
            notes[name] = True, str(error).replace("temp_module", name)
            continue
        found[name] = record["temp_module"]
        lines = [line for line in faults.notes if "temp_module" in line]
        notes[name] = False, "; ".join(lines).replace("temp_module", name)
    most = max((np.isfinite(one).sum() for one in found.values()), default=0)
    first = []
    for name, values in found.items():
        there = int(np.isfinite(values).sum())
        copies = [other for other in first if same(values, found[other])]
        if there < PRESENT * most:
            notes[name] = True, f"{there:,} values of {most:,} are there"
        elif copies:
            notes[name] = True, f"{name} is a copy of {copies[0]}"
        else:
            first.append(name)
    return found, notes


def compared(record, name, sensors, good):
    """
    Over-temperatures of a sensor less its offset, and of the others, with its line.

    By the row in sun, elsewhere NaN; share and offset are of days and nights.
    """
    air, poa, values = record["temp_air"], record["poa_global"], sensors[name]
    # NaN where one lacks: the median is of the same sensors at all times
    others = np.median([sensors[other] for other in good if other != name], axis=0)
    own, beside = values - air, others - air
    sunny = (poa > SUNNY) & np.isfinite(own + beside)
    known = sunny | (poa <= 0.0) & np.isfinite(own + beside)
    share = offset = np.nan
    if sunny.sum() >= FEWEST_ROWS:
        share, offset = np.polyfit(beside[known], own[known], 1).tolist()
    in_sun = (np.where(sunny, column, np.nan) for column in (own - offset, beside))
    return *in_sun, (share, offset)


def steps_of(record, sensors, good, criteria):
    """
    The step of each sensor that has one, and all sensors as they were before theirs.

    The largest is taken out before the next is looked for: it is in the others' median.
    """
    level, steps = dict(sensors), {}
    while True:
        found = {}
        for name in (n for n in level if n not in steps):
            over, beside, (share, _) = compared(record, name, level, good)
            found[name] = step_of(over, beside, share, record.dates, criteria)
        found = {name: step for name, step in found.items() if step}
        if not found:
            return steps, level
        first = max(found, key=lambda name: (name in good, abs(found[name]["change"])))
        step = steps[first] = found[first]
        later = record.dates >= number(step["step"])
        air = record["temp_air"]
        before = air + (level[first] - air) / (1.0 + step["change"])
        level[first] = np.where(later, before, level[first])


def step_of(over, beside, share, dates, criteria):
    """The date from which a sensor reads another share, and by how much, if any."""
    known = np.isfinite(over)
    if not known.any():
        return {}
    over, beside, dates = over[known], beside[known], dates[known]
    sums = cluster_sums([beside, beside], over - share * beside, dates)
    found = find_step(Daily.of(sums, 1, [0]), criteria)
    if found is None:
        return {}
    later = beside * (dates >= number(found["at"]))
    sums = cluster_sums([beside, later], over, dates)
    before, more = sums.solve([0, 1]) / sums.scale
    if abs(more) * sums.scale[1] < criteria.hint_gain:  # root mean square [K]
        return {}
    error = np.sqrt(sums.covariance([0, 1])[1, 1]) / sums.scale[1]
    sizes = float(more / before), float(error / before)
    return {"step": found["at"], "change": sizes[0], "stderr": sizes[1]}
