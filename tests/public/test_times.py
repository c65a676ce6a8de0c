"""What was corrected of a record's clocks is done again to what is predicted."""

import numpy as np
import pandas as pd
import pytest
from pvlib.location import Location

import pvlib_fem as fem
from pvlib_fem import simulator

ZONE = "Europe/Berlin"


@pytest.fixture(scope="module")
def on_the_wall():
    """A year of hours by the clock on the wall, whose module's logger is 2 h late."""
    step = 1800
    data = simulator.record(effects=simulator.OUTDOORS, days=365, step=step, seed=4)
    data["temp_module"] = data["temp_module"].shift(2 * 3600 // step)
    site, data.attrs = data.attrs["site"], {}
    index = data.index if data.index.tz is not None else data.index.tz_localize("UTC")
    local = index.tz_convert(ZONE) if str(index.tz) != ZONE else index
    data.index = local.tz_localize(None)
    data = data[~data.index.duplicated()]  # the hour that comes twice is there once
    place = Location(site["latitude"], site["longitude"], ZONE)
    loop = fem.close_loop(
        data, "faiman", place, site["surface_tilt"], site["surface_azimuth"]
    )
    return data[["poa_global", *loop_columns(loop)]], loop


def loop_columns(loop):
    return ["temp_air", "wind_speed", "temp_module", *measured(loop)]


def measured(loop):
    sun = {"solar_zenith", "solar_azimuth", "surface_tilt", "surface_azimuth"}
    return [name for name in loop.fit.thermal_model.drivers if name not in sun]


def test_the_record_itself_leaves_what_the_table_says(on_the_wall):
    data, loop = on_the_wall
    assert [one.applied for one in loop.corrections] == [True, True]
    table = loop.table["rmse_test"][loop.last]
    assert error(loop.residual(data), loop) == pytest.approx(table, rel=0.02)
    # as it is, the sun stands an hour elsewhere in summer, and the module is late
    assert error(loop.residual(data, correct_times=False), loop) > 1.5 * table


def error(residual, loop):
    """Root mean square on the test rows of a file, by its own times."""
    test = (loop.weeks == "test").to_numpy()
    known = loop.timed(residual.to_frame())[1]
    return float(np.sqrt(np.nanmean(residual.to_numpy()[known][test] ** 2)))


def test_a_loop_of_a_file_corrects_the_same_times(on_the_wall, tmp_path):
    data, loop = on_the_wall
    loop.to_json(tmp_path / "loop.json")
    again = type(loop).from_json(tmp_path / "loop.json")
    for one, other in (
        (loop.predict(data), again.predict(data)),
        (loop.residual(data), again.residual(data)),
        (loop.contributions(data), again.contributions(data)),
    ):
        assert one.index.equals(data.index) and one.equals(other)


def test_another_record_is_taken_by_its_own_times(on_the_wall):
    """Ten years later no time is corrected."""
    data, loop = on_the_wall
    later = data.set_axis(data.index + pd.Timedelta(days=3650))
    assert loop.predict(later).equals(loop.predict(later, correct_times=False))
    assert loop.predict(later).notna().all()


def test_a_time_that_is_not_known_has_no_temperature(on_the_wall):
    data, loop = on_the_wall
    lost = ~loop.timed(data)[1]
    assert lost.any() and loop.predict(data)[lost].isna().all()


def test_a_corrected_record_has_correct_times(on_the_wall):
    """What is corrected by hand leaves the residual of the corrected record."""
    data, loop = on_the_wall
    corrected = loop.corrected(data)
    known = loop.timed(data)[1]
    assert len(corrected.data) == known.sum() < len(data)
    assert corrected.data.index.equals(loop.timed(data)[0].index)
    original = corrected.data["time_original"]
    assert pd.DatetimeIndex(original).equals(data.index[known])
    assert {*corrected.actions["column"]} == {"all", "temp_module"}
    left = loop.residual(corrected.data, correct_times=False)
    assert np.allclose(left, loop.residual(data)[known], equal_nan=True)
    clocks = corrected.actions[corrected.actions["unit"] == "min"]
    sizes = {name: [*part["size"]] for name, part in clocks.groupby("column")}
    assert sizes["all"] == [-60.0]  # summer time, to standard time
    assert sizes["temp_module"] == [pytest.approx(-120.0, abs=30.0)]


def test_a_part_beside_a_change_has_no_time_to_correct(on_the_wall):
    data, loop = on_the_wall
    lost = data[~loop.timed(data)[1]]
    with pytest.raises(ValueError, match=r"no row of data, .*, has a sure time"):
        loop.corrected(lost.iloc[:1])


def test_data_without_times_are_refused_where_a_clock_was_corrected(on_the_wall):
    data, loop = on_the_wall
    with pytest.raises(ValueError, match="data has no DatetimeIndex but a RangeIndex"):
        loop.predict(data.reset_index(drop=True))
