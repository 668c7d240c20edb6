"""Every page of the documentation site can be reached from its first page; Sphinx is not needed to see that."""

import re
from pathlib import Path

DOCS = Path(__file__).resolve().parents[2] / "docs"
PAGES = {
    path.relative_to(DOCS).with_suffix("").as_posix()
    for path in DOCS.rglob("*")
    if path.suffix in (".md", ".rst") and "_site" not in path.parts
}
_TREE = re.compile(r"^```\{toctree\}\n(.*?)^```", re.MULTILINE | re.DOTALL)


def entries(page: str, text: str) -> set[str]:
    """Return the pages that a page's toctrees name, with those that a pattern stands for."""
    found = set()
    for tree in _TREE.findall(text):
        for line in tree.splitlines():
            if not line.strip() or line.startswith(":"):
                continue
            name = line[1:] if line.startswith("/") else (Path(page).parent / line).as_posix()
            found |= {one for one in PAGES if Path(one).match(name)} if "*" in name else {name}
    return found


def linked() -> dict[str, set[str]]:
    return {page: entries(page, source(page)) for page in PAGES}


def source(page: str) -> str:
    [path] = [path for path in (DOCS / f"{page}.md", DOCS / f"{page}.rst") if path.is_file()]
    return path.read_text(encoding="utf-8")


def test_toctrees_name_pages_that_are_there() -> None:
    missing = {page: names - PAGES for page, names in linked().items() if names - PAGES}
    assert not missing


def test_every_page_is_reached_from_the_first() -> None:
    trees, reached, pending = linked(), set(), {"index"}
    while pending:
        reached |= pending
        pending = {name for page in pending for name in trees[page]} - reached
    assert PAGES - reached == set(), "name it in a toctree, docs/index.md or the page it belongs to"


def test_each_page_has_one_place() -> None:
    named = [name for names in linked().values() for name in names]
    assert not {name for name in named if named.count(name) > 1}, "in one toctree only"


def test_the_reference_names_modules_that_are_there() -> None:
    for page in (DOCS / "reference").glob("*.rst"):
        for module in re.findall(r"^\.\. automodule:: (\S+)", page.read_text(), re.MULTILINE):
            path = DOCS.parent / module.replace(".", "/")
            assert path.with_suffix(".py").is_file() or (path / "__init__.py").is_file(), module


def test_a_toctree_is_read_with_its_options_and_patterns() -> None:
    text = "# A\n\n```{toctree}\n:glob:\n:hidden:\n\n/index\n0*\n```\n"
    found = entries("decisions/index", text)
    assert "index" in found
    assert any(name.startswith("decisions/0001") for name in found)
    assert len(found) > 10
