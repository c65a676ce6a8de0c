"""The kernel: exact on any steps, and its NaN, gaps and start-up."""

from datetime import timedelta

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, strategies as st
from numpy.testing import assert_allclose

from pvlib_fem import ewm
from pvlib_fem._relaxation import BLOCK


def by_hand(values, seconds, tau):
    """The response written as its definition, row by row."""
    result = np.full(len(values), np.nan)
    usual = np.median(np.diff(seconds))
    state, since = None, None
    for i, value in enumerate(values):
        if np.isnan(value):
            continue
        step = None if since is None else seconds[i] - since
        if state is None or (step > 5 * tau and step > 2 * usual):
            state = value
        else:
            decay = np.exp(-step / tau)
            state = decay * state + (1 - decay) * value
        since = seconds[i]
        result[i] = state
    return result


def at(seconds):
    return pd.Timestamp("2024-05-01") + pd.to_timedelta(seconds, unit="s")


def test_the_papers_listing_comes_out_to_the_last_digit(month):
    """The paper's listing: alpha = 1 - exp(-delta_t/tau), .ewm(alpha).mean()."""
    sun = month["poa_global"]
    for tau in (60.0, 378.0, 1500.0):
        alpha = 1 - np.exp(-60.0 / tau)
        listing = sun.ewm(alpha=alpha).mean()
        assert_allclose(ewm(sun, tau, adjust=True), listing, rtol=1e-12, atol=1e-12)


def test_the_listing_differs_at_start_up_only():
    """Row 1 of a step: the listing's weights give 1/(1 + decay) of it, the
    response 1 - decay; after some time constants both are there."""
    values, decay = np.r_[0.0, np.full(200, 1000.0)], np.exp(-60 / 378)
    listing = ewm(values, 378.0, step=60, adjust=True)
    response = ewm(values, 378.0, step=60)
    assert listing[1] == pytest.approx(1000 / (1 + decay), rel=1e-12)
    assert response[1] == pytest.approx(1000 * (1 - decay), rel=1e-12)
    assert_allclose(listing[150:], response[150:], rtol=1e-9)


@pytest.mark.parametrize("tau", [60.0, 378.0, 1500.0])
def test_a_step_on_uneven_times_is_answered_exactly(tau):
    seconds = np.concatenate(
        ([0.0], np.cumsum(np.random.default_rng(0).uniform(1, 280, 900)))
    )
    values = np.where(seconds > 0, 1000.0, 0.0)
    answer = ewm(values, tau, times=seconds)
    assert_allclose(answer, 1000 * (1 - np.exp(-seconds / tau)), rtol=1e-12, atol=1e-12)


def test_a_gap_relaxes_by_its_true_duration():
    """An hour of zeros at 1 min, then 1000 after 20 min: 958, where the
    weights of pandas' ``ewm(times=...)`` give 778 (design, section 1)."""
    times = pd.date_range("2024-05-01", periods=61, freq="1min")
    times = times.append(pd.DatetimeIndex([times[-1] + pd.Timedelta("20min")]))
    values = pd.Series(np.r_[np.zeros(61), 1000.0], times)
    assert ewm(values, 378.0).iloc[-1] == pytest.approx(958.2, abs=0.05)
    halflife = pd.Timedelta(seconds=378 * np.log(2))
    assert values.ewm(halflife=halflife, times=times).mean().iloc[-1] == pytest.approx(
        778, abs=1
    )


@pytest.mark.parametrize(("minutes", "anew"), [(31, False), (32, True)])
def test_after_five_time_constants_it_starts_anew(minutes, anew):
    """5 x 378 s are 31.5 min."""
    times = pd.date_range("2024-05-01", periods=9, freq="1min")
    times = times.append(times[-1:] + pd.Timedelta(minutes=minutes))
    answer = ewm(pd.Series(np.r_[np.zeros(9), 1000.0], times), 378.0).iloc[-1]
    assert (answer == 1000.0) == anew
    assert answer == pytest.approx(1000.0, abs=8)


def test_slow_even_steps_are_no_gaps():
    """Hourly steps exceed 5 tau, and are still answered exactly."""
    times = pd.date_range("2024-05-01", periods=3, freq="h")
    answer = ewm(pd.Series([0.0, 1000.0, 1000.0], times), 600.0)
    assert answer.iloc[1] == pytest.approx(1000 * (1 - np.exp(-6)), abs=1e-9)


@pytest.mark.parametrize("rows", [1, 2, BLOCK - 1, BLOCK, BLOCK + 1, 2 * BLOCK + 7])
def test_blocks_join_without_a_seam(rows):
    random = np.random.default_rng(rows)
    values = random.uniform(0, 1000, rows)
    seconds = np.cumsum(random.integers(1, 90, rows)).astype(float)
    tau = random.uniform(100, 900, rows)
    for constant in (378.0, tau):
        state, expected = values[0], []
        for x, step, t in zip(
            values,
            np.diff(seconds, prepend=seconds[0]),
            np.broadcast_to(constant, rows),
        ):
            decay = np.exp(-step / t)
            state = decay * state + (1 - decay) * x
            expected.append(state)
        assert_allclose(ewm(values, constant, times=seconds), expected, rtol=1e-11)


@pytest.mark.parametrize("cut", [1, 137, 719])
def test_a_record_in_two_parts_gives_the_same_numbers(month, cut):
    sun = month["poa_global"].iloc[:1440]
    sun = sun.drop(sun.index[[100, 101, 400]])
    whole = ewm(sun, 378.0)
    first = ewm(sun.iloc[:cut], 378.0)
    second = ewm(sun.iloc[cut:], 378.0, initial=first)
    assert_allclose(pd.concat([first, second]), whole, rtol=1e-12, atol=1e-9)
    array = sun.to_numpy()
    whole = ewm(array, 378.0, step=60)
    first = ewm(array[:cut], 378.0, step=60)
    second = ewm(array[cut:], 378.0, step=60, initial=first[-1])
    assert_allclose(np.r_[first, second], whole, rtol=1e-12, atol=1e-9)


def test_samples_that_come_one_by_one_give_the_same_numbers():
    """Also where each step is longer than five time constants: it is slow, no gap."""
    values = [0.0, 1000.0, 300.0]
    state, answers = None, []
    for value in values:
        (state,) = ewm([value], 5.0, step=26, initial=state)
        answers.append(state)
    assert_allclose(answers, ewm(values, 5.0, step=26), rtol=1e-12)


@pytest.mark.parametrize("unit", ["s", "ms", "us", "ns"])
@pytest.mark.parametrize("zone", [None, "Europe/Brussels"])
def test_the_resolution_and_zone_of_the_index_do_not_matter(unit, zone):
    """Over the night in which the clock springs forward."""
    seconds = np.cumsum(np.random.default_rng(4).integers(20, 100, 500))
    times = pd.DatetimeIndex(
        pd.Timestamp("2024-03-30 22:00") + pd.to_timedelta(seconds, unit="s")
    )
    if zone:
        times = times.tz_localize("UTC").tz_convert(zone)
    values = np.random.default_rng(5).uniform(0, 1000, 500)
    answer = ewm(pd.Series(values, times.as_unit(unit)), 378.0)
    assert_allclose(answer, ewm(values, 378.0, times=seconds), rtol=1e-13)


series = st.lists(
    st.tuples(
        st.floats(0.1, 3000.0),
        st.one_of(st.just(np.nan), st.floats(-1e3, 1e3)),
    ),
    min_size=2,
    max_size=60,
)
taus = st.floats(1.0, 5000.0)


@given(series, taus)
def test_random_records_match_the_definition(rows, tau):
    steps, values = np.array(rows).T
    seconds = np.cumsum(steps)
    answer = ewm(values, tau, times=seconds)
    # without the joined steps over NaN the usual step would be another
    kept = ~np.isnan(values)
    if kept.sum() > 1:
        expected = by_hand(values[kept], seconds[kept], tau)
        assert_allclose(answer[kept], expected, rtol=1e-9, atol=1e-9)


@given(series, taus)
def test_nan_comes_out_where_it_went_in_and_nowhere_else(rows, tau):
    steps, values = np.array(rows).T
    answer = ewm(values, tau, times=np.cumsum(steps))
    assert (np.isnan(answer) == np.isnan(values)).all()


@given(series, taus)
def test_the_answer_stays_within_the_values_it_has_seen(rows, tau):
    steps, values = np.array(rows).T
    answer = ewm(values, tau, times=np.cumsum(steps))
    seen = ~np.isnan(values)
    low = np.minimum.accumulate(values[seen])
    high = np.maximum.accumulate(values[seen])
    assert (answer[seen] >= low - 1e-9).all()
    assert (answer[seen] <= high + 1e-9).all()


@given(series, taus, st.integers(-10_000, 10_000))
def test_a_shift_of_time_shifts_the_answer(rows, tau, days):
    steps, values = np.array(rows).T
    times = at(np.round(np.cumsum(steps), 3))
    one = ewm(pd.Series(values, times), tau)
    other = ewm(pd.Series(values, times + pd.Timedelta(days=days)), tau)
    assert_allclose(one, other, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("adjust", [False, True])
def test_a_constant_stays_what_it_is(adjust):
    values = np.full(5000, 321.0)
    seconds = np.cumsum(np.random.default_rng(0).uniform(1, 400, 5000))
    assert_allclose(ewm(values, 378.0, times=seconds, adjust=adjust), 321.0, rtol=1e-13)


def test_the_input_is_left_as_it_was(month):
    sun = month["poa_global"].iloc[:2000].copy()
    sun.iloc[5] = np.nan
    before = sun.copy()
    answer = ewm(sun, 378.0)
    pd.testing.assert_series_equal(sun, before)
    assert answer.index is sun.index
    assert answer.name == "poa_global"


@pytest.mark.parametrize("tau", [0, -1.0, np.nan, [378.0, 0.0, 378.0]])
def test_a_time_constant_must_be_positive(tau):
    with pytest.raises(ValueError, match=r"tau = .* must be positive"):
        ewm([0.0, 1.0, 2.0], tau, step=60)


def test_a_list_of_time_constants_must_fit_the_samples():
    with pytest.raises(ValueError, match="tau has 2 values for 3 samples"):
        ewm([0.0, 1.0, 2.0], [378.0, 378.0], step=60)


def test_time_constants_of_other_times_are_refused(month):
    """Row by row they would be those of other weather, without a word."""
    sun, wind = (month[name].iloc[:200] for name in ("poa_global", "wind_speed"))
    tau = 700.0 - 50.0 * wind.clip(upper=10.0)
    assert ewm(sun, tau).notna().all()
    with pytest.raises(ValueError, match="tau and the signal have different indexes"):
        ewm(sun, tau[::-1])


@pytest.mark.parametrize(
    ("initial", "message"),
    [
        (pd.Series([1.0], at([60])), "not before the first sample"),
        (pd.Series([np.nan], at([-60])), "initial holds no value"),
        (pd.Series([1.0], at([-60]).tz_localize("UTC")), "zone UTC, values in None"),
        (pd.Series([1.0, 2.0], at([-60, -120])), "initial is not sorted"),
        (pd.Series([1.0, 2.0]), "initial has no DatetimeIndex but a (Range)?Index"),
        (pd.Series([np.inf], at([-60])), "initial is infinite at 2024"),
        (np.nan, "initial = nan must be a finite number"),
        (-np.inf, "initial = -inf must be a finite number"),
    ],
)
def test_a_state_must_come_from_before(initial, message):
    values = pd.Series([0.0, 1.0], at([0, 60]))
    with pytest.raises(ValueError, match=message):
        ewm(values, 378.0, initial=initial)


def test_a_masked_sample_is_one_that_is_missing():
    masked = np.ma.masked_array([0, -7999, 2, 3], [0, 1, 0, 0])
    plain = [0.0, np.nan, 2.0, 3.0]
    np.testing.assert_array_equal(ewm(masked, 60, step=60), ewm(plain, 60, step=60))
    with pytest.raises(ValueError, match="tau = nan must be positive"):
        ewm(plain, np.ma.masked_array([60.0] * 4, [0, 0, 1, 0]), step=60)


def test_a_bare_state_needs_even_steps():
    with pytest.raises(ValueError, match="the steps are uneven"):
        ewm([0.0, 1.0, 2.0], 378.0, times=[0, 60, 200], initial=5.0)
    with pytest.raises(ValueError, match="does not go with adjust=True"):
        ewm([0.0, 1.0, 2.0], 378.0, step=60, initial=5.0, adjust=True)


def test_a_day_of_the_calendar_lasts_as_long_as_it_does():
    """The 23 h of a change to summer time, with every pandas and without a freq."""
    days = pd.date_range("2024-03-29", periods=5, freq="D", tz="Europe/Brussels")
    values = pd.Series([10.0, 0.0, 0.0, 0.0, 0.0], days)
    bare = values.set_axis(pd.DatetimeIndex(list(days)))
    found = ewm(values, 86400.0)
    np.testing.assert_array_equal(found, ewm(bare, 86400.0))
    hours = np.array([24.0, 24.0, 23.0, 24.0])
    want = 10.0 * np.exp(-np.cumsum(hours) / 24.0)
    assert_allclose(found.iloc[1:], want, rtol=1e-12)


@pytest.mark.parametrize(
    "tau",
    [
        pd.Timedelta("6min"),
        timedelta(minutes=6),
        np.timedelta64(6, "m"),  # numpy takes it for the number 6
        "6min",
        [pd.Timedelta("6min")] * 3,
        pd.Series(pd.to_timedelta([360, 360, 360], unit="s")),
    ],
)
def test_a_time_constant_is_in_seconds(tau):
    with pytest.raises(ValueError, match=r"^tau is a .*; give seconds as numbers"):
        ewm([0.0, 1000.0, 1000.0], tau, step=60.0)


def test_a_step_is_in_seconds():
    for step in (pd.Timedelta("1min"), np.timedelta64(1, "m")):
        with pytest.raises(ValueError, match=r"^step = .* positive number of seconds"):
            ewm([0.0, 1000.0], 378.0, step=step)
