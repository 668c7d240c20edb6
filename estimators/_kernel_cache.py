"""Where compiled kernels are retained, and when they are out of date.

Numba keeps a compiled function until its own file changes. Ours put helpers and constants of other files into
themselves, so an edited helper would leave old machine code behind that still runs and gives old numbers. The
locators here make a kernel as old as the youngest file that it imports, directly or through others.

What a process compiles comes from what it imported. Files that were edited since then say nothing of that, so a
kernel of theirs is neither stored nor taken from the cache.
"""

import functools
import re
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, Final

import numba
from numba.core import caching

_ROOT: Final = Path(__file__).parents[1]
_IMPORTED_AT_S: Final = time.time()


@functools.cache
def imported_files(file: Path, root: Path = _ROOT) -> tuple[Path, ...]:
    """Return the files under `root` that a Python file imports, directly or through others, and itself.

    Parameters
    ----------
    file : Path
        A module under `root`.
    root : Path
        Folder that holds the packages; what lies elsewhere (numba, numpy) has versions and does not count.

    Returns
    -------
    tuple of Path
        Sorted.
    """
    found: set[Path] = set()
    waiting = [file]
    while waiting:
        one = waiting.pop()
        if one not in found:
            found.add(one)
            waiting.extend(_direct(one, root))
    return tuple(sorted(found))


_IMPORT: Final = re.compile(
    r"(?:^|[;:])[ \t\f]*(?:from[ \t]+(?P<module>[\w.]+)[ \t]+import\b[ \t]*"
    r"(?:\((?P<listed>[\w\s.,]*)\)|(?P<named>[^\n;(]*))"
    r"|import[ \t]+(?P<whole>[^\n;]*))",
    re.MULTILINE,
)
_VERSIONED: Final = {"llvmlite", "numba", "numpy", "scipy"}
"""Installed beside us, and known to numba's cache by their versions."""
_NO_WORDS: Final = re.compile(r"#[^\n]*|\\\n")
"""Comments, and ends of lines that are none."""


@functools.cache
def _direct(file: Path, root: Path) -> tuple[Path, ...]:
    # Kernels share most of what they import: without memory a start would read every file five times. Every start waits
    # for this, and a syntax tree takes fifteen times as long. What a string says like an import counts too.
    found: set[Path] = set()
    for one in _IMPORT.finditer(_NO_WORDS.sub(" ", file.read_text(encoding="utf-8-sig", errors="replace"))):
        module = one["module"]
        if module is None:
            for name in _names(one["whole"]):
                found.update(_module(name, root))
        elif not module.startswith("."):
            for name in _names(one["listed"] or one["named"] or ""):
                # A module taken out of its package, or else a name that the package's own file defines.
                found.update(_module(f"{module}.{name}", root) or _module(module, root))
    return tuple(found)


def _names(listed: str) -> Iterator[str]:
    """Yield what an import lists, without the names that are given to it."""
    for one in listed.split(","):
        if words := one.split():
            yield words[0]


@functools.cache
def _module(name: str, root: Path) -> tuple[Path, ...]:
    if name.partition(".")[0] in _VERSIONED:
        return ()
    place = root.joinpath(*name.split("."))
    return tuple(path for path in (place.with_suffix(".py"), place / "__init__.py") if path.is_file())


def is_current(file: Path, root: Path = _ROOT, since_s: float = _IMPORTED_AT_S) -> bool:
    """Say whether a file and all that it imports under `root` are what this process may have imported.

    Parameters
    ----------
    file, root : Path
        As for `imported_files`.
    since_s : float
        Wall clock before the first of them was imported.
    """
    return all(one.stat().st_mtime <= since_s for one in imported_files(file, root))


class _WithImports:
    """Adds what a kernel's file imports to the stamp by which its compiled code is known."""

    _py_file: str
    from_function: Callable[..., Any]

    def get_source_stamp(self) -> tuple[bytes, ...]:
        return tuple(_digests(imported_files(Path(self._py_file))))


def _digests(files: tuple[Path, ...]) -> Iterator[bytes]:
    for file in files:
        state = file.stat()
        yield caching._hash_source_file(str(file), state.st_mtime, state.st_size)


class ProvidedLocator(_WithImports, caching.UserProvidedCacheLocator):  # type: ignore[misc]
    """In the folder that `NUMBA_CACHE_DIR` names."""


class InTreeLocator(_WithImports, caching.InTreeCacheLocator):  # type: ignore[misc]
    """Beside the source."""


class UserWideLocator(_WithImports, caching.UserWideCacheLocator):  # type: ignore[misc]
    """In the user's own cache folder, when the installation is read-only."""


def use() -> None:
    """Let numba keep kernels by the locators here, unless the surroundings name others."""
    if not numba.config.CACHE_LOCATOR_CLASSES:
        numba.config.CACHE_LOCATOR_CLASSES = ",".join(
            f"{__name__}.{kind.__name__}" for kind in (ProvidedLocator, InTreeLocator, UserWideLocator)
        )
