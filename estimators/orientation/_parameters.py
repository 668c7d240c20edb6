"""How estimators read their parameters: frozen dataclasses that carry unit, bound and meaning, checked once."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import Any, TypeVar

from estimators.errors import SetupError

P = TypeVar("P")


@dataclass(frozen=True)
class Meaning:
    """What stands beside a parameter: unit, meaning, and the values it may have."""

    unit: str
    meaning: str
    above: float | None
    below: float | None


def parameter(
    default: float | bool, unit: str, meaning: str, *, above: float | None = None, below: float | None = None
) -> Any:
    """Return a field of a dataclass of parameters; `meaning_of` reads back what is said here.

    Parameters
    ----------
    unit : str
        Empty for a plain number or a switch.
    above, below : float, optional
        Bounds that the value may not reach. Without `above` no number may be negative.
    """
    return field(default=default, metadata={"parameter": Meaning(unit, meaning, above, below)})


def changed(kind: type[Any], name: str, default: float | bool) -> Any:
    """Return the field of `kind` with another default, for a class that inherits it."""
    return field(default=default, metadata={"parameter": meaning_of(kind)[name]})


def meaning_of(kind: type[Any]) -> dict[str, Meaning]:
    """Return unit, meaning and bounds of every parameter that was declared by `parameter`."""
    return {one.name: one.metadata["parameter"] for one in fields(kind) if "parameter" in one.metadata}


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
        For a name that the dataclass does not have, a value of the wrong kind, or one out of bounds.
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
    made = kind(**values)
    for name, meaning in meaning_of(kind).items():
        _check_bounds(name, getattr(made, name), meaning)
    return made


def _check_bounds(name: str, value: float, meaning: Meaning) -> None:
    if meaning.above is None and value < 0.0:
        raise SetupError(f"{name} must not be negative, not {value}")
    if meaning.above is not None and value <= meaning.above:
        raise SetupError(f"{name} must be above {meaning.above or 'zero'}")
    if meaning.below is not None and value >= meaning.below:
        raise SetupError(f"{name} must be below {meaning.below:g}")
