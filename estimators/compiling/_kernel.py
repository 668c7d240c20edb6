"""Kernels: compiled for their declared signature when they are first needed, and found again in the cache.

Importing a module compiles and loads nothing. A kernel is made ready by its first call: from the cache in
milliseconds, or compiled in up to half a minute. A service that must not wait for that in the middle of its work calls
beforehand what it will need.
"""

import contextlib
import contextvars
import functools
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, ClassVar, Final, TypeVar, cast

from numba.core.caching import CompileResultCacheImpl, FunctionCache, IndexDataCacheFile
from numba.core.compiler_lock import global_compiler_lock
from numba.core.registry import CPUDispatcher

from estimators.compiling import _shipped
from estimators.compiling._digest import digest
from estimators.compiling._units import EntryCompiler, Part

try:
    import fcntl
except ImportError:  # pragma: no cover - where files cannot be locked, two processes may compile the same
    fcntl = None  # type: ignore[assignment]

F = TypeVar("F", bound=Callable[..., Any])

_is_compiling_allowed = contextvars.ContextVar("is_compiling_allowed", default=True)


class NotCompiled(Exception):
    """A kernel is needed that is in no cache, where nothing may be compiled."""


@contextlib.contextmanager
def only_cached() -> Iterator[None]:
    """Compile nothing in this statement and thread: kernels come from the cache, or `NotCompiled` is raised."""
    token = _is_compiling_allowed.set(False)
    try:
        yield
    finally:
        _is_compiling_allowed.reset(token)


class _Implementation(CompileResultCacheImpl):  # type: ignore[misc]
    def __init__(self, function: Callable[..., Any]) -> None:
        self._module = function.__module__
        super().__init__(function)

    def get_filename_base(self, fullname: str, abiflags: str) -> str:
        # Without the line, which an edit above moves. With the whole module: kernels of all can lie in one folder.
        name = fullname.partition(".")[2].replace("<", "").replace(">", "")
        return f"{self._module}.{name}.py{sys.version_info.major}{sys.version_info.minor}{abiflags}"


class _Cache(FunctionCache):  # type: ignore[misc]
    """Numba's cache of one kernel, in which machine code is known by all that went into it."""

    _impl_class = _Implementation

    def __init__(self, kernel: "Kernel") -> None:
        super().__init__(kernel.py_func)
        stamp = digest(kernel.py_func, kernel.targetoptions, kernel.signature)
        self._cache_file = IndexDataCacheFile(self._cache_path, self._impl.filename_base, stamp)
        self._shipped = None
        if _shipped.is_used():
            self._shipped = IndexDataCacheFile(str(_shipped.FOLDER), self._impl.filename_base, stamp)

    def _index_key(self, sig: Any, codegen: Any) -> tuple[Any, ...]:
        return sig, codegen.magic_tuple()

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        target_context.refresh()
        if self._shipped is not None:
            # A file that cannot be read must not keep a kernel from being compiled.
            with contextlib.suppress(Exception):
                data = self._shipped.load(_shipped.key_of(sig))
                if data is not None:
                    return self._impl.rebuild(target_context, data)
        try:
            found = super().load_overload(sig, target_context)
        except (ImportError, AttributeError):
            # The index is unpickled before its stamp is read, and names a class that is gone or has moved.
            self.flush()
            found = None
        if found is None and not _is_compiling_allowed.get():
            raise NotCompiled(self._name)
        return found


class Kernel(CPUDispatcher):  # type: ignore[misc]
    """A function that is compiled for its declared signature at its first use, and for no other ever.

    Without a signature it is compiled for whatever other kernels hand to it.
    """

    made: ClassVar[list["Kernel"]] = []
    """Every entry, in the order of the imports."""
    signature: Any = None
    """The declared one, or a list of them; None where it is left to the callers."""
    _declared: Any = None
    _is_cached = False

    def declare(self, signature: Any, is_entry: bool) -> None:
        """Set the signature; None leaves it to the callers."""
        self.signature = self._declared = signature
        if is_entry and signature is not None:
            self.made.append(self)

    def prepare(self) -> None:
        """Compile the declared signature, or load it, unless that was done; waits for another thread that does."""
        with global_compiler_lock:
            if self._declared is None:
                return
            signature, self._declared = self._declared, None
            try:
                for one in signature if isinstance(signature, list) else [signature]:
                    self.compile(one)
            except BaseException:
                self._declared = signature
                raise
            self.disable_compile()

    @property
    def ready(self) -> Any:
        """What was compiled or loaded for the one signature of a kernel; makes it ready where it is not."""
        if not self.overloads:
            # What is ready is not asked to be: that would wait for whoever compiles something else.
            self.prepare()
        (found,) = self.overloads.values()
        return found

    def compile(self, sig: Any) -> Any:
        """Compile for a signature or load it; other processes that want the same wait and load what was made here."""
        with global_compiler_lock:
            if not self._is_cached:
                self._cache = _Cache(self)
            self._is_cached = True
            with _alone(self._cache):
                return super().compile(sig)

    @functools.cached_property
    def part(self) -> Part:
        """The kernel as other kernels take it in."""
        signature = self.signature
        declared = None if signature is None else signature if isinstance(signature, list) else [signature]
        return Part(self.py_func, self.targetoptions, declared)

    def get_call_template(self, args: Any, kws: Any) -> Any:
        """Lower the kernel for a caller that is being compiled."""
        return self.part.get_call_template(args, kws)

    def get_overload(self, sig: Any) -> Any:
        """Return what a caller that is being compiled links."""
        return self.part.get_overload(sig)

    def _compile_for_args(self, *args: Any, **kws: Any) -> Any:
        # From the first call. What is returned is called with the same arguments: once more this kernel, ready now.
        with global_compiler_lock:
            if self._can_compile and self._declared is None:
                return super()._compile_for_args(*args, **kws)
        self.prepare()
        return self


@contextlib.contextmanager
def _alone(cache: Any) -> Iterator[None]:
    """Hold what is cached of one function against other processes.

    Only one kernel is held at a time: the steps that it calls are in no cache.
    """
    with contextlib.ExitStack() as stack:
        if fcntl is not None and cache.cache_path is not None:
            # A cache that cannot be written to is of use all the same.
            with contextlib.suppress(OSError):
                cache._impl.locator.ensure_cache_path()
                path = Path(cache.cache_path, f"{cache._impl.filename_base}.lock")
                fcntl.flock(stack.enter_context(path.open("ab")), fcntl.LOCK_EX)
        yield


def unchecked(function: F) -> F:
    """Return a kernel with one signature as one calls it who answers for the types of what he hands over.

    Called as usual, a kernel is asked each time whether its arguments are those of its signature; of named tuples that
    is done in Python, and takes longer than short work itself. Here wrong ones are read as if they were right.
    """
    return cast(F, cast(Kernel, function).ready.entry_point)


_ALWAYS: Final = {"nopython": True, "boundscheck": None, "nogil": True, "error_model": "numpy"}


def compiled(signature: Any = None, *, is_entry: bool = True, **options: Any) -> Callable[[F], F]:
    """Compile a function when it is first needed: no GIL, cached, IEEE arithmetic (so chunking cannot change bits).

    Parameters
    ----------
    signature : str, numba signature or list of them, optional
        Without, the types are those that the kernels which call it hand over.
    is_entry : bool
        Python calls it: `telemotion compile` makes it ready. What only kernels call is lowered into them; called from
        Python all the same, as by a test, it is compiled then.
    **options
        Of `numba.njit`.

    Returns
    -------
    callable
        Decorator; the plain Python function stays reachable as `.py_func`.
    """

    def decorate(function: F) -> F:
        made = Kernel(function, targetoptions={**_ALWAYS, **options}, pipeline_class=EntryCompiler)
        made.declare(signature, is_entry)
        return cast(F, made)

    return decorate
