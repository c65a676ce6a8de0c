"""Translations: exact where they can be, pvlib's where it has them."""

import itertools

import numpy as np
import pvlib
import pytest
from pvlib.temperature import GenericLinearModel

from pvlib_fem import translate_coefficients, translation_mismatch, wm2
from pvlib_fem._translation import SHAPES, USUAL_WINDS

ETA, ALPHA = 0.19, 0.88
COEFFICIENTS = {
    "ross": dict(k=0.03),
    "noct": dict(noct=46.0),
    "sapm": dict(a=-3.47, b=-0.0594),
    "wm1": dict(k=0.033, d=12.0),
    "wm2": dict(k=0.033, k_w=0.002),
    "faiman": dict(u0=30.0, u1=4.0),
    "pvsyst": dict(u_c=29.0, u_v=1.2, module_efficiency=ETA, alpha_absorption=ALPHA),
    "noct_sam": dict(noct=45.0, module_efficiency=ETA, transmittance_absorptance=ALPHA),
}
FIXED = {
    "pvsyst": dict(module_efficiency=ETA, alpha_absorption=ALPHA),
    "noct_sam": dict(module_efficiency=ETA, transmittance_absorptance=ALPHA),
}
methods = pytest.mark.parametrize("method", ["calm", "two_winds", "least_squares"])


def resistance(model, wind):
    """T_o / G by pvlib's own functions where pvlib has the model."""
    coefficients = COEFFICIENTS[model]
    sun, air = 1000.0, 0.0
    if model in ("ross", "noct"):
        noct = coefficients.get("noct", 20 + 800 * coefficients.get("k", 0))
        return pvlib.temperature.ross(sun, air, noct) / sun + 0 * wind
    if model == "wm1":
        return coefficients["k"] * np.exp(-wind / coefficients["d"])
    if model == "wm2":
        return coefficients["k"] - coefficients["k_w"] * np.minimum(wind, 8)
    function = {
        "sapm": pvlib.temperature.sapm_module,
        "faiman": pvlib.temperature.faiman,
        "pvsyst": pvlib.temperature.pvsyst_cell,
        "noct_sam": pvlib.temperature.noct_sam,
    }[model]
    return function(sun, air, wind, **coefficients) / sun


@pytest.mark.parametrize("model", SHAPES)
def test_every_shape_is_its_models(model):
    wind = np.linspace(0, 12, 25)
    shape = SHAPES[model]
    own = shape.resistance(wind, {**shape.fixed, **COEFFICIENTS[model]})
    np.testing.assert_allclose(own, resistance(model, wind), rtol=1e-12)


@pytest.mark.parametrize(
    ("source", "target"),
    list(itertools.permutations(["faiman", "pvsyst", "noct_sam", "sapm"], 2)),
)
def test_two_winds_is_pvlibs_generic_linear_model(source, target):
    expected = GenericLinearModel(module_efficiency=ETA, absorptance=ALPHA)
    getattr(expected, f"use_{source}")(**COEFFICIENTS[source])
    expected = getattr(expected, f"to_{target}")()
    answer = translate_coefficients(
        COEFFICIENTS[source], source, target, "two_winds", **FIXED.get(target, {})
    )
    assert answer == pytest.approx(expected, rel=1e-12)


@methods
@pytest.mark.parametrize(
    ("one", "other"),
    [
        ("ross", "noct"),
        ("sapm", "wm1"),
        ("faiman", "pvsyst"),
        *((name, name) for name in SHAPES),
    ],
)
def test_exact_pairs_go_there_and_back(method, one, other):
    there = translate_coefficients(
        COEFFICIENTS[one], one, other, method, **FIXED.get(other, {})
    )
    assert translation_mismatch(
        COEFFICIENTS[one], one, other, translated=there
    ).rms == pytest.approx(0, abs=1e-6)
    back = translate_coefficients(there, other, one, method, **FIXED.get(one, {}))
    assert back == pytest.approx(COEFFICIENTS[one], rel=1e-8)


def test_in_calm_air_k_is_e_to_the_a_is_one_over_u0():
    """The paper's Eq. 12."""
    k = 0.035
    for target, name, value in (
        ("sapm", "a", np.log(k)),
        ("faiman", "u0", 1 / k),
        ("ross", "k", k),
    ):
        answer = translate_coefficients({"k": k, "d": 10}, "wm1", target, "calm")
        assert answer[name] == pytest.approx(value)


@pytest.mark.parametrize("source", SHAPES)
@pytest.mark.parametrize("target", [name for name in SHAPES if name != "noct_sam"])
def test_calm_matches_resistance_and_slope_at_no_wind(source, target):
    try:
        answer = translate_coefficients(
            COEFFICIENTS[source], source, target, "calm", **FIXED.get(target, {})
        )
    except ValueError as error:
        assert target == "wm2" and "k_w·8 must be below k" in str(error)
        return
    shape = SHAPES[target]
    wind = np.array([0.0, 1e-5])
    calm, after = shape.resistance(wind, answer)
    true_calm, true_after = resistance(source, wind)
    assert calm == pytest.approx(true_calm, rel=1e-12)
    if shape.ratio is None:
        assert after - calm == pytest.approx(true_after - true_calm, abs=1e-12)


@pytest.mark.parametrize("source", SHAPES)
@pytest.mark.parametrize("target", ["sapm", "wm1", "faiman", "wm2", "pvsyst"])
def test_least_squares_is_the_least_over_its_winds(source, target):
    """No rule leaves a smaller mean square over the same wind speeds."""
    wind = np.linspace(0.25, 7.75, 31)
    fixed = FIXED.get(target, {})
    left = {}
    for method in ("two_winds", "least_squares"):
        left[method] = translation_mismatch(
            COEFFICIENTS[source],
            source,
            target,
            wind_speed=wind,
            translated=translate_coefficients(
                COEFFICIENTS[source], source, target, method, wind_speed=wind, **fixed
            ),
        ).rms
    assert left["least_squares"] <= left["two_winds"] + 1e-6


def test_the_mismatch_is_the_difference_of_two_temperatures():
    """Faiman into sapm, against pvlib at 1000 W/m²."""
    faiman = dict(u0=25.0, u1=6.84)
    sapm = translate_coefficients(faiman, "faiman", "sapm")
    wind = np.array([0.0, 2.0, 5.0])
    difference = pvlib.temperature.sapm_module(1000, 20, wind, **sapm)
    difference = difference - pvlib.temperature.faiman(1000, 20, wind, **faiman)
    left = translation_mismatch(faiman, "faiman", "sapm", wind_speed=wind)
    assert left.worst == pytest.approx(difference[np.argmax(np.abs(difference))])
    assert left.rms == pytest.approx(np.sqrt(np.mean(difference**2)))


@pytest.mark.parametrize(
    ("source", "target"),
    [
        (source, target)
        for source in ("sapm", "wm2", "faiman", "pvsyst", "noct_sam")
        for target in ("wm1", "wm2", "faiman")
        if (source, target) != ("sapm", "wm1")
        and not (source in ("faiman", "pvsyst", "noct_sam") and target == "faiman")
        and source != target
    ],
)
def test_between_shapes_the_default_leaves_less_than_the_calm_rule(source, target):
    """Over the paper's winds, of drawn coefficients; the calm rule may find none."""
    random = np.random.default_rng(7)
    for _ in range(10):
        own = drawn(source, random.uniform)
        calm, usual = (left(own, source, target, m) for m in ("calm", "two_winds"))
        assert usual < 0.75 * calm


def drawn(model, within):
    """Coefficients as modules outdoors have them."""
    if model == "wm2":
        k = within(0.025, 0.042)
        return {"k": k, "k_w": k * within(0.2, 0.8) / 8}
    eta = {"module_efficiency": 0.2}
    return {
        "sapm": lambda: {"a": within(-3.7, -2.9), "b": within(-0.13, -0.03)},
        "faiman": lambda: {"u0": within(18, 40), "u1": within(1, 8)},
        "pvsyst": lambda: {"u_c": within(15, 29), "u_v": within(0.5, 6), **eta},
        "noct_sam": lambda: {"noct": within(42, 50), **eta},
    }[model]()


def left(own, source, target, method):
    """RMS over the paper's winds [K]; infinite where the rule gives no model."""
    try:
        return translation_mismatch(
            own, source, target, method, wind_speed=USUAL_WINDS
        ).rms
    except ValueError:
        return np.inf


SLOW_CLIP = dict(k=0.033, k_w=0.002, wind_speed_max=4.0)


@methods
def test_the_wind_up_to_which_wm2_cools_is_a_constant(method):
    """pvlib_fem.wm2 and a fit that holds it take it, too."""
    answer = translate_coefficients(SLOW_CLIP, "wm2", "wm2", method)
    assert answer == SLOW_CLIP
    for target in ("faiman", "sapm"):
        there = translate_coefficients(SLOW_CLIP, "wm2", target, method)
        back = translate_coefficients(there, target, "wm2", method, wind_speed_max=4.0)
        if method != "least_squares":  # which has no way back
            assert back == pytest.approx(SLOW_CLIP, rel=1e-8)


def test_two_winds_agree_below_and_above_the_limit_of_wm2():
    wind = np.array([1.4, 5.4])
    want = 1000.0 * (0.033 - 0.002 * np.minimum(wind, 4.0))
    faiman = translate_coefficients(SLOW_CLIP, "wm2", "faiman")
    np.testing.assert_allclose(pvlib.temperature.faiman(1000, 0, wind, **faiman), want)
    again = translate_coefficients(faiman, "faiman", "wm2", wind_speed_max=4.0)
    np.testing.assert_allclose(wm2(1000, 0, wind, **again), want)


def test_the_mismatch_of_wm2_has_its_own_limit():
    ross = {"k": 0.03}
    wind = np.linspace(0, 10, 101)
    difference = 30.0 - 1000.0 * (0.033 - 0.002 * np.minimum(wind, 4.0))
    left = translation_mismatch(SLOW_CLIP, "wm2", "ross", translated=ross)
    assert left.rms == pytest.approx(np.sqrt(np.mean(difference**2)))


@pytest.mark.parametrize("wind", [[], [np.nan, 1.0], [-1.0, 2.0]])
def test_wind_speeds_that_cannot_be_are_refused(wind):
    faiman = dict(u0=25.0, u1=6.84), "faiman", "sapm", "least_squares"
    for function in (translate_coefficients, translation_mismatch):
        with pytest.raises(ValueError, match=r"wind_speed = .* not negative"):
            function(*faiman, wind_speed=wind)


def test_the_memory_and_the_bias_go_along():
    fitted = dict(u0=25.0, u1=3.0, tau=400.0, bias=-2.0)
    answer = translate_coefficients(fitted, "faiman", "sapm")
    assert (answer["tau"], answer["bias"]) == (400.0, -2.0)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (({"k": 1}, "ross", "ros"), "unknown model 'ros'; there are ross, noct"),
        (({"u0": 1}, "faiman", "ross"), "faiman needs u1"),
        (({"k": 1, "u1": 1}, "ross", "sapm"), "ross has no coefficient u1"),
        (({"a": -3, "b": -0.1, "deltaT": 3}, "sapm", "ross"), "leave it out here"),
        (({"k": 0.03}, "ross", "noct_sam"), "noct_sam needs module_efficiency"),
        (
            ({"u0": 25, "u1": 6.84}, "faiman", "wm2", "calm"),
            "try method='two_winds' or 'least_squares'",
        ),
        (({"k": 0.03}, "ross", "sapm", "windy"), "unknown method 'windy'"),
        (({"k": 0.03}, "ross", "ross", "windy"), "unknown method 'windy'"),
        (({"k": 0.03, "k_w": 0.01}, "wm2", "sapm"), "k_w·8 must be below k"),
        (({"a": -3.0, "b": 0.1}, "sapm", "faiman"), "gains heat from wind"),
        (({"u0": "25", "u1": 3.0}, "faiman", "sapm"), "u0 = '25' must be one number"),
    ],
)
def test_what_cannot_be_translated_is_refused_by_name(arguments, message):
    with pytest.raises(ValueError, match=message):
        translate_coefficients(*arguments)


def test_wm2_needs_two_different_winds():
    with pytest.raises(ValueError, match=r"wind_speed_max = 1 m/s .* above 1\.4"):
        translate_coefficients({"k": 0.03}, "ross", "wm2", wind_speed_max=1.0)


def test_a_constant_of_another_model_is_refused():
    with pytest.raises(ValueError, match="sapm has no constant module_efficiency"):
        translate_coefficients({"k": 0.03}, "ross", "sapm", module_efficiency=0.2)


@pytest.mark.parametrize(
    ("target", "winds"),
    [("sapm", [3.0]), ("wm1", [3.0, 3.0, 3.0]), ("wm2", [9.0, 10.0, 12.0])],
)
def test_winds_that_do_not_determine_a_slope_are_refused(target, winds):
    """Above 8 m/s all winds are one wind to wm2."""
    faiman = {"u0": 25.0, "u1": 6.84}
    with pytest.raises(ValueError, match=r"does not determine .* that differ"):
        translate_coefficients(
            faiman, "faiman", target, "least_squares", wind_speed=winds
        )
    ross = translate_coefficients(faiman, "faiman", "ross", "least_squares", winds)
    mean = np.mean([1.0 / (25.0 + 6.84 * wind) for wind in winds])
    assert ross["k"] == pytest.approx(mean)
