import os

import numpy as np
import pytest

from pvlib_fem import datasets

DRIVERS = ("poa_global", "temp_air", "wind_speed")
COLUMNS = (*DRIVERS, "temp_module")


@pytest.fixture(scope="session")
def month():
    """Drivers of thirty days at 1 min, without sensor noise."""
    return datasets.synthetic(days=30, seed=1, noise=0)


@pytest.fixture(scope="session")
def drivers(month):
    return tuple(month[name] for name in DRIVERS)


@pytest.fixture(scope="session")
def week():
    """The measured week, where a user would find it."""
    try:
        return datasets.load("sandia_week")
    except OSError as error:
        pytest.skip(f"no measured week: set {datasets.FOLDER} or go online ({error})")


@pytest.fixture(scope="session")
def day():
    """The measured day, where a user would find it."""
    try:
        return datasets.load("sandia_day")
    except OSError as error:
        pytest.skip(f"no measured day: set {datasets.FOLDER} or go online ({error})")


@pytest.fixture
def noise():
    """Reproducible noise: ``noise(rows, sd)`` is white."""
    return lambda rows, sd=0.2, seed=0: np.random.default_rng(seed).normal(0, sd, rows)


os.environ.setdefault("MPLBACKEND", "Agg")
