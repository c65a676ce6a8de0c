"""Results come back from their files to the bit, or the file's fault is named."""

import json
import os
import pickle
import subprocess
import sys

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, strategies as st
from pvlib.location import Location

import pvlib_fem as fem
from pvlib_fem import datasets, simulator
from pvlib_fem._converter import AnyFloat
from pvlib_fem._findings import Finding, Kind
from pvlib_fem._record.column_names import COLUMNS
from pvlib_fem._stored import Stored, opened, saved, written
from pvlib_fem.reasons import Because, Reason, because, joined_reasons

SITE = simulator.RHINE
PLACE = dict(
    location=Location(SITE.latitude, SITE.longitude, tz=SITE.tz, name="Rhine"),
    surface_tilt=35.0,
    surface_azimuth=180.0,
)


@pytest.fixture(scope="module")
def record():
    """Effects with settings of their own, and one that follows a user's column."""
    effects = simulator.PHYSICS | {
        "sky_radiation": 1.0,
        "weekend_exhaust": 1.0,
        "shading": 1.0,
    }
    data = simulator.record(effects=effects, days=120, step=900, start="2023-04-01")
    hours = (data.index.hour >= 9) & (data.index.hour < 16)
    data["fan"] = 1.0 * ((data.index.day_of_week >= 5) & hours)
    return data.drop(columns=["longwave_down", "p_dc_per_area", "snow_depth"])


@pytest.fixture(scope="module")
def loop(record):
    return fem.close_loop(record, **PLACE, min_rmse_reduction=0.12)


@pytest.fixture(scope="module")
def files(loop, tmp_path_factory):
    """Written once: by hand, the loop with its deltaT and its fit."""
    folder = tmp_path_factory.mktemp("files")
    loop.to_json(folder / "loop.json", deltaT=3.0)
    loop.fit.to_json(folder / "fit.json", deltaT=3.0)
    return folder


def test_a_loop_comes_back_to_the_bit(loop, files):
    again = fem.Loop.from_json(files / "loop.json")
    assert "driver:fan" in loop.effects and len(loop.effects) > 2
    assert again.to_json() == (files / "loop.json").read_text("utf-8")[:-1]
    assert str(again) == str(loop)
    assert again.finding_objects == loop.finding_objects and again.ties == loop.ties
    pd.testing.assert_frame_equal(again.findings, loop.findings, check_exact=True)
    assert [str(f) for f in again.finding_objects] == [
        str(f) for f in loop.finding_objects
    ]
    assert again.untestable == loop.untestable and again.criteria == loop.criteria
    pd.testing.assert_frame_equal(again.table, loop.table, check_exact=True)
    pd.testing.assert_frame_equal(again.ranking, loop.ranking, check_exact=True)
    assert again.week_rows == loop.week_rows and again.given == loop.given
    assert again.fit.cell == {"deltaT": 3.0} and loop.fit.cell == {}


def test_what_comes_back_predicts_the_same_bits(loop, record, files):
    """On other weather, next to gaps, and with every effect's own settings."""
    other = record.iloc[:3000].assign(temp_air=record["temp_air"] - 5.0)
    other.loc[other.index[200:210], "relative_humidity"] = np.nan
    again = fem.Loop.from_json(files / "loop.json")
    for fallback in (False, True):
        want = loop.predict(other, fallback)
        pd.testing.assert_series_equal(again.predict(other, fallback), want, rtol=0)
    assert loop.predict(other).isna().sum() >= 10
    parts = again.contributions(other)
    pd.testing.assert_frame_equal(parts, loop.contributions(other), rtol=0)
    for one in (pickle.loads(pickle.dumps(loop)), again):
        specs = [effect.spec for effect in one.fit.effects]
        assert specs == [effect.spec for effect in loop.fit.effects]


def test_a_loop_of_another_place_has_its_own_sun(loop, record):
    """The place of the record is the default, and another can be given."""
    other = {**PLACE, "surface_azimuth": 90.0}
    want = fem.drivers.geometry(record.index, **other)
    given = loop.predict(record.assign(**want))
    pd.testing.assert_series_equal(loop.predict(record, surface_azimuth=90.0), given)
    assert (given - loop.predict(record)).abs().max() > 0.1


@pytest.mark.parametrize(("days", "late"), [(6, 0.0), (70, 20.0)])
def test_other_loops_come_back(days, late, tmp_path):
    """Too short to weigh anything; and with a clock that was corrected."""
    effects = simulator.PHYSICS | {"clock_shift": late}
    data = simulator.record(effects=effects, days=days, step=600, start="2023-04-01")
    loop = fem.close_loop(
        data, holdout=pd.Series(data.index.day % 5 == 0, data.index), effects="rain"
    )
    assert loop.weighed == (days > 10) and bool(loop.corrections) == (late > 0)
    text = loop.to_json(tmp_path / "loop.json")
    again = fem.Loop.from_json(tmp_path / "loop.json")
    assert again.to_json() == text and str(again) == str(loop)
    assert again.corrections == loop.corrections and again.place == loop.place
    alone = "Correcting the clock alone gives" in again.to_html()
    assert alone == ("clock corrected" in loop.table.index) == (late > 0)
    pd.testing.assert_frame_equal(again.ranking, loop.ranking, check_exact=True)


@pytest.mark.parametrize("name", ["fit.json", "loop.json"])
def test_a_fit_comes_back_from_either_file(loop, files, name):
    fit, again = loop.fit, fem.FemFit.from_json(files / name)
    assert str(again) == str(fit)
    for key in ("coefficients", "stderr", "at_bound", "notes", "base", "fixed"):
        assert getattr(again, key) == getattr(fit, key), key
    assert again.summary == fit.summary
    pd.testing.assert_frame_equal(again.scores, fit.scores, check_exact=True)
    assert again.record is again.residual is again.holdout is None
    assert again.step == fit.step
    with pytest.raises(ValueError, match="no rows and no mean wind; fit them again"):
        _ = again.wind
    with pytest.raises(ValueError, match="read from a file has no rows to plot"):
        again.plot()


def test_a_loop_from_a_file_has_a_page_without_pictures(files):
    again = fem.Loop.from_json(files / "loop.json")
    page = again.to_html()
    assert page.count("has no rows to draw or add up") == 2 and "<svg" not in page
    assert again.fit.summary.sha256 in page
    with pytest.raises(ValueError, match="has no rows to plot"):
        again.plot()


@pytest.mark.parametrize("dynamics", ["steady", "ewm", "balance"])
def test_every_dynamics_comes_back(dynamics, tmp_path):
    data = datasets.synthetic(8, 600, seed=2)
    usual = [data[name] for name in COLUMNS]
    fit = fem.fit_fem(*usual, model="faiman", dynamics=dynamics, fixed={"u1": 6.84})
    fit.to_json(tmp_path / "fit.json")
    again = fem.FemFit.from_json(tmp_path / "fit.json")
    assert again.coefficients == fit.coefficients and again.fixed == {"u1": 6.84}
    pd.testing.assert_series_equal(again.predict(*usual[:3]), fit.predict(*usual[:3]))
    pd.testing.assert_series_equal(again.predict(data), fit.predict(*usual[:3]))


@pytest.mark.parametrize("model", ["pvsyst", "noct_sam"])
def test_the_constants_of_a_model_come_back(model, tmp_path):
    """noct_sam has no default of its efficiency, so each of its fits holds one."""
    data = datasets.synthetic(8, 600, seed=2)
    fit = fem.fit_fem(data, model=model, fixed={"module_efficiency": 0.18})
    fit.to_json(tmp_path / "fit.json")
    again = fem.FemFit.from_json(tmp_path / "fit.json")
    assert again.fixed == {"module_efficiency": 0.18}
    assert again.coefficients == fit.coefficients
    pd.testing.assert_series_equal(again.predict(data), fit.predict(data))


def test_deltaT_travels_and_its_want_is_said(loop, files, record):
    """One warning if a cell temperature is needed, and none if deltaT was given."""
    weather = record.drop(columns="temp_module")
    with pytest.warns(UserWarning, match="deltaT = 0 K is taken"):
        model = loop.temperature_model(weather)
    assert model.deltaT == 0.0
    assert loop.temperature_model(deltaT=0.0).deltaT == 0.0
    again = fem.Loop.from_json(files / "loop.json")
    assert again.temperature_model(weather).deltaT == 3.0
    assert again.temperature_model(weather, k_bs_c=0.002).deltaT == 0.0
    columns = {name: weather[name] for name in ("fan", "relative_humidity")}
    for name in ("fit.json", "loop.json"):
        read = fem.DynamicCellTemperature.from_json(files / name, **columns)
        assert read.deltaT == 3.0 and read.coefficients == loop.fit.coefficients
    with pytest.raises(TypeError, match="to_json keeps deltaT and k_bs_c, no delta"):
        loop.to_json(delta=3.0)


def test_a_driver_that_lacks_is_named_with_its_argument(files, record):
    again = fem.Loop.from_json(files / "loop.json")
    bare = record[list(COLUMNS[:3])]
    with pytest.raises(ValueError, match=r"relative_humidity.*=\.\.\."):
        again.temperature_model(bare)
    with pytest.raises(ValueError, match=r"relative_humidity.*=\.\.\."):
        again.predict(bare)


BROKEN = [
    (lambda c: c.update(coefficients=None), "coefficients is null, where an object"),
    (lambda c: c["coefficients"].pop("tau"), "has no coefficients.tau"),
    (lambda c: c["coefficients"].pop("bias"), "has no coefficients.bias"),
    (lambda c: c["coefficients"].update(u0=None), "coefficients.u0 is null"),
    (lambda c: c["coefficients"].update(u0="25"), 'coefficients.u0 is "25"'),
    (lambda c: c["coefficients"].update(u0="inf"), 'coefficients.u0 is "inf"'),
    (lambda c: c["coefficients"].update(u0=True), "coefficients.u0 is true"),
    (lambda c: c["coefficients"].update(k=1.0), "coefficients.k is no coefficient"),
    (lambda c: c["base"].pop("u1"), "has no base.u1"),
    (lambda c: c["base"].update(u0=-1.0), "base.*u0 = -1"),
    (lambda c: c["coefficients"].update(u0=1e308), r"coefficients.u0 is 1e\+308 W"),
    (lambda c: c.update(fixed={"u0": 3.0}), "fixed.u0 is 3, and coefficients.u0 is"),
    (lambda c: c.update(stderr={}), "has no stderr.u0"),
    (lambda c: c["cell"].update(deltaT=None), "cell.deltaT is null"),
    (lambda c: c["cell"].update(evil=1), "cell.evil is none of deltaT, k_bs_c"),
    (lambda c: c["effects"].append("dust"), "unknown effect 'dust'.*given again"),
    (lambda c: c.update(dynamics="fast"), "unknown dynamics 'fast'"),
    (lambda c: c.update(version=0), "is of version 0 of its format"),
    (lambda c: c.pop("version"), "is of version None of its format"),
    (lambda c: c.pop("format"), "its format is not said"),
]


@pytest.mark.parametrize(("damage", "message"), BROKEN)
def test_a_broken_file_is_refused_by_its_key(files, tmp_path, damage, message):
    content = json.loads((files / "fit.json").read_text("utf-8"))
    damage(content)
    path = tmp_path / "broken.json"
    path.write_text(json.dumps(content), "utf-8")
    for read in (fem.FemFit.from_json, fem.DynamicCellTemperature.from_json):
        with pytest.raises(ValueError, match=message):
            read(path)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("{", "is no JSON"),
        ("[]", "its format is not"),
        ('{"a": NaN}', "holds NaN"),
        ('{"a": {"b": 1, "b": 2}}', "holds b twice"),
        ("[" * 100_000 + "]" * 100_000, "nested deeper"),
    ],
)
def test_what_is_no_result_is_refused(tmp_path, text, message):
    (tmp_path / "x.json").write_text(text)
    for read in (fem.FemFit.from_json, fem.Loop.from_json):
        with pytest.raises(ValueError, match=message):
            read(tmp_path / "x.json")


def test_the_text_of_a_result_is_no_path(loop):
    with pytest.raises(ValueError, match=r"as to_json\(\) returns it; write it to a"):
        fem.FemFit.from_json(loop.fit.to_json())


@pytest.mark.parametrize(
    ("damage", "message"),
    [
        (lambda c: c["u0"].update(u1=2.0), "correlation holds no correlations"),
        (lambda c: c["u0"].update(u0=0.5), "correlation holds no correlations"),
        (lambda c: c["u0"].pop("u1"), "correlation is of .*where a table of"),
        (lambda c: c.update(x={}), "correlation is of .*, x, where a table of"),
        (lambda c: c["u0"].update(u1="0"), 'correlation.u0.u1 is "0"'),
    ],
)
def test_broken_correlations_are_refused(files, tmp_path, damage, message):
    content = json.loads((files / "fit.json").read_text("utf-8"))
    damage(content["correlation"])
    (tmp_path / "x.json").write_text(json.dumps(content))
    with pytest.raises(ValueError, match=message):
        fem.FemFit.from_json(tmp_path / "x.json")


def test_the_covariance_has_the_errors_of_the_fit(loop, files):
    fit = fem.FemFit.from_json(files / "fit.json")
    pd.testing.assert_frame_equal(fit.covariance, loop.fit.covariance)
    error = pd.Series(np.sqrt(np.diag(fit.covariance)), fit.covariance.index)
    assert error.to_dict() == pytest.approx({n: fit.stderr[n] for n in error.index})
    assert np.linalg.eigvalsh(fit.correlation).min() > -1e-12


def test_a_count_is_not_negative(files, tmp_path):
    content = json.loads((files / "fit.json").read_text("utf-8")) | {"train_days": -5}
    (tmp_path / "x.json").write_text(json.dumps(content))
    with pytest.raises(ValueError, match="train_days is -5, where a count belongs"):
        fem.FemFit.from_json(tmp_path / "x.json")


def test_a_fault_in_the_fit_of_a_loop_is_named_with_its_place(files, tmp_path):
    content = json.loads((files / "loop.json").read_text("utf-8"))
    content["fit"]["cell"] = {"evil": 1}
    (tmp_path / "x.json").write_text(json.dumps(content))
    for read in (fem.FemFit, fem.Loop, fem.DynamicCellTemperature):
        with pytest.raises(ValueError, match=r"fit\.cell\.evil is none of"):
            read.from_json(tmp_path / "x.json")


def test_the_file_of_a_fit_is_no_loop(files):
    with pytest.raises(ValueError, match=r"is no file of pvlib_fem\.Loop"):
        fem.Loop.from_json(files / "fit.json")


@given(st.dictionaries(st.text(), st.floats(allow_nan=False), max_size=5))
def test_every_number_keeps_its_bits(tmp_path_factory, numbers):
    path = tmp_path_factory.getbasetemp() / "numbers.json"
    written("x", {"numbers": numbers}, path)
    with opened(path, ["x"]) as stored:
        again = stored.read("numbers", dict[str, AnyFloat])
    assert list(again) == list(numbers)
    for name, value in numbers.items():
        assert np.float64(again[name]).tobytes() == np.float64(value).tobytes()


WRONG = [
    (lambda c: c.pop("unit"), "has no findings.0.checks.0.unit"),  # it has a default
    (lambda c: c.update(name=3), "checks.0.name is 3, where a text belongs"),
    (lambda c: c.update(most=1), "checks.0.most is 1, where true or false belongs"),
    (lambda c: c.update(threshold=True), "threshold is true, where a number belongs"),
    (lambda c: c.update(threshold="nan"), 'threshold is "nan", where a number'),
]


@pytest.mark.parametrize(("damage", "message"), WRONG)
def test_a_wrong_value_deep_in_a_loop_is_named_by_its_place(
    files, tmp_path, damage, message
):
    content = json.loads((files / "loop.json").read_text("utf-8"))
    damage(content["findings"][0]["checks"][0])
    (tmp_path / "x.json").write_text(json.dumps(content))
    with pytest.raises(ValueError, match=message):
        fem.Loop.from_json(tmp_path / "x.json")


def test_parts_of_a_loop_that_do_not_fit_are_refused(files, tmp_path):
    content = json.loads((files / "loop.json").read_text("utf-8"))
    dated = {"name": "irradiance_sensor_step", "at": "NaT"}
    vague = [{"reason": "DETECTABLE", "gain": "x"}]
    for change, message in [
        ({"last": "+dust"}, r"last is '\+dust', and no row of the table"),
        ({"untestable": {"snow": vague}}, "untestable.snow is what no to_json wrote"),
        ({"fit": content["fit"] | {"effects": [dated]}}, "'NaT' is no date"),
    ]:
        (tmp_path / "x.json").write_text(json.dumps(content | change))
        with pytest.raises(ValueError, match=message):
            fem.Loop.from_json(tmp_path / "x.json")


@pytest.mark.parametrize("count", [10**30, 10**400])
def test_a_whole_number_of_any_size_is_read_or_refused(count):
    stored = Stored({"a": count}, "a.json")
    if count > 10**308:
        with pytest.raises(ValueError, match=r"a is 1000.*, where a number of double"):
            stored.read("a", float)
    else:
        assert isinstance(stored.read("a", float), float)


@pytest.mark.parametrize(
    ("key", "value", "message"),
    [
        ("verdict", "sure", "0.verdict is .sure., where one of identified, ambig"),
        ("kind", "OTHER", "0.kind is .OTHER., where one of EFFECT, OWN, COLUMN, STR"),
        ("candidates", "rain", "0.candidates is .rain., where a list belongs"),
        ("ranges", {"a": [1.0]}, r"0.ranges.a is \[1.0\], where a list of 2 belongs"),
        ("because", [{"reason": "OLD"}], "0.because is .*OLD is none of the reasons"),
    ],
)
def test_a_finding_is_of_the_types_of_its_fields(files, key, value, message):
    content = json.loads((files / "loop.json").read_text("utf-8"))["findings"]
    content[0][key] = value
    with pytest.raises(ValueError, match=rf"^a.json: findings.{message}"):
        Stored({"findings": content}, "a.json").read("findings", list[Finding])


def test_findings_come_back_as_what_they_were(loop, files):
    """A verdict equals its text, and is compared by identity."""
    again = fem.Loop.from_json(files / "loop.json")
    assert again.finding_objects
    assert loop.finding_objects
    for one, was in zip(again.finding_objects, loop.finding_objects, strict=True):
        assert one.verdict is was.verdict and one.kind is was.kind
        assert type(one.because) is Because and repr(one) == repr(was)


def test_the_converter_is_imported_when_a_file_is_written():
    code = (
        "import sys, pvlib_fem as fem; fem.close_loop, fem.FemFit\n"
        "from pvlib_fem._stored import written\n"
        "assert 'cattrs' not in sys.modules\n"
        "written('x', {}); assert 'cattrs' in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_reasons_come_back_typed():
    why = joined_reasons(
        [
            because(Reason.LACKS, columns=["a", "b"]),
            because(Reason.DETECTABLE, gain=float("inf")),
        ]
    )
    assert Because.stored(json.loads(json.dumps(why.content()))) == why
    assert Kind["COLUMN"] is Kind.COLUMN


def test_a_file_stays_whole_where_the_next_cannot_be_written(tmp_path):
    path = tmp_path / "fit.json"
    saved("whole", path)
    with pytest.raises(UnicodeEncodeError):
        saved("half \udc80", path)
    assert path.read_text() == "whole"
    assert os.listdir(tmp_path) == ["fit.json"]


@pytest.mark.skipif(sys.platform == "win32", reason="links need rights there")
def test_a_link_stays_a_link(tmp_path):
    (tmp_path / "real.json").write_text("old")
    (tmp_path / "link.json").symlink_to("real.json")
    saved("new", tmp_path / "link.json")
    assert (tmp_path / "link.json").is_symlink()
    assert (tmp_path / "real.json").read_text() == "new"


def keys(content, place=()):
    """Ways to all that is in a file."""
    inside = content.items() if isinstance(content, dict) else enumerate(content)
    for key, value in inside:
        yield (*place, key)
        if isinstance(value, dict | list):
            yield from keys(value, (*place, key))


@given(st.data())
def test_a_file_that_is_damaged_anywhere_is_refused_or_read(files, data):
    """A missing or changed value raises no other error and makes no new NaN."""
    content = json.loads((files / "loop.json").read_text("utf-8"))
    *way, last = data.draw(st.sampled_from(list(keys(content))))
    part = content
    for key in way:
        part = part[key]
    if data.draw(st.booleans()):
        del part[last]
    else:
        part[last] = data.draw(st.sampled_from([None, "x", [], {}, -1, True, 0.5]))
    path = files / "damaged.json"
    path.write_text(json.dumps(content), "utf-8")
    try:
        again = fem.Loop.from_json(path)
    except ValueError as error:
        assert "damaged.json" in str(error)
    else:
        assert np.isfinite(list(again.fit.coefficients.values())).all()


@pytest.mark.skipif(not os.path.isdir("/dev/fd"), reason="no such folder here")
def test_what_is_no_file_is_written_to():
    """A pipe, as /dev/stdout may be."""
    out, into = os.pipe()
    saved("through", f"/dev/fd/{into}")
    os.close(into)
    with open(out, encoding="utf-8") as file:
        assert file.read() == "through"
