"""`telemotion compile`: every kernel into the cache, as in the making of an image or before tests."""

import gc
import multiprocessing
import os
import pkgutil
import shutil
import tempfile
from concurrent.futures import ProcessPoolExecutor
from importlib import import_module
from pathlib import Path

import typer

import estimators
from app.commands.options.starting import CompileOptions
from app.errors import InvalidInput
from estimators.compiling import PROCESSOR, Kernel, is_labelled, label


def compile_kernels(options: CompileOptions) -> None:
    """Compile what is in no cache yet, for this processor into its cache, or for a package into a folder."""
    into = options.into
    if into is None:
        _compile(options.processes)
        return
    if into.exists() and any(into.iterdir()) and not is_labelled(into):
        raise InvalidInput(f"{into} holds something else; name a new or empty folder")
    # Read by the processes that compile, when they import numba.
    os.environ |= {"NUMBA_CPU_NAME": PROCESSOR, "NUMBA_CPU_FEATURES": ""}
    with tempfile.TemporaryDirectory() as folder:
        os.environ["NUMBA_CACHE_DIR"] = folder
        count = _compile(options.processes)
        made = sorted(Path(folder).rglob("*.nb[ci]"))
        if len(made) < 2 * count:
            raise InvalidInput(f"of {count} kernels only {len(made) // 2} could be stored")
        into.mkdir(parents=True, exist_ok=True)
        for file in into.glob("*.nb[ci]"):
            file.unlink()
        for file in made:
            shutil.copy(file, into)
    label(into)


def _compile(processes: int) -> int:
    with ProcessPoolExecutor(processes, multiprocessing.get_context("spawn"), _begin) as pool:
        count = sum(pool.map(_prepare, range(import_all())))
    typer.echo(f"{count} kernels are ready")
    return count


def _begin() -> None:
    import_all()
    # A tenth of the time; what compiling leaves behind is a hundred megabytes.
    gc.disable()


def import_all() -> int:
    """Import every module of the library, and the service with its own; returns how many kernels that makes."""
    import_module("app.main")
    for module in pkgutil.walk_packages(estimators.__path__, "estimators."):
        import_module(module.name)
    return len(Kernel.made)


def _prepare(number: int) -> int:
    Kernel.made[number].prepare()
    return 1
