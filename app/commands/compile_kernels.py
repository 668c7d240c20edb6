"""`telemotion compile`: every kernel into the cache, as in the making of an image or before tests."""

import multiprocessing
import pkgutil
from concurrent.futures import ProcessPoolExecutor
from importlib import import_module

import typer

import estimators
from estimators.compiling import Kernel


def compile_kernels(processes: int) -> None:
    """Compile what is in no cache yet.

    Parameters
    ----------
    processes : int
        At once; a kernel that one compiles the others wait for, where they need it.
    """
    with ProcessPoolExecutor(processes, multiprocessing.get_context("spawn"), import_all) as pool:
        count = sum(pool.map(_prepare, range(import_all())))
    typer.echo(f"{count} kernels are ready")


def import_all() -> int:
    """Import every module of the library, and the service with its own; returns how many kernels that makes."""
    import_module("app.main")
    for module in pkgutil.walk_packages(estimators.__path__, "estimators."):
        import_module(module.name)
    return len(Kernel.made)


def _prepare(number: int) -> int:
    Kernel.made[number].prepare()
    return 1
