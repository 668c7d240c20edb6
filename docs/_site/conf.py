"""Settings of the documentation site; `make docs` builds it from the pages beside this folder.

Nothing here may need a network, neither to build the site nor to read it: no inventories of other projects, no
fonts, scripts or styles from elsewhere.
"""

import sys
from importlib import metadata
from pathlib import Path
from typing import Any

from numpy import bool_, float64, int64
from numpy.typing import ArrayLike, NDArray
from sphinx.application import Sphinx
from sphinx.util.typing import stringify_annotation

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parents[1])]

from mathml import font  # noqa: E402

from estimators.conventions import Placement  # noqa: E402

project = "Telemotion"
author = "The authors of Telemotion"
version = release = metadata.version("telemotion")

extensions = ["myst_parser", "sphinx.ext.autodoc", "numpydoc", "mathml"]
exclude_patterns = ["_site"]
root_doc = "index"

# Pages in Markdown.
myst_enable_extensions = ["colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 3

# Docstrings. A name in single backquotes is a link where the site has it, and code elsewhere.
default_role = "py:obj"
numpydoc_show_class_members = False
numpydoc_xref_param_type = False
autodoc_default_options = {"members": True, "member-order": "bysource"}
autodoc_typehints_format = "short"
autodoc_preserve_defaults = True
python_use_unqualified_type_names = True
python_maximum_signature_line_length = 88
add_module_names = False
toc_object_entries_show_parents = "hide"
# Names of other projects have no page here, nor do our own that are no part of a front door.
nitpick_ignore_regex = [("py:.*", "(?s).*")]

html_theme = "furo"
html_title = "Telemotion"
html_math_renderer = "mathml"
html_static_path = [str(HERE / "static"), str(font())]
html_css_files = ["site.css"]
html_copy_source = False
html_show_copyright = False
html_show_sphinx = False
html_theme_options = {
    "light_css_variables": {"color-brand-primary": "#0b6e69", "color-brand-content": "#0b6e69"},
    "dark_css_variables": {"color-brand-primary": "#5cc4bb", "color-brand-content": "#5cc4bb"},
}


def _without_fields(app: Sphinx, what: str, name: str, one: object, skip: bool, options: Any) -> bool | None:
    """Leave out the fields of named tuples: the docstring of the class explains them."""
    return True if (getattr(one, "__doc__", None) or "").startswith("Alias for field number") else None


_SHORT = {
    stringify_annotation(kind, "smart"): name
    for kind, name in [
        (ArrayLike, "ArrayLike"),
        (NDArray[float64], "Float"),
        (NDArray[int64], "NDArray[int64]"),
        (NDArray[bool_], "NDArray[bool]"),
        (Placement, "Placement"),
    ]
}


def _short_types(
    app: Sphinx, what: str, name: str, one: object, options: Any, signature: str | None, returned: str | None
) -> tuple[str | None, str | None]:
    """Write types as the source does, not spelled out."""
    for long, short in _SHORT.items():
        signature = signature and signature.replace(long, short)
        returned = returned and returned.replace(long, short)
    return signature, returned


def setup(app: Sphinx) -> None:
    """Connect the rules of what is left out and how types are written."""
    app.connect("autodoc-skip-member", _without_fields)
    app.connect("autodoc-process-signature", _short_types)
