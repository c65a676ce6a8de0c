"""Dirty files of plants: each ends in an answer, or in the option that gives one."""

import re
import shlex

import numpy as np
import pytest
from click.testing import CliRunner

import pvlib_fem as fem
from pvlib_fem import cli, simulator
from pvlib_fem.record.columns import COLUMNS


def call(*arguments):
    return CliRunner().invoke(cli.main, [str(a) for a in arguments])


def proposed(result):
    """The command in a message, as a shell would take it."""
    line = re.search(r"^  pvlib-fem (.*)$", result.output, re.MULTILINE)
    assert line, result.output
    return shlex.split(line[1])


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
