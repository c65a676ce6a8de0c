"""Pictures show the numbers that they are of."""

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import pytest
from matplotlib.figure import Figure

from pvlib_fem import datasets, plotting
from pvlib_fem.loop import close_loop
from pvlib_fem.paper import COLUMNS


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
        lambda loop, ax=None: plotting.plot_fit(loop.fit, ax),
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


def test_no_other_sealed_day_is_more_variable(closed, ax):
    plotting.plot_fit(closed.fit, ax)
    record, sealed = closed.fit.record, closed.fit.holdout
    change = pd.Series(record["poa_global"], record.index).diff().abs()[sealed]
    by_day = change.groupby(change.index.strftime("%Y-%m-%d")).sum()
    assert by_day.idxmax() == ax.get_title()[:10]


def test_bars_are_the_errors_of_the_sealed_days(closed, ax):
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


def test_contributions_are_those_of_the_loop(closed, ax):
    plotting.plot_contributions(closed, ax)
    drawn, record = lines(ax), closed.fit.record
    data = pd.DataFrame(record.inputs.columns, record.index)
    parts = closed.contributions(data)
    day = parts.loc[ax.get_title()[:10]]
    words = {plotting.label(name): name for name in parts}
    found = {words[k.split(", rms")[0]]: v for k, v in drawn.items() if ", rms" in k}
    assert list(found) == list(parts)
    for name, (_, values) in found.items():
        np.testing.assert_allclose(values, day[name], atol=1e-12)


@pytest.mark.parametrize("name", ["a$b$", "$x^{$", "_quiet", "气温", "a\nb", "x" * 99])
def test_any_name_can_be_drawn(name, closed):
    def draw(ax):
        ax.set_title("never seen")
        ax.plot([0, 1], label=plotting.label(f"driver:{name}"))
        ax.legend()

    text = plotting.svg(draw, "a")
    assert "never seen" not in text
    shown = f"driver:{' '.join(name.split())}"
    assert (shown if len(shown) <= plotting.LONGEST else shown[:20]) in text
