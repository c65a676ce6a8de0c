"""Work that is spread over processes."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from pvlib_fem._parallel import spread

SCRIPT = """
import sys
sys.path.insert(0, {here!r})
from test_parallel import noted_and_slow
from pvlib_fem._parallel import spread

if __name__ == "__main__":
    list(spread(noted_and_slow, [({folder!r},), ({folder!r},)], 2))
"""


def noted_and_slow(folder):
    """Say which process this is, and work for long."""
    Path(folder, str(os.getpid())).touch()
    time.sleep(120.0)


def squared(scale, number):
    return scale * number**2


def gone(process):
    """Whether a process has ended."""
    try:
        status = Path(f"/proc/{process}/status").read_text(encoding="ascii")
    except OSError:
        return True
    return "State:\tZ" in status  # nobody has asked yet how it ended


def until(condition, seconds=60.0):
    """Wait until a condition holds, and say whether it does."""
    end = time.monotonic() + seconds
    while not condition() and time.monotonic() < end:
        time.sleep(0.1)
    return condition()


@pytest.mark.parametrize("processes", [1, 2, 5])
def test_any_number_of_processes_gives_the_same_in_order(processes):
    found = list(spread(squared, [(n,) for n in range(7)], processes, shared=(3,)))
    assert found == [3 * n**2 for n in range(7)]


@pytest.mark.skipif(not Path("/proc").exists(), reason="no list of processes")
def test_processes_end_with_one_that_is_killed(tmp_path):
    """Which can tell them nothing; they would hold their memory for ever."""
    script, folder = tmp_path / "script.py", tmp_path / "said"
    folder.mkdir()
    here = str(Path(__file__).parent)
    script.write_text(SCRIPT.format(here=here, folder=str(folder)), encoding="utf-8")
    with subprocess.Popen([sys.executable, str(script)]) as main:
        assert until(lambda: len(list(folder.iterdir())) == 2)
        main.send_signal(signal.SIGKILL)
    workers = [one.name for one in folder.iterdir()]
    assert until(lambda: all(map(gone, workers)))
