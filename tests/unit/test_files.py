"""Files as people have them: read as they say, or refused with what would read them."""

import gzip
import os
import re
import sys

import numpy as np
import openpyxl
import pandas as pd
import pytest
from conftest import call, proposed
from hypothesis import given, settings, strategies as st
from scipy.constants import convert_temperature

import pvlib_fem as fem
from pvlib_fem import datasets
from pvlib_fem._record.guess import guess
from pvlib_fem._record.header_units import (
    QUANTITIES,
    UNITS,
    converted_column,
    named_unit,
    own_unit,
    unit_of,
)
from pvlib_fem._record.layout import Layout, found_layout
from pvlib_fem._record.logger_files import frame
from pvlib_fem._record.zone_candidates import zone_of
from pvlib_fem._stored import replacing

NAMES = {
    "poa_global": "Irr (W/m2)",
    "temp_air": "Tamb [°F]",
    "wind_speed": "Wind (mph)",
    "temp_module": "Tmod [°C]",
}


@pytest.fixture(scope="module")
def record():
    """Twelve days over the end of summer time, whose truth is in Celsius and m/s."""
    data = fem.datasets.synthetic(12, 600, start="2023-10-22", seed=2)
    return data.tz_localize(None)[list(NAMES)].round(3)


@pytest.fixture
def raw(record):
    """The record of a logger: names of its own, mph and °F."""
    data = record.rename(columns=NAMES)
    data["Tamb [°F]"] = convert_temperature(data["Tamb [°F]"], "C", "F")
    data["Wind (mph)"] /= 0.44704
    return data.rename_axis("TIMESTAMP")


def excel(raw, folder):
    raw.to_excel(folder / "plant.xlsx", startrow=3)
    return ["plant.xlsx"]


def preamble(raw, folder):
    top = "Site: North field\nLogger, 12, 4711\n\nSoftware 1.2\n"
    (folder / "plant.csv").write_text(top + raw.to_csv(), encoding="utf-8")
    return ["plant.csv"]


def two_columns(raw, folder):
    day, hour = raw.index.strftime("%d/%m/%Y"), raw.index.strftime("%H:%M")
    raw.assign(Date=day, Time=hour).to_csv(folder / "plant.csv", index=False)
    return ["plant.csv"]


def two_files(raw, folder):
    weather = raw.drop(columns="Tmod [°C]")
    weather.to_csv(folder / "weather.csv")
    module = raw[["Tmod [°C]"]].assign(battery=12.5)
    module.index = (module.index + pd.Timedelta("3s")).strftime("%d.%m.%Y %H:%M:%S")
    module.to_csv(folder / "module.csv", sep=";", decimal=",", index_label="Zeit")
    return ["weather.csv", "module.csv"]


def comma(raw, folder):
    raw = raw.set_axis(raw.index.strftime("%d.%m.%Y %H:%M"))
    how = dict(sep=";", decimal=",", index_label="Zeit", encoding="cp1252")
    raw.to_csv(folder / "plant.csv", **how)
    return ["plant.csv"]


def summer_time(raw, folder):
    local = raw.tz_localize("UTC").tz_convert("Europe/Berlin").tz_localize(None)
    local.to_csv(folder / "plant.csv")
    return ["plant.csv"]


KINDS = {
    excel: ("--skip-rows", "3"),
    preamble: ("--skip-rows", "4"),
    two_columns: ("--time", "Date,Time"),
    two_files: ("--sep", ";"),
    comma: ("--decimal", ","),
    summer_time: ("--tz", "Europe/Berlin"),
}


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.__name__)
def test_a_file_of_any_kind_opens_with_what_the_message_proposes(
    kind, raw, record, tmp_path
):
    """Two commands from the file to the report, and the numbers of the record."""
    files = [str(tmp_path / name) for name in kind(raw, tmp_path)]
    out = tmp_path / "fit.json"
    first = call("fit", *files, "--model", "faiman", "--out", out)
    assert first.exit_code == 1
    said, _, asked, *_ = first.output.splitlines()
    assert said.startswith("Error: ") and asked.endswith("before you run it:")
    words = proposed(first)
    option, value = KINDS[kind]
    assert value in words[words.index(option) :]
    assert {"--convert", "--model", "faiman", "--out"} <= {*words}
    second = call(*words)
    assert second.exit_code == 0, second.output
    assert "pvlib_fem: faiman, ewm, least_squares\n1,728 rows, 20" in second.output
    expected = fem.fit_fem(*(record[name] for name in NAMES), model="faiman")
    tau = re.search(r"^tau +(\S+)", second.output, re.MULTILINE)[1]
    assert float(tau) == pytest.approx(expected.coefficients["tau"], rel=0.05)


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.__name__)
def test_a_guess_runs_nothing(kind, raw, tmp_path):
    files = [str(tmp_path / name) for name in kind(raw, tmp_path)]
    out = tmp_path / "loop.json"
    result = call("loop", *files, "--guess", "--out", out)
    assert result.exit_code == 0, result.output
    words = proposed(result)
    assert words[0] == "loop" and "--guess" not in words
    assert {f"{name}={column}" for name, column in NAMES.items()} <= {*words}
    assert not out.exists() and "RMSE" not in result.output


FORMS = {
    "%m/%d/%Y %I:%M %p": "%m/%d/%Y %I:%M %p",
    "%d.%m.%y %H:%M:%S": "%d.%m.%y %H:%M:%S",
    "%Y%m%d%H%M": "%Y%m%d%H%M",
    "%Y-%m-%dT%H:%M:%S": "ISO8601",
    "%s": "unix",
}


@pytest.mark.parametrize(("written", "form"), FORMS.items())
@pytest.mark.parametrize("start", ["2023-06-01", "2023-10-22"])
def test_forms_of_times_are_found(written, form, start, record, tmp_path):
    """Also where each day could be a month, by the steps that are even."""
    index = pd.date_range(start, periods=1000, freq="10min")
    text = index.strftime(written)
    if written == "%s":
        text = (index - pd.Timestamp(0)) // pd.Timedelta("1s")
    path = tmp_path / "plant.csv"
    record[:1000].set_axis(text).to_csv(path, index_label="stamp")
    found = guess([path], [Layout()], {})
    assert found.layouts[0].time_format == form
    data = frame([path], found.layouts, found.columns)
    assert (data.index.tz_localize(None) == index).all()
    assert (data.index.tz is not None) == (form == "unix")


def test_a_date_and_an_hour_without_a_colon(record, tmp_path):
    path = tmp_path / "plant.csv"
    day, hour = (record.index.strftime(form) for form in ("%Y%m%d", "%H%M"))
    record.assign(day=day, hhmm=hour).to_csv(path, index=False)
    found = guess([path], [Layout(time=("day", "hhmm"))], {})
    assert (frame([path], found.layouts, {}).index == record.index).all()


def test_offsets_that_change_tell_the_zone(record, tmp_path):
    path = tmp_path / "plant.csv"
    utc = record.shift(freq="7D").tz_localize("UTC")
    utc.tz_convert("America/Chicago").to_csv(path, index_label="stamp")
    assert guess([path], [Layout()], {}).layouts[0].tz == "America/Chicago"
    assert "--tz America/Chicago" in call("fit", path, "--guess").output


@pytest.mark.parametrize(
    "headers",
    [
        ("GPOA", "Tamb", "WS", "Tmod"),
        ("poa_irradiance", "ambient_temp", "wind_speed", "module_temp_1"),
        (
            "Einstrahlung Modulebene (W/m²)",
            "Lufttemperatur (°C)",
            "Windgeschwindigkeit (m/s)",
            "Modultemperatur (°C)",
        ),
        ("Irradiancia inclinada", "Temp ambiente", "Vel viento", "Temp panel"),
        (
            "Plane of Array Irradiance (W/m^2)",
            "Outdoor Temp (C)",
            "Wind Velocity (m/s)",
            "Back of Module Temp (C)",
        ),
        ("POAIrrad1_Avg", "LocalAmbientTemp_Avg", "WS_ms_Mean", "ModTemp1_Avg"),
        ("G", "T1", "v", "T2"),
    ],
)
def test_columns_are_found_by_the_names_that_loggers_give(headers, record, tmp_path):
    path = tmp_path / "plant.csv"
    others = {"GHI": 1.0, "WS_Std": 2.0, "T_max": 3.0, "Battery_V": 4.0}
    record.set_axis(headers, axis=1).assign(**others).to_csv(path, index_label="t")
    found = guess([path], [Layout()], {})
    assert found.columns == {n: h for n, h in zip(NAMES, headers) if n != h}


def test_no_column_is_mapped_that_is_not_it(record, tmp_path):
    """Horizontal irradiance is that; a spread and a maximum are none of the four."""
    path = tmp_path / "plant.csv"
    headers = ("GHI", "T_amb_max", "wind_std", "Tmod_sd")
    record.set_axis(headers, axis=1).to_csv(path, index_label="t")
    result = call("fit", path)
    words = proposed(result)
    assert {"ghi=GHI", "temp_air=COLUMN", "temp_module=COLUMN"} <= {*words}
    assert "There are T_amb_max, wind_std, Tmod_sd" in result.output
    assert call(*words).exit_code == 2
    refused = call("fit", path, "--map", "temp_air=COLUMN")
    assert refused.exit_code == 2 and "name of a column" in refused.output


def test_what_is_proposed_reads_what_was_measured(raw, record, tmp_path):
    """To the last digit that was written, each kind but for what it names."""
    excel(raw, tmp_path)
    data = fem.read_file(tmp_path / "plant.xlsx", NAMES, True, skip_rows=3)
    np.testing.assert_allclose(data[[*NAMES]], record, atol=1e-9)
    assert (data.index == record.index).all()
    done = ["temp_air converted from °F to °C", "wind_speed converted from mph to m/s"]
    assert data.attrs["notes"] == done


def test_a_header_that_names_a_unit_is_believed_by_choice_only(raw, tmp_path):
    path = tmp_path / "plant.csv"
    raw.to_csv(path)
    with pytest.raises(ValueError, match=r"names °F, and temp_air has to be in °C"):
        fem.read_file(path, NAMES)
    as_it_is = fem.read_file(path, NAMES, check_units=False)
    np.testing.assert_allclose(as_it_is["temp_air"], raw["Tamb [°F]"], rtol=1e-12)
    told = fem.read_file(path, NAMES, {"temp_air": "degF"}, check_units=False)
    assert told["wind_speed"].equals(as_it_is["wind_speed"])
    np.testing.assert_allclose(
        told["temp_air"], convert_temperature(raw["Tamb [°F]"], "F", "C")
    )


@pytest.mark.parametrize(
    ("name", "header", "unit"),
    [
        ("wind_speed", "Wind (mph)", "mph"),
        ("wind_speed", "WS_ms_Mean", "m/s"),
        ("wind_speed", "Wind Speed km/h", "km/h"),
        ("wind_speed", "Windspeed [kts]", "kn"),
        ("wind_speed", "wind_speed", None),
        ("temp_air", "Tamb [°F]", "°F"),
        ("wind_speed", "WS (miles/hour)", "mph"),
        ("temp_air", "気温(℃)", "°C"),
        ("poa_global", "Irradiancia(W/㎡)", "W/m²"),
        ("temp_air", "Temp_C_Avg", "°C"),
        ("temp_air", "Temp_C_Avg_Deg F", "°F"),
        ("temp_air", "T (module) [degC]", "°C"),
        ("temp_air", "C", None),
        ("temp_module", "T (rear, °F)", "°F"),
        ("poa_global", "POA (kW/m^2)", "kW/m²"),
        ("poa_global", "G [W m⁻²]", None),
        ("poa_global", "Global_Wm2_Avg", "W/m²"),
        ("precipitation", "Rain_in_gauge", None),
        ("precipitation", "Rain [in]", "in"),
        ("p_dc_per_area", "Power (kW)", "kW"),
        ("relative_humidity", "RH_pct_Avg", "%"),
    ],
)
def test_units_of_headers(name, header, unit):
    assert named_unit(name, header) == unit


def test_every_unit_has_a_spelling_and_its_own_is_left_as_it_is():
    column = pd.Series([0.0, 1.0, 20.0])
    for name, quantity in QUANTITIES.items():
        for unit in UNITS[quantity]:
            assert unit_of(name, unit) == unit
            if unit.upper() not in UNITS[quantity]:  # as mW and MW
                assert unit_of(name, unit.upper()) == unit
        assert converted_column(column, name, own_unit(name)) is column


def test_amounts_of_rain_and_power_of_a_plant_need_what_they_are_of():
    rain = converted_column(pd.Series([0.2]), "precipitation", "mm", hours=1 / 6)
    assert rain[0] == pytest.approx(1.2)  # mm/h: 0.2 mm in ten minutes
    for unit, size in {"mm/10min": 0.2, "mm/d": 28.8, "mm per 5 min": 0.1}.items():
        assert named_unit("precipitation", f"Rain ({unit})") == unit_of(
            "precipitation", unit
        )
        rain = converted_column(pd.Series([size]), "precipitation", unit, hours=1.0)
        assert rain[0] == pytest.approx(1.2)  # over its own span, whatever the step
    sun = converted_column(pd.Series([0.2]), "poa_global", "kWh/m²/15min", hours=1.0)
    assert sun[0] == pytest.approx(800.0)
    for unit in ("mm/0min", "m/s/10min", "mm/10"):
        with pytest.raises(ValueError, match="cannot be in"):
            unit_of("precipitation", unit)
    for unit, size in {"W": 24e3, "kW": 24.0, "MW": 0.024}.items():
        power = converted_column(pd.Series([size]), "p_dc_per_area", unit, area=120.0)
        assert power[0] == pytest.approx(200.0)
    gaps = pd.Series([68.0, None], dtype="Int64")
    warm = converted_column(gaps, "temp_air", "°F")
    assert warm[0] == pytest.approx(20.0) and pd.isna(warm[1])
    with pytest.raises(ValueError, match="precipitation is in mm of each step, and a"):
        converted_column(pd.Series([0.2]), "precipitation", "mm", hours=np.nan)
    with pytest.raises(ValueError, match="area of the modules"):
        converted_column(pd.Series([24.0]), "p_dc_per_area", "kW")
    with pytest.raises(ValueError, match=r"cannot be in 'furlong'; it may be in m/s"):
        unit_of("wind_speed", "furlong")


def test_a_unit_that_only_the_record_shows_is_proposed(raw, tmp_path):
    path = tmp_path / "plant.csv"
    names = {"Wind (mph)": "Wind", "Tamb [°F]": "Tamb"}
    raw.rename(columns=names).assign(Wind=raw["Wind (mph)"] * 1.609 * 1.7).to_csv(path)
    told = {n: names.get(c, c) for n, c in NAMES.items()}
    refused = call("fit", path, *(f"--map={n}={c}" for n, c in told.items()))
    assert "Give --unit temp_air=°F to convert it" in refused.output
    words = proposed(call("fit", path))
    assert {"wind_speed=km/h", "temp_air=°F"} <= {*words}
    assert call(*words).exit_code == 0


def test_a_line_of_units_below_the_header_is_left_out_and_read(raw, tmp_path):
    path = tmp_path / "plant.csv"
    head, *lines = raw.rename(columns=lambda c: c.split()[0]).to_csv().splitlines()
    path.write_text("\n".join([head, "TS,W/m^2,Deg F,mph,Deg C", *lines]), "utf-8")
    words = proposed(call("fit", path))
    assert words[2:4] == ["--skip-lines", "1"]
    assert {"wind_speed=mph", "temp_air=°F"} <= {*words}
    assert "1,728 rows" in call(*words).output


@pytest.mark.parametrize("suffix", [".csv", ".xlsx"])
def test_a_line_of_units_that_is_left_out_counts_more_than_the_header(
    raw, suffix, tmp_path
):
    """A logger's program whose names say m/s and °C may be set to mph and °F."""
    path, names = tmp_path / f"plant{suffix}", ["G_Wm2", "T_C", "WS_ms", "Tm_C_Avg"]
    units = ["TS", "W/m^2", "Deg F", "mph", "Deg C"]
    rows = [["plant"] * 5, ["time", *names], units, [*"-----"]]
    table = pd.DataFrame([*rows, *raw.reset_index().astype(object).to_numpy()])
    if suffix == ".csv":
        table.to_csv(path, index=False, header=False)
    else:
        table.to_excel(path, index=False, header=False)
    maps = [f"--map={n}={c}" for n, c in zip(NAMES, names)]
    given = ("fit", path, "--skip-lines", "0,2,3", *maps)
    refused = call(*given)
    assert "the line below the header 'T_C' names °F" in refused.output
    assert {"wind_speed=mph", "temp_air=°F"} <= {*proposed(refused)}
    fits = [call(*given, "--convert"), call(*proposed(refused))]
    assert "note: wind_speed converted from mph to m/s" in fits[0].output
    assert fits[0].output.splitlines()[2:] == fits[1].output.splitlines()[2:]


def test_a_text_that_stands_for_a_missing_value_is_told_by_its_row(record, tmp_path):
    path = tmp_path / "plant.csv"
    text = record.astype(object)
    text.iloc[7, 0] = "---"
    text.to_csv(path)
    refused = call("fit", path)
    at = f"poa_global holds '---' at {record.index[7]} (row 7), which is not a number"
    assert at in refused.output
    assert proposed(refused)[2:] == ["--missing", "---"]
    assert "missing: poa_global 1" in call(*proposed(refused)).output


def test_a_decimal_comma_is_no_missing_value(record, tmp_path):
    path = tmp_path / "plant.csv"
    record.to_csv(path, sep=";", decimal=",")
    refused = call("fit", path, "--sep", ";")
    assert "give --decimal ," in refused.output and "--missing" not in refused.output
    assert proposed(refused)[2:] == ["--sep", ";", "--decimal", ","]


def test_rows_out_of_order_or_twice_are_kept_until_it_is_asked_for(record, tmp_path):
    path = tmp_path / "plant.csv"
    order = [*range(500, 1728), *range(500), 1000]
    record.iloc[order].to_csv(path)
    refused = call("fit", path)
    assert refused.exit_code == 1 and "--sort" in refused.output
    words = proposed(refused)
    assert words[2:] == ["--sort", "--drop-doubled"]
    result = call(*words)
    assert "rows whose time was there already, left out: 1" in result.output
    assert "1,728 rows" in result.output


PYTHON = re.compile(
    r"pd\.|np\.|data\.|data\[|=[\"']|check_units|tz_localize|convert_units=|fem\.|"
    r"_area=|errors="
)


@pytest.mark.parametrize(
    ("spoil", "arguments", "remedy"),
    [
        (lambda d: d.iloc[::-1], (), "--sort"),
        (lambda d: pd.concat([d, d.iloc[[-1]]]), (), "--drop-doubled"),
        (
            lambda d: d.assign(poa_global=d.poa_global / 1000),
            (),
            "--unit poa_global=kW",
        ),
        (lambda d: d.assign(temp_air="x"), (), "--missing"),
        (lambda d: d, ("--method", "paper", "--dynamics", "balance"), "--dynamics ewm"),
        (
            lambda d: d,
            ("--method", "paper", "--fix", "tau=3"),
            "--method least_squares",
        ),
        (lambda d: d, ("--fix", "speed=3"), "--fix has speed"),
        (
            lambda d: d,
            ("--method", "paper", "--effects", "season"),
            "--method paper has no effects; use --method least_squares",
        ),
        (
            lambda d: d.rename(columns={"temp_air": "temp_air [°F]"}),
            ("--map", "temp_air=temp_air [°F]"),
            "give --convert to convert it, or --no-unit-check if",
        ),
        (
            lambda d: d.assign(**(1.8 * d.filter(like="temp_") + 32)),
            (),
            "Give --unit temp_air=°F --unit temp_module=°F to convert them",
        ),
        (lambda d: d, ("--fix", "tau=-3"), "--fix tau=-3 s cannot be"),
        (lambda d: d, ("--effects", "wind"), "unknown effect 'wind'"),
        (lambda d: d, ("--effects", "rain"), "--map"),
        (lambda d: d, ("--effects", "season,season"), "season twice"),
        (lambda d: d, ("--holdout", "2024-01-01"), "from 2023-10-22 to 2023-11-02"),
        (lambda d: d, ("--encoding", "nosuch"), "there is no such encoding"),
        (lambda d: d, ("--skip-rows", "9999"), "no line left after"),
        (lambda d: d, ("--sheet", "Nosuch", "--time", "Nosuch"), "no column Nosuch"),
    ],
)
def test_no_message_speaks_python(spoil, arguments, remedy, record, tmp_path):
    path = tmp_path / "plant.csv"
    spoil(record).to_csv(path, index_label="time")
    result = call("fit", path, *arguments)
    assert result.exit_code == 1, result.output
    assert remedy in result.output.splitlines()[0]
    assert not PYTHON.search(result.output), result.output


def test_a_workbook_without_its_reader_names_the_extra(record, tmp_path, monkeypatch):
    record.to_excel(tmp_path / "plant.xlsx")
    monkeypatch.setitem(sys.modules, "openpyxl", None)
    result = call("fit", tmp_path / "plant.xlsx")
    assert result.exit_code == 1
    assert "pip install 'pvlib_fem[excel]'" in result.output


def test_a_sheet_is_found_and_named(raw, tmp_path):
    path = tmp_path / "plant.xlsx"
    with pd.ExcelWriter(path) as book:
        pd.DataFrame({"about": ["a plant"]}).to_excel(book, sheet_name="Info")
        raw.iloc[:600].to_excel(book, sheet_name="Data")
    words = proposed(call("fit", path))
    assert words[words.index("--sheet") + 1] == "Data"
    assert call(*words).exit_code == 0
    assert "--sheet NAME" in call("fit", path, "--sheet", "Nosuch").output


@pytest.mark.parametrize("broken", [b"", b"PK\x03\x04 nothing", b"\xd0\xcf\x11\xe0"])
def test_a_broken_workbook_ends_with_one_line(broken, tmp_path):
    path = tmp_path / "plant.xlsx"
    path.write_bytes(broken)
    result = call("fit", path)
    assert result.exit_code == 1 and len(result.output.splitlines()) == 1


@pytest.mark.parametrize("own", ["5min", "10min", "15min"])
def test_amounts_of_a_step_are_of_the_step_of_their_own_file(own, tmp_path):
    """600 W/m² and 6 mm/h, of which a step of five minutes has 50 Wh/m² and 0.5 mm."""
    hours = pd.Timedelta(own) / pd.Timedelta("1h")
    amounts = {"Sun (Wh/m2)": 600.0 * hours, "Rain (mm)": 6.0 * hours}
    others = {"temp_air": 20.0, "temp_module": 30.0}
    paths = []
    for step, columns in ((own, amounts), ("15min", others)):
        index = pd.date_range("2024-06-01", "2024-06-03", freq=step, name="time")
        paths.append(tmp_path / f"{len(paths)}.csv")
        pd.DataFrame(columns, index).to_csv(paths[-1])
    names = {"poa_global": "Sun (Wh/m2)", "precipitation": "Rain (mm)"}
    data = fem.read_file(paths, names, convert_units=True)
    assert len(data) == 193
    np.testing.assert_allclose(data["poa_global"], 600.0)
    np.testing.assert_allclose(data["precipitation"], 6.0)


def test_files_of_different_steps_are_joined_in_means_and_states(record, tmp_path):
    """Weather by the minute, module by ten: the means of the step that ends there."""
    fine = fem.datasets.synthetic(2, 60, seed=3).tz_localize(None)
    fine["wind_direction"] = np.tile([350.0, 20.0], len(fine) // 2)
    fine.drop(columns="temp_module").to_csv(tmp_path / "weather.csv")
    module = fine[["temp_module"]].iloc[::10]
    module.to_csv(tmp_path / "module.csv")
    both = [tmp_path / "weather.csv", tmp_path / "module.csv"]
    data = fem.read_file(both)
    step = fine["poa_global"].resample("10min", label="right", closed="right").mean()
    np.testing.assert_allclose(data["poa_global"], step.reindex(data.index))
    np.testing.assert_allclose(data["wind_direction"].iloc[1:], 5.0)
    np.testing.assert_allclose(data["temp_module"], module["temp_module"], rtol=1e-12)
    fine[["temp_module"]].to_csv(tmp_path / "state.csv")
    fine.drop(columns="temp_module").iloc[::10].to_csv(tmp_path / "slow.csv")
    data = fem.read_file([tmp_path / "slow.csv", tmp_path / "state.csv"])
    np.testing.assert_allclose(data["temp_module"], module["temp_module"], rtol=1e-12)


def test_codes_of_a_parquet_file_are_texts_and_numbers(record, tmp_path):
    """As pandas writes a categorical column."""
    pytest.importorskip("pyarrow")
    flags = pd.Categorical(["good"] * len(record))
    wind = record["wind_speed"].astype("category")
    twice = pd.concat([record.assign(flags=flags, wind_speed=wind)] * 2)
    twice.to_parquet(path := tmp_path / "plant.parquet")
    data = fem.read_file(path)
    assert len(data) == 2 * len(record) and [*data["flags"]] == 2 * [*flags]
    np.testing.assert_array_equal(data["wind_speed"], twice["wind_speed"])


def test_second_module_sensors_and_trackers_are_joined_as_they_are_then(tmp_path):
    """A mean of a tracker's azimuths is of no plane, and one of sensors is late."""
    index = pd.date_range("2024-06-01", periods=200, freq="1min", name="time")
    turns = {"surface_azimuth": np.where(index.hour < 2, 90.0, 270.0)}
    turns |= {"tracker_theta": np.linspace(-50.0, 50.0, len(index))}
    modules = {"Tmod": np.arange(200.0), "T2": np.arange(200.0)}
    fine = pd.DataFrame(modules | turns, index)
    fine.to_csv(tmp_path / "fine.csv")
    pd.DataFrame({"temp_air": 20.0}, index[5::10]).to_csv(tmp_path / "slow.csv")
    names = {"temp_module": "Tmod", "temp_module_2": "T2"}
    data = fem.read_file([tmp_path / "slow.csv", tmp_path / "fine.csv"], names)
    for name, column in (names | {n: n for n in turns}).items():
        np.testing.assert_allclose(data[name], fine[column].iloc[5::10])


def test_files_that_do_not_meet_are_refused(record, tmp_path):
    one, other = tmp_path / "one.csv", tmp_path / "other.csv"
    record[["poa_global", "temp_air", "wind_speed"]].to_csv(one)
    record[["temp_module"]].shift(freq="300D").to_csv(other)
    result = call("fit", one, other)
    assert "only 0 of the 1,728 times of one.csv are in other.csv" in result.output
    record[["temp_module"]].tz_localize("UTC").to_csv(other)
    assert "the times of one.csv have no zone" in call("fit", one, other).output
    assert call("fit", one, other, "--tz", "UTC").exit_code == 0


def test_a_column_of_two_files_keeps_both(record, tmp_path):
    one, other = tmp_path / "one.csv", tmp_path / "other.csv"
    record.assign(battery=1.0).to_csv(one)
    record[["temp_air"]].assign(battery=2.0).to_csv(other)
    data = fem.read_file([one, other])
    assert {"battery", "battery (other.csv)", "temp_air (other.csv)"} <= {*data}
    assert (data["battery (other.csv)"] == 2.0).all()


@pytest.mark.parametrize(
    ("zone", "longitude", "found"),
    [
        ("Europe/Berlin", None, "Europe/Berlin"),
        ("Europe/London", None, "Europe/London"),
        ("America/Denver", -105.0, "America/Denver"),
        ("America/New_York", -75.0, "America/New_York"),
        ("Australia/Sydney", 151.0, "Australia/Sydney"),
    ],
)
def test_a_zone_is_told_by_the_hour_that_comes_twice(zone, longitude, found):
    utc = pd.date_range("2023-01-01", "2024-01-01", freq="30min", tz="UTC")
    naive = utc.tz_convert(zone).tz_localize(None)
    assert zone_of(naive, longitude, None, []) == found


@pytest.mark.parametrize("longitude", [-106.0, 0.0, 8.7, 151.0])
@pytest.mark.parametrize("zone", ["UTC", "Etc/GMT+7"])
def test_a_zone_is_told_by_the_sun_where_noon_is_elsewhere(longitude, zone):
    hours = round(longitude / 15)
    site = dict(latitude=35.0, longitude=longitude)
    data = fem.datasets.synthetic(5, 900, seed=1, **site).tz_convert(zone)
    naive, sun = data.index.tz_localize(None), data["poa_global"].to_numpy()
    own = {"UTC": 0, "Etc/GMT+7": -7}[zone]
    expected = None if abs(own - hours) <= 1 else zone  # the sun tells hours only
    assert zone_of(naive, longitude, sun, []) == expected


@pytest.mark.parametrize(
    ("clock", "found"),
    [
        ("Etc/GMT-12", None),
        ("Etc/GMT-13", None),
        ("Etc/GMT-14", "Etc/GMT-14"),
        ("UTC", "UTC"),
        ("Etc/GMT+8", "Etc/GMT+8"),
    ],
)
def test_a_clock_west_of_the_date_line_is_not_taken_for_one_east_of_it(clock, found):
    """In New Zealand, 12 h ahead of UTC, the sun is highest at 12:20."""
    site = dict(latitude=-37.0, longitude=174.8)
    data = fem.datasets.synthetic(5, 900, start="2023-02-10", **site).tz_convert(clock)
    sun = data["poa_global"].to_numpy()
    assert zone_of(data.index.tz_localize(None), 174.8, sun, []) == found


GROUPED = [(",", ".", ","), (";", ",", "."), (";", ",", " "), (",", ".", "'")]


@pytest.mark.parametrize("sep, decimal, thousands", GROUPED)
@pytest.mark.parametrize("end", [0, 2])
def test_thousands_and_totals_open_with_what_is_proposed(
    sep, decimal, thousands, end, record, tmp_path
):
    """Signs between thousands, and sums below the rows, from the file to the fit."""
    path, out = tmp_path / "plant.csv", tmp_path / "fit.json"
    light = record["poa_global"] + 900.0  # some above a thousand, some below
    light.iloc[0] = np.nan
    swap = str.maketrans({",": thousands, ".": decimal})
    text = light.map("{:,.3f}".format, na_action="ignore").str.translate(swap)
    table = record.assign(poa_global=text)
    total = "Total" + sep + f'"{light.sum():,.3f}"'.translate(swap) + 3 * sep + "\n"
    lines = table.to_csv(sep=sep, decimal=decimal, index_label="time") + end * total
    path.write_text(lines, "utf-8")
    first = call("fit", path, "--model", "faiman", "--no-unit-check", "--out", out)
    assert first.exit_code == 1
    words = proposed(first)
    assert words[words.index("--thousands") + 1] == thousands
    assert ("--skip-end" in words) == (end > 0)
    assert call(*words).exit_code == 0, words
    layout = dict(sep=sep, decimal=decimal, thousands=thousands, skip_end=end)
    data = fem.read_file(path, **layout)
    pd.testing.assert_series_equal(
        data["poa_global"], light.rename_axis("time"), check_freq=False, rtol=1e-12
    )
    assert len(data) == len(record)


def test_swapped_columns_are_proposed_the_other_way_round(record, tmp_path):
    path, out = tmp_path / "plant.csv", tmp_path / "fit.json"
    names = {"temp_air": "temp_module", "temp_module": "temp_air"}
    record.rename(columns=names).to_csv(path, index_label="time")
    refused = call("fit", path, "--model", "faiman", "--out", out)
    assert refused.exit_code == 1 and "look swapped" in refused.output
    asked = call("fit", path, "--guess", "--model", "faiman", "--out", out)
    words = proposed(asked)
    assert proposed(refused) == words
    assert {"temp_air=temp_module", "temp_module=temp_air"} <= {*words}
    assert "'temp_air' is taken for the module" in asked.output
    assert call(*words).exit_code == 0
    columns = [record[name] for name in NAMES]
    expected = fem.fit_fem(*columns, model="faiman").coefficients
    assert fem.FemFit.from_json(out).coefficients == pytest.approx(expected)


def test_wind_beside_fahrenheit_is_asked_about(record, tmp_path):
    """Numbers alone do not tell mph from m/s where it is calm."""
    path = tmp_path / "plant.csv"
    warm = record.rename(columns={"wind_speed": "WS"})
    for name in ("temp_air", "temp_module"):
        warm[name] = convert_temperature(warm[name], "C", "F")
    warm.to_csv(path, index_label="time")
    words = proposed(call("fit", path, "--map", "wind_speed=WS"))
    assert {"temp_air=°F", "temp_module=°F"} <= {*words}
    assert call(*words).exit_code == 0
    asked = call("fit", path, "--guess").output
    assert "temp_module=°F" in asked and "--unit wind_speed=mph" in asked
    warm.rename(columns={"WS": "WS (m/s)"}).to_csv(path, index_label="time")
    assert "mph" not in call("fit", path, "--guess").output


def test_only_three_digits_stand_after_a_sign_of_thousands(tmp_path):
    """1.5 in a file of decimal commas is neither 15 nor 1.5, but refused."""
    path = tmp_path / "plant.csv"
    rows = "time;poa_global\n2024-06-01 10:00;1.012,5\n2024-06-01 10:10;{}\n"
    path.write_text(rows.format("867,2"), "utf-8")
    layout = dict(sep=";", decimal=",", thousands=".")
    light = fem.read_file(path, **layout)["poa_global"]
    assert light.tolist() == [1012.5, 867.2]
    with pytest.raises(
        ValueError, match=r"'1\.012,5' at .*; give --thousands \. --dec"
    ):
        fem.read_file(path, **layout | {"thousands": ""})
    path.write_text(rows.format("1.5"), "utf-8")
    with pytest.raises(
        ValueError, match=r"poa_global holds '1\.5' at 2024-06-01 10:10"
    ):
        fem.read_file(path, **layout)


def test_a_total_is_told_from_a_time_that_cannot_be_read(record, tmp_path):
    path = tmp_path / "plant.csv"
    text = record.to_csv(index_label="time")
    path.write_text(text + "Total,1,2,3,4\n", "utf-8")
    with pytest.raises(ValueError, match="'Total'; give --skip-end 1 if the last row"):
        fem.read_file(path)
    path.write_text(text.replace("2023-10-25 00:00", "25th at midnight"), "utf-8")
    with pytest.raises(ValueError, match="give --time-format"):
        fem.read_file(path)


@pytest.mark.parametrize("sep", [",", ";", "\t", "|"])
@pytest.mark.parametrize("decimal", [".", ","])
@pytest.mark.parametrize("lines", [0, 1, 5])
def test_a_layout_is_found_as_it_was_written(sep, decimal, lines, record, tmp_path):
    path = tmp_path / "plant.csv"
    table = record.iloc[:100].to_csv(sep=sep, decimal=decimal, index_label="time")
    path.write_text("a line, of words; and signs\n" * lines + table, "utf-8")
    found, units = found_layout(path)
    assert found == Layout(sep=sep, decimal=decimal, skip_rows=lines) and units == {}


def test_what_is_written_is_whole_or_not_there(tmp_path):
    path = tmp_path / "fit.json"
    path.write_text("as it was", "utf-8")
    with pytest.raises(OSError, match="full"), replacing(path) as whole:
        whole.write_text("half", "utf-8")
        raise OSError("the disk is full")
    assert path.read_text("utf-8") == "as it was"
    assert [entry.name for entry in tmp_path.iterdir()] == ["fit.json"]


@pytest.mark.skipif(os.name == "nt", reason="rights are others there")
def test_what_is_written_keeps_its_rights_and_its_link(tmp_path):
    path, link = tmp_path / "a.json", tmp_path / "b.json"
    path.write_text("old", "utf-8")
    path.chmod(0o640)
    link.symlink_to(path)
    with replacing(link) as whole:
        whole.write_text("new", "utf-8")
    assert link.is_symlink() and path.read_text("utf-8") == "new"
    assert path.stat().st_mode & 0o777 == 0o640


CELLS = st.sampled_from(
    [
        "1",
        "-7,5",
        "2.5e3",
        "2023-06-01 00:10",
        "1.6.2023",
        "00:20",
        "x",
        "",
        "---",
        "°C",
        "POA",
        "Tamb",
        "WS",
        "Tmod",
        '"',
        "\x00",
        "NaN",
        "inf",
        "1e400",
        "1717200000",
        "202306010010",
    ]
)


@st.composite
def tables(draw):
    """Text that may be a table: mostly as wide in each line, of any cells."""
    width, sep = draw(st.integers(1, 6)), draw(st.sampled_from(",;\t| "))
    row = st.lists(CELLS, min_size=width, max_size=width) | st.lists(CELLS, max_size=6)
    return "\n".join(map(sep.join, draw(st.lists(row, max_size=12))))


@settings(max_examples=30, deadline=None)
@given(text=tables(), suffix=st.sampled_from([".csv", ".csv", ".xlsx", ".parquet"]))
def test_no_file_ends_with_a_traceback(text, suffix, tmp_path_factory):
    path = tmp_path_factory.mktemp("any") / f"any{suffix}"
    path.write_text(text, "utf-8")
    maps = ("--map", "temp_air=Tamb", "--time-format", "unix")
    for arguments in ((), ("--guess",), ("--sep", ";", "--decimal", ","), maps):
        result = call("fit", path, *arguments)
        assert isinstance(result.exception, SystemExit | None), result.exception
        assert result.output.startswith(("Error: ", "Usage: ", "this command"))


def files_of(folder):
    return {entry.name: entry.read_bytes() for entry in folder.iterdir()}


@pytest.mark.parametrize(
    "arguments",
    [
        ("fit", "plant.csv", "--out", "plant.csv"),
        ("fit", "plant.csv", "--plot", "plant.csv"),
        ("fit", "plant.csv", "--out", "./../{folder}/plant.csv"),
        ("fit", "plant.csv", "--out", "link.json"),
        ("fit", "plant.csv", "--out", "other.csv"),
        ("fit", "plant.csv", "--plot", "x"),
        ("fit", "plant.csv", "--plot", "x.nosuch"),
        ("loop", "plant.csv", "--report", "plant.csv"),
        ("loop", "plant.csv", "--report", "a.html", "--out", "a.html"),
        ("fit", "plant.csv", "other.csv", "--out", "other.csv"),
    ],
)
def test_nothing_that_is_there_is_lost(arguments, record, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    record.to_csv("plant.csv")
    record.to_csv("other.csv")
    try:
        (tmp_path / "link.json").symlink_to("plant.csv")
    except OSError:  # Windows without the right to
        (tmp_path / "link.json").hardlink_to("plant.csv")
    before = files_of(tmp_path)
    result = call(*(text.format(folder=tmp_path.name) for text in arguments))
    assert result.exit_code == 1, result.output
    assert len(result.output.splitlines()) == 1
    assert files_of(tmp_path) == before


def test_what_cannot_be_written_is_refused_before_the_work(
    record, tmp_path, monkeypatch
):
    def never(*arguments, **options):
        raise AssertionError("it was read")

    monkeypatch.setattr("pvlib_fem._cli.read_records.frame", never)
    record.to_csv(tmp_path / "plant.csv")
    for option in ("--plot x.nosuch", "--out a/b.json", "--effects nosuch"):
        result = call("fit", tmp_path / "plant.csv", *option.split())
        assert result.exit_code == 1 and "it was read" not in result.output


def test_the_months_of_one_logger_are_one_record(record, tmp_path):
    """In whatever order they come; overlaps and missing columns are named."""
    from pvlib_fem._record.layout import Layout
    from pvlib_fem._record.logger_files import frame

    third = len(record) // 3
    parts = [record[:third], record[third : 2 * third], record[2 * third :]]
    paths = [tmp_path / f"{name}.csv" for name in ("may", "june", "july")]
    for part, path in zip(parts, paths):
        part.to_csv(path)
    whole = tmp_path / "whole.csv"
    record.to_csv(whole)
    found = frame([[paths[2], paths[0], paths[1]]], [Layout()], {})
    pd.testing.assert_frame_equal(found, frame([whole], [Layout()], {}))
    record[third - 5 : 2 * third].to_csv(paths[1])
    with pytest.raises(ValueError, match=r"june\.csv begins at .* before may\.csv"):
        frame([paths], [Layout()], {})
    sorted_ = frame([paths], [Layout(sort=True, drop_doubled=True)], {})
    pd.testing.assert_frame_equal(sorted_, found)
    parts[1].drop(columns="wind_speed").to_csv(paths[1])
    with pytest.raises(ValueError, match="has no column wind_speed"):
        frame([paths], [Layout()], {})


def test_a_small_file_that_swells_is_refused_before_it_does(tmp_path):
    line = b"2024-01-01 00:00,0,0,0,0\n"
    path = tmp_path / "plant.csv.gz"
    path.write_bytes(gzip.compress(b"time,a,b,c,d\n" + line * 400_000, 9))
    with pytest.raises(
        ValueError, match=r"plant\.csv\.gz has .* unpacks to 10,000,013"
    ):
        fem.read_file(path)
    book = openpyxl.Workbook()
    book.active["A1"] = book.active["XFD1048576"] = 1
    book.save(tmp_path / "plant.xlsx")
    with pytest.raises(ValueError, match="reaches to row 1,048,576 and column 16,384"):
        fem.read_file(tmp_path / "plant.xlsx")


def test_a_packed_record_is_read_as_it_is(tmp_path):
    data = datasets.synthetic(8, 600.0, seed=2)
    data.to_csv(tmp_path / "plant.csv", index_label="time")
    data.to_csv(tmp_path / "plant.csv.gz", index_label="time")
    plain, packed = (fem.read_file(tmp_path / n) for n in ("plant.csv", "plant.csv.gz"))
    pd.testing.assert_frame_equal(packed, plain)
