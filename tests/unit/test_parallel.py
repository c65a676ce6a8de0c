"""Work that is spread over processes."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from pvlib_fem._parallel import spread

#: scripts have no guard, and functions of their own
SLOW = """
import os, pathlib, time
from pvlib_fem._parallel import spread

def noted_and_slow(folder, number):
    pathlib.Path(folder, str(os.getpid())).touch()
    time.sleep(120.0)
    return bytes(1_000_000)

list(spread(noted_and_slow, [(n,) for n in range(8)], 2, ({folder!r},)))
"""
ABANDONED = """
import time
from pvlib_fem._parallel import spread

def number(data, n):
    time.sleep(0.1 if n else 0.0)
    return n

data, held = bytes(1_000_000), []
for processes in (2, 3):
    for n in spread(number, [(data, n) for n in range(9000)], processes):
        break
    held.append(spread(number, [(data, n) for n in range(12)], processes))
    assert next(held[-1]) == 0
    assert [*spread(number, [(data, n) for n in range(4)], 2)] == [0, 1, 2, 3]
assert [[*some] for some in held] == [[*range(1, 12)]] * 2
"""
GROWS = """
import time, warnings
from pvlib_fem._parallel import spread

warnings.simplefilter("error")
kept = []

def grown(n):
    if n:
        kept.append(bytearray(b"1") * (350_000_000 if len(kept) == 1 else 1))
    time.sleep(1.1)
    return n

print(*spread(grown, [(n,) for n in range(6)], 2))
"""


def running(text, tmp_path, **how):
    script = tmp_path / "script.py"
    script.write_text(text, encoding="utf-8")
    how |= dict(stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    return subprocess.Popen([sys.executable, str(script)], **how)


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


def test_each_process_has_one_thread():
    assert [*spread(os.getenv, [("OMP_NUM_THREADS",)] * 2, 2)] == ["1", "1"]


def test_an_error_of_a_task_is_that_of_the_call():
    with pytest.raises(ValueError, match="invalid literal for int"):
        list(spread(int, [("1",), ("a",), ("2",)], 2))


def test_a_process_that_ends_is_an_error_with_a_remedy():
    with pytest.raises(RuntimeError, match="where memory is short, give fewer"):
        list(spread(os._exit, [(1,), (1,)], 2))


@pytest.mark.skipif(not Path("/proc").exists(), reason="no list of processes")
@pytest.mark.parametrize("stop", ["SIGKILL", "SIGINT"])
def test_processes_end_with_one_that_is_stopped(stop, tmp_path):
    """If it is killed it can tell them nothing; they would hold their memory."""
    folder = tmp_path / "said"
    folder.mkdir()
    # a job in the background of a shell ignores Ctrl-C, and so do its children
    how = dict(preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL))
    text = SLOW.format(folder=str(folder))
    with running(text, tmp_path, start_new_session=True, **how) as main:
        assert until(lambda: len(list(folder.iterdir())) == 2)
        if stop == "SIGKILL":
            main.send_signal(signal.SIGKILL)
        else:  # as a terminal sends Ctrl-C: to the processes, too
            os.killpg(main.pid, signal.SIGINT)
            errors = main.stderr.read()
            assert errors.count("Traceback") == 1, errors
            assert errors.endswith("KeyboardInterrupt\n")
    workers = [one.name for one in folder.iterdir()]
    assert len(workers) == 2 and until(lambda: all(map(gone, workers)), 30.0)


@pytest.mark.parametrize(
    ("text", "printed"),
    [(ABANDONED, ""), pytest.param(GROWS, "0 1 2 3 4 5\n", marks=pytest.mark.slow)],
)
def test_a_call_ends_silently(text, printed, tmp_path):
    """After calls whose results were not taken, and with a task that needs memory."""
    with running(text, tmp_path) as main:
        try:
            out, errors = main.communicate(timeout=300)
        finally:
            main.kill()
    assert (main.returncode, out, errors) == (0, printed, "")
