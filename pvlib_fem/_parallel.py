"""Run tasks in processes; results and their order do not depend on the number."""

from collections.abc import Callable, Iterator

from joblib import Parallel, cpu_count, delayed, parallel_config
from joblib.externals.loky.process_executor import TerminatedWorkerError


def spread(
    function: Callable, tasks: list, processes: int | None = None, shared: tuple = ()
) -> Iterator:
    """
    Yield the result of a function for each task, in the order of the tasks.

    Parameters
    ----------
    function : callable
        Called as ``function(*shared, *task)``.
    tasks : iterable of tuple
    processes : int, optional
        Number of processes, by default the number of cores. With 1 all tasks run in
        this process.
    shared : tuple
        Arguments that all tasks share.

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
    # processes share the cores, so that each has one thread; without memory maps,
    # since tasks may write to their arrays
    with parallel_config("loky", n_jobs=processes, inner_max_num_threads=1):
        run = Parallel(return_as="generator", max_nbytes=None)
        try:
            yield from run(delayed(function)(*shared, *task) for task in tasks)
        except TerminatedWorkerError as error:
            raise RuntimeError(
                "a process ended before its work was done; where memory is short, give "
                "fewer processes, and processes=1 needs none"
            ) from error
