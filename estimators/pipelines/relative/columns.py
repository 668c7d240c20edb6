"""Columns of relative-pose frames: their names, and a result as a table from which they are filled."""

from typing import Final

import numpy as np

from estimators.magnetic import RelativeResult
from estimators.magnetic.relative import layout as at
from estimators.pipelines._contract import FrameLayout
from estimators.recording import Float

SENSOR_SCALARS: Final = (
    "distance_m",
    "distance_sigma_m",
    "x_m",
    "y_m",
    "z_m",
    "x_sigma_m",
    "y_sigma_m",
    "z_sigma_m",
    "xy_correlation",
    "xz_correlation",
    "yz_correlation",
    "nis",
    "state",
)
"""Per sensor, named `hand_right_distance_m` and so on, in the axes of the source; `state` holds `RelativeFlag` bits,
`nis` is that of a pulse, NaN without one."""
SOURCE_SCALARS: Final = (
    "coil",
    "current_a",
    "ask_coil",
    "ask_current_a",
    "ask_ticks",
    "on_time_s",
    "charge_as",
    "current_squared_a2s",
)
"""Of the source, named `source_coil` and so on: what is on (0 nothing, else the coil's number), what it is asked to do
at the next tick, and its account since the start."""
ANGLES: Final = ("rotation", "flexion", "lateral")
"""Of the sensor against the source, `{source}_{sensor}_zyx_rotation` about z (up, to the left positive), then
`flexion` about y (forward), then `lateral` about x (to the right)."""


def layout_of(source: str, sensors: tuple[str, ...]) -> FrameLayout:
    """Return the columns for a source and sensors in this order."""
    names = (source, *sensors)
    return FrameLayout(
        segments=names,
        points=names,
        angles=tuple(f"{source}_{name}_zyx_{angle}" for name in sensors for angle in ANGLES),
        scalars=(
            *(f"{name}_{scalar}" for name in sensors for scalar in SENSOR_SCALARS),
            *(f"source_{scalar}" for scalar in SOURCE_SCALARS),
        ),
    )


def table_of(result: RelativeResult) -> Float:
    """Return a result as the filter's loop puts it out, shape (K, 54)."""
    out = np.empty((len(result.nis), at.OUTPUT))
    for column, values in (
        (at.O_POSITION, result.position_m),
        (at.O_ATTITUDE, result.q_source_sensor),
        (at.O_VELOCITY, result.velocity_mps),
        (at.O_COVARIANCE, result.covariance.reshape(-1, 36)),
        (at.O_NIS, result.nis[:, None]),
        (at.O_COIL, result.fire_coil[:, None]),
        (at.O_CURRENT, result.fire_current_a[:, None]),
        (at.O_FLAGS, result.flags[:, None]),
        (at.O_SCORES, result.scores),
        (at.O_TICKS, result.fire_ticks[:, None]),
    ):
        out[:, column : column + values.shape[1]] = values
    return out
