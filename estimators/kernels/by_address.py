"""Kernels that are called by their address: compiled code that calls one so does not have it linked into itself.

What a kernel calls is linked into it, optimised once more with it, and compiled a second time. Of a large kernel that
takes half a minute, as long as the kernel itself took. Called by its address it stays where it is.
"""

from collections.abc import Callable
from typing import Any, cast

from llvmlite import ir
from numba import types
from numba.core import cgutils, sigutils
from numba.extending import intrinsic

from estimators.compiling import Kernel


def address_of(kernel: Callable[..., Any]) -> int:
    """Return where a kernel with one signature is in this process, compiled or loaded; for `caller`."""
    found = cast(Kernel, kernel).ready
    address = int(found.library.get_pointer_to_function(found.fndesc.llvm_func_name))
    if not address:
        # Called, it would end the process.
        raise LookupError(f"{found.fndesc.llvm_func_name} is in no library")
    return address


def caller(kernel: Callable[..., Any]) -> Callable[..., Any]:
    """Return what compiled code calls with the address of a kernel with one signature, and a tuple of its arguments.

    Parameters
    ----------
    kernel : callable
        It is neither compiled nor loaded by this; arguments are converted as in any other call of it.

    Returns
    -------
    callable
        `call(address, arguments)`, to be used in kernels only.
    """
    args, found = sigutils.normalize_signature(cast(Kernel, kernel).signature)
    given = types.Tuple(args)

    @intrinsic  # type: ignore[untyped-decorator]
    def call(_: Any, address: Any, arguments: Any) -> Any:
        def generate(context: Any, builder: Any, typed: Any, values: Any) -> Any:
            convention = context.call_conv
            function = convention.get_function_type(found, args)
            pointer = builder.inttoptr(values[0], ir.PointerType(function))
            status, result = convention.call_function(
                builder, pointer, found, args, cgutils.unpack_tuple(builder, values[1])
            )
            with cgutils.if_unlikely(builder, status.is_error):
                convention.return_status_propagate(builder, status)
            return result

        return found(types.intp, given), generate

    return cast(Callable[..., Any], call)
