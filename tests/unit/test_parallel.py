"""Work that is spread over processes."""

import os
import signal

import numpy as np
import pytest

from pvlib_fem._parallel import spread


def squared(scale, number):
    return scale * number**2


def doubled(values):
    values *= 2.0
    return values


def killed():
    os.kill(os.getpid(), signal.SIGKILL)


def refused(number):
    raise ValueError(f"{number} is refused")


def threads():
    return os.environ["OMP_NUM_THREADS"]


@pytest.mark.parametrize("processes", [1, 2, 5])
def test_any_number_of_processes_gives_the_same_in_order(processes):
    found = list(spread(squared, [(n,) for n in range(7)], processes, shared=(3,)))
    assert found == [3 * n**2 for n in range(7)]


def test_a_task_may_write_to_its_arrays():
    """A memory map that processes share would refuse that."""
    values = np.ones(300_000)  # more than joblib copies by default
    for found in spread(doubled, [(), ()], 2, shared=(values,)):
        np.testing.assert_array_equal(found, 2.0)
    np.testing.assert_array_equal(values, 1.0)


def test_an_error_of_a_task_is_that_of_the_call():
    with pytest.raises(ValueError, match="3 is refused"):
        list(spread(refused, [(3,), (3,)], 2))


@pytest.mark.skipif(os.name == "nt", reason="no such signal")
def test_a_process_that_is_killed_is_an_error_with_a_remedy():
    with pytest.raises(RuntimeError, match="where memory is short, give fewer"):
        list(spread(killed, [(), ()], 2))


def test_processes_have_one_thread_each():
    assert {*spread(threads, [(), ()], 2)} == {"1"}
