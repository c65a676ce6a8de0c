"""
A year at 1 s in Parquet files: a fit and a loop of it against one read of its columns.

The files (1 GB) are made once in a temporary folder. Each work runs in a process of its
own on one thread of BLAS, in time of the processor.
"""

import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from before import peak

HERE = Path(__file__).parent
COLUMNS = ("poa_global", "temp_air", "wind_speed", "temp_module")
DAYS, MONTH = 365, 30


def made(folder):
    """The files, a month each, in single precision."""
    import pandas as pd

    import pvlib_fem as fem

    for first in range(0, DAYS, MONTH):
        days = min(MONTH, DAYS - first)
        data = fem.datasets.synthetic(days, step=1, seed=first)[list(COLUMNS)]
        data.index += pd.Timedelta(days=first)
        data.astype("float32").to_parquet(Path(folder) / f"{first:03d}.parquet")


def read(folder):
    """All columns once, by pyarrow."""
    import pyarrow.parquet as pq

    for file in sorted(Path(folder).glob("*.parquet")):
        with pq.ParquetFile(file) as opened:
            for _ in opened.iter_batches(batch_size=1 << 17):
                pass


def fit(folder, **how):
    import pvlib_fem as fem

    fem.fit_fem(folder, **how)


def loop(folder):
    import pvlib_fem as fem

    fem.close_loop(folder)


WORKS = {
    "read": read,
    "fit ewm": lambda folder: fit(folder, model="wm1", dynamics="ewm"),
    "fit balance": lambda folder: fit(folder, model="faiman", dynamics="balance"),
    "loop": loop,
}


def measured(work, folder):
    """Seconds of the processor and peak memory [GiB] of one work in a new process."""
    environment = os.environ | {"PYTHONPATH": str(HERE.parent), "OMP_NUM_THREADS": "1"}
    command = [sys.executable, __file__, work, str(folder)]
    given = dict(env=environment, check=True, capture_output=True, text=True)
    return json.loads(subprocess.run(command, **given).stdout)


def lines(folder=None):
    """Each work with its ratio and its reach."""
    if folder is None:
        with tempfile.TemporaryDirectory() as folder:
            made(folder)
            yield from lines(folder)
        return
    once = min(measured("read", folder)[0] for _ in range(3))
    seconds = {}
    for dynamics in ("ewm", "balance"):
        name = f"fit_fem, year at 1 s in files, {dynamics}"
        seconds[dynamics], peak = measured(f"fit {dynamics}", folder)
        over = (seconds[dynamics] - 5.0) / once
        yield f"{name}, less 5 s, against a read", f"{over:.0f} x", "<= 20 x"
        yield "its process at the peak", f"{peak:.2f} GiB", "<= 1 GiB"
    took, peak = measured("loop", folder)
    name = "close_loop, year at 1 s in files, against its fit"
    yield name, f"{took / seconds['balance']:.1f} x", "<= 2 x"
    yield "its process at the peak", f"{peak:.2f} GiB", "<= 1.5 GiB"


def run(work, folder):
    """Print what one work takes in this process."""
    start = time.process_time()
    WORKS[work](folder)
    print(json.dumps([time.process_time() - start, peak()]))


if __name__ == "__main__":
    run(*sys.argv[1:])
