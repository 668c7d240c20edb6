"""The arrows of the house: who may import whom. Walks the syntax trees, imports nothing."""

import ast
import functools
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]

FOUNDATION = {
    "errors",
    "schemas",
    "settings",
    "services",
    "pages",
    "database",
    "processes",
    "limits",
    "logs",
}
# Rooms of `app` that each room may import, besides itself, from the lowest to the highest. The nouns stand on each
# other in one order: accounts, patients, exercises, recordings.
ALLOWED = {
    "errors": set(),
    "schemas": set(),
    "version": set(),
    "time_zones": set(),
    "settings": {"errors", "time_zones"},
    "limits": {"errors", "settings"},
    "logs": {"errors", "settings"},
    "services": {"settings", "limits"},
    "processes": {"errors"},
    "pages": {"errors", "services", "settings"},
    "database": {"errors", "settings", "services"},
    "network": {"errors", "schemas"},
    "readers": {"errors", "schemas", "network"},
    "accounts": FOUNDATION | {"time_zones"},
    "edge": FOUNDATION | {"accounts", "version"},
    "accuracy": FOUNDATION | {"accounts"},
    "patients": FOUNDATION | {"accounts"},
    "exercises": FOUNDATION | {"accounts", "patients"},
    "recordings": FOUNDATION | {"accounts", "patients", "exercises", "network", "readers", "version"},
    "ingest": FOUNDATION | {"accounts", "network", "readers", "recordings"},
    "kinds/arm": FOUNDATION | {"accounts", "patients", "exercises", "recordings", "network"},
    "kinds/orientation": FOUNDATION | {"recordings"},
    "kinds/balance": FOUNDATION | {"accounts", "recordings"},
    "kinds/walk": FOUNDATION | {"accounts", "patients", "exercises", "recordings", "readers", "network"},
    "kinds/magnetic": FOUNDATION
    | {"accounts", "patients", "exercises", "recordings", "network", "kinds/walk"},
    "live": FOUNDATION
    | {
        "time_zones",
        "accounts",
        "patients",
        "exercises",
        "recordings",
        "network",
        "ingest",
        "kinds/magnetic",
        "assessment",
    },
    "assessment": FOUNDATION
    | {"version"}
    | {
        "time_zones",
        "accounts",
        "patients",
        "exercises",
        "recordings",
        "network",
        "ingest",
        "kinds/walk",
        "kinds/magnetic",
    },
    "viewer": FOUNDATION | {"accounts", "patients", "exercises", "recordings", "live", "assessment"},
    "scaled": FOUNDATION | {"accounts", "recordings", "network", "ingest", "live"},
    "gateway": FOUNDATION | {"accounts", "recordings", "network", "live", "kinds/magnetic"},
}
# Above all rooms: the command `demo` runs the demonstration, which sends its recordings as the command `upload` does.
TOP_CIRCLES = {frozenset({"commands", "demo"})}
TOP = {"main", "parts", "observation", "cli", "commands", "demo", "tables"}


def modules(package: str) -> list[Path]:
    return sorted((ROOT / package).rglob("*.py"))


@functools.cache
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


def libraries() -> list[Path]:
    return modules("messages") + modules("estimators") + modules("published") + modules("validation")


def test_the_libraries_know_nothing_of_the_service() -> None:
    banned = {"asyncio", "sqlalchemy", "fastapi", "requests", "httpx", "pickle", "app", "tests", "migrations"}
    above = {
        "messages": banned | {"validation", "published", "estimators"},
        "estimators": banned | {"validation", "published"},
        # The registry loads what stands there by its name, when somebody chooses it.
        "published": banned | {"validation"},
        "validation": banned,
    }
    wrong = {
        f"{dotted(path)} imports {name}"
        for path in libraries()
        for name in imported(path)
        if name.split(".")[0] in above[dotted(path).split(".")[0]]
    }
    assert not wrong


def test_rooms_of_the_service_import_only_what_they_may() -> None:
    wrong = {
        f"{dotted(path)} imports {name}"
        for path in modules("app")
        if (room := room_of(dotted(path))) not in TOP | {"", "kinds"}
        for name in imported(path)
        if (other := room_of(name)) and other != room and other not in ALLOWED[room]
    }
    assert not wrong


def room_of(name: str) -> str:
    """Return the room of a dotted name, `live` or `kinds/walk`; empty for what is in none."""
    pieces = name.split(".")
    if pieces[0] != "app" or len(pieces) < 2:
        return ""
    if pieces[1] == "kinds" and len(pieces) > 2:
        return f"kinds/{pieces[2]}"
    return pieces[1]


def rooms() -> dict[str, set[str]]:
    """Which rooms of `app` each room imports."""
    graph: dict[str, set[str]] = {}
    for path in modules("app"):
        room = room_of(dotted(path))
        others = {room_of(name) for name in imported(path)} - {"", room}
        graph.setdefault(room, set()).update(others)
    return {room: others & set(graph) for room, others in graph.items()}


def module_graph() -> dict[str, set[str]]:
    """Which modules each module imports, also inside functions; a package stands for its `__init__`."""
    paths = {dotted(path): path for path in modules("app") + libraries()}
    graph = {}
    for name, path in paths.items():
        names = imported(path)
        # `from package import module` names the package too, but needs only the module.
        children: dict[str, list[str]] = {}
        for other in names:
            children.setdefault(other.rpartition(".")[0], []).append(other)
        only_passed = {other for other in names if other in children and set(children[other]) <= set(paths)}
        graph[name] = (names & set(paths)) - only_passed - {name}
    return graph


def dotted(path: Path) -> str:
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def circles(graph: dict[str, set[str]]) -> set[frozenset[str]]:
    """Return the groups in which everybody reaches everybody (strongly connected, of two or more)."""
    reached = {name: reachable(graph, name) for name in graph}
    groups = {
        frozenset({name} | {other for other in reached[name] if name in reached.get(other, set())})
        for name in graph
    }
    return {group for group in groups if len(group) > 1}


def reachable(graph: dict[str, set[str]], start: str) -> set[str]:
    found: set[str] = set()
    ahead = [start]
    while ahead:
        for other in graph.get(ahead.pop(), set()) - found:
            found.add(other)
            ahead.append(other)
    return found


def test_rooms_import_each_other_in_no_circle() -> None:
    assert circles(rooms()) == TOP_CIRCLES


def test_the_arrows_that_are_allowed_make_no_circle() -> None:
    assert circles(ALLOWED) == set()


def test_modules_import_each_other_in_no_circle() -> None:
    assert circles(module_graph()) == set()


@pytest.mark.slow
def test_circles_are_found() -> None:
    graph = {"a": {"b"}, "b": {"c"}, "c": {"a", "d"}, "d": {"e"}, "e": {"d"}, "f": {"a"}, "g": set()}
    assert circles(graph) == {frozenset("abc"), frozenset("de")}
    assert circles({"a": {"b", "c"}, "b": {"c"}, "c": set()}) == set()
    assert len(module_graph()) > 100
    assert "accounts" in rooms()["patients"]


def test_nothing_imports_what_puts_the_service_together() -> None:
    for path in modules("app"):
        if path.relative_to(ROOT / "app").parts[0].removesuffix(".py") in TOP:
            continue
        above = (["app", "main"], ["app", "parts"], ["app", "cli"])
        wrong = {name for name in imported(path) if name.split(".")[:2] in above}
        assert not wrong, path


def test_the_walk_sees_imports_inside_functions_and_relative_ones(tmp_path: Path) -> None:
    example = ROOT / "app" / "patients" / "example.py"
    source = tmp_path / "example.py"
    source.write_text(
        "def f():\n    from app.main import create_app\n    from . import models\n    import app.cli\n"
    )
    names = imported(source, example)
    assert {"app.main", "app.main.create_app", "app.patients", "app.patients.models", "app.cli"} <= names


def test_modules_stay_readable() -> None:
    long = [dotted(path) for path in modules("app") + libraries() if len(path.read_text().splitlines()) > 500]
    assert not long, "split by use case before 500 lines"
