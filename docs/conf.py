"""The site of these pages, as Sphinx builds it: `make site`."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent / "_extensions"))

import mechid

project = "mechid"
author = "The mechid authors"
version = release = mechid.__version__
copyright = author
extensions = [
    "myst_nb",
    "sphinx_external_toc",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.napoleon",
    "mathml",
    "beside_docs",
    "modules",
    "public_names",
]
external_toc_path = "_toc.yml"
exclude_patterns = ["_build", "_extensions"]

# Strict: `make site` turns each warning into an error.
nitpicky = False
myst_enable_extensions = ["dollarmath", "amsmath"]
myst_heading_anchors = 4
myst_links_external_new_tab = False

# Offline: no fonts, scripts or pictures from elsewhere. Formulas are MathML, which browsers draw by themselves.
html_theme = "furo"
html_title = f"mechid {release}"
html_math_renderer = "mathml"
html_show_sphinx = False
html_copy_source = False
html_static_path = ["_static"]
html_css_files = ["mechid.css"]
templates_path = ["_templates"]

# `make site` runs the tutorials, each again when it has changed; `make pages` does not.
nb_execution_timeout = 1800
nb_execution_in_temp = True
nb_execution_raise_on_error = True
nb_merge_streams = True
nb_execution_mode = "off"

autodoc_typehints = "signature"
autodoc_member_order = "bysource"
autosummary_generate = True
autosummary_ignore_module_all = False
napoleon_google_docstring = False
napoleon_use_rtype = False
