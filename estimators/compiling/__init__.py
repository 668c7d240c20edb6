"""The one way in which this package compiles: for a declared signature, when it is first needed, once for everybody."""

from estimators.compiling._digest import goes_into
from estimators.compiling._kernel import Kernel, NotCompiled, compiled, only_cached, unchecked
from estimators.compiling._shipped import PROCESSOR, is_labelled, label, why_unused

__all__ = [
    "PROCESSOR",
    "Kernel",
    "NotCompiled",
    "compiled",
    "goes_into",
    "is_labelled",
    "label",
    "only_cached",
    "unchecked",
    "why_unused",
]
