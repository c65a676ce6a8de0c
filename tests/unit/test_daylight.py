"""A file in summer time is distinguished from others, and set to standard time."""

import numpy as np
import pandas as pd
import pytest
from conftest import COLUMNS, measured
from pvlib.location import Location

from pvlib_fem import close_loop, simulator
from pvlib_fem.quality._daylight import daylight_saving
from pvlib_fem.quality._irradiance_clock import twin_clock
from pvlib_fem.quality._noon import solar_noon_shift
from pvlib_fem.simulator import RHINE, Site

SYDNEY = Site(-33.9, 151.2, surface_azimuth=0.0)
DENVER = Site(39.7, -105.0)
ZONES = {
    "Europe/Berlin": RHINE,
    "Australia/Sydney": SYDNEY,
    "America/Denver": DENVER,
}
LATITUDES = (
    *(-54.8, -41.3, -29.1, -12.0, 0.3, 18.5, 30.1, 37.4, 42.7, 47.2, 51.1, 53.4),
    *(56.9, 59.3, 61.5, 64.1, 67.9, 69.7, 72.0, 78.2),
)
#: from the equator to beyond both polar circles; none of them keeps summer time
SITES = [
    Site(latitude, longitude, 30.0, 180.0 if latitude >= 0 else 0.0)
    for latitude, longitude in zip(LATITUDES, range(-170, 190, 18))
]


@pytest.fixture(scope="module")
def years():
    """A year of each place in its standard time, without a zone."""
    return {
        zone: simulator.record(site, {}, 365, 600.0, 3).tz_localize(None)
        for zone, site in ZONES.items()
    }


def by_the_wall(data, zone):
    """A logger that keeps a zone's clock: one hour is missing, one comes twice."""
    aware = data.tz_localize(ZONES[zone].tz).tz_convert(zone)
    return aware.tz_localize(None)


def once(data):
    """The file of a data base, in which each time comes once."""
    return data[~data.index.duplicated()]


def place(zone, tz=None):
    site = ZONES[zone]
    location = Location(site.latitude, site.longitude, tz=tz or zone)
    return location, site.surface_tilt, site.surface_azimuth


def judged(data, zone, tz=None):
    where = place(zone, tz)
    poa, index = data["poa_global"].to_numpy(), data.index
    noon = solar_noon_shift(poa, index, *where)
    return daylight_saving(poa, index, noon, *where)


@pytest.mark.parametrize("zone", ZONES)
def test_a_file_with_the_doubled_hour_comes_back_exactly(years, zone):
    wall = by_the_wall(years[zone], zone)
    found = judged(wall, zone)
    assert found.explained and found.zone == zone
    assert found.kept.all()
    pd.testing.assert_frame_equal(
        found.corrected(wall), years[zone], check_freq=False, check_index_type=False
    )


@pytest.mark.parametrize("zone", ZONES)
def test_an_hour_that_is_there_once_is_left_out_and_counted(years, zone):
    """Which of two hours it was is not known; every other row is right."""
    wall = once(by_the_wall(years[zone], zone))
    found = judged(wall, zone)
    corrected = found.corrected(wall)
    assert (~found.kept).sum() == 6
    assert "6 rows around the changes have no sure time" in found.line
    assert corrected.index.is_monotonic_increasing
    expected = years[zone].loc[corrected.index]
    pd.testing.assert_frame_equal(
        corrected, expected, check_freq=False, check_index_type=False
    )


@pytest.mark.parametrize("zone", ZONES)
def test_the_sun_is_where_it_should_be_afterwards(years, zone):
    found = judged(once(by_the_wall(years[zone], zone)), zone)
    right = solar_noon_shift(
        years[zone]["poa_global"].to_numpy(), years[zone].index, *place(zone)
    )
    assert found.after == pytest.approx(np.sqrt(np.mean(right.days**2)) / 60, abs=0.5)
    # an hour for more than half of the year
    assert found.before > 60 * np.sqrt(0.5)
    assert f"{found.after:.0f} min off the sun" in found.line
    assert f"was {found.before:.0f}" in found.line


def test_an_even_file_loses_the_hour_that_no_clock_shows():
    """The simulator's file has a row every 10 min, as some loggers' exports do."""
    data = simulator.record(RHINE, {"file_dst": 1.0}, 365, 600.0, 3)
    found = judged(data, "Europe/Berlin")
    assert found.explained
    assert str(found.index.tz) == RHINE.tz
    assert (~found.kept).sum() == 12
    assert found.after < 0.5 * found.before
    poa = data["poa_global"].to_numpy()[found.kept]
    assert solar_noon_shift(poa, found.index, *place("Europe/Berlin")).faults == {}


def test_several_years_have_two_jumps_each():
    data = simulator.record(RHINE, {}, 800, 1800.0, 3).tz_localize(None)
    found = judged(by_the_wall(data, "Europe/Berlin"), "Europe/Berlin")
    assert [by for _, by in found.transitions] == [3600.0, -3600.0] * 2
    dates = [str(time) for time, _ in found.transitions]
    # at one o'clock of universal time, which is two by standard time in Berlin
    assert dates[:2] == ["2023-03-26 02:00:00", "2023-10-29 02:00:00"]
    assert found.kept.all()


@pytest.mark.parametrize("tz", ["UTC", "Etc/GMT-1"])
def test_the_zone_is_found_from_the_place_where_none_is_given(years, tz):
    wall = by_the_wall(years["Europe/Berlin"], "Europe/Berlin")
    found, known = (judged(wall, "Europe/Berlin", tz) for tz in (tz, None))
    assert found.zone.startswith("Europe/")
    assert found.transitions == known.transitions
    pd.testing.assert_index_equal(found.index, known.index)


def test_a_file_without_a_jump_is_left_as_it_is(years):
    wall = once(by_the_wall(years["Europe/Berlin"], "Europe/Berlin"))
    wall = wall["2023-04-10":"2023-10-10"]
    found = judged(wall, "Europe/Berlin")
    assert not found.explained and "no jump of the light was found" in found.line
    assert found.corrected(wall).equals(wall)


def same_air(found, wall, right):
    """Each row that is kept holds what was measured at its time."""
    back = found.corrected(wall)["temp_air"]
    return np.array_equal(back, right["temp_air"].reindex(back.index))


def test_another_zone_does_not_keep_the_light_from_setting_it_right(years):
    """Its dates are not those of the file; the times around them are not sure."""
    wall = once(by_the_wall(years["Europe/Berlin"], "Europe/Berlin"))
    found = judged(wall, "Europe/Berlin", "America/Denver")
    assert (found.zone, found.fault) == ("", "file_jump")
    assert "the day's light moves on none of its dates" in found.line
    assert same_air(found, wall, years["Europe/Berlin"])


def test_a_transition_that_the_light_does_not_show_is_said(years):
    """Two years, of which the file keeps summer time in the first alone."""
    data = simulator.record(RHINE, {}, 730, 1800.0, 3).tz_localize(None)
    first = once(by_the_wall(data[:"2023"], "Europe/Berlin"))
    both = pd.concat((first, data["2024":].loc["2024-01-01 02:00":]))
    found = judged(both, "Europe/Berlin")
    assert (found.zone, found.fault) == ("", "file_jump")
    assert "has +60 min on 2024-03-31, -60 min on 2024-10-27" in found.line
    assert "the day's light does not move then" in found.line
    assert same_air(found, both, data)


# a clock that was set


def set_on(data, day, minutes):
    """What a logger writes whose clock is set at noon of a day, each time once."""
    at = data.index.searchsorted(pd.Timestamp(day) + pd.Timedelta(hours=12))
    by = pd.to_timedelta(np.where(np.arange(len(data)) < at, 0, minutes), unit="min")
    written = data.set_axis(data.index + by)
    first = written.index.to_series().cummax().shift()
    return written[~(written.index <= first)]


@pytest.mark.parametrize("minutes", [60, -120, 37])
@pytest.mark.parametrize(("step", "slack"), [(300.0, 4), (3600.0, 8)])
def test_one_jump_is_a_clock_that_was_set(minutes, step, slack):
    data = simulator.record(RHINE, {}, 100, step, 5, start="2023-04-10")
    data = data.tz_localize(None)
    wall = set_on(data, "2023-05-30", minutes)
    where = place("Europe/Berlin")
    noon = solar_noon_shift(wall["poa_global"].to_numpy(), wall.index, *where)
    assert list(noon.faults) == ["file_jump"]
    ((day, by),) = noon.jumps
    assert abs(day - pd.Timestamp("2023-05-30")) <= pd.Timedelta("2D")
    assert by / 60 == pytest.approx(minutes, abs=0 if minutes % 60 == 0 else slack)
    assert "the clock of the file was set then" in noon.faults["file_jump"]
    assert "daylight" not in noon.faults["file_jump"]
    found = judged(wall, "Europe/Berlin")
    assert (found.zone, found.fault, found.jumps_kept) == ("", "file_jump", ())
    assert found.after < 15 < found.before
    assert found.index.is_monotonic_increasing
    # all but the days around it are there
    assert len(data) - found.kept.sum() < 6 * 86400 / step
    if minutes % 60 == 0:
        assert same_air(found, wall, data)


def test_ten_days_by_another_clock_leave_all_other_changes_corrected():
    """As at Bolzano: there and back within days are two jumps, not one."""
    data = simulator.record(RHINE, {}, 365, 3600.0, 3).tz_localize(None)
    moved = (data.index >= "2023-06-21") & (data.index < "2023-07-01")
    late = data.set_axis(data.index + pd.to_timedelta(np.where(moved, 1, 0), unit="h"))
    late = late[~late.index.duplicated()]
    wall = by_the_wall(late, "Europe/Berlin")
    found = judged(wall, "Europe/Berlin")
    assert (found.zone, found.fault) == ("Europe/Berlin", "file_dst+file_jump")
    assert found.jumps_kept == ()
    for (day, by), (date, due) in zip(
        found.jumps, [("2023-06-21", 3600.0), ("2023-07-01", -3600.0)]
    ):
        assert by == due and abs(day - pd.Timestamp(date)) <= pd.Timedelta("2D")
    assert "60 min ahead from 2023-06-2" in found.line
    assert same_air(found, wall, data)


@pytest.fixture(scope="module")
def apart():
    """Two years and two more in Denver's standard time, three years from each other."""
    data = simulator.record(DENVER, {}, 7 * 365, 3600.0, 3, start="2015-01-01")
    data = data.tz_localize(None)
    return data[(data.index < "2016-09-10") | (data.index >= "2019-09-10")]


def late_by(data, hours, first, last="2100"):
    """The file with the clock of some days ahead."""
    late = (data.index >= first) & (data.index < last)
    moved = data.index + pd.to_timedelta(np.where(late, hours, 0), unit="h")
    return once(data.set_axis(moved)).sort_index()


def first_by_the_wall(data):
    """Summer time until the gap, and standard time after it."""
    first, second = data[:"2017"], data["2018":]
    return pd.concat([by_the_wall(first, "America/Denver"), second])


GAPS = {
    # what is made of the file, the zone that is found and the other changes
    "summer time": (lambda d: by_the_wall(d, "America/Denver"), True, []),
    "and a clock that was wrong for weeks": (
        lambda d: late_by(
            by_the_wall(d, "America/Denver"), 3, "2016-05-10", "2016-06-20"
        ),
        True,
        [("2016-05-10", 180), ("2016-06-20", -180)],
    ),
    "and another clock after the gap": (
        lambda d: late_by(by_the_wall(d, "America/Denver"), 2, "2019-09-10"),
        True,
        [("2019-09-10", 120)],
    ),
    "standard time, another clock after the gap": (
        lambda d: late_by(d, -1, "2019-09-10"),
        False,
        [("2019-09-10", -60)],
    ),
    "summer time before the gap alone": (
        first_by_the_wall,
        False,
        [
            *[("2015-03-08", 60), ("2015-11-01", -60)],
            *[("2016-03-13", 60), ("2019-09-10", -60)],
        ],
    ),
}


@pytest.mark.parametrize("kind", GAPS)
def test_changes_clock_errors_and_years_without_rows_are_told_apart(kind, apart):
    """The sun says on either side of the years which clock the file has."""
    change, kept, expected = GAPS[kind]
    wall = once(change(apart))
    found = judged(wall, "America/Denver")
    assert found.zone == ("America/Denver" if kept else "")
    assert found.explained and found.jumps_kept == ()
    moves = [(day, by / 60) for day, by in found.jumps]
    assert len(moves) == len(expected)
    for (day, by), (date, due) in zip(moves, expected):
        assert abs(day - pd.Timestamp(date)) <= pd.Timedelta("2D")
        assert by == pytest.approx(due, abs=20)  # rows are an hour apart
    # a clock that is off as well shows the zone's changes at other hours
    back = found.corrected(wall)["temp_air"]
    assert np.mean(back == apart["temp_air"].reindex(back.index)) > 0.999
    assert (~found.kept).mean() < 0.03


@pytest.mark.parametrize("months", [4, 7, 18])
@pytest.mark.parametrize("told", [True, False])
def test_no_gap_is_a_jump_by_itself(months, told):
    """Seasons on either side of it have one clock, planes to the east and west too."""
    for latitude, azimuth in ((62.0, 180.0), (49.0, 90.0), (35.0, 270.0), (-34.0, 0.0)):
        site = Site(latitude, 8.7, surface_azimuth=azimuth)
        data = simulator.record(site, {}, 1000, 3600.0, 3, start="2021-01-15")
        data = data.tz_localize(None)
        end = data.index[0] + pd.DateOffset(months=7 + months)
        data = data[(data.index < "2021-08-15") | (data.index > end)]
        angles = (site.surface_tilt, site.surface_azimuth) if told else ()
        location = Location(latitude, 8.7, tz="Etc/GMT-1")
        noon = solar_noon_shift(data["poa_global"], data.index, location, *angles)
        assert noon.jumps == (), (latitude, azimuth)


def test_a_file_of_days_alone_shows_its_jumps(years):
    wall = by_the_wall(years["Europe/Berlin"], "Europe/Berlin")
    wall.loc[wall["poa_global"] <= 0, "poa_global"] = np.nan
    found = judged(wall, "Europe/Berlin")
    assert found.explained and len(found.transitions) == 2


def test_a_transition_that_is_not_measured_is_not_missed():
    """The dates are the zone's; a gap over one of three does not speak against it."""
    data = simulator.record(RHINE, {}, 550, 1800.0, 3).tz_localize(None)
    wall = once(by_the_wall(data, "Europe/Berlin"))
    wall.loc["2023-10-01":"2023-12-15", "poa_global"] = np.nan
    found = judged(wall, "Europe/Berlin")
    assert found.explained
    assert len(found.transitions) == 3
    corrected = found.corrected(wall)["temp_air"]
    assert corrected.equals(data["temp_air"].loc[corrected.index])


def test_a_file_in_standard_time_with_a_zone_of_summer_time_is_told(years):
    data = years["Europe/Berlin"].tz_localize(
        "Europe/Berlin", nonexistent="NaT", ambiguous="NaT"
    )
    data = data[data.index.notna()]
    found = judged(data, "Europe/Berlin")
    assert not found.explained
    assert "give its times Etc/GMT-1 instead" in found.line


# false alarms


@pytest.mark.parametrize("step", [600, 1800, 3600, 7200, 10800])
def test_no_site_moves_by_an_hour_by_itself(step):
    """Not by rows that are far apart, nor where the sun hardly sets."""
    alarms = {}
    for number, site in enumerate(SITES):
        data = simulator.record(site, {}, 365, float(min(step, 3600)), 100 + number)
        data = data.resample(f"{step}s", closed="right", label="right").mean()
        location = Location(site.latitude, site.longitude, tz=site.tz)
        for where in ((), (location, site.surface_tilt, site.surface_azimuth)):
            found = solar_noon_shift(data["poa_global"].to_numpy(), data.index, *where)
            if found.jumps:
                alarms[site.latitude, bool(where)] = found.faults["file_dst"]
            looked = "no jump of the whole file by an hour was looked for"
            assert (step > 3600) == (looked in found.why)
    assert alarms == {}


@pytest.mark.parametrize("step", [600, 3600])
def test_summer_time_is_found_between_the_polar_circles(step):
    for number, site in enumerate(SITES):
        if abs(site.latitude) > 60:
            continue
        data = simulator.record(site, {"file_dst": 1.0}, 365, float(step), 50 + number)
        found = solar_noon_shift(data["poa_global"].to_numpy(), data.index)
        assert [by for _, by in found.jumps] == [3600.0, -3600.0], site.latitude
        for (day, _), date in zip(found.jumps, ("2023-03-26", "2023-10-29")):
            off = abs(day.tz_localize(None) - pd.Timestamp(date))
            assert off <= pd.Timedelta("5D"), site.latitude


# files that are refused


def refused(data):
    with pytest.raises(ValueError) as error:
        measured(*(data[name] for name in COLUMNS))
    return str(error.value)


@pytest.mark.parametrize("step", ["10min", "1h"])
def test_the_doubled_hour_suggests_the_zone_and_no_sorting(years, step):
    data = years["Europe/Berlin"][:: int(pd.Timedelta(step) / pd.Timedelta("10min"))]
    message = refused(by_the_wall(data, "Europe/Berlin"))
    assert "to 2023-10-29 02:00:00 (row " in message
    assert "as the clock does at the end of summer time" in message
    assert "leave the rows in their order" in message
    assert "sort_index" not in message
    # which does what it says
    wall = by_the_wall(data, "Europe/Berlin")
    aware = wall.tz_localize("Europe/Berlin", ambiguous="infer")
    assert measured(*(aware[name] for name in COLUMNS))


@pytest.mark.parametrize(
    "moved", ["2023-10-29 14:00", "2023-07-02 02:00"], ids=["by day", "in summer"]
)
def test_other_times_that_go_back_are_to_be_sorted(years, moved):
    data = years["Europe/Berlin"]
    at = int(data.index.searchsorted(pd.Timestamp(moved)))
    order = np.r_[: at + 6, at : len(data)]
    assert "is not sorted" in refused(data.iloc[order])
    aware = data.tz_localize(RHINE.tz).iloc[order]
    assert "use data.sort_index()" in refused(aware)


# a second irradiance


@pytest.mark.parametrize("minutes", [0, 35, -120])
def test_a_second_irradiance_has_its_own_clock(years, minutes):
    """Whatever its plane: a horizontal one and a tilted one see the same day."""
    data = years["Europe/Berlin"][:"2023-04-30"]
    late = data["ghi"] if "ghi" in data else 0.8 * data["poa_global"]
    shifted = np.interp(
        np.arange(len(data)) - minutes / 10, np.arange(len(data)), late.to_numpy()
    )
    found = twin_clock(data["poa_global"].to_numpy(), shifted, data.index)
    assert found.late / 60 == pytest.approx(minutes, abs=8)
    assert found.jumps == ()
    assert bool(found.line) == (abs(minutes) > 30)


def test_one_of_two_clocks_that_was_set_is_told(years):
    data = years["Europe/Berlin"][:"2023-06-30"]
    other = data["poa_global"].to_numpy().copy()
    at = data.index.searchsorted(pd.Timestamp("2023-04-10"))
    other[at:] = np.roll(other, 6)[at:]
    found = twin_clock(data["poa_global"].to_numpy(), other, data.index)
    ((day, by),) = found.jumps
    assert by == 3600 and abs(day - pd.Timestamp("2023-04-10")) <= pd.Timedelta("2D")
    assert "jump against those of poa_global by +60 min on 2023-04" in found.line


@pytest.mark.parametrize("kind", ["right", "covered", "threshold", "late"])
def test_a_power_that_is_late_for_weeks_is_not_used_on_these_days(years, kind):
    """A cover until ten moves one edge of the light; a threshold moves both apart."""
    data = years["Europe/Berlin"][:"2023-04-30"]
    power = 8.0 * data["poa_global"]
    there = (data.index >= "2023-03-01") & (data.index < "2023-04-01")
    if kind == "covered":
        power = power.mask(there & (data.index.hour < 10), 0.0)
    elif kind == "threshold":
        power = power.where(power > 0.06 * power.max(), 0.0)
    elif kind == "late":
        power = power.mask(there, power.shift(6))
    light, index = data["poa_global"].to_numpy(), data.index
    off = twin_clock(light, power.to_numpy(), index).off
    if kind != "late":
        assert not off.any()
        return
    days = pd.Series(off, index).resample("D").max()
    due = (days.index >= "2023-03-01") & (days.index < "2023-04-01")
    assert (days != due).sum() <= 4 and days.sum() >= 29
    loop = close_loop(data.assign(power_dc=power)[[*COLUMNS, "power_dc"]], effects=[])
    assert any(n.startswith("power_dc is not used on ") for n in loop.notes)
