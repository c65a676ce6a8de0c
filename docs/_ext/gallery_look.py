"""Every example draws alike, whatever was drawn before it."""

import matplotlib as mpl

from pvlib_fem.plotting import COLOURS


def reset(gallery_conf, name):
    mpl.rcdefaults()
    mpl.use("agg")
    mpl.rcParams.update(
        {
            "axes.prop_cycle": mpl.cycler(color=COLOURS),
            "axes.spines.top": False,
            "axes.spines.right": False,
            "figure.dpi": 110,
        }
    )
