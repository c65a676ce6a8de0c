"""Records in Parquet files: the same rows as a DataFrame, and one clear error."""

import re

import numpy as np
import pandas as pd
import pytest

import pvlib_fem as fem
from pvlib_fem._record.column_names import COLUMNS

pytest.importorskip("pyarrow")
FOUR = list(COLUMNS)
ZONE = "America/New_York"


@pytest.fixture(scope="module")
def data():
    return fem.datasets.synthetic(days=4, step=60)


def write(folder, parts, **how):
    """Files of some frames, whose names are not in the order of their times."""
    folder.mkdir(exist_ok=True)
    for i, part in enumerate(parts):
        part.to_parquet(folder / f"{9 - i}.parquet", **how)
    return folder


def by_day(data):
    return [part for _, part in data.groupby(data.index.date)]


def read_back(record, **how):
    blocks = list(record.blocks(**how))
    parts = [block.inputs.frame() for block in blocks]
    return pd.concat(parts), blocks


def test_blocks_are_the_rows_in_the_order_of_time(data, tmp_path):
    """Whatever the names of the files, their row groups and the size of a block."""
    folder = write(tmp_path / "days", by_day(data), row_group_size=500)
    record = fem.open_parquet(folder)
    found, blocks = read_back(record, rows=333)
    pd.testing.assert_frame_equal(
        found, data[FOUR], check_freq=False, check_names=False, check_index_type=False
    )
    assert len(record) == len(data)
    assert [block.start for block in blocks] == [
        *np.cumsum([0, *map(len, blocks)])[:-1].tolist()
    ]
    steps = np.concatenate([b.inputs.steps * b.inputs.unit for b in blocks])
    assert steps[0] == 0.0
    assert steps[1:] == pytest.approx(60.0)


@pytest.mark.parametrize("form", ["glob", "file", "dataset"])
def test_a_record_is_named_in_several_ways(data, tmp_path, form):
    dataset = pytest.importorskip("pyarrow.dataset")
    folder = write(tmp_path / "days", by_day(data))
    data.to_parquet(tmp_path / "all.parquet")
    named = {
        "glob": str(folder / "*.parquet"),
        "file": tmp_path / "all.parquet",
        "dataset": dataset.dataset(folder, format="parquet"),
    }
    assert read_back(fem.open_parquet(named[form]))[0].equals(
        read_back(fem.open_parquet(folder))[0]
    )


def test_hours_that_lack_are_one_long_step(data, tmp_path):
    gap = data.drop(data.index[2000:2600])
    record = fem.open_parquet(write(tmp_path, by_day(gap)))
    found, blocks = read_back(record)
    assert found.index.equals(gap.index)
    steps = np.concatenate([b.inputs.steps * b.inputs.unit for b in blocks])
    assert steps.max() == pytest.approx(601 * 60.0)


def test_single_precision_units_and_zones_are_joined_where_that_is_plain(
    data, tmp_path
):
    one, other = data.iloc[:2000].astype("float32"), data.iloc[2000:]
    one = one.set_axis(one.index.as_unit("ms"))
    other = other.tz_convert("UTC")
    found, _ = read_back(fem.open_parquet(write(tmp_path, [one, other])))
    assert (found.index == data.index).all()
    assert str(found.index.tz) == str(data.index.tz)
    assert {str(kind) for kind in found.dtypes} == {"float64"}
    expected = pd.concat([one[FOUR].astype(float), data[FOUR].iloc[2000:]])
    assert np.array_equal(found, expected)


def test_names_and_zone_are_as_given(data, tmp_path):
    plain = data.tz_localize(None).rename(columns={"poa_global": "Irr"})
    folder = write(tmp_path / "plain", by_day(plain))
    record = fem.open_parquet(folder, {"poa_global": "Irr"}, tz="Etc/GMT+7")
    assert read_back(record)[0].equals(
        read_back(fem.open_parquet(write(tmp_path / "own", by_day(data))))[0]
    )
    with pytest.raises(ValueError, match=r"poa_global.*columns=.*poa_global"):
        list(fem.open_parquet(folder).blocks())


def test_missing_values_are_nan_in_any_type(data, tmp_path):
    whole = data[FOUR].round().astype("Int32")
    whole.iloc[7, 1] = pd.NA
    record = fem.open_parquet(write(tmp_path, [whole]))
    found, _ = read_back(record)
    assert np.argwhere(np.isnan(found.to_numpy())).tolist() == [[7, 1]]


def overlapping(data):
    return [data.iloc[:2000], data.iloc[1999:]]


def other_columns(data):
    return [data.iloc[:2000], data.iloc[2000:].drop(columns="wind_speed")]


def other_types(data):
    return [data.iloc[:2000], data.iloc[2000:].assign(wind_speed="calm")]


def other_times(data):
    return [data.iloc[:2000], data.iloc[2000:].tz_localize(None)]


def disordered(data):
    order = [*range(1000), *range(1500, 1999), *range(1000, 1500), 1999]
    return [data.iloc[2000:], data.iloc[order]]


def no_times(data):
    return [data.iloc[:2000], data.iloc[2000:].reset_index(drop=True)]


@pytest.mark.parametrize(
    ("spoil", "words"),
    [
        (overlapping, "begins at 2023-06-02 16:19.*goes on until 2023-06-02 16:19"),
        (other_columns, "has no column 'wind_speed'"),
        (other_types, "has (large_)?strings in 'wind_speed'"),
        (other_times, "have zone Etc/GMT.7, those of .* None"),
        (disordered, "is not sorted.*after"),
        (no_times, "has no column of timestamps"),
    ],
)
def test_files_that_do_not_fit_are_named(data, tmp_path, spoil, words):
    folder = write(tmp_path, spoil(data))
    with pytest.raises(ValueError, match=words) as error:
        list(fem.open_parquet(folder).blocks())
    assert "8.parquet" in str(error.value) or spoil is other_times


def test_row_groups_out_of_order_in_one_file_are_refused_or_sorted(data, tmp_path):
    halves = pd.concat([data.iloc[3000:], data.iloc[:3000]])
    mixed = pd.concat([data.iloc[::2], data.iloc[1::2]])
    with pytest.raises(ValueError, match="is not sorted"):
        fem.open_parquet(write(tmp_path / "a", [halves], row_group_size=3000))
    with pytest.raises(ValueError, match=r"9\.parquet is not sorted"):
        fem.open_parquet(write(tmp_path / "b", [mixed], row_group_size=2880))
    record = fem.open_parquet(write(tmp_path / "c", [halves], row_group_size=20))
    assert read_back(record)[0].index.equals(data.index)


def test_what_is_no_data_set_is_said(data, tmp_path):
    with pytest.raises(ValueError, match="no Parquet file is in"):
        fem.open_parquet(tmp_path / "nowhere")
    (tmp_path / "x.parquet").write_text("no table")
    with pytest.raises(ValueError, match=r"x\.parquet is no Parquet file"):
        fem.open_parquet(tmp_path)
    header = data.rename(columns={"wind_speed": "Wind (mph)"})
    folder = write(tmp_path / "miles", [header])
    with pytest.raises(ValueError, match=r"'Wind \(mph\)' names mph"):
        fem.open_parquet(folder, {"wind_speed": "Wind (mph)"})


def clocks():
    """Blocks of an hourly year in a file, and their remaining times."""
    utc = pd.date_range("2023-01-01", periods=8760, freq="1h", tz="UTC")
    shown = utc.tz_convert(ZONE).tz_localize(None)
    once = ~shown.duplicated()
    doubled = shown.duplicated(keep=False)
    written = utc.tz_localize(None)
    there = written.tz_localize(ZONE, ambiguous="NaT", nonexistent="NaT")
    return {
        "the zone's clock": (shown, utc),
        "each hour once": (shown[once], utc[~doubled]),
        "standard time": (written, there[there.notna()].tz_convert("UTC")),
    }


@pytest.mark.parametrize("rows", [24, 700, 100_000])  # of a row group
@pytest.mark.parametrize("clock", clocks())
def test_rows_that_a_zone_has_no_time_for_are_left_out_and_counted(
    clock, rows, tmp_path
):
    """As of one file in memory, wherever row groups and blocks end."""
    shown, utc = clocks()[clock]
    data = pd.DataFrame({name: np.arange(len(shown)) % 97.0 for name in FOUR}, shown)
    data = data.rename_axis("time").astype(float)
    folder = write(tmp_path / "year", [data[:4000], data[4000:]], row_group_size=rows)
    record = fem.open_parquet(folder, tz=ZONE)
    found, _ = read_back(record, rows=333)
    assert (found.index == utc).all() and len(record) == len(utc)
    assert record.ends == (utc[0].tz_convert(ZONE), utc[-1].tz_convert(ZONE))
    data.to_parquet(tmp_path / "whole.parquet")
    whole = fem.read_file(tmp_path / "whole.parquet", tz=ZONE)
    np.testing.assert_array_equal(found[FOUR], whole[FOUR])
    counts = re.findall(r"left out: (\d+)", " ".join(record.notes))
    assert sum(map(int, counts)) == len(data) - len(utc)
    values = [columns["temp_air"] for _, columns in record.values(rows=500)]
    np.testing.assert_array_equal(np.concatenate(values), found["temp_air"])


def test_rows_without_a_time_are_left_out_by_an_option(data, tmp_path):
    parts = [part.tz_localize(None).reset_index(names="time") for part in by_day(data)]
    for part in parts[1:3]:
        part.loc[[0, 7, 800], "time"] = pd.NaT
    folder = write(tmp_path / "days", parts, row_group_size=500)
    with pytest.raises(ValueError, match="have no time; give drop_untimed=True"):
        fem.open_parquet(folder)
    record = fem.open_parquet(folder, drop_untimed=True)
    found, _ = read_back(record, rows=333)
    kept = pd.concat(parts).dropna().set_index("time")
    assert (found.index == kept.index).all() and len(record) == len(kept)
    np.testing.assert_array_equal(found, kept[FOUR])
    assert record.notes[0].startswith("rows without a time, left out: 6, the first in")
    fit = fem.fit_fem(record)
    assert record.notes[0] in fit.notes


@pytest.mark.parametrize("count", [1, 3])
def test_files_without_rows_are_counted(tmp_path, count):
    nothing = fem.datasets.synthetic(1, 600).iloc[:0]
    for number in range(count):
        nothing.to_parquet(tmp_path / f"{number}.parquet")
    more = f" and {count - 1} other files" if count > 1 else ""
    with pytest.raises(ValueError, match=rf"no row is in .*0.parquet{more}; give"):
        fem.open_parquet(tmp_path)
