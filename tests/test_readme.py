"""The README's lines run as they stand, and print what it shows."""

import re
import runpy
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")


def blocks(language):
    return re.findall(rf"```{language}\n(.*?)```", README, re.DOTALL)


def test_its_lines_run_and_its_report_is_what_they_print(week, capsys):
    names = {}
    loop, first, *others = blocks("python")
    exec(loop, names)
    assert capsys.readouterr().out == blocks("text")[0]
    exec(first, names)
    assert capsys.readouterr().out == blocks("text")[1]
    scores = names["fit"].scores["rmse_test"].round(1)
    sentence = f"leaves {scores['standard']} K (RMSE) on the two days that the fit "
    assert f"{sentence}never saw, this one {scores['fem']} K." in README
    week, usual = names["week"], ("poa_global", "temp_air", "wind_speed", "temp_module")
    steady = names["fem"].fit_fem(
        *(week[n] for n in usual),
        model="wm1",
        dynamics="steady",
        holdout=names["fit"].holdout,
    )
    assert f"with a bias leaves {steady.scores.rmse_test['fem']:.1f} K" in README
    for block in others:
        exec(block, names)
    assert names["modelled"].notna().all()
    assert (names["cell"] > names["week"]["temp_air"] - 1).all()
    assert names["energy"] > 5000
    windy = names["windy"]
    assert not windy.at_bound and not np.isnan([*windy.stderr.values()]).any()
    gained = windy.scores["rmse_test"]
    assert gained["+ wind_direction"] < 0.95 * gained["fem"]
    assert names["ranking"].index[0] == "rain"
    assert "…" not in str(names["ranking"]) and "..." not in str(names["ranking"])
    assert names["ranking"]["gain"].iloc[0] > 2 * names["ranking"]["gain"].iloc[1]


def test_its_energies_are_those_of_the_script(monkeypatch):
    import matplotlib

    matplotlib.use("agg")
    monkeypatch.setattr("matplotlib.pyplot.show", lambda: None)
    found = runpy.run_path(str(ROOT / "gallery" / "05_energy_of_a_year.py"))["table"]
    shown = dict(re.findall(r"^(.+?\]) +(-?[\d.]+)$", blocks("text")[2], re.MULTILINE))
    assert list(shown) == list(found)
    for name, value in found.items():
        assert float(shown[name]) == pytest.approx(value, abs=0.02), name
