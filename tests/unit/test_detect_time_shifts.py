"""Shifts of a clock that are put into light are found, and none where there is none."""

import numpy as np
import pandas as pd
import pytest
import study_detectors
from pvlib.location import Location

from pvlib_fem import detect, simulator
from pvlib_fem.detect._daily_clock import clock_of
from pvlib_fem.simulator import ALBUQUERQUE, OUTDOORS, RHINE

SEED = 11


def place(site):
    return Location(site.latitude, site.longitude, tz=site.tz)


def light(site=RHINE, days=400, step=900.0, seed=SEED):
    return simulator.record(site, OUTDOORS, days, step, seed)["poa_global"]


@pytest.fixture(scope="module")
def poa():
    return light()


def ahead(series, minutes, start, end=None):
    """The record with timestamps ahead by some minutes on some days."""
    parts = series[: pd.Timestamp(start, tz=series.index.tz)], series[start:end]
    moved = parts[1].copy()
    moved.index += pd.Timedelta(minutes=minutes)
    rest = series[end:].iloc[1:] if end else series[:0]
    both = pd.concat([parts[0][:-1], moved, rest])
    return both[~both.index.duplicated()].sort_index().asfreq(series.index.freq)


@pytest.mark.parametrize("by", [-120, -60, -30, -15, 15, 30, 45, 60, 120])
def test_a_jump_is_found_with_its_size_and_day(poa, by):
    found = detect.time_shifts(
        ahead(poa, by, "2023-05-10", "2023-09-20"), place(RHINE), label="center"
    )
    days, sizes = zip(*found.jumps)
    assert sizes == (by, -by)
    for day, true in zip(days, ("2023-05-10", "2023-09-21")):
        assert abs(day - pd.Timestamp(true)) <= pd.Timedelta(days=4 if by > 15 else 12)
    assert found.minutes["2023-07-01"] == by and found.minutes["2023-03-01"] == 0
    assert found.shifted.dtype == bool and found.shifted["2023-07-01"]
    assert not found.shifted["2023-12-01"]


@pytest.mark.parametrize("zone", [-120, -60, 60, 120, 480])
def test_another_zone_is_found(poa, zone):
    moved = poa.copy()
    moved.index += pd.Timedelta(minutes=zone)
    found = detect.time_shifts(moved, place(RHINE), label="center")
    assert (found.minutes == zone).all() and not found.jumps


def test_summer_time_is_no_season(poa):
    """Twice a year, as regular as the sun."""
    data = light(days=900, step=1800.0)
    for year in (2023, 2024):
        data = ahead(data, 60, f"{year}-03-26", f"{year}-10-28")
    found = detect.time_shifts(data, place(RHINE), label="center")
    assert [by for _, by in found.jumps] == [60, -60, 60, -60]


@pytest.mark.parametrize("site", [RHINE, ALBUQUERQUE], ids=["Rhine", "Albuquerque"])
@pytest.mark.parametrize(("step", "seed"), [(900.0, 1), (1800.0, 2), (3600.0, 3)])
def test_no_clock_is_off_where_none_is(site, step, seed):
    found = detect.time_shifts(
        light(site, 800, step, seed), place(site), label="center"
    )
    assert not found.shifted.any() and not found.jumps


def test_a_jump_in_a_gap_may_be_on_any_of_its_days(poa):
    moved = ahead(poa, 60, "2023-06-01")
    moved["2023-05-10":"2023-06-20"] = np.nan
    found = detect.time_shifts(moved, place(RHINE), label="center")
    ((day, by),), ((first, last),) = found.jumps, found.within
    assert by == 60 and first == pd.Timestamp("2023-05-10")
    assert abs(last - pd.Timestamp("2023-06-21")) <= pd.Timedelta(days=2)
    assert abs(day - pd.Timestamp("2023-05-31")) <= pd.Timedelta(days=2)


def test_the_unit_of_the_light_does_not_matter(poa):
    moved = ahead(poa, 30, "2023-06-01")
    whole = detect.time_shifts(moved, place(RHINE), label="center")
    other = detect.time_shifts(moved * 7.3e-3, place(RHINE), label="center")
    pd.testing.assert_series_equal(whole.minutes, other.minutes)


def test_nights_may_lack(poa):
    moved = ahead(poa, 30, "2023-06-01")
    by_day = moved.where(moved.rolling(9, center=True).max() > 10.0)
    found = detect.time_shifts(by_day, place(RHINE), label="center")
    assert [by for _, by in found.jumps] == [30]
    found = detect.time_shifts(by_day.dropna(), place(RHINE), label="center")
    assert [by for _, by in found.jumps] == [30]


def test_power_may_be_used_by_night_but_not_fed_as_negative(poa):
    fed = ahead(poa, 30, "2023-06-01")
    used = fed.where(fed > 0.0, -0.01 * fed.max())
    found = detect.time_shifts(used, place(RHINE), label="center")
    assert [by for _, by in found.jumps] == [30]
    with pytest.raises(ValueError, match=r"light is negative, .* turn its sign"):
        detect.time_shifts(-used, place(RHINE), label="center")


@pytest.mark.parametrize(("label", "end"), [("left", 0), ("right", 1)])
def test_a_label_names_the_end_of_an_interval(label, end):
    fine = light(days=60, step=300.0)
    hourly = fine.resample("1h", label=label, closed=label).mean()
    found = detect.time_shifts(hourly, place(RHINE), label=label)
    assert abs(found.usual) < 8.0 and not found.shifted.any()
    other = detect.time_shifts(hourly, place(RHINE), label="center")
    assert other.usual == pytest.approx(found.usual + (2 * end - 1) * 30.0, abs=2.0)


def test_a_first_row_of_the_day_before_does_not_matter():
    """East of the zone's meridian the sun's midnight is before that of the clock."""
    here = Location(RHINE.latitude, 29.0, tz="Etc/GMT-1")
    index = pd.date_range("2023-01-01", periods=60 * 24, freq="1h", tz=here.tz)
    middle = index - pd.Timedelta(minutes=30)
    ghi = here.get_clearsky(middle, model="haurwitz")["ghi"].set_axis(index)
    for first in (0, 12):
        found = detect.time_shifts(ghi[first:], here, label="right")
        assert abs(found.usual) < 8.0 and not found.shifted.any()


def test_a_path_bears_wild_days():
    random = np.random.default_rng(1)
    day, minutes = np.arange(300), random.laplace(0.0, 8.0, 300)
    minutes[random.random(300) < 0.1] += 200.0
    minutes[100:180] += 30.0
    clock = clock_of(day, minutes).level
    true = np.where((day >= 100) & (day < 180), 30.0, 0.0)
    assert np.abs(np.diff(clock)).sum() == 60.0
    assert (clock - clock[0] != true).sum() <= 4


def test_what_is_no_series_of_light_is_refused(poa):
    here = place(RHINE)
    with pytest.raises(TypeError, match="light is a ndarray; give a pandas Series"):
        detect.time_shifts(poa.to_numpy(), here)
    with pytest.raises(TypeError, match="no DatetimeIndex"):
        detect.time_shifts(poa.reset_index(drop=True), here)
    with pytest.raises(ValueError, match=r"label = 'middle'; it is 'left'"):
        detect.time_shifts(poa, here, label="middle")
    with pytest.raises(ValueError, match="location is None"):
        detect.time_shifts(poa, None)
    with pytest.raises(ValueError, match="the index of light is not sorted"):
        detect.time_shifts(poa.iloc[::-1], here)
    lost = poa[:1].set_axis(pd.DatetimeIndex(["1970-01-01"], tz=poa.index.tz))
    with pytest.raises(ValueError, match="a logger that lost its clock; drop such"):
        detect.time_shifts(pd.concat([lost, poa]), here)
    with pytest.raises(ValueError, match="light is empty; give at least one row"):
        detect.time_shifts(poa[:0], here)


def test_a_record_without_light_has_no_clock(poa):
    found = detect.time_shifts(poa[:300] * 0.0, place(RHINE))
    assert found.minutes.isna().all() and not found.shifted.any()
    assert "no clock" in str(found)


def test_a_single_row_has_no_clock(poa):
    found = detect.time_shifts(poa.iloc[50:51], place(RHINE))
    assert found.minutes.isna().all() and found.jumps == ()


def test_jumps_are_counted_as_the_page_says():
    day = pd.Timestamp("2023-06-01")
    true = [(day, 60.0), (day + pd.Timedelta(days=90), -60.0)]
    shifted = [(d, d, by) for d, by in true]
    assert study_detectors.counted(true, shifted) == (2, 0)
    assert study_detectors.counted(true, shifted[:1]) == (1, 0)
    assert study_detectors.counted(true, [(day, day, -60.0)]) == (0, 1)
    assert study_detectors.counted(true, [(day, day, 30.0)]) == (0, 0)
    assert study_detectors.counted([], shifted) == (0, 2)
    early, late = day - pd.Timedelta(days=80), day - pd.Timedelta(days=20)
    assert study_detectors.counted(true, [(early, late, 60.0)]) == (1, 0)
    assert study_detectors.counted(true, [(early, early, 60.0)]) == (0, 1)
