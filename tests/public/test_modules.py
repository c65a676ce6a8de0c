"""Several module sensors: errors common to all, and errors of one."""

import numpy as np
import pandas as pd
import pytest

import pvlib_fem as fem
from pvlib_fem import datasets

USUAL = ["poa_global", "temp_air", "wind_speed"]
SHARES, OFFSETS = (0.95, 1.0, 1.02, 1.05), (0.0, 0.4, -0.3, 0.1)


@pytest.fixture(scope="module")
def plant():
    """Four sensors of 200 days with a common part that no model has."""
    data = datasets.synthetic(200, 3600, seed=3, noise=0).tz_localize(None)
    random = np.random.default_rng(1)
    both = np.cumsum(random.normal(0.0, 0.05, len(data)))
    over = (data["temp_module"] - data["temp_air"]) * (1.0 + 0.1 * np.sin(both))
    data = data[USUAL].copy()
    for i, (share, offset) in enumerate(zip(SHARES, OFFSETS)):
        noise = random.normal(0.0, 0.3, len(data))
        data[f"temp_module_{i}"] = data["temp_air"] + share * over + offset + noise
    return data


def test_each_has_its_share_and_its_offset(plant):
    found = fem.compare_modules(plant).table
    assert list(found.index) == [f"temp_module_{i}" for i in range(4)]
    assert found["used"].all() and (found["step"] == "").all()
    for i, name in enumerate(found.index):
        others = [j for j in range(4) if j != i]
        share, offset = (
            np.median([part[j] for j in others]) for part in (SHARES, OFFSETS)
        )
        assert found["share"][name] == pytest.approx(SHARES[i] / share, abs=0.03)
        assert found["offset"][name] == pytest.approx(OFFSETS[i] - offset, abs=0.1)


def test_a_step_is_of_the_one_that_has_it(plant):
    data, there = plant.copy(), plant.index >= "2023-09-15"
    over = data["temp_module_2"] - data["temp_air"]
    data["temp_module_2"] -= 0.12 * there * over
    found = fem.compare_modules(data).table
    assert (found["step"] != "").to_dict() == {
        name: name == "temp_module_2" for name in found.index
    }
    step = found.loc["temp_module_2"]
    assert abs(pd.Timestamp(step["step"]) - pd.Timestamp("2023-09-15")).days <= 2
    assert step["change"] == pytest.approx(-0.12, abs=max(4 * step["stderr"], 0.01))


@pytest.mark.parametrize(("at", "by"), [("2023-08-20", -0.2), ("2023-08-01", 0.25)])
def test_a_step_is_relative_to_the_share_before_it(plant, at, by):
    """Relative to the share of the whole record it would be -0.22 and 0.21."""
    data, later = plant.copy(), plant.index >= at
    over = data["temp_module_2"] - data["temp_air"]
    data["temp_module_2"] += by * later * over
    found = fem.compare_modules(data).table
    assert found["step"].to_dict() == {
        name: at if name == "temp_module_2" else "" for name in found.index
    }
    assert found["change"]["temp_module_2"] == pytest.approx(by, abs=0.012)


def test_what_a_fit_leaves_is_told_apart(plant):
    """The made over-temperature is common, and the noise of each sensor its own."""
    data, there = plant.copy(), plant.index >= "2023-09-15"
    data["temp_module_2"] += 3.0 * there
    comparison = fem.compare_modules(data)
    found = comparison.table
    others = found.drop("temp_module_2")
    assert (others["common"] > others["own"]).all()
    assert others["own"].max() < 0.5  # noise of 0.3 K, and of a median of three
    assert found["own"]["temp_module_2"] == pytest.approx(1.5, abs=0.3)  # half of 3 K
    assert (found["left"] ** 2 < 2.0 * (found["common"] ** 2 + found["own"] ** 2)).all()
    assert comparison.fits
    for name, fit in comparison.fits.items():
        alone = fem.fit_fem(
            *(data[n] for n in USUAL), data[name], model="faiman", dynamics="balance"
        )
        assert fit.coefficients == alone.coefficients


def test_what_all_have_in_common_is_a_record_for_the_loop(plant):
    data, there = plant.copy(), plant.index >= "2023-09-15"
    over = data["temp_module_2"] - data["temp_air"]
    data["temp_module_2"] -= 0.12 * there * over
    comparison = fem.compare_modules(data)
    assert list(comparison.common) == [*USUAL, "temp_module"]
    before = plant.iloc[:, 3:].mean(axis=1)
    gap = comparison.common["temp_module"] - before
    assert gap.abs().max() < 0.25  # a step of 12 % of 40 K, taken out of one of four
    words = str(comparison)
    assert "temp_module_2 alone reads 1" in words and "% less over-temp" in words
    assert "of the error common to all" in words
    with pytest.raises(
        ValueError, match=r"Of 4 module sensors give one as temp_module"
    ):
        fem.close_loop(data)


def test_what_all_have_is_none_of_theirs(plant):
    """The mounting of all changes, or the pyranometer."""
    data, there = plant.copy(), plant.index >= "2023-09-15"
    for name in data.columns[3:]:
        data[name] += 0.2 * there * (data[name] - data["temp_air"])
    assert (fem.compare_modules(data).table["step"] == "").all()


def test_copies_and_failed_sensors_are_said_and_not_used(plant):
    data = plant.assign(
        temp_module_4=plant["temp_module_0"],
        temp_module_5=20.0,
        temp_module_6=plant["temp_module_1"].where(plant.index < "2023-07-01"),
    )
    data.insert(3, "temp_module", "off")  # the first, too
    found = fem.compare_modules(data).table
    words = found["note"].iloc[0]
    assert "temp_module holds 'off'" in words and not found["used"].iloc[0]
    found = found.iloc[1:]
    assert found["used"].to_list() == [True] * 4 + [False] * 3
    copy, still, gone = found["note"].iloc[4:]
    assert copy == "temp_module_4 is a copy of temp_module_0"
    assert "temp_module_5 is stuck at 20 for the whole record" in still
    assert gone == "720 values of 4,800 are there"
    alone = fem.compare_modules(plant).table
    pd.testing.assert_frame_equal(found.iloc[:4], alone)


def test_two_sensors_share_a_step(plant):
    """A step of two sensors can be in either, and stays in their common part."""
    pair, there = ["temp_module_0", "temp_module_2"], plant.index >= "2023-09-15"
    same = fem.compare_modules(plant, pair)
    assert (same.table["step"] == "").all() and "with the other" in str(same)
    share = SHARES[0] / SHARES[2]
    assert same.table["share"].iloc[0] == pytest.approx(share, abs=0.02)
    assert same.table["share"].iloc[1] == pytest.approx(1.0 / share, abs=0.02)
    data = plant.copy()
    data["temp_module_2"] -= 0.12 * there * (data["temp_module_2"] - data["temp_air"])
    found = fem.compare_modules(data, pair)
    table = found.table
    assert table["share"].to_list() == pytest.approx([share, 1.0 / share], abs=0.02)
    assert table["step"].iloc[0] == table["step"].iloc[1]
    step = pd.Timestamp(table["step"].iloc[0])
    assert abs(step - pd.Timestamp("2023-09-15")).days <= 2
    first, second = table["change"]
    assert second == pytest.approx(-0.12, abs=0.015)
    assert (1.0 + first) * (1.0 + second) == pytest.approx(1.0, abs=0.01)
    assert "one of both" in str(found) and "alone" not in str(found)
    pd.testing.assert_series_equal(
        found.common["temp_module"], data[pair].mean(axis=1), check_names=False
    )


def test_what_cannot_be_compared_is_said(plant):
    with pytest.raises(ValueError, match=r"1 module sensors are there .* at least 2"):
        fem.compare_modules(plant, ["temp_module_0"])
    with pytest.raises(
        ValueError, match="the data have no column temp_back; they have"
    ):
        fem.compare_modules(plant, ["temp_module_0", "temp_module_1", "temp_back"])
    with pytest.raises(ValueError, match=r"fewer than 2 .* temp_module_1 is a copy of"):
        fem.compare_modules(
            plant[[*USUAL, "temp_module_0"]].assign(
                temp_module_1=plant["temp_module_0"]
            )
        )
