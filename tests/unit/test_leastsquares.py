"""The search, compared with a certified fit, scipy and the explicit jackknife."""

import numpy as np
import pytest
from scipy.optimize import least_squares

from pvlib_fem._statistics.clusters import cluster_sums
from pvlib_fem._statistics.leastsquares import Normal, descent, minima_of, products

# NIST StRD, Misra1a (nonlinear regression, lower difficulty), certified values
MISRA_Y = [10.07, 14.73, 17.94, 23.93, 29.61, 35.18, 40.02, 44.82, 50.76, 55.05]
MISRA_Y = np.array([*MISRA_Y, 61.01, 66.40, 75.47, 81.78])
MISRA_X = [77.6, 114.9, 141.1, 190.8, 239.9, 289.0, 332.8, 378.4, 434.8, 477.3]
MISRA_X = np.array([*MISRA_X, 536.8, 593.1, 689.1, 760.0])
CERTIFIED = [2.3894212918e2, 5.5015643181e-4]
CERTIFIED_SQUARES = 1.2455138894e-1


def normal(residual, jacobian):
    """The sums of a residual and the matrix of its slopes."""
    return Normal.from_products(products([*jacobian.T, residual]))


def minimum_of(search, evaluate):
    """The end of one search, whose points a function answers."""
    return minima_of({"": search}, lambda points: {"": evaluate(points[""])})[""]


def misra(b):
    decay = np.exp(-b[1] * MISRA_X)
    jacobian = np.column_stack([1 - decay, b[0] * MISRA_X * decay])
    return MISRA_Y - b[0] * (1 - decay), jacobian


def sums_of(law):
    return lambda b: normal(*law(b))


@pytest.mark.parametrize("start", [(500, 1e-4), (250, 5e-4)])  # NIST's two starts
def test_a_certified_fit(start):
    found = minimum_of(descent(start, [1, 1e-6], [1e4, 1e-1]), sums_of(misra))
    assert found.converged and not found.at_bound.any()
    assert found.x == pytest.approx(CERTIFIED, rel=1e-6)
    residual, _ = misra(found.x)
    assert residual @ residual == pytest.approx(CERTIFIED_SQUARES, rel=1e-9)


@pytest.mark.parametrize("upper", [(200, 1e-1), (1e4, 5e-4)])
def test_a_bound_that_binds_is_scipys_too(upper):
    lower = [1, 1e-6]
    found = minimum_of(descent((100, 1e-4), lower, upper), sums_of(misra))
    theirs = least_squares(
        lambda b: -misra(b)[0],
        (100, 1e-4),
        lambda b: misra(b)[1],
        (lower, upper),
        x_scale=[100, 1e-4],
        xtol=1e-14,
        ftol=1e-14,
        gtol=1e-14,
    )
    assert found.x == pytest.approx(theirs.x, rel=1e-5)
    assert found.at_bound.tolist() == np.isclose(found.x, upper).tolist()
    assert found.at_bound.any()


@pytest.mark.parametrize("flat", [1e-4, 1e-8, 1e-13])
def test_a_last_step_that_is_not_looked_at_leaves_next_to_nothing(flat):
    """By the slopes at the end, one more step would gain far less than ``flat``."""
    places = []

    def seen(b):
        places.append(b)
        return sums_of(misra)(b)

    found = minimum_of(descent((250, 5e-4), [1, 1e-6], [1e4, 1e-1], flat=flat), seen)
    assert not np.array_equal(found.x, places[-1])
    end = sums_of(misra)(found.x)
    more = end.fall(np.linalg.solve(end.normal, end.gradient))
    assert 0.0 <= more <= max(0.01 * flat, 1e-17) * end.squares


def test_too_few_steps_are_no_convergence():
    assert not minimum_of(
        descent((500, 1e-4), [1, 1e-6], [1e4, 1e-1], 1), sums_of(misra)
    ).converged


def test_a_place_without_a_number_is_no_minimum():
    """Where every step leads to NaN the search says that it failed."""

    def nowhere(x):
        residual, jacobian = misra(x)
        return residual + (0.0 if x[0] == 250 else np.nan), jacobian

    found = minimum_of(descent((250, 5e-4), [1, 1e-6], [1e4, 1e-1]), sums_of(nowhere))
    assert not found.converged
    assert found.x.tolist() == [250, 5e-4]


def test_searches_that_share_their_passes_end_where_each_does():
    starts, asked = {"far": (500, 1e-4), "near": (250, 5e-4)}, []
    evaluate = sums_of(misra)

    def searches():
        return {n: descent(x, [1, 1e-6], [1e4, 1e-1]) for n, x in starts.items()}

    def together(points):
        asked.append(set(points))
        return {name: evaluate(point) for name, point in points.items()}

    found, each = minima_of(searches(), together), searches()
    assert list(found) and set(found) == set(starts)
    assert each.keys() == found.keys()
    for name, search in each.items():
        np.testing.assert_array_equal(found[name].x, minimum_of(search, evaluate).x)
    # one pass serves all that have not ended
    assert asked[0] == set(starts) and len(asked[-1]) == 1


def test_day_errors_are_the_jackknife_over_days():
    """For a linear model, leaving out each day in turn and solving again."""
    random = np.random.default_rng(0)
    days = np.repeat(np.arange(8), 30)
    x = np.column_stack([np.ones(240), random.normal(size=240)])
    y = x @ [1.0, 2.0] + np.repeat(random.normal(size=8), 30) + random.normal(size=240)
    best = np.linalg.lstsq(x, y, rcond=None)[0]
    without = np.array(
        [np.linalg.lstsq(x[days != d], y[days != d], rcond=None)[0] for d in range(8)]
    )
    expected = 7 / 8 * (without - best).T @ (without - best)
    np.testing.assert_allclose(
        cluster_sums(list(x.T), y - x @ best, days).by_day(), expected, rtol=1e-9
    )
