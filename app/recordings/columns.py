"""Frames as one table, for files that leave the service: a row a tick, a column a number, units in the names."""

import numpy as np
import pyarrow as pa

from estimators.pipelines import Frames


def frames_table(frames: Frames) -> pa.Table:
    """Return frames as one table.

    Parameters
    ----------
    frames : Frames

    Returns
    -------
    pyarrow.Table
        `time_s`; `<angle>_rad`, `<angle>_sigma_rad`, `<angle>_flags`; scalars; `<point>_x_m` ...; `<segment>_q_w` ...
        and `<segment>_flags`. NaN where there is no estimate.
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
    return pa.table(columns)


__all__ = ["frames_table"]
