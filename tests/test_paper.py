"""The paper's estimators, its tables, and where it cannot be taken literally."""

import numpy as np
import pandas as pd
import pytest
from conftest import COLUMNS, DRIVERS

import pvlib_fem as fem
from pvlib_fem import datasets, paper

# r_eq,max, r_M [mK/(W/m²)], c_eq,max, c_M, c_film [kJ/(m²K)], tau_0, tau [s]: the
# paper's second table, the rows that have a tau
TABLE = {
    "KUL B roof 1s": (35.4, 15.3, 37.7, 26.9, 10.8, 576, 410),
    "KUL B roof 1min": (34.8, 15.3, 37.4, 23.8, 13.6, 572, 364),
    "KUL B roof 5min": (35.4, 15.6, 37.5, 22.6, 14.9, 584, 352),
    "KUL B roof 15min": (31.2, 16.3, 53.7, 27.8, 25.9, 874, 453),
    "KUL APV HAX": (12.2, 5.3, 102.8, 16.6, 86.2, 545, 87),
    "NIST RTD 4 10s": (31.3, 14.0, 36.4, 23.6, 12.8, 510, 330),
    "NIST RTD 4 1min": (31.2, 14.0, 36.5, 23.9, 12.6, 510, 334),
    "NIST RTD 4 5min": (32.7, 14.0, 35.5, 23.7, 11.8, 497, 332),
    "NIST RTD 4 15min": (28.0, 15.1, 56.4, 31.0, 25.4, 851, 468),
    "NIST RTD 8 10s": (36.2, 16.8, 30.5, 21.5, 9.0, 513, 361),
    "NIST Canopy E": (41.6, 17.2, 27.1, 14.0, 13.1, 465, 241),
    "NIST Canopy W": (38.2, 18.5, 27.6, 16.0, 11.6, 511, 295),
    "DOE c10hov6": (35.0, 18.5, 40.7, 22.3, 18.4, 753, 412),
    "DOE t3pg1sv": (34.9, 18.8, 39.9, 22.7, 17.2, 750, 426),
    "DOE wca0c5m": (30.7, 18.6, 31.5, 25.5, 6.0, 586, 474),
    "DOE z0aygry": (30.1, 18.0, 32.4, 25.4, 7.0, 583, 456),
    "DOE lwcb907": (37.2, 19.1, 29.7, 20.0, 9.7, 567, 382),
    "DOE luemkoy": (35.8, 17.7, 32.1, 21.6, 10.5, 567, 381),
    "NREL Sanyo": (32.2, 16.3, 40.2, 25.7, 14.5, 655, 418),
    "U.H. System 1": (31.5, 19.9, 37.8, 16.4, 21.4, 751, 326),
    "U.H. System 2A": (32.2, 16.4, 32.4, 28.8, 3.6, 532, 472),
    "U.H. System 2B": (23.1, 16.4, 31.8, 25.9, 5.9, 522, 425),
}


@pytest.mark.parametrize("site", TABLE)
def test_the_heat_capacities_of_the_papers_table(site):
    """c_eq,max = tau_0/r_M and c_M = tau/r_M give every row, within its rounding."""
    r_max, r_m, c_max, c_m, c_film, tau_0, tau = TABLE[site]
    capacities = paper.heat_capacities(
        paper.TimeConstant(tau, tau_0, f=np.inf, points=70, table=pd.DataFrame()),
        paper.Estimate(r_max / 1e3, "K m²/W", points=50),
        paper.Estimate(r_m / 1e3, "K m²/W", points=60),
    )
    assert capacities["c_eq_min"].points == 50 and capacities["c_m"].points == 60
    found = {name: estimate.value / 1e3 for name, estimate in capacities.items()}
    slack = 0.05 / r_m + 0.5 / tau
    assert found["c_eq_max"] == pytest.approx(c_max, abs=0.06 + slack * c_max)
    assert found["c_m"] == pytest.approx(c_m, abs=0.06 + slack * c_m)
    assert found["c_film"] == pytest.approx(c_film, abs=0.12 + slack * c_max)
    assert found["c_eq_min"] == pytest.approx(tau_0 / r_max)


def test_the_papers_formula_with_f_does_not_give_its_table():
    """c_eq,max = tau_0·exp(-WS/f)/r_eq,min at 8 m/s is far off the first row."""
    assert 576 * np.exp(-8 / 11.8) / 15.3 < 0.6 * 37.7


@pytest.fixture(scope="module")
def calm_module():
    """A quick module without sky: steady regressions should find its steady models."""
    data = datasets.synthetic(
        180, seed=5, noise=0, model="wm1", dynamics="ewm", k=0.035, d=10.0, tau=20.0
    )
    return tuple(data[name] for name in COLUMNS)


def test_filters_are_masks_of_the_papers_limits():
    rows = pd.DataFrame(
        [
            (500, 20, 3, 40, True, False),
            (10, 20, 3, 18, False, True),
            (500, 20, 26, 40, False, False),
            (500, 61, 3, 80, False, False),
            (500, -3, 3, -1, False, False),
            (500, 20, 3, 81, False, False),
            (5, -25, 3, -22, False, False),
            (np.nan, 20, 3, 40, False, False),
        ],
        columns=[*COLUMNS, "day", "night"],
    )
    record = tuple(rows[name] for name in COLUMNS)
    assert paper.daytime(*record).tolist() == rows["day"].tolist()
    assert paper.night(*record).tolist() == rows["night"].tolist()


def test_resistances_and_wind_coefficients_are_recovered(calm_module):
    r_max = paper.r_eq_max(*calm_module)
    assert r_max.value == pytest.approx(0.035, rel=0.05)
    assert paper.d(*calm_module, k=0.035).value == pytest.approx(10.0, rel=0.05)
    r_m = paper.r_m(*calm_module)
    winds = calm_module[2].resample("5min").mean()
    typical = 0.035 * np.exp(-winds[winds > 6].mean() / 10.0)
    assert r_m.value == pytest.approx(typical, rel=0.1)
    film = paper.r_film(r_max, r_m)
    assert film.value == pytest.approx(r_max.value - r_m.value)
    assert film.points == min(r_max.points, r_m.points)


def test_k_w_is_recovered():
    data = datasets.synthetic(
        180, seed=5, noise=0, model="wm2", dynamics="ewm", k=0.035, k_w=0.0025, tau=20.0
    )
    found = paper.k_w(*(data[name] for name in COLUMNS))
    assert found.value == pytest.approx(0.0025, rel=0.1)
    assert found.points > 1000


def test_every_estimate_tells_its_points(calm_module):
    """They are the five-minute daytime averages that pass its filter."""
    frame = paper.averages(*calm_module)
    assert paper.r_eq_max(*calm_module).points == (frame["wind_speed"] < 0.5).sum()
    assert paper.r_m(*calm_module).points == (frame["wind_speed"] >= 6).sum()


def test_the_papers_tau_runs_backwards():
    """The table in the docstring of ``time_constant``."""
    data = datasets.synthetic(60, seed=1, noise=0)
    drivers = tuple(data[name] for name in DRIVERS)
    truth = (120, 200, 300, 400, 600, 900)
    found = []
    for tau in truth:
        module = fem.fem_temperature(*drivers, tau=tau, k=0.035, d=10)
        found.append(paper.time_constant(*drivers, module, 0.035).table["tau"][0])
        fit = fem.fit_fem(*drivers, module)
        assert fit.coefficients["tau"] == pytest.approx(tau, rel=1e-3)
    assert found == pytest.approx([1016, 886, 740, 620, 445, 289], abs=1)
    for value in found:
        assert f"{value:.0f}" in paper.time_constant.__doc__


def test_the_chosen_bin_is_the_last_up_to_which_tau_falls(month):
    drivers = tuple(month[name] for name in DRIVERS)
    module = fem.fem_temperature(*drivers, tau=378, k=0.035, d=10)
    found = paper.time_constant(*drivers, module, 0.035, min_points=5)
    used = found.table[found.table["used"]]
    assert found.value == used["tau"].iloc[-1]
    assert found.tau_0 == used["tau"].iloc[0] == found.table["tau"][:2].max()
    assert (used["tau"].diff().dropna() <= 20).all()
    following = found.table["tau"].get(used.index[-1] + 1, np.inf)
    assert not following <= found.value + 20
    assert found.points == used["points"].sum()


def test_a_tau_that_is_not_positive_is_refused(month):
    poa, air, wind = (month[name] for name in DRIVERS)
    with pytest.raises(ValueError, match=r"at \d-\d m/s give tau = -\d+ s"):
        paper.time_constant(poa, air, wind, air - 0.03 * poa, 0.035, min_points=5)


def test_the_measured_weeks_calm_slope_needs_its_intercept(week):
    """The figures in the docstring of ``r_eq_max``: 33.8 and 24.5 mK/(W/m²)."""
    record = tuple(week[name] for name in COLUMNS)
    line = paper.r_eq_max(*record, calm_wind=1.0)
    origin = paper.r_eq_max(*record, calm_wind=1.0, intercept=False)
    assert 1e3 * line.value == pytest.approx(33.8, abs=0.05)
    assert 1e3 * origin.value == pytest.approx(24.5, abs=0.05)


def test_the_cell_is_warmer_than_the_back_by_smoothed_irradiance(month):
    back, sun = month["temp_module"], month["poa_global"]
    cell = paper.cell_from_back(back, sun, k_bs_c=0.003, tau=378.0)
    pd.testing.assert_series_equal(cell, back + 0.003 * fem.ewm(sun, 378.0))
    found = paper.k_bs_c(cell, back, sun, tau=378.0)
    assert found.value == pytest.approx(0.003, rel=1e-9)


@pytest.mark.parametrize(
    ("step", "call"),
    [
        ("r_eq,max needs 20 points and has", lambda r: paper.r_eq_max(*r)),
        ("r_M needs 20 points and has 0", lambda r: paper.r_m(*r)),
        ("d of WM1 needs 10 points and has", lambda r: paper.d(*r, k=0.035)),
        ("k_W needs 3 irradiance bins", lambda r: paper.k_w(*r)),
        ("tau needs 10 step changes", lambda r: paper.time_constant(*r, 0.035)),
        ("k_BS-C needs 10 rows", lambda r: paper.k_bs_c(r[3], r[3], 0 * r[0], 378)),
    ],
)
def test_a_step_with_too_few_points_says_which_filter_left_them(month, step, call):
    hours = month.iloc[360:440]
    with pytest.raises(ValueError, match=step):
        call(tuple(hours[name] for name in COLUMNS))


def test_wind_that_does_not_cool_is_no_d(calm_module):
    poa, air, wind, module = calm_module
    with pytest.raises(ValueError, match="does not fall with wind"):
        paper.d(poa, air, wind, module + 40, k=0.02)
