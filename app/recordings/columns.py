"""Frames as one table, for files that leave the service: a row a tick, a column a number, units in the names."""

import numpy as np
import pyarrow as pa

from app.recordings.points import described
from estimators.body import BodyDimensions
from estimators.pipelines import Frames


def frames_table(frames: Frames, body: BodyDimensions | None = None) -> pa.Table:
    """Return frames as one table.

    Parameters
    ----------
    frames : Frames
    body : BodyDimensions, optional
        Of their setup: elbows, wrists and hands then come with uncertainty, velocity and acceleration; frames at
        full rate.

    Returns
    -------
    pyarrow.Table
        `time_s`; `<angle>_rad`, `<angle>_sigma_rad`, `<angle>_flags`; scalars; `<point>_x_m` ...; `<segment>_q_w` ...
        and `<segment>_flags`; with `body` `<point>_sigma_x_m`, `<point>_velocity_x_mps`,
        `<point>_acceleration_x_mps2` ... NaN where there is no estimate.
    """
    columns: dict[str, np.ndarray] = {"time_s": frames.time_s}
    layout = frames.layout
    for index, name in enumerate(layout.angles):
        columns[f"{name}_rad"] = frames.angle_rad[:, index]
        columns[f"{name}_sigma_rad"] = frames.angle_sigma_rad[:, index]
        columns[f"{name}_flags"] = frames.angle_flags[:, index]
    for index, name in enumerate(layout.scalars):
        columns[name] = frames.scalar[:, index]
    for index, name in enumerate(layout.points):
        for axis, letter in enumerate("xyz"):
            columns[f"{name}_{letter}_m"] = frames.point_room_m[:, index, axis]
    for index, name in enumerate(layout.segments):
        for part, letter in enumerate("wxyz"):
            columns[f"{name}_q_{letter}"] = frames.q_room_segment[:, index, part]
        columns[f"{name}_flags"] = frames.segment_flags[:, index]
    for unit, names, sigma in (
        ("m", layout.points, frames.point_sigma_m),
        ("rad", layout.segments, frames.segment_sigma_rad),
    ):
        if sigma is not None:
            for index, name in enumerate(names):
                for axis, letter in enumerate("xyz"):
                    columns[f"{name}_sigma_{letter}_{unit}"] = sigma[:, index, axis]
    if body is not None:
        found = described(frames, body)
        kinds = (
            ("sigma", "m", found.sigma_m),
            ("velocity", "mps", found.velocity_mps),
            ("acceleration", "mps2", found.acceleration_mps2),
        )
        for index, name in enumerate(found.names):
            for kind, unit, values in kinds:
                for axis, letter in enumerate("xyz"):
                    columns[f"{name}_{kind}_{letter}_{unit}"] = values[:, index, axis]
    return pa.table(columns)


__all__ = ["frames_table"]
