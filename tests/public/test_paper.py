"""The paper's estimators, its tables, and where it cannot be taken literally."""

import numpy as np
import pandas as pd
import pytest
from conftest import COLUMNS, DRIVERS

import pvlib_fem as fem
from pvlib_fem import datasets, paper

TABLE = paper.table_3().dropna()  # the rows that have a tau


@pytest.mark.parametrize("site", TABLE.index)
def test_the_heat_capacities_of_the_papers_table(site):
    """c_eq,max = tau_0/r_M and c_M = tau/r_M give every row, within its rounding."""
    row = TABLE.loc[site]
    capacities = paper.heat_capacities(
        paper.TimeConstant(row.tau, row.tau_0, row.f, points=70, table=pd.DataFrame()),
        paper.Estimate(row.r_eq_max, "K m²/W", points=50),
        paper.Estimate(row.r_m, "K m²/W", points=60),
    )
    assert capacities["c_eq_min"].points == 50 and capacities["c_m"].points == 60
    found = {name: estimate.value / 1e3 for name, estimate in capacities.items()}
    slack = 0.05e-3 / row.r_m + 0.5 / row.tau
    c_max = row.c_eq_max / 1e3
    assert found["c_eq_max"] == pytest.approx(c_max, abs=0.06 + slack * c_max)
    assert found["c_m"] == pytest.approx(
        row.c_m / 1e3, abs=0.06 + slack * row.c_m / 1e3
    )
    assert found["c_film"] == pytest.approx(row.c_film / 1e3, abs=0.12 + slack * c_max)
    assert found["c_eq_min"] == pytest.approx(row.tau_0 / row.r_eq_max / 1e3)


def test_eq_17_at_the_wind_of_each_sites_last_bin_is_its_c_m():
    """f·ln(tau_0/tau) is a whole number N, and tau_0·exp(-N/f)/r_M the table's c_M."""
    way = TABLE["f"] * np.log(TABLE["tau_0"] / TABLE["tau"])
    bins = way.round()
    assert (way - bins).abs().max() < 0.04
    assert bins.between(4, 10).all() and (bins == 10).sum() == 2
    by_eq_17 = TABLE["tau_0"] * np.exp(-bins / TABLE["f"]) / TABLE["r_m"]
    np.testing.assert_allclose(by_eq_17, TABLE["c_m"], rtol=0.005)


def test_the_papers_mean_time_constants():
    """378 ± 60 s of fixed mountings and 364 ± 90 s with the tracker."""
    table = paper.table_3()
    fine = table[table["step"] <= 300]
    fixed = fine.loc[fine["mounting"] != "tracker", "tau"]
    assert fixed.mean() == pytest.approx(378.5, abs=0.1)
    assert fixed.std(ddof=0) == pytest.approx(60.0, abs=0.1)
    assert fine["tau"].mean() == pytest.approx(364, abs=0.5)
    by_mounting = paper.tau_by_mounting()
    assert by_mounting["records"].sum() == len(fine) == 20
    assert by_mounting.loc["tracker", "mean"] == 87
    own = TABLE.loc[["Heidelberg 1", "Heidelberg 2A", "Heidelberg 2B"], "tau"]
    barry = [589, 509, 547]
    assert own.rank().tolist() == (-pd.Series(barry)).rank().tolist()


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
    way = used.index[-1] - used.index[0]
    assert found.f == pytest.approx(way / np.log(found.tau_0 / found.value))


def windy_steps(interval):
    """Step changes in even winds of 0.5 to 11.5 m/s, of an exact exponential."""
    index = pd.date_range("2023-06-01", periods=12 * 400, freq=interval)
    wind = pd.Series(np.repeat(np.arange(12) + 0.5, 400), index)
    sun = pd.Series(500.0 + 300.0 * np.sin(np.arange(len(index)) / 7.0), index)
    over = 0.03 * sun * np.exp(-wind / 10.0)
    return sun, 0.0 * sun + 20.0, wind, 20.0 + over


@pytest.mark.parametrize(("interval", "apart"), [("5min", 4), ("15min", 1)])
def test_tau_falls_to_the_last_bin_there_is_and_f_is_its_fall(interval, apart):
    """Past 8 m/s, at any interval; a slope r·exp(-WS/d) gives f = d."""
    record = windy_steps(interval)
    found = paper.time_constant(*record, 0.03, interval=interval, apart=apart)
    assert found.table.index[-1] == 11 and found.table["used"].all()
    seconds = apart * pd.Timedelta(interval).total_seconds()
    assert found.tau_0 == pytest.approx(seconds * np.exp(-0.05))
    assert found.value == pytest.approx(seconds * np.exp(-1.15))
    assert found.f == pytest.approx(10.0)
    steps = paper.step_changes(*record, interval=interval, apart=apart)
    assert len(steps) == found.points


def test_averages_shorter_than_the_records_step_are_refused():
    with pytest.raises(ValueError, match=r"step of 15min, longer .* interval='15min'"):
        paper.time_constant(*windy_steps("15min"), 0.03)


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
    few = dict(calm_wind=0.5, min_points=10)
    for intercept, expected in ((True, 28.5), (False, 24.9)):
        found = paper.r_eq_max(*record, intercept=intercept, **few)
        assert found.points == 10
        assert 1e3 * found.value == pytest.approx(expected, abs=0.05)


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


def test_the_bias_by_night_leaves_more_than_the_fitted_one_in_the_week(week):
    record = tuple(week[name] for name in COLUMNS)
    fit = fem.fit_fem(*record)
    bias = paper.night_bias(*(column[~fit.holdout] for column in record)).value
    held = fem.fit_fem(*record, fixed={"bias": bias})
    assert fit.coefficients["bias"] == pytest.approx(-4.44, abs=0.005)
    assert bias == pytest.approx(-4.99, abs=0.005)
    errors = [f.scores.loc["fem", "rmse_test"] for f in (fit, held)]
    assert errors == pytest.approx([1.56, 1.65], abs=0.006)


def test_mae_times_gamma_is_off_to_either_side_in_the_week(week):
    record = tuple(week[name] for name in COLUMNS)
    rows = paper.daytime(*record)
    options = {
        0.87: dict(dynamics="steady"),
        1.21: dict(dynamics="ewm", fixed={"bias": 0.0}),
        0.99: dict(dynamics="ewm"),
    }
    for expected, how in options.items():
        modelled = fem.fit_fem(*record, **how).predict(*record[:3])[rows]
        measured = record[3][rows]
        error = fem.scores.energy_error(record[0][rows], measured, modelled)
        ratio = 0.35 * fem.scores.mae(measured, modelled) / error.performance_ratio
        assert ratio == pytest.approx(expected, abs=0.006)


def test_pvsysts_absorbed_share_is_pvlibs_and_not_the_papers():
    """15/(0.9·(1−0.15)) = 19.6, where the paper has 15/(0.9−0.15) = 20.0."""
    pvsyst = dict(u_c=15.0, u_v=0.0, module_efficiency=0.15, alpha_absorption=0.9)
    u0 = fem.translate_coefficients(pvsyst, "pvsyst", "faiman")["u0"]
    assert u0 == pytest.approx(19.61, abs=0.005)


def test_the_effective_maximum_wind_is_a_quantile_of_averages(month):
    """Six to eight m/s in the paper; of a Weibull wind of shape 2, mean 3 m/s, 7.3."""
    wind = month["wind_speed"]
    found = paper.wind_max(wind)
    means = wind.resample("5min").mean()
    assert (means < found.value).mean() == pytest.approx(0.99, abs=1e-3)
    assert found.points == len(means) and 6.0 < found.value < 8.0
    assert paper.wind_max(wind, share=1.0).value == means.max()
    with pytest.raises(ValueError, match="needs 10 averages over 5min and has 2"):
        paper.wind_max(wind.iloc[:10])
    with pytest.raises(ValueError, match="share = 0 must be above 0"):
        paper.wind_max(wind, share=0)


def test_what_convection_takes_off_is_wm2s_wind(month):
    """T_o = G·k − G/h, and nothing in calm air."""
    poa, air, wind = (month[name] for name in DRIVERS)
    h = paper.convection(wind, k_w=0.0025)
    over = fem.wm2(poa, air, wind, k=0.035, k_w=0.0025) - air
    np.testing.assert_allclose(over, poa * 0.035 - poa / h, atol=1e-9)
    assert paper.convection(0.0, 0.0025) == np.inf
    assert paper.convection(20.0, 0.0025) == paper.convection(8.0, 0.0025)
    with pytest.raises(ValueError, match="k_w = -1 must be positive"):
        paper.convection(2.0, -1)
