"""Centre of mass from the orientations of worn sensors: the loop over ticks."""

import math

import numpy as np
from numpy.typing import NDArray

from estimators._kernels import kernel, normalized, rotate, rotate_back, step
from estimators.recording import Float

FROM_HIP, FROM_MIDDLE, FROM_LEFT, FROM_RIGHT, TARGETS = range(5)
PELVIS, STERNUM, SHANK_LEFT, SHANK_RIGHT, SOURCES = range(5)
S_ANKLE, S_LEVER2, S_HIP, SETTINGS = range(4)
AHEAD, LEFT, UP, SIGMA_AHEAD, SIGMA_LEFT, SIGMA_UP, SCALARS = range(7)
"""Places of `MASS_SCALARS`."""
_INVALID = np.uint8(1)  # OrientationFlag.INVALID; numba wants a plain constant


@step("UniTuple(float64, 4)(float64[::1], float64[::1])")
def _half_way(a: Float, b: Float) -> tuple[float, float, float, float]:
    """Return the mean of two orientations."""
    sign = 1.0 if a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3] >= 0.0 else -1.0
    return normalized(a[0] + sign * b[0], a[1] + sign * b[1], a[2] + sign * b[2], a[3] + sign * b[3])


@step("float64(float64[:, ::1], UniTuple(float64, 3))")
def _along(covariance: Float, n: tuple[float, float, float]) -> float:
    """Return the variance along a direction."""
    total = 0.0
    for i in range(3):
        for j in range(3):
            total += n[i] * covariance[i, j] * n[j]
    return total


@kernel(
    "void(float64[:, :, ::1], float64[:, :, ::1], uint8[:, ::1], float64[:, :, ::1], float64[:, :, :, ::1], uint8[::1],"
    " float64[::1], float64[:, ::1], int64[::1], float64[::1], float64[:, :, ::1], float64[:, ::1])"
)
def mass_centre(
    q: Float,
    sigma: Float,
    flags: NDArray[np.uint8],
    lever: Float,
    doubt: Float,
    has_doubt: NDArray[np.uint8],
    middle: Float,
    feet: Float,
    source: NDArray[np.int64],
    settings: Float,
    point: Float,
    scalar: Float,
) -> None:
    """Write place and sigma of every tick.

    Parameters
    ----------
    q : ndarray, shape (K, S, 4)
    sigma : ndarray, shape (K, S, 3)
        About the room axes.
    flags : ndarray of uint8, shape (K, S)
        Where a sensor is INVALID, scalars are NaN.
    lever : ndarray, shape (TARGETS, S, 3)
        What each sensor turns of the way to the centre of mass from the hips, the middle of the ankles, the left and
        the right ankle.
    doubt : ndarray, shape (TARGETS, S, 3, 3)
        Covariance, sensor's segment axes, of what only moves with it.
    has_doubt : ndarray of uint8, shape (S,)
        Where it is not zero.
    middle : ndarray, shape (3,)
        Lever of the middle trunk.
    feet : ndarray, shape (2, 3)
        Levers of level feet; zero where they are worn.
    source : ndarray of int64, shape (SOURCES,)
    settings : ndarray, shape (SETTINGS,)
    point : ndarray, shape (K, P, 3)
        The last point is written.
    scalar : ndarray, shape (K, C)
        The last six are written.
    """
    sensors, last, first = q.shape[1], point.shape[1] - 1, scalar.shape[1] - 6
    arm, place = np.empty((TARGETS, 3)), np.empty((TARGETS, 3))
    turned = np.empty((sensors, TARGETS, 3))
    for k in range(q.shape[0]):
        one, other = q[k, source[PELVIS]], q[k, source[STERNUM]]
        mw, mx, my, mz = _half_way(one, other)
        bx, by, bz = rotate(mw, mx, my, mz, middle[0], middle[1], middle[2])
        common_x, common_y, common_z = bx, by, bz
        for side in range(2):
            if feet[side, 0] != 0.0 or feet[side, 2] != 0.0:
                shank = q[k, source[SHANK_LEFT + side]]
                fx, fy, _ = rotate(shank[0], shank[1], shank[2], shank[3], 1.0, 0.0, 0.0)
                flat = math.sqrt(fx * fx + fy * fy)
                if flat > 0.0:
                    fx, fy = fx / flat, fy / flat
                common_x += fx * feet[side, 0] - fy * feet[side, 1]
                common_y += fy * feet[side, 0] + fx * feet[side, 1]
                common_z += feet[side, 2]
        for t in range(TARGETS):
            place[t, 0], place[t, 1], place[t, 2] = common_x, common_y, common_z
        lost = False
        for s in range(sensors):
            lost |= (flags[k, s] & _INVALID) != 0
            w, x, y, z = q[k, s, 0], q[k, s, 1], q[k, s, 2], q[k, s, 3]
            # Four levers turn by one matrix: half the products of turning each by the quaternion.
            xx, xy, xz = 1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)
            yx, yy, yz = 2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)
            zx, zy, zz = 2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)
            for t in range(TARGETS):
                a, b, c = lever[t, s, 0], lever[t, s, 1], lever[t, s, 2]
                vx, vy, vz = xx * a + xy * b + xz * c, yx * a + yy * b + yz * c, zx * a + zy * b + zz * c
                turned[s, t, 0], turned[s, t, 1], turned[s, t, 2] = vx, vy, vz
                place[t, 0] += vx
                place[t, 1] += vy
                place[t, 2] += vz
        # Ahead is where the pelvis faces.
        fx, fy, _ = rotate(one[0], one[1], one[2], one[3], 1.0, 0.0, 0.0)
        flat = math.sqrt(fx * fx + fy * fy)
        c, d = (fx / flat, fy / flat) if flat > 0.0 else (1.0, 0.0)
        lower = FROM_LEFT if place[FROM_LEFT, 2] >= place[FROM_RIGHT, 2] else FROM_RIGHT
        ahead2 = left2 = up2 = settings[S_LEVER2] / 3.0
        for s in range(sensors):
            part = 0.5 * float((s == source[PELVIS]) + (s == source[STERNUM]))
            for t in (FROM_MIDDLE, lower):
                vx, vy = turned[s, t, 0] + part * bx, turned[s, t, 1] + part * by
                arm[t, 0] = c * vx + d * vy
                arm[t, 1] = -d * vx + c * vy
                arm[t, 2] = turned[s, t, 2] + part * bz
            sx2, sy2, sz2 = sigma[k, s, 0] ** 2, sigma[k, s, 1] ** 2, sigma[k, s, 2] ** 2
            about_ahead, about_left = c * c * sx2 + d * d * sy2, d * d * sx2 + c * c * sy2
            m = arm[FROM_MIDDLE]
            ahead2 += about_left * m[2] ** 2 + sz2 * m[1] ** 2
            left2 += about_ahead * m[2] ** 2 + sz2 * m[0] ** 2
            m = arm[lower]
            up2 += about_ahead * m[1] ** 2 + about_left * m[0] ** 2
            if has_doubt[s]:
                w, x, y, z = q[k, s, 0], q[k, s, 1], q[k, s, 2], q[k, s, 3]
                up2 += _along(doubt[lower, s], rotate_back(w, x, y, z, 0.0, 0.0, 1.0))
                e = doubt[FROM_MIDDLE, s]
                ahead2 += _along(e, rotate_back(w, x, y, z, c, d, 0.0))
                left2 += _along(e, rotate_back(w, x, y, z, -d, c, 0.0))
        point[k, last, 0], point[k, last, 1] = place[FROM_HIP, 0], place[FROM_HIP, 1]
        point[k, last, 2] = settings[S_HIP] + place[FROM_HIP, 2]
        if lost:
            for i in range(SCALARS):
                scalar[k, first + i] = np.nan
            continue
        scalar[k, first + AHEAD] = c * place[FROM_MIDDLE, 0] + d * place[FROM_MIDDLE, 1]
        scalar[k, first + LEFT] = -d * place[FROM_MIDDLE, 0] + c * place[FROM_MIDDLE, 1]
        scalar[k, first + UP] = place[lower, 2] + settings[S_ANKLE]
        scalar[k, first + SIGMA_AHEAD] = math.sqrt(ahead2)
        scalar[k, first + SIGMA_LEFT] = math.sqrt(left2)
        scalar[k, first + SIGMA_UP] = math.sqrt(up2)
