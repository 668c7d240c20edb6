"""Two kinds of compiled function: an entry, which becomes machine code, and a part, which is only lowered into entries.

Numba optimises and emits every function by itself, then links it into its caller and optimises it again, as often as
calls are nested. Here what a kernel calls is lowered only. The kernel that Python calls takes in all of its parts once,
and is optimised and emitted once.
"""

import contextlib
from collections.abc import Callable
from typing import Any, Final

import llvmlite.binding as llvm
import numba
from numba.core import sigutils
from numba.core.codegen import CPUCodeLibrary, JITCodeLibrary
from numba.core.compiler import Compiler
from numba.core.registry import CPUDispatcher

TRIED_NUMBA: Final = "0.68"
"""Shorter ways through numba stand on what it keeps to itself: with another version its own ways are taken."""


class _PartLibrary(JITCodeLibrary):  # type: ignore[misc]
    _whole: Any = None

    def finalize(self) -> None:
        """Leave linking, optimising and machine code to the entries that take it in."""
        self._finalized = True

    def own_module(self) -> Any:
        """Return what was lowered of this part, without what it calls."""
        return super()._get_module_for_linking()

    def _get_module_for_linking(self) -> Any:
        """Return the part with all that it calls: for a function that somebody else compiles."""
        if self._whole is None:
            own, *others = _callers_first([self])
            self._whole = own.own_module().clone()
            for one in others:
                self._whole.link_in(_module(one), preserve=True)
        return self._whole


class _EntryLibrary(JITCodeLibrary):  # type: ignore[misc]
    def finalize(self) -> None:
        """Link each part once, those of its parts as well; then optimise and emit."""
        linked: list[CPUCodeLibrary] = self._linking_libraries
        for one in _callers_first(linked):
            self._reload_init.update(one._reload_init)
            self._final_module.link_in(_module(one), preserve=True)
        self._linking_libraries: list[CPUCodeLibrary] = []
        super().finalize()

    def serialize_using_object_code(self) -> tuple[str, str, tuple[bytes, bytes]]:
        """Serialise the machine code, and the names that it defines instead of bitcode: nothing links an entry."""
        self._ensure_finalized()
        names = [one.name for one in self._final_module.functions if not one.is_declaration]
        text = "\n".join(f'define void @"{name}"() {{ ret void }}' for name in names)
        return self.name, "object", (self._get_compiled_object(), llvm.parse_assembly(text).as_bitcode())


def _module(library: CPUCodeLibrary) -> Any:
    return library.own_module() if isinstance(library, _PartLibrary) else library._get_module_for_linking()


def _callers_first(libraries: list[CPUCodeLibrary]) -> list[CPUCodeLibrary]:
    """Return libraries and all that their parts take in, each before what it calls.

    LLVM takes from a module only the functions that were called before.
    """
    found: dict[CPUCodeLibrary, None] = {}

    def visit(library: CPUCodeLibrary) -> None:
        if library not in found:
            if isinstance(library, _PartLibrary):
                for one in library._linking_libraries:
                    visit(one)
            found[library] = None

    for one in libraries:
        visit(one)
    return [*reversed(found)]


class _UnitCompiler(Compiler):  # type: ignore[misc]
    library: type[CPUCodeLibrary]

    def compile_extra(self, func: Callable[..., Any]) -> Any:
        self.state.library = self.library(self.state.targetctx.codegen(), func.__qualname__)
        self.state.library.enable_object_caching()
        return super().compile_extra(func)


def _ways() -> contextlib.AbstractContextManager[None]:
    """Return the ways through numba in which kernels are compiled."""
    if not numba.__version__.startswith(f"{TRIED_NUMBA}."):
        return contextlib.nullcontext()
    # What only compiling needs.
    from estimators.compiling._quicker import quicker

    return quicker(_PartLibrary, lambda function, options: Part(function, options, None))


class EntryCompiler(_UnitCompiler):
    """Compiles what Python calls, or a kernel calls by its address."""

    library = _EntryLibrary

    def compile_extra(self, func: Callable[..., Any]) -> Any:
        """Compile; what it calls and numba's own helpers are parts."""
        with _ways():
            return super().compile_extra(func)


class _PartCompiler(_UnitCompiler):
    library = _PartLibrary

    def compile_extra(self, func: Callable[..., Any]) -> Any:
        flags = self.state.flags
        flags.no_compile = flags.no_cpython_wrapper = flags.no_cfunc_wrapper = True
        return super().compile_extra(func)


class Part(CPUDispatcher):  # type: ignore[misc]
    """A kernel as other kernels call it: lowered for the declared signatures, or else for what callers hand over.

    It cannot be handed over as a value to code of numba's own (`list.sort(key=...)`), which is emitted by itself; and
    what it raises has constant words only.
    """

    def __init__(
        self, function: Callable[..., Any], options: dict[str, Any], signatures: list[Any] | None
    ) -> None:
        super().__init__(function, targetoptions=options, pipeline_class=_PartCompiler)
        self._declared = signatures

    def get_call_template(self, args: Any, kws: Any) -> Any:
        """Lower for a caller that is being compiled."""
        if self._declared is not None:
            signatures, self._declared = self._declared, None
            try:
                for one in signatures:
                    self.compile(one)
            except BaseException:
                # Without this the next try would lower it for what its caller hands over.
                self.overloads.clear()
                self._declared = signatures
                raise
            self.disable_compile()
        return super().get_call_template(args, kws)

    def add_overload(self, cres: Any) -> None:
        """Make it known to callers by its library: it has no address."""
        self.overloads[tuple(cres.signature.args)] = cres
        self.targetctx.insert_user_function(cres.library, cres.fndesc, [cres.library])

    def get_overload(self, sig: Any) -> Any:
        """Return the key by which a caller finds what was lowered."""
        arguments, _ = sigutils.normalize_signature(sig)
        return self.overloads[tuple(arguments)].library
