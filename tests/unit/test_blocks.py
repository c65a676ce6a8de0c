"""A record answered block by block is the record answered as a whole."""

import subprocess
import sys
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from conftest import COLUMNS
from hypothesis import given, strategies as st
from test_leastsquares import normal

import pvlib_fem as fem
from pvlib_fem._fitting import row_source as rows_of
from pvlib_fem._fitting.row_source import EvalRequest, Rows, daily_sums
from pvlib_fem._fitting.search import with_tables
from pvlib_fem._loop.regression.tangents import Tangents, gapless_column
from pvlib_fem._record.inputs import as_record
from pvlib_fem._statistics.clusters import cluster_sums
from pvlib_fem._thermal import compiled, model as thermal
from pvlib_fem._thermal.steady_models import STEADY_MODELS
from pvlib_fem.effects import find
from pvlib_fem.effects._effect import Effect, Parameter, Terms

DAYS = fem.datasets.synthetic(6, 600, seed=4)
EFFECTS = ("temperature_gain", "wind_shape")


def record(kind, seed=0):
    """Six days at 10 min: complete, with gaps, with missing values, or uneven."""
    random, data = np.random.default_rng(seed), DAYS.copy()
    if "missing" in kind:
        data = data.mask(random.random(data.shape) < 0.1)
        data.iloc[:30, 0] = data.iloc[200:330, 2] = np.nan
    if "gaps" in kind:
        data = data[
            (random.random(len(data)) < 0.9) & (np.arange(len(data)) // 99 != 4)
        ]
    if "uneven" in kind:
        late = random.integers(0, 200, len(data))
        data.index = data.index + pd.to_timedelta(late, unit="s")
    return as_record(*(data[name] for name in COLUMNS))


def normal_sums(model, coefficients, source, names):
    """Sums of products of slopes and residual, from one pass over a source."""
    return source.sums({"": EvalRequest(model, coefficients)}, {"": names})[""]


def model_of(law, dynamics, effects):
    """A model with effects, its coefficients, and those without."""
    model = thermal.ThermalModel(STEADY_MODELS[law], dynamics, (*map(find, effects),))
    known = model.steady_model
    lacking = [name for name in known.constants if name not in known.fixed]
    model = replace(model, held=dict.fromkeys(lacking, 0.2))
    values = {name: row.start for name, row in model.parameters.items()}
    values = {**values, **model.constants}
    if "k_w" in values:
        values["k_w"] *= values["k"]
    base = {**values, "bias": -1.0}
    inside = {
        name: 0.02 * model.parameters[name].upper for name in values if "." in name
    }
    return replace(model, base=base), {**base, **inside}


@pytest.mark.parametrize("dynamics", thermal.MEMORY)
@pytest.mark.parametrize("effects", [(), EFFECTS])
@given(
    kind=st.sampled_from(["", "missing", "gaps", "uneven missing gaps"]),
    law=st.sampled_from(["faiman", "wm1", "ross"]),
    rows=st.integers(1, 400),
    seed=st.integers(0, 3),
)
def test_blocks_are_the_whole(dynamics, effects, kind, law, rows, seed):
    """Blocks of any size continue states, slopes and the time over gaps."""
    model, values = model_of(law, dynamics, effects)
    inputs = model.with_drivers(record(kind, seed).inputs)
    whole, slopes = model.solve_block(inputs, values, model.past(inputs))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(thermal, "BLOCK", rows)
        found, parts = model.slopes(inputs, values)
    close = dict(rtol=1e-12, atol=1e-12, equal_nan=True)
    np.testing.assert_allclose(found, whole, **close)
    assert list(parts) == list(slopes)
    assert parts
    for name, part in parts.items():
        size = max(np.nanmax(np.abs(slopes[name])), 1e-300)
        np.testing.assert_allclose(part / size, slopes[name] / size, **close)


@pytest.mark.parametrize("dynamics", thermal.MEMORY)
def test_terms_that_add_nothing_yet_are_answered_along(dynamics, monkeypatch):
    """As the slopes of the effect itself, where it is there and adds nothing."""
    model, values = model_of("faiman", dynamics, ("wind_shape",))
    values |= dict.fromkeys(["wind_shape.root", "wind_shape.stall"], 0.0)
    inputs = model.with_drivers(record("uneven gaps").inputs)
    (effect,) = model.effects
    also = effect.slopes(inputs.columns, effect.start)
    theirs = model.slopes(inputs, values)[1]
    monkeypatch.setattr(thermal, "BLOCK", 70)
    found = replace(model, effects=()).slopes(inputs, values, also=also)[1]
    assert also
    for name in also:
        np.testing.assert_allclose(found[name], theirs[name], rtol=1e-9, atol=1e-12)


VALUES = [1.0, 2.0, np.inf, -np.inf, np.nan]


@given(st.lists(st.sampled_from(VALUES), min_size=1, max_size=30))
def test_terms_over_gaps_are_those_of_the_next_row(column):
    """At the end of the last one that is there, and where there is none nothing."""
    column = np.array(column)
    want = pd.Series(column).bfill().ffill().to_numpy()
    np.testing.assert_array_equal(gapless_column(column), want)


def some_terms(rows):
    """Terms in every column but the capacity, as numbers and row by row."""
    random = np.random.default_rng(7)
    return {
        "heat": Terms(heat=100.0 * random.random(rows)),
        "loss": Terms(loss=random.random(rows)),
        "several": Terms(heat=30.0, loss=random.random(rows), offset=1.0),
        "read": Terms(offset=random.random(rows), gain=random.random(rows)),
        "read all": Terms(heat=random.random(rows), gain=0.1),
    }


@pytest.mark.parametrize("kind", ["", "uneven missing gaps"])
@pytest.mark.parametrize("dynamics", thermal.MEMORY)
def test_the_compiled_loops_answer_further_terms_alike(kind, dynamics, monkeypatch):
    """To twelve digits, whether the model has effects or none."""
    pytest.importorskip("numba")
    for effects in ((), EFFECTS):
        model, values = model_of("faiman", dynamics, effects)
        inputs = model.with_drivers(record(kind).inputs)
        how = dict(wanted=False, also=some_terms(len(inputs.index)))
        monkeypatch.setattr(compiled, "LONG", 1 << 15)
        temperature, theirs = model.slopes(inputs, values, **how)
        monkeypatch.setattr(compiled, "LONG", 1)
        found, ours = model.slopes(inputs, values, **how)
        np.testing.assert_allclose(found, temperature, rtol=1e-12, atol=1e-12)
        there = np.isfinite(temperature)
        assert model.slopes(inputs, values, wanted=False, also={})[1] == {}
        assert how["also"]
        for name in how["also"]:
            one, other = (slopes[name][there] for slopes in (ours, theirs))
            np.testing.assert_allclose(one, other, rtol=1e-11, atol=1e-11)


@pytest.mark.parametrize("kind", ["", "uneven missing gaps"])
@pytest.mark.parametrize("dynamics", thermal.MEMORY)
def test_tangents_at_some_rows_need_only_what_those_remember(kind, dynamics):
    """On two days of six, equal to the computation on all rows to the last digits."""
    model, values = model_of("faiman", dynamics, EFFECTS)
    whole = record(kind)
    inputs, also = model.with_drivers(whole.inputs), some_terms(len(whole.index))
    temperature, own = model.slopes(inputs, values)
    further = model.slopes(inputs, values, wanted=False, also=also)[1]
    day = whole.dates - whole.dates[0]
    rows = np.flatnonzero(np.isin(day, [2, 5]) & np.isfinite(temperature))
    at = Tangents.from_model(model, inputs, values, rows)
    assert len(rows) < len(at.read) + (dynamics == "steady") < 0.7 * len(whole.index)
    assert [*at.slopes()] == [*own] and [*at.slopes(also)] == [*also]
    assert own and also
    for ours, theirs in ((at.slopes(), own), (at.slopes(also), further)):
        for name in ours:
            column = np.broadcast_to(theirs[name], len(whole.index))[rows]
            size = np.abs(column).max()
            np.testing.assert_allclose(ours[name] / size, column / size, atol=1e-12)


@pytest.mark.parametrize("kind", ["", "uneven missing gaps"])
@pytest.mark.parametrize("dynamics", thermal.MEMORY)
def test_the_sums_of_a_pass_are_those_of_the_columns(kind, dynamics, monkeypatch):
    """Normal matrix and daily sums, from blocks and from whole columns."""
    whole = record(kind)
    model, values = model_of("faiman", dynamics, EFFECTS)
    inputs = model.with_drivers(whole.inputs)
    whole = replace(whole, inputs=inputs)
    counts = whole.complete_rows([*COLUMNS, *model.drivers]) & (
        whole["poa_global"] > 20
    )
    temperature, slopes = model.solve_block(inputs, values, model.past(inputs))
    columns = [np.broadcast_to(slopes[n], len(counts))[counts] for n in model.free]
    rest = (whole["temp_module"] - temperature)[counts]
    monkeypatch.setattr(thermal, "BLOCK", 50)
    source, tabled = Rows(whole, counts), with_tables(model, whole)
    found = normal_sums(tabled, values, source, model.free)
    theirs = normal(rest, np.column_stack(columns))
    for ours, other in zip(vars(found).values(), vars(theirs).values()):
        np.testing.assert_allclose(ours, other, rtol=1e-9)
    daily = daily_sums(tabled, values, source, ()).sums
    theirs = cluster_sums(columns, rest, whole.dates[counts])
    np.testing.assert_allclose(daily.sums, theirs.sums, rtol=1e-9, atol=1e-9)
    assert daily.dates.tolist() == theirs.dates.tolist()


@pytest.mark.parametrize("dynamics", thermal.MEMORY)
@pytest.mark.parametrize("law", STEADY_MODELS)
@pytest.mark.parametrize("kind", ["", "uneven missing gaps"])
def test_the_compiled_loops_are_the_columns(kind, law, dynamics, monkeypatch):
    """Temperature, normal matrix and daily sums, to twelve digits."""
    pytest.importorskip("numba")
    monkeypatch.setattr(thermal, "BLOCK", 200)
    model, values = model_of(law, dynamics, EFFECTS if law == "faiman" else ())
    whole = record(kind)
    inputs = model.with_drivers(whole.inputs)
    whole = replace(whole, inputs=inputs)
    counts = whole.complete_rows([*COLUMNS, *model.drivers]) & (
        whole["poa_global"] > 20
    )
    tabled = with_tables(model, whole)

    def found():
        source = Rows(whole, counts)
        sums = normal_sums(tabled, values, source, model.free)
        daily = daily_sums(tabled, values, source, ()).sums
        return tabled.temperature(inputs, values), sums, daily

    theirs = found()
    monkeypatch.setattr(compiled, "LONG", 1)
    ours = found()
    close = dict(rtol=1e-12, atol=1e-12, equal_nan=True)
    np.testing.assert_allclose(ours[0], theirs[0], **close)
    size = np.sqrt(np.diag(theirs[1].normal))
    for one, other, scale in (
        (ours[1].normal, theirs[1].normal, np.outer(size, size)),
        (ours[1].gradient, theirs[1].gradient, size * theirs[1].squares ** 0.5),
        (ours[2].sums, theirs[2].sums, counts.sum()),
    ):
        np.testing.assert_allclose(one / scale, other / scale, **close)
    assert ours[1].squares == pytest.approx(theirs[1].squares, rel=1e-12)


@pytest.mark.parametrize("dynamics", thermal.MEMORY)
@pytest.mark.parametrize("kind", ["", "uneven missing gaps"])
def test_some_blocks_are_a_record_with_gaps(kind, dynamics, monkeypatch):
    """What is between them is long enough that nothing of the one is in the next."""
    whole, (model, values) = record(kind), model_of("faiman", dynamics, ())
    values |= {"tau": 60.0} if dynamics == "ewm" else {}
    values |= {"capacity": 1.5e3} if dynamics == "balance" else {}
    counts = whole.complete_rows(COLUMNS) & (whole["poa_global"] > 20)
    parts = thermal.blocks(len(counts), 20)
    monkeypatch.setattr(rows_of, "blocks", lambda n, *_: thermal.blocks(n, 20))
    monkeypatch.setattr(rows_of, "EVERY", 4)
    found = normal_sums(model, values, Rows(whole, counts).thinned(), model.free)
    each = [
        Rows(replace(whole, inputs=whole.inputs.part(part)), counts[part])
        for part in parts[::4]
    ]
    each = [normal_sums(model, values, one, model.free) for one in each if one.count]
    for name, ours in vars(found).items():
        theirs = sum(vars(one)[name] for one in each)
        np.testing.assert_allclose(ours, theirs, rtol=1e-6)


@pytest.mark.parametrize("dynamics", thermal.MEMORY)
def test_an_effect_on_the_capacity_is_as_with_numpy(dynamics, monkeypatch):
    """The loops have none, so that a change of the time constant takes NumPy."""

    def wet(poa_global, *, more):
        return Terms(capacity=more * (poa_global > 300.0))

    own = Effect("wet", wet, {"more": Parameter(0.0, -5e3, 5e3, "J/(m² K)")})
    model, values = model_of("faiman", dynamics, ())
    model, values = replace(model, effects=(own,)), values | {"wet.more": 2e3}
    whole = record("")
    counts = whole.complete_rows(COLUMNS) & (whole["poa_global"] > 20)

    def found():
        sums = normal_sums(model, values, Rows(whole, counts), model.free)
        return model.temperature(whole.inputs, values), *vars(sums).values()

    theirs = found()
    monkeypatch.setattr(compiled, "LONG", 1)
    for one, other in zip(found(), theirs):
        np.testing.assert_allclose(one, other, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("dynamics", thermal.MEMORY)
@pytest.mark.parametrize("kind", ["", "uneven missing gaps"])
def test_slopes_by_a_changed_time_constant_are_central_differences(
    dynamics, kind, monkeypatch
):
    """By its size and by every other coefficient, over blocks of few rows, too."""
    whole = record(kind)
    day = str(whole.index[len(whole.index) // 2])[:10]
    names = "mounting", "time_constant"
    effects = [find({"name": f"{name}_step", "at": day}) for name in names]
    model, values = model_of("faiman", dynamics, ())
    model = replace(model, effects=tuple(effects))
    values |= {"mounting_step.change": -0.2, "time_constant_step.change": 1.5}
    inputs = model.with_drivers(whole.inputs)
    blocks = thermal.blocks
    monkeypatch.setattr(thermal, "blocks", lambda n, *_: blocks(n, 150))
    temperature, slopes = model.slopes(inputs, values)
    for name, row in model.parameters.items():
        by = 1e-4 * max(abs(values[name]), 0.01 * row.upper)
        ends = [
            model.temperature(inputs, {**values, name: values[name] + side})
            for side in (by, -by)
        ]
        central = (ends[0] - ends[1]) / (2.0 * by)
        known = np.isfinite(temperature)
        largest = np.abs(central[known]).max()
        np.testing.assert_allclose(
            slopes[name][known], central[known], atol=1e-5 * largest, err_msg=name
        )


def test_a_changed_time_constant_of_both_dynamics_is_that_of_another_module():
    """From some time after its date on, the answer is that of the new module."""
    whole = record("")
    effect = find({"name": "time_constant_step", "at": str(whole.index[0])[:10]})
    for dynamics, name in {"ewm": "tau", "balance": "capacity"}.items():
        model, values = model_of("faiman", dynamics, ())
        slower = model.temperature(whole.inputs, {**values, name: 2.5 * values[name]})
        model = replace(model, effects=(effect,))
        inputs = model.with_drivers(whole.inputs)
        changed = model.temperature(
            inputs, {**values, "time_constant_step.change": 1.5}
        )
        np.testing.assert_allclose(changed, slower, rtol=1e-9)


@pytest.mark.parametrize("capacity", [3e3, 6e4, 1e6])
def test_a_module_slower_than_the_steps_is_answered_by_a_series(capacity, monkeypatch):
    """Of the exponential, which is as exact: by short steps, by long ones, by both."""
    pytest.importorskip("numba")
    model, values = model_of("faiman", "balance", ())
    values |= {"capacity": capacity}
    inputs = record("gaps").inputs
    theirs = model.temperature(inputs, values)
    monkeypatch.setattr(compiled, "LONG", 1)
    ours = model.temperature(inputs, values)
    np.testing.assert_allclose(ours, theirs, rtol=1e-13, atol=1e-12)


@pytest.mark.parametrize("dynamics", thermal.MEMORY)
@pytest.mark.parametrize("effects", [(), EFFECTS])
def test_rows_that_nothing_remembers_are_left_out(dynamics, effects, monkeypatch):
    """The compiled loops do not read days that do not count, but for their ends."""
    pytest.importorskip("numba")
    monkeypatch.setattr(compiled, "LONG", 1)
    model, values = model_of("faiman", dynamics, effects)
    whole = record("gaps")
    day = whole.dates - whole.dates[0]
    counts = (whole["poa_global"] > 20) & ((day == 0) | (day == 5))

    def found(poa_global):
        one = replace(whole, inputs=model.with_drivers(whole.inputs))
        one = one.having({"poa_global": poa_global})
        tabled = with_tables(model, one)
        temperature = next(tabled.in_blocks(one.inputs, values, counts))
        sums = normal_sums(tabled, values, Rows(one, counts), model.free)
        return temperature[counts].copy(), *vars(sums).values()

    light = whole["poa_global"]
    ours = found(np.where((day > 1) & (day < 4), np.inf, light))
    monkeypatch.setattr(compiled, "LONG", len(light) + 1)
    for one, other in zip(ours, found(light)):
        np.testing.assert_allclose(one, other, rtol=1e-9)


def test_the_package_does_not_load_numba():
    words = "import sys, pvlib_fem; assert 'numba' not in sys.modules"
    subprocess.run([sys.executable, "-c", words], check=True)
