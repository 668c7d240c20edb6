"""`telemotion compile`: every kernel into the cache, as in the making of an image or before tests."""

import gc
import multiprocessing
import os
import pkgutil
import shutil
import sys
import tempfile
from collections.abc import Callable, Iterable
from importlib import import_module
from pathlib import Path
from typing import Any, Final

import typer

import estimators
import published
from app.commands.options.starting import CompileOptions
from app.errors import InvalidInput
from estimators.compiling import PROCESSOR, Kernel, goes_into, is_labelled, label

_EMITTING: Final = 0.3
"""Time to optimise and emit a part in each kernel that takes it in, beside that to lower it once."""


def compile_kernels(options: CompileOptions) -> None:
    """Compile what is in no cache yet, for this processor into its cache, or for a package into a folder."""
    into = options.into
    if into is None:
        # Forked, a process has imported all there is; no thread was begun and nothing compiled.
        _compile(options.processes, "fork" if sys.platform == "linux" else "spawn")
        return
    if into.exists() and any(into.iterdir()) and not is_labelled(into):
        raise InvalidInput(f"{into} holds something else; name a new or empty folder")
    # Read by the processes that compile, when they import numba.
    os.environ |= {"NUMBA_CPU_NAME": PROCESSOR, "NUMBA_CPU_FEATURES": ""}
    with tempfile.TemporaryDirectory() as folder:
        os.environ["NUMBA_CACHE_DIR"] = folder
        count = _compile(options.processes, "spawn")
        made = sorted(Path(folder).rglob("*.nb[ci]"))
        if len(made) < 2 * count:
            raise InvalidInput(f"of {count} kernels only {len(made) // 2} could be stored")
        into.mkdir(parents=True, exist_ok=True)
        for file in into.glob("*.nb[ci]"):
            file.unlink()
        for file in made:
            shutil.copy(file, into)
    label(into)


def _compile(processes: int, start_method: str) -> int:
    count = import_all()
    orders = _orders([goes_into(kernel.py_func) for kernel in Kernel.made], processes)
    multiprocessing.set_start_method(start_method, force=True)
    begun = multiprocessing.Array("b", count)
    working = [multiprocessing.Process(target=_work, args=(order, begun)) for order in orders]
    for one in working:
        one.start()
    for one in working:
        one.join()
    if any(one.exitcode for one in working):
        raise RuntimeError("a process that compiles kernels ended early; what it printed says why")
    typer.echo(f"{count} kernels are ready")
    return count


def _work(order: list[int], begun: Any) -> None:
    """Compile the kernels that no other process has begun."""
    import_all()
    # Collecting what numba makes, at its usual pace, is a tenth of the time; never, and memory is what slows it.
    gc.freeze()
    gc.set_threshold(20_000)
    for number in order:
        with begun.get_lock():
            is_mine, begun[number] = not begun[number], 1
        if is_mine:
            Kernel.made[number].prepare()


def _orders(parts: list[set[Callable[..., Any]]], processes: int) -> list[list[int]]:
    """Return in which order each process takes the kernels: its own from the large ones on, then those of others.

    A process lowers a part once, for all of its kernels. A kernel goes where least is to be done with it.
    """
    own: list[list[int]] = [[] for _ in range(processes)]
    lowered: list[set[Callable[..., Any]]] = [set() for _ in range(processes)]
    emitted = [0.0] * processes
    for number in sorted(range(len(parts)), key=lambda n: -_length(parts[n])):
        costs = [_length(done | parts[number]) + spent for done, spent in zip(lowered, emitted, strict=True)]
        chosen = costs.index(min(costs))
        own[chosen].append(number)
        lowered[chosen] |= parts[number]
        emitted[chosen] += _EMITTING * _length(parts[number])
    # Who is ready first helps the others from their small end.
    return [mine + [n for theirs in own if theirs is not mine for n in reversed(theirs)] for mine in own]


def _length(functions: Iterable[Callable[..., Any]]) -> int:
    return sum(len(one.__code__.co_code) for one in functions)


def import_all() -> int:
    """Import every module of the library, and the service with its own; returns how many kernels that makes."""
    import_module("app.main")
    for package in (estimators, published):
        for module in pkgutil.walk_packages(package.__path__, f"{package.__name__}."):
            import_module(module.name)
    return len(Kernel.made)
