"""BLAS on one thread, for as long as any loop runs, and trees on one."""

from collections.abc import Iterator
from contextlib import contextmanager
from threading import Lock

from threadpoolctl import threadpool_limits

LOCK = Lock()
#: the limits of the loops that run in any thread, the first one's first
RUNNING: list[threadpool_limits] = []


@contextmanager
def one_blas_thread() -> Iterator[None]:
    """
    Context in which BLAS runs on one thread.

    The number of threads is the process's own, so that only the last loop restores it.
    Else a loop that ends while another runs would restore the number that it found:
    one.

    Yields
    ------
    None
    """
    with LOCK:
        RUNNING.append(threadpool_limits(limits=1, user_api="blas"))
    try:
        yield
    finally:
        with LOCK:
            if len(RUNNING) > 1:
                RUNNING.pop()  # any but the first, which knows what was before
            else:
                RUNNING.pop().restore_original_limits()
