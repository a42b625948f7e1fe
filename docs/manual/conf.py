"""Sphinx's settings of the manual, which `packaging/manual.py` builds."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import engine

#: Whether the scripts and notebooks are among the sources, which are run.
EXAMPLES = (Path(__file__).parent / "scripts").is_dir()

project = "Lightarc"
version = release = engine.__version__
extensions = [
    *(["myst_nb", "sphinx_gallery.gen_gallery"] if EXAMPLES else ["myst_parser"]),
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx_copybutton",
    "sphinx_design",
]
root_doc = "index"
html_theme = "furo"
html_title = "Lightarc"
html_static_path = ["_static"]
html_css_files = ["lightarc.css"]
html_show_copyright = False
html_copy_source = False
html_theme_options = {"navigation_with_keys": True}
myst_enable_extensions = ["attrs_inline", "colon_fence", "deflist"]
myst_heading_anchors = 3
copybutton_prompt_text = "$ "
copybutton_line_continuation_character = "\\"
default_role = "code"
autodoc_typehints = "none"
autodoc_member_order = "bysource"
napoleon_google_docstring = False
napoleon_use_rtype = False
smartquotes = False  # two dashes are the beginning of an option
pygments_style = "tango"
exclude_patterns = ["scripts", "gallery/*.ipynb", "gallery/*.py"]
nb_execution_mode = "auto"
nb_execution_raise_on_error = True
nb_execution_timeout = 300
sphinx_gallery_conf = {
    "examples_dirs": "scripts",
    "gallery_dirs": "gallery",
    "within_subsection_order": "FileNameSortKey",
    "abort_on_example_error": True,
    "download_all_examples": False,
    "show_memory": False,
    "show_signature": False,
    "write_computation_times": False,
    "min_reported_time": 3600,
}


def show_bars(_app: Any, _kind: str, _name: str, _found: object, _options: object, lines: list[str]) -> None:
    """Docstrings write |x| for a magnitude, which reStructuredText takes for a substitution."""
    lines[:] = [line.replace("|", "\\|") for line in lines]


def setup(app: Any) -> None:
    app.connect("autodoc-process-docstring", show_bars)
