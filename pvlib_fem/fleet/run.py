"""Fit many systems, or close the loop on them, and keep what comes of it."""

from collections.abc import Callable
from contextlib import ExitStack, closing, suppress
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pandas as pd

from pvlib_fem.fleet.engine import client_of, on_dask, serial
from pvlib_fem.fleet.results import Results
from pvlib_fem.fleet.store import compact
from pvlib_fem.fleet.table import opened, systems_of
from pvlib_fem.fleet.tasks import TASKS, check_task
from pvlib_fem.fleet.work import Work
from pvlib_fem.loop.progress import counting
from pvlib_fem.types import FilePath

NEEDED = ("pyarrow", "fsspec", "distributed")


def run(
    systems: pd.DataFrame | FilePath,
    out: FilePath,
    task: str = "loop",
    client: Any = None,
    workers: int | None = None,
    resume: bool = True,
    pages: bool = False,
    memory_limit: Any = "auto",
    progress: Callable[[dict], object] | bool | None = None,
    **options: Any,
) -> Results:
    """
    Do a task for each system of a table, on one machine or on many.

    Workers read the files, do the task and write a file each; only the names of
    systems and what became of them pass through here. In the end tables are made of
    all files. The same tables come of any number of workers, to the bit.

    Parameters
    ----------
    systems : DataFrame or path
        A table, or its CSV, Excel or Parquet file, with a row for each system: ``id``,
        ``file`` (path, pattern or URL that fsspec opens; files of several loggers
        joined by ``|``), and any of ``site``, ``latitude``, ``longitude``,
        ``surface_tilt``, ``surface_azimuth`` [°], ``pdc0`` [W], ``steady_model`` in the
        place of the run's ``model`` (``ross`` where there is no wind), the options of
        :func:`pvlib_fem.read_file` by name, ``poa_global`` and the others for the
        name of the column in the file, ``poa_global_unit`` for its unit. All other
        columns are labels. Relative paths are from the folder of the table.
    out : path
        Folder of the results, which all workers see.
    task : str, default "loop"
        ``"fit"``, which is :func:`pvlib_fem.fit_fem`, ``"loop"``,
        :func:`pvlib_fem.close_loop`, or ``"recover"``,
        :func:`pvlib_fem.recover_effects`.
    client : distributed.Client or str, optional
        Or the address of a scheduler; by default a cluster on this machine.
    workers : int, optional
        Processes of that cluster, by default one a core; 0 works here, without Dask.
    resume : bool, default True
        Keep what is there of the same files, row, options and version. Systems that
        failed because of their data are kept so; what failed otherwise is tried again.
    pages : bool, default False
        Write each system's page with pictures, too, which takes about as long again.
    memory_limit : str or int, default "auto"
        Of each worker of the cluster on this machine, as Dask takes it.
    progress : callable or bool, optional
        Called with what became of each system; True shows a bar. By default a bar on
        a terminal.
    **options
        Of the task, such as ``model="pvsyst"`` or ``criteria=Criteria(chance=0.01)``.

    Returns
    -------
    Results

    Raises
    ------
    ValueError
        If the table is wrong, before anything is read; the message names the system
        and the cell. A file that cannot be used is a row with its message instead.
    OSError
        If results cannot be written. What was done until then is kept.

    Notes
    -----
    A script that calls it needs ``if __name__ == "__main__":``, since workers are
    processes of their own.

    When it is interrupted the tables are made of what there is.

    Examples
    --------
    See :doc:`/guide/fleet`.
    """
    check(task, pages, options)
    table = opened(systems)
    for system in systems_of(table):  # refuses what is wrong before the work
        del system
    out = Path(out).absolute()
    Path(out, "results").mkdir(parents=True, exist_ok=True)
    work = Work(str(out), task, resume, pages, options)
    try:
        with ExitStack() as stack:
            tell = told(stack, progress, len(table))
            if workers == 0:
                answers = serial(work, systems_of(table))
            else:
                found = stack.enter_context(client_of(client, workers, memory_limit))
                answers = on_dask(found, work, systems_of(table))
            for answer in stack.enter_context(closing(answers)):
                tell(answer)
    except KeyboardInterrupt:
        with suppress(OSError):
            compact(out, table, task)
        raise
    compact(out, table, task)
    return Results(out)


def check(task, pages, options):
    """Refuse before the work what no system could do."""
    check_task(task, options)
    if lacking := [name for name in NEEDED if find_spec(name) is None]:
        raise ValueError(
            f"a fleet needs {' and '.join(lacking)}: pip install 'pvlib_fem[fleet]'"
        )
    if pages and not TASKS[task].paged:
        raise ValueError(f"the task {task} makes no pages")
    if pages and find_spec("matplotlib") is None:
        raise ValueError("pages need matplotlib: pip install 'pvlib_fem[plot]'")


def told(stack, progress, total):
    """A function that is told each answer."""
    if callable(progress):
        return progress
    tell = stack.enter_context(counting(total, 0, progress, "systems"))
    failed = 0

    def count(answer):
        nonlocal failed
        failed += answer["state"] == "failed"
        tell(f"{failed:,} failed")

    return count
