"""What was not measured is found in files as in memory: the same rows and words."""

import numpy as np
import pytest
from hypothesis import Phase, given, settings, strategies as st

import pvlib_fem as fem
from pvlib_fem._record.column_names import COLUMNS
from pvlib_fem._record.inputs import as_record
from pvlib_fem.quality._parquet_screen import screened_blocks
from pvlib_fem.quality._screen import screened
from pvlib_fem.quality._unit_checks import oddities

pytest.importorskip("pyarrow")
DRIVERS = ("relative_humidity", "fan")


@pytest.fixture(scope="module")
def record():
    """Four days with two further columns, one of a kind that nobody knows."""
    data = fem.datasets.synthetic(days=4, step=120)[list(COLUMNS)].round(2)
    wave = np.sin(np.arange(len(data)) / 7.0)
    noise = np.random.default_rng(0).normal(size=len(data))
    return data.assign(relative_humidity=60 + 9 * wave, fan=40 + 5 * wave + noise)


def spoiled(data, faults):
    """A record with faults: of a kind, in a column, from a row on, for some rows."""
    data = data.copy()
    for kind, column, at, rows in faults:
        place = slice(at, at + rows)
        column = data.columns[column]
        values = data[column].to_numpy(copy=True)
        if kind == "nan":
            values[place] = np.nan
        elif kind == "still":
            values[place] = values[at]
        else:
            values[place] = kind
        data[column] = values
    return data


def written(data, folder):
    """The record in three files of small row groups."""
    for i, part in enumerate(np.array_split(np.arange(len(data)), 3)):
        data.iloc[part].to_parquet(folder / f"{i}.parquet", row_group_size=251)
    return fem.open_parquet(folder)


def in_memory(data):
    record = as_record(*(data[n] for n in COLUMNS), **{n: data[n] for n in DRIVERS})
    clean, faults = screened(record)
    return clean, (*faults.notes, *oddities(clean.inputs)), clean.impossible


def in_blocks(source):
    found = screened_blocks(source, DRIVERS)
    names = found.record.names
    blocks = list(found.record.blocks())
    columns = {n: np.concatenate([block[n] for block in blocks]) for n in names}
    return columns, found


def both(data, folder):
    """The two screenings, or their errors, which have to be the same."""
    source = written(data, folder)
    try:
        clean, notes, impossible = in_memory(data)
    except ValueError as error:
        with pytest.raises(ValueError) as other:
            in_blocks(source)
        assert str(other.value) == str(error)
        return None
    columns, found = in_blocks(source)
    assert columns
    for name, values in columns.items():
        np.testing.assert_array_equal(values, clean[name], err_msg=name)
    assert found.notes == notes
    assert found.impossible == impossible
    assert found.clipped == clean.clipped
    assert found.missing == clean.missing
    return found


FAULTS = st.tuples(
    st.sampled_from(
        [-999.0, 9999.0, -5.0, -40.0, 65.0, 150.0, 2500.0, 1e5, 0.0, "nan", "still"]
    ),
    st.integers(0, 5),
    st.integers(0, 2700),
    st.sampled_from([1, 2, 3, 7, 40, 400]),
)


@settings(max_examples=12, deadline=None, phases=[Phase.generate])
@given(faults=st.lists(FAULTS, max_size=5))
def test_any_faults_are_the_same_in_files(record, tmp_path_factory, faults):
    both(spoiled(record, faults), tmp_path_factory.mktemp("record"))


NOON = 350
CASES = {
    "fill value": [(-999.0, 0, 100, 9), (9999.0, 5, 40, 3), (-6999.0, 4, 9, 2)],
    "negative by day": [(-5.0, 0, NOON, 20), (-3.0, 0, 0, 40)],
    "out of range": [(2500.0, 0, NOON, 3), (-70.0, 3, 900, 2), (120.0, 4, 1, 1)],
    "light by night": [(400.0, 0, 10, 9), (30.0, 0, 1450, 2)],
    "spike": [(90.0, 3, 249, 3), (-25.0, 1, 251, 1), (4e4, 5, 777, 1)],
    "lone zero": [
        (0.0, 3, 250, 2),
        (0.0, 0, NOON, 1),
        (0.0, 1, 501, 3),
        (0.0, 0, 0, 1),
    ],
    "lone zero, often": [(0.0, i % 4, 97 * i + 55, 1 + i % 3) for i in range(28)],
    "all zero": [(0.0, i, first, 40) for i in range(4) for first in (230, 700)],
    "stuck": [("still", 3, NOON - 100, 300), ("still", 2, 1000, 260)],
    "stuck, one after the other": [("still", 3, 200, 900), ("still", 0, 220, 800)],
    "fill value, far": [(1e4, 5, 30, 5), ("nan", 1, 500, 700)],
}


@pytest.mark.parametrize("name", CASES)
def test_each_kind_is_found_across_blocks(record, tmp_path, name):
    found = both(spoiled(record, CASES[name]), tmp_path)
    assert name.split(",")[0] in {one.kind for one in found.fault_rows}


@pytest.mark.parametrize("column", ["poa_global", "temp_air", "temp_module"])
def test_the_end_of_a_range_is_found_across_blocks(tmp_path, column):
    data = fem.datasets.synthetic(days=20, step=600)[list(COLUMNS)].round(3)
    data = data.assign(relative_humidity=60 + 9 * np.sin(np.arange(len(data))), fan=40)
    data[column] = data[column].clip(upper=data[column].quantile(0.93))
    found = both(spoiled(data, [(-999.0, 4, 100, 9), ("still", 2, 700, 60)]), tmp_path)
    assert (column, "end of range") in {
        (one.column, one.kind) for one in found.fault_rows
    }


@pytest.mark.parametrize(
    ("first", "last"), [("06-05", "06-15"), ("06-01", "06-04"), ("06-05", "06-08")]
)
@pytest.mark.parametrize("gone", [False, True])
def test_an_anemometer_that_reads_nothing_by_day_alone(tmp_path, first, last, gone):
    """Its nights are missing values, which take no time, or no rows."""
    data = fem.datasets.synthetic(days=20, step=600)[list(COLUMNS)].round(2)
    data = data.assign(relative_humidity=60 + 9 * np.sin(np.arange(len(data))), fan=40)
    day = (data.index.hour >= 6) & (data.index.hour < 18)
    year = data.index[0].year
    data.loc[f"{year}-{first}" : f"{year}-{last}", "wind_speed"] = 0.0
    data["wind_speed"] = data["wind_speed"].where(day)
    found = both(data[day] if gone else data, tmp_path)
    kinds = {one.kind for one in found.fault_rows if one.column == "wind_speed"}
    assert ("stuck" in kinds) == (gone or last == "06-15")


@pytest.mark.parametrize(
    "faults",
    [
        [("still", 3, 0, 2880)],
        [(-999.0, 1, 0, 2880)],
        [("nan", 2, 0, 2880)],
        [(150.0, 3, 0, 900)],
        [(0.0, 0, 0, 2880)],
    ],
)
def test_the_same_records_are_refused(record, tmp_path, faults):
    assert both(spoiled(record, faults), tmp_path) is None


def test_units_are_refused_in_the_same_words(record, tmp_path):
    for data in (record.assign(temp_air=record["temp_air"] + 273.15),):
        assert both(data, tmp_path) is None
