"""Sphinx builds these pages into a site: `python -m sphinx -W --keep-going -b html docs site`.

The site asks nothing of the network: the theme's files, the search and all pictures lie in the build folder. Formulas
are MathML, which browsers set themselves (`_extensions/mathml.py`).
"""

import re
import sys
import textwrap
from pathlib import Path

from sphinx.application import Sphinx

sys.path[:0] = [str(Path(__file__).parent.parent), str(Path(__file__).parent / "_extensions")]

project = "octmip"
author = "the octmip developers"
copyright = "2026, the octmip developers"
html_title = "octmip"
extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx_copybutton",
    "sphinx_design",
    "sphinxcontrib.bibtex",
    "accessible",
    "example_pictures",
    "mathml",
    "notebooks",
]
exclude_patterns = ["_build", "_extensions"]

bibtex_bibfiles = ["references.bib"]
bibtex_reference_style = "author_year"

html_theme = "furo"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_copy_source = False
html_show_sourcelink = False
html_theme_options = {"navigation_with_keys": True}
pygments_style = "a11y-high-contrast-light"
pygments_dark_style = "a11y-high-contrast-dark"

myst_enable_extensions = ["attrs_block", "colon_fence", "dollarmath"]
myst_dmath_double_inline = False
html_math_renderer = "mathml"
myst_heading_anchors = 4

autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_typehints_format = "short"
autodoc_preserve_defaults = True
ROUTED = ("fit", "predict", "predict_proba", "score")  # scikit-learn's own methods
autodoc_default_options = {
    "members": True,
    "exclude-members": ", ".join(["get_metadata_routing", *(f"set_{name}_request" for name in ROUTED)]),
}
suppress_warnings = ["ref.python"]  # a field such as `name` belongs to several classes
napoleon_google_docstring = False
napoleon_use_rtype = False
napoleon_use_ivar = True
napoleon_attr_annotations = False
maximum_signature_line_length = 88
toc_object_entries_show_parents = "hide"

copybutton_prompt_text = r"\$ |>>> "
copybutton_prompt_is_regexp = True
copybutton_line_continuation_character = "\\"


ARRAY = re.compile(
    r"~?(?:numpy\.)?ndarray\[~?tuple\[(?:~?typing\.)?Any, \.\.\.\], ~?(?:numpy\.)?dtype\[~?(?:numpy\.)?(\w+)\]\]"
)
ARRAY_LIKE = re.compile(r"[\w.~]*_?Buffer \|.*?_NestedSequence\[(?:~?(?:complex|bytes|str|int|float|bool)|[ |])+\]")


def keep_tables(app: Sphinx, what: str, name: str, obj: object, options: object, lines: list[str]) -> None:
    """Set the aligned paragraphs of a module's docstring, its problem in mathematics or a table, as they are typed."""
    if what != "module":
        return
    paragraphs = "\n".join(lines).strip().split("\n\n")
    kept = [
        "::\n\n" + textwrap.indent(part, "    ") if re.search(r"\S   +\S|\n +\S", part) else part for part in paragraphs
    ]
    lines[:] = "\n\n".join([*kept, ""]).split("\n")


def escape_fitted(app: Sphinx, what: str, name: str, obj: object, options: object, lines: list[str]) -> None:
    """Escape the underscore that ends the name of a fitted attribute: to docutils it would be a link."""
    for number, line in enumerate(lines):
        plain_and_code = line.split("`")
        plain_and_code[::2] = (re.sub(r"(\w)_(?=[\s,;:.)]|$)", r"\1\\_", part) for part in plain_and_code[::2])
        lines[number] = "`".join(plain_and_code)


def shorten(
    app: Sphinx, what: str, name: str, obj: object, options: object, signature: str | None, returns: str | None
) -> tuple[str | None, ...]:
    """Return a signature whose arrays are written as the code writes them."""
    return tuple(text and ARRAY_LIKE.sub("ArrayLike", ARRAY.sub(r"NDArray[\1]", text)) for text in (signature, returns))


def setup(app: Sphinx) -> None:
    """Connect what this build does beside Sphinx."""
    app.connect("autodoc-process-docstring", keep_tables)
    app.connect("autodoc-process-docstring", escape_fitted, priority=600)  # after napoleon
    app.connect("autodoc-process-signature", shorten)
