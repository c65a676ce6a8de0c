"""Where systems are worked on: here, one after the other, or on Dask."""

import logging
import signal
from collections.abc import Callable, Generator, Iterable
from contextlib import contextmanager, suppress
from typing import Any
from uuid import uuid4

AHEAD = 4  # systems that wait for each thread, so that none waits for systems


#: a worker does one long thing at a time: its profile, and what asks fifty times a
#: second whether it is late, cost more than they tell; it holds nothing that could be
#: spilled, and its memory is bounded by its nanny alone. In glibc's arenas of threads,
#: and by its first thresholds, each temporary array would be new pages of memory.
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


def serial(work: Callable, systems: Iterable) -> Generator[dict, None, None]:
    """The answers of a bare loop."""
    for system in systems:
        yield work(system)


def on_dask(client: Any, work: Any, systems: Iterable) -> Generator[dict, None, None]:
    """
    The answers of a cluster's workers, in the order in which they come.

    Few systems more than there are threads are with the scheduler at any time, so that
    their number does not matter to it. A worker that is lost has its systems done by
    another, as Dask does; one that ends every worker is told in its answer.

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

    run, systems, whose = uuid4().hex[:8], iter(systems), {}
    waiting = as_completed(loop=client.loop)

    def fill(most):
        for system in systems:
            key = f"pvlib_fem-{run}-{system.id}"
            future = client.submit(work, system, key=key, pure=False)
            whose[key] = system
            waiting.add(future)
            if len(whose) >= most:
                return

    try:
        fill(AHEAD * threads(client))
        for batch in waiting.batches():
            for future in batch:
                system = whose.pop(future.key)
                try:
                    yield future.result()
                except KilledWorker as error:
                    yield work.ended(system, error)
            if len(whose) < (most := AHEAD * threads(client)):
                fill(most)
    finally:
        client.cancel(waiting.futures)


def threads(client):
    """How many systems are worked on at once; one where no worker is there yet."""
    return max(sum(client.nthreads().values()), 1)


@contextmanager
def client_of(client=None, workers=None, memory_limit="auto"):
    """
    A client: as given, of a scheduler's address, or of a cluster on this machine.

    Parameters
    ----------
    client : distributed.Client, str or None
    workers : int, optional
        Processes of one thread each; by default as many as there are cores.
    memory_limit : str, int or "auto"
        Of each; Dask ends a worker that goes beyond it.
    """
    import dask
    from distributed import Client, LocalCluster

    if client is not None and not isinstance(client, str):
        yield client
    elif client is not None:
        with Client(client, timeout="30s") as found:
            yield found
    else:
        with dask.config.set(WORKERS):
            cluster = LocalCluster(
                n_workers=workers or cores(),
                threads_per_worker=1,
                processes=True,
                memory_limit=memory_limit,
                dashboard_address="127.0.0.1:0",  # of no fixed port, and here only
                silence_logs=logging.ERROR,
            )
        with cluster, Client(cluster) as found:
            found.register_plugin(unhearing())
            yield found


def unhearing():
    """A plugin by which Ctrl-C, which a terminal sends to all, ends no worker."""
    from distributed import WorkerPlugin

    class Unhearing(WorkerPlugin):
        def setup(self, worker):
            with suppress(ValueError):  # of a thread that may not say so
                signal.signal(signal.SIGINT, signal.SIG_IGN)

    return Unhearing()


def cores():
    """Cores that this process may use."""
    from dask.system import CPU_COUNT

    return CPU_COUNT
