"""What the loop finds in two measured records of years, and the pages that tell it."""

import runpy
import warnings
from pathlib import Path

import numpy as np
import pandas as pd
import pvlib
import pytest
from pvlib.location import Location
from study_measured import summary_of

import pvlib_fem as fem
from pvlib_fem._findings import CheckOutcome, Verdict
from pvlib_fem._loop.references.power_events import BY_POWER

ROOT = Path(__file__).parents[2]


def closed(data):
    site = [data.attrs[name] for name in ("latitude", "longitude", "tz")]
    return fem.close_loop(data, location=Location(*site))


@pytest.fixture(scope="module")
def at_bolzano(bolzano):
    return closed(bolzano)


@pytest.fixture(scope="module")
def at_golden(golden):
    return closed(golden)


def words(path):
    """The text of a file, each run of white space one blank."""
    return " ".join((ROOT / path).read_text(encoding="utf-8").split())


def question(page):
    """What stands above a page of the gallery."""
    return words(f"gallery/{page}.py").split('"""')[1]


def over_temperature(data):
    """Measured over modelled by pvlib's defaults, in sun."""
    sunny = data[data["poa_global"] > 300.0]
    usual = [sunny[name] for name in ("poa_global", "temp_air", "wind_speed")]
    expected = pvlib.temperature.faiman(*usual) - sunny["temp_air"]
    return (sunny["temp_module"] - sunny["temp_air"]) / expected


def test_at_bolzano_power_speaks_for_the_irradiance_sensor(at_bolzano):
    first = next(f for f in at_bolzano.finding_objects if f.cross_checks)
    assert "irradiance_sensor_step" not in first.candidates
    assert {"module_sensor_contact_step", "mounting_step"} <= {*first.candidates}
    said = {(one.column, one.effect): one.outcome for one in first.cross_checks}
    powers = "power_dc", "power_ac"
    sensors = [(name, "irradiance_sensor_step") for name in (*powers, "clear sky")]
    against = [*sensors, ("usual wind", "anemometer_step")]
    # modules of one face may have more light that power does not show
    either = [(name, "module_irradiance_step") for name in powers]
    assert said == {
        **dict.fromkeys(against, CheckOutcome.CONTRADICTS),
        **dict.fromkeys(either, CheckOutcome.CANNOT_TELL),
    }
    # of the fifth that came with the step nothing else in the record is known
    assert 0.0 < first.probabilities["outside"] < 0.15


def test_at_bolzano_other_weeks_say_the_same(at_bolzano):
    nine = summary_of("eurac_bolzano", 2)
    assert nine.names == {
        (str(one.verdict), frozenset(one.candidates))
        for one in at_bolzano.finding_objects
        if one.added
    }


def drift_of(loop):
    return next(
        f for f in loop.finding_objects if f.effect == "irradiance_sensor_drift"
    )


def test_at_golden_the_irradiance_sensor_is_named(at_golden):
    """By 1.5 to 2.1 % a year: power, a clear sky and a modelled irradiance agree."""
    first = drift_of(at_golden)
    assert first.verdict is Verdict.IDENTIFIED
    (rate,) = first.coefficients.values()
    assert 0.015 < rate < 0.021
    agreeing = {
        o.column for o in first.cross_checks if o.outcome is CheckOutcome.AGREES
    }
    assert agreeing >= {"power_ac", "clear sky"}
    assert CheckOutcome.CONTRADICTS not in {o.outcome for o in first.cross_checks}
    (sky,) = (one for one in first.cross_checks if one.column == "clear sky")
    assert sky.size == pytest.approx(0.0185, abs=0.002) and 0.002 < sky.stderr < 0.005
    assert isinstance(at_golden.residual_before, pd.Series)


def test_at_golden_an_anemometer_that_reads_nothing_for_weeks_is_said(at_golden):
    """By day alone the record has some 15 h a day; a calm of three days is none."""
    (note,) = (n for n in at_golden.notes if "wind_speed is stuck" in n)
    assert "wind_speed is stuck at 0 from 2017-05-08 14:00:00 on, 346 rows" in note


def test_the_readme_opens_with_what_the_loop_says_of_bolzano(at_bolzano, bolzano):
    text = words("README.md")
    (clock,) = at_bolzano.corrections
    assert "16 changes" in clock.why and "changes 16 times with summer time" in text
    assert "from 2018-06-21 until 2018-07-01" in clock.why
    step, sky = at_bolzano.finding_objects[:2]
    its = next(e for e in at_bolzano.fit.effects if e.name == step.effect).settings
    low, high = its["between"]
    assert f"From {its['at']} ({low} to {high}) on, over-temperature per" in text
    share = over_temperature(bolzano)
    before, after = share["2011-04":"2012-03"], share["2012-04":"2013-03"]
    assert after.median() / before.median() == pytest.approx(1.2, abs=0.02)
    by_dc = (one for one in step.cross_checks if one.column == "power_dc")
    (check,) = (one for one in by_dc if one.effect == "irradiance_sensor_step")
    expected = check.in_words(check.reading(check.expected))
    words_of = (
        f"by power the sensor reads {check.reads} where {expected} would be needed."
    )
    assert words_of in text
    kinds = {name.rsplit("_", 1)[0] for name in step.candidates}
    assert step.verdict is Verdict.AMBIGUOUS
    causes = {"module_sensor_contact", "mounting", "air_sensor_shield"}
    assert kinds == causes | {"module_irradiance"}
    place = at_bolzano.place
    angles = [f"{place[n]:.0f} ± 5°" for n in ("surface_tilt", "surface_azimuth")]
    assert f"clear days have them at {angles[0]} and {angles[1]}" in text
    assert "ten draws of ten" in text
    assert (sky.effect, sky.verdict) == ("sky_radiation", Verdict.AMBIGUOUS)
    errors = at_bolzano.table["rmse_test"]
    paper, causes, last = errors["fem"], errors[at_bolzano.last], errors["+patterns"]
    words_of = (
        f"the paper's form leaves {paper:.2f} K, these causes {causes:.2f} K, and"
    )
    assert f"{words_of} {last:.2f} K with errors that repeat." in text
    study = words("docs/study_measured.md")
    # of causes that are as probable, any may be the first
    for finding in (step, sky):
        rows = (f"| `{name}` | 10 | 10 |" for name in finding.candidates)
        assert any(row in study for row in rows)


def test_the_page_of_bolzano_has_the_numbers_of_the_loop(at_bolzano, bolzano):
    text = question("16_eight_years_at_bolzano")
    before, after = at_bolzano.table["rmse_test"].loc[["fem", at_bolzano.last]]
    assert f"from {before:.2f} K to {after:.2f} K" in text
    assert "On 29 March 2012" in text
    page = words("gallery/16_eight_years_at_bolzano.py")
    share = over_temperature(bolzano)
    parts = share["2011-04":"2012-03"].median(), share["2012-04":"2013-03"].median()
    assert f"are near {parts[0]:.2f}, the year" in page
    assert f"on is near {parts[1]:.2f}." in page


def test_the_page_of_golden_has_the_numbers_of_the_loop(at_golden, golden):
    text = question("17_a_pyranometer_that_fades")
    first = drift_of(at_golden)
    (rate,), (error,) = first.coefficients.values(), first.stderr.values()
    assert f"{100 * rate:.1f} ± {100 * error:.1f} % a year" in text
    drifts = {
        one.column: f"{100 * one.size:.1f}"
        for one in first.cross_checks
        if one.effect == first.effect
    }
    told = "power by {power_ac}, a modelled irradiance by {poa_modelled} and a second "
    assert told.format(**drifts) + f"plane by {drifts['poa_global_2']} %" in text
    assert f"a clear sky by {drifts['clear sky']} % a year" in text
    before, after = at_golden.table["rmse_test"].loc[["fem", at_golden.last]]
    assert f"from {before:.2f} K to {after:.2f} K" in text
    page, share = (
        words("gallery/17_a_pyranometer_that_fades.py"),
        over_temperature(golden),
    )
    days = [
        share[f"{year}-04-14" : f"{year}-05-20"].median() for year in (2012, 2013, 2014)
    ]
    assert days[1] / np.mean(days[::2]) == pytest.approx(7 / 6, abs=0.02)
    assert "heats the modules, by about a sixth" in page
    fed = golden["power_ac"] > 0.0
    assert fed["2013-04-14":"2013-05-20"].mean() < 0.02 < fed["2012"].mean()
    calm = golden.loc["2017-05-09":"2017-05-31", "wind_speed"]
    assert (calm.dropna() == 0.0).all() and calm.notna().sum() > 300


def signed(number):
    """A number as a page has it: +0.5, −0.4, and plain 0.0."""
    return "0.0" if abs(number) < 0.05 else f"{number:+.1f}".replace("-", "−")


def around_zero(found, unit=" % a year"):
    """A rate that may be a gain or a loss, and its interval."""
    rate, low, high = map(signed, found)
    return f"{rate}{unit} ({low} to {high})"


def of_size(found, unit=" % a year"):
    """A rate of known direction, and its interval, from small to large."""
    rate, *ends = map(abs, found)
    return f"{rate:.1f}{unit} ({min(ends):.1f} to {max(ends):.1f})"


def test_the_page_of_a_loss_rate_has_the_numbers_that_it_makes(golden):
    pytest.importorskip("rdtools")
    name = "18_a_loss_rate_and_its_pyranometer"
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # those of RdTools
        made = runpy.run_path(str(ROOT / "gallery" / f"{name}.py"))
    head = question(name)
    text = " ".join(words(f"gallery/{name}.py").replace("# ", "").split())
    rates = made["rates"]
    raw, sound, sky, sky_sound = rates.values()
    # what the two ways change the rate by agrees within the error
    by_sensor, by_sky = raw[0] - sound[0], raw[0] - sky[0]
    half = 0.5 * (sky[2] - sky[1])
    assert abs(by_sensor - by_sky) < half
    for one in (sky, sky_sound):
        assert one[1] < sound[0] < one[2]
    fading = made["fading"]
    assert fading.column == "poa_global" and fading.applied
    assert f"gains {raw[0]:.1f} % a year" in head
    assert f"fades by {100 * fading.size:.1f} % a year" in head
    assert f"irradiance the rate is {signed(sound[0])} % a year" in head
    assert f"says {signed(sky[0])} ± {half:.1f} % a year" in head
    assert f"gains {of_size(raw)}" in text
    assert f"corrected sensor the rate is {around_zero(sound)}" in text
    assert f"correction changes the rate by {by_sensor:.1f} % a year" in text
    assert f"workflow gives {around_zero(sky)} with the sensor" in text
    assert f"and {around_zero(sky_sound, '')} with the corrected one" in text
    assert f"it changes the rate by {by_sky:.1f} % a year" in text
    assert f"changes differ by {by_sensor - by_sky:.1f} % a year" in text
    low, high = 100 * fading.low, 100 * fading.high
    assert f"range of {low:.1f} to {high:.1f} % a year" in text
    assert f"standard error of {100 * fading.stderr:.2f} % a year" in text
    ends = made["ends"]
    told = f"between {signed(ends['high'])} and {signed(ends['low'])} % a year"
    assert told in text
    by_end, by_begin = (
        [made["others"][name, sensor] for sensor in ("as measured", "corrected")]
        for name in ("end", "begin")
    )
    assert f"their end, the clear-sky workflow gives {around_zero(by_end[0])}" in text
    assert f"and {around_zero(by_end[1], '')} with the corrected one" in text
    begin = [around_zero(one, "") for one in by_begin]
    assert f"named by their begin {' and '.join(begin)}" in text
    assert f"worth up to {by_begin[0][0] - by_begin[1][0]:.1f} % a year" in text
    for _, low, high in (by_end[1], by_begin[1]):
        assert low < sound[0] < high
    late = [of_size(one, "") for one in made["late_years"].values()]
    first = of_size(made["late_years"]["sensor, as measured"])
    assert f"shows a gain of {first}, the corrected one a loss of {late[1]}," in text
    assert f"a loss of {late[2]} or, with the corrected sensor, of {late[3]}" in text
    sweep = made["sweep"]
    assert f"into a gain of {sweep['rate'][-0.8]:.1f}." in text
    assert f"it is a gain of {sweep['rate'][-3.0]:.1f}, more" in text
    wide = sweep["to"] - sweep["from"]
    assert wide.max() < 1.2 * wide[0.0]
    read = 1.0 - 0.03 * made["years"][-1]
    assert read == pytest.approx(0.75, abs=0.02)


def test_at_golden_the_drift_is_the_same_without_power(at_golden, golden):
    """A loss rate of the plant need not rest on its own power."""
    loop = closed(golden.drop(columns="power_ac"))
    (one,) = (f for f in loop.finding_objects if f.added)
    assert one.effect == "irradiance_sensor_drift" and one.verdict is Verdict.IDENTIFIED
    (rate,), (other,) = (f.coefficients.values() for f in (one, drift_of(at_golden)))
    (error,) = one.stderr.values()
    assert abs(rate - other) < 2.0 * error


def test_at_golden_power_shows_snow_and_outages(at_golden):
    """Snow, by its dates in cold air; the outage of spring 2013, by its own."""
    snow, off = (
        at_golden.events[at_golden.events["effect"] == kind]
        for kind in ("modules_covered", "outage")
    )
    # the smaller ones are hours after sunrise, too, when light is uneven
    assert (snow["temp_air"].head(80) < 5.0).mean() > 0.8
    assert (snow["size"] < 0.0).mean() > 0.99  # of one on frozen modules it is not
    days = {f"{start:%Y-%m-%d}" for start in snow["start"]}
    assert {"2012-02-23", "2014-02-03", "2012-11-11", "2014-12-15"} <= days
    stood = off[(off["start"] >= "2013-04-14") & (off["end"] <= "2013-05-22")]
    assert stood["hours"].sum() > 300
    assert len(snow) > 80
    found = next(f for f in at_golden.finding_objects if f.effect == "modules_covered")
    assert found.added and 0.5 < found.coefficients["modules_covered.share"] < 1.0


def test_at_bolzano_few_events_leave_the_loop_as_it_was(at_bolzano, bolzano):
    assert not {*BY_POWER} & {*at_bolzano.effects}
    low = at_bolzano.events["effect"] == "underperformance"
    assert (~low).sum() < 5 * 8  # years
    # in the afternoons of December modules without the sensor are in the shade
    start = at_bolzano.events["start"][low]
    shade = (start.dt.month == 12) & (start.dt.hour == 14)
    assert shade.sum() > 60 and shade.mean() > 0.7
    without = closed(bolzano.drop(columns=["power_dc", "power_ac"]))
    before, after = (loop.table["rmse_test"].iloc[-1] for loop in (without, at_bolzano))
    assert after == pytest.approx(before, abs=0.02)
