"""Records: the measured ones as pinned, the made-up one as planted."""

import numpy as np
import pandas as pd
import pytest

from pvlib_fem import datasets, heat_balance


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
    monkeypatch.setenv(datasets.FOLDER, str(tmp_path))
    monkeypatch.setattr(
        datasets.pooch, "retrieve", lambda url, known_hash, **kw: asked.append(url)
    )
    datasets.fetch("sandia_week_1min.csv")
    assert asked == [datasets.FILES["sandia_week_1min.csv"][0]]


def test_without_a_network_the_message_says_where_a_file_can_be_put(monkeypatch):
    def offline(*arguments, **options):
        raise ConnectionError("Max retries exceeded with url: /pvlib/…")

    monkeypatch.delenv(datasets.FOLDER, raising=False)
    monkeypatch.setattr(datasets.pooch, "retrieve", offline)
    with pytest.raises(OSError, match="environment variable PVLIB_FEM_DATA") as refused:
        datasets.load("sandia_week")
    assert datasets.FILES["sandia_week_1min.csv"][0] in str(refused.value)
    assert refused.value.__cause__ is None and refused.value.__suppress_context__


def test_another_file_of_that_name_is_refused(tmp_path, monkeypatch):
    (tmp_path / "sandia_week_1min.csv").write_text("time,poa_global\n")
    monkeypatch.setenv(datasets.FOLDER, str(tmp_path))
    with pytest.raises(ValueError, match="is not the pinned file"):
        datasets.load("sandia_week")


def test_an_unknown_record_is_named():
    with pytest.raises(ValueError, match="unknown record 'week'; there are sandia_w"):
        datasets.load("week")


def test_the_made_up_record_is_its_truth_and_the_same_every_time():
    one = datasets.synthetic(2, seed=4, noise=0)
    pd.testing.assert_frame_equal(one, datasets.synthetic(2, seed=4, noise=0))
    assert not one.equals(datasets.synthetic(2, seed=5, noise=0))
    drivers = (one[name] for name in ("poa_global", "temp_air", "wind_speed"))
    want = heat_balance(*drivers, **one.attrs["coefficients"])
    np.testing.assert_array_equal(one["temp_module"], want)


@pytest.mark.parametrize("step", [5.0, 60.0, 900.0])
def test_its_weather_does_not_depend_on_the_step(step):
    """The same statistics at every step: wind 3 m/s, clouds, a warm afternoon."""
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
