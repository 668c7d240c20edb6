"""The one way in which this package compiles: for a declared signature, when it is first needed, once for everybody."""

from estimators.compiling._kernel import Kernel, NotCompiled, compiled, only_cached, unchecked

__all__ = ["Kernel", "NotCompiled", "compiled", "only_cached", "unchecked"]
