"""Marker trajectories, C3D or CSV, brought to metres in a laboratory with z up."""

from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np

from app.errors import RecordingFormatError
from app.readers.markers.c3d import read_c3d
from app.readers.markers.schemas import MarkerFileIn
from app.readers.tables.body import MAX_LINE_BYTES, read_columns
from app.readers.tables.clocks.stamps import HIGHEST_HZ, LOWEST_HZ, seconds_of
from estimators.optical import TURNS
from estimators.recording import Float
from estimators.sentences import say

METRES: Final = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "inch": 0.0254}
"""Units that a CSV file can be declared in."""
_FARTHEST_M: Final = 100.0


@dataclass(frozen=True)
class MarkerTracks:
    """Markers over time.

    Attributes
    ----------
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
                say("marker_file.no_marker", marker=name, names=list(self.names[:40])), field="marker"
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
        raise RecordingFormatError(say("marker_file.never_seen"))
    far = float(np.nanmax(np.abs(position)))
    if far > _FARTHEST_M:
        advice = (
            say("marker_file.unit")
            if declared.format == "csv" and declared.unit == "m"
            else say("marker_file.check_unit")
        )
        raise RecordingFormatError(say("marker_file.far", far_m=far, advice=advice))
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
        raise RecordingFormatError(say("table.not_utf8")) from error
    names = tuple(
        name[:-2]
        for name in header
        if name.endswith("_x") and {name[:-2] + "_y", name[:-2] + "_z"} <= set(header)
    )
    if not names:
        raise RecordingFormatError(say("marker_file.columns", present=", ".join(header)[:400]))
    columns = [f"{name}_{axis}" for name in names for axis in "xyz"]
    wanted = columns if declared.rate_hz is not None else [*columns, "time_s"]
    if declared.rate_hz is None and "time_s" not in header:
        raise RecordingFormatError(say("marker_file.no_time"))
    table = read_columns(path, wanted, declared.delimiter)
    position = np.stack([table[name] for name in columns], axis=1).reshape(-1, len(names), 3)
    if declared.rate_hz is not None:
        time_s = np.arange(len(position), dtype=np.float64) / declared.rate_hz
    else:
        time_s = seconds_of(table["time_s"], "s")
        rate = 1.0 / float(np.median(np.diff(time_s)))
        if not LOWEST_HZ <= rate <= HIGHEST_HZ:
            raise RecordingFormatError(say("marker_file.rate", rate_hz=rate))
    # A hidden marker is empty, NaN, or all three zero.
    position = np.where((position == 0.0).all(axis=-1, keepdims=True), np.nan, position)
    return names, time_s, position * METRES[declared.unit]
