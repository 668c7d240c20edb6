"""Columns of relative-pose frames: what a filter says, as scalars, angles and flags."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from estimators import rotation
from estimators.magnetic import RelativeFlag, RelativeResult
from estimators.orientation import OrientationFlag
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
_SINGULAR: Final = np.uint8(int(OrientationFlag.SINGULAR))
_SHOWN: Final = tuple(
    (np.uint16(int(own)), np.uint8(int(shown)))
    for own, shown in (
        (RelativeFlag.INVALID, OrientationFlag.INVALID),
        (RelativeFlag.CALIBRATING | RelativeFlag.UNCERTAIN, OrientationFlag.CONVERGING),
        (RelativeFlag.INERTIAL_ONLY | RelativeFlag.FAULT, OrientationFlag.HEADING_NOT_TRUSTED),
        (RelativeFlag.DISTURBED, OrientationFlag.MAGNETIC_DISTURBANCE),
        (RelativeFlag.SATURATED, OrientationFlag.SATURATED),
        (RelativeFlag.GAP, OrientationFlag.BRIDGED),
    )
)
_SINGULAR_COSINE: Final = float(np.sin(np.radians(10.0)))


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


def sensor_scalars(result: RelativeResult, told: NDArray[np.uint16], known: NDArray[np.bool_]) -> Float:
    """Return the columns of one sensor."""
    position, cov = result.position_m, result.covariance
    x, y, z = position.T
    distance = np.sqrt(x * x + y * y + z * z)
    unit = position / np.where(distance > 0.0, distance, 1.0)[:, None]
    along = (unit[:, :, None] * unit[:, None, :] * cov[:, :3, :3]).sum(axis=(1, 2))
    sigma = result.position_sigma_m
    nonzero = np.where(sigma > 0.0, sigma, np.inf)
    columns = [distance, np.sqrt(np.maximum(along, 0.0)), x, y, z, *sigma.T]
    columns += [cov[:, a, b] / (nonzero[:, a] * nonzero[:, b]) for a, b in ((0, 1), (0, 2), (1, 2))]
    table = np.where(known[:, None], np.column_stack(columns), np.nan)
    return np.column_stack([table, result.nis, told])


def angles_of(result: RelativeResult, known: NDArray[np.bool_]) -> tuple[Float, Float]:
    """Return z-y-x angles of the sensor against the source, and their sigmas by first order."""
    matrix = rotation.to_matrix(result.q_source_sensor)
    middle = np.arcsin(np.clip(-matrix[:, 2, 0], -1.0, 1.0))
    about_z = np.arctan2(matrix[:, 1, 0], matrix[:, 0, 0])
    about_x = np.arctan2(matrix[:, 2, 1], matrix[:, 2, 2])
    sine, cosine = np.sin(about_x), np.cos(about_x)
    near = np.cos(middle)
    near = np.where(np.abs(near) < 1e-6, 1e-6, near)
    zero, one = np.zeros_like(sine), np.ones_like(sine)
    rows = (
        (zero, sine / near, cosine / near),
        (zero, cosine, -sine),
        (one, sine * np.tan(middle), cosine * np.tan(middle)),
    )
    row = np.stack([value for one in rows for value in one], axis=1).reshape(-1, 3, 3)
    cov = result.covariance[:, None, 3:, 3:]
    variance = (row[:, :, :, None] * row[:, :, None, :] * cov).sum(axis=(2, 3))
    spread = np.sqrt(np.maximum(variance, 0.0))
    keep = known[:, None]
    found = np.column_stack([about_z, middle, about_x])
    return np.where(keep, found, np.nan), np.where(keep, spread, np.nan)


def frame_flags(told: NDArray[np.uint16]) -> NDArray[np.uint8]:
    """Say in the words of frames what the filter says."""
    bits = np.zeros(told.shape, dtype=np.uint8)
    if not told.any():
        return bits
    for own, shown in _SHOWN:
        bits[(told & own) != 0] |= shown
    return bits


def angle_flags(flags: NDArray[np.uint8], angle: Float) -> NDArray[np.uint8]:
    """Return the flags of the angles, (K, A), from those of the segments, (K, G): singular where flexion is near 90."""
    bits = np.repeat(flags[:, 1:], len(ANGLES), axis=1)
    middle = np.repeat(np.cos(angle[:, 1 :: len(ANGLES)]), len(ANGLES), axis=1)
    bits[np.abs(middle) < _SINGULAR_COSINE] |= _SINGULAR
    return bits


def room_sigma(q_room_sensor: Float, covariance: Float, known: NDArray[np.bool_]) -> Float:
    """Return one sigma of the orientation about the room axes, (K, 3), from the covariance in sensor axes."""
    turn, cov = rotation.to_matrix(q_room_sensor), covariance[:, None, 3:, 3:]
    variance = (turn[:, :, :, None] * turn[:, :, None, :] * cov).sum(axis=(2, 3))
    return np.where(known[:, None], np.sqrt(np.maximum(variance, 0.0)), np.nan)


__all__ = [
    "ANGLES",
    "SENSOR_SCALARS",
    "SOURCE_SCALARS",
    "angle_flags",
    "angles_of",
    "frame_flags",
    "layout_of",
    "room_sigma",
    "sensor_scalars",
]
