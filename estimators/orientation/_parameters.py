"""How estimators read their parameters: frozen dataclasses with units in the names, checked once."""

import math
from collections.abc import Mapping
from dataclasses import fields
from typing import Any, TypeVar

from estimators.errors import SetupError

P = TypeVar("P")


def read_parameters(kind: type[P], values: Mapping[str, Any] | None) -> P:
    """Build the parameters of an estimator from plain values.

    Parameters
    ----------
    kind : type
        A dataclass whose fields all have defaults of type bool, int or float.
    values : mapping, optional
        What differs from the defaults.

    Raises
    ------
    SetupError
        For a name that the dataclass does not have, or a value of the wrong kind.
    """
    values = dict(values or {})
    known = {field.name: field.default for field in fields(kind)}  # type: ignore[arg-type]
    unknown = sorted(set(values) - set(known))
    if unknown:
        raise SetupError(f"unknown parameter {', '.join(unknown)}; known are {', '.join(known)}")
    for name, value in values.items():
        default = known[name]
        if isinstance(default, bool):
            if not isinstance(value, bool):
                raise SetupError(f"{name} must be true or false, not {value!r}")
        elif isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
            raise SetupError(f"{name} must be a finite number, not {value!r}")
        else:
            values[name] = float(value)
    return kind(**values)


__all__ = ["read_parameters"]
