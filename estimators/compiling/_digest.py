"""Digest of all that goes into a kernel's machine code, by which the cache knows it again.

It covers the bytecode of the kernel and of the functions that it calls, and the values of the constants that they read:
numbers, records, flags. Sentences, comments, docstrings, line numbers and whatever else a file imports do not count.
Implementations that are registered with `numba.extending.overload` are not seen: the library has none.
"""

import dis
import enum
import functools
import hashlib
from collections.abc import Callable, Iterator
from pathlib import Path
from types import BuiltinFunctionType, CodeType, FunctionType, ModuleType
from typing import Any, Final, NamedTuple

import numpy as np
from numba.core.dispatcher import Dispatcher
from numba.extending import _Intrinsic

_OURS: Final = frozenset({__name__.partition(".")[0], "app", "published", "validation"})
_COMPILER: Final = ("_quicker.py", "_units.py")
"""They decide how everything is compiled."""


class _Own(NamedTuple):
    """A function's own share of a digest, and the functions that it calls."""

    share: bytes
    called: tuple[FunctionType, ...]


def digest(function: Callable[..., Any], *options: object) -> bytes:
    """Return the digest of a kernel.

    Parameters
    ----------
    function : callable
        Plain Python function of the kernel.
    *options : object
        Further choices that decide its machine code; their `repr` counts.
    """
    whole = _with_called(function, {})
    return hashlib.sha256(b"".join([_basis(), repr(options).encode(), whole])).digest()


def goes_into(function: Callable[..., Any]) -> set[Callable[..., Any]]:
    """Return a kernel's function and all those of ours that it calls, and those that they call."""
    found: set[Callable[..., Any]] = set()
    left = [function]
    while left:
        one = left.pop()
        if one not in found:
            found.add(one)
            left += _own(one).called
    return found


def _with_called(function: Any, done: dict[Any, bytes]) -> bytes:
    """Return the digest of a function and, in their order, of those that it calls."""
    if function not in done:
        # Where functions call each other in a circle the name stands for what is under way.
        done[function] = f"{function.__module__}.{function.__qualname__}".encode()
        share, called = _own(function)
        parts = [share, *(_with_called(one, done) for one in called)]
        done[function] = hashlib.sha256(b"".join(parts)).digest()
    return done[function]


@functools.cache
def _basis() -> bytes:
    sources = b"".join(Path(__file__).with_name(name).read_bytes() for name in _COMPILER)
    return hashlib.sha256(np.__version__.encode() + sources).digest()


@functools.lru_cache(maxsize=4096)
def _own(function: Any) -> _Own:
    shares: list[bytes] = [f"{function.__module__}.{function.__qualname__}".encode()]
    called: list[FunctionType] = []
    for code in _codes(function.__code__):
        shares += [code.co_code, repr((code.co_varnames, code.co_freevars, code.co_names)).encode()]
    cells = [cell.cell_contents for cell in function.__closure__ or ()]
    for value in (function.__defaults__, function.__kwdefaults__, cells, *_constants(function)):
        shares.append(_described(value, called))
    return _Own(hashlib.sha256(b"\0".join(shares)).digest(), tuple(called))


def _codes(code: CodeType) -> Iterator[CodeType]:
    yield code
    for one in code.co_consts:
        if isinstance(one, CodeType):
            yield from _codes(one)


_LOADS_FIRST: Final = bytes((dis.opmap["LOAD_CONST"], 0))


def _constants(function: Any) -> Iterator[Any]:
    """Yield the constants of a function, and the globals of the names in it; of a module of ours what is read of it.

    Names of attributes stand among those of globals: one that is both is read too often, never too seldom.
    """
    for number, code in enumerate(_codes(function.__code__)):
        constants = [one for one in code.co_consts if not isinstance(one, CodeType)]
        is_documented = number == 0 and function.__doc__ is not None and code.co_consts[0] == function.__doc__
        if is_documented and _LOADS_FIRST not in (
            code.co_code[i : i + 2] for i in range(0, len(code.co_code), 2)
        ):
            constants = constants[1:]
        yield from constants
        for name in code.co_names:
            yield from _read(function.__globals__.get(name), code.co_names, set())


def _read(found: Any, names: tuple[str, ...], seen: set[int]) -> Iterator[Any]:
    if isinstance(found, ModuleType) and _is_ours(found.__name__):
        if id(found) not in seen:
            seen.add(id(found))
            for one in names:
                if hasattr(found, one):
                    yield one
                    yield from _read(getattr(found, one), names, seen)
    else:
        yield found


def _is_ours(module: str | None) -> bool:
    return (module or "").partition(".")[0] in _OURS


def _described(value: Any, called: list[FunctionType]) -> bytes:
    """Return what a value adds to machine code; functions whose code counts as well are added to `called`."""
    if isinstance(value, tuple | list):
        return repr(type(value)).encode() + b",".join(_described(one, called) for one in value) + b")"
    if isinstance(value, set | frozenset):
        return b"{" + b",".join(sorted(_described(one, called) for one in value)) + b"}"
    if isinstance(value, dict):
        return _described(list(value.items()), called)
    if isinstance(value, Dispatcher):
        called.append(value.py_func)
        name = f"{value.py_func.__module__}.{value.py_func.__qualname__}"
        return repr((name, value.targetoptions, getattr(value, "signature", None))).encode()
    if isinstance(value, _Intrinsic):
        value = value._defn
    if isinstance(value, FunctionType) and _is_ours(value.__module__):
        called.append(value)
    if isinstance(value, ModuleType | BuiltinFunctionType | FunctionType | np.ufunc):
        return f"{getattr(value, '__module__', '')}.{value.__name__}".encode()
    if isinstance(value, np.ndarray):
        return repr((value.dtype, value.shape)).encode() + value.tobytes()
    if isinstance(value, type):
        return _of_type(value)
    return f"{type(value)} {value!r}".encode()


def _of_type(kind: type) -> bytes:
    name = f"{kind.__module__}.{kind.__qualname__}"
    if issubclass(kind, enum.Enum):
        return repr((name, [(name, one.value) for name, one in kind.__members__.items()])).encode()
    return repr((name, getattr(kind, "_fields", ()))).encode()
