"""The record without the faults of its instruments: what was true comes back."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from conftest import COLUMNS, DRIVERS
from test_instruments import DATES, dated

import pvlib_fem as fem
from pvlib_fem import datasets
from pvlib_fem._correction.faults import causes_by_finding
from pvlib_fem._findings import Finding, Verdict
from pvlib_fem._loop.results.conclude import NINETY, range_around, relative_error
from pvlib_fem._record.inputs import read
from pvlib_fem._thermal.model import ThermalModel
from pvlib_fem._thermal.steady_models import STEADY_MODELS
from pvlib_fem.drivers import derive_drivers, needed_for
from pvlib_fem.effects import find
from pvlib_fem.reasons import Reason, because

TRUTH = {"u0": 26.0, "u1": 6.0, "capacity": 12e3, "bias": -0.5}


@pytest.fixture(scope="module")
def true():
    """Two hundred days at half an hour as sound instruments would have them."""
    data = datasets.synthetic(200, 1800, seed=3, noise=0).tz_localize(None)
    rain = np.random.default_rng(4).uniform(size=len(data)) < 0.003
    data["precipitation"] = np.where(rain, 8.0, 0.0)
    model = ThermalModel(STEADY_MODELS["faiman"], "balance")
    module = model.predict(*(data[n] for n in DRIVERS), TRUTH)
    noise = np.random.default_rng(1).normal(0.0, 0.4, len(data))
    smooth = pd.Series(noise, data.index).ewm(halflife=4).mean()
    return data[[*DRIVERS, "precipitation"]].assign(temp_module=module + smooth)


@pytest.fixture(scope="module")
def sound(true):
    """The loop of a part of it, in which nothing is found."""
    loop = fem.close_loop(true[list(COLUMNS)].iloc[: 48 * 60])
    assert not any(finding.added for finding in loop.finding_objects)
    return replace(loop, times=None)


def weight(effect, index):
    """How much of a change there is at each time."""
    terms = effect.terms
    return terms.time_profile.weight(**terms.dates)(
        (index - pd.Timestamp(0)) / pd.Timedelta("1D")
    )


def faulty(true, effect, size):
    """What the instruments write with a fault, by what each fault means."""
    kind = effect.sensor_fault or effect.name
    poa, air, wind, module = (true[name] for name in COLUMNS)
    if kind == "soiling":
        inputs = derive_drivers(
            read({"precipitation": true["precipitation"]}), effect.drivers
        )
        dirty = inputs[effect.drivers[1]]
        return true.assign(poa_global=poa / (1.0 + size * dirty))
    if kind == "air_shield":
        return true.assign(temp_air=air + size * poa / 1000.0 * np.exp(-wind / 1.2))
    now = size * weight(effect, true.index)
    if kind == "irradiance_sensor":
        return true.assign(poa_global=poa / (1.0 + now))
    if kind == "anemometer":
        return true.assign(wind_speed=wind / (1.0 + now))
    if kind == "anemometer_stall":  # below 1.5 m/s it stands earlier
        light = ((wind - 1.5 * now) / (1.0 - now)).clip(lower=0.0)
        return true.assign(wind_speed=light.where(wind < 1.5, wind))
    if kind == "air_offset":
        return true.assign(temp_air=air - now)
    if kind == "air_sensor_shield":
        return true.assign(temp_air=air - now * poa / 1000.0)
    if kind == "module_sensor_contact":  # the reading is T_air + (1 + gain) (T - T_air)
        zero = air + TRUTH["bias"]
        return true.assign(temp_module=zero + (module - zero) / (1.0 + now))
    assert kind == "module_offset"
    return true.assign(temp_module=module - now)


def found(loop, data, *effects):
    """The loop with these effects in its model, as if it had found and named them."""
    needed = {n for e in effects for n in needed_for(e.drivers)} - {*DRIVERS}
    fit = fem.fit_fem(
        *(data[name] for name in COLUMNS),
        model="faiman",
        dynamics="balance",
        night=True,
        effects=effects,
        **{name: data[name] for name in needed if name in data},
    )
    return replace(
        loop, fit=fit, finding_objects=tuple(named(fit, e, loop) for e in effects)
    )


def named(fit, effect, loop):
    (key,), (row,) = effect.rows(), effect.rows().values()
    value, error = fit.coefficients[key], fit.stderr[key]
    law = relative_error(effect, loop.criteria)
    return Finding(
        effect.name,
        (effect.name,),
        Verdict.IDENTIFIED,
        1.0,
        {key: value},
        {key: error},
        because(Reason.GAINED, gain=1.0),
        ranges={key: range_around(value, [NINETY * error, NINETY * law * value], row)},
    )


#: name of the effect: what a correction adds, a share or K
FAULTS = {
    "irradiance_sensor_step": (0.12, -0.08),
    "irradiance_sensor_drift": (0.1, -0.1),
    "irradiance_sensor_episode": (0.15, -0.15),
    "soiling": (0.004,),
    "anemometer_step": (0.4, -0.25),
    "anemometer_drift": (0.5,),
    "anemometer_stall_step": (0.3,),
    "air_offset_step": (1.5, -1.5),
    "air_offset_drift": (3.0,),
    "air_sensor_shield_step": (2.5, -2.5),
    "air_shield": (3.0,),
    "module_sensor_contact_step": (0.2, -0.12),
    "module_sensor_contact_episode": (0.25,),
    "module_offset_step": (1.5, -1.5),
    "module_offset_drift": (-3.0,),
}


def effect_of(name):
    return (
        dated(name) if "_" in name and name.rsplit("_", 1)[1] in DATES else find(name)
    )


CASES = [(name, size) for name, sizes in FAULTS.items() for size in sizes]


#: trends that begin, end, or both within the record
TRENDS = [
    {"start": "2023-08-10"},
    {"since": "2023-06-01", "end": "2023-09-20"},
    {"start": "2023-07-20", "end": "2023-10-05"},
]
PARTS = [
    (find({"name": name, **dates}), size)
    for name, size in (("irradiance_sensor_drift", 0.5), ("module_offset_drift", -4.0))
    for dates in TRENDS
]


@pytest.mark.parametrize(
    "effect, size", [(effect_of(name), size) for name, size in CASES] + PARTS
)
def test_the_true_column_is_within_the_stated_range(true, sound, effect, size):
    name = effect.name
    data = faulty(true, effect, size)
    loop = found(sound, data, effect)
    corrected = loop.corrected(data)
    (action,) = corrected.actions.itertuples()
    column, was = action.column, data[action.column]
    assert action.applied and action.cause == name
    assert [n for n in data if not data[n].equals(corrected.data[n])] == [column]
    assert corrected.data[f"{column}_original"].equals(was)
    assert action.stderr > 0.0
    # where an anemometer stands, the wind is any below the one in which it turns, and
    # of a module as warm as the air a contact shows nothing
    over = (was - true["temp_air"]).abs()
    rows = {"wind_speed": was > 0.0, "temp_module": over > 5.0}.get(column, was == was)
    added, wanted = corrected.data[column] - was, true[column] - was
    ends = [added * end / action.size for end in (action.low, action.high)]
    low, high = np.minimum(*ends), np.maximum(*ends)
    assert ((low - 1e-9 <= wanted) & (wanted <= high + 1e-9))[rows].all()
    left = corrected.data[column] - true[column]
    assert (left[rows] ** 2).sum() < 0.1 * (wanted[rows] ** 2).sum()
    flagged = corrected.data["corrected"] == name
    assert (
        flagged.equals(corrected.data[column] != was) and flagged.sum() == action.rows
    )


def power_of(true, seed=3):
    """Power of a plant by the true irradiance and the true temperature."""
    noise = np.random.default_rng(seed).normal(0.0, 2.0, len(true))
    sunny = true["poa_global"] > 0.0
    ideal = true["poa_global"] * (1.0 - 0.004 * (true["temp_module"] - 25.0))
    return 0.2 * ideal + noise * sunny


@pytest.fixture(scope="module")
def ambiguous(true):
    """A sensor that loses an eighth, of a record that cannot tell that it does."""
    data = faulty(true, effect_of("irradiance_sensor_step"), 0.12)[list(COLUMNS)]
    return data, fem.close_loop(data)


@pytest.fixture(scope="module")
def named_one(true):
    """A sensor that loses an eighth, as power and a second sensor show."""
    data = faulty(true, effect_of("irradiance_sensor_step"), 0.12)[list(COLUMNS)]
    random = np.random.default_rng(5).normal(0.0, 0.01, len(data))
    data = data.assign(poa_global_2=true["poa_global"] * (1.0 + random))
    data["power_ac"] = power_of(true)
    return data, fem.close_loop(data)


def test_what_the_loop_names_is_taken_out(named_one, true):
    data, loop = named_one
    corrected = loop.corrected(data)
    (action,) = corrected.actions.itertuples()
    assert action.cause == "irradiance_sensor_step" and action.column == "poa_global"
    assert action.low < 0.12 < action.high and action.unit == "-"
    (key,) = loop.finding_objects[0].coefficients
    assert action.stderr == pytest.approx(loop.finding_objects[0].stderr[key])
    at = loop.fit.effects[-1].settings["at"]
    assert action.start == at and action.end == "2023-12-17"
    assert "the irradiance sensor reads less from" in str(corrected)
    left = corrected.data["poa_global"][at:] / true["poa_global"][at:] - 1.0
    assert abs(left).max() < 0.01
    before = corrected.data["poa_global"][:"2023-09-11"]
    assert before.equals(data["poa_global"][:"2023-09-11"])


def test_test_weeks_and_fitting_weeks_are_corrected_alike(named_one):
    data, loop = named_one
    corrected = loop.corrected(data).data
    factor = (corrected["poa_global"] / data["poa_global"])["2023-10":]
    by_weeks = factor.groupby(loop.weeks["2023-10":], observed=True)
    assert by_weeks.count().min() > 100
    assert by_weeks.max()["test"] == pytest.approx(by_weeks.min()["fitting"])


def test_a_corrected_record_shows_the_fault_no_more(named_one, ambiguous):
    data, loop = named_one
    again = fem.close_loop(loop.corrected(data).data)
    assert not any(finding.added for finding in again.finding_objects)
    kept = "poa_global_original is as it was measured, before a correction: not used"
    assert kept in again.notes
    data, loop = ambiguous
    resolved = loop.corrected(data, resolve="irradiance_sensor_step").data
    again = fem.close_loop(resolved)
    assert not any(finding.added for finding in again.finding_objects)


def test_an_ambiguous_finding_changes_nothing_until_its_cause_is_given(ambiguous, true):
    data, loop = ambiguous
    (finding,) = (one for one in loop.finding_objects if one.added)
    assert {
        "irradiance_sensor_step",
        "module_sensor_contact_step",
        "mounting_step",
    } <= {*finding.candidates}
    alone = loop.corrected(data)
    assert alone.data[list(COLUMNS)].equals(data)
    assert not alone.actions["applied"].any()
    assert "name the cause with resolve=" in str(alone)
    columns = {
        "irradiance_sensor_step": "poa_global",
        "module_sensor_contact_step": "temp_module",
    }
    for cause, column in columns.items():
        resolved = loop.corrected(data, resolve=[cause])
        changed = [n for n in data if not data[n].equals(resolved.data[n])]
        assert changed == [column]
        (action,) = resolved.actions.itertuples()
        assert action.applied and action.cause == cause
    assert loop.corrected(data, "irradiance_sensor_step").actions["size"][
        0
    ] == pytest.approx(0.12, abs=0.01)
    mounting = loop.corrected(data, "mounting_step")
    assert mounting.data[list(COLUMNS)].equals(data)
    assert "no wrong reading of an instrument" in str(mounting)


def test_a_cause_can_be_of_one_finding(ambiguous):
    """So two findings with the same candidates can have different causes."""
    data, loop = ambiguous
    (name,) = (one.effect for one in loop.finding_objects if one.added)
    cause = "module_sensor_contact_step"
    usual = loop.corrected(data, cause)
    for resolve in ({name: cause}, f"{name}={cause}"):
        assert loop.corrected(data, resolve).data.equals(usual.data)
    with pytest.raises(ValueError, match="'rain=module_sensor_contact_step', which"):
        loop.corrected(data, {"rain": cause})
    one, other = (
        replace(f, effect=effect)
        for f in loop.finding_objects
        if f.added
        for effect in ("air_offset_step", "module_offset_step")
    )
    own = {"air_offset_step": cause}
    assert causes_by_finding([one, other], own) == own
    assert causes_by_finding([one, other], [cause, cause]) == {
        "air_offset_step": cause,
        "module_offset_step": cause,
    }


def test_snow_is_no_wrong_reading_also_if_no_column_shows_it(ambiguous):
    data, loop = ambiguous
    findings = [
        replace(one, candidates=(*one.candidates, "snow")) if one.added else one
        for one in loop.finding_objects
    ]
    snowy = replace(loop, finding_objects=findings)
    resolved = snowy.corrected(data, "snow")
    assert resolved.data[list(COLUMNS)].equals(data)
    assert "no wrong reading of an instrument" in str(resolved)


def test_only_one_candidate_of_a_finding_is_its_cause(ambiguous):
    data, loop = ambiguous
    with pytest.raises(ValueError, match="'rain', which is no candidate of an amb"):
        loop.corrected(data, ["rain"])
    with pytest.raises(ValueError, match="candidates of one finding; give one"):
        loop.corrected(data, ["irradiance_sensor_step", "module_sensor_contact_step"])


def test_a_loop_of_a_file_corrects_the_same(ambiguous, tmp_path):
    data, loop = ambiguous
    loop.to_json(tmp_path / "loop.json")
    again = fem.Loop.from_json(tmp_path / "loop.json")
    assert again.finding_objects == loop.finding_objects
    for cause in (
        "irradiance_sensor_step",
        "module_sensor_contact_step",
        "air_sensor_shield_step",
    ):
        one, other = (each.corrected(data, cause) for each in (loop, again))
        assert one.data.equals(other.data) and one.actions.equals(other.actions)


def test_a_part_is_corrected_as_the_whole(named_one):
    data, loop = named_one
    whole = loop.corrected(data).data
    part = loop.corrected(data["2023-09-10":"2023-10-10"]).data
    assert part["poa_global"].equals(whole["poa_global"]["2023-09-10":"2023-10-10"])


def test_rows_beyond_the_record_stay_as_they_were_and_are_flagged(named_one):
    data, loop = named_one
    later = data.set_axis(data.index + pd.Timedelta(days=100))
    corrected = loop.corrected(later)
    beyond = (later.index > data.index[-1]).astype(bool)
    assert corrected.data[beyond][[*data]].equals(later[beyond])
    assert set(corrected.data["corrected"][beyond]) == {"outside the record"}
    assert f"{beyond.sum():,} rows are outside the record" in str(corrected)


def test_a_record_of_another_time_or_index_is_refused(named_one):
    data, loop = named_one
    for other, words in (
        (data.set_axis(data.index + pd.Timedelta(days=3650)), "no row within the rec"),
        (data.tz_localize("UTC"), r"\(UTC\), and the record is .* \(without a zone\)"),
        (data.reset_index(drop=True), "is a RangeIndex; give the times"),
        (data.iloc[:0], "they are no rows"),
        (loop.corrected(data).data, "data have corrected, as a record that"),
    ):
        with pytest.raises(ValueError, match=words):
            loop.corrected(other)


def test_missing_values_stay_missing(named_one):
    data, loop = named_one
    holes = data.copy()
    holes.loc["2023-10-01":"2023-10-03", "poa_global"] = np.nan
    corrected = loop.corrected(holes).data
    assert corrected["poa_global"].isna().equals(holes["poa_global"].isna())
    assert set(corrected["corrected"]["2023-10-01":"2023-10-03"]) == {""}
    whole = loop.corrected(data).data["poa_global"]
    known = holes["poa_global"].notna()
    assert corrected["poa_global"][known].equals(whole[known])


def test_a_row_without_the_column_that_its_correction_needs_is_unknown(true, sound):
    effect = effect_of("air_sensor_shield_step")
    data = faulty(true, effect, 2.5)
    loop = found(sound, data, effect)
    holes = data.copy()
    holes.loc["2023-10-01 12:00":"2023-10-01 13:00", "poa_global"] = np.nan
    corrected = loop.corrected(holes).data
    assert corrected["temp_air"].isna().sum() == 3
    without = loop.corrected(data.drop(columns="poa_global"))
    assert without.data["temp_air"].equals(data["temp_air"])
    assert "data have no poa_global" in str(without)


def test_faults_of_one_sensor_are_taken_out_together(true, sound):
    effects = effect_of("module_sensor_contact_step"), effect_of("module_offset_step")
    data = faulty(faulty(true, effects[0], 0.2), effects[1], 1.5)
    corrected = found(sound, data, *effects).corrected(data)
    assert list(corrected.actions["column"]) == ["temp_module"] * 2
    error = corrected.data["temp_module"] - true["temp_module"]
    assert error.abs().mean() < 0.1 < (data - true)["temp_module"].abs().mean()
    both = corrected.data["corrected"].astype(str)["2023-09-15":]
    assert (both == "module_sensor_contact_step, module_offset_step").mean() > 0.9


def test_an_anemometer_is_corrected_by_a_loss_that_is_proportional(true, sound):
    effect = effect_of("anemometer_step")
    data = faulty(true, effect, 0.3)
    loop = found(sound, data, effect)
    coefficients = {n: v for n, v in loop.fit.coefficients.items() if n != "u1"}
    loop = replace(loop, fit=replace(loop.fit, coefficients=coefficients))
    corrected = loop.corrected(data)
    assert corrected.data["wind_speed"].equals(data["wind_speed"])
    assert "close the loop with model='faiman'" in str(corrected)


def test_dirt_on_the_module_is_no_fault_of_the_sensor(true, sound):
    effect = effect_of("soiling")
    data = faulty(true, effect, -0.002)
    corrected = found(sound, data, effect).corrected(data)
    assert corrected.data["poa_global"].equals(data["poa_global"])
    assert "the module soils and not the sensor" in str(corrected)


def test_humidity_as_a_fraction_is_converted(named_one):
    data, loop = named_one
    damp = data.assign(relative_humidity=np.linspace(0.2, 0.9, len(data)))
    corrected = loop.corrected(damp)
    assert np.allclose(
        corrected.data["relative_humidity"], 100.0 * damp["relative_humidity"]
    )
    assert "its numbers are fraction. Converted to %" in str(corrected)


def test_names_of_the_users_frame_stay(named_one):
    data, loop = named_one
    data = data.assign(place="roof").rename_axis("Zeit")
    corrected = loop.corrected(data).data
    assert corrected.index.name == "Zeit" and (corrected["place"] == "roof").all()
    assert [*corrected] == [
        "poa_global",
        "poa_global_original",
        *(n for n in data if n != "poa_global"),
        "corrected",
    ]
    assert "corrected" not in data  # nothing changes its input


@pytest.fixture(scope="module")
def late():
    """A year's half whose module is written two hours late, with its power or not."""
    data = datasets.synthetic(120, 1800, seed=5, noise=0).tz_localize(None)
    data = data[list(COLUMNS)]
    data["p_dc_per_area"] = 0.18 * data["poa_global"]
    return data.assign(temp_module=data["temp_module"].shift(4)), data


@pytest.mark.parametrize("shared", [True, False])
def test_power_is_moved_where_the_same_logger_wrote_it(late, shared):
    data, true = late
    if shared:
        data = data.assign(p_dc_per_area=data["p_dc_per_area"].shift(4))
    loop = fem.close_loop(data, effects=[])
    assert loop.times.module.fault
    corrected = loop.corrected(data)
    names = ["temp_module", "p_dc_per_area"] if shared else ["temp_module"]
    assert list(corrected.actions["column"]) == names
    assert [*corrected.actions["size"]] == pytest.approx([-120.0] * len(names))
    for name in names:
        both = corrected.data[name].notna() & data[name].notna()
        assert np.allclose(corrected.data[name][both], true[name][both])
    again = fem.close_loop(corrected.data, effects=[])
    assert not again.times.module.fault
    assert {f"{n}_original" for n in names} == {
        n for n in corrected.data if n.endswith("_original")
    }
