"""Records of compiled filters: fields read by name, `x.bias[i]`, `c.step_s`, in Python and in compiled code alike.

One numpy structured dtype each says what the settings, the state and a sample of a filter hold. A filter that extends
another's records hands them to the same compiled steps, which are made for each kind of record that comes.

Numba refuses a nested array where a kernel's signature says `float64[::1]`. So scalars and short vectors are in
records, and what kernels pass on whole, as a covariance, is an array of its own with sensors leading.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numba
import numpy as np
from numba import types
from numpy.typing import DTypeLike, NDArray

from estimators.errors import SetupError, ShapeError

Record = Any
"""One record inside a kernel; the dtype that its documentation names says what it holds."""
Fields = list[tuple[str, Any] | tuple[str, Any, int]]
VOID = types.void


def record(*fields: Fields) -> np.dtype[Any]:
    """Return the dtype of records with these fields, aligned as the machine wants them."""
    return np.dtype([one for part in fields for one in part], align=True)


def fields_of(values: Mapping[str, float | Sequence[float]]) -> Fields:
    """Return the fields that hold such values, in their order: switches, numbers, and rows of numbers."""
    return [
        (name, "f8", len(value))
        if isinstance(value, Sequence)
        else (name, "i8" if isinstance(value, bool) else "f8")
        for name, value in values.items()
    ]


def rows(kind: DTypeLike) -> Any:
    """Return numba's type of an array of records."""
    return types.Array(numba.from_dtype(kind), 1, "C")


def single(kind: DTypeLike) -> Any:
    """Return numba's type of a single record."""
    return numba.from_dtype(kind)


def bundle(kind: type[Any], *columns: Any) -> Any:
    """Return numba's type of a named tuple of arrays, which says once what a kernel reads or writes."""
    return types.NamedTuple(columns, kind)


def filled(kind: np.dtype[Any], values: Mapping[str, Any]) -> NDArray[Any]:
    """Return one record, shape (1,), with every field set.

    Raises
    ------
    SetupError
        If a field is missing or is not one of the record.
    """
    if set(values) != set(kind.names or ()):
        raise SetupError(f"fields of a record do not fit: {sorted(set(values) ^ set(kind.names or ()))}")
    made = np.zeros(1, dtype=kind)
    for name, value in values.items():
        made[name] = value
    return made


def restored(state: Mapping[str, NDArray[Any]], name: str, like: NDArray[Any]) -> NDArray[Any]:
    """Return a copy of stored records or numbers of the kind and shape of `like`.

    Raises
    ------
    ShapeError
        If they are missing, of another kind (another version made them) or of another shape.
    """
    if name not in state:
        raise ShapeError(f"the stored state has no {name}; it was made by another version")
    values = np.array(state[name], order="C")
    if values.dtype != like.dtype:
        raise ShapeError(f"stored {name} has other fields; it was made by another version")
    if values.shape != like.shape:
        raise ShapeError(f"stored {name} has shape {values.shape}; this estimator needs {like.shape}")
    return values
