"""Run tasks in processes; results and their order do not depend on the number."""

import os
import pickle
import signal
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from functools import lru_cache
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from pathlib import Path
from tempfile import TemporaryDirectory
from threading import Thread
from typing import Any

from joblib import cpu_count, wrap_non_picklable_objects
from joblib.externals.loky import ProcessPoolExecutor, process_executor

#: variables that limit each process to one thread, since processes share the cores
THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


def spread(
    function: Callable,
    tasks: Iterable[tuple],
    processes: int | None = None,
    shared: tuple = (),
) -> Iterator[Any]:
    """
    Yield the result of a function for each task, in the order of the tasks.

    Each call starts processes of its own, which end with it. joblib would keep them for
    the next call, which waits for ever if the results of this one are not all taken.

    Parameters
    ----------
    function : callable
        Called as ``function(*shared, *task)``.
    tasks : iterable of tuple
    processes : int, optional
        Number of processes, by default the number of cores. With 1 all tasks run in
        this process.
    shared : tuple
        Arguments that all tasks share; each process reads them once.

    Yields
    ------
    object

    Raises
    ------
    RuntimeError
        If a process ends before its work is done.
    """
    tasks = list(tasks)
    processes = min(processes or cpu_count(), max(len(tasks), 1))
    if processes == 1:
        yield from (function(*shared, *task) for task in tasks)
        return
    # the processes end if nobody holds the other end, even if this one is killed
    line, held = Pipe(duplex=False)
    with TemporaryDirectory(prefix="pvlib_fem-") as folder, line:
        path = Path(folder, "shared.pickle")
        packed = wrap_non_picklable_objects((function, shared), keep_wrapper=False)
        path.write_bytes(pickle.dumps(packed, pickle.HIGHEST_PROTOCOL))
        how: dict[str, Any] = dict(initializer=begin, initargs=(line,))
        pool = ProcessPoolExecutor(processes, **how, env=dict.fromkeys(THREADS, "1"))
        try:
            waiting = deque(pool.submit(work, path, task) for task in tasks)
            while waiting:
                yield waiting.popleft().result()
            pool.shutdown()
        except process_executor.TerminatedWorkerError as error:
            raise RuntimeError(
                "a process ended before its work was done; where memory is short, give "
                "fewer processes, and processes=1 needs none"
            ) from error
        finally:
            held.close()
            pool.shutdown()


def begin(line: Connection) -> None:
    # a terminal sends Ctrl-C to the processes, too; they end without a traceback
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    # otherwise loky restarts a process that grows by 300 MB, and warns of it in a
    # thread; where warnings are errors, the thread ends and the call waits for ever
    process_executor._USE_PSUTIL = False
    Thread(target=end_with, args=(line,), daemon=True).start()


def end_with(line: Connection) -> None:
    with suppress(EOFError):
        line.recv()
    os._exit(1)


def work(path: Path, task: tuple) -> Any:
    function, shared = loaded(path)
    return function(*shared, *task)


@lru_cache(maxsize=1)
def loaded(path: Path) -> Any:
    """The function and the arguments that all tasks share."""
    return pickle.loads(path.read_bytes())
