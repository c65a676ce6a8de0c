"""Every example draws alike, whatever was drawn before it."""

from pathlib import Path

import matplotlib as mpl
import matplotlib.pyplot as plt
from sphinx_gallery.scrapers import matplotlib_scraper

from pvlib_fem.plotting import COLOURS

#: of a picture on the gallery's page, where its letters have to be read [inch]
SMALL = (5.0, 3.45)
PIXELS = (600, 414)


def scrape(block, block_vars, gallery_conf):
    """Pictures of a block; the one that stands for the example is drawn small, too."""
    chosen = block_vars["file_conf"]
    wanted = chosen.get("thumbnail_number", 1)
    first = len(block_vars["image_path_iterator"]) + 1
    figures = dict(enumerate(map(plt.figure, plt.get_fignums()), first))
    text = matplotlib_scraper(block, block_vars, gallery_conf)
    if wanted in figures and "thumbnail_path" not in chosen:
        path = Path(block_vars["target_file"]).parent / "images" / "small"
        path.mkdir(exist_ok=True)
        path /= f"{Path(block_vars['src_file']).stem}.png"
        figures[wanted].set_size_inches(SMALL)
        figures[wanted].savefig(path, dpi=PIXELS[0] / SMALL[0])
        # which the number would overrule
        chosen.pop("thumbnail_number", None)
        chosen["thumbnail_path"] = str(path)
    return text


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
