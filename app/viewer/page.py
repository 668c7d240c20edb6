"""The viewer's page: viser's own, without its panels, under a policy that allows exactly its own scripts.

viser ships one HTML file: a small inline loader that unpacks styles and program from an attribute and adds
them as inline elements. The policy names both scripts by their hashes, so no other script can run.
"""

import base64
import hashlib
import re
from dataclasses import dataclass
from functools import lru_cache
from html import unescape
from pathlib import Path
from typing import Final

import viser
import zstandard

from app.errors import Unavailable
from app.viewer.layers.palette import PALETTES, Palette
from estimators.sentences import say

_ALPHABET: Final = "".join(chr(code) for code in range(0x21, 0x7F) if chr(code) not in "\"&<>'`")
_SCRIPT: Final = re.compile(r"<script(?P<attributes>[^>]*)>(?P<code>.*?)</script>", re.DOTALL)
_TITLE: Final = "Movement in 3D"

# The page lives in a frame that rarely has the focus, and viser's page reconnects only with the focus.
_KEEP_CONNECTING: Final = "document.hasFocus=()=>true;"

# viser compiles what sorts Gaussian splats from text, which the policy refuses with a report on every page. We show no
# splats: refused here first, in the same words to the program and without the noise.
_NO_EVALUATION: Final = (
    "{const no=()=>{throw new EvalError('not evaluated here')};"
    "window.Function=new Proxy(Function,{apply:no,construct:no});"
    "for(const kind of ['error','unhandledrejection'])addEventListener(kind,e=>{"
    "if((e.error??e.reason) instanceof EvalError)e.preventDefault()})}"
)

# A canvas says nothing to a screen reader; the numbers are in the page around the frame.
_DESCRIBE: Final = (
    "new MutationObserver((_,o)=>{const c=document.querySelector('canvas[data-engine]');"
    f"if(c){{c.setAttribute('role','img');c.setAttribute('aria-label','{_TITLE}');o.disconnect()}}}})"
    ".observe(document,{childList:true,subtree:true});"
)


@dataclass(frozen=True)
class Page:
    """The page and the hashes of its scripts.

    Attributes
    ----------
    script_hashes : tuple of str
        `'sha256-...'`, for the policy.
    """

    html: str
    script_hashes: tuple[str, ...]

    def policy(self, socket_origin: str) -> str:
        """Return the content security policy.

        Parameters
        ----------
        socket_origin : str
            `wss://host`, for browsers that do not count sockets as 'self'.

        Notes
        -----
        WebAssembly unpacks the page and its messages; blob workers hold the socket; the component library
        writes style elements; `data:` serves images and fonts that the page carries inside.
        """
        return "; ".join(
            [
                "default-src 'none'",
                f"script-src {' '.join(self.script_hashes)} 'wasm-unsafe-eval'",
                "style-src 'unsafe-inline'",
                "img-src 'self' data: blob:",
                "font-src data:",
                f"connect-src 'self' {socket_origin} data: blob:",
                "worker-src blob:",
                "object-src 'none'",
                "base-uri 'none'",
                "form-action 'none'",
                "frame-ancestors 'self'",
            ]
        )


@lru_cache(maxsize=1)
def build_page() -> Page:
    """Return the page of the installed viser.

    Raises
    ------
    Unavailable
        The installed viser has another page than the one this was written for.
    """
    source = (Path(viser.__file__).parent / "client" / "build" / "index.html").read_text(encoding="utf-8")
    scripts = list(_SCRIPT.finditer(source))
    if len(scripts) != 1:
        raise Unavailable(say("viewer.version"))
    loader = scripts[0]
    hashes = [_hash(loader["code"]), _hash(_packed_program(loader["attributes"]))]
    own = _KEEP_CONNECTING + _NO_EVALUATION + _DESCRIBE
    hashes.append(_hash(own))
    addition = f"<script>{own}</script><style>{_styles()}</style>"
    html = re.sub(r"<title>.*?</title>", lambda _: f"<title>{_TITLE}</title>", source, count=1)
    html = re.sub(r'<link\s+rel="icon".*?/>', "", html, count=1, flags=re.DOTALL)
    html = html.replace("</title>", "</title>" + addition, 1)
    return Page(html, tuple(hashes))


def _packed_program(attributes: str) -> str:
    """Unpack the program that the loader will add as an inline script."""
    found = {name: unescape(value) for name, value in re.findall(r'data-(\w+)="([^"]*)"', attributes)}
    try:
        unpacked = zstandard.ZstdDecompressor().decompress(
            _from_base88(found["p"]), max_output_size=int(found["ss"]) + int(found["cs"])
        )
        return unpacked[int(found["ss"]) :].decode("utf-8")
    except (KeyError, ValueError, zstandard.ZstdError) as error:
        raise Unavailable(say("viewer.version")) from error


def _from_base88(text: str) -> bytes:
    """Decode viser's text form of bytes: five characters for four bytes, n + 1 for the last n."""
    value_of = {character: number for number, character in enumerate(_ALPHABET)}
    digits = [value_of[character] for character in text]
    whole = len(digits) // 5
    out = bytearray()
    for group in range(whole):
        number = 0
        for digit in digits[5 * group : 5 * group + 5]:
            number = number * 88 + digit
        out += number.to_bytes(4, "big")
    rest = digits[5 * whole :]
    if rest:
        number = 0
        for digit in rest:
            number = number * 88 + digit
        out += number.to_bytes(len(rest) - 1, "big")
    return bytes(out)


def _hash(code: str) -> str:
    digest = hashlib.sha256(code.encode("utf-8")).digest()
    return f"'sha256-{base64.b64encode(digest).decode()}'"


def _styles() -> str:
    """Hide viser's panels and notes, which are for programmers, and give the page its background."""

    def sky(theme: Palette) -> str:
        return f"background:linear-gradient({theme.background_top},{theme.background_bottom})"

    return (
        "html,body,#root{height:100%;margin:0}"
        ".mantine-Notifications-root,.mantine-Paper-root,.mantine-Affix-root,[data-testid^=floating-panel]"
        "{display:none!important}"
        f"canvas[data-engine]{{{sky(PALETTES['light'])}}}"
        f"[data-mantine-color-scheme=dark] canvas[data-engine]{{{sky(PALETTES['dark'])}}}"
        f"html{{background:{PALETTES['light'].background_bottom}}}"
        f"html[data-mantine-color-scheme=dark]{{background:{PALETTES['dark'].background_bottom}}}"
    )
