"""Marker trajectories, C3D or CSV, brought to metres in a laboratory with z up."""

from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np

from app.errors import RecordingFormatError
from app.ingest.readers._c3d import read_c3d
from app.ingest.readers._csv import MAX_LINE_BYTES, read_columns
from app.ingest.readers._time import HIGHEST_HZ, LOWEST_HZ, seconds_of
from app.recordings.marker_schemas import MarkerFileIn
from estimators.optical import TURNS
from estimators.recording import Float

METRES: Final = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "inch": 0.0254}
"""Units that a CSV file can be declared in."""
_FARTHEST_M: Final = 100.0


@dataclass(frozen=True)
class MarkerTracks:
    """Markers over time.

    Attributes
    ----------
    names : tuple of str
    time_s : ndarray, shape (N,)
        Of the cameras, from the first frame.
    position_m : ndarray, shape (N, M, 3)
        Laboratory with z up; NaN in gaps.
    """

    names: tuple[str, ...]
    time_s: Float
    position_m: Float

    def of(self, name: str) -> Float:
        """Return one marker, shape (N, 3).

        Raises
        ------
        RecordingFormatError
            There is none of this name.
        """
        if name not in self.names:
            raise RecordingFormatError(
                f"The file has no marker {name!r}; it has {', '.join(self.names[:40])}.", field="marker"
            )
        return self.position_m[:, self.names.index(name)]


def read_markers(path: Path, declared: MarkerFileIn) -> MarkerTracks:
    """Read trajectories as declared.

    Raises
    ------
    RecordingFormatError
        The file is not what it was declared to be, or its numbers cannot be right.
    """
    if declared.format == "c3d":
        points = read_c3d(path)
        names, position = points.labels, points.position_m
        time_s = np.arange(len(position), dtype=np.float64) / points.rate_hz
    else:
        names, time_s, position = _read_csv(path, declared)
    seen = np.isfinite(position).all(axis=-1)
    if not seen.any():
        raise RecordingFormatError("No marker was ever seen in this file.")
    far = float(np.nanmax(np.abs(position)))
    if far > _FARTHEST_M:
        advice = (
            " It looks like mm, or cm; declare that unit."
            if declared.format == "csv" and declared.unit == "m"
            else ""
        )
        raise RecordingFormatError(f"A marker is {far:.0f} m from the origin, which cannot be.{advice}")
    turn = np.array(TURNS[declared.up], dtype=np.float64)
    return MarkerTracks(names, time_s, position @ turn.T)


def _read_csv(path: Path, declared: MarkerFileIn) -> tuple[tuple[str, ...], Float, Float]:
    """Read columns `NAME_x`, `NAME_y`, `NAME_z`, and `time_s` unless a rate was declared."""
    with path.open("rb") as file:
        line = file.readline(MAX_LINE_BYTES)
    try:
        header = [
            name.strip().strip('"')
            for name in line.decode("utf-8-sig").strip("\r\n").split(declared.delimiter)
        ]
    except UnicodeDecodeError as error:
        raise RecordingFormatError("The first line is not UTF-8 text; this is no CSV file.") from error
    names = tuple(
        name[:-2]
        for name in header
        if name.endswith("_x") and {name[:-2] + "_y", name[:-2] + "_z"} <= set(header)
    )
    if not names:
        raise RecordingFormatError(
            "No marker was found: each needs three columns, NAME_x, NAME_y and NAME_z. The file has:"
            f" {', '.join(header)[:400]}."
        )
    columns = [f"{name}_{axis}" for name in names for axis in "xyz"]
    wanted = columns if declared.rate_hz is not None else [*columns, "time_s"]
    if declared.rate_hz is None and "time_s" not in header:
        raise RecordingFormatError(
            "The file has no column time_s; add it, or declare the rate of the cameras."
        )
    table = read_columns(path, wanted, declared.delimiter)
    position = np.stack([table[name] for name in columns], axis=1).reshape(-1, len(names), 3)
    if declared.rate_hz is not None:
        time_s = np.arange(len(position), dtype=np.float64) / declared.rate_hz
    else:
        time_s = seconds_of(table["time_s"], "s")
        rate = 1.0 / float(np.median(np.diff(time_s)))
        if not LOWEST_HZ <= rate <= HIGHEST_HZ:
            raise RecordingFormatError(
                f"The frames come at {rate:.3g} Hz, which cannot be used; is time_s in seconds?"
            )
    # A hidden marker is empty, NaN, or all three zero.
    position = np.where((position == 0.0).all(axis=-1, keepdims=True), np.nan, position)
    return names, time_s, position * METRES[declared.unit]


__all__ = ["METRES", "MarkerTracks", "read_markers"]
