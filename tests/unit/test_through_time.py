"""Coefficients by the period follow what changes, with errors that are right."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from conftest import DRIVERS
from matplotlib.dates import date2num
from matplotlib.figure import Figure

import pvlib_fem as fem
from pvlib_fem import datasets, plotting
from pvlib_fem._relaxation import relax, respond
from pvlib_fem._thermal.steady_models import STEADY_MODELS

BASE = {"u0": 25.0, "u1": 6.84, "capacity": 12e3, "bias": -1.0}
MODELS = {
    "ross": dict(k=0.03),
    "sapm": dict(a=-3.47, b=-0.0594),
    "wm1": dict(k=0.035, d=10.0),
    "wm2": dict(k=0.035, k_w=0.002),
    "pvsyst": dict(u_c=22.0, u_v=4.0),
    "noct": dict(noct=46.0),
}
#: days, step [s] and periods: months of a long record, weeks of a short one
STEPS = {60: (42, "W-MON"), 900: (180, "MS"), 3600: (360, "MS")}


def world(days=120, step=900, seed=0, noise=0.3, start="2023-05-01", **time_profiles):
    """A record whose coefficients follow time profiles, and these as columns."""
    data = datasets.synthetic(days, step, start, seed, noise=0)
    share = pd.Series(np.linspace(0.0, 1.0, len(data)), data.index)
    truth = pd.DataFrame({n: v + 0.0 * share for n, v in BASE.items()})
    for name, time_profile in time_profiles.items():
        if name == "gain":  # of the over-temperature
            truth[["u0", "u1"]] = truth[["u0", "u1"]].div(time_profile(share), axis=0)
        else:
            truth[name] *= time_profile(share)
    r_eq = (1.0 / (truth["u0"] + truth["u1"] * data["wind_speed"])).to_numpy()
    target = data["temp_air"].to_numpy() + data["poa_global"].to_numpy() * r_eq
    module = relax(target, 1.0, truth["capacity"].to_numpy() * r_eq / step)
    random = np.random.default_rng([seed, step])  # not that of the weather
    decay = np.full(len(data), np.exp(-step / 1800.0))
    kicks = random.standard_normal(len(data)) * np.sqrt(1.0 - decay**2)
    data["temp_module"] = module + truth["bias"] + noise * respond(decay, kicks, 0.0)
    return data, truth


def fitted(data, model="faiman", dynamics="balance", **how):
    columns = (data[name] for name in (*DRIVERS, "temp_module"))
    return fem.fit_fem(*columns, model=model, dynamics=dynamics, **how)


def against(fit, truth, freq="MS"):
    """The table, the mean of the truth, and the change of the truth in a period."""
    truth = truth.assign(r_eq=1.0 / (truth["u0"] + truth["u1"] * fit.daily.winds[0]))
    table = fit.through_time(freq)
    starts = table.loc["u0"].index
    period = starts[np.searchsorted(starts, truth.index, side="right") - 1]
    parts = truth.groupby(period)
    mean, span = parts.mean(), parts.max() - parts.min()
    return table.assign(
        truth=[mean.loc[start, name] for name, start in table.index],
        span=[span.loc[start, name] for name, start in table.index],
    )


def step_of(size):
    return lambda share: 1.0 + (size - 1.0) * (share > 0.5)


def drift_of(size):
    return lambda share: 1.0 + (size - 1.0) * share


def episode_of(size):
    return lambda share: 1.0 + (size - 1.0) * share.between(0.3, 0.7)


TIME_PROFILES = {
    "step": {"gain": step_of(1.2)},
    "drift": {"gain": drift_of(0.9)},
    "episode": {"gain": episode_of(0.8)},
    "wind": {"u1": step_of(0.8)},
    "sensor": {"bias": step_of(3.0)},
}


@pytest.mark.parametrize("step", STEPS)
@pytest.mark.parametrize("time_profile", TIME_PROFILES)
def test_it_follows_what_changes(time_profile, step):
    days, freq = STEPS[step]
    data, truth = world(days, step, noise=0.02, **TIME_PROFILES[time_profile])
    rows = against(fitted(data), truth, freq)
    # a period in which a step falls has no one truth
    moves = (rows["span"] / rows["truth"].abs()).groupby("start").transform("max")
    rows = rows[(moves < 0.03) & rows["value"].notna()]
    rows = rows.drop(index="capacity", errors="ignore")
    error = (rows["value"] - rows["truth"]).abs()
    assert error.loc["bias"].max() < 0.03
    # of a drift it is the mean over the sunny days, somewhere in its span
    within = 0.008 * rows["truth"].abs() + 0.5 * rows["span"]
    assert (error < within).drop(index="bias").all()
    size = {"wind": "u1", "sensor": "bias"}.get(time_profile, "r_eq")
    told = rows["value"].loc[size]
    # the true change is far larger than the tolerance
    assert told.max() - told.min() > 0.05 * abs(told.mean())


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("dynamics", ["ewm", "balance"])
def test_a_gain_of_a_fifth_is_found_whatever_the_model(model, dynamics):
    data = datasets.synthetic(90, 900, "2023-05-01", seed=2, noise=0)
    memory = {"capacity": 12e3} if dynamics == "balance" else {"tau": 400.0}
    function = fem.heat_balance if dynamics == "balance" else fem.fem_temperature
    usual = [data[name] for name in DRIVERS]
    plain = function(*usual, model=model, **memory, **MODELS[model])
    # the over-temperature of a linear model is as large as the irradiance
    hot = function(1.2 * usual[0], *usual[1:], model=model, **memory, **MODELS[model])
    if dynamics == "balance":  # whose time constant stays
        memory = {"capacity": 12e3 / 1.2}
    july = data.index >= "2023-07-01"
    data["temp_module"] = np.where(july, hot, plain)
    fit = fitted(data, model, dynamics)
    rows = fit.through_time()
    assert rows["stderr"].notna().all()
    table = rows["value"]
    law, wind = STEADY_MODELS[model], np.array([0.5, 3.0, 6.0])

    def resistance(start):
        found = table.xs(start, level="start")
        own = {name: found[name] for name in law.parameters}
        return law.resistance(wind, **own, **law.fixed)

    starts = table.index.unique("start")
    before = law.resistance(wind, **MODELS[model], **law.fixed)
    np.testing.assert_allclose(resistance(starts[0]), before, rtol=3e-3)
    np.testing.assert_allclose(resistance(starts[2]), 1.2 * before, rtol=3e-3)
    name, last = list(memory), table.xs(starts[2], level="start")
    assert last[name].tolist() == pytest.approx([*memory.values()], rel=0.015)


def test_intervals_hold_the_truth():
    held = []
    for seed in range(12):
        time_profile = list(TIME_PROFILES)[seed % len(TIME_PROFILES)]
        data, truth = world(180, 1800, seed=seed, **TIME_PROFILES[time_profile])
        rows = against(fitted(data), truth)
        moves = rows["span"].groupby("start").transform("max")
        rows = rows[(moves < 1e-9) | (time_profile == "drift")]
        held.append(rows["truth"].between(rows["lower"], rows["upper"]))
    held = pd.concat(held)
    # five per cent are three standard errors of 250 that know nothing of each other
    assert len(held) > 220
    assert 0.90 <= held.mean() <= 0.99


def test_one_period_of_all_is_the_fit():
    data, _ = world(40, 900, start="2023-01-02")
    fit = fitted(data)
    row = fit.through_time("YS").droplevel("start")
    assert len(row) == 5
    for name, value in fit.coefficients.items():
        assert row["value"][name] == pytest.approx(value, rel=1e-5)
        assert row["stderr"][name] == pytest.approx(fit.stderr[name], rel=1e-3)
    interval = fit.confidence_interval()
    for end in ("lower", "upper"):
        wanted = interval[end].drop("capacity")
        np.testing.assert_allclose(row[end][wanted.index], wanted, rtol=1e-3)


def test_a_period_is_a_fit_of_its_days_alone():
    """A separate fit of the period agrees within half of its error."""
    data, _ = world(90, 900, noise=0.5, gain=step_of(1.1))
    none = pd.Series(False, data.index)
    table = fitted(data, holdout=none).through_time()
    starts = table.index.unique("start").drop("2023-06-01 00:00-07:00")
    assert len(starts)
    for start in starts:
        month = data[(data.index.month == start.month)]
        alone = fitted(month, holdout=none[month.index])
        row = table.xs(start, level="start")
        for name, value in alone.coefficients.items():
            error = alone.stderr[name]
            assert row["value"][name] == pytest.approx(value, abs=error / 2.0)
            assert row["stderr"][name] == pytest.approx(error, rel=0.1)


def test_coefficients_that_do_not_vary_keep_their_value():
    data, _ = world(120, 900, u0=step_of(1.2))
    fit = fitted(data)
    free, alone = fit.through_time(), fit.through_time(coefficients="u0")
    assert [*alone.index.unique("coefficient")] == ["r_eq", "u0"]
    ends = alone["value"].loc["u0"].iloc[[0, -1]]
    assert ends.iloc[1] / ends.iloc[0] == pytest.approx(1.2, rel=0.02)
    # but where the step falls
    smaller = alone["stderr"].loc["u0"] < free["stderr"].loc["u0"]
    assert smaller.tolist() == [True, False, True, True]
    # a solution of the free ones, given the others: exactly so of bias alone
    bias = fit.through_time(coefficients=["bias"])
    assert [*bias.index.unique("coefficient")] == ["bias"]
    fitted_rows = fit.residual[~fit.holdout & fit.record.complete_rows(("poa_global",))]
    sun = fit.record["poa_global"][fit.residual.index.isin(fitted_rows.index)] > 20.0
    june = fitted_rows[sun].loc["2023-06"].mean()
    shift = bias["value"].loc["bias"].loc["2023-06"].iloc[0] - fit.coefficients["bias"]
    assert shift == pytest.approx(june, abs=1e-6)


def test_what_a_period_cannot_tell_has_a_reason():
    data, _ = world(100, 900, noise=0.1)
    june = data.index.month == 6  # in which u1 cannot be distinguished from u0
    calm = 2.0 + 1e-7 * np.random.default_rng(0).uniform(size=june.sum())
    data.loc[june, "wind_speed"] = calm
    short = data.drop(data.loc["2023-07-04":"2023-07-31"].index)
    fit = fitted(short, holdout=pd.Series(False, short.index))
    table = fit.through_time()
    may, june, july, _ = table.index.unique("start")
    numbers = ["value", "stderr", "lower", "upper"]
    for name in ("u0", "u1", "r_eq"):
        assert table.loc[(name, june), numbers].isna().all()
    assert "does not determine u0 and u1" in table.loc[("u0", june), "why"]
    assert np.isfinite(table.loc[("bias", june), "stderr"])
    few = table.xs(july, level="start")
    assert few[numbers].isna().all(axis=None) and (few["days"] == 3).all()
    assert few["why"].str.contains("fitted days: 3").all()
    fine = table.xs(may, level="start")
    assert fine[numbers].notna().all(axis=None) and (fine["why"] == "").all()


def test_a_memory_that_the_steps_do_not_tell_has_no_error():
    data, truth = world(120, 3600, capacity=lambda share: 0.5 + 0.0 * share)
    fit = fitted(data, fixed={"bias": -1.0})
    rows = against(fit, truth).loc["capacity"]
    unknown = rows["stderr"].isna()
    assert unknown.any()
    assert rows["why"][unknown].str.contains("steps of 3600 s").all()
    assert (rows["lower"][unknown] == 0.0).all()
    assert rows["truth"].between(rows["lower"], rows["upper"])[unknown].all()


def test_a_month_without_days_stands_in_the_table():
    data, _ = world(95, 900)
    gap = data.drop(data.loc["2023-06"].index)
    table = fitted(gap).through_time()
    assert (table["days"].loc["u0"] > 0).tolist() == [True, False, True, True]


@pytest.mark.parametrize("freq", ["h", "36h", "nonsense", ""])
def test_a_period_that_is_none_is_refused(freq):
    data, _ = world(20, 1800)
    with pytest.raises(ValueError, match="freq = "):
        fitted(data).through_time(freq)


def test_a_fit_without_sums_says_so(tmp_path):
    data, _ = world(20, 900)
    fit = fitted(data, dynamics="ewm")
    fit.to_json(tmp_path / "fit.json")
    with pytest.raises(ValueError, match="read from a file"):
        fem.FemFit.from_json(tmp_path / "fit.json").through_time()
    paper = replace(fit, method="paper", daily=None)
    with pytest.raises(ValueError, match="the paper's recipe"):
        paper.through_time()
    with pytest.raises(ValueError, match=r"rain was not fitted.*u0, u1, tau, bias"):
        fit.through_time(coefficients="rain")


def test_an_effect_can_vary_too():
    """A wall that is built at half of the record."""
    data, _ = world(120, 900)
    data["wind_direction"] = np.random.default_rng(0).uniform(0, 360, len(data))
    north = np.cos(np.radians(data["wind_direction"]))
    late = np.linspace(0, 1, len(data)) > 0.5
    warm = 1.0 + 0.15 * north * late
    quick = dict(model="faiman", capacity=BASE["capacity"], u0=25.0, u1=6.84)
    usual = [data[name] for name in DRIVERS]
    wind = usual[2] / warm
    data["temp_module"] = fem.heat_balance(*usual[:2], wind, **quick)
    how = dict(effects="wind_direction", wind_direction=data["wind_direction"])
    fit = fitted(data, **how)
    name = next(n for n in fit.coefficients if n.endswith(".north"))
    assert name not in fit.through_time().index.unique("coefficient")
    time_profile = fit.through_time(coefficients=["u0", "u1", name]).loc[name]
    assert (
        abs(time_profile["value"].iloc[0]) < 4.0 * time_profile["stderr"].iloc[0] + 0.01
    )
    assert abs(time_profile["value"].iloc[-1]) > 10.0 * time_profile["stderr"].iloc[-1]


def test_the_picture_has_the_numbers_and_the_changes():
    data, _ = world(150, 1800, gain=step_of(1.2))
    fit = fitted(data)
    table = fit.through_time()
    names = [*table.index.unique("coefficient")]
    given = Figure(layout="constrained").subplots()
    ax = plotting.plot_through_time(fit, given, changes=["2023-07-15"])
    assert ax is given and len(ax.figure.axes) == len(names)
    assert names
    for name, panel in zip(names, ax.figure.axes):
        drawn = panel.containers[0].lines[0].get_ydata()
        np.testing.assert_array_equal(drawn, table.loc[name, "value"])
        dashed = [line for line in panel.lines if line.get_linestyle() == "--"]
        changed = date2num(pd.Timestamp("2023-07-15"))
        assert [line.get_xdata()[0] for line in dashed] == [changed]
        assert name in panel.get_ylabel()
    quarter = plotting.plot_through_time(fit.through_time("QS", "u0"))
    assert len(quarter.figure.axes) == 2
    with pytest.raises(ValueError, match="no date"):
        plotting.plot_through_time(fit, changes=["some day"])


@pytest.mark.parametrize(("days", "drawn"), [(100, False), (130, True)])
def test_the_page_of_a_long_record_has_its_months(days, drawn):
    data, _ = world(days, 3600)
    assert ("Monthly coefficients" in fitted(data).to_html()) is drawn
