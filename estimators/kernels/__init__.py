"""Shared parts of compiled filters: records, small linear algebra, and the error-state core of models."""

from estimators._kernels import step
from estimators.kernels._angles import arcsine, direction, turn
from estimators.kernels._borrowing import borrowing
from estimators.kernels._error_state import BASE, Matrix, absorb, attitude_seen, inject, predict, turn_by_rate
from estimators.kernels._linear import invert_symmetric, mirror, skew
from estimators.kernels._records import (
    VOID,
    Fields,
    Record,
    bundle,
    fields_of,
    filled,
    record,
    restored,
    rows,
    single,
)

__all__ = [
    "BASE",
    "VOID",
    "Fields",
    "Matrix",
    "Record",
    "absorb",
    "arcsine",
    "attitude_seen",
    "borrowing",
    "bundle",
    "direction",
    "fields_of",
    "filled",
    "inject",
    "invert_symmetric",
    "mirror",
    "predict",
    "record",
    "restored",
    "rows",
    "single",
    "skew",
    "step",
    "turn",
    "turn_by_rate",
]
