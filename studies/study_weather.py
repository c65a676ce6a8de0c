"""
What the loop says of measured weather with modules by models that it does not fit.

Run as
``python studies/study_weather.py [--out docs/study_weather.md]``.
Weather is that of both measured plants, in periods of two years. The module temperature
is computed from it, with causes that are known.
"""

import argparse
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
import pvlib
from pvlib.location import Location
from study_gate import Found
from study_instruments import SAME, changed
from study_page import publish
from study_records import sets

from pvlib_fem import close_loop, datasets
from pvlib_fem._parallel import spread

PLANTS = {"eurac_bolzano": range(2012, 2018, 2), "nrel_stf": range(2010, 2017, 2)}
YEARS = 2  # of a record
WEATHER = ["poa_global", "temp_air", "wind_speed", "wind_direction"]
KELVIN, SIGMA, EMISSIVITY = 273.15, 5.67e-8, 0.85
GLASS, CELLS = 6500.0, 5500.0  # heat capacity of each node [J/(m² K)]
BETWEEN = 180.0  # W/(m² K), through encapsulant and half of the glass
TAKEN = 0.03, 0.80  # share of the irradiance that heats glass and cells
NOISE, SLOW, MEMORY = 0.3, 0.12, 40.0  # K, K, and rows
STEP = 60.0  # s, of the two nodes
MOST_WRONG, LEAST_FOUND, MOST_MISLED = 0.003, 0.95, 0.03  # as in the gate


def two_nodes(weather):
    """
    Glass and cells of a module in W/m², in implicit steps of a minute.

    Convection on the glass is a power of the wind, the back has half of it, and the
    glass sees a clear sky by Swinbank (1963, :doi:`10.1002/qj.49708938105`), which
    clouds bring up to 60 % nearer to the air. Returns means over each row. [°C]
    """
    values = weather[WEATHER[:3]].to_numpy()
    seconds = pd.Series(weather.index).diff().median().total_seconds()
    many = max(int(seconds // STEP), 1)
    glass = cells = values[0, 1]
    cloud, found = 0.5, np.empty(len(values))
    for i, (light, air, wind) in enumerate(values):
        cloud += 0.1 * (1.0 - min(light / 900.0, 1.0) - cloud)
        front, back, sky = surroundings(air, wind, cloud)
        total = 0.0
        for _ in range(many):
            up, down = radiation(glass, sky), radiation(cells, air)
            # glass: a · T - BETWEEN · T_cells = p; cells: b · T - BETWEEN · T_glass = q
            a = GLASS / STEP + front + up + BETWEEN
            b = CELLS / STEP + back + down + BETWEEN
            p = GLASS / STEP * glass + TAKEN[0] * light + front * air + up * sky
            q = CELLS / STEP * cells + TAKEN[1] * light + (back + down) * air
            glass = (p * b + BETWEEN * q) / (a * b - BETWEEN**2)
            cells = (q + BETWEEN * glass) / b
            total += cells
        found[i] = total / many
    return found


def surroundings(air, wind, cloud):
    """Convection of front and back [W/(m² K)], and temperature of the sky [°C]."""
    front = 2.8 + 3.0 * wind**0.9
    clear = 0.0552 * (air + KELVIN) ** 1.5 - KELVIN
    return front, 1.6 + 0.55 * front, clear + (air - clear) * 0.6 * cloud


def radiation(one, other):
    """Exchange by radiation, linear about the mean temperature. [W/(m² K)]"""
    return 4.0 * EMISSIVITY * SIGMA * (0.5 * (one + other) + KELVIN) ** 3


def fuentes(weather):
    """pvlib's model by Fuentes, with a mass."""
    even = weather.set_axis(pd.date_range("2001", periods=len(weather), freq="h"))
    inputs = (even[name] for name in WEATHER[:3])
    return pvlib.temperature.fuentes(*inputs, noct_installed=46.0).to_numpy()


def sapm(weather):
    """pvlib's model by King: steady, with an exponential of the wind."""
    inputs = (weather[name] for name in WEATHER[:3])
    return pvlib.temperature.sapm_module(*inputs, a=-3.56, b=-0.075).to_numpy()


#: each module with the effects of the catalogue that it has
MODULES = {
    "two nodes": (
        two_nodes,
        {"sky_radiation", "radiative_loss", "thermal_storage", "wind_shape"},
    ),
    "fuentes": (
        fuentes,
        {"sky_radiation", "radiative_loss", "natural_convection", "wind_shape"},
    ),
    "sapm": (sapm, {"wind_shape"}),
}


@dataclass(frozen=True)
class Cause:
    """A change of an instrument, or heat that no effect of the catalogue brings."""

    name: str
    channel: str = ""  # of the instrument, as in the study of instruments
    course: str = ""
    size: float = 0.0
    heat: Callable | None = None  # of a record [K]
    light: float = 0.0  # that the modules receive from a date on, beyond the reading

    @property
    def unknown(self):
        """Whether it is outside the catalogue."""
        return self.heat is not None

    @property
    def truths(self):
        """Names that are right for it."""
        channels = SAME.get(self.channel, (self.channel,)) if self.channel else ()
        return frozenset(f"{name}_{self.course}" for name in channels)

    def done(self, data, after, some_days, lit):
        """
        The record with it; masks of rows from a date on, and of 100 days.

        ``lit`` is a function from a factor of the light to the module's temperature.
        """
        if self.light:
            return data.assign(temp_module=lit(1.0 + self.light * after))
        if self.unknown:
            return data.assign(temp_module=data["temp_module"] + self.heat(data))
        years = np.asarray((data.index - data.index[0]) / pd.Timedelta(days=365.25))
        weights = {"step": after, "episode": some_days, "drift": years}
        return changed(data, self.channel, self.size, weights.get(self.course))


def in_hours(data, first, last):
    return (data.index.hour >= first) & (data.index.hour < last)


def fan(data):
    on = in_hours(data, 9, 16) & (data.index.day_of_week < 5)
    return -0.2 * on * (data["temp_module"] - data["temp_air"])


CONTACT = "contact of the module sensor, 12 %"
CAUSES = (
    Cause("nothing"),
    Cause(f"{CONTACT}, from a date on", "module_sensor_contact", "step", 0.12),
    Cause(f"{CONTACT}, for 100 days", "module_sensor_contact", "episode", 0.12),
    Cause("irradiance sensor, −4 % a year", "irradiance_sensor", "drift", 0.04),
    Cause("irradiance sensor, −10 % from a date on", "irradiance_sensor", "step", 0.1),
    Cause("air temperature sensor, 2 K from a date on", "air_offset", "step", 2.0),
    Cause("anemometer, −30 % from a date on", "anemometer", "step", 0.3),
    Cause("a fan behind the modules on weekdays", heat=fan),
    Cause("2.5 K from 17 to 22 h", heat=lambda data: 2.5 * in_hours(data, 17, 22)),
    Cause(
        "light from a wall from 15 to 17 h",
        heat=lambda data: 0.003 * data["poa_global"] * in_hours(data, 15, 17),
    ),
    Cause("modules washed, +9 % light", "module_irradiance", "step", light=0.09),
)
CAUSES_WITH_TRUTH = {cause.name for cause in CAUSES if cause.truths}


def record(plant, year, module):
    """
    Weather of some years, with the temperature of a module and its noise.

    The last is a function from a factor of the light to that temperature.
    """
    data = datasets.load(plant)
    location = Location(*(data.attrs[n] for n in ("latitude", "longitude", "tz")))
    years = (data.index.year >= year) & (data.index.year < year + YEARS)
    data = data.loc[years, [name for name in WEATHER if name in data]]
    known = data.notna().all(axis=1)
    whole = data.interpolate().bfill()
    whole["wind_speed"] = whole["wind_speed"].clip(lower=0.0)
    random = np.random.default_rng([year, len(plant), len(module)])
    noise = NOISE * random.normal(size=len(data))
    slow = pd.Series(random.normal(size=len(data))).ewm(span=MEMORY).mean().to_numpy()
    noise = noise + SLOW / slow.std() * slow

    def lit(factor):
        light = whole.assign(poa_global=factor * whole["poa_global"])
        return np.where(known, MODULES[module][0](light) + noise, np.nan)

    return data.assign(temp_module=lit(1.0)), location, lit


def looked(plant, year, module):
    """What the loop says of one module in one weather, by each cause."""
    data, location, lit = record(plant, year, module)
    random = np.random.default_rng([year, len(plant), 1])
    return [row(data, location, lit, module, cause, random) for cause in CAUSES]


def row(data, location, lit, module, cause, random):
    """What the loop says of one cause."""
    first = data.index[int(len(data) * random.uniform(0.3, 0.6))].normalize()
    after = np.asarray(data.index >= first, dtype=float)
    some_days = after * (data.index < first + pd.Timedelta(days=100))
    changed_record = cause.done(data, after, some_days, lit)
    loop = close_loop(changed_record, location=location)
    known = MODULES[module][1] | cause.truths
    found = [Found(**one, known=known, unknown=cause.unknown) for one in sets(loop)]
    added = [one for one in loop.finding_objects if one.added]
    errors = loop.table["rmse_test"]
    return dict(
        module=module,
        cause=cause.name,
        wrong=any(one.wrong for one in found),
        misled=[one.effect for one in found if not one.right],
        sets=len(found),
        found=any(cause.truths & {*one.candidates} for one in added),
        before=float(errors["fem"]),
        after=float(errors[loop.last]),
        patterns=float(errors.iloc[-1]),
    )


INTRO = """\
# Measured weather, and modules by other models

Other studies simulate the weather. This one takes irradiance, air temperature and wind
as they were measured at the plants of {{doc}}`guide/public_records`, in {periods}
periods of two years, with the gaps and faults that they have. The module temperature is
computed from them by three models, none of which the loop fits: glass and cells as two
nodes with a sky that clouds warm, pvlib's `fuentes`, and pvlib's `sapm_module`. It has
noise of {noise:g} K from hour to hour and {slow:g} K from day to day.

A name is wrong if neither the cause nor the model of the module has that effect.
*Found* is a change of an instrument that is in the set of a finding. No threshold was
set on these records.
"""

OUTRO = """
*Before*, *after* and *with patterns* are medians of the RMSE on test weeks: of the
paper's form, of the model with all findings, and of predictions that have the
unexplained patterns, too. Records of one period and module share weather and noise, so
that a set of the physics comes back with most causes.
"""


def counted(rows, key):
    """A line of the table for each value of a column."""
    for name, some in rows.groupby(key, sort=False):
        truth = CAUSES_WITH_TRUTH & {*some["cause"]}
        of_truth = some[some["cause"].isin(truth)]
        cells = (
            str(len(some)),
            str(int(some["wrong"].sum())),
            f"{len(some['misled'].sum())} of {int(some['sets'].sum())}",
            f"{int(of_truth['found'].sum())} of {len(of_truth)}" if truth else "–",
            f"{some['before'].median():.2f}",
            f"{some['after'].median():.2f}",
            f"{some['patterns'].median():.2f}",
        )
        yield f"| {name} | {' | '.join(cells)} |"


def page(rows, periods):
    """The page, as Markdown."""
    yield INTRO.format(periods=periods, noise=NOISE, slow=SLOW)
    head = "records | wrong names | sets without the truth | found"
    head += " | K before | K after | K with patterns"
    for key in ("cause", "module"):
        yield f"| {key} | {head} |"
        yield "|---" * 8 + "|"
        yield from counted(rows, key)
        yield ""
    some = rows[rows["cause"].isin(CAUSES_WITH_TRUTH)]
    wrong, found = int(rows["wrong"].sum()), int(some["found"].sum())
    firsts = Counter(rows["misled"].sum())
    misled, every = firsts.total(), int(rows["sets"].sum())
    names = ", ".join(f"`{name}` {count}" for name, count in firsts.most_common())
    met = {True: "met", False: "**missed**"}
    yield (
        f"* A name is wrong in {wrong} of {len(rows)} records (at most "
        f"{MOST_WRONG:.1%}: {met[wrong <= MOST_WRONG * len(rows)]}).\n"
        f"* A change of an instrument is in a set in {found} of {len(some)} (at least "
        f"{LEAST_FOUND:.0%}: {met[found >= LEAST_FOUND * len(some)]}).\n"
        f"* Sets without the truth are {misled} of {every} ({misled / every:.1%}; at "
        f"most {MOST_MISLED:.0%}: {met[misled <= MOST_MISLED * every]}). Their most "
        f"probable causes, with the number of sets: {names or 'none'}."
    )
    yield OUTRO.rstrip("\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, help="Markdown; standard output if none")
    parser.add_argument("--processes", type=int, default=2)
    options = parser.parse_args()
    periods = [(plant, year) for plant, years in PLANTS.items() for year in years]
    tasks = [(*one, module) for one in periods for module in MODULES]
    rows = [row for some in spread(looked, tasks, options.processes) for row in some]
    text = "\n".join(page(pd.DataFrame(rows), len(periods)))
    publish(text, options.out, "make study-weather")


if __name__ == "__main__":
    main()
