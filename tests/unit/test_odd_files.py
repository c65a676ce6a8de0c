"""Files as portals, historians and scripts write them: each opens as is proposed."""

from itertools import pairwise

import numpy as np
import pandas as pd
import pytest
from conftest import call, proposed

import pvlib_fem as fem
from pvlib_fem import simulator
from pvlib_fem._record.column_names import COLUMNS
from pvlib_fem._record.layout import Layout, found_layout
from pvlib_fem._record.months import in_english
from pvlib_fem._record.names import usual_name
from pvlib_fem._record.numbers import marks_of
from pvlib_fem._record.time_formats import zones_of

HOUR, DAY = pd.Timedelta(hours=1), pd.Timedelta(days=1)
SPANISH = {5: "may"}
MODULES = ("temp_module", "temp_module_2", "temp_module_3")


@pytest.fixture(scope="module")
def plant():
    """Twenty days at 10 min with three module sensors, without a zone."""
    data = simulator.record(days=20, step=600, start="2023-05-01", seed=5)
    data = data[list(COLUMNS)].tz_localize(None)
    rng = np.random.default_rng(1)
    for name, offset in zip(MODULES[1:], (0.4, -0.3)):
        noise = rng.normal(0.0, 0.1, len(data))
        data[name] = data["temp_module"] + offset + noise
    return data.round(2)


def called(data, *names):
    """Columns under names of their own, in the order of the data."""
    return data.set_axis(list(names), axis=1)


def portal(data, path):
    """UTF-16, semicolons to the end of each line, decimal commas, km/h, in German."""
    data = data.assign(wind_speed=(3.6 * data["wind_speed"]).round(2))
    names = "Einstrahlung Modulebene [W/m²]", "Außentemperatur [°C]"
    names += ("Windgeschwindigkeit [km/h]",)
    data = called(data, *names, *(f"Modultemperatur {n} [°C]" for n in (1, 2, 3)))
    data = data.set_axis(data.index.strftime("%d.%m.%Y %H:%M:%S"))
    text = data.to_csv(sep=";", decimal=",", index_label="Datum").replace("\n", ";\n")
    path.write_text("Anlage;;;;;;;;\n" + text, "utf-16")


def historian(data, path):
    """A row for each reading."""
    tags = "MET.POA_IRR", "MET.AMB_TEMP", "MET.WIND_SPD"
    data = called(data, *tags, *(f"ARR{n}.MOD_TEMP" for n in (1, 2, 3)))
    rows = data.rename_axis("Timestamp").melt(
        var_name="Tag", value_name="Value", ignore_index=False
    )
    rows.assign(Quality="Good").sort_index(kind="stable").to_csv(path)


def dates_once(data, path):
    """The date in the first row of each day alone."""
    first = ~pd.Series(data.index.date).duplicated().to_numpy()
    date, time = data.index.strftime("%d/%m/%Y"), data.index.strftime("%H:%M")
    data = called(data, "Irr (W/m2)", "Tamb", "Wind", "TC1", "TC2", "TC3")
    data.insert(0, "Date", np.where(first, date, ""))
    data.insert(1, "Time", time)
    data.to_csv(path, index=False)


def of_a_script(data, path):
    """Spaces between columns, days since the year 0, and lines that begin with #."""
    days = (data.index - pd.Timestamp("1970-01-01")) / pd.Timedelta(days=1) + 719529
    rows = np.column_stack([days, data])
    head = "station 4, values each 10 min\ndatenum G Ta ws Tm1 Tm2 Tm3"
    np.savetxt(path, rows, fmt=["%.8f"] + 6 * ["%8.2f"], header=head)


def in_spanish(data, path):
    """Months in another language, half days with full stops, and marked values."""
    clock = [
        f"{t.day} {SPANISH[t.month]} {t.year} {t.hour % 12 or 12}:{t.minute:02d} "
        f"{'a.m.' if t.hour < 12 else 'p.m.'}"
        for t in data.index
    ]
    names = "Irradiancia inclinada", "Temp. ambiente", "Vel. viento"
    data = called(data, *names, *(f"Temp. módulo {n}" for n in (1, 2, 3)))
    marked = data.astype(str)
    marked.iloc[::50, 1] += "*"
    marked.iloc[7::60, 3] += " *"
    marked.set_axis(clock).to_csv(path, index_label="Fecha")


def in_french(data, path):
    """The date and such as 14h30 in two columns, accents of Windows, km/h."""
    data = data.assign(wind_speed=(3.6 * data["wind_speed"]).round(2))
    names = "Éclairement plan modules (W/m²)", "Temp. extérieure (°C)"
    names += ("Vitesse du vent (km/h)",)
    data = called(data, *names, *(f"Temp. panneau {n} (°C)" for n in (1, 2, 3)))
    data.insert(0, "Date", data.index.strftime("%d/%m/%Y"))
    data.insert(1, "Heure", data.index.strftime("%Hh%M"))
    data.to_csv(path, sep=";", decimal=",", index=False, encoding="cp1252")


def in_japanese(data, path):
    """Names in the encoding of Windows in Japan."""
    data = called(
        data,
        "傾斜面日射量",
        "外気温",
        "風速",
        *(f"モジュール温度{n}" for n in (1, 2, 3)),
    )
    data.to_csv(path, index_label="日時", encoding="cp932")


def in_turkish(data, path):
    """Names in the encoding of Windows in Turkey."""
    names = "Işınım (W/m²)", "Hava sıcaklığı (°C)", "Rüzgar hızı (m/s)"
    data = called(data, *names, *(f"Modül sıcaklığı {n} (°C)" for n in (1, 2, 3)))
    how = dict(index_label="Tarih", sep=";", decimal=",", encoding="cp1254")
    data.set_axis(data.index.strftime("%d.%m.%Y %H:%M")).to_csv(path, **how)


def with_infinities(data, path):
    """What a logger writes where it divides by nothing."""
    data = called(data, "G", "Ta", "ws", "Tm1", "Tm2", "Tm3").astype(str)
    data.iloc[::50, 1] = "INF"
    data.iloc[7::60, 3] = "-INF"
    data.to_csv(path, index_label="TIMESTAMP")


FILES = {
    in_japanese: {"--encoding": "cp932"},
    in_turkish: {"--encoding": "cp1254", "--decimal": ","},
    with_infinities: {"--missing": "-INF"},
    in_french: {"--time": "Date,Heure", "--time-format": "%d/%m/%Y %Hh%M"},
    portal: {"--encoding": "utf-16", "--decimal": ",", "--skip-rows": "1"},
    historian: {"--tag": "Tag", "--value": "Value"},
    dates_once: {"--time": "Date,Time", "--time-format": "%d/%m/%Y %H:%M"},
    of_a_script: {"--time-format": "matlab", "--sep": " ", "--skip-rows": "1"},
    in_spanish: {"--time-format": "%d %b %Y %I:%M %p", "--missing": "*"},
}


@pytest.mark.parametrize("form", FILES, ids=lambda form: form.__name__)
def test_an_odd_file_opens_as_it_is_proposed(form, plant, tmp_path):
    form(plant, path := tmp_path / "plant.csv")
    guessed = call("modules", path, "--guess")
    assert guessed.exit_code == 0, guessed.output
    words = proposed(guessed)
    told = dict(pairwise(words))
    assert {option: told[option] for option in FILES[form]} == FILES[form]
    maps = [word for flag, word in pairwise(words) if flag == "--map"]
    assert [word.partition("=")[0] for word in maps if word[:5] == "temp_"] == [
        *("temp_module", "temp_air", "temp_module_2", "temp_module_3")
    ]
    compared = call(*words)
    assert compared.exit_code == 0 and "3 module sensors" in compared.output
    # the same options, on another command, read what was measured
    cleaned = tmp_path / "cleaned.csv"
    shown = call("screen", *words[1:], "--cleaned", cleaned)
    assert shown.exit_code == 0 and f"{len(plant):,} rows" in shown.output
    read = fem.read_file(cleaned)
    for name in plant:
        there = read[name].notna()
        assert there.mean() > 0.97
        want = plant[name].clip(lower=0.0) if name == "poa_global" else plant[name]
        assert read[name][there].to_numpy() == pytest.approx(want[there], abs=0.01)
    assert (read.index == plant.index).all()


def test_dates_that_are_filled_in_are_counted(plant, tmp_path):
    dates_once(plant, path := tmp_path / "plant.csv")
    how = dict(time=("Date", "Time"), time_format="%d/%m/%Y %H:%M")
    data = fem.read_file(path, **how)
    rows = len(plant) - 20
    assert any(f"taken for the rows below: {rows:,}" in n for n in data.attrs["notes"])


def test_rows_of_readings_keep_the_order_of_the_file(plant, tmp_path):
    """A date and a time of day, which as texts are in another order."""
    data = plant["2023-05-19":].set_axis(plant["2023-05-19":].index + 12 * DAY)
    clock = {
        "Date": data.index.strftime("%d/%m/%Y"),
        "Time": data.index.strftime("%H:%M"),
    }
    rows = data[list(COLUMNS)].assign(**clock).melt(["Date", "Time"], var_name="what")
    rows.to_csv(path := tmp_path / "plant.csv", index=False)
    how = dict(time=("Date", "Time"), time_format="%d/%m/%Y %H:%M")
    read = fem.read_file(path, **how, tag="what", value="value")
    assert (read.index == data.index).all() and [*read] == list(COLUMNS)
    np.testing.assert_array_equal(read, data[list(COLUMNS)])


def test_readings_that_are_not_good_and_times_of_their_own_are_told(plant, tmp_path):
    historian(plant, path := tmp_path / "plant.csv")
    rows = pd.read_csv(path)
    mixed = rows.assign(Kind=np.where(rows.index % 90, "spot", "mean"))
    mixed.to_csv(path, index=False)
    shown = call("fit", path).output
    assert "any 'Kind' are taken, 'spot' and 'mean'" in shown
    assert "--keep Kind=spot leaves out all but these" in shown
    tags = rows["Tag"].astype("category").cat.codes
    own = pd.to_datetime(rows["Timestamp"]) + pd.to_timedelta(tags, unit="s")
    rows.assign(Timestamp=own).to_csv(path, index=False)
    with pytest.raises(ValueError, match=r"times of their own.*a file for each tag"):
        fem.read_file(path, tag="Tag", value="Value")
    pd.concat([rows, rows.iloc[[9, 9]]]).to_csv(path, index=False)
    with pytest.raises(ValueError, match=r"has a second reading at 2023-.*2 are"):
        fem.read_file(path, tag="Tag", value="Value")
    with pytest.raises(ValueError, match="no column 'Point' to make columns of"):
        fem.read_file(path, tag="Point", value="Value")
    with pytest.raises(ValueError, match="'Tag' is given for the times, and for the"):
        fem.read_file(path, tag="Tag", value="Value", time="Tag")


@pytest.mark.parametrize("first", ["Timestamp", "Tag"])
@pytest.mark.parametrize(
    ("good", "bad", "instead"), [("Good", "Bad", "I/O Timeout"), (192, 0, 0.0)]
)
def test_readings_of_bad_quality_are_left_out(
    good, bad, instead, first, plant, tmp_path
):
    """By the proposed command and from Python, as if they were not in the file."""
    historian(plant, path := tmp_path / "plant.csv")
    rows = pd.read_csv(path)
    fails = rows.index % 90 == 0
    rows["Quality"] = np.where(fails, bad, good)
    rows["Value"] = rows["Value"].astype(object).mask(fails, instead)
    rows = rows[[first, *rows.columns.drop(first)]]
    rows.to_csv(path, index=False)
    words = proposed(call("modules", path, "--guess"))
    assert words[words.index("--keep") + 1] == f"Quality={good}"
    how = dict(tag="Tag", value="Value")
    read = fem.read_file(path, **how, keep=f"Quality={good}")
    note = f"rows whose 'Quality' is not '{good}', left out: {fails.sum():,}"
    assert read.attrs["notes"] == [f"plant.csv: {note}"]
    without = rows[~fails].drop(columns="Quality")
    without.to_csv(other := tmp_path / "other.csv", index=False)
    pd.testing.assert_frame_equal(read, fem.read_file(other, **how))
    (note,) = fem.read_file(path, **how).attrs["notes"]
    assert f"--keep Quality={good} leaves them out" in note


@pytest.mark.parametrize(
    ("keep", "words"),
    [
        ("State=run", r"no row has 'run' \(did you mean 'RUN'\?\); there are 'RUN'"),
        ("state=RUN", r"no column 'state' \(did you mean 'State'\?\); there are time"),
        ("RUN", "has to be COLUMN=TEXT"),
    ],
)
def test_rows_to_keep_that_are_not_there_are_refused(keep, words, plant, tmp_path):
    data = plant.assign(State=np.where(plant["poa_global"] > 5.0, "RUN", "STOP"))
    data.to_csv(path := tmp_path / "plant.csv", index_label="time")
    lit = fem.read_file(path, keep=["State=RUN"])
    assert len(lit) == (plant["poa_global"] > 5.0).sum()
    assert len(fem.read_file(path, keep=["State=RUN", "State=STOP"])) == len(plant)
    with pytest.raises(ValueError, match=words):
        fem.read_file(path, keep=keep)


def test_rows_of_a_long_code_are_kept_by_all_of_its_digits(tmp_path):
    lines = ["time,temp_air,Status", "2024-06-01 00:00,1,1073741824"]
    lines += ["2024-06-01 01:00,2,1073741826", "2024-06-01 02:00,3,0"]
    (path := tmp_path / "plant.csv").write_text("\n".join(lines))
    assert [*fem.read_file(path, keep="Status=1073741824")["temp_air"]] == [1]


def test_columns_with_times_of_their_own_are_noted(plant, tmp_path):
    """Read at the times of the rows, they would be off by what only the file shows."""
    later = plant.index + pd.to_timedelta(np.arange(len(plant)) % 50, unit="s")
    data = plant[list(COLUMNS)].assign(module_time=later, utc=plant.index - HOUR)
    data.to_csv(path := tmp_path / "plant.csv", index_label="time")
    result = call("fit", path)
    assert result.exit_code == 0
    assert "'module_time' holds times, too, up to 49 s off" in result.output
    assert "'utc'" not in result.output


@pytest.mark.parametrize(
    ("text", "english"),
    [
        ("1 Mai 2023", "1 May 2023"),
        ("03-Dez-22 10:00", "03-Dec-22 10:00"),
        ("2 févr. 2024", "2 Feb 2024"),
        ("14 août 2023 03:00", "14 Aug 2023 03:00"),
        ("9 giugno 2023", "9 Jun 2023"),
        ("Jan 5, 2023 3:15 p.m.", "Jan 5, 2023 3:15 PM"),
        ("Mon 1 Set 2023 1:00 am", "Mon 1 Sep 2023 1:00 AM"),
    ],
)
def test_months_of_other_languages_are_read(text, english):
    assert in_english(text, whole=False) == english


def test_units_and_words_are_no_marks():
    column = pd.Series(["1.5", "2.5", "3", "7", "4.0*", "5 *", "6?"])
    assert marks_of([column], ".") == ("*", "?")
    assert marks_of([column + " °C"], ".") == ()
    assert marks_of([pd.Series(["1", "2", "calm", "3*"])], ".") == ()
    assert marks_of([column.str.replace(".", "·")], "·") == ("*", "?")


@pytest.mark.parametrize("name", ["poa_direct", "poa_diffuse", "poa_rear_2"])
def test_parts_of_the_light_have_a_unit_and_check_nothing(name, tmp_path):
    data = simulator.record(days=40, step=3600)[list(COLUMNS)]
    path = tmp_path / "plant.csv"
    part = 0.0003 * data["poa_global"] * (1.0 + np.arange(len(data)) % 3)
    data.assign(**{f"{name} (kW/m²)": part}).to_csv(path, index_label="time")
    how = {"columns": {name: f"{name} (kW/m²)"}, "convert_units": True}
    read = fem.read_file(path, **how)
    np.testing.assert_allclose(read[name], 1000.0 * part, rtol=1e-9)
    assert not any("cross-check" in note for note in fem.close_loop(read).notes)
    asked = call("screen", path, "--map", f"{name}={name} (kW/m²)", "--convert")
    assert asked.exit_code == 0, asked.output


@pytest.mark.parametrize("sign", ["", "·", "::"])
def test_a_decimal_sign_that_cannot_be_read_is_refused(sign, tmp_path):
    path = tmp_path / "plant.csv"
    simulator.record(days=1, step=3600)[list(COLUMNS)].to_csv(path, index_label="time")
    with pytest.raises(ValueError, match=rf"--decimal '{sign}'.*one sign of ASCII"):
        fem.read_file(path, decimal=sign)


def test_letters_of_two_zones_are_of_the_first_in_the_file():
    both = pd.Series(["1 May 2023 10:00 IST", "1 May 2023 10:05 CST"])
    assert zones_of(both) == ["Asia/Kolkata", "Europe/Dublin", "Asia/Jerusalem"]
    assert zones_of(both[::-1]) == ["America/Chicago", "Asia/Shanghai"]
    # an empty cell has no letters, and is of any zone
    irish = pd.Series(["1 May 2023 10:00 IST", "", "1 Jan 2023 10:00 GMT"])
    assert zones_of(irish) == ["Europe/Dublin"]


@pytest.mark.parametrize(
    ("header", "name"),
    [
        ("Température module", "temp_module"),
        ("Temperatura esterna", "temp_air"),
        ("Vitesse du vent", "wind_speed"),
        ("Velocidade do vento", "wind_speed"),
        ("Rayonnement incliné", "poa_global"),
        ("Éclairement plan modules (W/m²)", "poa_global"),
        ("Temp. panneau (°C)", "temp_module"),
        ("Thermocouple 3", "temp_module"),
        ("Rückseite Einstrahlung (W/m²)", "poa_rear"),
        ("Einstrahlung_Rueckseite", "poa_rear"),
        ("Ambient [K]", "temp_air"),
        ("Panel (°F)", "temp_module"),
        ("T_m (°C)", "temp_module"),
        ("Ambient light (lux)", None),
        ("PV1.INV.PAC", "power_ac"),
        ("inv2_Pac_kW", "power_ac"),
        ("System Production (W)", "power_ac"),
        ("Erzeugung [kW]", "power_ac"),
        ("Potencia", "power_ac"),
        ("Potência CA (kW)", "power_ac"),
        ("Potencia CC (kW)", "power_dc"),
        ("Puissance AC (W)", "power_ac"),
        ("Potenza [kW]", "power_ac"),
        ("発電電力(kW)", "power_ac"),
        ("直流功率", "power_dc"),
        ("Мощность, кВт", "power_ac"),
        ("Inverter kW", "power_ac"),
        ("P [kW]", "power_ac"),
        ("Export MW", "power_ac"),
        ("Sensor W", None),
        ("Radiación [W]", None),
        ("Load kW", None),
        ("消費電力(kW)", None),
        ("Puissance réactive", None),
        ("Fator de potência", None),
        ("Production (kWh)", None),
        ("Production unit", None),
        ("Pac_limit", None),
        ("Luftdruck G", None),
        ("Event", None),
        ("TC_status", None),
        ("Wind direction (°)", "wind_direction"),
        ("Direction du vent", "wind_direction"),
        ("Dirección del viento (º)", "wind_direction"),
        ("Velocidad del viento", "wind_speed"),
        ("WS10m", "wind_speed"),
        ("Direct irradiance", None),
        ("Radiación directa", None),
        ("Panel Düzlemi Işınımı (W/m²)", "poa_global"),
        ("Yatay Işınım (W/m²)", None),
        ("Ortam Sıcaklığı (°C)", "temp_air"),
        ("Panel Sıcaklığı (°C)", "temp_module"),
        ("Rüzgar Hızı (m/s)", "wind_speed"),
        ("Rüzgar Yönü (°)", "wind_direction"),
        ("Bağıl Nem (%)", "relative_humidity"),
        ("傾斜面日射強度(kW/m2)", "poa_global"),
        ("水平面全天日射量(kW/m2)", None),
        ("傾斜角(°)", None),
        ("外気温度(℃)", "temp_air"),
        ("モジュール温度(℃)", "temp_module"),
        ("風速(m/s)", "wind_speed"),
        ("風向(°)", "wind_direction"),
        ("湿度(%)", "relative_humidity"),
        ("Natężenie promieniowania [W/m2]", "poa_global"),
        ("Promieniowanie poziome [W/m2]", None),
        ("Temperatura powietrza [°C]", "temp_air"),
        ("Temperatura modułu 1 [°C]", "temp_module"),
        ("Prędkość wiatru [m/s]", "wind_speed"),
        ("Kierunek wiatru [°]", "wind_direction"),
        ("Wilgotność [%]", "relative_humidity"),
        ("ff [m/s]", "wind_speed"),
        ("GlobInc", "poa_global"),
        ("GlobHor", None),
    ],
)
def test_headers_of_other_languages_are_known(header, name):
    assert usual_name(header) == name


@pytest.mark.parametrize(
    ("header", "name"),
    [
        ("SWD [W/m**2]", None),  # short-wave, down
        ("Wind [°]", None),
        ("Wind [m/s]", "wind_speed"),
        ("Pyranometer [mV]", None),
        ("Pyranometer [W]", "poa_global"),  # as some write W/m²
        ("Temp [°]", "temp_air"),
    ],
)
def test_a_column_in_a_unit_of_another_quantity_is_none_of_this(header, name):
    assert usual_name(header) == name


def test_a_unit_below_the_header_is_none_of_another_quantity(plant, tmp_path):
    names = "POA", "Ta", "WD10", "TC1", "TC2", "TC3"
    text = called(plant, *names).to_csv(index_label="Time").splitlines()
    text.insert(1, ",W/m2,°C,m/s,°C,°C,°C")
    (path := tmp_path / "plant.csv").write_text("\n".join(text))
    assert "wind_direction=" not in call("loop", path, "--guess").output


@pytest.mark.parametrize(
    ("name", "header", "cell", "value"),
    [
        ("power_ac", "P (mW)", 500.0, 0.5),  # a prefix of the SI: milli
        ("power_ac", "P (MW)", 0.5, 5e5),
        ("power_ac", "p_mw", 0.5, 5e5),  # of a name in small letters
        ("power_ac", "Energy (kWh)", 1.0, 6000.0),  # of ten minutes
        ("poa_global", "Slope (MJ/m²)", 0.6, 1000.0),
        ("poa_global", "Slope (kJ/m2)", 600.0, 1000.0),
    ],
)
def test_a_unit_is_converted_by_its_factor(name, header, cell, value, tmp_path):
    times = pd.date_range("2023-06-01", periods=3, freq="10min", name="Time")
    pd.DataFrame({header: cell}, times).to_csv(path := tmp_path / "plant.csv")
    data = fem.read_file(path, {name: header}, convert_units=True)
    assert data[name].tolist() == pytest.approx([value] * 3)


def test_a_proposal_says_which_part_of_the_place_is_not_given(plant, tmp_path):
    """A loop runs without it, and finds less."""
    plant[list(COLUMNS)].to_csv(path := tmp_path / "plant.csv", index_label="time")
    turned = plant[list(COLUMNS)].assign(surface_tilt=20.0, surface_azimuth=90.0)
    turned.to_csv(other := tmp_path / "turned.csv", index_label="time")

    def not_given(path, *words, command="loop"):
        shown = call(command, path, "--guess", *words).output
        lines = [line for line in shown.splitlines() if "not given" in line]
        return lines[0].partition(";")[0] if lines else ""

    place = ("--lat", 49.4, "--lon", 8.7)
    assert not_given(path) == "- not given: --lat, --lon, --tilt, --azimuth"
    assert not_given(path, *place) == "- not given: --tilt, --azimuth"
    assert not_given(path, *place, "--max-angle", 55) == ""
    assert not_given(other) == "- not given: --lat, --lon"
    assert not_given(other, *place) == ""
    assert not_given(path, command="fit") == ""


def test_the_end_of_each_range_of_times_is_taken(plant, tmp_path):
    """With a date in the end or without, over midnight, from the proposed command."""
    ends = plant.index
    starts = ends - pd.Timedelta(minutes=10)
    day = "%d.%m.%Y "
    written = {
        "short": starts.strftime(day + "%H:%M") + " - " + ends.strftime("%H:%M"),
        "whole": starts.strftime(day + "%H:%M") + " – " + ends.strftime(day + "%H:%M"),
        "words": starts.strftime("%Y-%m-%d %H:%M:%S to ") + ends.strftime("%H:%M:%S"),
    }
    for name, times in written.items():
        path = tmp_path / f"{name}.csv"
        plant[list(COLUMNS)].set_axis(times).to_csv(path, index_label="Period")
        words = proposed(call("fit", path, "--guess"))
        forms = [b for a, b in pairwise(words) if a == "--time-format"]
        read = fem.read_file(path, time_format=(forms or ["ISO8601"])[0])
        assert (read.index == ends).all()
        assert read.attrs["notes"] == [
            f"{name}.csv: times are ranges, as {times[0]!r}: the end of each is taken"
        ]


def test_a_date_and_an_hour_as_numbers_are_proposed(plant, tmp_path):
    data = plant[list(COLUMNS)]
    data.insert(0, "HHMM", data.index.strftime("%H%M"))
    data = data.set_axis(data.index.strftime("%Y%m%d"))
    data.to_csv(path := tmp_path / "plant.csv", index_label="YYYYMMDD")
    words = proposed(call("fit", path, "--guess"))
    assert words[words.index("--time") + 1] == "YYYYMMDD,HHMM"
    form = words[words.index("--time-format") + 1]
    read = fem.read_file(path, time=("YYYYMMDD", "HHMM"), time_format=form)
    assert (read.index == plant.index).all()


@pytest.mark.parametrize(
    ("count", "given"),
    [
        ("unix-ms", "unix"),
        ("unix", "unix-ms"),
        ("excel", "unix"),
        ("matlab", "excel"),
        ("unix", "matlab"),
    ],
)
def test_numbers_of_another_count_are_refused(count, given, plant, tmp_path):
    seconds = plant.index.asi8 // {"ns": 10**9, "us": 10**6}[plant.index.unit]
    starts = {"excel": 25569.0, "matlab": 719529.0}  # of 1970, in days
    numbers = {"unix": seconds, "unix-ms": 1000 * seconds}
    numbers |= {name: start + seconds / 86400.0 for name, start in starts.items()}
    path = tmp_path / "plant.csv"
    plant.set_axis(numbers[count]).to_csv(path, index_label="stamp")
    with pytest.raises(ValueError, match="column 'stamp' holds numbers such as") as no:
        fem.read_file(path, time_format=given)
    assert str(no.value).endswith(f"give --time-format {count}")
    right = fem.read_file(path, time_format=count)
    off = right.index.tz_localize(None) - plant.index
    assert abs(off).max() < pd.Timedelta("0.1s")


def test_a_date_and_an_hour_that_are_empty_are_said_as_they_are(plant, tmp_path):
    date, hour = plant.index.strftime("%Y-%m-%d"), plant.index.strftime("%H:%M")
    table = plant.assign(Date=date, Time=hour).reset_index(drop=True)
    table.loc[0, ["Date", "Time"]] = None
    table.to_csv(tmp_path / "plant.csv", index=False)
    with pytest.raises(ValueError, match="row 0: an empty cell and an empty cell;"):
        fem.read_file(tmp_path / "plant.csv", time=("Date", "Time"))


def test_a_count_beyond_the_calendar_is_no_time(plant, tmp_path):
    seconds = (plant.index - pd.Timestamp("1970-01-01")) // pd.Timedelta("1s")
    for bad in (10**12, 10**18):
        path = tmp_path / "plant.csv"
        odd = np.where(np.arange(len(plant)) == 7, bad, seconds)
        plant.set_axis(odd).to_csv(path, index_label="stamp")
        with pytest.raises(ValueError, match=rf"no time .* in row 7: '{bad}'"):
            fem.read_file(path, time_format="unix")


def as_sheet_reads(index, first="%d/%m/%Y"):
    """Texts of which a sheet makes dates, of days as months, where there is such."""
    return [
        t.replace(month=t.day, day=t.month)
        if t.day <= 12
        else t.strftime(f"{first} %H:%M")
        for t in index.to_pydatetime()
    ]


@pytest.mark.parametrize("parts", [1, 2])
def test_a_sheet_that_took_days_for_months_is_refused(parts, plant, tmp_path):
    """Half of the rows would get a date of another month."""
    hourly = plant[::6]  # from 1 to 20 May, of which eight days are after the 12th
    data = pd.concat([hourly[: 8 * 24], hourly[12 * 24 :]])
    cells = as_sheet_reads(data.index)
    data.insert(0, "Date", cells)
    if parts == 2:
        days = [c.date() if not isinstance(c, str) else c.split()[0] for c in cells]
        data["Date"] = pd.Series(days, data.index, dtype=object)
        data.insert(1, "Hour", data.index.strftime("%H:%M"))
    path = tmp_path / "plant.xlsx"
    data.to_excel(path, index=False)
    with pytest.raises(ValueError, match="day and month are exchanged") as no:
        time = ("Date", "Hour")[:parts]
        fem.read_file(path, time=time, time_format="%d/%m/%Y %H:%M")
    words = str(no.value)
    assert "column 'Date' holds dates in 192 rows and text in 192" in words
    assert "the first is row 0, '2023-01-05" in words and "'2023-05-01" in words
    assert words.endswith("import it into the sheet anew with this column as text")
    result = call("loop", path, "--guess")
    assert result.exit_code == 1 and "day and month are exchanged" in result.output


def test_dates_beside_texts_are_refused_and_words_beside_dates_are_not(plant, tmp_path):
    hourly, path = plant[::6], tmp_path / "plant.xlsx"
    cells = [*hourly.index.to_pydatetime()]
    odd = [*cells[:-9], *hourly.index[-9:].strftime("%d/%m/%Y %H:%M")]
    hourly.assign(t=odd).to_excel(path, index=False)
    with pytest.raises(ValueError, match="text in 9, such as '20/05") as no:
        fem.read_file(path, time="t", time_format="%d/%m/%Y %H:%M")
    assert "exchanged" not in str(no.value)
    hourly.assign(t=[*cells[:-1], "Mean of 2023"]).to_excel(path, index=False)
    with pytest.raises(ValueError, match="give --skip-end 1"):
        fem.read_file(path, time="t")


def test_a_given_encoding_is_used_where_the_bytes_can_be_that(plant, tmp_path):
    path = tmp_path / "plant.csv"
    table = plant.rename(columns={"temp_module_2": "気温(℃)"})
    table.to_csv(path, index_label="日時", encoding="cp932")
    found, _ = found_layout(path, Layout(encoding="cp932"))
    assert found.encoding == "cp932" and found.sep == ","
    given = call("loop", path, "--guess", "--encoding", "cp932")
    assert "--encoding cp932" in given.output
    assert "--encoding cp932" in call("loop", path, "--guess").output
    table.rename(columns={"気温(℃)": "℃"}).to_csv(
        path, index_label="日時", encoding="cp932"
    )
    other = call("loop", path, "--guess")
    assert "plant.csv is not in cp1252" in other.output
    table.to_csv(path, index_label="日時")
    assert found_layout(path, Layout(encoding="cp1252"))[0].encoding == "utf-8"
    plant.to_csv(path, index_label="time")
    assert found_layout(path, Layout(encoding="cp932"))[0].encoding == "cp932"


def test_options_of_lines_are_arguments_of_their_names(plant, tmp_path):
    path = tmp_path / "plant.csv"
    head, *rows = plant.to_csv(index_label="time").splitlines(keepends=True)
    path.write_text("".join([head, ",W/m2,C,m/s,C,C,C\n", *rows]))
    right = fem.read_file(path, skip_rows=[1])
    for lines in (1, [1]):
        pd.testing.assert_frame_equal(fem.read_file(path, skip_lines=lines), right)
    with pytest.raises(ValueError, match="skip_rows and skip_lines are both given"):
        fem.read_file(path, skip_lines=1, skip_rows=1)
    with pytest.raises(TypeError, match=r"no argument 'seperator'.*, sep, decimal"):
        fem.read_file(path, seperator=";")


def test_counted_times_in_the_first_column_are_found_by_their_numbers(plant, tmp_path):
    path = tmp_path / "plant.csv"
    seconds = (plant.index - pd.Timestamp("1970-01-01")) // pd.Timedelta("1s")
    plant.set_axis(seconds).to_csv(path, index_label="t")
    assert "--time-format unix" in call("loop", path, "--guess").output
    plant.set_axis(np.arange(len(plant))).to_csv(path, index_label="t")
    result = call("loop", path, "--guess")
    assert result.exit_code == 1
    assert (
        "no command is found that reads plant.csv: column 't' should" in result.output
    )


def test_a_counter_is_listed_as_one(plant, tmp_path):
    """It is no column of power, whatever its unit."""
    data = plant[list(COLUMNS)].assign(power_ac=plant["poa_global"].clip(lower=0.0))
    data["Lifetime (Wh)"] = data["power_ac"].cumsum()
    data["door opened"] = 1.0 * (np.arange(len(data)) > 100)
    data.to_csv(path := tmp_path / "plant.csv", index_label="time")
    shown = call("loop", path, "--guess").output
    assert "- not mapped, a counter, since it never falls: 'Lifetime (Wh)'" in shown
    assert "- not mapped, no known name: 'door opened'" in shown


def test_a_file_is_screened_by_a_command(plant, tmp_path):
    data = plant[list(COLUMNS)].copy()
    data.iloc[10:13, 1] = -999.0
    data.to_csv(path := tmp_path / "plant.csv", index_label="time")
    shown = call("screen", path)
    assert shown.exit_code == 0
    assert "temp_air holds the fill value -999 in 3 rows" in shown.output
    refused = call("screen", path, "--cleaned", path)
    assert refused.exit_code == 1 and "would overwrite" in refused.output


def test_a_line_with_too_many_columns_is_named_and_can_be_left_out(plant, tmp_path):
    """In a long record nobody finds it by eye."""
    path = tmp_path / "log.csv"
    plant.to_csv(path, index_label="time")
    lines = path.read_text().splitlines()
    lines[1000] += ",9"
    path.write_text("\n".join(lines))
    said = r"line 1001 has 8 columns, and those before it 7; give --skip-lines 1000"
    with pytest.raises(ValueError, match=said):
        fem.read_file(path)
    read = fem.read_file(path, skip_lines=1000)
    assert len(read) == len(plant) - 1 and plant.index[999] not in read.index
