"""Shorter ways through numba while a kernel is compiled: the same types and the same arithmetic, in less time.

Numba types and lowers in Python. Much of that time goes to questions that were answered before: which of some thirty
implementations of `+` fits two numbers, whether two sets of flags are equal, which variables an instruction holds. Here
answers are kept or found sooner. Besides, numba emits machine code for each of its own helpers (`np.empty`, slices),
which nothing calls once a kernel has taken them in: here they are parts as well.

It holds in `quicker()` only, under numba's own lock: what others compile in this process is compiled as ever. It
stands on what numba keeps to itself: `_units.py` knows for which version.
"""

import contextlib
from collections.abc import Callable, Iterator
from typing import Any, Final

from numba.core import ir, targetconfig
from numba.core.codegen import JITCPUCodegen
from numba.core.extending import overload
from numba.core.types.functions import BaseFunction
from numba.core.typing.templates import _OverloadFunctionTemplate
from numba.np import arrayobj

_get_call_type: Final = BaseFunction.get_call_type
_MOST_ANSWERS: Final = 100_000

_answers: dict[Any, Any] = {}


def _remembered_call_type(self: Any, context: Any, args: Any, kws: Any) -> Any:
    """Return the signature by which a function takes some types, from the first time that it was asked."""
    if kws or not all(one.is_precise() for one in args):
        return _get_call_type(self, context, args, kws)
    key = id(self), id(context), tuple(args), targetconfig.ConfigStack.top_or_none()
    found = _answers.get(key)
    if found is None:
        if len(_answers) > _MOST_ANSWERS:
            _answers.clear()
        # The function is kept: another one must not get its number.
        found = _answers[key] = self, _get_call_type(self, context, args, kws)
    return found[1]


def _are_equal(self: Any, other: Any) -> Any:
    if not isinstance(other, targetconfig.TargetConfig):
        return NotImplemented
    return self._values == other._values or self.values() == other.values()


def _hash_of_flags(self: Any) -> int:
    # Numba's own hashes the names of the flags, which are those of the class.
    return hash(type(self))


def _variables(_self: Any, value: Any) -> list[Any]:
    found: list[Any] = []
    _add_variables(value, found)
    return found


def _add_variables(value: Any, found: list[Any]) -> None:
    kind = type(value)
    if kind is ir.Var:
        found.append(value)
    elif kind in _HOLDS_NONE:
        return
    elif kind is dict:
        for one in value.values():
            _add_variables(one, found)
    elif isinstance(value, ir.Inst):
        found += value.list_vars()
    elif isinstance(value, list | tuple):
        for one in value:
            _add_variables(one, found)


_HOLDS_NONE: Final = frozenset({ir.Loc, str, int, float, bool, type(None)})


def _shapes_differ(source: Any, target: Any) -> None:
    """Stands for numba's function of this task."""
    raise NotImplementedError


@overload(_shapes_differ)
def _raise_shapes_differ(_source: Any, _target: Any) -> Callable[..., None]:
    # Numba puts both shapes into the words: string arithmetic at every slice that is written to.
    def raise_it(_source: Any, _target: Any) -> None:
        raise ValueError("cannot assign slice from input of different size")

    return raise_it


@contextlib.contextmanager
def quicker(part_library: Any, part: Callable[[Any, dict[str, Any]], Any]) -> Iterator[None]:
    """Take the shorter ways in this statement.

    Parameters
    ----------
    part_library : type of code library
        Of what is taken in and needs no machine code.
    part : callable
        Makes a part of a plain function and its options.
    """

    def jit(_template: Any) -> Callable[..., Any]:
        return lambda **options: lambda function: part(function, options)

    ways = (
        (BaseFunction, "get_call_type", _remembered_call_type),
        (targetconfig.TargetConfig, "__eq__", _are_equal),
        (targetconfig.TargetConfig, "__hash__", _hash_of_flags),
        (ir.Inst, "_rec_list_vars", _variables),
        (arrayobj, "raise_with_shape_context", _shapes_differ),
        (JITCPUCodegen, "_library_class", part_library),
        (_OverloadFunctionTemplate, "_get_jit_decorator", jit),
    )
    before = [getattr(owner, name) for owner, name, _ in ways]
    try:
        for owner, name, ours in ways:
            setattr(owner, name, ours)
        yield
    finally:
        for (owner, name, _), theirs in zip(ways, before, strict=True):
            setattr(owner, name, theirs)
