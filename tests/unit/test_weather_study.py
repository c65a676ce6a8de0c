"""The study of measured weather: its module, and its causes."""

import numpy as np
import pandas as pd
import pytest
import study_weather
from study_weather import BETWEEN, CAUSES, TAKEN, radiation, surroundings, two_nodes

from pvlib_fem.effects import CHANGES


def steady(light, air=10.0, wind=2.0, hours=48):
    index = pd.date_range("2023-01-01", periods=hours, freq="h")
    values = {"poa_global": light, "temp_air": air, "wind_speed": wind}
    return pd.DataFrame(values, index, dtype=float)


@pytest.mark.parametrize("light", [0.0, 300.0, 1000.0])
def test_in_steady_weather_both_nodes_lose_what_they_take(light):
    air, wind = 10.0, 2.0
    cells = two_nodes(steady(light, air, wind))[-1]
    front, back, sky = surroundings(air, wind, 1.0 - min(light / 900.0, 1.0))
    from_cells = TAKEN[1] * light - (back + radiation(cells, air)) * (cells - air)
    glass = cells - from_cells / BETWEEN
    lost = front * (glass - air) + radiation(glass, sky) * (glass - sky)
    assert lost == pytest.approx(from_cells + TAKEN[0] * light, abs=0.5)


def test_a_module_is_below_the_air_by_night_and_far_above_it_in_the_sun():
    assert -6.0 < two_nodes(steady(0.0))[-1] - 10.0 < -0.5
    assert 18.0 < two_nodes(steady(1000.0))[-1] - 10.0 < 35.0


def test_each_cause_changes_the_record_and_has_names_of_the_catalogue():
    data = steady(500.0, hours=24 * 14).assign(temp_module=40.0)
    after = np.arange(len(data)) >= 100
    for cause in CAUSES:
        masks = after.astype(float), after.astype(float)
        found = cause.done(data, *masks, lambda light: 40.0 * light)
        assert found.equals(data) == (cause.name == "nothing")
        assert cause.truths <= {*CHANGES}
        assert not (cause.truths and cause.unknown)
    assert len({cause.name for cause in CAUSES}) == len(CAUSES)


def test_a_name_that_neither_cause_nor_module_has_is_wrong():
    """The page counts it, and says that the requirement is missed."""
    right, wrong = (
        dict(
            module="sapm",
            cause=CAUSES[1].name,
            wrong=bad,
            misled=["soiling"] * bad,
            sets=1,
            found=not bad,
            before=1.0,
            after=0.5,
            patterns=0.4,
        )
        for bad in (False, True)
    )
    text = "\n".join(study_weather.page(pd.DataFrame([right, wrong]), 1))
    assert "wrong in 1 of 2 records (at most 0.3%: **missed**)" in text
    assert "| sapm | 2 | 1 | 1 of 2 | 1 of 2 | 1.00 | 0.50 | 0.40 |" in text
    assert text.count("with the number of sets: `soiling` 1.") == 1
