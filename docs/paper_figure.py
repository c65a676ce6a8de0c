"""
The figure of paper.md: the mean residual of a year, before and after the loop.

``python docs/paper_figure.py [paper.png]``
"""

import sys

import matplotlib

matplotlib.use("agg")
import matplotlib.pyplot as plt
from pvlib.location import Location

import pvlib_fem as fem

HIDDEN = {"sky_radiation": 1.0, "wind_direction": 1.0, "weekend_exhaust": 0.5}
SITE = Location(49.4, 8.7, tz="Etc/GMT-1")


def closed(**record):
    """The loop on the simulated year of README.md, whose causes it does not know."""
    simulator = fem.simulator
    data = simulator.record(effects=simulator.PHYSICS | HIDDEN, step=300, **record)
    data = data.drop(columns=["longwave_down", "p_dc_per_area"])
    return fem.close_loop(data, location=SITE, surface_tilt=35, surface_azimuth=180)


def draw(loop, path):
    """Mean residual by hour and month, before any effect and after the last."""
    figure, axes = plt.subplots(1, 2, figsize=(9, 3.6), layout="constrained")
    residuals = {"before": loop.residual_before, "after": loop.fit.residual}
    for ax, (when, residual) in zip(axes, residuals.items()):
        fem.plotting.plot_residual_map(residual, ax, limit=2.0)
        ax.set_title(when)
    figure.savefig(path, dpi=200)
    plt.close(figure)


if __name__ == "__main__":
    draw(closed(), sys.argv[1] if sys.argv[1:] else "paper.png")
