"""The command, as it is called: output, files and exit codes."""

import json
import re

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner

from pvlib_fem import DynamicCellTemperature, cli, datasets


def call(*arguments):
    return CliRunner().invoke(cli.main, [str(a) for a in arguments])


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
    assert "runs backwards" in paper.output


def test_parquet_and_csv_give_the_same(frame, logger, tmp_path):
    path = tmp_path / "logger.parquet"
    pd.read_csv(logger, index_col=0, parse_dates=True).to_parquet(path)
    assert call("fit", path, *MAP).output == call("fit", logger, *MAP).output


@pytest.mark.parametrize("zone", [None, "Europe/Brussels"])
def test_the_zone_changes_the_days_and_not_the_instants(frame, tmp_path, zone):
    path = tmp_path / "utc.csv"
    frame.tz_localize("UTC").to_csv(path)
    data = cli.read_file(path, {}, zone)
    assert str(data.index.tz) == (zone or "UTC")
    assert (data.index == frame.index.tz_localize("UTC")).all()


def test_offsets_that_change_are_read_as_instants(frame, tmp_path):
    """A logger that writes local time with its offset, over a change of the clock."""
    utc = pd.date_range("2024-03-31 00:00", periods=4, freq="30min", tz="UTC")
    path = tmp_path / "dst.csv"
    local = pd.Series(1.0, utc.tz_convert("Europe/Brussels"))
    local.to_csv(path)
    assert path.read_text().count("+02:00") == 2
    assert (cli.read_file(path, {}, "Europe/Brussels").index == utc).all()


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
    file = datasets.fetch("MET_2015_11_11.dat")
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
            (*MAP, "--map", "time=wind_speed"),
            "column 'wind_speed' should hold the times and holds numbers",
        ),
    ],
)
def test_bad_data_end_with_one_line_and_exit_code_1(logger, spoil, arguments, message):
    spoil(pd.read_csv(logger, index_col=0)).to_csv(logger, index_label="Timestamp")
    result = call("fit", logger, *arguments)
    assert result.exit_code == 1
    assert result.output.startswith("Error: ")
    assert message in result.output
    assert len(result.output.splitlines()) == 1


@pytest.mark.parametrize(
    "arguments",
    [
        ("fit",),
        ("fit", "no such file.csv"),
        ("fit", __file__, "--model", "wm3"),
        ("fit", __file__, "--map", "poa_global"),
        ("fit", __file__, "--map", "rain=Irr"),
        ("fit", __file__, "--skip-rows", "two"),
        ("forecast",),
    ],
)
def test_wrong_usage_ends_with_exit_code_2(arguments):
    assert call(*arguments).exit_code == 2


def test_a_unit_can_be_insisted_on(logger):
    data = pd.read_csv(logger, index_col=0)
    data.assign(wind_speed=3.6 * data["wind_speed"]).to_csv(logger)
    assert call("fit", logger, *MAP, "--no-unit-check").exit_code == 0


def test_the_demo_is_the_fit_of_the_measured_week(week, tmp_path):
    path = tmp_path / "week.csv"
    week.to_csv(path)
    demo = call("demo").output
    assert demo.startswith("measured week: ")
    assert demo.split("\n", 2)[2] == call("fit", path).output


def test_without_the_week_the_demo_makes_a_month_and_says_so(monkeypatch):
    def offline(name):
        raise OSError("no route to host")

    monkeypatch.setattr(datasets, "load", offline)
    result = call("demo")
    assert result.exit_code == 0
    assert "cannot be had (no route to host), so this is a made-up month" in (
        result.output
    )
    assert "43,200 rows" in result.output
    shown = dict(re.findall(r"^(k|tau) +(\S+)", result.output, re.MULTILINE))
    assert np.isfinite([float(value) for value in shown.values()]).all()
