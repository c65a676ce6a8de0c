"""Records: the measured ones as pinned, the made-up one as planted."""

import hashlib
import subprocess
import sys
import zipfile
from pathlib import Path

import numpy as np
import pandas as pd
import pooch
import pytest

from pvlib_fem import datasets, fem_temperature, heat_balance
from pvlib_fem.datasets import _download as files, _pip_wheel as wheel
from pvlib_fem.datasets._measured_records import BOLZANO, GOLDEN


def test_the_measured_week(week):
    """10 080 rows at 1 min, 18 to 24 March 2020, nights about 5 K below the air."""
    assert len(week) == 10_080
    assert week.index[0] == pd.Timestamp("2020-03-18")
    assert (np.diff(week.index.values) == np.timedelta64(60, "s")).all()
    night = week[week["poa_global"] < 1]
    assert (night["temp_module"] - night["temp_air"]).mean() == pytest.approx(-5, abs=1)
    assert "10.5281/zenodo.10003736" in week.attrs["source"]


def test_the_measured_day(day):
    """1351 rows at 1 min, sixteen sensors that differ by kelvins by position."""
    assert len(day) == 1351
    sensors = day[[f"temp_module_{i}" for i in range(1, 17)]]
    spread = (sensors.max(axis=1) - sensors.min(axis=1)).max()
    assert spread == pytest.approx(5.9, abs=0.1)
    first_array = [f"temp_module_{i}" for i in range(1, 9)]
    assert day["temp_module"].iloc[700] == pytest.approx(
        day[first_array].iloc[700].mean()
    )
    assert day["wind_direction"].between(0, 360).all()


def test_a_folder_without_the_file_is_passed_over(tmp_path, monkeypatch):
    asked = []

    def retrieve(url, known_hash, fname, path):
        asked.append(url)
        return str(path / fname)  # as pooch does

    monkeypatch.setenv(files.FOLDER, str(tmp_path))
    monkeypatch.setattr(pooch, "retrieve", retrieve)
    name = "sandia_week_1min.csv"
    assert files.fetch(name) == files.cache() / name
    assert asked == [files.FILES[name][0]]


def test_without_a_network_the_message_says_where_a_file_can_be_put(monkeypatch):
    def offline(*arguments, **options):
        raise ConnectionError("Max retries exceeded with url: /pvlib/…")

    monkeypatch.delenv(files.FOLDER, raising=False)
    monkeypatch.setattr(pooch, "retrieve", offline)
    with pytest.raises(OSError, match="environment variable PVLIB_FEM_DATA") as refused:
        datasets.load("sandia_week")
    assert files.FILES["sandia_week_1min.csv"][0] in str(refused.value)
    assert refused.value.__cause__ is None and refused.value.__suppress_context__


def test_another_file_of_that_name_is_refused(tmp_path, monkeypatch):
    (tmp_path / "sandia_week_1min.csv").write_text("time,poa_global\n")
    monkeypatch.setenv(files.FOLDER, str(tmp_path))
    with pytest.raises(ValueError, match="is not the pinned file"):
        datasets.load("sandia_week")


def test_an_unknown_record_is_named():
    with pytest.raises(ValueError, match="unknown record 'week'; there are sandia_w"):
        datasets.load("week")


@pytest.fixture
def small_wheel(tmp_path, monkeypatch):
    """A wheel with two small records, pinned in place of the public one."""
    times = pd.date_range("2012-03-31 22:00", periods=4, freq="h", name="timestamp")
    path = tmp_path / "elsewhere" / wheel.WHEEL
    path.parent.mkdir()
    with zipfile.ZipFile(path, "w") as file:
        for (name, member), columns in zip(wheel.MEMBERS.items(), (BOLZANO, GOLDEN)):
            raw = {column: [1, 2, 3, 4] for column in [*columns.values(), "other"]}
            pd.DataFrame(raw, times).to_parquet(tmp_path / name)
            file.write(tmp_path / name, member)
        file.writestr("pvcopilot/data/examples/another.parquet", "not to be read")
    sha256 = hashlib.sha256(path.read_bytes()).hexdigest()
    monkeypatch.setattr(wheel, "SHA256", sha256)
    monkeypatch.setattr(pooch, "os_cache", lambda project: tmp_path / "cache")
    monkeypatch.delenv(files.FOLDER, raising=False)
    return path


def pip(monkeypatch, wheel_file=None, stderr="", error=None):
    """Replace pip: it brings a file, or fails; its commands are returned."""
    asked = []

    def run(command, **options):
        asked.append(command)
        if error:
            raise error
        if wheel_file:
            folder = Path(command[command.index("--dest") + 1])
            (folder / wheel.WHEEL).write_bytes(wheel_file.read_bytes())
        return subprocess.CompletedProcess(command, not wheel_file, "", stderr)

    monkeypatch.setattr(subprocess, "run", run)
    return asked


@pytest.mark.parametrize("name", wheel.MEMBERS)
def test_a_wheel_in_the_folder_is_read_as_it_lies_there(name, small_wheel, monkeypatch):
    asked, opened = pip(monkeypatch), []
    monkeypatch.setenv(files.FOLDER, str(small_wheel.parent))
    read = zipfile.ZipFile.read

    def watched(self, member, *rest):
        opened.append(member)
        return read(self, member, *rest)

    monkeypatch.setattr(zipfile.ZipFile, "read", watched)
    data = datasets.load(name)
    assert not asked and opened == [wheel.MEMBERS[name]]
    assert len(data) == 4 and set(data.dtypes) == {np.dtype("float64")}
    assert "other" not in data and data["power_ac"].tolist() == [1, 2, 3, 4]
    assert {"latitude", "longitude", "source", "citation", "licence"} < {*data.attrs}


def test_a_wheel_is_downloaded_once_whole_and_kept(small_wheel, monkeypatch):
    asked = pip(monkeypatch, small_wheel)
    datasets.load("eurac_bolzano")
    datasets.load("nrel_stf")
    kept = small_wheel.parent.parent / "cache"
    assert [path.name for path in kept.iterdir()] == [wheel.WHEEL]
    (command,) = asked
    assert command[:4] == [sys.executable, "-m", "pip", "download"]
    assert {"--no-deps", "--only-binary", wheel.REQUIREMENT} < {*command}


def test_a_cached_wheel_that_is_broken_is_downloaded_anew(small_wheel, monkeypatch):
    kept = small_wheel.parent.parent / "cache" / wheel.WHEEL
    kept.parent.mkdir()
    kept.write_bytes(small_wheel.read_bytes()[:100])
    asked = pip(monkeypatch, small_wheel)
    assert len(datasets.load("nrel_stf")) == 4 and len(asked) == 1
    assert kept.read_bytes() == small_wheel.read_bytes()


def test_another_wheel_of_that_name_is_refused(small_wheel, monkeypatch):
    """In the folder and from pip; nothing of it is kept."""
    other = small_wheel.parent.parent / "other" / wheel.WHEEL
    other.parent.mkdir()
    other.write_bytes(b"another")
    pip(monkeypatch, other)
    with pytest.raises(ValueError, match="that pip got is not the pinned file"):
        datasets.load("nrel_stf")
    assert not any((small_wheel.parent.parent / "cache").iterdir())
    monkeypatch.setenv(files.FOLDER, str(other.parent))
    with pytest.raises(ValueError, match="is not the pinned file"):
        datasets.load("nrel_stf")


@pytest.mark.parametrize(
    "fault, said",
    [
        ({"stderr": "WARNING: Retry\nERROR: No distribution\n"}, "No distribution"),
        ({"stderr": "python: No module named pip"}, "python: No module named pip"),
        ({"error": FileNotFoundError("no python")}, "no python"),
        ({"error": subprocess.TimeoutExpired("pip", 600)}, "not done within 600 s"),
    ],
)
def test_without_pip_the_message_names_the_wheel_and_the_folder(
    small_wheel, monkeypatch, fault, said
):
    pip(monkeypatch, **fault)
    with pytest.raises(OSError, match=rf"\({said}") as refused:
        datasets.load("eurac_bolzano")
    message = str(refused.value)
    assert wheel.WHEEL in message and files.FOLDER in message
    assert "pip download" in message and message.count(". ") == 1
    assert refused.value.__suppress_context__


def test_without_pyarrow_nothing_is_downloaded(small_wheel, monkeypatch):
    asked = pip(monkeypatch, small_wheel)
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(ImportError, match=r"pip install 'pvlib_fem\[parquet\]'"):
        datasets.load("eurac_bolzano")
    assert not asked


def test_eight_years_at_bolzano(bolzano):
    """97.4 % of the rows have all four columns; the clock is the file's own."""
    assert len(bolzano) == 69_857 and bolzano.index.tz is None
    assert (np.diff(bolzano.index.values) == np.timedelta64(1, "h")).all()
    four = bolzano[["poa_global", "temp_air", "wind_speed", "temp_module"]]
    assert four.notna().all(axis=1).mean() == pytest.approx(0.974, abs=5e-4)
    rome = bolzano.index.tz_localize("Europe/Rome", ambiguous=True, nonexistent="NaT")
    skipped = bolzano[rome.isna()]
    assert len(skipped) == 8 and skipped.isna().all(axis=None)
    assert not bolzano["wind_direction"].gt(348).any()


def test_over_temperature_at_bolzano_jumps_by_a_fifth_in_april_2012(bolzano):
    """The largest step between two months, and power has none there."""
    bright = bolzano[bolzano["poa_global"] > 500]
    warmth = (bright["temp_module"] - bright["temp_air"]) / bright["poa_global"]
    months = (warmth * (25 + 6.8 * bright["wind_speed"])).resample("MS").median()
    assert months.diff().abs().idxmax() == pd.Timestamp("2012-04-01")
    before, after = months[:"2012-03-31"], months["2012-04-01":"2013-05-31"]
    assert after.median() / before.median() == pytest.approx(1.19, abs=0.02)
    power = (bright["power_ac"] / bright["poa_global"]).resample("YS").median()
    assert power.iloc[1] / power.iloc[0] == pytest.approx(1.0, abs=0.03)


def test_ten_days_at_bolzano_are_an_hour_late_but_for_power(bolzano):
    """21 to 30 June 2018, by the centre of each day's light and power."""
    june = bolzano["2018-06-11":"2018-07-10"].fillna({"power_ac": 0.0})
    hours = june.index.hour.to_numpy(float)
    light, power = (
        (june[name] * hours).resample("D").sum() / june[name].resample("D").sum()
        for name in ("poa_global", "power_ac")
    )
    late = light - power
    fault = (late.index >= "2018-06-21") & (late.index < "2018-07-01")
    assert late[fault].between(0.75, 1.1).all()
    assert late[~fault].between(-0.2, 0.2).all()


def test_the_pyranometer_at_golden_fades(golden):
    """Against the modelled irradiance, and power per irradiance rises."""
    assert len(golden) == 72_723 and golden.index.tz is None
    bright = golden[golden["poa_global"] > 500]
    ratios = pd.DataFrame(
        {
            "modelled": bright["poa_global"] / bright["poa_modelled"],
            "power": bright["power_ac"] / bright["poa_global"],
        }
    )
    years = ratios.groupby(bright.index.year).median()
    assert years["modelled"][2011] == pytest.approx(0.996, abs=1e-3)
    assert years["modelled"][2017] == pytest.approx(0.881, abs=1e-3)
    assert years["power"][2017] / years["power"][2011] > 1.05


def test_the_made_up_record_is_its_truth_and_the_same_every_time():
    one = datasets.synthetic(2, seed=4, noise=0)
    pd.testing.assert_frame_equal(one, datasets.synthetic(2, seed=4, noise=0))
    assert not one.equals(datasets.synthetic(2, seed=5, noise=0))
    drivers = (one[name] for name in ("poa_global", "temp_air", "wind_speed"))
    want = heat_balance(*drivers, **one.attrs["coefficients"])
    np.testing.assert_array_equal(one["temp_module"], want)


@pytest.mark.parametrize("step", [5.0, 60.0, 900.0])
def test_its_weather_does_not_depend_on_the_step(step):
    """Statistics do not depend on the step: wind 3 m/s, clouds, a warm afternoon."""
    data = datasets.synthetic(20, step, seed=1)
    assert data["wind_speed"].mean() == pytest.approx(3.0, abs=0.6)
    assert (data["wind_speed"] >= 0).all()
    assert data["temp_air"].groupby(data.index.hour).mean().idxmax() in (14, 15, 16)
    noon = data["poa_global"].between_time("11:00", "13:00")
    assert noon.min() < 350 and 850 < noon.max() < 1300
    assert (data["poa_global"].between_time("22:00", "03:00") == 0).all()


def test_its_wind_is_weibull():
    """Shape 2 and mean 3 m/s: a tenth is above 1.712 means (Rayleigh)."""
    wind = datasets.synthetic(1500, 900, seed=1, noise=0)["wind_speed"]
    assert wind.mean() == pytest.approx(3.0, abs=0.1)
    assert wind.quantile(0.9) == pytest.approx(3.0 * 1.712, rel=0.04)


@pytest.mark.parametrize("dynamics", ["ewm", "balance"])
def test_the_truth_of_a_synthetic_record_is_whole(dynamics):
    """Also where coefficients of the steady model alone are given."""
    data = datasets.synthetic(3, 600, dynamics=dynamics, noise=0, u0=20.0, u1=5.0)
    usual = (data[name] for name in ("poa_global", "temp_air", "wind_speed"))
    function = {"ewm": fem_temperature, "balance": heat_balance}[dynamics]
    again = function(*usual, model="faiman", **data.attrs["coefficients"])
    np.testing.assert_array_equal(again, data["temp_module"])
    memory = {"ewm": {"tau": 378.0}, "balance": {"capacity": 15e3}}[dynamics]
    assert data.attrs["coefficients"] == {"u0": 20.0, "u1": 5.0, "bias": 0.0} | memory


def test_synthetic_air_is_coldest_before_sunrise_from_any_hour_on():
    for start in ("2023-06-01", "2023-06-01 12:00"):
        air = datasets.synthetic(60, 3600, start=start)["temp_air"]
        assert 1 <= air.groupby(air.index.hour).mean().idxmin() <= 5


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (dict(days=0), "days = 0 must be a positive number"),
        (dict(days=-1), "days = -1 must be a positive number"),
        (dict(days=1, step=0), "step = 0 must be a positive number"),
        (dict(days=1, step=pd.Timedelta("1min")), "step = 0 days .* positive number"),
        (dict(days=0.01, step=3600), "days = 0.01 are shorter than a step of 3600 s"),
        (dict(days=1, dynamics="steady"), "unknown dynamics 'steady'; they are ewm"),
    ],
)
def test_a_synthetic_record_has_a_length_and_a_memory(options, message):
    with pytest.raises(ValueError, match=message):
        datasets.synthetic(**options)


@pytest.mark.parametrize("dynamics", ["ewm", "balance"])
def test_each_dynamics_has_coefficients_by_default(dynamics):
    data = datasets.synthetic(days=1, step=900, noise=0, dynamics=dynamics)
    memory = {"ewm": "tau", "balance": "capacity"}[dynamics]
    assert memory in data.attrs["coefficients"]
    function = heat_balance if dynamics == "balance" else fem_temperature
    drivers = (data[n] for n in ("poa_global", "temp_air", "wind_speed"))
    again = function(*drivers, model="faiman", **data.attrs["coefficients"])
    pd.testing.assert_series_equal(data["temp_module"], again, check_names=False)
