"""Pictures show the numbers that they are of."""

import datetime
import warnings
from dataclasses import replace
from itertools import pairwise
from types import SimpleNamespace

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import pytest
from matplotlib.figure import Figure

from pvlib_fem import datasets, fit_fem, plotting, simulator
from pvlib_fem._loop.close import close_loop
from pvlib_fem._record.column_names import COLUMNS
from pvlib_fem.plotting._style import LONGEST, dated_axis, escaped_name, outside_legend
from pvlib_fem.plotting._vector import svg


@pytest.fixture(scope="module")
def closed():
    """A loop that finds the heat behind two columns of the user's own."""
    data = datasets.synthetic(90, 1800)[list(COLUMNS)]
    random = np.random.default_rng(0)
    for name in ("fan", "cost $"):
        data[name] = np.repeat(random.uniform(size=len(data) // 6) > 0.6, 6) * 1.0
        data["temp_module"] += 2.0 * data[name]
    found = close_loop(data)
    assert set(found.effects) == {"driver:fan", "driver:cost $"}
    return found


@pytest.fixture
def ax():
    return Figure(layout="constrained").subplots()


@pytest.mark.parametrize(
    "draw",
    [
        plotting.plot_before_after,
        plotting.plot_contributions,
        plotting.plot_steps,
        plotting.plot_budget,
        lambda loop, ax=None: plotting.plot_fit(loop.fit, ax=ax),
        lambda loop, ax=None: plotting.plot_residual_map(loop.residual_before, ax),
        lambda loop, ax=None: loop.plot(ax),
    ],
)
def test_axes_are_those_given_or_new_ones(draw, closed, ax):
    figures = plt.get_fignums()
    assert draw(closed, ax) is ax
    assert plt.get_fignums() == figures
    new = draw(closed)
    assert new is not ax
    new.figure.canvas.draw()
    plt.close(new.figure)


def lines(ax):
    return {line.get_label(): line.get_xydata().T for line in ax.get_lines()}


def test_the_day_is_that_of_the_record_by_its_own_clock(closed, ax):
    plotting.plot_before_after(closed, ax)
    drawn, record = lines(ax), closed.fit.record
    hours, measured = drawn["measured"]
    day = pd.Series(record["temp_module"], record.index).loc[ax.get_title()[:10]]
    np.testing.assert_array_equal(measured, day)
    np.testing.assert_allclose(hours, day.index.hour + day.index.minute / 60.0)
    assert closed.fit.holdout[day.index].all()
    for name, residual in (
        ("before", closed.residual_before),
        ("after", closed.fit.residual),
    ):
        left = measured - drawn[name][1]
        np.testing.assert_allclose(left, residual[day.index], atol=1e-9)


def test_no_other_test_day_is_more_variable(closed, ax):
    plotting.plot_fit(closed.fit, ax=ax)
    record, test = closed.fit.record, closed.fit.holdout
    change = pd.Series(record["poa_global"], record.index).diff().abs()[test]
    by_day = change.groupby(change.index.strftime("%Y-%m-%d")).sum()
    assert by_day.idxmax() == ax.get_title()[:10]


def test_bars_are_the_errors_of_the_test_days(closed, ax):
    plotting.plot_steps(closed, ax)
    widths = [bar.get_width() for bar in ax.patches]
    np.testing.assert_array_equal(widths, closed.table["rmse_test"])


def test_a_cell_of_the_map_is_the_mean_of_its_hour_and_month(ax):
    index = pd.date_range("2023-11-20", "2024-02-10", freq="h", tz="Europe/Brussels")
    values = np.random.default_rng(0).normal(size=len(index))
    residual = pd.Series(values, index).where(values < 2.0)
    plotting.plot_residual_map(residual, ax)
    cells = ax.collections[0].get_array().reshape(24, 4)
    names = [text.get_text() for text in ax.get_xticklabels()]
    assert names == ["Nov", "Dec", "Jan", "Feb"]
    at = (index.hour == 7) & (index.month == 1)
    assert cells[7, 2] == pytest.approx(residual[at].mean())
    low, high = ax.collections[0].get_clim()
    assert -low == high == pytest.approx(np.abs(cells).max())


def test_a_map_of_several_years_does_not_mix_them(ax):
    """January of one year is another column than that of the next."""
    index = pd.date_range("2019-11-20", "2022-02-10", freq="h", tz="Europe/Brussels")
    residual = pd.Series(np.where(index.year == 2021, 3.0, -1.0), index)
    plotting.plot_residual_map(residual, ax)
    months = [
        "2019-11",
        "2019-12",
        *(f"{y}-{m:02}" for y in (2020, 2021) for m in range(1, 13)),
        "2022-01",
        "2022-02",
    ]
    cells = ax.collections[0].get_array().reshape(24, len(months))
    of_2021 = np.array([month.startswith("2021") for month in months])
    assert (cells[:, of_2021] == 3.0).all() and (cells[:, ~of_2021] == -1.0).all()
    names = [text.get_text() for text in ax.get_xticklabels()]
    assert names == ["2020", "2021", "2022"]
    assert [months[int(x)] for x in ax.get_xticks()] == [f"{n}-01" for n in names]


def test_contributions_are_those_of_the_loop(closed, ax):
    plotting.plot_contributions(closed, ax)
    drawn, record = lines(ax), closed.fit.record
    data = record.inputs.frame()
    parts = closed.contributions(data)
    day = parts.loc[ax.get_title()[:10]]
    words = {escaped_name(name): name for name in parts}
    found = {words[k.split(", rms")[0]]: v for k, v in drawn.items() if ", rms" in k}
    assert list(found) == list(parts)
    assert found
    for name, (_, values) in found.items():
        np.testing.assert_allclose(values, day[name], atol=1e-12)


def test_no_two_of_many_contributions_look_alike(closed, ax):
    index = closed.fit.record.index
    parts = pd.DataFrame({f"effect {i}": 1.0 * i for i in range(12)}, index)
    loop = SimpleNamespace(fit=closed.fit, contributions=lambda *_, **__: parts)
    plotting.plot_contributions(loop, ax)
    drawn = [line for line in ax.get_lines() if ", rms" in line.get_label()]
    looks = {(line.get_color(), line.get_linestyle()) for line in drawn}
    assert len(looks) == len(drawn) == 12


@pytest.mark.parametrize("name", ["a$b$", "$x^{$", "_quiet", "气温", "a\nb", "x" * 99])
def test_any_name_can_be_drawn(name, closed):
    def draw(ax):
        ax.set_title("never seen")
        ax.plot([0, 1], label=escaped_name(f"driver:{name}"))
        ax.legend()

    text = svg(draw, "a")
    assert "never seen" not in text
    shown = f"driver:{' '.join(name.split())}"
    assert (shown if len(shown) <= LONGEST else shown[:20]) in text


@pytest.fixture(scope="module")
def held():
    """A fit of thirty days whose weekends are held out; tau falls with the wind."""
    data = datasets.synthetic(30, 300, seed=2)
    return fit_fem(*(data[n] for n in COLUMNS), model="faiman", dynamics="balance")


PICTURES = {
    "fit": lambda fit, ax: plotting.plot_fit(fit, ax=ax),
    "by": lambda fit, ax: plotting.plot_residual_by(
        fit.residual, column(fit, "poa_global"), column(fit, "wind_speed"), ax
    ),
    "steps": lambda fit, ax: plotting.plot_step_response(fit, ax=ax),
    "tau": plotting.plot_tau_by_wind,
    "waterfall": plotting.plot_waterfall,
}


def column(fit, name):
    return pd.Series(fit.record[name], fit.record.index, name=name)


@pytest.mark.parametrize("style", ["default", "dark_background"])
@pytest.mark.parametrize("draw", PICTURES.values(), ids=PICTURES)
def test_text_is_of_the_style_and_every_axis_has_its_unit(draw, style, held):
    with plt.style.context(style):
        ax = Figure(layout="constrained").subplots()
        given = draw(held, ax)
        written = plt.rcParams["text.color"]
    legend = given.get_legend()
    for text in [*(legend.get_texts() if legend else ()), *given.texts]:
        assert text.get_color() == written
    shown = [a for a in given.figure.axes if a.get_xlabel() or a.get_ylabel()]
    words = {w for a in shown for w in (a.get_xlabel(), a.get_ylabel()) if w}
    assert all("[" in w or w in ("hour of the day", "day") for w in words), words


def test_a_fit_has_its_residual_below(held, ax):
    upper = plotting.plot_fit(held, ax, "2023-06-10")
    assert upper is ax
    below = next(a for a in ax.figure.axes if "measured −" in a.get_ylabel())
    drawn, day = lines(ax), held.residual.loc["2023-06-10"]
    np.testing.assert_allclose(below.get_lines()[-1].get_ydata(), day)
    modelled = drawn["faiman, balance"][1]
    np.testing.assert_allclose(drawn["measured"][1] - modelled, day)
    ax.figure.canvas.draw()
    top, bottom = ax.get_window_extent(), below.get_window_extent()
    assert bottom.y1 < top.y0
    assert (bottom.x0, bottom.x1) == pytest.approx((top.x0, top.x1), abs=1)


@pytest.mark.parametrize("rows", ["absent", "missing"])
def test_no_line_goes_over_a_gap(rows, ax):
    data = datasets.synthetic(8, 600)
    out = slice("2023-06-03 09:00", "2023-06-03 14:50")
    gap = data.index.slice_indexer(out.start, out.stop)
    if rows == "absent":
        data = data.drop(data.index[gap])
    else:
        data.iloc[gap] = np.nan
    plotting.plot_fit(fit_fem(data), ax, "2023-06-03")
    for name in ("measured", "wm1, ewm"):
        hours, values = lines(ax)[name]
        at = np.searchsorted(hours, 10.0)
        assert np.isnan(values[at]) and hours[at] > 9.0
        assert np.isfinite(values).sum() >= 144 - 36 - 1


@pytest.mark.parametrize("draw", [plotting.plot_fit, plotting.plot_tau_by_wind])
def test_a_fit_from_a_file_has_no_rows_to_plot(draw, held, ax):
    stored = replace(held, record=None, residual=None, holdout=None)
    with pytest.raises(ValueError, match="read from a file has no rows to plot"):
        draw(stored, ax)


def test_a_fit_stays_in_axes_without_a_grid(held):
    ax = Figure().add_axes([0.2, 0.3, 0.5, 0.6])
    plotting.plot_fit(held, ax=ax)
    assert ax.figure.axes
    for part in ax.figure.axes:
        x0, y0, x1, y1 = part.get_position().extents
        assert x0 >= 0.2 - 1e-9
        assert y0 >= 0.3 - 1e-9
        assert x1 <= 0.7 + 1e-9
        assert y1 <= 0.9 + 1e-9


@pytest.mark.parametrize(
    ("when", "rows", "title", "ticks"),
    [
        ("2023-06-10", 288, "2023-06-10, held out", ("0", "21")),
        (datetime.date(2023, 6, 8), 288, "2023-06-08, fitted", ("0", "21")),
        (pd.Timestamp("2023-06-08 09:00"), 288, "2023-06-08, fitted", ("0", "21")),
        (
            slice("2023-06-09", "2023-06-10 12:00"),
            433,
            "2023-06-09 to 2023-06-10, fitted and held out",
            ("9 Jun", "12:00"),
        ),
        ("2023-06", 8640, "2023-06-01 to 2023-06-30, fitted and held out", ("1 Jun",)),
        (
            slice("2023-06-10 11:00", "2023-06-10 12:00"),
            13,
            "2023-06-10, held out",
            ("11:00", "12:00"),
        ),
    ],
)
def test_any_part_of_a_record_can_be_shown(when, rows, title, ticks, held, ax):
    plotting.plot_fit(held, ax, when)
    expected = held.residual.loc[
        when if isinstance(when, (str, slice)) else str(when)[:10]
    ]
    assert len(expected) == rows
    drawn = lines(ax)
    left = drawn["measured"][1] - drawn["faiman, balance"][1]
    np.testing.assert_allclose(left, expected)
    assert ax.get_title() == title
    below = ax.figure.axes[1]
    words = [text.get_text() for text in below.get_xticklabels()]
    assert 3 <= len(words) <= 10
    assert set(ticks) <= set(words)


@pytest.mark.parametrize(
    "when", ["2024-01-01", "soon", slice("2022", "2023-01"), "2023-06-10 12:00"]
)
def test_what_is_no_part_of_it_is_refused(when, held):
    with pytest.raises(ValueError, match=r"when = .* runs from 2023-06-01 .* a date"):
        plotting.plot_fit(held, when=when)


def test_a_cell_is_the_mean_of_enough_rows_of_enough_days(ax):
    index = pd.date_range("2023-06-01", periods=5 * 24, freq="h")
    random = np.random.default_rng(0)
    residual = pd.Series(random.normal(size=len(index)), index)
    sun = pd.Series(150.0, index, name="poa_global")
    wind = pd.Series(0.5, index, name="wind_speed")
    sun[index.hour >= 12] = 950.0
    wind[index.day == 1] = 4.5  # twelve rows in each half, all of one day
    sun.iloc[30], wind.iloc[30] = 450.0, 2.5  # a single row
    plotting.plot_residual_by(residual, sun, wind, ax)
    mesh = ax.collections[0]
    across, up = mesh.get_coordinates()[0, :, 0], mesh.get_coordinates()[:, 0, 1]
    cells = mesh.get_array().filled(np.nan).reshape(len(up) - 1, len(across) - 1)
    at = (sun == 150) & (wind == 0.5)
    place = tuple(
        np.searchsorted(edges, value, side="right") - 1
        for edges, value in ((up, 0.5), (across, 150.0))
    )
    assert cells[place] == pytest.approx(residual[at].mean())
    assert np.isfinite(cells).sum() == 2
    assert ax.get_xlabel() == "poa_global [W/m²]"
    assert ax.get_ylabel() == "wind_speed [m/s]"


def test_a_rose_has_its_sectors_where_the_wind_comes_from():
    ax = Figure().subplots(subplot_kw={"projection": "polar"})
    index = pd.date_range("2023-06-01", periods=20_000, freq="h")
    random = np.random.default_rng(0)
    direction = pd.Series(random.uniform(0, 360, len(index)), index)
    speed = pd.Series(random.uniform(0, 6, len(index)), index)
    noise = random.normal(0, 0.1, len(index))
    east = direction.between(90 - 11.25, 90 + 11.25)
    residual = pd.Series(noise, index) + 3.0 * (east & (speed >= 3.0))
    assert plotting.plot_residual_rose(residual, speed, direction, ax) is ax
    mesh = ax.collections[0]
    angle = mesh.get_coordinates()[0, :, 0]
    radius = mesh.get_coordinates()[:, 0, 1]
    cells = mesh.get_array().reshape(len(radius) - 1, len(angle) - 1)
    rows, columns = np.nonzero(cells > 2.0)
    assert set(radius[rows]) == set(radius[(radius >= 3.0) & (radius < 6.0)])
    middle = np.degrees(angle[:-1] + angle[1:]) / 2
    assert middle[columns].min() > 90 - 11.25
    assert middle[columns].max() < 90 + 11.25
    # north is up, and east to the right of it
    up, right = (
        ax.transData.transform((a, 5.0)) - ax.transData.transform((0.0, 0.0))
        for a in (0.0, np.pi / 2)
    )
    assert up[1] > 10 > abs(up[0])
    assert right[0] > 10 > abs(right[1])


def test_no_ring_of_a_rose_is_named_at_its_rim():
    """Where its line would run through the words."""
    rows = pd.date_range("2023-06-01", periods=4000, freq="15min")
    residual = pd.Series(0.1, rows)
    for top in (3.0, 5.0, 8.0, 9.0):
        speed = pd.Series(np.linspace(0.0, top, len(rows)), rows)
        angle = pd.Series(np.arange(len(rows)) * 7.0 % 360.0, rows)
        ax = plotting.plot_residual_rose(residual, speed, angle)
        assert len(ax.get_yticks()) > 0 and max(ax.get_yticks()) < ax.get_ylim()[1]


def test_a_rose_refuses_what_is_not_round(ax, held):
    wind = column(held, "wind_speed")
    with pytest.raises(ValueError, match=r"polar axes, and ax is rectilinear; .*polar"):
        plotting.plot_residual_rose(held.residual, wind, 30.0 * wind, ax)


def test_columns_of_other_times_are_refused(held):
    wind = column(held, "wind_speed")
    with pytest.raises(ValueError, match=r"^y and the residual .*reindex"):
        plotting.plot_residual_by(held.residual, wind, wind.iloc[1:])
    with pytest.raises(ValueError, match=r"^wind_direction and the residual"):
        plotting.plot_residual_rose(held.residual, wind, wind.to_numpy())
    with pytest.raises(ValueError, match="y holds no number"):
        plotting.plot_residual_by(held.residual, wind, np.nan * wind)


@pytest.mark.parametrize("wind", [0.0, 3.0])
def test_a_step_reaches_63_percent_after_the_time_constant(wind, held, ax):
    plotting.plot_step_response(held, wind, ax)
    u0, u1, capacity = (held.coefficients[n] for n in ("u0", "u1", "capacity"))
    loss = u0 + u1 * wind
    minutes, warm = lines(ax)[f"{wind:g} m/s: τ = {capacity / loss:.0f} s"]
    expected = 1000.0 / loss * (1.0 - np.exp(-minutes * 60.0 * loss / capacity))
    np.testing.assert_allclose(warm, expected, atol=1e-6)
    (marker,) = (line for line in ax.get_lines() if len(line.get_xdata()) == 1)
    ((x, y),) = marker.get_xydata()
    assert x == pytest.approx(capacity / loss / 60.0)
    assert y == pytest.approx(632.12 / loss, rel=1e-4)


def test_a_held_efficiency_is_in_the_time_constant(ax):
    data = datasets.synthetic(12, 300)
    held = {"module_efficiency": 0.3}
    fit = fit_fem(data, model="pvsyst", dynamics="balance", fixed=held)
    plotting.plot_step_response(fit, 0.0, ax)
    r_eq = 0.9 * (1.0 - 0.3) / fit.coefficients["u_c"]
    assert f"0 m/s: τ = {fit.coefficients['capacity'] * r_eq:.0f} s" in lines(ax)


def test_a_steady_fit_has_no_memory_to_show(closed):
    data = datasets.synthetic(3, 300)
    fit = fit_fem(*(data[n] for n in COLUMNS), dynamics="steady")
    for draw in (plotting.plot_step_response, plotting.plot_tau_by_wind):
        with pytest.raises(ValueError, match=r"steady fit has no time constant; .*ewm"):
            draw(fit)


def test_a_wind_below_zero_is_refused(held):
    with pytest.raises(ValueError, match=r"wind_speed = -1 m/s is no speed"):
        plotting.plot_step_response(held, (2.0, -1.0))


@pytest.mark.parametrize(
    ("truth", "model", "dynamics"),
    [
        (dict(u0=25.0, u1=6.84, capacity=15e3, bias=-2.0), "faiman", "balance"),
        (dict(k=0.035, d=10.0, tau=400.0, bias=-1.0), "wm1", "ewm"),
    ],
)
def test_the_time_constant_of_each_wind_is_within_its_bars(truth, model, dynamics):
    """Of three skies; the bars are 95 %, and would not hold another time constant."""
    inside, beside, bins = 0, 0, 0
    for seed in range(3):
        how = dict(model=model, dynamics=dynamics, seed=seed)
        data = datasets.synthetic(30, 60, **how, **truth)
        fit = fit_fem(*(data[n] for n in COLUMNS), model=model, dynamics=dynamics)
        found = plotting.tau_by_wind(fit)
        true = truth.get("tau", 15e3 / (25.0 + 6.84 * found["wind_speed"]))
        inside += found["lower"].le(true).mul(found["upper"].ge(true)).sum()
        other = 1.1 * true
        beside += found["lower"].le(other).mul(found["upper"].ge(other)).sum()
        bins += len(found)
    assert bins >= 18
    assert inside >= 0.9 * bins
    assert beside <= 0.4 * bins


def test_one_time_constant_for_all_winds_is_seen_to_be_wrong():
    data = datasets.synthetic(30, 60)  # falls from 500 to 200 s with the wind
    fit = fit_fem(*(data[n] for n in COLUMNS), model="faiman", dynamics="ewm")
    found = plotting.tau_by_wind(fit)
    tau = fit.coefficients["tau"]
    assert found["lower"].iloc[0] > tau > found["upper"].iloc[-1]
    assert found["tau"].is_monotonic_decreasing


def test_a_model_with_effects_has_a_time_constant_by_wind():
    """Exchange by the fourth power needs the temperature without effects."""
    data = simulator.record(effects=simulator.PHYSICS, days=60, step=600)
    fit = close_loop(data[list(COLUMNS)]).fit
    assert "radiative_loss" in [effect.name for effect in fit.effects]
    assert len(plotting.tau_by_wind(fit)) > 5


def test_bins_that_tell_nothing_are_left_out(ax):
    data = datasets.synthetic(30, 300)
    data["wind_speed"] = data["wind_speed"].clip(upper=4.0)
    gust = data.index.normalize() == data.index[0].normalize()  # one day of storm
    data.loc[gust, "wind_speed"] = 12.0
    fit = fit_fem(*(data[n] for n in COLUMNS), model="faiman", dynamics="balance")
    found = plotting.tau_by_wind(fit)
    assert found["wind_speed"].max() < 5.0
    assert (found["days"] >= 5).all()
    few = datasets.synthetic(3, 300)
    fit = fit_fem(*(few[n] for n in COLUMNS), dynamics="ewm")
    with pytest.raises(ValueError, match="no bin of wind has 5 days"):
        plotting.plot_tau_by_wind(fit, ax)


def test_a_waterfall_falls_from_step_to_step(held, ax):
    plotting.plot_waterfall(held, ax)
    errors = held.scores["rmse_test"].to_numpy()
    bars = [(bar.get_x(), bar.get_x() + bar.get_width()) for bar in ax.patches]
    falls = [tuple(sorted(pair)) for pair in pairwise(errors)]
    np.testing.assert_allclose(bars[:2], [(0, errors[0]), (0, errors[-1])])
    np.testing.assert_allclose(bars[2:], falls)
    names = [text.get_text() for text in ax.get_yticklabels()]
    assert names == [
        "steady",
        "+ filter",
        "+ heat balance",
        "+ bias",
        "remaining error",
    ]
    rises = errors[1:] - errors[:-1] > 0.005
    assert [bool(bar.get_hatch()) for bar in ax.patches[2:]] == rises.tolist()


def test_a_loops_waterfall_leaves_out_the_form_that_it_left(closed, ax):
    plotting.plot_waterfall(closed.fit, ax)
    names = [text.get_text() for text in ax.get_yticklabels()]
    form = {"ewm": "+ EWM", "balance": "+ heat balance"}[closed.fit.dynamics]
    added = [f"+ {escaped_name(effect)}" for effect in closed.effects]
    assert names == ["steady", form, *added, "remaining error"]


def test_without_colours_lines_can_be_told_apart(closed, ax):
    other = Figure().subplots()
    plotting.plot_before_after(closed, ax)
    plotting.plot_contributions(closed, other)
    for drawn, count in ((ax, 3), (other, 2 + len(closed.patterns))):
        named = [n for n in drawn.get_lines() if not n.get_label().startswith("_")]
        assert len({line.get_linestyle() for line in named}) == len(named) == count


def test_a_cell_below_zero_has_a_dash(ax):
    index = pd.date_range("2023-01-01", periods=60 * 24, freq="h")
    residual = pd.Series(np.where(index.hour < 6, -1.0, 1.0), index)
    plotting.plot_residual_map(residual, ax)
    dashes = ax.collections[1].get_offsets()
    assert sorted({float(y) for _, y in dashes}) == [h + 0.5 for h in range(6)]
    assert len(dashes) == 6 * 3


def test_cups_that_read_a_little_below_zero_are_calm():
    """The middle of the rose has them, and its edges rise."""
    index = pd.date_range("2024-01-01", periods=4 * 24 * 60, freq="min")
    speed = pd.Series(np.where(np.arange(len(index)) % 2, -0.02, 4.5), index)
    angle = pd.Series(90.0, index)
    residual = pd.Series(np.where(speed < 0, 1.0, -1.0), index)
    ax = plotting.plot_residual_rose(residual, speed, angle)
    (cells,) = (c for c in ax.collections if c.get_array() is not None)
    values = np.ma.filled(cells.get_array().astype(float), np.nan).ravel()
    assert {1.0, -1.0} <= set(values[np.isfinite(values)])
    assert ax.get_ylim()[0] == 0.0


@pytest.mark.parametrize("count", [2, 5])
def test_a_legend_outside_the_axes_is_no_wider_than_the_figure(count):
    figure = Figure(figsize=(4.2, 4.0), layout="constrained")
    ax = figure.subplots()
    for i in range(count):
        ax.plot([0, 1], [i, i], label=f"module_sensor_contact_episode_{i}, rms 1.23 K")
    outside_legend(ax, 3, loc="upper center", bbox_to_anchor=(0.5, -0.22))
    figure.draw_without_rendering()
    legend = ax.get_legend().get_window_extent()
    assert legend.x0 >= 0.0 and legend.x1 <= figure.bbox.width
    assert ax.get_window_extent().width > 0.7 * figure.bbox.width


@pytest.mark.parametrize("days", [0.1, 1, 2.5, 2.9, 10, 75, 200, 700, 1000, 3000])
def test_an_axis_of_any_length_has_some_dates_and_not_too_many(days, ax):
    first = pd.Timestamp("2023-03-01 07:10")
    ax.plot([first, first + pd.Timedelta(days=days)], [0.0, 1.0])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        dated_axis(ax)
        places = ax.get_xticks()
    low, high = ax.get_xlim()
    assert 2 <= np.count_nonzero((places >= low) & (places <= high)) <= 7
