"""Experiments that passed before with the same code are skipped.

The digest of an experiment covers every module of this repository that its module imports, directly or not, the
modules of this folder, the versions of Python and of the numerical packages, and the name of the processor. Digests
that passed lie in a folder of the user, which `TELEMOTION_TEST_CACHE` may name; `ALL=1` in the environment runs all.
"""

import ast
import functools
import hashlib
import os
import platform
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import metadata
from pathlib import Path

import pytest

from tests.benchmarks.machine import processor
from tests.structure.test_imports import imported
from validation import Protocol

ROOT = Path(__file__).parents[2]
PACKAGES = ("numpy", "scipy", "numba", "llvmlite", "vqf")
RUNS_ALL = frozenset({"validation"})
"""It imports every experiment; its own text counts, its imports do not."""


def folder() -> Path:
    """Return where digests that passed lie."""
    named = os.environ.get("TELEMOTION_TEST_CACHE")
    caches = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(named) if named else Path(caches) / "telemotion" / "experiments"


def file_of(module: str, root: Path) -> Path | None:
    """Return the file of a module of the repository, or nothing of a module from elsewhere."""
    path = root.joinpath(*module.split("."))
    return next((one for one in (path.with_suffix(".py"), path / "__init__.py") if one.is_file()), None)


@functools.cache
def needed(module: str, root: Path) -> frozenset[str]:
    """Return the modules of the repository that a module imports, or names in a text of its own.

    A registry names by a text what it loads when somebody asks for it.
    """
    file = file_of(module, root)
    assert file is not None
    texts = {
        node.value
        for node in ast.walk(ast.parse(file.read_bytes()))
        if isinstance(node, ast.Constant) and isinstance(node.value, str)
    }
    named = {one for one in texts if "." in one and one.replace(".", "").isidentifier()}
    return frozenset(
        one for one in named | imported(file, ROOT / file.relative_to(root)) if file_of(one, root) is not None
    )


def closure(modules: set[str], root: Path = ROOT) -> set[str]:
    """Return modules and all that they import, directly or not."""
    found: set[str] = set()
    left = set(modules)
    while left:
        module = left.pop()
        found.add(module)
        if module not in RUNS_ALL:
            left |= needed(module, root) - found
    return found


def digest(modules: set[str], root: Path = ROOT) -> str:
    """Return the digest of what modules import, of the experiments' tests, and of what they run on."""
    files = {file for module in closure(modules, root) if (file := file_of(module, root)) is not None}
    files.update((root / "tests" / "validation").glob("*.py"))
    versions = [sys.version, *(metadata.version(name) for name in PACKAGES), processor(), platform.machine()]
    whole = hashlib.sha256(repr(versions).encode())
    for file in sorted(files):
        whole.update(f"\0{file.relative_to(root)}\0".encode() + hashlib.sha256(file.read_bytes()).digest())
    return whole.hexdigest()


def modules_of(protocol: Protocol) -> set[str]:
    """Return the modules of an experiment, and that which runs it."""
    holding = {
        name
        for name, module in list(sys.modules.items())
        if name.startswith("validation.") and any(one is protocol for one in list(vars(module).values()))
    }
    assert holding, protocol.name
    return holding | RUNS_ALL | {"validation.protocol"}


@contextmanager
def unless_passed_before(name: str, modules: set[str], root: Path = ROOT) -> Iterator[None]:
    """Skip the test where an experiment passed before with the same code; remember it when it passes now."""
    passed = folder() / f"{name}-{digest(modules, root)}"
    if passed.exists() and not os.environ.get("ALL"):
        pytest.skip("passed before with the same code")
    yield
    passed.parent.mkdir(parents=True, exist_ok=True)
    passed.touch()
