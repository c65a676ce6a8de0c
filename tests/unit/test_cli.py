"""The command, as it is called: output, files and exit codes."""

import io
import json
import re
import runpy
import shlex
import subprocess
import sys
from pathlib import Path

import click
import numpy as np
import pandas as pd
import pytest
from conftest import call
from pvlib.location import Location

from pvlib_fem import (
    DynamicCellTemperature,
    FemFit,
    Loop,
    __version__,
    _cli as cli,
    datasets,
    fit_fem,
    read_file,
    simulator,
)
from pvlib_fem._cli import COMMANDS, commands
from pvlib_fem._cli.demo import HIDDEN, demo_years
from pvlib_fem._cli.proposal import LOOK
from pvlib_fem._loop.close import close_loop
from pvlib_fem._record.column_names import COLUMNS
from pvlib_fem.datasets._download import fetch
from pvlib_fem.drivers._record_site import location


@pytest.fixture(scope="module")
def frame():
    return datasets.synthetic(8, 300, seed=2).tz_localize(None)


@pytest.fixture
def logger(frame, tmp_path):
    """A file with names of its own and a column that is none of ours."""
    renamed = frame.rename(columns={"poa_global": "Irr", "temp_module": "Tmod [C]"})
    path = tmp_path / "logger.csv"
    renamed.assign(note="ok").to_csv(path, index_label="Timestamp")
    return path


MAP = ("--map", "poa_global=Irr", "--map", "temp_module=Tmod [C]")


def test_the_list_of_commands_tells_what_each_of_them_tells():
    shown = " ".join(call("--help").output.split())
    of_module = [c for c in vars(commands).values() if isinstance(c, click.Command)]
    assert {command.name for command in of_module} == {*COMMANDS}
    for command in of_module:
        told = COMMANDS[command.name]
        assert " ".join(command.help.split()).startswith(told)
        assert f"{command.name} {told}" in shown


@pytest.mark.parametrize("asked", ["import pvlib_fem", "import pvlib_fem._cli"])
def test_nothing_is_loaded_before_it_is_used(asked):
    script = f"import sys; {asked}; print(*sys.modules)"
    run = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert not {"numpy", "pandas", "pvlib", "scipy"} & {*run.stdout.split()}
    assert "pvlib_fem" in run.stdout.split()


def test_a_logger_file_gives_the_report(logger, tmp_path):
    out, picture = tmp_path / "fit.json", tmp_path / "fit.png"
    result = call("fit", logger, *MAP, "--out", out, "--plot", picture)
    assert result.exit_code == 0, result.output
    assert result.output.startswith("pvlib_fem: wm1, ewm, least_squares\n2,304 rows")
    fit = json.loads(out.read_text(encoding="utf-8"))
    shown = re.search(r"^tau +(\S+)", result.output, re.MULTILINE)[1]
    assert float(shown) == pytest.approx(fit["coefficients"]["tau"], rel=1e-4)
    model = DynamicCellTemperature.from_json(out)
    assert model.coefficients == fit["coefficients"]
    assert picture.stat().st_size > 10_000


def test_every_option_reaches_the_fit(logger):
    result = call(
        "fit",
        logger,
        *MAP,
        "--model",
        "faiman",
        "--dynamics",
        "balance",
        "--tz",
        "Etc/GMT+7",
    )
    assert result.exit_code == 0, result.output
    assert "pvlib_fem: faiman, balance, least_squares" in result.output
    paper = call("fit", logger, *MAP, "--method", "paper", "--calm-wind", "1.5")
    assert "decreases as the true time constant" in paper.output


def test_parquet_and_csv_give_the_same(frame, logger, tmp_path):
    path = tmp_path / "logger.parquet"
    pd.read_csv(logger, index_col=0, parse_dates=True).to_parquet(path)
    assert call("fit", path, *MAP).output == call("fit", logger, *MAP).output


@pytest.mark.parametrize("zone", [None, "Europe/Brussels"])
def test_the_zone_changes_the_days_and_not_the_instants(frame, tmp_path, zone):
    path = tmp_path / "utc.csv"
    frame.tz_localize("UTC").to_csv(path)
    data = read_file(path, tz=zone)
    assert str(data.index.tz) == (zone or "UTC")
    assert (data.index == frame.index.tz_localize("UTC")).all()


def test_offsets_that_change_are_read_as_instants(frame, tmp_path):
    """A logger that writes local time with its offset, over a change of the clock."""
    utc = pd.date_range("2024-03-31 00:00", periods=4, freq="30min", tz="UTC")
    path = tmp_path / "dst.csv"
    local = pd.Series(1.0, utc.tz_convert("Europe/Brussels"))
    local.to_csv(path)
    assert path.read_text().count("+02:00") == 2
    assert (read_file(path, tz="Europe/Brussels").index == utc).all()


def test_other_formats_of_time_are_given_and_not_guessed(frame, tmp_path):
    path = tmp_path / "european.csv"
    frame.set_axis(frame.index.strftime("%d/%m/%Y %H:%M")).to_csv(path)
    refused = call("fit", path)
    assert refused.exit_code == 1
    assert (
        "holds no time of the format ISO8601 in row 0: '01/06/2023 00:00'; give "
        in (refused.output)
    )
    accepted = call("fit", path, "--time-format", "%d/%m/%Y %H:%M")
    assert accepted.exit_code == 0
    assert "2023-06-01 to 2023-06-08" in accepted.output


def test_a_european_file(frame, tmp_path):
    """Semicolons, decimal commas and a day first."""
    path = tmp_path / "european.csv"
    european = frame.set_axis(frame.index.strftime("%d.%m.%Y %H:%M"))
    european.to_csv(path, sep=";", decimal=",")
    assert "give --sep, such as ';'" in call("fit", path).output
    format_ = ("--time-format", "%d.%m.%Y %H:%M")
    result = call("fit", path, "--sep", ";", "--decimal", ",", *format_)
    assert result.exit_code == 0, result.output
    assert "2,304 rows, 2023-06-01 to 2023-06-08" in result.output


def test_a_toa5_file(day):
    """The logger's own file, with four lines of heading."""
    file = fetch("MET_2015_11_11.dat")
    columns = ("Global_Wm2_Avg", "Temp_C_Avg", "WS_ms_Mean", "Panel_Temp_C_Avg")
    names = ("poa_global", "temp_air", "wind_speed", "temp_module")
    maps = [f"--map={name}={column}" for name, column in zip(names, columns)]
    toa5 = ("--skip-rows", "0,2,3", "--time-format", "%m/%d/%Y %H:%M")
    result = call("fit", file, *toa5, *maps)
    assert result.exit_code == 0, result.output
    assert result.output.splitlines()[1].startswith("1,351 rows, 2015-11-11")


@pytest.mark.parametrize(
    ("spoil", "arguments", "message"),
    [
        (lambda d: d, (), "no column poa_global, temp_module among ghi, dni"),
        (lambda d: d, ("--map", "poa_global=G"), "logger.csv has no column G; it has"),
        (lambda d: d.iloc[::-1], MAP, "is not sorted"),
        (lambda d: d.assign(Irr="x"), MAP, "poa_global holds 'x' at"),
        (
            lambda d: d.assign(wind_speed=3.6 * d["wind_speed"]),
            MAP,
            "wind_speed looks to be in km/h",
        ),
        (lambda d: d, (*MAP, "--tz", "Mars/Crater"), "--tz Mars/Crater: "),
        (lambda d: d, (*MAP, "--method", "paper"), "r_eq,max needs 20 points"),
        (
            lambda d: d,
            (*MAP, "--time", "wind_speed"),
            "column 'wind_speed' should hold the times and holds numbers",
        ),
    ],
)
def test_bad_data_end_with_one_line_and_exit_code_1(logger, spoil, arguments, message):
    spoil(pd.read_csv(logger, index_col=0)).to_csv(logger, index_label="Timestamp")
    result = call("fit", logger, *arguments)
    assert result.exit_code == 1
    said, *proposed = result.output.splitlines()
    assert said.startswith("Error: ")
    assert message in said
    assert not proposed or proposed[1] == LOOK


@pytest.mark.parametrize(
    "arguments",
    [
        ("fit",),
        ("fit", "no such file.csv"),
        ("fit", __file__, "--model", "wm3"),
        ("fit", __file__, "--map", "poa_global"),
        ("fit", __file__, "--map", "rain=Irr"),
        ("fit", __file__, "--skip-rows", "two"),
        ("fit", __file__, "--skip-rows", "-2"),
        ("fit", __file__, "--map", "temp_air=a", "--map", "temp_air=b"),
        ("fit", __file__, "--map", "temp_air=a", "--map", "temp_module=a"),
        ("fit", __file__, "--map", "time=a"),
        ("fit", __file__, "--unit", "wind_speed=furlong"),
        ("fit", __file__, "--unit", "time=h"),
        ("fit", __file__, "--fix", "tau"),
        ("fit", __file__, "--fix", "tau=long"),
        ("fit", __file__, "--fix", "tau=1", "--fix", "tau=2"),
        ("fit", __file__, "--sep", ";", "--sep", ","),
        ("fit", __file__, "--decimal", ".."),
        ("loop",),
        ("loop", __file__, "--model", "wm3"),
        ("loop", __file__, "--map", "snow=Irr"),
        ("loop", __file__, "--lat", "95", "--lon", "8"),
        ("demo", "--days", "0"),
        ("demo", "--days", "1000000"),
        ("demo", "--days", "3000", "--step", "1"),
        ("forecast",),
    ],
)
def test_wrong_usage_ends_with_exit_code_2(arguments):
    assert call(*arguments).exit_code == 2


def test_a_unit_can_be_insisted_on(logger):
    data = pd.read_csv(logger, index_col=0)
    data.assign(wind_speed=3.6 * data["wind_speed"]).to_csv(logger)
    assert call("fit", logger, *MAP, "--no-unit-check").exit_code == 0


@pytest.fixture(scope="module")
def plant():
    """Four months with a cold sky, as a logger has them, and their site."""
    site = simulator.ALBUQUERQUE
    effects = simulator.PHYSICS | {"sky_radiation": 1.0}
    data = simulator.record(site, effects, days=120, step=900, seed=1)
    return data.drop(columns=["snow_depth"]).tz_localize(None), site


@pytest.fixture
def plant_file(plant, tmp_path):
    path = tmp_path / "plant.csv"
    names = {"longwave_down": "LW", "wind_direction": "WD", "temp_module": "T<1>"}
    plant[0].rename(columns=names).assign(state="ok").to_csv(path)
    return path


PLANT = [f"--map={n}" for n in ("longwave_down=LW", "wind_direction=WD")]
PLANT += ["--map=temp_module=T<1>"]
PLACE = ("--lat", 35.05, "--lon", -106.54, "--tilt", 35, "--azimuth", 180)


def test_the_loop_prints_what_close_loop_finds(plant, plant_file, tmp_path):
    """With other names, a column of text and times without a zone, too."""
    data, site = plant
    out, report = tmp_path / "loop.json", tmp_path / "loop.html"
    files = ("--out", out, "--report", report)
    result = call("loop", plant_file, *PLANT, *PLACE, "--model", "sapm", *files)
    assert result.exit_code == 0, result.output
    place = Location(site.latitude, site.longitude, tz=site.tz)
    found = close_loop(data.assign(state="ok"), "sapm", place, 35.0, 180.0)
    assert "sky_radiation" in found.effects
    assert result.output == f"{found}\n\nwrote {out}\n\nwrote {report}\n"
    assert json.loads(out.read_text(encoding="utf-8"))["findings"]
    page = report.read_text(encoding="utf-8")
    assert page.startswith("<!DOCTYPE html>")
    assert f'<p class="plant">{plant_file.name}</p>' in page
    titled = found.to_html(title="Roof <3>")
    assert "Roof &lt;3&gt;" in titled and "plant.csv" not in titled


def test_a_fit_has_a_page_of_its_own(plant_file, tmp_path):
    report = tmp_path / "fit.html"
    result = call("fit", plant_file, *PLANT, "--report", report, "--title", "Roof <3>")
    assert result.exit_code == 0, result.output
    assert result.output.endswith(f"wrote {report}\n")
    page = report.read_text(encoding="utf-8")
    assert page.startswith("<!DOCTYPE html>") and "Roof &lt;3&gt;" in page


def test_a_gain_can_be_asked_for(plant_file):
    asked = call("loop", plant_file, *PLANT, "--min-rmse-reduction", 50)
    assert asked.exit_code == 0
    assert "\n+ wind_direction" not in asked.output and "identified" not in asked.output


def test_a_pipe_hears_no_progress_and_a_terminal_does(plant_file, capsys, monkeypatch):
    arguments = ["loop", str(plant_file), *PLANT]
    cli.main(arguments, standalone_mode=False)
    assert capsys.readouterr().err == ""
    terminal = io.StringIO()
    terminal.isatty = lambda: True
    monkeypatch.setattr(sys, "stderr", terminal)
    cli.main(arguments, standalone_mode=False)
    assert "fitting the model without effects" in terminal.getvalue()
    assert terminal.getvalue().endswith("\r")  # nothing stays


@pytest.mark.parametrize(
    ("index", "tz"),
    [
        (pd.DatetimeIndex(["2024-01-01"]), "Etc/GMT+7"),  # local standard time
        (pd.DatetimeIndex(["2024-01-01"], tz="America/Denver"), "America/Denver"),
        (pd.DatetimeIndex(["2024-01-01T00:00-07:00"]), "UTC"),  # instants say it all
    ],
)
def test_a_place_has_the_zone_of_the_record(index, tz):
    assert str(location(index, 35.05, -106.54).tz) == tz


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--lat", 35), "--lat needs --lon, too"),
        (("--lon", 8), "--lon needs --lat, too"),
        (("--tilt", 35), "--tilt needs --azimuth, too"),
        (("--azimuth", 180), "--azimuth needs --tilt, too"),
        (("--out", "nowhere/loop.json"), "there is no folder nowhere for loop.json"),
        (("--report", "nowhere/a.html"), "there is no folder nowhere for a.html"),
        (("--map", "wind_direction=Dir"), "plant.csv has no column Dir; it has"),
        ((), "no column temp_module among"),
    ],
)
def test_a_loop_that_cannot_be_ends_with_one_line(plant_file, arguments, message):
    result = call("loop", plant_file, *arguments)
    assert result.exit_code == 1
    said, *proposed = result.output.splitlines()
    assert said.startswith("Error: ")
    assert message in said
    assert not proposed or proposed[1] == LOOK


def test_a_report_without_matplotlib_is_refused_before_the_work(
    plant_file, monkeypatch
):
    monkeypatch.setattr("pvlib_fem._cli.output_files.find_spec", lambda name: None)
    result = call("loop", plant_file, *PLANT, "--report", "a.html")
    assert result.exit_code == 1
    assert "pip install 'pvlib_fem[plot]'" in result.output


def test_missing_values_as_a_campbell_logger_writes_them(plant, tmp_path):
    path = tmp_path / "toa5.csv"
    plant[0].assign(wind_speed=plant[0]["wind_speed"].where(lambda w: w > 1)).to_csv(
        path, na_rep='"NAN"', quoting=3, quotechar="'"
    )
    assert '"NAN"' in path.read_text()
    assert read_file(path)["wind_speed"].isna().any()


QUICK = ("demo", "--days", 120, "--step", 900)


def test_the_demo_finds_what_is_hidden_and_tells_the_truth_after(week, tmp_path):
    path = tmp_path / "demo.html"
    result = call(*QUICK, "--report", path)
    assert result.exit_code == 0, result.output
    answer, truth = result.output.split("the truth, which the loop has not seen")
    assert answer.index("measured plant") < answer.index("a simulated site")
    assert "not told of" in answer
    for name in HIDDEN:
        assert f"+ {name}" in answer
        assert re.search(rf"^  {name} .*: found, \d\.\d\d K$", truth, re.MULTILINE)
    assert path.stat().st_size > 50_000
    assert str(close_loop(week)) in truth
    assert "what 7 days can say" in truth


def test_without_measured_records_the_demo_goes_on_and_says_so(monkeypatch):
    def offline(name):
        raise OSError("no route to host")

    monkeypatch.setattr(datasets, "load", offline)
    result = call("demo", "--days", 30, "--step", 1800, "--seed", 4)
    assert result.exit_code == 0, result.output
    first, *_, last = result.output.splitlines()
    assert first == "the measured plant cannot be had (no route to host)"
    assert last == "the measured week cannot be had (no route to host)"
    assert "the truth, which the loop has not seen" in result.output


def test_the_demo_begins_with_the_measured_plant(bolzano, monkeypatch, capsys):
    """A year of it here, in the summer time of its file."""
    year = bolzano["2012-06-01":"2013-05-31"]
    monkeypatch.setattr(datasets, "load", lambda name: {"eurac_bolzano": year}[name])
    demo_years()
    said = capsys.readouterr().out
    assert said.startswith("a measured plant: Eurac Research, Bolzano, Italy")
    assert "days at 60 min" in said and "10.17605/OSF.IO/VTR2S" in said
    assert "no log of this plant is published" in said


def test_the_hour_that_autumn_has_twice_is_told_by_the_order(tmp_path):
    utc = pd.date_range("2023-10-28 22:00", periods=96, freq="30min", tz="UTC")
    naive = utc.tz_convert("Europe/Brussels").tz_localize(None)
    path = tmp_path / "summer.csv"
    pd.DataFrame({"wind_speed": 1.0}, naive).to_csv(path, index_label="time")
    assert (read_file(path, tz="Europe/Brussels").index == utc).all()


def test_a_unit_that_is_right_can_pass(tmp_path):
    """A storm whose wind looks to be in km/h goes to the loop by the flag only."""
    data = datasets.synthetic(8, 300, seed=2).tz_localize(None)
    data["wind_speed"] *= 3.6
    path = tmp_path / "storm.csv"
    data.to_csv(path, index_label="time")
    refused = call("loop", path)
    assert refused.exit_code == 1 and "--no-unit-check" in refused.output
    assert call("loop", path, "--no-unit-check").exit_code == 0


@pytest.mark.parametrize("column", ["v", "v (m/s)"])
@pytest.mark.parametrize("parquet", [False, True])
def test_a_wind_that_is_possible_passes_where_its_unit_is_stated(
    tmp_path, column, parquet
):
    """A storm's wind may be in m/s: its header, or the user, has to say so."""
    data = datasets.synthetic(8, 300, seed=2).tz_localize(None)
    data = data.assign(wind_speed=3.6 * data["wind_speed"])
    data = data.rename(columns={"wind_speed": column}).rename_axis("time")
    path = tmp_path / "storm"
    data.to_csv(path.with_suffix(".csv"))
    path.mkdir()
    data.to_parquet(path / "all.parquet")
    given = [path if parquet else path.with_suffix(".csv"), "--map"]
    given += [f"wind_speed={column}"]
    stated = column != "v"
    for method in ("fit", "loop"):
        done = call(method, *given, *["--details"] * (method == "loop"))
        assert (done.exit_code == 0) is stated, done.output
        assert "wind_speed looks to be in km/h" in " ".join(done.output.split())
    if not parquet:
        assert call("fit", *given, "--unit", "wind_speed=m/s").exit_code == 0
        names = {"wind_speed": column}
        whole = read_file(given[0], names, {} if stated else {"wind_speed": "m/s"})
        assert whole.attrs["stated"] == ["wind_speed"]
        assert fit_fem(whole).coefficients["k"] > 0.0


def test_a_proposal_says_what_is_odd_of_a_driver(tmp_path):
    data = datasets.synthetic(10, 600, seed=2).tz_localize(None)
    tips = np.random.default_rng(0).random(len(data)) < 0.05
    data.assign(rain=0.2 * np.cumsum(tips)).to_csv(tmp_path / "a.csv")
    done = call("loop", tmp_path / "a.csv", "--guess")
    assert "precipitation=rain" in done.output
    assert "- precipitation rises in" in done.output


def test_a_file_in_another_encoding_names_the_option(frame, tmp_path):
    path = tmp_path / "latin.csv"
    named = frame.rename(columns={"temp_air": "T [°C]"})
    named.to_csv(path, index_label="time", encoding="latin-1")
    names = ("--map", "temp_air=T [°C]")
    refused = call("fit", path, *names)
    assert refused.exit_code == 1 and "give --encoding, such as latin-1" in (
        refused.output
    )
    assert call("fit", path, *names, "--encoding", "latin-1").exit_code == 0


def test_fit_and_loop_take_the_same_options():
    """But for those that only one of them can have, as its help says."""
    fit, loop = (
        {param.name: param for param in getattr(commands, name).params}
        for name in ("fit", "loop")
    )
    assert set(fit) - set(loop) == {"dynamics", "method", "calm_wind", "plot"}
    extra = {"min_rmse_reduction", "corrected", "resolve", "details", "ceiling"}
    assert set(loop) - set(fit) == extra
    both = set(fit) & set(loop) - {"model"}
    assert both
    for name in both:
        assert fit[name].default == loop[name].default
    said = {name: " ".join(call(name, "-h").output.split()) for name in ("fit", "loop")}
    assert "fit takes the paper's wm1 by default" in said["loop"]
    assert "where loop takes faiman" in said["fit"]


def test_what_is_held_out_fixed_and_added_reaches_the_fit(frame, tmp_path):
    path, out = tmp_path / "plant.csv", tmp_path / "fit.json"
    data = frame.assign(wind_direction=np.arange(len(frame)) * 7.0 % 360.0)
    data.to_csv(path, index_label="time")
    days = ("--holdout", "2023-06-02..2023-06-03", "--holdout", "2023-06-07")
    options = ("--fix", "tau=378", "--effects", "wind_direction", "--out", out)
    result = call("fit", path, *days, *options)
    assert result.exit_code == 0, result.output
    held = pd.Series(data.index.day.isin([2, 3, 7]), data.index)
    expected = fit_fem(
        *(data[name] for name in COLUMNS),
        holdout=held,
        fixed={"tau": 378.0},
        effects="wind_direction",
        wind_direction=data["wind_direction"],
    )
    assert result.output == f"{expected}\n\nwrote {out}\n"
    assert re.search(r"^tau +378 +held", result.output, re.MULTILINE)


def test_the_same_reaches_the_loop(plant_file, plant):
    data, site = plant
    days = ("--holdout", "2023-01-09..2023-01-22", "--effects", "sky_radiation,season")
    result = call("loop", plant_file, *PLANT, *PLACE, *days, "--fix", "bias=-1")
    assert result.exit_code == 0, result.output
    held = pd.Series(
        data.index.normalize().isin(pd.date_range("2023-01-09", periods=14)), data.index
    )
    found = close_loop(
        data.assign(state="ok"),
        location=Location(site.latitude, site.longitude, tz=site.tz),
        surface_tilt=35.0,
        surface_azimuth=180.0,
        holdout=held,
        effects=["sky_radiation", "season"],
        fixed={"bias": -1.0},
    )
    assert result.output == f"{found}\n"


def test_an_effect_that_follows_the_sun_is_fitted_with_the_place(frame, tmp_path):
    path = tmp_path / "plant.csv"
    frame.to_csv(path, index_label="time")
    refused = call("fit", path, "--effects", "incidence_angle")
    assert refused.exit_code == 1 and "--lat" in refused.output
    result = call("fit", path, "--effects", "incidence_angle", *PLACE)
    assert result.exit_code == 0 and "+ incidence_angle" in result.output


def test_a_likely_driver_of_another_name_is_asked_about(frame, tmp_path):
    path = tmp_path / "plant.csv"
    names = {"RH [%]": 50.0, "WR": 180.0, "Rain": 1.0, "Load": 3.0}
    noise = np.random.default_rng(0).uniform(size=(len(frame), 4))
    extra = pd.DataFrame(noise * list(names.values()), frame.index, list(names))
    frame.join(extra).to_csv(path, index_label="time")
    result = call("loop", path)
    assert result.exit_code == 0
    asked = result.output.splitlines()[0]
    for option in (
        "relative_humidity=RH [%]",
        "wind_direction=WR",
        "precipitation=Rain",
    ):
        assert option in asked
    assert "Load" not in asked
    maps = shlex.split(asked.partition("run again with ")[2])
    mapped = call("loop", path, *maps)
    assert mapped.exit_code == 0 and "looks like" not in mapped.output


def test_instants_are_told_in_the_days_of_their_place(frame, tmp_path):
    path = tmp_path / "plant.csv"
    local = frame.tz_localize("Etc/GMT+7").tz_convert("UTC")
    local.to_csv(path, index_label="time")
    result = call("loop", path, "--lat", 35, "--lon", -106)
    assert result.output.startswith("note: the times are instants; days and hours are")
    alone = close_loop(
        local.tz_convert("Etc/GMT+7"), location=Location(35, -106, "Etc/GMT+7")
    )
    assert str(alone) in result.output


def test_a_file_cannot_steer_the_terminal(logger):
    data = pd.read_csv(logger).rename(columns={"note": "\x1b[2J\x07"})
    data.to_csv(logger, index=False)
    result = call("fit", logger)
    assert result.exit_code == 1
    assert "\x1b" not in result.output and "\\x1b[2J\\x07" in result.output


@pytest.mark.skipif(not Path("/dev/zero").exists(), reason="has no endless file")
def test_an_endless_file_is_refused():
    assert "is a device and no file" in call("fit", "/dev/zero").output


def test_the_package_is_the_command(monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", ["pvlib_fem", "--version"])
    with pytest.raises(SystemExit, match="0"):
        runpy.run_module("pvlib_fem", run_name="__main__")
    assert capsys.readouterr().out == f"pvlib-fem, version {__version__}\n"


def test_an_effect_takes_its_settings_at_the_shell(frame, tmp_path):
    path, out = tmp_path / "plant.csv", tmp_path / "fit.json"
    humid = frame.assign(relative_humidity=50.0 + 30.0 * np.sin(np.arange(len(frame))))
    humid.to_csv(path, index_label="time")
    setting = "sky_radiation.source=humidity, without clouds"
    effect = ("--effects", "sky_radiation", "--effect-setting", setting)
    result = call("fit", path, *effect, "--out", out)
    assert result.exit_code == 0, result.output
    source = {"name": "sky_radiation", "source": "humidity, without clouds"}
    columns = [humid[name] for name in COLUMNS]
    humidity = humid["relative_humidity"]
    expected = fit_fem(*columns, effects=[source], relative_humidity=humidity)
    found = FemFit.from_json(out)
    assert found.effects[0].source == source["source"]
    assert found.coefficients == pytest.approx(expected.coefficients, rel=1e-6)
    for given, said in {
        "sky_radiation.source=nosuch": "unknown source 'nosuch'",
        "sky_radiation.nosuch=1": "has no setting nosuch",
        "rain.film=1": "given for rain, which is not among --effects",
        "sky_radiation=1": "is not NAME.SETTING=VALUE",
    }.items():
        refused = call("fit", path, *effect[:2], "--effect-setting", given)
        assert refused.exit_code != 0 and said in refused.output


def test_module_sensors_are_compared_and_their_common_part_goes_into_the_loop(tmp_path):
    data = datasets.synthetic(70, 1800, seed=2).tz_localize(None)
    over, random = data["temp_module"] - data["temp_air"], np.random.default_rng(0)
    for i, share in enumerate((1.0, 1.03, 0.95)):
        noise = random.normal(0.0, 0.2, len(data))
        data[f"T{i}"] = data["temp_air"] + share * over + noise
    path, common = tmp_path / "plant.csv", tmp_path / "common.csv"
    data = data.drop(columns="temp_module").assign(**{"=cmd|' /C calc'!A0": noise})
    data.to_csv(path, index_label="time")
    maps = [w for i in range(3) for w in ("--map", f"temp_module_{i}=T{i}")]
    found = call("modules", path, *maps, "--common", common)
    assert found.exit_code == 0, found.output
    assert found.output.startswith("3 module sensors, each compared with the median")
    assert "temp_module_2  0.9" in found.output
    header = common.read_text().splitlines()[0]
    assert "'=cmd" in header and ",=" not in header and ',"=' not in header
    loop = call("loop", common)
    assert loop.exit_code == 0, loop.output
    refused = call("fit", path, *maps)
    assert refused.exit_code == 1
    assert "Of 3 module sensors give one as temp_module, or pvlib-fem" in refused.output
    none = call("modules", common)
    assert none.exit_code == 1
    assert "1 module sensors are there (temp_module)" in none.output
    assert "--map temp_module_1=COLUMN" in none.output


def test_the_loop_of_a_module_that_lies_flat_is_told_and_written(tmp_path):
    effects = simulator.PHYSICS | {"soiling": 1.0, "poa_misalignment": 5.0}
    data = simulator.record(effects=effects, days=120, step=3600, seed=5)
    data.to_csv(tmp_path / "flat.csv", index_label="time")
    place = ("--lat", 49.4, "--lon", 8.7, "--tilt", 0, "--azimuth", 180)
    out = tmp_path / "flat.json"
    found = call("loop", tmp_path / "flat.csv", *place, "--out", out)
    assert found.exit_code == 0, found.output
    assert "the loop on 120 days" in found.output
    assert Loop.from_json(out).place["surface_tilt"] == 0.0


@pytest.fixture
def fading(tmp_path):
    """A logger's file whose sensor loses an eighth, and how it is read."""
    data = datasets.synthetic(200, 1800, seed=3, noise=0).tz_localize(None)
    noise = np.random.default_rng(1).normal(0.0, 0.4, len(data))
    data["temp_module"] += pd.Series(noise, data.index).ewm(halflife=4).mean()
    lit = data["poa_global"] * (1.0 - 0.004 * (data["temp_module"] - 25.0))
    data["AC"] = 0.2 * lit + 3.0 * noise * (lit > 0.0)
    data["poa_global"] /= np.where(data.index < "2023-09-15", 1.0, 1.12)
    data["wind_speed"] *= 3.6
    names = {"poa_global": "Irr (W/m2)", "temp_air": "T air", "wind_speed": "W (km/h)"}
    data = data[[*COLUMNS, "AC"]].rename(columns=names)
    data.round(3).to_csv(tmp_path / "plant.csv", index_label="Zeit", sep=";")
    maps = [w for n, c in names.items() for w in ("--map", f"{n}={c}")]
    return tmp_path / "plant.csv", [*maps, "--map", "power_ac=AC"]


def test_a_corrected_file_has_the_names_of_its_own_and_is_read_again(fading, tmp_path):
    path, maps = fading
    out = tmp_path / "corrected.csv"
    given = pd.read_csv(path, index_col=0, sep=";", parse_dates=True)
    given["T air"] = (1.8 * given["T air"] + 32.0).round(3)
    given.to_csv(path, sep=";")
    own = ("--sep", ";", "--convert", "--unit", "temp_air=°F", "--tz", "Etc/GMT-1")
    # power cannot tell the sensor from light on the modules
    cause = "--resolve", "irradiance_sensor_step"
    found = call("loop", path, *maps, *own, *cause, "--corrected", out)
    assert found.exit_code == 0, found.output
    assert "poa_global: the irradiance sensor reads less from 2023-09-" in found.output
    assert f"wrote {out}" in found.output
    header = out.read_text().splitlines()[0]
    # what was converted is no more in the unit that its header names
    assert header == (
        "time,temp_module,Irr (W/m2),poa_global_original,T air,wind_speed,AC,corrected"
    )
    same = [f"--map={word}" for word in maps[1::2] if "km/h" not in word]
    again = call("loop", out, *same)
    assert again.exit_code == 0, again.output
    assert "irradiance_sensor_step" not in again.output
    whole = pd.read_csv(out, index_col=0, parse_dates=True)
    assert np.allclose(1.8 * whole["T air"] + 32.0, given["T air"])
    assert np.allclose(whole["poa_global_original"], given["Irr (W/m2)"])
    assert np.allclose(whole["wind_speed"] * 3.6, given["W (km/h)"])


def test_a_correction_that_cannot_be_is_refused_before_the_work(fading, tmp_path):
    path, maps = fading
    for options, words in (
        (("--resolve", "rain"), "--resolve is for --corrected, which is not given"),
        (("--corrected", "a.json"), "writes a table, so a.json has to end with .csv"),
        (("--corrected", path), "would overwrite a file: plant.csv is read"),
    ):
        refused = call("loop", path, *maps, *options)
        assert refused.exit_code == 1 and words in refused.output
    (tmp_path / "parts").mkdir()
    parts = call("loop", tmp_path / "parts", "--corrected", tmp_path / "a.csv")
    assert parts.exit_code == 1
    assert "does not go with Parquet files that follow each other" in parts.output
