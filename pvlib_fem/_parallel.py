"""Run tasks in processes; results and their order do not depend on the number."""

import os
import pickle
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from multiprocessing import current_process, get_context, parent_process
from pathlib import Path
from tempfile import TemporaryDirectory
from threading import Thread
from typing import Any

#: variables that limit each process to one thread, since processes share the cores
THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
GUARD = (
    "A script has to call this under `if __name__ == '__main__':`, since each process "
    "reads the script anew"
)
WORK: list[
    Any
] = []  # in a process: the function, and the arguments that all tasks share


def spread(
    function: Callable,
    tasks: Iterable[tuple],
    processes: int | None = None,
    shared: tuple = (),
) -> Iterator[Any]:
    """
    Yield the result of a function for each task, in the order of the tasks.

    Parameters
    ----------
    function : callable
        Function at module level, called as ``function(*shared, *task)``.
    tasks : iterable of tuple
    processes : int, optional
        Number of processes, by default the number of cores. With 1 all tasks run in
        this process.
    shared : tuple
        Arguments that all tasks share; each process gets them once.

    Yields
    ------
    object

    Raises
    ------
    RuntimeError
        If a process ends before its work is done.
    """
    tasks = list(tasks)
    processes = min(processes or cores(), max(len(tasks), 1))
    if processes == 1:
        yield from (function(*shared, *task) for task in tasks)
        return
    how: dict[str, Any] = dict(mp_context=get_context("spawn"), initializer=begin)
    with (
        one_thread_each(),
        kept(shared) as path,
        ProcessPoolExecutor(processes, initargs=(function, path), **how) as pool,
    ):
        try:
            yield from pool.map(work, tasks)
        except BrokenProcessPool as error:
            raise RuntimeError(
                f"a process ended before its work was done. {GUARD}; where memory is "
                "short give fewer processes, and processes=1 needs none"
            ) from error


@contextmanager
def kept(shared: tuple) -> Iterator[Path]:
    """
    A temporary file of the arguments that all tasks share.

    Data in the pipe to a new process have to be small: Python waits for ever if a
    process ends before it has read more than the pipe holds.
    """
    with TemporaryDirectory(prefix="pvlib_fem-") as folder:
        path = Path(folder, "shared.pickle")
        path.write_bytes(pickle.dumps(shared, pickle.HIGHEST_PROTOCOL))
        yield path


def refuse_anew() -> None:
    """
    Refuse a call in a process that still imports the script of its parent.

    Otherwise each process would repeat the work that precedes the call.

    Raises
    ------
    RuntimeError
    """
    # Python checks this only when the process starts another
    if getattr(current_process(), "_inheriting", False):
        raise RuntimeError(GUARD)


def cores() -> int:
    """Cores that this process may use."""
    usable = getattr(os, "process_cpu_count", os.cpu_count)
    return usable() or 1


@contextmanager
def one_thread_each() -> Iterator[None]:
    """Start processes with one BLAS thread each."""
    before = {name: os.environ.get(name) for name in THREADS}
    os.environ.update(dict.fromkeys(THREADS, "1"))
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value


def begin(function: Callable, path: Path) -> None:
    WORK[:] = [function, pickle.loads(path.read_bytes())]
    Thread(target=end_with_parent, daemon=True).start()


def end_with_parent() -> None:
    """End with the parent; otherwise a process would wait for work for ever."""
    if (parent := parent_process()) is not None:
        parent.join()
    os._exit(1)


def work(task: tuple) -> Any:
    function, shared = WORK
    return function(*shared, *task)
