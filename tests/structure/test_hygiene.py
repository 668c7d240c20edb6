"""Tracked files name no machine and no registry; docstrings say more than signatures do."""

import ast
import re
import subprocess
from importlib import metadata
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
SECTION = re.compile(r"^(?:Parameters|Attributes)\n-+\n((?:.+\n?)*)", re.MULTILINE)
KIND = r"(?:[a-z]+|[A-Z]+[a-z]\w*)"
ONLY_NAME_AND_TYPE = re.compile(
    rf"^\w+(?:, \w+)* : {KIND}(?:(?: or | of | to | \| ){KIND})*(?:, optional)?$(?!\n )",
    re.MULTILINE,
)
EXTRAS = re.compile(r"(?P<name>[\w.-]+)\[(?P<extras>[^]]+)\]")


def tracked(*patterns: str) -> list[Path]:
    listing = subprocess.run(
        ["git", "ls-files", "--", *patterns], cwd=ROOT, capture_output=True, text=True, check=True
    ).stdout
    return [ROOT / line for line in listing.splitlines() if (ROOT / line).is_file()]


def test_locks_hold_no_registry_addresses() -> None:
    for path in tracked("requirements*.lock", "web/package-lock.json", "web/.npmrc"):
        text = path.read_text()
        assert not re.search(r"index[-]url|\"resolved\": *\"https?:/{2}|^registry *=", text, re.MULTILINE), (
            path
        )


def test_no_machine_paths_in_tracked_files() -> None:
    pattern = re.compile(r"[/]root[/]|[/]work[/](main|shared)|[/]tmp[/]bash_jobs")
    found = []
    for path in tracked("*.py", "*.ts", "*.tsx", "*.md", "*.toml", "Makefile", "docker/*", ".ci/*"):
        if path == Path(__file__):
            continue
        if pattern.search(path.read_text()):
            found.append(path.name)
    assert not found


def test_test_data_names_its_origin_and_licence() -> None:
    for folder in (ROOT / "tests" / "data").iterdir():
        if folder.is_dir():
            names = {path.name for path in folder.iterdir()}
            assert "ORIGIN.md" in names, f"{folder.name} has no ORIGIN.md"
    total = sum(path.stat().st_size for path in tracked("tests/data"))
    assert total < 10e6, "test data is megabytes, not tens"


def test_the_lock_names_the_extras_that_packages_ask_of_each_other() -> None:
    # Without them pip looks at the newest release for the extra, and refuses it because it is not the locked one.
    asked = {
        (found["name"].lower().replace("_", "-"), found["extras"])
        for installed in metadata.distributions()
        for requirement in installed.requires or []
        if "extra ==" not in requirement and (found := EXTRAS.match(requirement))
    }
    lock = (ROOT / "requirements.lock").read_text().splitlines()
    pinned = [line.partition("==")[0] for line in lock if line[:1].isalnum()]
    missing = [f"{name}[{extras}]" for name, extras in asked if name in pinned]
    assert not missing, "make lock"


def test_entries_of_docstrings_say_more_than_the_signature() -> None:
    # Meaning, shape or unit: name and type stand in the signature already.
    found = []
    for path in tracked("app/*.py", "estimators/*.py", "published/*.py", "validation/*.py"):
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
                for entries in SECTION.findall(ast.get_docstring(node) or ""):
                    found += [
                        f"{path.name}: {node.name}: {one}" for one in ONLY_NAME_AND_TYPE.findall(entries)
                    ]
    assert not found
