"""How much script the patient's pages load, counted in the built files; the 3D frame is a page of its own."""

import gzip
import json
from typing import Any

import pytest

from tests.e2e.conftest import ROOT

MOST_BYTES = 250_000
BUILT = ROOT / "web" / "dist"
SHOWN_AT_ONCE = {
    "src/pages/mine/Today.tsx": ["src/sensors/Unsent.tsx"],
    "src/pages/mine/Results.tsx": [],
    "src/pages/mine/MyData.tsx": [],
    "src/pages/mine/Replay.tsx": ["src/components/CameraBar.tsx"],
    "src/pages/mine/Live.tsx": ["src/sensors/ConnectSensors.tsx"],
}
"""The patient's pages, and the pieces that they show without being asked."""


def manifest() -> dict[str, Any]:
    path = BUILT / ".vite" / "manifest.json"
    assert path.exists(), "build the browser client first: make web"
    pieces: dict[str, Any] = json.loads(path.read_text())
    return pieces


def piece_of(pieces: dict[str, Any], page: str) -> str | None:
    """Return the piece that holds a page: by its path or, where other pieces share it, by its name; None: the entry."""
    stem = page.rsplit("/", 1)[-1].removesuffix(".tsx")
    shared = (
        name for name, piece in pieces.items() if piece.get("isDynamicEntry") and name.startswith(f"_{stem}-")
    )
    return page if page in pieces else next(shared, None)


def with_imports(pieces: dict[str, Any], *names: str) -> set[str]:
    """These pieces and all that comes with them."""
    found: set[str] = set()
    wanted = list(names)
    while wanted:
        name = wanted.pop()
        if name not in found:
            found.add(name)
            wanted.extend(pieces[name].get("imports", []))
    return found


def packed_bytes(name: str) -> int:
    return len(gzip.compress((BUILT / name).read_bytes(), 9))


LANGUAGES = ("en", "de")
"""A page is drawn when the words of one have come; the service's sentences come with the first of them."""


@pytest.mark.parametrize("language", LANGUAGES)
@pytest.mark.parametrize("page", SHOWN_AT_ONCE)
def test_a_page_of_the_patient_loads_little_script(page: str, language: str) -> None:
    pieces = manifest()
    # The first page to be seen comes with the entry.
    piece = piece_of(pieces, page)
    own = [] if piece is None else [piece]
    loaded = with_imports(pieces, "index.html", f"src/i18n/{language}/index.ts", *own, *SHOWN_AT_ONCE[page])
    sizes = {pieces[name]["file"]: packed_bytes(pieces[name]["file"]) for name in loaded}
    total = sum(sizes.values())
    largest = sorted(sizes.items(), key=lambda one: -one[1])[:6]
    print(f"{page} ({language}): {total / 1000:.1f} kB in {len(sizes)} files")
    assert total <= MOST_BYTES, f"{page} loads {total} bytes of script: {largest}"


def test_only_the_first_page_comes_with_the_entry() -> None:
    pieces = manifest()
    assert [page for page in SHOWN_AT_ONCE if piece_of(pieces, page) is None] == ["src/pages/mine/Today.tsx"]
    # What a page shows is still one of its pieces, not a name that nothing has.
    later = {one for piece in pieces.values() for one in piece.get("dynamicImports", [])}
    assert {one for shown in SHOWN_AT_ONCE.values() for one in shown} <= later
