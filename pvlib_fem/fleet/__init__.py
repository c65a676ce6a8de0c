"""Many systems at once, on one machine or on any that Dask runs on."""

from pvlib_fem.fleet.run import Results, run

__all__ = ["Results", "run"]
