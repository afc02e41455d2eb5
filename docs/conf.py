"""Settings of Sphinx; ``build.py`` runs it on the pages that it has put together."""

from __future__ import annotations

from irsim_gym import __version__

project = "irsim_gym"
author = "The irsim_gym authors"
copyright = author
release = version = __version__

extensions = ["myst_nb", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx.ext.viewcode"]
exclude_patterns = ["files/**"]

myst_heading_anchors = 4
myst_enable_extensions = ["colon_fence"]
nb_execution_mode = "off"  # notebooks are shown with the outputs that they are committed with
nb_render_image_options = {"alt": "What the cell above draws"}

autodoc_typehints = "signature"
autodoc_member_order = "bysource"
autodoc_preserve_defaults = True
autodoc_class_signature = "mixed"
napoleon_google_docstring = True
napoleon_numpy_docstring = False
napoleon_use_ivar = True
add_module_names = False
python_maximum_signature_line_length = 100

html_theme = "furo"
html_title = f"irsim_gym {version}"
html_static_path = ["_static"]
html_extra_path = ["../build/site-source/extra"]  # films
html_css_files = ["site.css"]
html_show_sphinx = False
html_copy_source = False
html_show_search_summary = False  # summaries are fetched, which browsers refuse without a server
