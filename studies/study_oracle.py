"""
What the loop decided by rules, before its statistical model, of the gate's records.

The rules are those of one commit. It is checked out for as long as this takes, and its
own study runs there, on the shifts, seeds and worlds of the gate. Run as
``python studies/study_oracle.py STUDY INSTRUMENTS``; the rows go there, pickled.
"""

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

COMMIT = "453ed13"  # Refuse by name a module that no sun warms
ROOT = Path(__file__).resolve().parents[1]


def by_rules(options):
    """Check the commit out, and run this file in it."""
    with tempfile.TemporaryDirectory() as folder:
        tree = Path(folder) / "rules"
        git("worktree", "add", "--detach", str(tree), COMMIT)
        try:
            script = shutil.copy(__file__, tree / "tests")
            command = [sys.executable, script, "--inside", *arguments_of(options)]
            paths = os.environ | {"PYTHONPATH": str(tree)}
            subprocess.run(command, cwd=tree, env=paths, check=True)
        finally:
            git("worktree", "remove", "--force", str(tree))


def git(*words):
    subprocess.run(["git", *words], cwd=ROOT, check=True)


def arguments_of(options):
    """The gate's records, in words for a script that does not know them."""
    from study_worlds import (
        GATE_EVERY,
        GATE_RECORDS,
        GATE_SEED,
        GATE_SHIFTS,
        WHOLE,
    )

    shifts = options.shift or GATE_SHIFTS
    yield from map(str, (options.study.resolve(), options.instruments.resolve()))
    yield from ("--shift", *map(str, shifts))
    yield from ("--every", str(options.every or GATE_EVERY), "--whole", *WHOLE)
    yield from ("--seed", str(options.seed or GATE_SEED))
    yield from ("--records", str(options.records or GATE_RECORDS))
    yield from ("--processes", str(options.processes))


def inside(options):
    """Rows by the modules next to this file, of its own commit."""
    import study
    import study_instruments

    import pvlib_fem

    tree = Path(__file__).resolve().parents[1]
    if not Path(pvlib_fem.__file__).resolve().is_relative_to(tree):
        raise ImportError(f"pvlib_fem is {pvlib_fem.__file__}, and not that of {tree}")

    def thinned(families=None, quick=False):
        for name, made in study.FAMILIES.items():
            thin = 1 if name in options.whole else options.every
            yield from list(made())[::thin]

    study.worlds = thinned
    table = study.run(processes=options.processes, shifts=options.shift)
    # words in place of this commit's own types, which another need not have
    table["verdicts"] = [
        tuple(map(str, some)) if isinstance(some, tuple) else some
        for some in table["verdicts"]
    ]
    table.to_pickle(options.study)
    how = options.records, options.seed, options.processes
    study_instruments.run(*how).to_pickle(options.instruments)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("study", type=Path, help="rows of the study, pickled")
    parser.add_argument("instruments", type=Path, help="rows of instruments, pickled")
    usual = "; by default the gate's"
    parser.add_argument("--shift", type=int, nargs="+", help="of seeds" + usual)
    parser.add_argument("--every", type=int, help="one world of so many" + usual)
    parser.add_argument("--seed", type=int, help="first of instruments" + usual)
    parser.add_argument("--records", type=int, help="of instruments" + usual)
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--whole", nargs="+", default=(), help=argparse.SUPPRESS)
    parser.add_argument("--inside", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args()
    (inside if options.inside else by_rules)(options)


if __name__ == "__main__":
    main()
