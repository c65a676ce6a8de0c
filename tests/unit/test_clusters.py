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


def test_sums_of_some_columns_have_the_least_squares_solution(rows):
    columns, residual, _ = rows
    kept = [0, 2, 3]
    sums = summed(rows).of_columns(kept)
    found = np.linalg.solve(sums.whole[:-1, :-1], sums.whole[:-1, -1]) / sums.scale
    want = np.linalg.lstsq(columns[:, kept], residual, rcond=None)[0]
    np.testing.assert_allclose(found, want, rtol=1e-6)


@pytest.mark.parametrize("days", [70, 40])
def test_sums_of_a_week_are_those_of_its_days(rows, days):
    """Where there are few weeks, each day is on its own."""
    columns, residual, dates = (part[: 25 * days] for part in rows)
    found = cluster_sums(list(columns.T), residual, dates).by_week
    number = dates if days == 40 else (dates + 3) // 7
    table = np.column_stack([columns, residual])
    rows_of = [table[number == one] for one in np.unique(number)]
    want = np.array([part.T @ part for part in rows_of])
    scale = np.append(np.sqrt(np.mean(columns**2, axis=0)), 1.0)
    np.testing.assert_allclose(found, want / np.outer(scale, scale), rtol=1e-9)


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
