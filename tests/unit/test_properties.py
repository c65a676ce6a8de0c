"""
Every numeric public function against its definition, written row by row.

Any steps, gaps, missing values, kinds of numbers, zones, one row and none.
``make fuzz`` runs each with 10,000 examples.
"""

import itertools
import math

import numpy as np
import pandas as pd
import pvlib
import pytest
from hypothesis import assume, given, strategies as st
from numpy.testing import assert_allclose
from test_leastsquares import minimum_of, normal

import pvlib_fem as fem
from pvlib_fem import layers, scores
from pvlib_fem._statistics.leastsquares import descent

#: over-temperature per irradiance, as pvlib and the paper write it
LAWS = {
    "ross": lambda w, k: k + 0.0 * w,
    "sapm": lambda w, a, b: math.exp(a + b * w),
    "faiman": lambda w, u0, u1: 1.0 / (u0 + u1 * w),
    "wm1": lambda w, k, d: k * math.exp(-w / d),
    "wm2": lambda w, k, k_w: k - k_w * min(w, 8.0),
    "pvsyst": lambda w, u_c, u_v: 0.9 * (1.0 - 0.1) / (u_c + u_v * w),
    "noct": lambda w, noct: (noct - 20.0) / 800.0 + 0.0 * w,
    "noct_sam": lambda w, noct, module_efficiency: (
        (noct - 20.0)
        / 800.0
        * (1.0 - module_efficiency / 0.9)
        * 9.5
        / (5.7 + 3.8 * 0.51 * w)
    ),
}
SPANS = {
    "k": (0.01, 0.06),
    "a": (-4.0, -3.0),
    "b": (-0.2, 0.0),
    "u0": (15.0, 40.0),
    "u1": (0.0, 12.0),
    "d": (3.0, 50.0),
    "k_w": (0.0, 0.001),
    "u_c": (15.0, 40.0),
    "u_v": (0.0, 12.0),
    "noct": (35.0, 60.0),
    "module_efficiency": (0.05, 0.25),
}
NAMES = {model: law.__code__.co_varnames[1:] for model, law in LAWS.items()}
LIMITS = {"poa_global": (-5, 1200), "temp_air": (-30, 50), "wind_speed": (0, 25)}
ZONES = [
    "UTC",
    "Etc/GMT+7",
    "Europe/Brussels",
    "America/New_York",
    "Australia/Lord_Howe",
]
#: half an hour before clocks change, in spring or autumn, somewhere of those
CHANGES = [
    "2024-03-31 00:30",
    "2024-11-03 05:30",
    "2024-04-06 14:30",
    "2024-10-27 00:30",
]
exact = {"rtol": 1e-9, "atol": 1e-9}


def numbers(low, high):
    """Whole numbers, in which every kind of number agrees, some missing."""
    return st.one_of(st.integers(low, high).map(float), st.just(math.nan))


@st.composite
def weathers(draw, names=tuple(LIMITS), most=40):
    """Times of each row [s] and columns; steps even, uneven or with gaps."""
    rows = draw(st.integers(1, most))
    short = st.integers(1, 600)
    steps = draw(
        st.one_of(
            short.map(lambda step: [step] * rows),
            st.lists(short, min_size=rows, max_size=rows),
            st.lists(
                st.one_of(short, st.integers(600, 90_000)), min_size=rows, max_size=rows
            ),
        )
    )
    columns = {
        name: np.array(
            draw(st.lists(numbers(*LIMITS[name]), min_size=rows, max_size=rows))
        )
        for name in names
    }
    return np.cumsum(steps).astype(float), columns


@st.composite
def laws(draw):
    model = draw(st.sampled_from(sorted(LAWS)))
    return model, {n: draw(st.floats(*SPANS[n])) for n in NAMES[model]}


def relaxed(values, seconds, taus, begin=None):
    """The response by its definition: exact over each step, anew after a gap."""
    there = [i for i, value in enumerate(values) if not math.isnan(value)]
    since = [seconds[j] - seconds[i] for i, j in itertools.pairwise(there)]
    usual = float(np.median(since)) if since else math.inf
    answer, state, before = [math.nan] * len(values), begin, None
    for i in there:
        step = usual if before is None else seconds[i] - before
        gap = step > 5 * taus[i] and step > 2 * usual
        if state is None or gap:
            state = values[i]
        else:
            state += (values[i] - state) * -math.expm1(-step / taus[i])
        answer[i], before = state, seconds[i]
    return answer


taus = st.floats(5.0, 5000.0)


@given(weathers(["poa_global"]), st.data())
def test_ewm_is_its_recursion(weather, data):
    seconds, columns = weather
    values, rows = columns["poa_global"], len(seconds)
    tau = data.draw(st.one_of(taus, st.lists(taus, min_size=rows, max_size=rows)))
    each = np.broadcast_to(tau, rows)
    answer = fem.ewm(values, tau, times=seconds)
    assert_allclose(answer, relaxed(values, seconds, each), **exact)


@given(weathers(["poa_global"]), taus)
def test_the_papers_start_up_is_a_mean_of_fading_weights(weather, tau):
    seconds, columns = weather
    values = columns["poa_global"]
    there = np.flatnonzero(~np.isnan(values))
    since = np.diff(seconds[there])
    gaps = (since > 5 * tau) & (since > 2 * np.median(since)) if len(since) else since
    piece = np.concatenate(([0], np.cumsum(gaps)))
    answer = fem.ewm(values, tau, times=seconds, adjust=True)
    assert np.isnan(answer).sum() == len(values) - len(there)
    for at, i in enumerate(there):
        past = [j for j, p in zip(there[: at + 1], piece) if p == piece[at]]
        weights = [math.exp(-(seconds[i] - seconds[j]) / tau) for j in past]
        total = math.fsum(w * values[j] for w, j in zip(weights, past))
        assert answer[i] == pytest.approx(total / math.fsum(weights), **PLAIN)


@given(st.integers(2, 60), st.integers(1, 900), taus, st.data())
def test_a_record_in_pieces_is_the_whole(rows, step, tau, data):
    values = np.array(
        data.draw(st.lists(st.floats(-9, 999), min_size=rows, max_size=rows))
    )
    cut = data.draw(st.integers(1, rows - 1))
    whole = fem.ewm(values, tau, step=step)
    first = fem.ewm(values[:cut], tau, step=step)
    second = fem.ewm(values[cut:], tau, step=step, initial=first[-1])
    assert_allclose(np.r_[first, second], whole, **exact)


@given(weathers(), laws(), taus, st.floats(-5, 5))
def test_a_smoothed_temperature_is_the_law_of_its_smoothed_inputs(
    weather, law, tau, bias
):
    seconds, columns = weather
    model, own = law
    answer = fem.fem_temperature(
        *columns.values(), times=seconds, tau=tau, bias=bias, model=model, **own
    )
    each = [tau] * len(seconds)
    poa, wind = (
        relaxed(columns[n], seconds, each) for n in ("poa_global", "wind_speed")
    )
    expected = [
        air + g * LAWS[model](w, **own) + bias
        for g, air, w in zip(poa, columns["temp_air"], wind)
    ]
    assert_allclose(answer, expected, **exact)


@given(weathers(), laws(), st.floats(500, 1e5), st.floats(-5, 5))
def test_a_heat_balance_is_its_recursion(weather, law, capacity, bias):
    seconds, columns = weather
    model, own = law
    answer = fem.heat_balance(
        *columns.values(),
        times=seconds,
        capacity=capacity,
        bias=bias,
        model=model,
        **own,
    )
    r_eq = [LAWS[model](w, **own) for w in columns["wind_speed"]]
    steady = columns["temp_air"] + columns["poa_global"] * r_eq
    expected = relaxed(steady, seconds, [capacity * r for r in r_eq])
    assert_allclose(answer, np.array(expected) + bias, **exact)


@given(laws(), st.floats(0, 1200), st.floats(-30, 50), st.floats(0, 25))
def test_the_laws_are_pvlibs(law, sun, air, wind):
    model, own = law
    theirs = {
        "sapm": pvlib.temperature.sapm_module,
        "faiman": pvlib.temperature.faiman,
        "pvsyst": pvlib.temperature.pvsyst_cell,
        "noct_sam": pvlib.temperature.noct_sam,
        "wm1": fem.wm1,
        "wm2": fem.wm2,
    }
    want = air + sun * LAWS[model](wind, **own)
    if model in theirs:
        assert theirs[model](sun, air, wind, **own) == pytest.approx(want, **PLAIN)
    still = [np.full(3, value) for value in (sun, air, wind)]
    for answer in (
        fem.fem_temperature(*still, step=60.0, model=model, **own),
        fem.heat_balance(*still, step=60.0, capacity=1e4, model=model, **own),
    ):
        assert_allclose(answer, want, rtol=1e-12, atol=1e-12)


PLAIN = {"rel": 1e-9, "abs": 1e-9}
KINDS = {
    "float32": lambda v: pd.Series(v, dtype="float32"),
    "Float64": lambda v: pd.Series(v).astype("Float64"),
    "Int64": lambda v: pd.Series(v).astype("Int64"),
    "Int16": lambda v: pd.Series(v).astype("Int16"),
    "arrow": lambda v: pd.Series(v).astype("double[pyarrow]"),
    "arrow int": lambda v: pd.Series(v).astype("Int64").astype("int64[pyarrow]"),
    "object": lambda v: pd.Series(v, dtype=object).where(~np.isnan(v), None),
    "masked": lambda v: np.ma.masked_array(np.nan_to_num(v, nan=-7999), np.isnan(v)),
    "masked int": lambda v: np.ma.masked_array(
        np.nan_to_num(v, nan=-7999).astype(int), np.isnan(v)
    ),
    "list": list,
    "strided": lambda v: np.repeat(v, 2)[::2],
    "read-only": lambda v: np.broadcast_to(v, (1, len(v)))[0],
}


@given(weathers(most=12), st.sampled_from(sorted(KINDS)), taus)
def test_the_kind_of_number_does_not_matter(weather, kind, tau):
    _, columns = weather
    plain = list(columns.values())
    given_as = [KINDS[kind](values) for values in plain]
    if isinstance(given_as[0], pd.Series):  # plain rows have steps by step=
        plain = [pd.Series(values) for values in plain]
    for function in (
        lambda sun, air, wind: fem.ewm(sun, tau, step=60),
        lambda *all_: fem.fem_temperature(*all_, step=60, tau=tau, model="faiman"),
        lambda *all_: fem.heat_balance(*all_, step=60, capacity=30 * tau),
        lambda sun, air, wind: [scores.rmse(air, sun), scores.mbe(wind, sun)],
        lambda sun, air, wind: [scores.energy_error(sun, air, wind, step=60).total],
    ):
        np.testing.assert_array_equal(function(*given_as), function(*plain))


@given(weathers(most=12), st.sampled_from(ZONES), st.sampled_from(CHANGES), taus)
def test_the_zone_does_not_matter_nor_the_night_of_its_change(
    weather, zone, start, tau
):
    seconds, columns = weather
    times = pd.Timestamp(start, tz="UTC") + pd.to_timedelta(seconds, unit="s")
    local = [pd.Series(v, times.tz_convert(zone)) for v in columns.values()]
    for function, how in (
        (fem.fem_temperature, {"tau": tau, "model": "faiman"}),
        (fem.heat_balance, {"capacity": 30 * tau}),
    ):
        answer = function(*local, **how)
        assert answer.index.equals(local[0].index)
        assert_allclose(
            answer, function(*columns.values(), times=seconds, **how), **exact
        )


pairs = st.lists(
    st.tuples(numbers(0, 1200), numbers(-30, 90), numbers(-30, 90)),
    min_size=1,
    max_size=30,
)


@given(pairs)
def test_scores_are_their_sums(rows):
    _, measured, modelled = np.array(rows).T
    errors = [a - b for a, b in zip(measured, modelled) if not math.isnan(a - b)]
    count = len(errors)
    if not count:
        for score in (scores.rmse, scores.mae, scores.mbe):
            assert math.isnan(score(measured, modelled))
        return
    squares = math.fsum(e * e for e in errors)
    assert scores.rmse(measured, modelled) == pytest.approx(math.sqrt(squares / count))
    assert scores.mbe(measured, modelled) == pytest.approx(math.fsum(errors) / count)
    total = math.fsum(map(abs, errors))
    assert scores.mae(measured, modelled) == pytest.approx(total / count)


@given(pairs, st.floats(-0.006, -0.001), st.data())
def test_an_energy_error_is_its_sum(rows, gamma, data):
    """Each sample stands for the step before it, at most twice the usual one."""
    poa, measured, modelled = np.array(rows).T
    steps = data.draw(
        st.lists(st.integers(1, 4000), min_size=len(rows), max_size=len(rows))
    )
    usual = float(np.median(steps[1:])) if len(rows) > 1 else math.nan
    stands = [usual, *(min(step, 2 * usual) for step in steps[1:])]
    over = under = sun = 0.0
    for g, real, model, step in zip(poa, measured, modelled, stands):
        energy = g / 1000.0 * step / 3600.0
        error = energy * (model - real) * gamma
        if math.isnan(error):
            continue
        sun += energy
        over, under = over + max(error, 0.0), under + min(error, 0.0)
    times = pd.Timestamp("2024-05-01") + pd.to_timedelta(np.cumsum(steps), unit="s")
    found = scores.energy_error(
        *(pd.Series(v, times) for v in (poa, measured, modelled)), gamma=gamma
    )
    assert found.over_estimate == pytest.approx(over, **PLAIN)
    assert found.under_estimate == pytest.approx(under, **PLAIN)
    assert found.total == pytest.approx(over - under, **PLAIN)
    assert found.insolation == pytest.approx(sun, **PLAIN)


@given(
    st.lists(numbers(-30, 90), min_size=2, max_size=40), st.integers(1, 1200), st.data()
)
def test_a_delayed_sensor_is_the_sensor_some_rows_ago(values, step, data):
    late = data.draw(st.integers(0, len(values)))
    times = pd.date_range("2024-05-01", periods=len(values), freq=f"{step}s")
    sensor = pd.Series(values, times)
    table = scores.delayed_sensor(sensor, [late * step])
    errors = [a - b for a, b in zip(values[late:], values)]
    errors = [e for e in errors if not math.isnan(e)]
    (row,) = table.itertuples()
    assert row.points == len(errors)
    if errors:
        squares = math.fsum(e * e for e in errors) / len(errors)
        assert row.rmse == pytest.approx(math.sqrt(squares))
    with pytest.raises(ValueError, match="no whole steps"):
        scores.delayed_sensor(sensor, [late * step + 0.5 * step])


@given(laws(), st.sampled_from(["sapm", "faiman", "wm1", "wm2", "pvsyst"]))
def test_a_translation_by_two_winds_meets_at_both(law, target):
    model, own = law
    try:
        found = fem.translate_coefficients(own, model, target, "two_winds")
    except ValueError as error:
        why = str(error)
        assert "must be below k" in why or "gains heat" in why
        return
    found = {name: found[name] for name in NAMES[target]}
    assume(math.isfinite(found.get("d", 0.0)))  # no wind at all
    for wind in (1.4, 5.4):
        want = LAWS[model](wind, **own)
        assert LAWS[target](wind, **found) == pytest.approx(want, rel=1e-9)


some = st.floats(1e-4, 10.0)


@given(
    st.lists(st.tuples(some, some, some, some, st.booleans()), min_size=1, max_size=5)
)
def test_a_stack_is_its_layers_in_series_and_its_sides_in_parallel(rows):
    made = [
        layers.Layer(f"{i}", *numbers_, 500.0, is_film=film)
        for i, (*numbers_, _, film) in enumerate(rows)
    ]
    solid = layers.Layer("solid", 1e-3, 0.5, 1000.0, 900.0)
    table = layers.stack([solid, *made], [solid])
    r = [t / c for t, c, *_ in rows]
    heat = [t * d * 500.0 for t, _, d, *_ in rows]
    r_solid, c_solid = 1e-3 / 0.5, 1e-3 * 1000.0 * 900.0
    front_r, front_c = math.fsum([r_solid, *r]), math.fsum([c_solid, *heat])
    total = table.loc["total + air"]
    assert total["r"] == pytest.approx(1 / (1 / front_r + 1 / r_solid))
    assert total["c"] == pytest.approx(front_c + c_solid)
    assert total["tau"] == pytest.approx(total["r"] * total["c"])
    without = [x for x, row in zip(r, rows) if not row[-1]]
    assert table.loc["front", "r"] == pytest.approx(math.fsum([r_solid, *without]))


@given(st.integers(0, 2**32 - 1), st.integers(1, 4), st.floats(0.0, 2.0))
def test_a_linear_search_is_the_best_of_all_faces_of_its_box(seed, size, room):
    """Least squares within bounds, against every choice of what stands at a bound."""
    random = np.random.default_rng(seed)
    matrix, target = random.normal(size=(12, size)), random.normal(size=12)
    lower, upper = np.full(size, -room), np.full(size, 0.5 * room)
    assume(room > 0.01)
    found = minimum_of(
        descent(0 * lower, lower, upper),
        lambda x: normal(target - matrix @ x, matrix),
    )
    best = math.inf
    for face in itertools.product(("low", "free", "high"), repeat=size):
        x = np.select(
            [np.array(face) == "low", np.array(face) == "high"], [lower, upper]
        )
        free = np.array(face) == "free"
        rest = target - matrix[:, ~free] @ x[~free]
        x[free] = np.linalg.lstsq(matrix[:, free], rest, rcond=None)[0]
        if ((x >= lower - 1e-12) & (x <= upper + 1e-12)).all():
            best = min(best, float(((target - matrix @ x) ** 2).sum()))
    left = float(((target - matrix @ found.x) ** 2).sum())
    assert found.converged and left == pytest.approx(best, rel=1e-9)


@pytest.fixture(scope="module")
def days():
    """Ten days at 10 min, whose module is drawn."""
    data = fem.datasets.synthetic(10, 600, seed=5, noise=0)
    return [data[name] for name in LIMITS]


@given(laws(), st.floats(200.0, 1500.0), st.floats(-5, 3), st.booleans())
def test_a_fit_without_noise_is_the_truth(days, law, tau, bias, balance):
    model, own = law
    own = dict(own)
    fixed = {n: own.pop(n) for n in ("module_efficiency",) if n in own}
    if balance:
        function, dynamics = fem.heat_balance, "balance"
        own["capacity"] = tau / LAWS[model](3.0, **own, **fixed)
    else:
        function, dynamics, own["tau"] = fem.fem_temperature, "ewm", tau
    module = function(*days, model=model, bias=bias, **own, **fixed)
    how = dict(model=model, dynamics=dynamics, fixed=fixed)
    fit = fem.fit_fem(*days, module, check_units=False, **how)
    np.testing.assert_allclose(fit.residual, 0.0, atol=1e-3)


@pytest.mark.parametrize("rows", [0, 1])
def test_one_row_is_steady_and_none_is_refused(rows):
    sun, air, wind = (np.full(rows, v) for v in (800.0, 20.0, 3.0))
    for function in (
        lambda: fem.ewm(sun, 300.0, step=60),
        lambda: fem.fem_temperature(sun, air, wind, step=60, model="faiman"),
        lambda: fem.heat_balance(sun, air, wind, step=60, capacity=1e4),
    ):
        if rows:
            assert function().shape == (1,)
            continue
        with pytest.raises(ValueError, match="is empty; give at least one row"):
            function()
    if rows:
        steady = 20.0 + 800.0 / (25.0 + 6.84 * 3.0)
        answer = fem.heat_balance(sun, air, wind, step=60, capacity=1e4)
        assert answer[0] == pytest.approx(steady)
    else:
        assert math.isnan(scores.rmse([], []))
