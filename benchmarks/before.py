"""
Run the work by an earlier commit and by this tree in turn, for ratios of one run.

The commit is checked out in a second folder, from the repository's history. Each runs
in a process of its own on one thread of BLAS; the shortest of some runs counts, in time
of the processor, so that a busy machine changes a ratio little.
"""

import json
import os
import subprocess
import sys
import tempfile
import time
from contextlib import contextmanager
from pathlib import Path

HERE = Path(__file__).parent
COMMIT = "a8ab032f528a705043d08fe4d97abaebb94da959"
WORKS = {  # class of benchmarks.speed, what it is set up with, its work
    "fit ewm": ("Fit", "ewm", "time_fit_fem"),
    "fit balance": ("Fit", "balance", "time_fit_fem"),
    "fem_temperature": ("FemTemperature", "year at 1 min", "time_fem_temperature"),
    "loop": ("Loop", 1, "time_close_loop"),
}


@contextmanager
def checked_out(commit=COMMIT):
    """A folder with the tree of a commit."""
    git = ["git", "-C", str(HERE)]
    with tempfile.TemporaryDirectory() as folder:
        place = str(Path(folder) / "before")
        subprocess.run(
            [*git, "worktree", "add", "--quiet", "--detach", place, commit], check=True
        )
        try:
            yield place
        finally:
            subprocess.run([*git, "worktree", "remove", "--force", place], check=True)


def measured(tree, work, repeat):
    """Seconds of the processor and peak memory [GiB] of a work by a tree's package."""
    environment = os.environ | {"PYTHONPATH": str(tree), "OMP_NUM_THREADS": "1"}
    found = subprocess.run(
        [sys.executable, __file__, work, str(repeat)],
        env=environment,
        check=True,
        capture_output=True,
        text=True,
    )
    return json.loads(found.stdout)


def in_turn(*works, turns):
    """The shortest time and the largest memory of each of some works of trees."""
    runs = [[measured(*work) for work in works] for _ in range(turns)]
    return [
        (min(seconds for seconds, _ in of_one), max(memory for _, memory in of_one))
        for of_one in zip(*runs)
    ]


def imported(tree):
    """Shortest time of the processor of an import, in a new process. [s]"""
    words = "import time, pvlib_fem; print(time.process_time())"
    environment = os.environ | {"PYTHONPATH": str(tree)}
    given = dict(env=environment, check=True, capture_output=True, text=True, cwd=tree)
    runs = [subprocess.run([sys.executable, "-c", words], **given) for _ in range(5)]
    return min(float(run.stdout) for run in runs)


def helped(tree):
    """Shortest time until the command has printed what it can do. [s]"""
    environment, times = os.environ | {"PYTHONPATH": str(tree)}, []
    command = [sys.executable, "-m", "pvlib_fem", "--help"]
    for _ in range(5):
        start = time.perf_counter()
        subprocess.run(command, env=environment, check=True, capture_output=True)
        times.append(time.perf_counter() - start)
    return min(times)


def lines():
    """Each work with its ratio and its reach."""
    with checked_out() as before:
        now = HERE.parent
        for dynamics in ("ewm", "balance"):
            work, name = f"fit {dynamics}", f"fit_fem, year at 1 min, {dynamics}"
            # how memory is paged makes half of a time, from process to process
            works = (before, work, 4), (now, work, 4), (now, "fem_temperature", 10)
            (theirs, _), (ours, _), (one, _) = in_turn(*works, turns=4)
            yield f"{name}, against a8ab032", f"1/{theirs / ours:.1f}", "<= 1/5"
            yield f"{name}, against a temperature", f"{ours / one:.0f} x", "<= 12 x"
        works = (before, "loop", 3), (now, "loop", 3)
        (theirs, much), (ours, more) = in_turn(*works, turns=4)
        name = "close_loop, year at 1 min, against a8ab032"
        yield name, f"{ours / theirs:.2f} x", "<= 1/2"
        yield (
            "its process at the peak, against a8ab032",
            f"{more / much:.2f} x",
            "<= 1 x",
        )
        theirs, ours = imported(before), imported(now)
        yield "import pvlib_fem, against a8ab032", f"{ours / theirs:.2f} x", "<= 1 x"
        yield "pvlib-fem --help", f"{helped(now):.2f} s", "<= 1 s"


def run(work, repeat):
    """Print what one work takes in this process."""
    sys.path.insert(0, str(HERE))
    from benchmarks import speed

    kind, given, name = WORKS[work]
    bench, times = getattr(speed, kind)(), []
    bench.setup(given)
    for _ in range(repeat):
        start = time.process_time()
        getattr(bench, name)(given)
        times.append(time.process_time() - start)
    print(json.dumps([min(times), peak()]))


def peak():
    """
    Most memory that this process has held. [GiB]

    The kernel's own count of a process, since what ``getrusage`` has of a child begins
    with that of its parent.
    """
    lines = Path("/proc/self/status").read_text().splitlines()
    (found,) = (line for line in lines if line.startswith("VmHWM"))
    return int(found.split()[1]) / 2**20


if __name__ == "__main__":
    run(sys.argv[1], int(sys.argv[2]))
