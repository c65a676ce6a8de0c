"""Fit many systems, or close the loop on them, and store the results."""

from collections.abc import Callable, Mapping
from contextlib import ExitStack, closing, suppress
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pandas as pd

from pvlib_fem._loop.progress import item_counter
from pvlib_fem.fleet._engine import client_of, on_dask, serial
from pvlib_fem.fleet._results import Results
from pvlib_fem.fleet._store import check_labels, write_tables
from pvlib_fem.fleet._system_work import Work
from pvlib_fem.fleet._systems_table import opened_table, systems_of
from pvlib_fem.fleet._tasks import TASKS, check_task
from pvlib_fem.types import FilePath

if TYPE_CHECKING:
    from distributed import Client

NEEDED = ("pyarrow", "fsspec", "distributed")


def run(
    systems: pd.DataFrame | FilePath,
    out: FilePath,
    task: str = "loop",
    client: "Client | str | None" = None,
    workers: int | None = None,
    resume: bool = True,
    pages: bool = False,
    memory_limit: str | int = "auto",
    progress: Callable[[dict], object] | bool | None = None,
    **options: Any,
) -> Results:
    """
    Run a task for each system of a table, on one machine or on many.

    Workers read the files, run the task and write one file per system; this process
    handles only names and states of systems. At the end tables are made from all files.
    They do not depend on the number of workers, to the bit.

    Parameters
    ----------
    systems : DataFrame or path
        A table, or its CSV, Excel or Parquet file, with a row for each system: ``id``,
        ``file`` (path, pattern or URL that fsspec opens; files of several loggers
        joined by ``|``), and any of ``site``, ``latitude``, ``longitude``,
        ``surface_tilt``, ``surface_azimuth`` [°], or of a tracker ``axis_tilt``,
        ``axis_azimuth``, ``max_angle`` [°], ``gcr``, ``backtrack``, ``pdc0`` [W],
        ``steady_model`` instead of the run's ``model`` (``ross`` for records without
        wind), the options of :func:`pvlib_fem.read_file` by name, ``poa_global`` and
        the others for the name of the column in the file, ``poa_global_unit`` for its
        unit. All other columns are labels. Relative paths start at the folder of the
        table.
    out : path
        Folder of the results, to which all workers have access.
    task : str, default "loop"
        ``"fit"``, which is :func:`pvlib_fem.fit_fem`, ``"loop"``,
        :func:`pvlib_fem.close_loop`, or ``"recover"``,
        :func:`pvlib_fem.recover_effects`.
    client : distributed.Client or str, optional
        A client, or the address of a scheduler; by default a cluster on this machine.
    workers : int, optional
        Processes of that cluster, by default one per core; with 0 all systems run in
        this process, without Dask.
    resume : bool, default True
        Keep results of the same files, row, options and version. Systems that failed
        because of their data are kept as failed; other failures are tried again.
    pages : bool, default False
        Write each system's page with pictures, too; this doubles the time.
    memory_limit : str or int, default "auto"
        Memory limit of each worker of the cluster on this machine, as for Dask.
    progress : callable or bool, optional
        Function that is called with the answer of each system; True shows a bar. By
        default a bar on a terminal.
    **options
        Options of the task, such as ``model="pvsyst"`` or
        ``criteria=Criteria(chance=0.01)``.

    Returns
    -------
    Results

    Raises
    ------
    ValueError
        If the table is wrong, before any file is read; the message names the system
        and the cell. A file that cannot be used is a row with its message instead.
    OSError
        If results cannot be written. Results until then are kept.

    Notes
    -----
    A script that calls this function needs ``if __name__ == "__main__":``, because
    workers are separate processes.

    After an interrupt, the tables are made from the results so far.

    Examples
    --------
    See :doc:`/guide/fleet`.
    """
    check_options(task, pages, options)
    if workers is not None and workers < 0:
        raise ValueError(f"workers = {workers}; give 0, 1 or more")
    table = opened_table(systems)
    check_labels(table)
    for system in systems_of(table):  # refuses wrong rows before the work
        del system
    out = Path(out).absolute()
    Path(out, "results").mkdir(parents=True, exist_ok=True)
    work = Work(str(out), task, resume, pages, options)
    try:
        with ExitStack() as stack:
            show = reporter(stack, progress, len(table))
            if workers == 0:
                answers = serial(work, systems_of(table))
            else:
                connected = stack.enter_context(
                    client_of(client, workers, memory_limit)
                )
                answers = on_dask(connected, work, systems_of(table))
            for answer in stack.enter_context(closing(answers)):
                show(answer)
    except KeyboardInterrupt:
        with suppress(OSError):
            write_tables(out, table, task)
        raise
    write_tables(out, table, task)
    return Results(out)


def check_options(task: str, pages: bool, options: Mapping[str, Any]) -> None:
    """Refuse options that no system could use, before the work."""
    check_task(task, options)
    if missing := [name for name in NEEDED if find_spec(name) is None]:
        raise ValueError(
            f"a fleet needs {' and '.join(missing)}: pip install 'pvlib_fem[fleet]'"
        )
    if pages and not TASKS[task].paged:
        raise ValueError(f"the task {task} makes no pages")
    if pages and find_spec("matplotlib") is None:
        raise ValueError("pages need matplotlib: pip install 'pvlib_fem[plot]'")


def reporter(
    stack: ExitStack, progress: Callable[[dict], object] | bool | None, total: int
) -> Callable[[dict], object]:
    """The function to call with each answer."""
    if callable(progress):
        return progress
    show = stack.enter_context(item_counter(total, 0, progress, "systems"))
    failed = 0

    def count(answer: dict) -> None:
        nonlocal failed
        failed += answer["state"] == "failed"
        show(f"{failed:,} failed")

    return count
