"""Shared parts of compiled filters: records and small linear algebra."""

from estimators._kernels import step
from estimators.kernels._angles import arcsine, direction, turn
from estimators.kernels._borrowing import borrowing
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
    "VOID",
    "Fields",
    "Record",
    "arcsine",
    "borrowing",
    "bundle",
    "direction",
    "fields_of",
    "filled",
    "invert_symmetric",
    "mirror",
    "record",
    "restored",
    "rows",
    "single",
    "skew",
    "step",
    "turn",
]
