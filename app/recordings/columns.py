"""Frames as one table, for files that leave the service: a row a tick, a column a number, each with what it means."""

import json
from typing import Any

import pyarrow as pa
from numpy.typing import NDArray

from app.recordings.column_words import (
    angle_words,
    flags_words,
    scalar_words,
    sequence_of,
    unit_of,
)
from app.recordings.points import described
from estimators import pipelines
from estimators.body import BodyDimensions
from estimators.pipelines import Frames


class _Columns:
    """Columns with their metadata, in order."""

    def __init__(self, pipeline: str) -> None:
        self.arrays: list[pa.Array] = []
        self.fields: list[pa.Field] = []
        self._frame = pipelines.available()[pipeline].axes if pipeline else ""

    def add(
        self, name: str, values: NDArray[Any], meaning: str, *, sequence: str = "", has_frame: bool = False
    ) -> None:
        """Add one column."""
        said = {"unit": unit_of(name), "meaning": meaning}
        if sequence:
            said["sequence"] = sequence
        if has_frame and self._frame:
            said["frame"] = self._frame
        array = pa.array(values)
        self.arrays.append(array)
        self.fields.append(pa.field(name, array.type, metadata=said))

    def triple(self, name: str, unit: str, values: NDArray[Any], meaning: str) -> None:
        """Add x, y and z of a vector, shape (K, 3)."""
        for axis, letter in enumerate("xyz"):
            self.add(f"{name}_{letter}_{unit}", values[:, axis], f"{meaning}, {letter}", has_frame=True)


def frames_table(
    frames: Frames,
    body: BodyDimensions | None = None,
    *,
    pipeline: str = "",
    about: dict[str, Any] | None = None,
) -> pa.Table:
    """Return frames as one table.

    Parameters
    ----------
    body : BodyDimensions, optional
        Of their setup: elbows, wrists and hands then come with uncertainty, velocity and acceleration; frames at
        full rate.
    pipeline : str
        Says in which frame points and orientations are.
    about : dict, optional
        What else a reader of the file must know, in plain JSON types; becomes metadata of the table.

    Returns
    -------
    pyarrow.Table
        `time_s`; `<angle>_rad`, `<angle>_sigma_rad`, `<angle>_flags`; scalars; `<point>_x_m` ...; `<segment>_q_w` ...
        and `<segment>_flags`; where they are known `<point>_sigma_x_m` and `<segment>_sigma_x_rad`; with `body`
        `<point>_sigma_x_m`, `<point>_velocity_x_mps`, `<point>_acceleration_x_mps2` ... NaN where there is no
        estimate. Each field has `unit` and `meaning` in its metadata, and `frame` and `sequence` where it has one.
    """
    found, layout = _Columns(pipeline), frames.layout
    angle_bits, segment_bits = frames.angle_bits, frames.segment_bits
    found.add("time_s", frames.time_s, "time since the start of the recording")
    for index, name in enumerate(layout.angles):
        words, sequence = angle_words(name), sequence_of(name)
        found.add(f"{name}_rad", frames.angle_rad[:, index], words, sequence=sequence)
        found.add(
            f"{name}_sigma_rad", frames.angle_sigma_rad[:, index], f"one sigma of {words}", sequence=sequence
        )
        found.add(f"{name}_flags", angle_bits[:, index], flags_words())
    for index, name in enumerate(layout.scalars):
        found.add(name, frames.scalar[:, index], scalar_words(name))
    for index, name in enumerate(layout.points):
        found.triple(name, "m", frames.point_room_m[:, index], f"position of {name}")
    for index, name in enumerate(layout.segments):
        for part, letter in enumerate("wxyz"):
            meaning = (
                f"quaternion from the axes of {name} to those of the frame, {letter}; unit norm, scalar first"
            )
            found.add(f"{name}_q_{letter}", frames.q_room_segment[:, index, part], meaning, has_frame=True)
        found.add(f"{name}_flags", segment_bits[:, index], flags_words())
    if frames.point_sigma_m is not None:
        for index, name in enumerate(layout.points):
            meaning = f"one sigma of the position of {name} along"
            found.triple(f"{name}_sigma", "m", frames.point_sigma_m[:, index], meaning)
    if frames.segment_sigma_rad is not None:
        for index, name in enumerate(layout.segments):
            meaning = f"one sigma of the orientation of {name} about"
            found.triple(f"{name}_sigma", "rad", frames.segment_sigma_rad[:, index], meaning)
    if body is not None:
        _add_points(found, frames, body)
    schema = pa.schema(found.fields, metadata={"telemotion": json.dumps(about)} if about else None)
    return pa.table(found.arrays, schema=schema)


def _add_points(found: _Columns, frames: Frames, body: BodyDimensions) -> None:
    points = described(frames, body)
    for index, name in enumerate(points.names):
        for kind, unit, values, meaning in (
            ("sigma", "m", points.sigma_m, f"one sigma of the position of {name} along"),
            ("velocity", "mps", points.velocity_mps, f"velocity of {name}"),
            (
                "acceleration",
                "mps2",
                points.acceleration_mps2,
                f"acceleration of {name}, gravity not included",
            ),
        ):
            found.triple(f"{name}_{kind}", unit, values[:, index], meaning)


def dictionary(table: pa.Table) -> list[dict[str, str]]:
    """Return what each column of a table is, for `columns.json`.

    Parameters
    ----------
    table : pyarrow.Table
        As `frames_table` makes it.

    Returns
    -------
    list of dict
        `name`, `unit`, `meaning`, and `frame` and `sequence` where a column has one.
    """
    return [
        {
            "name": field.name,
            **{key.decode(): value.decode() for key, value in (field.metadata or {}).items()},
        }
        for field in table.schema
    ]


def csv_cell(text: str) -> str:
    """Return text for a cell or heading of a table that a spreadsheet opens: never taken for a formula.

    Parameters
    ----------
    text : str
        With a quote before it where it begins as formulas do.
    """
    return f"'{text}" if text[:1] in {"=", "+", "-", "@", "\t", "\r"} else text
