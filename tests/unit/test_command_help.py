"""Help, hints and interrupts of the command line."""

import io
import json
import os
import re
import shlex
import signal
import subprocess
import sys
import time
from pathlib import Path

import click
import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner
from conftest import call, proposed

from pvlib_fem import _cli as cli, datasets
from pvlib_fem._cli import (
    COMMANDS,
    commands,
    printing as words,
    read_records as reading,
)
from pvlib_fem._cli.headings import ORDER
from pvlib_fem._record.column_names import COLUMNS
from pvlib_fem._record.logger_files import read_file
from pvlib_fem._spelling import did_you_mean, similar_names


@pytest.fixture(scope="module")
def plant():
    return datasets.synthetic(12, 600, seed=2)[[*COLUMNS]].tz_localize(None)


@pytest.fixture
def logger(plant, tmp_path):
    path = tmp_path / "plant.csv"
    plant.rename(columns={"poa_global": "Irr [W/m2]"}).to_csv(path, index_label="time")
    return path


EXAMPLES = [
    (name, example) for name in COMMANDS for example in getattr(commands, name).examples
]


def test_each_command_has_an_example():
    assert {name for name, _ in EXAMPLES} == {*COMMANDS}


@pytest.mark.parametrize(("name", "example"), EXAMPLES)
def test_an_example_is_in_the_help_and_is_understood(
    name, example, tmp_path, monkeypatch
):
    assert f"\n  {example}\n" in call(name, "--help").output and len(example) < 79
    monkeypatch.chdir(tmp_path)
    for file in ("plant.csv", "systems.csv", "fit.json"):
        Path(file).write_text("")
    program, command, *arguments = shlex.split(example)
    assert (program, command) == ("pvlib-fem", name)
    getattr(commands, name).make_context(name, arguments)  # refuses wrong options


@pytest.mark.parametrize("name", COMMANDS)
def test_each_option_stands_once_under_a_heading(name):
    shown = call(name, "--help").output
    headings = [line[:-1] for line in shown.splitlines() if line[:-1] in ORDER]
    assert headings == [heading for heading in ORDER if heading in headings]
    assert len(headings) >= 2
    options = [p for p in getattr(commands, name).params if isinstance(p, click.Option)]
    shown = shown.partition(f"\n{headings[0]}:\n")[2]
    assert options
    for option in options:
        assert len(re.findall(rf"^  {option.opts[0]}\b(?!-)", shown, re.M)) == 1, option


@pytest.mark.parametrize(
    ("word", "known", "found"),
    [
        ("Irr", ["Irr [W/m2]", "Tmod"], ["Irr [W/m2]"]),
        ("IRR", ["Tmod", "irr"], ["irr"]),
        ("sky_radation", ["sky_radiation", "rain"], ["sky_radiation"]),
        ("Tmod", ["T_mod 2", "wind"], ["T_mod 2"]),
        ("rain", ["wind", "snow"], []),
    ],
)
def test_names_that_a_word_may_stand_for(word, known, found):
    assert similar_names(word, known) == found
    assert bool(did_you_mean(word, known)) == bool(found)


@pytest.mark.parametrize(
    ("arguments", "question"),
    [
        (("lop",), "did you mean 'loop'?"),
        (("fit", "FILE", "--skiprows", "1"), "--skip-rows"),
        (("fit", "FILE", "--map", "poa_global=Irr"), "did you mean 'Irr [W/m2]'?"),
        (("fit", "FILE", "--time", "Tme"), "did you mean 'time'?"),
        (("fit", "FILE", "--effects", "rian"), "did you mean 'rain'?"),
        (("fit", "FILE", "--unit", "windspeed=mph"), "did you mean 'wind_speed'?"),
        (("fit", "FILE", "--map", "windspeed=x"), "did you mean 'wind_speed'?"),
        (
            ("fit", "FILE", "--map", "poa_global=Irr [W/m2]", "--fix", "taw=3"),
            "did you mean 'tau'?",
        ),
    ],
)
def test_a_misspelled_name_is_answered_with_the_near_one(logger, arguments, question):
    result = call(*(logger if word == "FILE" else word for word in arguments))
    assert result.exit_code in (1, 2) and question in result.output


def test_a_table_of_systems_with_the_names_of_options_is_told_the_right_ones(tmp_path):
    table = pd.DataFrame([{"id": "a", "file": "a.csv", "lat": 50.0, "lon": 4.0}])
    table.to_csv(tmp_path / "systems.csv", index=False)
    result = call("fleet", tmp_path / "systems.csv", "--out", tmp_path / "out")
    assert result.exit_code == 1 and "looks like 'latitude'" in result.output


@pytest.fixture
def with_units(plant, tmp_path):
    """A file with units in the line below the header."""
    path = tmp_path / "units.csv"
    header, *rows = plant.to_csv(index_label="time").splitlines()
    path.write_text("\n".join([header, ",W/m²,°C,m/s,°C", *rows]), encoding="utf-8")
    return path


def test_lines_to_leave_out_are_given_by_their_numbers(with_units, plant):
    refused = call("fit", with_units, "--skip-rows", "1")
    assert refused.exit_code == 1
    words = proposed(refused)
    assert words == ["fit", str(with_units), "--skip-lines", "1"]
    result = call(*words)
    assert result.exit_code == 0, result.output
    assert call("fit", with_units, "--skip-rows", "1,").output == result.output
    data = read_file(with_units, skip_rows=(1,))
    assert np.allclose(data["temp_module"], plant["temp_module"])


def test_rows_before_the_header_are_a_number(plant, tmp_path):
    path = tmp_path / "preamble.csv"
    path.write_text(f"logger 7\n{plant.to_csv(index_label='time')}")
    words = proposed(call("fit", path))
    assert words[2:] == ["--skip-rows", "1"]
    assert call("fit", path, "--skip-lines", "0").output == call(*words).output
    both = call("fit", path, "--skip-lines", "0", "--skip-rows", "1")
    assert both.exit_code == 2 and "--skip-rows 2" in both.output
    assert call("fit", path, "--skip-lines", "-1").exit_code == 2


def test_a_folder_without_parquet_says_what_was_looked_for(tmp_path):
    (tmp_path / "plant").mkdir()
    (tmp_path / "plant" / "a.csv").write_text("x")
    result = call("loop", tmp_path / "plant")
    assert result.exit_code == 1
    assert ".parquet or .pq" in result.output and "1 .csv" in result.output


SENSORS = {
    "numbered": (["Module Temp 1", "Module Temp 2", "Module Temp 3"], 1.0),
    "T1_module": (["T1_module (degF)", "T2_module (degF)"], 1.8),
    "BOM": (["BOM1", "BOM2"], 1.0),
}


@pytest.mark.parametrize("names", SENSORS)
def test_the_proposal_for_module_sensors_is_accepted(plant, tmp_path, names):
    columns, slope = SENSORS[names]
    random, path = np.random.default_rng(1), tmp_path / "plant.csv"
    module = plant["temp_module"]
    some = {
        name: slope * (module + 0.5 * i + 0.1 * random.normal(size=len(module)))
        + (slope != 1.0) * 32.0
        for i, name in enumerate(columns)
    }
    plant.drop(columns="temp_module").assign(**some).to_csv(path, index_label="time")
    asked = call("modules", path, "--guess")
    assert asked.exit_code == 0, asked.output
    result = call(*proposed(asked))
    assert result.exit_code == 0, result.output
    assert f"{len(columns)} module sensors" in result.output
    rows = re.findall(r"^temp_module\S* +\S+ +([-+.\d]+) ", result.output, re.M)
    offsets = [*map(float, rows)]
    assert 0.5 < max(offsets) - min(offsets) < 1.6  # each in °C


def test_one_module_sensor_alone_has_a_place_for_the_second(plant, tmp_path):
    path = tmp_path / "plant.csv"
    plant.to_csv(path, index_label="time")
    asked = call("modules", path, "--guess")
    assert "temp_module_2=COLUMN" in proposed(asked)
    assert "which column is temp_module_2?" in asked.output


def test_no_remedy_is_named_that_the_command_lacks(plant, tmp_path):
    path = tmp_path / "plant.csv"
    level = plant.rename(columns={"poa_global": "ghi"})
    level.to_csv(path, index_label="time")
    for name in ("modules", "loop"):
        result = call(name, path)
        assert result.exit_code == 1
        has = "--transposition" in call(name, "--help").output
        assert has == ("--transposition" in result.output)


def test_second_sensors_are_converted(plant, tmp_path):
    path = tmp_path / "plant.csv"
    other = plant["temp_air"] + 0.3
    table = plant.assign(**{"Tamb B (degF)": 1.8 * other + 32.0})
    table.assign(gust=2.0 * plant["wind_speed"]).to_csv(path, index_label="time")
    names = {"temp_air_2": "Tamb B (degF)", "wind_speed_2": "gust"}
    with pytest.raises(ValueError, match=r"names °F, and temp_air_2 has to be in °C"):
        read_file(path, names)
    data = read_file(path, names, {"temp_air_2": "°F", "wind_speed_2": "km/h"})
    assert np.allclose(data["temp_air_2"], other)
    assert np.allclose(data["wind_speed_2"], 2.0 * plant["wind_speed"] / 3.6)
    maps = [f"--map={name}={column}" for name, column in names.items()]
    done = call("fit", path, *maps, "--convert", "--unit", "wind_speed_2=km/h")
    assert done.exit_code == 0, done.output
    assert "temp_air_2 converted from °F to °C" in done.output


def test_the_end_of_a_sensors_own_name_is_no_unit(plant, tmp_path):
    """As of sensors that are called A to K."""
    path = tmp_path / "plant.csv"
    plant.assign(temp_module_f=plant["temp_module"]).to_csv(path, index_label="time")
    data = read_file(path, convert_units=True)
    assert np.allclose(data["temp_module_f"], plant["temp_module"])


def test_reading_is_explained_on_a_terminal_where_it_takes_long(
    logger, capsys, monkeypatch
):
    arguments = ["screen", str(logger)]
    monkeypatch.setattr(words, "PATIENCE", 0.0)
    cli.main(arguments, standalone_mode=False)
    assert capsys.readouterr().err == ""  # nothing where it is no terminal

    def seen(patience):
        terminal = io.StringIO()
        terminal.isatty = lambda: True
        monkeypatch.setattr(words, "PATIENCE", patience)
        monkeypatch.setattr(sys, "stderr", terminal)
        cli.main(arguments, standalone_mode=False)
        return terminal.getvalue()

    assert seen(60.0) == ""
    monkeypatch.setattr(reading, "frame", delayed(reading.frame))
    told = seen(0.01)
    assert told.startswith("reading plant.csv …") and told.endswith("\r")


def delayed(function):
    def slowly(*arguments, **options):
        time.sleep(0.2)
        return function(*arguments, **options)

    return slowly


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("pvlib-fem lo", {"loop"}),
        ("pvlib-fem fit --ho", {"--holdout"}),
        ("pvlib-fem fit --model fai", {"faiman"}),
    ],
)
def test_a_shell_completes_commands_options_and_choices(line, words):
    """By the variable that the guide names."""
    guide = Path(__file__).parents[2] / "docs" / "guide" / "command_line.md"
    assert "_PVLIB_FEM_COMPLETE=bash_source pvlib-fem" in guide.read_text("utf-8")
    shell = {"_PVLIB_FEM_COMPLETE": "bash_complete", "COMP_WORDS": line}
    shell["COMP_CWORD"] = str(len(line.split()) - 1)
    done = CliRunner().invoke(cli.main, [], prog_name="pvlib-fem", env=shell)
    assert {row.partition(",")[2] for row in done.output.split()} == words


def states(out):
    """Time of writing of each system's result."""
    files = sorted(Path(out, "results").rglob("*.json"))
    heads = {p: json.loads(p.read_text("utf-8"))["fleet"]["state"] for p in files}
    return {p: p.stat().st_mtime_ns for p, state in heads.items() if state == "done"}


@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
def test_an_interrupted_fleet_says_how_to_go_on_and_goes_on(plant, tmp_path):
    for i in range(8):
        plant.to_csv(tmp_path / f"{i}.csv", index_label="time")
    table = pd.DataFrame({"id": [*map(str, range(8))]})
    table["file"] = table["id"] + ".csv"
    table.to_csv(tmp_path / "systems.csv", index=False)
    out = tmp_path / "out"
    command = ["fleet", str(tmp_path / "systems.csv"), "--out", str(out), "--task"]
    command += ["fit", "--workers", "1"]
    # as a terminal sends Ctrl-C: to the workers, too
    run = subprocess.Popen(
        [sys.executable, "-m", "pvlib_fem", *command],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        # a job in the background of a shell ignores it, and so do its children
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )
    begin = time.monotonic()
    while not [*out.rglob("results/*/*.json")] and time.monotonic() - begin < 60:
        time.sleep(0.01)
    os.killpg(run.pid, signal.SIGINT)
    _, said = run.communicate(timeout=60)
    before = states(out)
    assert run.returncode == 130, said
    assert 0 < len(before) < 8
    assert said == (
        f"Interrupted: {len(before)} of 8 systems are kept in {out}; run the same "
        "command to go on\n"
    )
    again = call(*command[:-1], "0")
    assert again.exit_code == 0 and "8 systems: 8 done" in again.output
    after = states(out)
    assert len(after) == 8 and before.items() <= after.items()
