"""From sensors in the earth frame to segments in the room: one compiled call a chunk."""

from typing import NamedTuple

import numpy as np
from numba import types
from numpy.typing import NDArray

from estimators import rotation
from estimators._kernels import Scalars3
from estimators.kernels import VOID, borrowing, bundle
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
    mounting_variance: Float,
) -> tuple[Float, Float, Float]:
    """Numpy twin of `compose`: the test oracle; returns the first three that `compose` fills."""
    q_room_sensor = rotation.multiply(q_room_earth[:, None], q_earth_sensor)
    q_room_segment = rotation.multiply(q_room_sensor, q_sensor_segment[:, None])
    omega = np.where((flags & _INVALID)[..., None] != 0, np.nan, rotation.rotate(q_room_sensor, rate_radps))
    squared = rotation.to_matrix(q_room_earth)[:, None] ** 2
    sigma = np.sqrt(
        np.einsum("skij,skj->ski", np.broadcast_to(squared, (*flags.shape, 3, 3)), sigma_earth**2)
    )
    if len(mounting_variance):
        part = rotation.to_matrix(q_room_segment) ** 2 * mounting_variance[:, None, None]
        sigma = np.sqrt(sigma**2 + (part[..., 0] + part[..., 1] + part[..., 2]))
    return q_room_segment.swapaxes(0, 1), omega.swapaxes(0, 1), sigma.swapaxes(0, 1)


class Worn(NamedTuple):
    """How the sensors are worn: shapes (S, 4), (S, 4), (S, 3) and (S,).

    `q_room_earth` turns about z only; variances are of the mounting, about the segment's axes, shape (0, 3) where
    nothing is known; `more_flags` are set at every tick.
    """

    q_room_earth: Float
    q_sensor_segment: Float
    mounting_variance: Float
    more_flags: Flags


@borrowing(inlined=True)
def _with_mounting(w: float, x: float, y: float, z: float, variance: Float, sigma: Scalars3) -> Scalars3:
    """Add to sigma about the room's axes what the mounting leaves open about the segment's."""
    vx, vy, vz = variance[0], variance[1], variance[2]
    about_x, about_y, about_z = sigma
    a, b, c = 1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)
    about_x = np.sqrt(about_x**2 + (a * a * vx + b * b * vy + c * c * vz))
    a, b, c = 2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)
    about_y = np.sqrt(about_y**2 + (a * a * vx + b * b * vy + c * c * vz))
    a, b, c = 2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)
    about_z = np.sqrt(about_z**2 + (a * a * vx + b * b * vy + c * c * vz))
    return about_x, about_y, about_z


def compose_python(
    q_earth_sensor: Float,
    sigma_earth: Float,
    gyroscope_radps: Float,
    bias_radps: Float,
    flags: Flags,
    worn: Worn,
    q_room_segment: Float,
    omega_room: Float,
    sigma_room: Float,
    segment_flags: Flags,
) -> None:
    """Fill the outputs, shapes (K, S, ...), from what is known of the sensors in the earth frame, shapes (S, K, ...).

    Orientation is `q_room_earth * q_earth_sensor * q_sensor_segment`; the turning rate is that of the segment
    in room axes, NaN where there is no estimate; sigma is about the room axes, that of the orientation and what the
    mounting adds to it.
    """
    sensors, ticks = flags.shape
    has_mounting = worn.mounting_variance.shape[0] > 0
    for s in range(sensors):
        first, last = worn.q_room_earth[s], worn.q_sensor_segment[s]
        aw, ax, ay, az = first[0], first[1], first[2], first[3]
        cw, cx, cy, cz = last[0], last[1], last[2], last[3]
        # q_room_earth turns about z only.
        cosine, sine = aw * aw - az * az, 2.0 * aw * az
        for k in range(ticks):
            between = q_earth_sensor[s, k]
            bw, bx, by, bz = between[0], between[1], between[2], between[3]
            w = aw * bw - ax * bx - ay * by - az * bz
            x = aw * bx + ax * bw + ay * bz - az * by
            y = aw * by - ax * bz + ay * bw + az * bx
            z = aw * bz + ax * by - ay * bx + az * bw
            gw = w * cw - x * cx - y * cy - z * cz
            gx = w * cx + x * cw + y * cz - z * cy
            gy = w * cy - x * cz + y * cw + z * cx
            gz = w * cz + x * cy - y * cx + z * cw
            q_out, omega, sigma = q_room_segment[k, s], omega_room[k, s], sigma_room[k, s]
            q_out[0], q_out[1], q_out[2], q_out[3] = gw, gx, gy, gz
            flag = flags[s, k]
            segment_flags[k, s] = flag | worn.more_flags[s]
            if flag & _INVALID:
                omega[0], omega[1], omega[2] = np.nan, np.nan, np.nan
            else:
                rate, bias = gyroscope_radps[s, k], bias_radps[s, k]
                p, q, r = rate[0] - bias[0], rate[1] - bias[1], rate[2] - bias[2]
                tx, ty, tz = 2.0 * (y * r - z * q), 2.0 * (z * p - x * r), 2.0 * (x * q - y * p)
                omega[0] = p + w * tx + y * tz - z * ty
                omega[1] = q + w * ty + z * tx - x * tz
                omega[2] = r + w * tz + x * ty - y * tx
            sx, sy = sigma_earth[s, k, 0], sigma_earth[s, k, 1]
            about_x = np.sqrt((cosine * sx) ** 2 + (sine * sy) ** 2)
            about_y = np.sqrt((sine * sx) ** 2 + (cosine * sy) ** 2)
            about = (about_x, about_y, sigma_earth[s, k, 2])
            if has_mounting:
                about = _with_mounting(gw, gx, gy, gz, worn.mounting_variance[s], about)
            sigma[0], sigma[1], sigma[2] = about


_ROW, _TABLE, _CUBE = types.uint8[::1], types.float64[:, ::1], types.float64[:, :, ::1]
_BYTES = types.uint8[:, ::1]
compose = borrowing(
    VOID(
        *(_CUBE, _CUBE, _CUBE, _CUBE, _BYTES),
        bundle(Worn, _TABLE, _TABLE, _TABLE, _ROW),
        *(_CUBE, _CUBE, _CUBE, _BYTES),
    ),
    is_entry=True,
)(compose_python)
