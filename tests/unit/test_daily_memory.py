"""An error that lasts from day to day, against series whose mean is known to err."""

from itertools import accumulate

import numpy as np
import pytest

from pvlib_fem._statistics.clusters import cluster_sums
from pvlib_fem._statistics.daily_memory import correlated_sum, daily_memory

ROWS = 6  # of a day


def of_days(error, columns=None, dates=None):
    """Sums about the minimum of some columns, on days that are each off by one."""
    days = len(error)
    dates = np.arange(days) if dates is None else dates
    columns = np.ones((days * ROWS, 1)) if columns is None else columns
    y = np.repeat(error, ROWS)
    best = np.linalg.lstsq(columns, y, rcond=None)[0]
    return cluster_sums(list(columns.T), y - columns @ best, np.repeat(dates, ROWS))


def autocorrelated_series(random, days, memory):
    kicks = random.standard_normal(days) * np.sqrt(1.0 - memory**2)
    kicks[0] = random.standard_normal()
    return np.array(list(accumulate(kicks, lambda before, k: k + memory * before)))


def test_pairs_of_days_are_summed_by_what_is_between_them():
    columns = np.random.default_rng(0).normal(size=(40, 3))
    apart = np.abs(np.subtract.outer(np.arange(40), np.arange(40)))
    want = np.einsum("ti,ts,si->i", columns, 0.7**apart, columns)
    np.testing.assert_allclose(correlated_sum(columns, 0.7), want, rtol=1e-12)


@pytest.mark.parametrize("memory", [0.0, 0.5, 0.8])
def test_the_error_of_a_mean_is_that_of_its_series(memory):
    random, days = np.random.default_rng(1), 300
    found, alone, means = [], [], []
    for _ in range(200):
        error = autocorrelated_series(random, days, memory)
        sums = of_days(error)
        alone.append(sums.by_day()[0, 0])
        found.append(alone[-1] + daily_memory(sums).variance[0])
        means.append(error.mean())
    apart = np.arange(1, days)
    want = (1.0 + 2.0 * ((1.0 - apart / days) * memory**apart).sum()) / days
    # the law of the series, directly and from the scatter of 200 means
    assert np.mean(found) == pytest.approx(want, rel=0.06)
    assert np.var(means) == pytest.approx(want, rel=0.25)
    assert np.mean(alone) == pytest.approx(1.0 / days, rel=0.06)


def test_it_lasts_for_as_long_as_it_was_made_to():
    random = np.random.default_rng(2)
    memory = [
        daily_memory(of_days(autocorrelated_series(random, 400, 0.8))).memory
        for _ in "1234"
    ]
    assert np.mean(memory) == pytest.approx(-1.0 / np.log(0.8), rel=0.15)


def test_an_error_that_changes_its_sign_each_day_takes_nothing_off():
    sums = of_days((-1.0) ** np.arange(60))
    assert daily_memory(sums).variance[0] == 0.0 and daily_memory(sums).memory == 0.0


def test_it_is_found_along_the_coefficient_that_it_is_of():
    random, days = np.random.default_rng(3), 200
    light = random.uniform(0.0, 1.0, (days, ROWS))
    columns = np.stack([light.ravel(), np.ones(days * ROWS)], axis=1)
    gain = 0.1 * autocorrelated_series(random, days, 0.9)[:, None] * light
    y = (gain + 0.02 * random.standard_normal((days, ROWS))).ravel()
    best = np.linalg.lstsq(columns, y, rcond=None)[0]
    dates = np.repeat(np.arange(days), ROWS)
    sums = cluster_sums(list(columns.T), y - columns @ best, dates)
    times = 1.0 + daily_memory(sums).variance / np.diag(sums.by_day())
    assert times[0] > 5.0 and times[1] < 1.5


def test_few_days_do_not_tell_how_long_it_lasts():
    random = np.random.default_rng(4)

    def known(days, memory, series=100):
        drawn = (autocorrelated_series(random, days, memory) for _ in range(series))
        return np.mean([daily_memory(of_days(error)).known for error in drawn])

    assert known(30, 0.95) < 0.2 and known(300, 0.5) == 1.0
    # no more than that it is there on half of them
    assert daily_memory(of_days(np.arange(10.0))).memory <= 5.0 + 1e-9


def test_the_unit_of_a_coefficient_is_that_of_its_error():
    error = autocorrelated_series(np.random.default_rng(5), 80, 0.6)
    ones = np.ones((80 * ROWS, 1))
    one, thousand = (daily_memory(of_days(error, ones * by)) for by in (1.0, 1e-3))
    assert thousand.variance[0] == pytest.approx(1e6 * one.variance[0])
    assert thousand.memory == pytest.approx(one.memory)
