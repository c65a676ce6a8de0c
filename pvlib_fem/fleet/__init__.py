"""Process many systems, on one machine or on a Dask cluster."""

from pvlib_fem.fleet._report import report
from pvlib_fem.fleet._results import Results
from pvlib_fem.fleet._run import run

__all__ = ["Results", "report", "run"]
