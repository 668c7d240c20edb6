"""The formats that are read, by name."""

from typing import Final

FORMATS: Final = (
    "packet_log",
    "csv",
    "qmt_mat",
    "broad",
    "pyshoe",
    "gait_tracking",
    "gaitmap",
    "instrumented_shoe",
)
WALKS: Final = ("pyshoe", "gait_tracking", "gaitmap", "instrumented_shoe")
"""Formats of walking feet only."""
TEXT: Final = frozenset({".csv", ".txt", ".tsv", ".dat", ".asc"})

__all__ = ["FORMATS", "TEXT", "WALKS"]
