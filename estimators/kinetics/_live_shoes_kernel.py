"""Loads of two shoes while somebody walks: zero found again in every swing, ground reaction, and what is wrong."""

import math

import numpy as np
from numpy.typing import NDArray

from estimators._kernels import multiply, rotate, step, wrapped
from estimators.recording import Float

MEASURED, UNTARED, MISSING, IMPLAUSIBLE = 0, 1, 2, 3
"""What is to be said of a shoe's forces at a sample."""
HEEL_FORCE, HEEL_MOMENT, FOREFOOT_FORCE, FOREFOOT_MOMENT, LOADS = 0, 3, 6, 9, 12
"""Force and moment of the heel cell, then of the forefoot cell."""
# One shoe's memory.
TARED, SWINGING, COUNTED, PEAK, LAST_PEAK, TWIST, HEEL_ON, FOREFOOT_ON = range(8)
SINGLE_SUM, SINGLE_COUNT, SINGLE_LOAD, WRONG, FLOOR, HAS_FLOOR = range(8, 14)
ZERO, SWING_SUM, SWING_LEAST, SWING_MOST = 14, 26, 38, 50
SHOE = SWING_MOST + LOADS
S_STEP, S_SENSOR_HEIGHT, S_HINGE, S_FOREFOOT, S_REAR, S_TOE, S_HALF_WIDTH, SETTINGS = range(8)

_ON_N, _OFF_N, _LEAST_COP_N = 20.0, 10.0, 20.0
_AIR_MPS, _AIR_SHARE = 0.4, 0.6
"""A foot faster than both is in the middle of a swing; the share is of the fastest of the swing before."""
_SHORTEST_SWING_S, _QUIET_N = 0.08, 12.0
_MOST_N, _LEAST_SINGLE_N, _MOST_SINGLE_N = 5000.0, 200.0, 3000.0
_SINGLE_SHARE, _SINGLE_S = 0.5, 0.1
FORCE, COP, STATE, HEEL, FOREFOOT, OUT = 0, 3, 6, 7, 8, 9
_SOLE = 4
"""Corners of the heel's sole; those of the forefoot's follow."""


@step("void(float64[::1], float64[::1], float64[::1], float64)")
def _follow_swing(settings: Float, m: Float, load: Float, speed: float) -> None:
    """Find the zero of both cells in the middle of a swing."""
    m[PEAK] = max(m[PEAK], speed)
    if speed > max(_AIR_MPS, _AIR_SHARE * m[LAST_PEAK]) and speed > _AIR_SHARE * m[PEAK]:
        if m[SWINGING] == 0.0:
            m[SWINGING], m[COUNTED] = 1.0, 0.0
        for i in range(LOADS):
            if m[COUNTED] == 0.0:
                m[SWING_SUM + i] = 0.0
                m[SWING_LEAST + i], m[SWING_MOST + i] = load[i], load[i]
            m[SWING_SUM + i] += load[i]
            m[SWING_LEAST + i] = min(m[SWING_LEAST + i], load[i])
            m[SWING_MOST + i] = max(m[SWING_MOST + i], load[i])
        m[COUNTED] += 1.0
    elif m[SWINGING] > 0.0 and speed < 0.5 * _AIR_MPS:
        # The swing is over. A cell that was not quiet was not in the air, or is not sound.
        is_quiet = m[COUNTED] * settings[S_STEP] >= _SHORTEST_SWING_S
        for cell in range(2):
            for i in range(3):
                at = FOREFOOT_FORCE * cell + i
                is_quiet = is_quiet and m[SWING_MOST + at] - m[SWING_LEAST + at] < _QUIET_N
        if is_quiet:
            for i in range(LOADS):
                m[ZERO + i] = m[SWING_SUM + i] / m[COUNTED]
            m[TARED] = 1.0
        m[LAST_PEAK], m[PEAK], m[SWINGING], m[COUNTED] = m[PEAK], 0.0, 0.0, 0.0


@step("void(float64[::1], float64[::1], float64[:, ::1], int64, float64, float64, boolean)")
def _judge(
    settings: Float, m: Float, shoes: Float, other: int, up_n: float, other_mps: float, stands: bool
) -> None:
    """Compare what a foot carries alone with what a person weighs, and with what the other foot carries alone."""
    its = shoes[other]
    if stands and other_mps > max(_AIR_MPS, _AIR_SHARE * its[LAST_PEAK]):
        m[SINGLE_SUM] += up_n
        m[SINGLE_COUNT] += 1.0
    elif m[SINGLE_COUNT] > 0.0 and other_mps < 0.5 * _AIR_MPS:
        if m[SINGLE_COUNT] * settings[S_STEP] >= _SINGLE_S:
            load = m[SINGLE_SUM] / m[SINGLE_COUNT]
            m[SINGLE_LOAD] = load
            is_wrong = not (_LEAST_SINGLE_N < load < _MOST_SINGLE_N)
            # With a cell that has failed a shoe shows too little; a stick takes less than half.
            if its[WRONG] == 0.0 and its[SINGLE_LOAD] > 0.0 and load < _SINGLE_SHARE * its[SINGLE_LOAD]:
                is_wrong = True
            m[WRONG] = 1.0 if is_wrong else 0.0
        m[SINGLE_SUM], m[SINGLE_COUNT] = 0.0, 0.0


@step("boolean(float64, boolean)")
def _touches(up_n: float, before: bool) -> bool:
    return up_n > _ON_N or (before and up_n >= _OFF_N)


@step(
    "void(float64[::1], float64[:, :, ::1], float64[:, :, :, ::1], float64[:, :, ::1], float64[:, ::1],"
    " float64[:, ::1], uint8[:, ::1], float64[:, ::1], float64[:, :, ::1], float64[:, :, :, ::1],"
    " float64[:, ::1])"
)
def shoes_live(
    settings: Float,
    loads: Float,
    q_world_cell: Float,
    heel_m: Float,
    course_rad: Float,
    speed_mps: Float,
    bits: NDArray[np.uint8],
    shoes: Float,
    out: Float,
    corners: Float,
    zero_n: Float,
) -> None:
    """Bring the loads of the next samples into the room.

    Parameters
    ----------
    settings : ndarray, shape (SETTINGS,)
    loads : ndarray, shape (2, K or more, LOADS)
        Left and right shoe, cell axes; NaN where nothing was measured.
    q_world_cell : ndarray, shape (2, 2, K, 4)
        Of heel and forefoot, each in a world of its own heading.
    heel_m : ndarray, shape (2, K, 3)
        Heel sensor in the room.
    course_rad, speed_mps : ndarray, shape (2, K)
        Of the room in the heel's world; speed of the heel.
    bits : ndarray of uint8, shape (2, K)
        1: the foot stands; 2: nothing is known of it.
    shoes : ndarray, shape (2, SHOE)
        Memory, changed.
    out : ndarray, shape (2, K, OUT)
        Force (3), pressure centre (3), state, contact of heel and of forefoot. NaN where not measured.
    corners : ndarray, shape (2, K, 8, 2)
        Of the sole on the floor; NaN for parts that do not touch.
    zero_n : ndarray, shape (2, K)
        Vertical load that both cells of a shoe show in the air, as far as known.
    """
    force, moment, tared = np.empty(3), np.empty(3), np.empty(LOADS)
    heel, heel_moment = tared[HEEL_FORCE:HEEL_MOMENT], tared[HEEL_MOMENT:FOREFOOT_FORCE]
    forefoot, forefoot_moment = tared[FOREFOOT_FORCE:FOREFOOT_MOMENT], tared[FOREFOOT_MOMENT:]
    for k in range(speed_mps.shape[1]):
        for s in range(2):
            m, load = shoes[s], loads[s, k]
            result = out[s, k]
            result[:] = np.nan
            corners[s, k] = np.nan
            result[HEEL], result[FOREFOOT] = 0.0, 0.0
            zero_n[s, k] = m[ZERO + HEEL_FORCE + 2] + m[ZERO + FOREFOOT_FORCE + 2]
            measured, largest = True, 0.0
            for i in range(LOADS):
                measured = measured and not math.isnan(load[i])
                largest = max(largest, abs(load[i]))
            if not measured or bits[s, k] & 2:
                result[STATE] = MISSING
                # A swing with holes tells no zero.
                m[SWINGING], m[COUNTED], m[SINGLE_COUNT], m[SINGLE_SUM] = 0.0, 0.0, 0.0, 0.0
                continue
            if largest > _MOST_N:
                result[STATE] = IMPLAUSIBLE
                continue
            _follow_swing(settings, m, load, speed_mps[s, k])
            for i in range(LOADS):
                tared[i] = load[i] - m[ZERO + i]
            q, g = q_world_cell[s, 0, k], q_world_cell[s, 1, k]
            half = -0.5 * course_rad[s, k]
            hw, hx, hy, hz = multiply(math.cos(half), 0.0, 0.0, math.sin(half), q[0], q[1], q[2], q[3])
            fw, fx, fy, fz = multiply(math.cos(half), 0.0, 0.0, math.sin(half), g[0], g[1], g[2], g[3])
            heel_up = rotate(hw, hx, hy, hz, heel[0], heel[1], heel[2])[2]
            ball_up = rotate(fw, fx, fy, fz, forefoot[0], forefoot[1], forefoot[2])[2]
            if bits[s, k] & 1:
                m[FLOOR] = heel_m[s, k, 2] - settings[S_SENSOR_HEIGHT]
                m[HAS_FLOOR] = 1.0
                # The sole is straight while the foot rests: both parts point one way.
                if heel_up > _ON_N and ball_up > _ON_N:
                    ax, ay, _ = rotate(hw, hx, hy, hz, 1.0, 0.0, 0.0)
                    bx, by, _ = rotate(fw, fx, fy, fz, 1.0, 0.0, 0.0)
                    m[TWIST] = wrapped(math.atan2(by, bx) - math.atan2(ay, ax))
            c, d = math.cos(-0.5 * m[TWIST]), math.sin(-0.5 * m[TWIST])
            fw, fx, fy, fz = multiply(c, 0.0, 0.0, d, fw, fx, fy, fz)
            hinge = rotate(hw, hx, hy, hz, settings[S_HINGE], 0.0, 0.0)
            ahead = rotate(fw, fx, fy, fz, settings[S_FOREFOOT], 0.0, 0.0)
            force[:] = 0.0
            moment[:] = 0.0
            floor = m[FLOOR] if m[HAS_FLOOR] > 0.0 else heel_m[s, k, 2] - settings[S_SENSOR_HEIGHT]
            for cell in range(2):
                px, py, pz = heel_m[s, k, 0], heel_m[s, k, 1], heel_m[s, k, 2]
                if cell == 0:
                    a = rotate(hw, hx, hy, hz, heel[0], heel[1], heel[2])
                    b = rotate(hw, hx, hy, hz, heel_moment[0], heel_moment[1], heel_moment[2])
                else:
                    a = rotate(fw, fx, fy, fz, forefoot[0], forefoot[1], forefoot[2])
                    b = rotate(fw, fx, fy, fz, forefoot_moment[0], forefoot_moment[1], forefoot_moment[2])
                    px, py, pz = px + hinge[0] + ahead[0], py + hinge[1] + ahead[1], pz + hinge[2] + ahead[2]
                pz -= floor
                force[0] += a[0]
                force[1] += a[1]
                force[2] += a[2]
                # M = R M_S + p x (R F_S), about the room's axis on this floor
                moment[0] += b[0] + (py * a[2] - pz * a[1])
                moment[1] += b[1] + (pz * a[0] - px * a[2])
            for i in range(3):
                result[FORCE + i] = force[i]
            if force[2] > _LEAST_COP_N:
                result[COP] = -moment[1] / force[2]
                result[COP + 1] = moment[0] / force[2]
                result[COP + 2] = floor
            touches_heel = _touches(heel_up, m[HEEL_ON] > 0.0)
            touches_ball = _touches(ball_up, m[FOREFOOT_ON] > 0.0)
            m[HEEL_ON], m[FOREFOOT_ON] = 1.0 if touches_heel else 0.0, 1.0 if touches_ball else 0.0
            result[HEEL], result[FOREFOOT] = m[HEEL_ON], m[FOREFOOT_ON]
            _judge(settings, m, shoes, 1 - s, force[2], speed_mps[1 - s, k], (bits[s, k] & 1) > 0)
            if m[WRONG] > 0.0:
                result[STATE] = IMPLAUSIBLE
            else:
                result[STATE] = MEASURED if m[TARED] > 0.0 else UNTARED
            for corner in range(_SOLE):
                across = settings[S_HALF_WIDTH] if corner % 2 == 0 else -settings[S_HALF_WIDTH]
                down = -settings[S_SENSOR_HEIGHT]
                if touches_heel:
                    along = settings[S_REAR] if corner < 2 else settings[S_HINGE]
                    v = rotate(hw, hx, hy, hz, along, across, down)
                    corners[s, k, corner, 0] = heel_m[s, k, 0] + v[0]
                    corners[s, k, corner, 1] = heel_m[s, k, 1] + v[1]
                if touches_ball:
                    along = 0.0 if corner < 2 else settings[S_TOE]
                    v = rotate(fw, fx, fy, fz, along, across, down)
                    corners[s, k, _SOLE + corner, 0] = heel_m[s, k, 0] + hinge[0] + v[0]
                    corners[s, k, _SOLE + corner, 1] = heel_m[s, k, 1] + hinge[1] + v[1]
