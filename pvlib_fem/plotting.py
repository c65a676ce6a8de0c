"""Pictures of fits. matplotlib is imported here only, and only when one is drawn."""

import numpy as np
import pandas as pd


def plot_fit(fit, ax=None):
    """
    Measured and modelled temperature on the most variable held-out day.

    Parameters
    ----------
    fit : FemFit
    ax : matplotlib Axes, optional
        Where to draw; a new figure without it.

    Returns
    -------
    matplotlib Axes
    """
    import matplotlib.pyplot as plt
    from matplotlib.dates import ConciseDateFormatter

    if ax is None:
        ax = plt.subplots(figsize=(8, 4), layout="constrained")[1]
    record = fit.record
    days = record.days
    change = np.abs(np.diff(record["poa_global"], prepend=np.nan))
    seen = fit.holdout.to_numpy() if fit.test_days else np.ones(len(days), bool)
    roughness = np.bincount(days[seen], np.nan_to_num(change[seen]))
    rows = days == int(np.argmax(roughness))
    measured = pd.Series(record["temp_module"], record.index)[rows]
    modelled = measured - fit.residual[rows]
    sun = pd.Series(record["poa_global"], record.index)[rows]

    irradiance = ax.twinx()
    irradiance.fill_between(sun.index, sun, color="0.88", linewidth=0)
    irradiance.set_ylabel("irradiance [W/m²]", color="0.5")
    irradiance.set_ylim(bottom=0)
    ax.set_zorder(irradiance.get_zorder() + 1)
    ax.patch.set_visible(False)
    ax.plot(measured.index, measured, color="black", linewidth=1.2, label="measured")
    label = f"{fit.model}, {fit.dynamics}"
    ax.plot(modelled.index, modelled, color="#d55e00", linewidth=1.2, label=label)
    ax.set_ylabel("module temperature [°C]")
    part = "held out" if fit.test_days else "fitted"
    ax.set_title(f"{measured.index[0]:%Y-%m-%d}, {part}")
    ax.legend(loc="upper left", frameon=False)
    ax.xaxis.set_major_formatter(ConciseDateFormatter(ax.xaxis.get_major_locator()))
    return ax
