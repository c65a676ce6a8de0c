"""Dirty files of plants: each ends in an answer, or in the option that gives one."""

import re
import shlex
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pandas as pd
import pytest
from conftest import call, proposed
from pvlib.location import Location

import pvlib_fem as fem
from pvlib_fem import simulator
from pvlib_fem._record.column_names import COLUMNS
from pvlib_fem._record.names import usual_name
from pvlib_fem.quality._limits import Limits
from pvlib_fem.quality._noon import solar_noon_shift
from pvlib_fem.reasons import Reason


def tau_of(result):
    assert result.exit_code == 0, result.output
    return float(re.search(r"^tau +(\S+)", result.output, re.MULTILINE)[1])


def in_fahrenheit(celsius):
    return 1.8 * celsius + 32.0


def in_celsius(fahrenheit):
    return (fahrenheit - 32.0) / 1.8


@pytest.fixture(scope="module")
def plant():
    """Forty days at 10 min without a zone, in the package's names and units."""
    data = simulator.record(days=40, step=600, start="2023-05-01", seed=5)
    return data.tz_localize(None)


@pytest.fixture
def record(plant):
    """The four columns of it."""
    return plant[list(COLUMNS)].round(3)


def spoiled(column, share, change, seed):
    """A column with some of its rows, never two together, changed."""
    rows = 1 + 3 * np.random.default_rng(seed).choice(
        len(column) // 3 - 1, int(share * len(column)), replace=False
    )
    column = column.copy()
    column.iloc[rows] = change(column.iloc[rows])
    return column


@pytest.mark.parametrize("share", [0.005, 0.02, 0.05])
def test_a_unit_is_judged_without_codes_and_spikes(share, record, tmp_path):
    """A file in °F is proposed in °F once, and then it is one of °C."""
    path = tmp_path / "plant.csv"
    expected = fem.fit_fem(*(record[name] for name in COLUMNS))
    for seed, name in enumerate(("temp_air", "temp_module")):
        fahrenheit = in_fahrenheit(record[name]).round(2)
        codes = spoiled(fahrenheit, share, lambda x: 999.9, seed)
        record[name] = spoiled(codes, share, lambda x: x + 110.0, 10 + seed)
    record.to_csv(path, index_label="time")
    first = call("fit", path)
    assert first.exit_code == 1
    assert "temp_air and temp_module look to be in °F" in first.output
    second = call(*proposed(first))
    assert tau_of(second) == pytest.approx(expected.coefficients["tau"], rel=0.2)
    rows = (record == 999.9).sum()
    for name in ("temp_air", "temp_module"):
        words = f"{name} holds the fill value 999.9 in {rows[name]:,} rows"
        assert words in second.output


@pytest.mark.parametrize("name", ["temp_air", "temp_module"])
def test_a_difference_that_cannot_be_names_both_columns(name, record, tmp_path):
    """Converted twice, a temperature is as odd as the other would be in °F."""
    path = tmp_path / "plant.csv"
    other = {"temp_air": "temp_module", "temp_module": "temp_air"}[name]
    data = record.assign(**{name: in_celsius(record[name])})
    data.to_csv(path, index_label="time")
    refused = call("fit", path)
    assert refused.exit_code == 1
    said = refused.output
    assert said.startswith("Error: temp_air and temp_module do not go together")
    assert f"{name} may have been converted from °F twice" in said
    assert f"{other} may be in °F" in said and f"--unit {other}=°F" in said
    low, high = (f"{end:.0f}" for end in np.nanpercentile(data[name], [1, 99]))
    assert f"{name} is {low} to {high}" in said
    # what the message says of either column makes a record of it
    undone = data.assign(**{name: in_fahrenheit(data[name])})
    undone.to_csv(path, index_label="time")
    assert call("fit", path).exit_code == 0


def test_a_command_that_was_run_is_not_proposed_again(record, tmp_path):
    """Fahrenheit once more, and the message does not turn in a circle."""
    path = tmp_path / "plant.csv"
    hot = record.assign(
        temp_air=in_fahrenheit(in_fahrenheit(record.temp_air)),
        temp_module=in_fahrenheit(in_fahrenheit(record.temp_module)),
    )
    hot.to_csv(path, index_label="time")
    told = ["fit", path, "--unit", "temp_air=°F", "--unit", "temp_module=°F"]
    refused = call(*told)
    assert refused.exit_code == 1
    assert "still look to be in °F after the conversion" in refused.output
    assert "pvlib-fem fit" not in refused.output


def keeping(index, zone):
    """What a clock of a zone shows at instants in UTC."""
    return index.tz_localize("UTC").tz_convert(zone).tz_localize(None)


CLOCKS = {
    # what the file keeps of a year by the hour, and how many rows have no sure time
    "the zone's clock": (lambda d: d.set_axis(keeping(d.index, "America/New_York")), 0),
    "the same with its newest row first": (
        lambda d: d.set_axis(keeping(d.index, "America/New_York"))[::-1],
        0,
    ),
    "each hour once": (
        lambda d: (
            d.set_axis(keeping(d.index, "America/New_York")).groupby(level=0).first()
        ),
        1,
    ),
    "standard time": (lambda d: d, 2),
}


@pytest.mark.parametrize("clock", CLOCKS)
def test_a_zone_with_summer_time_opens_files_of_hours(clock, tmp_path):
    """Rows that have no time in the zone are counted, and all others kept."""
    changed, lost = CLOCKS[clock]
    whole = simulator.record(days=365, step=3600, start="2022-01-01", seed=4)
    whole = whole.tz_localize(None)[list(COLUMNS)]
    written = changed(whole)
    path = tmp_path / "plant.csv"
    written.to_csv(path, index_label="time")
    result = call("fit", path, "--tz", "America/New_York", "--sort")
    assert result.exit_code == 0, result.output
    assert f"\n{len(written) - lost:,} rows" in "\n" + result.output
    counts = re.findall(r"left out: (\d+), the first is (\S+ \S+)", result.output)
    assert sum(int(count) for count, _ in counts) == lost
    data = fem.read_file(path, tz="America/New_York", sort=True)
    assert len(data) == len(written) - lost
    assert data.index.tz_convert(None).is_monotonic_increasing
    if clock == "standard time":
        assert "keeps standard time (Etc/GMT+5)" in result.output
        assert counts[0][1].startswith("2022-03-13 02:00:00")
    else:  # the instants are those that were measured
        then = whole["temp_module"][data.index.tz_convert(None)]
        assert data["temp_module"].to_numpy() == pytest.approx(then.to_numpy())


EMPTY = {
    "nothing": ("", []),
    "a word": ("n/a", []),
    "the header again": ("time", list(COLUMNS)),
}


@pytest.mark.parametrize("cell", EMPTY)
def test_rows_without_a_time_are_dropped_by_an_option(cell, record, tmp_path):
    """The message names the option, and its command counts the rows."""
    time, others = EMPTY[cell]
    lines = record.to_csv(index_label="time").splitlines()
    for row in (500, 501, 3000):
        cells = lines[row + 1].split(",")
        lines[row + 1] = ",".join([time, *(others or cells[1:])])
    path = tmp_path / "plant.csv"
    path.write_text("\n".join(lines) + "\n")
    refused = call("fit", path)
    assert refused.exit_code == 1
    assert "'time' holds no time in row 500, and in 2 more rows" in refused.output
    assert "give --drop-untimed" in refused.output
    words = proposed(refused)
    assert "--drop-untimed" in words and "--missing" not in words
    result = call(*words)
    told = "rows without a time, left out: 3, the first is row 500"
    assert f"note: plant.csv: {told}" in result.output
    kept = record.drop(record.index[[500, 501, 3000]])
    expected = fem.fit_fem(*(kept[name] for name in COLUMNS))
    assert tau_of(result) == pytest.approx(expected.coefficients["tau"], rel=1e-3)
    assert f"{len(kept):,} rows" in result.output


def test_times_of_parquet_may_lack_too(record, tmp_path):
    path = tmp_path / "plant.parquet"
    times = record.index.to_series().reset_index(drop=True)
    times[[7, 900]] = pd.NaT
    record.set_axis(pd.DatetimeIndex(times, name="time")).to_parquet(path)
    refused = call("fit", path)
    assert "holds no time in row 7, and in 1 more row:" in refused.output
    result = call(*proposed(refused))
    assert result.exit_code == 0 and f"{len(record) - 2:,} rows" in result.output


def test_labels_of_several_levels_are_joined(plant, tmp_path):
    names = {name: ("met", name) for name in plant} | {"temp_module": ("array", "Tmod")}
    data = plant.set_axis(pd.MultiIndex.from_tuples(names[n] for n in plant), axis=1)
    data.rename_axis("time").to_parquet(path := tmp_path / "plant.parquet")
    refused = call("fit", path)
    assert refused.exit_code == 1 and "array_Tmod" in refused.output
    words = proposed(refused)
    assert {"temp_module=array_Tmod", "poa_global=met_poa_global"} <= {*words}
    assert "relative_humidity=met_relative_humidity" in words
    assert call(*words).exit_code == 0


def of_two_lines(data, path):
    """A group over each of its columns, as pandas writes it."""
    data.rename_axis("time").to_csv(path)


def of_merged_cells(data, path):
    """A group over its first column alone, as a spreadsheet writes it, and units."""
    groups = [*data.columns.get_level_values(0)]
    first = [a if a != b else "" for a, b in zip(groups, ["", *groups])]
    rows = [first, data.columns.get_level_values(1), ["W/m²", "°C", "m/s", "°C"]]
    header = [",".join([word, *row]) for word, row in zip(["", "time", ""], rows)]
    path.write_text("\n".join(header) + "\n" + data.to_csv(header=False), "utf-8")


def of_a_workbook(data, path):
    data.rename_axis("time").to_excel(path.with_suffix(".xlsx"))


@pytest.mark.parametrize("form", [of_two_lines, of_merged_cells, of_a_workbook])
def test_a_header_of_several_lines_is_joined_where_one_is_not_enough(
    form, record, tmp_path
):
    """Two temperatures of one name: the line above says of what."""
    labels = ("Weather station", "POA"), ("Weather station", "Temp")
    labels += ("Weather station", "Wind"), ("Array 1", "Temp")
    data = record.set_axis(pd.MultiIndex.from_tuples(labels), axis=1)
    form(data, tmp_path / "plant.csv")
    (path,) = tmp_path.iterdir()
    words = proposed(call("fit", path))
    assert words[words.index("--header-rows") + 1] == "2"
    assert {f"{n}={a}_{b}" for n, (a, b) in zip(COLUMNS, labels)} <= {*words}
    expected = fem.fit_fem(record)
    result = call(*words)
    assert tau_of(result) == pytest.approx(expected.coefficients["tau"], rel=1e-3)
    if path.suffix == ".csv":
        read = fem.read_file(path, header_rows=2, drop_untimed=True)
        assert [*read.columns] == ["_".join(label) for label in labels]


def test_a_line_of_groups_is_left_out_where_names_are_enough(record, tmp_path):
    lines = ",Weather,,,Array\n" + record.to_csv(index_label="Timestamp")
    (path := tmp_path / "plant.csv").write_text(lines)
    words = proposed(call("fit", path))
    assert words[1:] == [str(path), "--skip-rows", "1"]


@pytest.mark.parametrize(
    "name",
    [
        *("module_tilt", "tilt", "temp_dew", "Wind Chill", "wet bulb T", "PV total"),
        *("Pyranometer Temp", "Irradiance sensor temperature", "pyrano_body_temp"),
    ],
)
def test_no_name_of_another_quantity_is_proposed(name):
    assert usual_name(name) is None


def form_of_parts(time, form, rest):
    return form if time == time.normalize() else form + rest


WRITTEN = {
    "%b %d, %Y %I:%M %p": lambda t: (
        f"{t:%b} {t.day}, {t:%Y} {t.hour % 12 or 12}:{t:%M %p}"
    ),
    "%d %B %Y %H:%M": lambda t: f"{t:%d %B %Y %H:%M}",
    "%d-%b-%y %H:%M:%S": lambda t: f"{t:%d-%b-%y %H:%M:%S}",
    "%m/%d/%Y, %I:%M:%S %p": lambda t: f"{t:%m/%d/%Y, %I:%M:%S %p}",
    "%Y%m%d:%H%M": lambda t: f"{t:%Y%m%d:%H%M}",  # as PVGIS
    "%y-%m-%d %H:%M": lambda t: f"{t:%y-%m-%d %H:%M}",
    "%Y-%j %H:%M": lambda t: f"{t:%Y-%j %H:%M}",
    "%Y年%m月%d日 %H:%M": lambda t: f"{t:%Y年%m月%d日 %H:%M}",
    # R and spreadsheets leave out what is zero
    "%d.%m.%Y %H:%M:%S": lambda t: f"{t:{form_of_parts(t, '%d.%m.%Y', ' %H:%M:%S')}}",
    "%m/%d/%Y %I:%M %p": lambda t: f"{t:{form_of_parts(t, '%m/%d/%Y', ' %I:%M %p')}}",
    "%d/%m/%Y %H:%M:%S": lambda t: f"{t:{form_of_parts(t, '%d/%m/%Y %H:%M', ':%S')}}",
    "excel": lambda t: (t - pd.Timestamp("1899-12-30")) / pd.Timedelta(days=1),
}


@pytest.mark.parametrize("form", WRITTEN)
def test_times_as_portals_and_spreadsheets_write_them_are_read(form, record, tmp_path):
    path = tmp_path / "plant.csv"
    data = record.set_axis([WRITTEN[form](t) for t in record.index])
    data.to_csv(path, index_label="Time stamp")
    refused = call("fit", path)
    assert refused.exit_code == 1 and "--time-format" in refused.output
    words = proposed(refused)
    assert words[words.index("--time-format") + 1] == form
    read = fem.read_file(path, time_format=form)
    assert (read.index == record.index).all()
    assert call(*words).exit_code == 0


LETTERED = {
    # zone of the clock, what stands behind its times, and the zone that is proposed
    "standard time all year": ("Etc/GMT-1", "CET", None),
    "in German": ("Europe/Berlin", {1: "MEZ", 2: "MESZ"}, "Europe/Berlin"),
    "both": ("Europe/Berlin", "%Z", "Europe/Berlin"),
    "twelve hours": ("America/New_York", "%Z", "America/New_York"),
    "letters of two zones": ("America/Chicago", "%Z", "America/Chicago"),
    "letters of two zones in winter": ("Etc/GMT+6", "CST", "America/Chicago"),
    "an offset": ("Europe/Berlin", "%z", "Europe/Berlin"),
}


@pytest.mark.parametrize("case", LETTERED)
def test_letters_of_a_zone_are_one_distance_from_utc(case, tmp_path):
    zone, letters, told = LETTERED[case]
    days = 60 if "winter" in case else 365
    data = simulator.record(days=days, step=3600, start="2022-12-01", seed=4)
    data = data[list(COLUMNS)].tz_convert(zone)
    form = "%m/%d/%Y %I:%M %p" if "twelve" in case else "%d.%m.%Y %H:%M"
    behind = letters
    if isinstance(letters, dict):
        hours = [int(time.utcoffset().total_seconds() // 3600) for time in data.index]
        behind, letters = [letters[hour] for hour in hours], "%Z"
    elif letters in ("%Z", "%z"):
        behind = data.index.strftime(letters)
    else:
        letters = "%Z"
    text = data.index.strftime(form) + " " + behind
    data.set_axis(text).to_csv(path := tmp_path / "plant.csv", index_label="time")
    words = proposed(call("fit", path))
    assert words[words.index("--time-format") + 1] == f"{form} {letters}"
    assert told is None or words[words.index("--tz") + 1] == told
    read = fem.read_file(path, time_format=f"{form} {letters}", tz=told)
    assert (read.index == data.index).all()
    assert call(*words).exit_code == 0


@pytest.mark.parametrize("zone", ["Europe/Madrid", "America/New_York"])
def test_letters_may_mark_summer_time_alone(zone, tmp_path):
    """As FusionSolar does, with a device in each row."""
    data = simulator.record(days=60, step=3600, start="2023-03-01", seed=4)
    data = data[list(COLUMNS)].tz_convert(zone)
    text = data.index.strftime("%Y-%m-%d %H:%M:%S")
    text += np.where([bool(time.dst()) for time in data.index], " DST", "")
    rows = data.set_axis(text).assign(device="EMI-01")
    rows.to_csv(path := tmp_path / "plant.csv", index_label="time")
    assert "--tz, such as Europe/Madrid" in call("fit", path, "--guess").output
    words = proposed(call("fit", path, "--guess", "--tz", zone))
    form = "%Y-%m-%d %H:%M:%S %Z"
    assert words[words.index("--time-format") + 1] == form
    assert (fem.read_file(path, time_format=form, tz=zone).index == data.index).all()
    assert call(*words).exit_code == 0


@pytest.mark.parametrize(
    ("letters", "form", "words"),
    [
        ("CST", "%Z", "more than one zone.*--tz America/Chicago or --tz Asia/Shanghai"),
        ("XYZ", "XYZ", "the zone 'XYZ' in row 0 .*%H:%M XYZ.*--tz"),
    ],
)
def test_letters_that_tell_no_time_are_refused_by_name(
    letters, form, words, record, tmp_path
):
    data = record.set_axis(record.index.strftime(f"%Y-%m-%d %H:%M {letters}"))
    data.to_csv(path := tmp_path / "plant.csv", index_label="time")
    refused = call("fit", path, "--time-format", "%Y-%m-%d %H:%M %Z")
    assert refused.exit_code == 1 and re.search(words, refused.output)
    told = ["--tz", "America/Chicago", "--time-format", f"%Y-%m-%d %H:%M {form}"]
    assert call("fit", path, *told).exit_code == 0


@pytest.mark.parametrize("first", ["%d/%m/%Y %H:%M", "%m/%d/%Y %H:%M"])
def test_a_month_that_is_read_as_the_day_is_noticed(first, record, tmp_path):
    """Twelve days may be one of each month: by the other format they follow."""
    forms = "%d/%m/%Y %H:%M", "%m/%d/%Y %H:%M"
    (other,) = {*forms} - {first}
    days = record[record.index.day <= 12]["2023-06":]
    path = tmp_path / "plant.csv"
    days.set_axis(days.index.strftime(first)).to_csv(path, index_label="time")
    for more in ([], ["--sort"]):
        refused = call("fit", path, "--time-format", other, *more)
        assert refused.exit_code == 1
        assert f"give --time-format '{first}'" in refused.output
        assert "none after the 12th of a month" in refused.output
    assert (fem.read_file(path, time_format=first).index == days.index).all()


@pytest.fixture
def portal(plant):
    """What a portal exports: prefixes, a fraction, a plant's power, and the rest."""
    power = plant["poa_global"] * 0.04 * (1 - 0.004 * (plant["temp_module"] - 25))
    return pd.DataFrame(
        {
            "met_POA": plant["poa_global"],
            "met_Tamb": plant["temp_air"],
            "met_WS": plant["wind_speed"],
            "array_Tmod": plant["temp_module"],
            "met_RH": plant["relative_humidity"] / 100.0,
            "System Power (kW)": power.round(3),
            "inverter_2_power": power.round(2),
            "Battery V": 12.5,
            "comment": "ok",
            "spare": np.nan,
            "POA_std": power.round(1) % 7,
            "fan": power.round(1) % 11,
            "RECORD": range(len(plant)),
        },
        plant.index,
    )


def test_a_guess_lists_every_column_that_it_does_not_use(portal, tmp_path):
    path = tmp_path / "plant.csv"
    portal.to_csv(path, index_label="time")
    guessed = call("loop", path, "--guess")
    assert guessed.exit_code == 0
    words = proposed(guessed)
    mapped = {
        "poa_global": "met_POA",
        "temp_air": "met_Tamb",
        "wind_speed": "met_WS",
        "temp_module": "array_Tmod",
        "relative_humidity": "met_RH",
        "power_ac": "System Power (kW)",
    }
    assert {f"{name}={column}" for name, column in mapped.items()} <= {*words}
    assert words[words.index("--unit") + 1] == "relative_humidity=fraction"
    left = {
        "constant: 'Battery V'",
        "not numeric: 'comment'",
        "no value: 'spare'",
        "another quantity, by 'std' in the name: 'POA_std'",
        "power_ac has a column already: 'inverter_2_power'",
        "no known name: 'fan'",
        "a count of the rows: 'RECORD'",
    }
    found = re.findall(r"^- not mapped, (.*)$", guessed.output, re.MULTILINE)
    assert {*found} == left
    named = [*mapped.values(), *re.findall(r"'([^']+)'$", "\n".join(found), re.M)]
    assert {*portal} == {*named}


def test_a_fraction_reaches_the_loop_as_percent(portal, plant, tmp_path):
    path = tmp_path / "plant.csv"
    portal.to_csv(path, index_label="time")
    words = proposed(call("loop", path, "--guess"))
    files = [word for word in words if word.startswith("relative_humidity=")]
    assert files == ["relative_humidity=met_RH", "relative_humidity=fraction"]
    data = fem.read_file(
        path, {"relative_humidity": "met_RH"}, {"relative_humidity": "fraction"}
    )
    humid = plant["relative_humidity"].to_numpy()
    assert data["relative_humidity"].to_numpy() == pytest.approx(humid)


OWN = {
    "met_RH": ("relative_humidity", lambda d: d["relative_humidity"] / 100.0),
    "wind dir": ("wind_direction", lambda d: np.radians(d["wind_direction"])),
    "rain_in": ("precipitation", lambda d: d["precipitation"] / 25.4),
    "System Power (kW)": ("power_ac", lambda d: d["poa_global"] * 0.04),
}


@pytest.mark.parametrize("column", OWN)
def test_no_driver_of_an_effect_is_a_cause_of_its_own_without_a_word(column, plant):
    """Under another name, in another unit: the loop says what it may be."""
    name, values = OWN[column]
    noise = np.random.default_rng(1).normal(0.0, 0.01, len(plant))
    data = plant[list(COLUMNS)].assign(**{column: values(plant) + noise, "fan": noise})
    notes = fem.close_loop(data, effects=[]).notes
    told = [note for note in notes if note.startswith(f"{column} looks like {name}:")]
    assert len(told) == 1 and f"--map {name}={column}" in told[0]
    assert not any(note.startswith("fan looks") for note in notes)


def test_the_hint_is_said_once_and_what_it_says_can_be_run(plant, tmp_path):
    """With the unit that the header names, or the values show."""
    data = plant[list(COLUMNS)].assign(met_RH=plant["relative_humidity"] / 100.0)
    data["System Power (kW)"] = plant["poa_global"] * 0.04
    data.to_csv(path := tmp_path / "plant.csv", index_label="time")
    for more in ((), ("--details",)):
        shown = call("loop", path, "--effects", "season", *more)
        assert shown.output.count("looks like relative_humidity") == 1
    hint = call("loop", path, "--effects", "season").output.splitlines()[0]
    words = shlex.split(hint.partition("run again with ")[2])
    assert {"relative_humidity=fraction", "power_ac=kW"} <= {*words}
    run = call("loop", path, "--effects", "season", *words)
    assert run.exit_code == 0 and "looks like" not in run.output


def test_a_driver_in_another_unit_is_told_the_option_that_converts_it(plant):
    turned = plant.assign(
        relative_humidity=plant["relative_humidity"] / 100.0,
        wind_direction=np.radians(plant["wind_direction"]),
    )
    notes = " ".join(fem.close_loop(turned, effects=[]).notes)
    assert "--unit relative_humidity=fraction" in notes
    assert "--unit wind_direction=rad" in notes


def test_the_loop_counts_what_a_screening_counts(plant):
    """Test weeks are in the counts, though no rule has seen their temperature."""
    data = plant.copy()
    rng = np.random.default_rng(3)
    codes = {"temp_module": -9999.0, "temp_air": -99.0, "relative_humidity": -999.0}
    for name, code in codes.items():
        rows = rng.choice(len(data), 150, replace=False)
        data.iloc[rows, data.columns.get_loc(name)] = code
    whole = [note for note in fem.screen_record(data).notes if "fill value" in note]
    assert [re.search(r"in (\d+) rows", note)[1] for note in whole] == 3 * ["150"]
    loop = fem.close_loop(data, effects=[])
    assert [note for note in loop.notes if "fill value" in note] == whole


def test_times_that_stay_uncertain_hold_back_the_sun_alone():
    """A clock that is set each week to anything within hours: the rest is answered."""
    whole = {**simulator.PHYSICS, "sky_radiation": 1.0}
    data = simulator.record(effects=whole, days=200, step=1800, seed=4)
    data = data.tz_localize(None)
    rng = np.random.default_rng(1)
    weeks = np.cumsum(rng.integers(6, 12, 60))
    week = np.searchsorted(weeks, (data.index - data.index[0]).days)
    off = pd.to_timedelta(rng.integers(-4, 5, 60)[week] * 30, unit="min")
    data = data.set_axis(data.index + off).sort_index()
    data = data[~data.index.duplicated()]
    site = simulator.RHINE
    loop = fem.close_loop(
        data,
        location=Location(site.latitude, site.longitude, tz=site.tz),
        surface_tilt=site.surface_tilt,
        surface_azimuth=site.surface_azimuth,
        effects=["sky_radiation", "shading"],
    )
    assert loop.untestable["shading"].reason is Reason.OFF_THE_SUN
    assert "sky_radiation" in loop.effects
    assert "are not sure" in loop.report()


def lamps(data, nights, seed):
    """A light for an hour after ten, in some of the nights."""
    days = pd.Series(data.index.date)
    lit = np.random.default_rng(seed).choice(days.unique(), nights, replace=False)
    rows = days.isin(lit).to_numpy() & (data.index.hour == 22)
    return data.assign(poa_global=data["poa_global"].mask(rows, 700.0)), rows


def flashes(data, share, seed):
    """Single rows of the dark that read anything."""
    rng = np.random.default_rng(seed)
    night = (data.index.hour >= 22) | (data.index.hour < 3)
    rows = night & (rng.uniform(size=len(data)) < share)
    light = data["poa_global"].mask(rows, rng.uniform(100.0, 1200.0, len(data)))
    return data.assign(poa_global=light), rows


@pytest.mark.parametrize("late", [0.0, 60.0, -120.0])
@pytest.mark.parametrize(
    ("lit", "many"), [(flashes, 0.01), (flashes, 0.05), (lamps, 6), (lamps, 30)]
)
def test_light_by_night_neither_hides_a_clock_nor_looks_like_one(lit, many, late):
    """The middle of the day's light is where it was, to a minute."""
    site = simulator.RHINE
    data = simulator.record(site, {"file_shift": late}, 100, 900.0, 3)[list(COLUMNS)]
    place = Location(site.latitude, site.longitude, tz=site.tz)
    spoilt, rows = lit(data, many, seed=1)
    found = fem.screen_record(spoilt)
    if rows.mean() < 0.01 or lit is flashes:
        assert found.masks["light by night"]["poa_global"][rows].mean() > 0.9
        assert any("when other nights are dark" in note for note in found.notes)
    assert not found.masks["light by night"]["poa_global"][~rows].any()
    plane = site.surface_tilt, site.surface_azimuth
    poa = found.cleaned["poa_global"].to_numpy()
    noon = solar_noon_shift(poa, data.index, place, *plane)
    assert noon.late / 60.0 == pytest.approx(late, abs=1.0)
    assert list(noon.faults) == (["file_shift"] if late else [])


@pytest.mark.parametrize("latitude", [5.0, 49.4, 66.0])
@pytest.mark.parametrize("start", ["2023-11-25", "2023-03-01", "2023-05-25"])
def test_the_first_clear_day_among_dark_ones_is_no_light_by_night(latitude, start):
    site = replace(simulator.RHINE, latitude=latitude)
    for step in (300.0, 3600.0):
        data = simulator.record(site, simulator.PHYSICS, 40, step, 7, start=start)
        kinds = fem.screen_record(data[["poa_global"]]).counts["kind"]
        assert "light by night" not in {*kinds}


def of_the_day_before(index):
    """Dates by which midnight is the end of a day."""
    midnight = (index.hour == 0) & (index.minute == 0)
    return index - pd.to_timedelta(np.where(midnight, 1, 0), unit="D"), midnight


LOGGERS = {
    "midnight is 24:00": lambda index: {
        "Datum": of_the_day_before(index)[0].strftime("%d.%m.%Y"),
        "Zeit": np.where(of_the_day_before(index)[1], "24:00", index.strftime("%H:%M")),
    },
    "parts": lambda index: {
        "Year": index.year,
        "Month": index.month,
        "Day": index.day,
        "Hour": index.hour,
        "Minute": index.minute,
    },
    "day of the year, midnight is 2400": lambda index: {
        "Year": of_the_day_before(index)[0].year,
        "DOY": of_the_day_before(index)[0].day_of_year,
        "HHMM": np.where(
            of_the_day_before(index)[1], 2400, index.hour * 100 + index.minute
        ),
    },
}


@pytest.mark.parametrize("logger", LOGGERS)
def test_dates_and_hours_as_loggers_write_them_are_proposed(logger, record, tmp_path):
    path = tmp_path / "plant.csv"
    columns = LOGGERS[logger](record.index)
    data = pd.DataFrame(columns).join(record.reset_index(drop=True))
    data.to_csv(path, index=False)
    words = proposed(call("fit", path))
    time = words[words.index("--time") + 1].split(",")
    form = words[words.index("--time-format") + 1]
    assert time == [*columns]
    read = fem.read_file(path, time=time, time_format=form)
    assert (read.index == record.index).all()
    assert call(*words).exit_code == 0


def test_dates_without_any_hour_are_no_times(record, tmp_path):
    path = tmp_path / "plant.csv"
    dates = record.index.strftime("%d.%m.%Y")
    record.set_axis(dates).to_csv(path, index_label="time")
    result = call("fit", path, "--time-format", "%d.%m.%Y %H:%M")
    assert "holds no time of the format %d.%m.%Y %H:%M in row 0" in result.output


def test_a_campbell_table_needs_the_proposal_alone(plant, tmp_path):
    """TOA5: four lines of header, a record number, "NAN", statistics next to means."""
    names = {
        "POA_Irrad_Avg": ("W/m^2", "poa_global"),
        "AirTC_Avg": ("Deg C", "temp_air"),
        "WS_ms_S_WVT": ("meters/second", "wind_speed"),
        "WindDir_D1_WVT": ("Deg", "wind_direction"),
        "WindDir_SD1_WVT": ("Deg", None),
        "RH": ("%", "relative_humidity"),
        "BOM_Temp_C_Avg(1)": ("Deg C", "temp_module"),
    }
    rng = np.random.default_rng(0)
    columns = {
        column: rng.normal(10.0, 3.0, len(plant)) if name is None else plant[name]
        for column, (_, name) in names.items()
    }
    data = pd.DataFrame(columns, plant.index).round(3).astype(object)
    data.iloc[rng.choice(len(data), 40, replace=False), 2] = "NAN"
    data.insert(0, "RECORD", range(len(data)))
    header = ["TIMESTAMP", *data]
    units = ["TS", "RN", *(unit for unit, _ in names.values())]
    kinds = ["", "", *["Avg"] * len(names)]
    top = '"TOA5","Station","CR1000X","1","CR1000X.Std.05","CPU:pv.CR1X","9","Table"\n'
    lines = [",".join(f'"{c}"' for c in row) for row in (header, units, kinds)]
    path = tmp_path / "plant.dat"
    path.write_text(top + "\n".join(lines) + "\n" + data.to_csv(header=False))
    words = proposed(call("loop", path))
    assert words[words.index("--skip-lines") + 1] == "0,2,3"
    mapped = {f"{name}={column}" for column, (_, name) in names.items() if name}
    maps = {word for flag, word in pairwise(words) if flag == "--map"}
    assert maps == mapped
    result = call("fit", *words[1:])
    assert result.exit_code == 0 and "missing: wind_speed 40" in result.output


def in_milliseconds(record, path):
    since = (record.index - pd.Timestamp("1970")) // pd.Timedelta("1ms")
    record.assign(epoch=since).to_csv(path, index=False)
    return ["--time-format", "unix-ms"]


def with_a_zone(record, path):
    data = record.set_axis(record.index.strftime("%Y-%m-%d %H:%M:%S EST"))
    data.to_csv(path, index_label="time")
    return ["--time-format", "%Y-%m-%d %H:%M:%S %Z"]


def with_totals_of_days(record, path):
    lines = record.to_csv(index_label="time").splitlines()
    mean = "\nDaily mean,200,15,3,20"
    path.write_text("\n".join(line + mean * (" 23:50" in line) for line in lines))
    return ["--drop-untimed"]


def as_amounts(record, path):
    record.assign(poa_global=record.poa_global / 6).to_csv(path, index_label="time")
    return ["--unit", "poa_global=Wh/m²"]


ODD = (in_milliseconds, with_a_zone, with_totals_of_days, as_amounts)


@pytest.mark.parametrize("kind", ODD, ids=lambda kind: kind.__name__)
def test_an_odd_file_opens_with_what_the_message_proposes(kind, record, tmp_path):
    path = tmp_path / "plant.csv"
    option, *value = kind(record, path)
    words = proposed(call("fit", path))
    assert words[words.index(option) + 1 :][: len(value)] == value
    expected = fem.fit_fem(*(record[name] for name in COLUMNS))
    result = call(*words)
    assert tau_of(result) == pytest.approx(expected.coefficients["tau"], rel=0.02)


def test_a_file_without_a_header_is_told_to_have_none(record, tmp_path):
    record.to_csv(path := tmp_path / "plant.csv", header=False)
    result = call("fit", path)
    assert result.exit_code == 1 and "plant.csv has no header" in result.output
    assert "write a line of names above it" in result.output


def test_a_unit_in_the_cells_is_no_missing_value(record, tmp_path):
    data = record.assign(temp_air=record["temp_air"].astype(str) + " °C")
    data.to_csv(path := tmp_path / "plant.csv", index_label="time")
    result = call("fit", path)
    assert result.exit_code == 1 and "--missing" not in result.output
    assert "take the unit '°C' out of the cells" in result.output


def test_a_record_number_is_no_cause(plant):
    """It would be named for whatever drifts, gaps or not."""
    number = np.arange(len(plant))
    since = (plant.index - plant.index[0]) / pd.Timedelta("1s")
    data = plant[list(COLUMNS)].assign(since=since, fan=number % 7)
    data = data.drop(data.index[1000:1500])
    data["again"] = np.arange(len(data))
    notes = " ".join(fem.close_loop(data, effects=[]).notes)
    assert "since is a copy of the time: not used" in notes
    assert "again is a copy of a count: not used" in notes
    assert "fan is" not in notes


@pytest.mark.parametrize("part", [700.0, 1800.0, 5000.0])
def test_light_is_where_it_is_in_parts_of_a_day_of_any_length(part):
    """A part of the day need not divide it."""
    data = simulator.record(
        effects=simulator.PHYSICS, days=8, step=600, start="2023-06-01"
    )
    place = data.columns.get_loc("poa_global")
    data.iloc[[72, 144], place] = -50.0, 300.0  # noon, and midnight
    found = fem.screen_record(data, Limits(daylight_tolerance=part))
    assert [*found.counts["kind"]] == ["negative by day", "light by night"]
