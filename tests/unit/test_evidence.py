"""Each finding has a picture of measured columns that shows it."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from conftest import COLUMNS
from pvlib.location import Location
from test_corrected import effect_of, faulty, found, sound, true  # noqa: F401 (fixtures)
from test_instruments import DATES

import pvlib_fem as fem
from pvlib_fem import simulator
from pvlib_fem._findings import Finding, Verdict
from pvlib_fem._report import evidence
from pvlib_fem._report.clocks import picture_of_clock
from pvlib_fem._report.rows import Rows
from pvlib_fem._report.shown import NONE, findings_with_pictures
from pvlib_fem.effects import EFFECTS
from pvlib_fem.reasons import Reason, because

AT = pd.Timestamp(DATES["step"]["at"])


def pictures(loop, data, effect):
    """Pictures of a fault that the loop has found in these data."""
    loop = found(loop, data, effect)
    record = loop.fit.record
    more = {n: data[n].to_numpy() for n in data if n not in record.inputs.columns}
    loop = replace(loop, fit=replace(loop.fit, record=record.having(more)))
    return evidence.pictures_of(loop.finding_objects[0], loop)


def before_after(daily):
    """Medians of the days before the step and after."""
    later = daily.days >= AT
    return np.median(daily.values[~later]), np.median(daily.values[later])


def ratio(daily):
    before, after = before_after(daily)
    return after / before


def test_a_second_irradiance_shows_what_the_first_reads_less(true, sound):  # noqa: F811
    effect = effect_of("irradiance_sensor_step")
    data = faulty(true, effect, 0.25).assign(poa_global_2=true["poa_global"])
    (one,) = pictures(sound, data, effect)
    series, words, marks = one.draw.args
    assert ratio(series["poa_global_2"]) == pytest.approx(1 / 1.25, rel=1e-6)
    assert marks.lines == (DATES["step"]["at"],) and "[-]" in words
    assert "dashed: dates of the finding" in one.words


def test_the_wind_before_and_after_has_the_share_that_is_lost(true, sound):  # noqa: F811
    effect = effect_of("anemometer_step")
    data = faulty(true, effect, 1.0)
    both, by_date = pictures(sound, data, effect)
    before, after = both.draw.args[0].values()
    wind = true["wind_speed"]
    assert before.mean() == pytest.approx(wind[wind.index < AT].mean())
    assert after.mean() == pytest.approx(wind[wind.index >= AT].mean() / 2)
    assert ratio(by_date.draw.args[0]["wind"]) == pytest.approx(0.5, abs=0.1)


@pytest.mark.parametrize(
    "name, size, twin",
    [("air_offset_step", 2.0, "temp_air"), ("module_offset_step", 2.0, "temp_module")],
)
def test_a_second_thermometer_shows_what_the_first_reads_colder(
    true,  # noqa: F811
    sound,  # noqa: F811
    name,
    size,
    twin,
):
    effect = effect_of(name)
    data = faulty(true, effect, size).assign(**{f"{twin}_2": true[twin]})
    first, night = pictures(sound, data, effect)
    apart = np.diff(before_after(first.draw.args[0][f"{twin}_2"]))
    assert apart == pytest.approx(-size, abs=1e-6)
    way = 1.0 if twin == "temp_air" else -1.0  # module minus air
    apart = np.diff(before_after(night.draw.args[0]["night"]))
    assert apart == pytest.approx(way * size, abs=0.4)


def test_a_detached_sensor_shows_less_of_the_temperature_rise(true, sound):  # noqa: F811
    effect = effect_of("module_sensor_contact_step")
    (rise,) = pictures(sound, faulty(true, effect, 1.0), effect)
    assert ratio(rise.draw.args[0]["rise"]) == pytest.approx(0.5, abs=0.05)


@pytest.mark.parametrize("hours", [1, -2])
def test_the_clock_of_the_module_is_shown_by_date(hours):
    """Each day it is that much later in the file than after the correction."""
    data = simulator.record(days=60, step=1800.0, start="2023-05-01")
    data["temp_module"] = data["temp_module"].shift(2 * hours)
    loop = fem.close_loop(data[list(COLUMNS)].dropna(), effects=[])
    (correction,) = loop.corrections
    series = picture_of_clock(correction, loop).draw.args[0]
    late = series["as in the file"].values - series["corrected"].values
    np.testing.assert_allclose(late, 60.0 * hours, atol=1e-6)
    assert 0.0 < np.median(series["corrected"].values) < 25.0


def test_the_noon_of_a_file_in_summer_time_jumps_by_an_hour():
    site = simulator.RHINE
    where = Location(site.latitude, site.longitude, tz="Europe/Berlin")
    data = simulator.record(days=150, step=1800.0, start="2023-01-15")
    data = data[list(COLUMNS)]
    wall = data.index.tz_convert("Europe/Berlin").tz_localize(None)
    data = data.set_axis(wall)[~wall.duplicated()]
    loop = fem.close_loop(data, location=where, effects=[])
    (correction,) = loop.corrections
    series = picture_of_clock(correction, loop).draw.args[0]
    file, right = series["as in the file"], series["corrected"]
    summer = file.days > "2023-03-27"
    assert np.median((file.values - right.values)[summer]) == pytest.approx(60.0)
    assert np.median((file.values - right.values)[~summer]) == pytest.approx(0.0)
    assert abs(np.median(right.values)) < 20.0


def test_contributions_are_drawn_at_times_that_are_corrected_once():
    """Corrected twice, the last hour of a file that ends late would come twice."""
    site = simulator.RHINE
    where = Location(site.latitude, site.longitude, tz=site.tz)
    data = simulator.record(days=150, step=3600.0, start="2023-03-15")[list(COLUMNS)]
    late = data.index >= data.index[24 * 70]
    index = data.index.where(~late, data.index - pd.Timedelta(hours=1))
    data = data.set_axis(index)[~index.duplicated()]
    loop = fem.close_loop(data, location=where, effects=["radiative_loss"])
    (correction,) = loop.corrections
    assert correction.applied and loop.fit.effects
    assert "Contribution of each effect" in loop.to_html()


@pytest.mark.parametrize("name", sorted(EFFECTS))
def test_every_effect_has_pictures_or_a_sentence(true, sound, name):  # noqa: F811
    """Whatever columns there are; never an error, never an empty card."""
    why = because(Reason.GAINED, gain=1.0)
    finding = Finding(name, (name,), Verdict.IDENTIFIED, 1.0, {}, {}, why)
    fit = fem.fit_fem(
        *(true[n] for n in COLUMNS), model="faiman", dynamics="balance", night=True
    )
    where = Location(49.0, 8.4, tz="Etc/GMT-1")
    place = {"location": where, "surface_tilt": 35.0, "surface_azimuth": 180.0}
    loop = replace(sound, fit=fit, finding_objects=(finding,), place=place)
    loop = replace(loop, residual_before=fit.residual)
    (one,) = findings_with_pictures(loop, loop.statements)
    assert one.pictures or one.note == NONE
    for svg, words in one.pictures:
        assert svg.startswith("<svg") and words.endswith(".")


def test_a_loop_of_a_file_says_that_it_has_no_rows(true, sound, tmp_path):  # noqa: F811
    effect = effect_of("anemometer_step")
    loop = found(sound, faulty(true, effect, 1.0), effect)
    loop.to_json(path := tmp_path / "loop.json")
    html = fem.Loop.from_json(path).to_html()
    assert "<figure" not in html and "has no rows to draw" in html


def test_days_with_few_rows_are_left_out(true, sound):  # noqa: F811
    rows = Rows(replace(sound, fit=fit_of(true)))
    every = np.ones(len(true), dtype=bool)
    every[5:48] = False  # five rows of the first day
    daily = rows.daily(every, np.ones(len(true)))
    assert daily.days[0] == true.index[48].normalize()
    assert (daily.values == 1.0).all()


def fit_of(data):
    return fem.fit_fem(*(data[n] for n in COLUMNS), model="ross", night=True)
