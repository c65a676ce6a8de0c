"""The documentation: Markdown by MyST, the API by numpydoc, examples by gallery."""

import os
import sys
import warnings
from pathlib import Path

import pvlib_fem

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / "docs" / "_ext"))
import gallery_look  # noqa: E402

project = "pvlib_fem"
author = "pvlib_fem developers"
copyright = author
version = release = pvlib_fem.__version__

extensions = [
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.extlinks",
    "numpydoc",
    "myst_parser",
    "sphinx_design",
    "sphinx_gallery.gen_gallery",
    "effects_page",
    "offline_math",
]
templates_path = ["_templates"]
root_doc = "index"
exclude_patterns = ["_build", "gallery/**/*.md5", "gallery/**/*.ipynb"]
nitpicky = True
# what numpydoc takes for a link in "float, default 1" and the like is a word
nitpick_ignore_regex = [("py:.*", r"^(?!pvlib_fem).*")]

autosummary_generate = True
autodoc_typehints = "none"  # the docstrings say it, with shape and unit
numpydoc_show_class_members = False
numpydoc_xref_param_type = False
extlinks = {"doi": ("https://doi.org/%s", "doi:%s")}

myst_enable_extensions = ["colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 3

html_theme = "pydata_sphinx_theme"
html_title = f"pvlib_fem {release}"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_show_sourcelink = False
html_sidebars = {"index": []}
html_context = {"default_mode": "auto"}
html_theme_options = {
    "logo": {"text": "pvlib_fem"},
    "show_prev_next": True,
    "secondary_sidebar_items": {
        "*": ["page-toc"],
        "guide/**": ["page-toc"],
        "generated/**": ["page-toc"],
        "gallery/**": [],
    },
    "navigation_with_keys": False,
    "show_toc_level": 2,
}


sphinx_gallery_conf = {
    "examples_dirs": str(ROOT / "gallery"),
    "gallery_dirs": "gallery",
    "filename_pattern": r"\.py$",
    "within_subsection_order": "FileNameSortKey",
    "image_scrapers": ("gallery_look.scrape",),
    "thumbnail_size": gallery_look.PIXELS,
    "reset_modules": ("gallery_look.reset",),
    "download_all_examples": False,
    "show_memory": False,
    "capture_repr": (),
    "min_reported_time": 0,
    "show_signature": False,
    "remove_config_comments": True,
    "abort_on_example_error": True,
    "plot_gallery": "True",
    "parallel": 2,
}

# pandas 3 warns of a call that pvlib itself makes
warnings.filterwarnings("ignore", "DatetimeIndex.dayofyear is deprecated")
os.environ.setdefault("MPLBACKEND", "agg")
