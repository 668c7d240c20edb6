"""Equations as MathML, written when the site is built: a browser draws them without a script and without a network."""

import re
import unicodedata
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Final

from docutils import nodes
from docutils.utils.math import MathError
from docutils.utils.math.latex2mathml import accents, parse_latex_math
from docutils.utils.math.mathml_elements import MathElement, math, mover, msub, munderover
from docutils.utils.math.tex2unichar import mathalpha
from sphinx.application import Sphinx
from sphinx.util import logging
from sphinx.util.math import get_node_equation_number
from sphinx.writers.html5 import HTML5Translator

_LOGGER = logging.getLogger(__name__)
_BOLD: Final = re.compile(r"\\boldsymbol\{\\(\w+)\}")
_NAMESPACE: Final = "http://www.w3.org/1998/Math/MathML"


def setup(app: Sphinx) -> dict[str, Any]:
    """Register the renderer under the name that `html_math_renderer` gives."""
    app.add_html_math_renderer("mathml", (_inline, None), (_block, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def font() -> Path:
    """Return the font of the equations; a package that is installed with Sphinx carries it."""
    found = find_spec("ziamath")
    assert found is not None
    assert found.origin is not None
    return Path(found.origin).parent / "fonts" / "STIXTwoMath-Regular.ttf"


def _bold(found: re.Match[str]) -> str:
    """Return a bold Greek letter, which docutils would not take beside other symbols."""
    name = unicodedata.name(mathalpha[found[1]]).removeprefix("GREEK ").replace("LETTER ", "")
    return unicodedata.lookup(f"MATHEMATICAL BOLD ITALIC {name}") + " "


def _tidied(node: MathElement) -> None:
    """Put the index of an accented letter beside it, not below as of a sum; bars of a norm stand close."""
    for place, child in enumerate(node):
        _tidied(child)
        if child.tag == "mo" and child.text == "|":
            child.set("lspace", "0")
            child.set("rspace", "0")
        if isinstance(child, munderover) and child[2].text in accents.values():
            base, index, accent = child
            node[place] = msub(mover(base, accent, accent=True), index)


def _converted(node: nodes.math | nodes.math_block, *, as_block: bool) -> str:
    """Return MathML; an equation that cannot be read is a warning, and so an error of `make docs`."""
    tree = math(xmlns=_NAMESPACE)
    if as_block:
        tree.set("display", "block")
    try:
        parse_latex_math(tree, _BOLD.sub(_bold, node.astext()))
    except MathError as error:
        _LOGGER.warning("equation: %s", error, location=node)
    _tidied(tree)
    return str(tree.toxml())


def _inline(writer: HTML5Translator, node: nodes.math) -> None:
    writer.body.append(_converted(node, as_block=False))
    raise nodes.SkipNode


def _block(writer: HTML5Translator, node: nodes.math_block) -> None:
    writer.body.append(writer.starttag(node, "div", CLASS="equation"))
    writer.body.append(_converted(node, as_block=True))
    if node["number"]:
        writer.body.append(f'<span class="eqno">({get_node_equation_number(writer, node)})')
        writer.add_permalink_ref(node, "Link to this equation")
        writer.body.append("</span>")
    writer.body.append("</div>\n")
    raise nodes.SkipNode
