"""Footholds, course and foot angle while somebody walks: the loop over released samples of the feet."""

import math

import numpy as np
from numpy.typing import NDArray

from estimators._kernels import kernel, multiply, rotate, rotate_back, step, wrapped
from estimators.recording import Float

WINDOW = 5
"""Footholds that tell the course: four strides."""
# One foot's memory.
STANDING, STOOD, COUNT, PLACED, COURSE, CERTAIN, TOE_OUT, LENGTH, HAS_LAST, LOST = range(10)
SUM, FIRST, ANCHOR_WORLD, ANCHOR_ROOM = 10, 13, 16, 19
Q_LAST, Q_STOOD, RATES, UP, WENT, HOLDS = 22, 26, 30, 36, 39, 42
HOLD = 4
"""A foothold: place and where the foot points."""
ALONE = HOLDS + WINDOW * HOLD
"""Where this foot is to the other is not known, since a long gap."""
FOOT = ALONE + 1

(
    S_STEP,
    S_LEAST_M,
    S_FIRST_M,
    S_SURE_M,
    S_STRAIGHT_RAD,
    S_GAIN,
    S_FLAT_S,
    S_KNOWN_AXES,
    S_APART_M,
    SETTINGS,
) = range(10)
# What is written of a tick and a foot.
O_PLACE, O_COURSE, O_PLACED, O_TOE_OUT, O_LENGTH, O_Q, O_LOST, O_JOINED, OUT = 0, 3, 4, 5, 6, 7, 11, 12, 13


@step("UniTuple(float64, 3)(float64[::1])")
def _forward(m: Float) -> tuple[float, float, float]:
    """Return where the toes are in the sensor's axes: across the axis about which the foot rolls."""
    ux, uy, uz = m[UP], m[UP + 1], m[UP + 2]
    size = math.sqrt(ux * ux + uy * uy + uz * uz)
    if size == 0.0:
        return 1.0, 0.0, 0.0
    ux, uy, uz = ux / size, uy / size, uz / size
    # Two directions across "up", the first as far from it as the axes allow.
    if abs(ux) < 0.7:
        ax, ay, az = 1.0 - ux * ux, -ux * uy, -ux * uz
    else:
        ax, ay, az = -uy * ux, 1.0 - uy * uy, -uy * uz
    size = math.sqrt(ax * ax + ay * ay + az * az)
    ax, ay, az = ax / size, ay / size, az / size
    bx, by, bz = uy * az - uz * ay, uz * ax - ux * az, ux * ay - uy * ax
    xx, xy, xz, yy, yz, zz = m[RATES], m[RATES + 1], m[RATES + 2], m[RATES + 3], m[RATES + 4], m[RATES + 5]
    tx, ty, tz = xx * ax + xy * ay + xz * az, xy * ax + yy * ay + yz * az, xz * ax + yz * ay + zz * az
    aa, ab = tx * ax + ty * ay + tz * az, tx * bx + ty * by + tz * bz
    tx, ty, tz = xx * bx + xy * by + xz * bz, xy * bx + yy * by + yz * bz, xz * bx + yz * by + zz * bz
    bb = tx * bx + ty * by + tz * bz
    angle = 0.5 * math.atan2(2.0 * ab, aa - bb)
    c, s = math.cos(angle), math.sin(angle)
    lx, ly, lz = c * ax + s * bx, c * ay + s * by, c * az + s * bz
    fx, fy, fz = ly * uz - lz * uy, lz * ux - lx * uz, lx * uy - ly * ux
    if fx * m[WENT] + fy * m[WENT + 1] + fz * m[WENT + 2] < 0.0:
        return -fx, -fy, -fz
    return fx, fy, fz


@step("void(float64[::1], float64, float64, float64, float64[::1])")
def _placed(m: Float, x: float, y: float, z: float, out: Float) -> None:
    """Write a place of the foot's own world in the room."""
    c, s = math.cos(m[COURSE]), math.sin(m[COURSE])
    dx, dy = x - m[ANCHOR_WORLD], y - m[ANCHOR_WORLD + 1]
    out[0] = m[ANCHOR_ROOM] + c * dx + s * dy
    out[1] = m[ANCHOR_ROOM + 1] - s * dx + c * dy
    out[2] = m[ANCHOR_ROOM + 2] + z - m[ANCHOR_WORLD + 2]


@step("void(float64[::1], float64, float64, float64)")
def _anchor(m: Float, x: float, y: float, z: float) -> None:
    """Turn later changes of the course about this place, so that the foot does not jump."""
    place = np.empty(3)
    _placed(m, x, y, z, place)
    m[ANCHOR_WORLD], m[ANCHOR_WORLD + 1], m[ANCHOR_WORLD + 2] = x, y, z
    m[ANCHOR_ROOM], m[ANCHOR_ROOM + 1], m[ANCHOR_ROOM + 2] = place[0], place[1], place[2]


@step("UniTuple(float64, 3)(float64[::1])")
def _window(m: Float) -> tuple[float, float, float]:
    """Return direction and length of the way over the last footholds, and how far the foot turned in them."""
    count = min(int(m[COUNT]), WINDOW)
    last, first = HOLDS, HOLDS + (count - 1) * HOLD
    dx, dy = m[last] - m[first], m[last + 1] - m[first + 1]
    most = 0.0
    for k in range(1, count):
        most = max(most, abs(wrapped(m[HOLDS + k * HOLD + 3] - m[last + 3])))
    return math.atan2(dy, dx), math.sqrt(dx * dx + dy * dy), most


@step("void(float64[::1], float64[::1])")
def _begin_anew(m: Float, p: Float) -> None:
    """Begin after a long gap where the foot was lost: nothing is known of the strides in it."""
    _anchor(m, p[0], p[1], p[2])
    m[STANDING], m[COUNT], m[PLACED], m[CERTAIN], m[HAS_LAST] = 0.0, 0.0, 0.0, 0.0, 0.0
    m[LOST], m[ALONE] = 1.0, 1.0


@step("void(float64[::1], float64[::1], float64[:, ::1], int64, float64)")
def _join(settings: Float, m: Float, feet: Float, other: int, outward: float) -> None:
    """Put a foot that was lost beside the other, where both go straight and have made a stride.

    The stance of this foot has just ended. Feet that go one way have their footholds half-way between those of the
    other foot: it stands already, half a stride ahead, or its last stance was half a stride behind.
    """
    its = feet[other]
    if m[COUNT] < 2.0 or its[COUNT] < 2.0 or m[PLACED] == 0.0 or its[PLACED] == 0.0:
        return
    direction, length, turned = _window(m)
    its_direction, its_length, its_turned = _window(its)
    if min(length, its_length) < settings[S_FIRST_M] or max(turned, its_turned) > settings[S_STRAIGHT_RAD]:
        return
    going = its_direction - its[COURSE]
    place = np.empty(3)
    if its[STANDING] > 0.0:
        _placed(its, its[SUM] / its[STOOD], its[SUM + 1] / its[STOOD], its[SUM + 2] / its[STOOD], place)
        ahead = -0.5 * its[LENGTH]
    else:
        _placed(its, its[HOLDS], its[HOLDS + 1], its[HOLDS + 2], place)
        ahead = 0.5 * its[LENGTH]
    aside = outward * settings[S_APART_M]
    c, s = math.cos(going), math.sin(going)
    m[COURSE] = direction - going
    m[ANCHOR_WORLD], m[ANCHOR_WORLD + 1], m[ANCHOR_WORLD + 2] = m[HOLDS], m[HOLDS + 1], m[HOLDS + 2]
    m[ANCHOR_ROOM] = place[0] + c * ahead - s * aside
    m[ANCHOR_ROOM + 1] = place[1] + s * ahead + c * aside
    m[ANCHOR_ROOM + 2] = place[2]
    m[CERTAIN] = 1.0
    # What the other is worth in the room is what this one is worth now.
    m[LOST], m[ALONE] = its[LOST], 0.0
    its[ALONE] = 0.0


@step("void(float64[::1], float64[::1], float64[:, ::1], int64, float64)")
def _new_foothold(settings: Float, m: Float, feet: Float, other: int, outward: float) -> None:
    """Take note of a stance that has ended: stride, foot angle, and what it says about the course."""
    x, y, z = m[SUM] / m[STOOD], m[SUM + 1] / m[STOOD], m[SUM + 2] / m[STOOD]
    ux, uy, uz = rotate_back(m[Q_STOOD], m[Q_STOOD + 1], m[Q_STOOD + 2], m[Q_STOOD + 3], 0.0, 0.0, 1.0)
    m[UP] += ux
    m[UP + 1] += uy
    m[UP + 2] += uz
    dx, dy, dz = x - m[HOLDS], y - m[HOLDS + 1], z - m[HOLDS + 2]
    way = math.sqrt(dx * dx + dy * dy)
    if m[COUNT] > 0.0:
        if way < settings[S_LEAST_M]:
            return
        ux, uy, uz = rotate_back(m[Q_STOOD], m[Q_STOOD + 1], m[Q_STOOD + 2], m[Q_STOOD + 3], dx, dy, dz)
        m[WENT] += ux
        m[WENT + 1] += uy
        m[WENT + 2] += uz
    fx, fy, fz = (1.0, 0.0, 0.0) if settings[S_KNOWN_AXES] > 0.0 else _forward(m)
    fx, fy, fz = rotate(m[Q_STOOD], m[Q_STOOD + 1], m[Q_STOOD + 2], m[Q_STOOD + 3], fx, fy, fz)
    points = math.atan2(fy, fx)
    for k in range(WINDOW - 1, 0, -1):
        for i in range(HOLD):
            m[HOLDS + k * HOLD + i] = m[HOLDS + (k - 1) * HOLD + i]
    m[HOLDS], m[HOLDS + 1], m[HOLDS + 2], m[HOLDS + 3] = x, y, z, points
    m[COUNT] += 1.0
    if m[COUNT] == 1.0:
        m[FIRST], m[FIRST + 1], m[FIRST + 2] = x, y, z
        m[ANCHOR_WORLD], m[ANCHOR_WORLD + 1], m[ANCHOR_WORLD + 2] = x, y, z
        return
    m[LENGTH] = way
    m[TOE_OUT] = outward * wrapped(points - math.atan2(dy, dx))
    direction, length, turned = _window(m)
    was_certain = m[CERTAIN] > 0.0
    if not was_certain:
        # From the start on, while the way is straight: the whole of it tells the course best.
        gx, gy = x - m[FIRST], y - m[FIRST + 1]
        gone = math.sqrt(gx * gx + gy * gy)
        if gone > settings[S_FIRST_M] and (m[PLACED] == 0.0 or turned < settings[S_STRAIGHT_RAD]):
            m[COURSE], m[PLACED] = math.atan2(gy, gx), 1.0
        if m[PLACED] > 0.0 and (gone > settings[S_SURE_M] or turned >= settings[S_STRAIGHT_RAD]):
            m[CERTAIN] = 1.0
            _anchor(m, x, y, z)
    else:
        _anchor(m, x, y, z)
    if other >= 0 and m[ALONE] > 0.0:
        _join(settings, m, feet, other, outward)
    elif was_certain and other >= 0 and feet[other, CERTAIN] > 0.0 and length > settings[S_FIRST_M]:
        its, its_length, its_turned = _window(feet[other])
        if its_length > settings[S_FIRST_M] and max(turned, its_turned) < settings[S_STRAIGHT_RAD]:
            # On a straight way both feet go one course; headings drift apart slowly.
            apart = wrapped((direction - m[COURSE]) - (its - feet[other, COURSE]))
            m[COURSE] += settings[S_GAIN] * apart


@kernel(
    "void(float64[::1], float64[:, :, ::1], float64[:, :, ::1], uint8[:, ::1], float64[:, ::1],"
    " float64[:, :, ::1])"
)
def follow(
    settings: Float,
    q_world_sensor: Float,
    position_m: Float,
    bits: NDArray[np.uint8],
    feet: Float,
    out: Float,
) -> None:
    """Take the next released samples.

    Parameters
    ----------
    settings : ndarray, shape (SETTINGS,)
    q_world_sensor, position_m : ndarray, shape (F, K, 4) and (F, K, 3)
    bits : ndarray of uint8, shape (F, K)
        1: the foot stands; 2: nothing is known of it; 4: a right foot; 8: it begins again after a long gap.
    feet : ndarray, shape (F, FOOT)
        Memory, changed.
    out : ndarray, shape (K, F, OUT)
        Place in the room (3), course, whether the foot is placed, toe-out and stride length, the sensor's
        orientation in the room (4), whether the place is lost, and whether a foot was put beside the other just now.
    """
    feet_count, count = position_m.shape[0], position_m.shape[1]
    for k in range(count):
        for f in range(feet_count):
            m, q, p = feet[f], q_world_sensor[f, k], position_m[f, k]
            row = out[k, f]
            row[O_TOE_OUT], row[O_LENGTH], row[O_JOINED] = np.nan, np.nan, 0.0
            if bits[f, k] & 8:
                _begin_anew(m, p)
            if not bits[f, k] & 2:
                if m[HAS_LAST] > 0.0:
                    # Twice the vector part of the turn since the last sample, in sensor axes: the rate, but for
                    # a factor that does not matter.
                    a = multiply(
                        m[Q_LAST], -m[Q_LAST + 1], -m[Q_LAST + 2], -m[Q_LAST + 3], q[0], q[1], q[2], q[3]
                    )
                    m[RATES] += a[1] * a[1]
                    m[RATES + 1] += a[1] * a[2]
                    m[RATES + 2] += a[1] * a[3]
                    m[RATES + 3] += a[2] * a[2]
                    m[RATES + 4] += a[2] * a[3]
                    m[RATES + 5] += a[3] * a[3]
                m[Q_LAST], m[Q_LAST + 1], m[Q_LAST + 2], m[Q_LAST + 3] = q[0], q[1], q[2], q[3]
                m[HAS_LAST] = 1.0
            stands = bits[f, k] & 3 == 1
            if stands:
                if m[STANDING] == 0.0:
                    m[STANDING], m[STOOD] = 1.0, 0.0
                    m[SUM], m[SUM + 1], m[SUM + 2] = 0.0, 0.0, 0.0
                m[STOOD] += 1.0
                for i in range(3):
                    m[SUM + i] += p[i]
                if m[STOOD] * settings[S_STEP] <= settings[S_FLAT_S]:
                    m[Q_STOOD], m[Q_STOOD + 1], m[Q_STOOD + 2], m[Q_STOOD + 3] = q[0], q[1], q[2], q[3]
            elif m[STANDING] > 0.0:
                m[STANDING] = 0.0
                other = 1 - f if feet_count == 2 else -1
                was_alone = m[ALONE]
                _new_foothold(settings, m, feet, other, -1.0 if bits[f, k] & 4 else 1.0)
                row[O_JOINED] = was_alone - m[ALONE]
            _placed(m, p[0], p[1], p[2], row[O_PLACE : O_PLACE + 3])
            is_alone = feet_count == 2 and m[ALONE] > 0.0
            row[O_COURSE], row[O_PLACED] = m[COURSE], 0.0 if is_alone else m[PLACED]
            row[O_LOST] = m[LOST]
            half = -0.5 * m[COURSE]
            turned = multiply(math.cos(half), 0.0, 0.0, math.sin(half), q[0], q[1], q[2], q[3])
            row[O_Q], row[O_Q + 1], row[O_Q + 2], row[O_Q + 3] = turned
            if m[COUNT] > 1.0:
                row[O_TOE_OUT], row[O_LENGTH] = m[TOE_OUT], m[LENGTH]
