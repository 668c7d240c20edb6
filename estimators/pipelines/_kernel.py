"""From sensors in the earth frame to segments in the room: one compiled call a chunk."""

from collections.abc import Callable
from typing import cast

import numba
import numpy as np
from numpy.typing import NDArray

from estimators import rotation
from estimators.recording import Float

Flags = NDArray[np.uint8]
_INVALID = np.uint8(1)  # OrientationFlag.INVALID; numba wants a plain constant


def compose_numpy(
    q_earth_sensor: Float,
    sigma_earth: Float,
    rate_radps: Float,
    flags: Flags,
    q_room_earth: Float,
    q_sensor_segment: Float,
) -> tuple[Float, Float, Float]:
    """Numpy twin of `compose`: the test oracle; returns what `compose` fills."""
    q_room_sensor = rotation.multiply(q_room_earth[:, None], q_earth_sensor)
    q_room_segment = rotation.multiply(q_room_sensor, q_sensor_segment[:, None])
    omega = np.where((flags & _INVALID)[..., None] != 0, np.nan, rotation.rotate(q_room_sensor, rate_radps))
    squared = rotation.to_matrix(q_room_earth)[:, None] ** 2
    sigma = np.sqrt(
        np.einsum("skij,skj->ski", np.broadcast_to(squared, (*flags.shape, 3, 3)), sigma_earth**2)
    )
    return q_room_segment.swapaxes(0, 1), omega.swapaxes(0, 1), sigma.swapaxes(0, 1)


def compose_python(
    q_earth_sensor: Float,
    sigma_earth: Float,
    gyroscope_radps: Float,
    bias_radps: Float,
    flags: Flags,
    q_room_earth: Float,
    q_sensor_segment: Float,
    q_room_segment: Float,
    omega_room: Float,
    sigma_room: Float,
    segment_flags: Flags,
) -> None:
    """Fill the outputs, shapes (K, S, ...), from inputs of shapes (S, K, ...) and (S, 4).

    Orientation is `q_room_earth * q_earth_sensor * q_sensor_segment`; the turning rate is that of the segment
    in room axes, NaN where there is no estimate; sigma is about the room axes.
    """
    sensors, ticks = flags.shape
    for s in range(sensors):
        aw, ax, ay, az = q_room_earth[s, 0], q_room_earth[s, 1], q_room_earth[s, 2], q_room_earth[s, 3]
        cw, cx, cy, cz = (
            q_sensor_segment[s, 0],
            q_sensor_segment[s, 1],
            q_sensor_segment[s, 2],
            q_sensor_segment[s, 3],
        )
        # q_room_earth turns about z only.
        cosine, sine = aw * aw - az * az, 2.0 * aw * az
        for k in range(ticks):
            bw, bx, by, bz = (
                q_earth_sensor[s, k, 0],
                q_earth_sensor[s, k, 1],
                q_earth_sensor[s, k, 2],
                q_earth_sensor[s, k, 3],
            )
            w = aw * bw - ax * bx - ay * by - az * bz
            x = aw * bx + ax * bw + ay * bz - az * by
            y = aw * by - ax * bz + ay * bw + az * bx
            z = aw * bz + ax * by - ay * bx + az * bw
            q_room_segment[k, s, 0] = w * cw - x * cx - y * cy - z * cz
            q_room_segment[k, s, 1] = w * cx + x * cw + y * cz - z * cy
            q_room_segment[k, s, 2] = w * cy - x * cz + y * cw + z * cx
            q_room_segment[k, s, 3] = w * cz + x * cy - y * cx + z * cw
            flag = flags[s, k]
            segment_flags[k, s] = flag
            if flag & _INVALID:
                for i in range(3):
                    omega_room[k, s, i] = np.nan
            else:
                p = gyroscope_radps[s, k, 0] - bias_radps[s, k, 0]
                q = gyroscope_radps[s, k, 1] - bias_radps[s, k, 1]
                r = gyroscope_radps[s, k, 2] - bias_radps[s, k, 2]
                tx, ty, tz = 2.0 * (y * r - z * q), 2.0 * (z * p - x * r), 2.0 * (x * q - y * p)
                omega_room[k, s, 0] = p + w * tx + y * tz - z * ty
                omega_room[k, s, 1] = q + w * ty + z * tx - x * tz
                omega_room[k, s, 2] = r + w * tz + x * ty - y * tx
            sx, sy = sigma_earth[s, k, 0], sigma_earth[s, k, 1]
            sigma_room[k, s, 0] = np.sqrt((cosine * sx) ** 2 + (sine * sy) ** 2)
            sigma_room[k, s, 1] = np.sqrt((sine * sx) ** 2 + (cosine * sy) ** 2)
            sigma_room[k, s, 2] = sigma_earth[s, k, 2]


compose = cast(
    Callable[..., None],
    numba.njit(
        "void(f8[:,:,::1],f8[:,:,::1],f8[:,:,::1],f8[:,:,::1],u1[:,::1],f8[:,::1],f8[:,::1],"
        "f8[:,:,::1],f8[:,:,::1],f8[:,:,::1],u1[:,::1])",
        cache=True,
        nogil=True,
        error_model="numpy",
    )(compose_python),
)
