"""Process many systems, on one machine or on a Dask cluster."""

from pvlib_fem.fleet.report import report
from pvlib_fem.fleet.results import Results
from pvlib_fem.fleet.run import run

__all__ = ["Results", "report", "run"]
