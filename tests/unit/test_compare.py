"""Comparison of models: the table, its steps, and the models of others."""

import warnings

import numpy as np
import pandas as pd
import pvlib
import pytest
from conftest import COLUMNS, DRIVERS

import pvlib_fem as fem
from pvlib_fem import datasets, paper, plotting
from pvlib_fem._thermal_parameters import unit_mass
from pvlib_fem.drivers._sky_deficit import STEFAN_BOLTZMANN
from pvlib_fem.paper import comparators
from pvlib_fem.paper.comparators import (
    COMPARATORS,
    armstrong_hurley_tau,
    fitted,
)

SAPM = dict(a=-3.47, b=-0.0594)


@pytest.fixture(scope="module")
def fortnight():
    data = datasets.synthetic(14, 300, seed=2)
    clouds = np.sin(np.arange(len(data)) / 50.0)
    data["longwave_down"] = 330.0 + 50.0 * clouds
    return data


@pytest.fixture(scope="module")
def compared(fortnight):
    columns = (fortnight[name] for name in COLUMNS)
    longwave = fortnight["longwave_down"]
    return fem.compare_models(*columns, resolutions=(1800, 300), ir_down=longwave)


def test_prilliman_is_pvlibs_over_pieces_and_gaps(month, monkeypatch):
    """Row by row what pvlib gives a piece without gaps, however few fit in memory."""
    monkeypatch.setattr(unit_mass, "CELLS", 20 * 100)
    two = month.tz_localize(None).iloc[:2000]
    two = two.drop(two.index[900:905])
    sun, air, wind = (two[name] for name in DRIVERS)
    found = comparators.prilliman(sun, air, wind, **SAPM, bias=1.0)
    for rows in (slice(0, 900), slice(900, None)):
        steady = pvlib.temperature.sapm_module(
            *(two[name].iloc[rows] for name in DRIVERS), **SAPM
        )
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # pandas 3 warns of a call of pvlib's own
            expected = pvlib.temperature.prilliman(steady, wind.iloc[rows])
        np.testing.assert_allclose(found.iloc[rows] - 1.0, expected, rtol=1e-12)


def test_prilliman_leaves_long_steps_alone(month):
    hourly = month.resample("1h").mean()
    drivers = [hourly[name] for name in DRIVERS]
    steady = pvlib.temperature.sapm_module(*drivers, **SAPM)
    pd.testing.assert_series_equal(
        comparators.prilliman(*drivers, **SAPM), steady, check_names=False
    )


@pytest.mark.parametrize(
    ("wind", "both_faces", "minutes"),
    [(0.77, 5.8123, 7.4166), (2.14, 4.8730, 6.0833), (5.76, 4.1749, 3.966)],
)
def test_the_time_constants_that_armstrong_and_hurley_predict(
    wind, both_faces, minutes
):
    """Their Table 3: wind, free convection and time constant of three step changes."""
    tau = armstrong_hurley_tau(wind, free=both_faces / 2) / 60.0
    assert tau == pytest.approx(minutes, rel=0.005)


def test_armstrong_and_hurleys_capacity_is_that_of_their_layers():
    layers = [
        *((3e-3, 3000, 500), (100e-9, 2400, 691), (225e-6, 2330, 677)),
        *((500e-6, 960, 2090), (10e-6, 2700, 900), (0.1e-3, 1200, 1250)),
    ]
    capacity = sum(thickness * density * heat for thickness, density, heat in layers)
    assert capacity == pytest.approx(comparators.GLASS_TEDLAR, rel=1e-3)


def test_models_of_others_are_the_steady_one_where_nothing_changes():
    index = pd.date_range("2023-06-01 06:00", periods=300, freq="1min")
    sun, air, wind = (pd.Series(float(v), index) for v in (800, 20, 2))
    sapm = pvlib.temperature.sapm_module(800.0, 20.0, 2.0, **SAPM)
    for name in ("prilliman", "armstrong_hurley"):
        answer = COMPARATORS[name].function(sun, air, wind, **SAPM)
        assert answer.iloc[-1] == pytest.approx(sapm)
    answer = comparators.veldhuis(sun, air, wind, **SAPM, tau=1020.0, bias=-2.0)
    assert answer.iloc[-1] == pytest.approx(sapm - 2.0)
    longwave = STEFAN_BOLTZMANN * (283.15**4) + 0.0 * sun  # a sky 10 K below the air
    faiman = dict(u1=25.0, u2=6.84)
    warm = comparators.barry(sun, air, wind, longwave, **faiman, u3=0.2, tau=589.0)
    steady = pvlib.temperature.faiman(800.0, 20.0, 2.0, u0=25.0, u1=6.84)
    assert warm.iloc[-1] == pytest.approx(steady - 2.0)


@pytest.mark.parametrize("name", COMPARATORS)
def test_a_comparator_finds_its_own_coefficients(fortnight, name):
    """From noise of 0.1 K; Barry's model is fitted without a bias, as theirs."""
    comparator = COMPARATORS[name]
    truth = dict(a=-3.4, b=-0.08, bias=-1.5, tau=700.0, u1=27.0, u2=5.0, u3=0.15)
    truth = {key: truth[key] for key in comparator.parameters}
    drivers = [fortnight[column] for column in (*DRIVERS, *comparator.columns)]
    module = comparator.function(*drivers, **truth)
    module += np.random.default_rng(0).normal(0, 0.1, len(module))
    found = fitted(comparator, drivers, module, slice(None))
    assert found == pytest.approx(truth, rel=0.02)


def test_a_fine_record_is_fitted_in_means_where_a_comparator_says_so(month):
    """Prilliman's fit at 20 s equals the fit to means over a minute."""
    comparator = COMPARATORS["prilliman"]
    minutes = month.iloc[600:1000]
    fine = minutes.resample("20s").ffill()
    rows = np.zeros(len(fine), bool)
    rows[300:] = True
    drivers, module = [fine[n] for n in DRIVERS], fine["temp_module"]
    found = fitted(comparator, drivers, module, rows)
    coarse = [fine[n].resample("60s").mean() for n in COLUMNS]
    expected = fitted(
        comparator, coarse[:3], coarse[3], np.arange(len(coarse[0])) >= 100
    )
    assert found == pytest.approx(expected, rel=1e-6)


def test_the_table_has_what_fit_fem_says_of_each_model(compared, fortnight):
    columns = [fortnight[name] for name in COLUMNS]
    fit = fem.fit_fem(*columns, model="wm1")
    assert len(fit.scores)
    for step, row in fit.scores.iterrows():
        for score in ("rmse", "mae", "mbe"):
            found = compared.table.loc[(300.0, "wm1", step), score]
            assert found == pytest.approx(row[f"{score}_test"], rel=1e-12)
    assert compared.coefficients[300.0, "wm1", "fem"]["k"] == fit.coefficients["k"]
    rows = fit.holdout & paper.night(*columns)
    dark = fem.scores.rmse(columns[3][rows], fit.predict(*columns[:3])[rows])
    assert compared.table.loc[(300.0, "wm1", "fem"), "rmse_night"] == pytest.approx(
        dark
    )
    balance = fem.fit_fem(*columns, model="faiman", dynamics="balance")
    error = balance.scores.loc["fem", "rmse_test"]
    assert compared.by_step().loc["fem", "torres_lobera"] == pytest.approx(error)
    assert compared.best() == "torres_lobera"  # the model that made the record


def test_the_shapes_of_the_papers_tables(compared):
    steps = ["standard", "filter", "ewm", "fem"]
    models = ["ross", "sapm", "faiman", "wm1", "wm2"]
    others = ["prilliman", "armstrong_hurley", "veldhuis", "barry", "torres_lobera"]
    wide = compared.by_step("mae")
    assert (list(wide.index), list(wide)) == (steps, models + others)
    assert wide[models].notna().all().all()
    assert wide[others].notna().sum().tolist() == [1] * 5
    sweep = compared.by_resolution()
    assert sweep.index.tolist() == compared.resolutions == [300.0, 1800.0]
    text = str(compared)
    assert "steps of 300 s" in text and "steps of 1800 s" in text
    assert compared._repr_html_().count("<tr") == len(compared.table) + 2
    assert len(compared.to_csv().splitlines()) == len(compared.table) + 1


def test_resolutions_are_means_of_the_record(compared, fortnight):
    half_hours = fortnight.resample("1800s").mean()
    columns = (half_hours[name] for name in COLUMNS)
    fit = fem.fit_fem(*columns, model="faiman")
    one = compared.table.loc[(1800.0, "faiman", "fem")]
    assert one["rmse"] == pytest.approx(fit.scores.loc["fem", "rmse_test"])


def test_what_cannot_be_fitted_is_an_empty_cell_and_a_note(fortnight):
    columns = [fortnight[name] for name in COLUMNS]
    found = fem.compare_models(
        *columns, models="wm1", method="paper", calm_wind=0.01, comparators="barry"
    )
    assert found.table["rmse"].isna().all()
    assert "barry is not fitted: it needs longwave_down" in found.notes
    assert any(
        note.startswith("wm1 at 300 s: r_eq,max needs 20") for note in found.notes
    )
    assert str(found).count("note: ") == 2


def test_rows_held_out_by_choice_are_those_that_count(fortnight):
    columns = [fortnight[name] for name in COLUMNS]
    out = pd.Series(fortnight.index.day <= 5, fortnight.index)
    usual = dict(models="faiman", comparators=())
    found = fem.compare_models(*columns, holdout=out, resolutions=(300, 900), **usual)
    rows = out & paper.daytime(*columns)
    assert found.table.loc[(300.0, "faiman", "fem"), "points"] == rows.sum()
    assert found.table.loc[(900.0, "faiman", "fem"), "points"] < rows.sum() / 2.5


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (dict(models="wm3"), "unknown models 'wm3'; they are ross, sapm"),
        (dict(comparators=["king"]), "unknown comparators 'king'; they are prilliman"),
        (dict(method="ols"), "unknown methods 'ols'"),
        (dict(models=(), comparators=()), "nothing to compare"),
        (dict(resolutions=[60]), "resolution 60 s is finer than the record's 300 s"),
        (dict(resolutions=[pd.Timedelta("1h")]), "resolution Timedelta.* of seconds"),
        (dict(resolutions="15min"), "resolution '15min' must be a positive number"),
        (dict(rain=None), "no model uses rain; they use poa_global, .* longwave_down"),
    ],
)
def test_what_compare_cannot_do_is_refused_by_name(fortnight, options, message):
    with pytest.raises(ValueError, match=message):
        fem.compare_models(*(fortnight[name] for name in COLUMNS), **options)


def test_a_frame_has_the_columns(fortnight):
    columns = (fortnight[name] for name in COLUMNS)
    usual = dict(models="wm1", comparators="barry")
    found = fem.compare_models(
        fortnight.rename(columns={"longwave_down": "ir_down"}), **usual
    )
    want = fem.compare_models(
        *columns, longwave_down=fortnight["longwave_down"], **usual
    )
    pd.testing.assert_frame_equal(found.table, want.table)


def test_a_record_without_a_column_is_refused(fortnight):
    light, air, wind, module = (fortnight[name] for name in COLUMNS)
    with pytest.raises(ValueError, match="have no column wind_speed; they have ghi"):
        fem.compare_models(fortnight.drop(columns="wind_speed"))
    with pytest.raises(ValueError, match="no column wind_speed; give all of poa_glob"):
        fem.compare_models(light, air, temp_module=module)
    with pytest.raises(ValueError, match="wind_speed given in addition to a frame"):
        fem.compare_models(fortnight, wind_speed=wind)


def test_scores_and_steps_that_are_not_there_are_named(compared):
    with pytest.raises(ValueError, match="unknown score 'rsme'; they are rmse, mae, m"):
        compared.by_step("rsme")
    with pytest.raises(ValueError, match="unknown step 'bias'; they are standard, fil"):
        compared.by_resolution(step="bias")


def test_one_resolution_needs_no_list(fortnight):
    usual = dict(models="ross", comparators=())
    found = fem.compare_models(fortnight, resolutions=900, **usual)
    assert found.resolutions == [900.0]


def test_a_resolution_that_was_not_compared_is_refused(compared):
    with pytest.raises(ValueError, match="no resolution 60 s"):
        compared.by_step(resolution=60)


def test_the_gain_over_prilliman_in_the_measured_week(week):
    """0.07 K at the paper's tau with Sandia's steady fit, 0.15 K fitted together."""
    record = [week[name] for name in COLUMNS]
    steady = fem.fit_fem(*record, model="sapm", dynamics="steady")
    a, b = (steady.coefficients[name] for name in ("a", "b"))
    rows = paper.daytime(*record)
    left = {}
    for name, answer in (
        ("steady", pvlib.temperature.sapm_module(*record[:3], a, b)),
        ("prilliman", comparators.prilliman(*record[:3], a, b)),
        ("ewm", fem.fem_temperature(*record[:3], model="sapm", a=a, b=b)),
    ):
        bias = fem.scores.mbe(*(c[rows & ~steady.holdout] for c in (record[3], answer)))
        held = rows & steady.holdout
        left[name] = fem.scores.rmse(record[3][held], answer[held] + bias)
    assert left == pytest.approx(dict(steady=3.83, prilliman=1.72, ewm=1.65), abs=0.006)
    found = fem.compare_models(*record).by_resolution().iloc[0]
    expected = {
        **dict(ross=2.90, sapm=1.56, faiman=1.60, wm1=1.56, wm2=1.52, prilliman=1.71),
        **dict(armstrong_hurley=1.74, veldhuis=1.61, torres_lobera=1.56),
    }
    assert found.to_dict() == pytest.approx(expected, abs=0.006)


@pytest.fixture
def ax():
    from matplotlib.figure import Figure

    return Figure(layout="constrained").subplots()


def drawn(ax):
    return {line.get_label(): line.get_xydata().T for line in ax.get_lines()}


def test_the_pictures_of_a_comparison_have_its_numbers(compared, ax):
    assert compared.plot(ax) is ax  # several resolutions: over the resolution
    lines = drawn(ax)
    np.testing.assert_array_equal(lines["wm2"][1], compared.by_resolution()["wm2"])
    np.testing.assert_array_equal(lines["barry"][0], [300.0, 1800.0])
    assert [t.get_text() for t in ax.get_xticklabels()] == ["5 min", "30 min"]
    ax.clear()
    plotting.plot_comparison(compared, ax, "mae")
    assert ax.get_ylabel() == "MAE by day, held-out days [K]"
    lines, table = drawn(ax), compared.by_step("mae")
    np.testing.assert_array_equal(lines["wm1"][1], table["wm1"])
    assert lines["veldhuis"][1] == pytest.approx([table.loc["fem", "veldhuis"]])


def test_one_resolution_is_a_picture_by_step(fortnight, ax):
    columns = (fortnight[name] for name in COLUMNS)
    found = fem.compare_models(*columns, models=("wm1", "ross"), comparators=())
    found.plot(ax)
    assert set(drawn(ax)) == {"wm1", "ross"}
    with pytest.raises(ValueError, match="one resolution makes no line"):
        plotting.plot_resolutions(found, ax)


def test_the_picture_of_energy_errors_has_both_sides(ax):
    error = fem.scores.EnergyError(6.0, 4.0, -2.0, insolation=200.0)
    plotting.plot_energy_error({"mine": error}, ax)
    assert [bar.get_width() for bar in ax.patches] == [2.0, -1.0]
    assert drawn(ax)["both together"][0] == [1.0]
    assert [t.get_text() for t in ax.get_yticklabels()] == ["mine"]


def test_the_lines_of_the_estimators_are_theirs(month, ax):
    record = [month[name] for name in COLUMNS]
    paper.plot_resistances(*record, calm_wind=1.0, ax=ax)
    words = f"r_eq,max = {1e3 * paper.r_eq_max(*record, 1.0).value:.1f} mK/(W/m²)"
    (calm,) = (line for name, line in drawn(ax).items() if name.endswith(words))
    slope = (calm[1][1] - calm[1][0]) / (calm[0][1] - calm[0][0])
    assert slope == pytest.approx(paper.r_eq_max(*record, 1.0).value)
    ax.clear()
    paper.plot_k_w(*record, ax=ax)
    for free in (False, True):
        k_w = paper.k_w(*record, intercept=free).value
        (line,) = (v for n, v in drawn(ax).items() if f"k_W = {1e3 * k_w:.2f}" in n)
        assert np.diff(line[1]) / np.diff(line[0]) == pytest.approx(-k_w)
    ax.clear()
    paper.plot_step_changes(*record, bins=(0, 1), ax=ax)
    assert len([n for n in drawn(ax) if "mK" in n]) == 2
    with pytest.raises(ValueError, match="no wind bin of 20 m/s has ten step changes"):
        paper.plot_step_changes(*record, bins=(20,), ax=ax)
    ax.clear()
    tau = paper.time_constant(*record, 0.033)
    paper.plot_tau_bins(tau, ax)
    lines = drawn(ax)
    np.testing.assert_array_equal(lines["used"][1], tau.table["tau"][tau.table["used"]])
    fall = lines[f"f = {tau.f:.1f} m/s"][1]
    assert (fall[0], fall[-1]) == pytest.approx((tau.tau_0, tau.value))


def test_impossible_values_are_in_no_mean(fortnight):
    """A logger's fill values leave the half hour, or its mean, without a trace."""
    columns = [fortnight[name].copy() for name in COLUMNS]
    columns[3].iloc[[700, 1300]] = -99.0
    usual = dict(models="wm1", comparators=(), resolutions=(1800,))
    found = fem.compare_models(*columns, **usual)
    clean = fem.compare_models(*(fortnight[name] for name in COLUMNS), **usual)
    rmse, expected = (c.table["rmse"].to_numpy() for c in (found, clean))
    np.testing.assert_allclose(rmse, expected, atol=0.01)


def test_a_record_of_which_nothing_can_be_fitted_says_so(fortnight):
    columns = [fortnight[name].iloc[:40] for name in COLUMNS]  # a night
    found = fem.compare_models(
        *columns, models="wm1", comparators=("veldhuis", "torres_lobera")
    )
    assert found.table["rmse"].isna().all()
    assert any("veldhuis at 300 s: 4 coefficients need more" in n for n in found.notes)
    with pytest.raises(
        ValueError, match=r"no model has a score: .*least squares needs"
    ):
        found.best()


def test_the_week_with_and_without_a_bias(week):
    """The paper's table; `compare_models` has its first and last row."""
    record = [week[name] for name in COLUMNS]
    table = {
        "ross": (4.70, 4.42, 3.84, 2.90, 2.95),
        "sapm": (4.07, 3.83, 2.73, 1.56, 1.53),
        "faiman": (4.10, 3.84, 2.80, 1.60, 1.56),
        "wm2": (4.04, 3.82, 2.65, 1.52, 1.49),
    }
    for model, expected in table.items():
        scores = {
            dynamics: fem.fit_fem(*record, model=model, dynamics=dynamics).scores
            for dynamics in ("steady", "ewm", "balance")
        }
        found = [
            scores["steady"].loc["standard", "rmse_test"],
            scores["steady"].loc["fem", "rmse_test"],
            scores["ewm"].loc["ewm", "rmse_test"],
            scores["ewm"].loc["fem", "rmse_test"],
            scores["balance"].loc["fem", "rmse_test"],
        ]
        assert found == pytest.approx(expected, abs=0.006)


def test_comparators_alone_are_a_table_and_a_picture(fortnight, ax):
    columns = [fortnight[name] for name in COLUMNS]
    found = fem.compare_models(
        *columns, models=(), comparators=("veldhuis", "torres_lobera")
    )
    assert found.by_step().index.tolist() == ["fem"]
    found.plot(ax, score="rmse_night")
    assert ax.get_ylabel() == "RMSE by night, held-out days [K]"
    assert set(drawn(ax)) == {"veldhuis", "torres_lobera"}


def test_gaps_and_zones_and_nullable_columns_are_compared_as_they_are_fitted(fortnight):
    some = fortnight.drop(fortnight.index[1000:1100]).copy()
    some.iloc[50:60, some.columns.get_loc("wind_speed")] = np.nan
    plain = [some[name] for name in COLUMNS]
    usual = dict(models="wm1", comparators=("veldhuis", "prilliman"))
    expected = fem.compare_models(*plain, **usual).table
    nullable = [column.astype("Float64") for column in plain]
    pd.testing.assert_frame_equal(
        fem.compare_models(*nullable, **usual).table, expected
    )
    assert expected["rmse"].notna().all()
