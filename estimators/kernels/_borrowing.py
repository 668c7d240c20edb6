"""Compiled steps that borrow the arrays they are handed, and so count no references to them.

For every array that a function receives, and every slice it makes, compiled code counts one user more and later one
less: two atomic operations, some 10 ns, which was a third of a filter whose steps take that long. A step that neither
makes an array nor returns one has no use for the count: its caller holds what it works on. Numba refuses to compile a
step that makes one all the same.
"""

from collections.abc import Callable
from typing import Any, TypeVar

from estimators.compiling import compiled

F = TypeVar("F", bound=Callable[..., Any])


def borrowing(signature: Any = None, *, inlined: bool = False, is_entry: bool = False) -> Callable[[F], F]:
    """Compile a step that makes no array and returns none; otherwise as `step`, or as `kernel` where it is an entry.

    Parameters
    ----------
    signature : str or numba signature, optional
        Without, the types are those that the kernels which call it hand over.
    inlined : bool
        Always put the code into its caller.
    is_entry : bool
        Python calls it, or a kernel by its address.

    Returns
    -------
    callable
        Decorator; the plain Python function stays reachable as `.py_func`.
    """
    return compiled(signature, is_entry=is_entry, forceinline=inlined, _nrt=False)
