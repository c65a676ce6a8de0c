"""The README's lines run as they stand, and print what it shows."""

import re
import runpy
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")
GUIDE = ROOT / "docs" / "guide"


def blocks(language, text=README):
    return re.findall(rf"```{language}\n(.*?)```", text, re.DOTALL)


def guide(page):
    return (GUIDE / f"{page}.md").read_text(encoding="utf-8")


def test_it_is_short():
    assert len(README.splitlines()) <= 150


def test_each_block_runs_by_itself_and_prints_what_is_shown(capsys):
    fit, loop, chain = blocks("python")
    for code, shown in zip((fit, loop), blocks("text"), strict=True):
        exec(code, {})
        assert capsys.readouterr().out == shown
    names = {}
    exec(chain, names)
    assert names["energy"] > 5000


def test_the_blocks_of_the_page_on_fitting_run_and_print_what_is_shown(week, capsys):
    page, names = guide("fitting"), {}
    first, *others = blocks("python", page)
    exec(f"import pvlib_fem as fem\n{first}", names)
    assert capsys.readouterr().out == blocks("text", page)[0]
    scores = names["fit"].scores["rmse_test"].round(1)
    sentence = f"has an error of {scores['standard']} K (RMSE) on the two held-out days"
    assert f"{sentence}, this one {scores['fem']} K." in page
    shown = f"leaves {scores['standard']} K (RMSE) on two days that the fit never saw"
    words = " ".join(README.split())
    assert f"{shown}, the paper's form {scores['fem']} K" in words
    week, usual = names["week"], ("poa_global", "temp_air", "wind_speed", "temp_module")
    steady = names["fem"].fit_fem(
        *(week[n] for n in usual),
        model="wm1",
        dynamics="steady",
        holdout=names["fit"].holdout,
    )
    assert f"with a bias has {steady.scores.rmse_test['fem']:.1f} K" in page
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
    shown = dict(
        re.findall(
            r"^(.+?\]) +(-?[\d.]+)$",
            blocks("text", guide("dynamics"))[-1],
            re.MULTILINE,
        )
    )
    assert list(shown) == list(found)
    assert found
    for name, value in found.items():
        assert float(shown[name]) == pytest.approx(value, abs=0.02), name
