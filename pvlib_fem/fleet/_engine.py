"""Run the work on systems: in this process, or on Dask."""

import logging
import signal
from collections.abc import Callable, Generator, Iterable, Iterator
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING
from uuid import uuid4

if TYPE_CHECKING:
    from distributed import Client, Worker, WorkerPlugin

    from pvlib_fem.fleet._system_work import Work
    from pvlib_fem.fleet._systems_table import System

AHEAD = 4  # queued systems per thread, so that no thread waits


#: A worker runs one long task at a time, so the profiler and the event loop's tick
#: cost more than they help. It holds no data that could be spilled; only its nanny
#: limits its memory. With glibc's thread arenas and default thresholds, each temporary
#: array would need new pages of memory.
WORKERS = {
    "distributed.worker.profile.enabled": False,
    "distributed.admin.tick.interval": "1s",
    "distributed.worker.memory.target": False,
    "distributed.worker.memory.spill": False,
    "distributed.worker.memory.pause": False,
    "distributed.nanny.pre-spawn-environ": {
        "MALLOC_ARENA_MAX": 1,
        "MALLOC_MMAP_THRESHOLD_": 32 << 20,
        "MALLOC_TRIM_THRESHOLD_": 128 << 20,
        "MALLOC_TOP_PAD_": 32 << 20,
        "OMP_NUM_THREADS": 1,
        "OPENBLAS_NUM_THREADS": 1,
        "MKL_NUM_THREADS": 1,
    },
}


def serial(
    work: Callable[["System"], dict], systems: "Iterable[System]"
) -> Generator[dict, None, None]:
    """
    Yield the answers of a plain loop over the systems.

    Parameters
    ----------
    work : callable
        Takes a System and returns its answer, a dict.
    systems : iterable of System
        Systems in order.

    Yields
    ------
    dict
        Answer of each system, in their order.
    """
    for system in systems:
        yield work(system)


def on_dask(
    client: "Client", work: "Work", systems: "Iterable[System]"
) -> Generator[dict, None, None]:
    """
    Yield the answers of a cluster's workers, in the order in which they arrive.

    The scheduler has only a few more systems than threads at any time, so their total
    number does not matter. Dask moves the systems of a lost worker to another; the
    answer of a system that ends every worker is a failure.

    Parameters
    ----------
    client : distributed.Client
    work : Work
    systems : iterable of System

    Yields
    ------
    dict
    """
    from distributed import as_completed
    from distributed.scheduler import KilledWorker

    run, queue, waits = uuid4().hex[:8], iter(systems), {}
    waiting = as_completed(loop=client.loop)

    def fill(most: int) -> None:
        for system in queue:
            key = f"pvlib_fem-{run}-{system.id}"
            future = client.submit(work, system, key=key, pure=False)
            waits[key] = system
            waiting.add(future)
            if len(waits) >= most:
                return

    try:
        fill(AHEAD * threads(client))
        for batch in waiting.batches():
            for future in batch:
                system = waits.pop(future.key)
                try:
                    yield future.result()
                except KilledWorker as error:
                    yield work.ended(system, error)
            if len(waits) < (most := AHEAD * threads(client)):
                fill(most)
    finally:
        client.cancel(waiting.futures)


def threads(client: "Client") -> int:
    """Number of threads of all workers; at least one."""
    return max(sum(client.nthreads().values()), 1)


@contextmanager
def client_of(
    client: "Client | str | None" = None,
    workers: int | None = None,
    memory_limit: str | int = "auto",
) -> "Iterator[Client]":
    """
    The given client, or one for a scheduler's address or a cluster on this machine.

    Parameters
    ----------
    client : distributed.Client, str or None
        A client, which stays open; the address of a scheduler; or None for a cluster on
        this machine, which is closed at the end.
    workers : int, optional
        Number of processes with one thread each; by default the number of cores.
    memory_limit : str, int or "auto"
        Memory limit of each worker; Dask ends a worker that exceeds it.

    Yields
    ------
    distributed.Client
    """
    import dask
    from distributed import Client, LocalCluster

    if client is not None and not isinstance(client, str):
        yield client
    elif client is not None:
        with Client(client, timeout="30s") as connected:
            yield connected
    else:
        with dask.config.set(WORKERS):
            cluster = LocalCluster(
                n_workers=workers or cores(),
                threads_per_worker=1,
                processes=True,
                memory_limit=memory_limit,
                dashboard_address="127.0.0.1:0",  # any free port, this machine only
                # errors of systems are answers; workers that lose the scheduler, as
                # after Ctrl-C, would each log a traceback
                silence_logs=logging.CRITICAL,
            )
        with cluster, Client(cluster) as connected:
            connected.register_plugin(ignoring_interrupts())
            yield connected


def ignoring_interrupts() -> "WorkerPlugin":
    """A plugin that lets workers ignore Ctrl-C, which a terminal sends to them, too."""
    from distributed import WorkerPlugin

    class IgnoringInterrupts(WorkerPlugin):
        def setup(self, worker: "Worker") -> None:
            with suppress(ValueError):  # not in the main thread
                signal.signal(signal.SIGINT, signal.SIG_IGN)

    return IgnoringInterrupts()


def cores() -> int:
    """Cores that this process may use."""
    from dask.system import CPU_COUNT

    return CPU_COUNT
