"""Settings of Sphinx for the site (build.py)."""

import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]

project = "vibro-impact"
copyright = "the vibro-impact maintainers"
release = re.search(r'^version = "(.*)"', (ROOT / "Cargo.toml").read_text(), re.MULTILINE)[1]
extensions = ["myst_nb", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx.ext.mathjax", "sphinx-mathjax-offline"]
# As GitHub reads these pages: equations between dollars, anchors from headings.
myst_enable_extensions = ["dollarmath", "attrs_inline"]
myst_heading_anchors = 6
myst_fence_as_directive = ["math"]
root_doc = "index"
html_theme = "furo"
html_title = f"vibro-impact {release}"
html_copy_source = False
html_extra_path = ["llms.txt"]
html_static_path = ["static"]
html_css_files = ["wide.css"]
nb_execution_timeout = 120  # s: each notebook takes less than two minutes
nb_execution_raise_on_error = True
autodoc_member_order = "bysource"
autodoc_typehints = "signature"

suppress_warnings = ["myst-nb.lexer", "ref.python"]


def setup(app):
    """Shows tables of records without colours, and bars in docstrings as absolute values."""
    from pygments.lexers.special import TextLexer

    app.add_lexer("csv", TextLexer)
    app.connect("autodoc-process-docstring", lambda *given: given[-1].__setitem__(slice(None), [line.replace("|", "\\|") for line in given[-1]]))
