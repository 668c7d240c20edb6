"""From sensors in the earth frame to segments in the room: one compiled call a chunk."""

import numpy as np
from numpy.typing import NDArray

from estimators import rotation
from estimators.kernels import borrowing
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


def compose_python(
    q_earth_sensor: Float,
    sigma_earth: Float,
    gyroscope_radps: Float,
    bias_radps: Float,
    flags: Flags,
    q_room_earth: Float,
    q_sensor_segment: Float,
    mounting_variance: Float,
    more_flags: Flags,
    q_room_segment: Float,
    omega_room: Float,
    sigma_room: Float,
    segment_flags: Flags,
) -> None:
    """Fill the outputs, shapes (K, S, ...), from inputs of shapes (S, K, ...), (S, 4), (S, 3) and (S,).

    Orientation is `q_room_earth * q_earth_sensor * q_sensor_segment`; the turning rate is that of the segment
    in room axes, NaN where there is no estimate; sigma is about the room axes, that of the orientation and what the
    mounting adds to it (variances about the segment's axes; shape (0, 3) where nothing is known). `more_flags` are
    set at every tick of a sensor.
    """
    sensors, ticks = flags.shape
    has_mounting = mounting_variance.shape[0] > 0
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
            gw = w * cw - x * cx - y * cy - z * cz
            gx = w * cx + x * cw + y * cz - z * cy
            gy = w * cy - x * cz + y * cw + z * cx
            gz = w * cz + x * cy - y * cx + z * cw
            q_room_segment[k, s, 0] = gw
            q_room_segment[k, s, 1] = gx
            q_room_segment[k, s, 2] = gy
            q_room_segment[k, s, 3] = gz
            flag = flags[s, k]
            segment_flags[k, s] = flag | more_flags[s]
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
            about_x = np.sqrt((cosine * sx) ** 2 + (sine * sy) ** 2)
            about_y = np.sqrt((sine * sx) ** 2 + (cosine * sy) ** 2)
            about_z = sigma_earth[s, k, 2]
            if has_mounting:
                vx, vy, vz = mounting_variance[s, 0], mounting_variance[s, 1], mounting_variance[s, 2]
                a, b, c = 1 - 2 * (gy * gy + gz * gz), 2 * (gx * gy - gw * gz), 2 * (gx * gz + gw * gy)
                about_x = np.sqrt(about_x**2 + (a * a * vx + b * b * vy + c * c * vz))
                a, b, c = 2 * (gx * gy + gw * gz), 1 - 2 * (gx * gx + gz * gz), 2 * (gy * gz - gw * gx)
                about_y = np.sqrt(about_y**2 + (a * a * vx + b * b * vy + c * c * vz))
                a, b, c = 2 * (gx * gz - gw * gy), 2 * (gy * gz + gw * gx), 1 - 2 * (gx * gx + gy * gy)
                about_z = np.sqrt(about_z**2 + (a * a * vx + b * b * vy + c * c * vz))
            sigma_room[k, s, 0] = about_x
            sigma_room[k, s, 1] = about_y
            sigma_room[k, s, 2] = about_z


compose = borrowing(
    "void(f8[:,:,::1],f8[:,:,::1],f8[:,:,::1],f8[:,:,::1],u1[:,::1],f8[:,::1],f8[:,::1],"
    "f8[:,::1],u1[::1],f8[:,:,::1],f8[:,:,::1],f8[:,:,::1],u1[:,::1])"
)(compose_python)
