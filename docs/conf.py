"""Sphinx's configuration: ``make docs`` builds the site into ``docs/_build/html``, offline and without a warning."""

from __future__ import annotations

import os
import sys
from pathlib import Path

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE / "_ext"))
os.environ["KINETOGRAPH_EXAMPLES"] = str(HERE / "_build" / "examples")  # where the examples write
os.environ.setdefault("MPLBACKEND", "Agg")

import kinetograph  # noqa: E402
from gallery import Order, written_pictures  # noqa: E402

project = "Kinetograph"
author = "Kinetograph contributors"
copyright = "Kinetograph contributors, MIT licence"
release = version = kinetograph.__version__

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "numpydoc",
    "sphinx_gallery.gen_gallery",
    "reference",
    "mathml",
]
exclude_patterns = ["_build", "_ext", "gallery/*.ipynb", "gallery/sg_execution_times.rst", "sg_execution_times.rst"]
smartquotes = False  # options of commands begin with two hyphens
suppress_warnings = ["config.cache"]  # the gallery's functions cannot be pickled: its pages are read anew

# Names between backticks in docstrings are links, and every one has to lead somewhere; types of other projects do not.
default_role = "py:obj"
nitpicky = True
nitpick_ignore_regex = [
    ("py:.*", r"(np|npt|numpy|asyncio|collections|typing|matplotlib|PIL|pathlib|types|enum|subprocess|sqlite3)\..*"),
    (
        "py:.*",
        r"(Any|Self|Callable|Iterable|Iterator|Mapping|Sequence|Path|ModuleType|TracebackType|NDArray|ArrayLike)",
    ),
    ("py:class", r"(msgspec\..*|dict\[str|tuple\[str)"),  # the fields of documents, whose types are texts
    ("py:class", r"(Answer|Interval|Links|Row)"),  # aliases and a type variable, spelt out where they are defined
]

autodoc_typehints_format = "short"
autodoc_type_aliases = {name: name for name in ("FloatArray", "IntArray", "BoolArray", "ComplexArray", "SingleArray")}
autodoc_member_order = "bysource"
autodoc_preserve_defaults = True
python_maximum_signature_line_length = 88
autosummary_generate = False
numpydoc_show_class_members = False
numpydoc_class_members_toctree = False

myst_enable_extensions = ["colon_fence", "deflist", "dollarmath", "fieldlist"]
myst_heading_anchors = 3

sphinx_gallery_conf = {
    "examples_dirs": "../examples",
    "gallery_dirs": "gallery",
    "ignore_pattern": r"clips\.py",
    "within_subsection_order": Order,
    "image_scrapers": (written_pictures,),
    "backreferences_dir": "gallery/backreferences",
    "doc_module": ("kinetograph",),
    "abort_on_example_error": True,
    "download_all_examples": False,
    "show_memory": False,
    "show_signature": False,
    "reset_argv": "gallery.no_arguments",
    "remove_config_comments": True,
    "min_reported_time": 1e9,
    "write_computation_times": False,
    "matplotlib_animations": False,
    "capture_repr": (),
    "notebook_extensions": set(),
    "copyfile_regex": r"clips\.py",
}

html_math_renderer = "mathml"
html_theme = "pydata_sphinx_theme"
html_title = "Kinetograph"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_sidebars = {"install": [], "tutorial": []}
html_show_sourcelink = False
html_copy_source = False
html_theme_options = {
    "navigation_with_keys": False,
    "show_toc_level": 2,
    "navbar_align": "left",
    "header_links_before_dropdown": 8,
    "footer_start": ["copyright"],
    "footer_end": [],
}
