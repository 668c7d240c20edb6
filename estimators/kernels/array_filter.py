"""Shared parts of filters outside their loops: parameters with overrides, and a state of arrays."""

from collections.abc import Mapping
from dataclasses import asdict, fields, replace
from typing import Any, ClassVar, TypeVar

import numpy as np
from numpy.typing import NDArray

from estimators.errors import SetupError, ShapeError

P = TypeVar("P")


class StoredArrays:
    """Anything all of whose state is arrays of its own, of shapes that stay."""

    _ARRAYS: ClassVar[tuple[str, ...]]
    """Their names, without the underscore."""

    def state(self) -> dict[str, NDArray[Any]]:
        """Return everything that the next update depends on, as arrays that can be stored."""
        return {name: getattr(self, f"_{name}").copy() for name in self._ARRAYS}

    def restore(self, state: Mapping[str, NDArray[Any]]) -> None:
        """Continue exactly where the instance that gave `state` stood.

        Raises
        ------
        ShapeError
            For the state of another filter; nothing has changed then.
        """
        restored = {}
        for name in self._ARRAYS:
            own = getattr(self, f"_{name}")
            if name not in state or state[name].shape != own.shape:
                raise ShapeError(
                    f"the stored state has no {name} of shape {own.shape}; was it another filter's?"
                )
            restored[name] = np.array(state[name], dtype=own.dtype, order="C")
        for name, values in restored.items():
            setattr(self, f"_{name}", values)


class ArrayFilter(StoredArrays):
    """Such a filter whose parameters are a dataclass."""

    _parameters: Any

    @property
    def parameters(self) -> dict[str, Any]:
        """Every parameter with its value."""
        return asdict(self._parameters)


def with_overrides(defaults: P, values: Mapping[str, Any] | None) -> P:
    """Return a dataclass of parameters with some of its values replaced; their bounds are the caller's.

    Raises
    ------
    SetupError
        For a name that it does not have.
    """
    known = {field.name for field in fields(defaults)}  # type: ignore[arg-type]
    if unknown := sorted(set(values or {}) - known):
        raise SetupError(f"no parameter {', '.join(unknown)}; known are {', '.join(sorted(known))}")
    return replace(defaults, **(values or {}))  # type: ignore[type-var]
