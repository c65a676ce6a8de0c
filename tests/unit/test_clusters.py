"""Daily sums, compared with computations on rows."""

import numpy as np
import pytest
from hypothesis import given, strategies as st

from pvlib_fem._statistics.clusters import (
    FOLDS,
    cluster_sums,
    days_of_folds,
    products_by_day,
)
from pvlib_fem._statistics.leastsquares import products


@pytest.fixture(scope="module")
def rows():
    """Seventy days of four columns, the last made of two others and a rest."""
    random = np.random.default_rng(0)
    dates = np.repeat(np.arange(19_000, 19_070), 25)
    columns = random.normal(size=(len(dates), 4)) * [1.0, 50.0, 1e-3, 1.0]
    columns[:, 3] = columns[:, 0] - columns[:, 1] / 50 + 0.1 * columns[:, 3]
    daily = np.repeat(random.normal(size=70), 25)
    residual = (
        columns @ [0.5, 0.02, 100.0, 0.3] + daily + random.normal(size=len(dates))
    )
    return columns, residual, dates


def summed(rows):
    columns, residual, dates = rows
    return cluster_sums(list(columns.T), residual, dates)


def test_the_solution_is_least_squares(rows):
    columns, residual, _ = rows
    kept = [0, 2, 3]
    sums = summed(rows).of_columns(kept)
    want = np.linalg.lstsq(columns[:, kept], residual, rcond=None)[0]
    np.testing.assert_allclose(sums.solved / sums.scale, want, rtol=1e-6)


def test_errors_are_those_of_weeks_left_out(rows):
    columns, residual, dates = rows
    kept = [0, 1, 3]
    x = columns[:, kept]
    left = residual - x @ np.linalg.lstsq(x, residual, rcond=None)[0]
    sums = summed(rows).of_columns(kept)
    found = sums.covariance() / np.outer(sums.scale, sums.scale)
    np.testing.assert_allclose(
        found, cluster_sums(list(x.T), left, (dates + 3) // 7).by_day(), rtol=1e-5
    )


def test_few_weeks_are_folded_by_days():
    assert days_of_folds(np.arange(20)).tolist() == [day % FOLDS for day in range(20)]


@given(st.lists(st.integers(1, 60), min_size=1, max_size=30), st.integers(1, 9))
def test_days_of_one_length_are_summed_together_to_the_bits_of_each(lengths, columns):
    """The result does not depend on the days around them."""
    dates = np.repeat(np.arange(len(lengths)), lengths)
    random = np.random.default_rng(len(dates))
    columns = list(random.normal(size=(columns, len(dates))))
    days, found = products_by_day(columns, dates)
    alone = [products([c[dates == day] for c in columns]) for day in days]
    np.testing.assert_array_equal(found, alone)


@pytest.mark.parametrize("length", [4096, 4320, 5760, 8640])
@pytest.mark.parametrize("size", [2, 4, 6])
def test_long_days_are_summed_as_short_ones_are(length, size):
    """Days at steps of ten to twenty seconds, and a short day."""
    dates = np.repeat(np.arange(3), [length, length, 7])
    columns = list(np.random.default_rng(length).normal(size=(size, len(dates))))
    days, found = products_by_day(columns, dates)
    alone = [products([c[dates == day] for c in columns]) for day in days]
    np.testing.assert_array_equal(found, alone)
