"""The quickstart's commands run as they stand, and print what it shows."""

import re
import shlex
from pathlib import Path

from click.testing import CliRunner

from pvlib_fem import FemFit, Loop, _cli as cli

PAGE = Path(__file__).parents[2] / "docs" / "guide" / "quickstart.md"
BLOCKS = re.findall(
    r"^```(\w+)\n(.*?)^```", PAGE.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL
)


def run(block):
    """What the commands of a block print, one after the other."""
    for line in block.replace("\\\n", " ").splitlines():
        program, *arguments = shlex.split(line)
        assert program == "pvlib-fem"
        answer = CliRunner().invoke(cli.main, arguments)
        assert answer.exit_code == 0, answer.output
        yield answer.output


def test_every_block_runs_and_prints_what_is_shown(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    names, printed = {}, []
    assert BLOCKS
    for language, block in BLOCKS:
        match language:
            case "python":
                exec(block, names)
            case "sh":
                printed.append("".join(run(block)))
            case "text":
                lines = printed[-1].splitlines()
                assert all(line in lines for line in block.splitlines()), printed[-1]
            case _:
                assert block.startswith("$ pip install")
    assert names["energy"] > 5000
    assert "<svg" in Path("report.html").read_text(encoding="utf-8")
    assert FemFit.from_json("fit.json").coefficients["u0"] > 0
    assert Loop.from_json("loop.json").effects[0] == "sky_radiation"
    # the loop is run as the guess proposes it, and kept
    proposed = next(line for line in printed[0].splitlines() if "pvlib-fem" in line)
    (shown,) = (block for _, block in BLOCKS if "--out loop.json" in block)
    shown = shlex.split(shown.replace("\\\n", " "))
    assert {*shown} - {*shlex.split(proposed)} == {"--out", "loop.json"}
