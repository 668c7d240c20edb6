"""The arrows of the house: who may import whom. Walks the syntax trees, imports nothing."""

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]

NOUNS = {"accounts", "patients", "exercises", "recordings"}
FOUNDATION = {"errors", "schemas", "settings", "services", "database"}
# Rooms of `app` that each room may import, besides itself. `accounts` is below the other nouns.
ALLOWED = {
    "errors": set(),
    "schemas": set(),
    "settings": {"errors"},
    "services": {"settings"},
    "database": {"errors", "settings", "services"},
    "edge": FOUNDATION | {"accounts"},
    "accounts": FOUNDATION | {"patients"},
    "patients": FOUNDATION | {"accounts", "exercises", "recordings", "assessment"},
    "exercises": FOUNDATION | {"accounts", "patients", "recordings"},
    "ingest": FOUNDATION | {"accounts", "patients", "recordings"},
    "recordings": FOUNDATION | {"accounts", "patients", "exercises", "ingest"},
    "live": FOUNDATION | NOUNS | {"ingest", "assessment"},
    "assessment": FOUNDATION | NOUNS | {"live"},
    "viewer": FOUNDATION | NOUNS | {"live", "assessment"},
    "gateway": FOUNDATION | {"ingest", "live", "recordings", "accounts"},
}
TOP = {"main", "cli", "commands", "demo", "tables"}


def modules(package: str) -> list[Path]:
    return sorted((ROOT / package).rglob("*.py"))


def imported(path: Path, place: Path | None = None) -> set[str]:
    """Absolute dotted names that a module imports anywhere, also inside functions."""
    package = (place or path).relative_to(ROOT).with_suffix("").parts
    names: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            names.update(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            if node.level:
                base = ".".join(package[: len(package) - node.level])
                base = f"{base}.{node.module}" if node.module else base
                names.add(base)
                names.update(f"{base}.{alias.name}" for alias in node.names)
            elif node.module:
                names.add(node.module)
                names.update(f"{node.module}.{alias.name}" for alias in node.names)
    return names


@pytest.mark.parametrize("path", modules("estimators"), ids=lambda p: str(p.relative_to(ROOT)))
def test_the_library_knows_nothing_of_the_service(path: Path) -> None:
    wrong = {name for name in imported(path) if name.split(".")[0] in {"app", "tests", "migrations"}}
    banned = {"asyncio", "sqlalchemy", "fastapi", "requests", "httpx", "pickle"}
    wrong |= {name for name in imported(path) if name.split(".")[0] in banned}
    assert not wrong


@pytest.mark.parametrize("path", modules("app"), ids=lambda p: str(p.relative_to(ROOT)))
def test_rooms_of_the_service_import_only_what_they_may(path: Path) -> None:
    parts = path.relative_to(ROOT / "app").with_suffix("").parts
    room = parts[0]
    if room in TOP or room == "__init__":
        return
    wrong = set()
    for name in imported(path):
        pieces = name.split(".")
        if pieces[0] != "app" or len(pieces) < 2:
            continue
        other = pieces[1]
        if other != room and other not in ALLOWED[room]:
            wrong.add(name)
    assert not wrong


def test_nothing_imports_what_puts_the_service_together() -> None:
    for path in modules("app"):
        if path.relative_to(ROOT / "app").parts[0].removesuffix(".py") in TOP:
            continue
        wrong = {name for name in imported(path) if name.split(".")[:2] in (["app", "main"], ["app", "cli"])}
        assert not wrong, path


def test_the_walk_sees_imports_inside_functions_and_relative_ones(tmp_path: Path) -> None:
    example = ROOT / "app" / "patients" / "example.py"
    source = tmp_path / "example.py"
    source.write_text(
        "def f():\n    from app.main import create_app\n    from . import models\n    import app.cli\n"
    )
    names = imported(source, example)
    assert {"app.main", "app.main.create_app", "app.patients", "app.patients.models", "app.cli"} <= names


@pytest.mark.parametrize(
    "path", modules("app") + modules("estimators"), ids=lambda p: str(p.relative_to(ROOT))
)
def test_modules_stay_readable(path: Path) -> None:
    assert len(path.read_text().splitlines()) <= 500, "split by use case before 500 lines"
