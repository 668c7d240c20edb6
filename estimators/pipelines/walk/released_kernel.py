"""Frames of a walk from what the live foot filter released, compiled: steps, forces, centre of mass and flags."""

import math
from typing import Final, NamedTuple

import numpy as np
from numba import types
from numpy.typing import NDArray

from estimators.balance import _live_balance_kernel as balance
from estimators.compiling import compiled
from estimators.conventions import GRAVITY_MPS2
from estimators.gait import _live_steps_kernel as steps
from estimators.gait.foot import layout as at
from estimators.gait.foot.trajectory import FootFlag
from estimators.kernels import VOID, bundle, step
from estimators.kinetics import _live_shoes_kernel as shoe
from estimators.orientation import OrientationFlag
from estimators.pipelines.walk.layout import SCALARS, SPEED, STANCE, STRIDE_LENGTH, TOE_OUT
from estimators.recording import Float

_P, _V, _Q = at.P, at.V, at.Q
_PLACE_SIGMA, _TURN_SIGMA, _AFTER_SIGMA = at.POSITION_SIGMA, at.ATTITUDE_SIGMA, at.STATISTIC
_STANDS: Final = at.STANDS
_PER_FOOT: Final = len(SCALARS)
_UNKNOWN: Final = int(FootFlag.INVALID | FootFlag.NO_STANCE)
_NOTHING, _ANEW, _LOST, _BRIDGED, _CLIPPED = (
    int(getattr(FootFlag, name)) for name in ("INVALID", "BEGINS_ANEW", "PLACE_LOST", "BRIDGED", "SATURATED")
)
_INVALID, _HEADING, _WAS_BRIDGED, _SATURATED = (
    int(getattr(OrientationFlag, name)) for name in ("INVALID", "HEADING_NOT_TRUSTED", "BRIDGED", "SATURATED")
)
_O_PLACE, _O_COURSE, _O_PLACED, _O_LOST, _O_JOINED = (
    steps.O_PLACE,
    steps.O_COURSE,
    steps.O_PLACED,
    steps.O_LOST,
    steps.O_JOINED,
)
_O_TOE_OUT, _O_LENGTH, _O_Q, _OUT = steps.O_TOE_OUT, steps.O_LENGTH, steps.O_Q, steps.OUT
_SHIFT, _MASS, _COP, _GOING = balance.SHIFT, balance.MASS, balance.COP, balance.GOING
_MARGIN, _CENTRE_SIGMA, _WEIGHT = balance.MARGIN, balance.SIGMA, balance.WEIGHT
_HEIGHT: Final = shoe.S_SENSOR_HEIGHT
_UP = (shoe.HEEL_FORCE + 2, shoe.FOREFOOT_FORCE + 2)
_TURN: Final = 4
"""Numbers of an orientation."""
_MASS_POINT, _COP_POINT, _GOING_POINT, _PRESSED, _ROOM_POINTS = 2, 3, 4, 5, 7
"""Points of two shoes in a room, after their soles: centre of mass, of pressure, where the former goes; each shoe's."""
_FORCE_SCALARS: Final = 4
"""Force along three axes, and its state."""


class Feet(NamedTuple):
    """What is known of the feet that are drawn.

    Attributes
    ----------
    heels : ndarray of int64, shape (F,)
        Their sensors among those of the filter.
    right : ndarray of uint8, shape (F, 1)
        4 for a right foot.
    settings, memory : ndarray, shapes (SETTINGS,), (F, FOOT)
        Of `estimators.gait._live_steps_kernel`.
    offset_m : ndarray, shape (F, 3)
        Where feet without a common room are drawn.
    """

    heels: NDArray[np.int64]
    right: NDArray[np.uint8]
    settings: Float
    memory: Float
    offset_m: Float


class Shoes(NamedTuple):
    """What is known of the forces of two shoes.

    Attributes
    ----------
    settings, memory : ndarray
        Of `estimators.kinetics._live_shoes_kernel`, shoes leading.
    balance_settings, balance_memory, x, p : ndarray
        Of `estimators.balance._live_balance_kernel`.
    """

    settings: Float
    memory: Float
    balance_settings: Float
    balance_memory: Float
    x: Float
    p: Float


_F1, _F2, _F3 = (types.Array(types.float64, n, "C") for n in (1, 2, 3))
_FLAGS = types.uint8[:, ::1]
_FEET = bundle(Feet, types.int64[::1], _FLAGS, _F1, _F2, _F2)
_SHOES = bundle(Shoes, _F1, _F2, _F1, _F1, _F2, _F2)
WRITE_FEET: Final = VOID(_F3, _FLAGS, _FEET, _F2)
WRITE_SHOES: Final = VOID(_F3, _FLAGS, _FEET, _F3, _SHOES, _F2)


@step()
def _stepped(values: Float, flags: NDArray[np.uint8], feet: Feet) -> Float:
    """Follow the footholds; returns what `follow` writes, shape (K, F, OUT)."""
    count, ticks = len(feet.heels), values.shape[1]
    q, position = np.empty((count, ticks, 4)), np.empty((count, ticks, 3))
    bits = np.empty((count, ticks), dtype=np.uint8)
    for f in range(count):
        s = feet.heels[f]
        for k in range(ticks):
            for i in range(4):
                q[f, k, i] = values[s, k, _Q + i]
            for i in range(3):
                position[f, k, i] = values[s, k, _P + i]
            found = feet.right[f, 0]
            if values[s, k, _STANDS] > 0.0:
                found |= np.uint8(1)
            if flags[s, k] & _NOTHING:
                found |= np.uint8(2)
            if flags[s, k] & _ANEW:
                found |= np.uint8(8)
            bits[f, k] = found
    out = np.empty((ticks, count, _OUT))
    steps.follow(feet.settings, q, position, bits, feet.memory, out)
    return out


@step()
def _speed(value: Float) -> float:
    vx, vy, vz = value[_V], value[_V + 1], value[_V + 2]
    return math.sqrt(vx * vx + vy * vy + vz * vz)


@step()
def _flags_of(foot: int) -> float:
    """Say in the words of frames what is known of a foot, see `flags_of`."""
    found = 0
    if foot & _UNKNOWN:
        found |= _INVALID
    if foot & _BRIDGED:
        found |= _WAS_BRIDGED
    if foot & _LOST:
        found |= _HEADING
    if foot & _CLIPPED:
        found |= _SATURATED
    return float(found)


@step()
def _write_level(sigma: Float, out: Float) -> None:
    """Write sigmas in the axes of the room, see `level_sigma`."""
    level = math.sqrt(0.5 * (sigma[0] * sigma[0] + sigma[1] * sigma[1]))
    for i in range(3):
        value = sigma[2] if i == 2 else level
        out[i] = value if math.isfinite(value) else np.nan


@step()
def _write_common(
    values: Float, flags: NDArray[np.uint8], stepped: Float, feet: Feet, scalars: int, rows: Float
) -> None:
    """Write stance, speed, stride, flags and sigmas; `scalars` is the first of them in a row."""
    count = len(feet.heels)
    others = (rows.shape[1] - scalars) - (_PER_FOOT + 1 + 3 + 3) * count
    # Behind the scalars of all feet those of the forces, then flags and sigmas; sigmas of further points are unknown.
    points = (scalars - 4 * count) // 3
    force_scalars = others - 3 * (points - count)
    at_flags = scalars + _PER_FOOT * count + force_scalars
    for k in range(rows.shape[0]):
        row = rows[k]
        row[at_flags + 4 * count :] = np.nan
        for f in range(count):
            s = feet.heels[f]
            first = scalars + _PER_FOOT * f
            row[first : first + _PER_FOOT] = np.nan
            row[first + STANCE] = 1.0 if values[s, k, _STANDS] > 0.0 else 0.0
            row[first + SPEED] = _speed(values[s, k])
            row[first + STRIDE_LENGTH], row[first + TOE_OUT] = (
                stepped[k, f, _O_LENGTH],
                stepped[k, f, _O_TOE_OUT],
            )
            foot = int(flags[s, k])
            if force_scalars and not stepped[k, f, _O_LOST] > 0.0:
                # Beside a foot that was never lost it has its place again; each in a world of its own finds none.
                foot &= ~_LOST
            row[at_flags + f] = _flags_of(foot)
            a = at_flags + count + 3 * f
            _write_level(values[s, k, _TURN_SIGMA:_AFTER_SIGMA], row[a : a + 3])
            b = at_flags + 4 * count + 3 * f
            _write_level(values[s, k, _PLACE_SIGMA:_TURN_SIGMA], row[b : b + 3])


@compiled(WRITE_FEET)
def write_feet(values: Float, flags: NDArray[np.uint8], feet: Feet, rows: Float) -> None:
    """Write rows of feet that are each in a world of their own.

    Parameters
    ----------
    values : ndarray, shape (S, K, COLUMNS)
    flags : ndarray of uint8, shape (S, K)
        As `FootTracker.released` returns them.
    rows : ndarray, shape (K, W)
        Output: orientations, points, scalars, flags, sigmas of attitude, sigmas of points.
    """
    count = len(feet.heels)
    stepped = _stepped(values, flags, feet)
    for k in range(rows.shape[0]):
        for f in range(count):
            s = feet.heels[f]
            for i in range(_TURN):
                rows[k, _TURN * f + i] = values[s, k, _Q + i]
            for i in range(3):
                rows[k, _TURN * count + 3 * f + i] = values[s, k, _P + i] + feet.offset_m[f, i]
    _write_common(values, flags, stepped, feet, (_TURN + 3) * count, rows)


@step()
def _felt(
    values: Float, flags: NDArray[np.uint8], stepped: Float, loads: Float, shoes: Shoes, out: Float
) -> Float:
    """Bring the loads into the room; fills `out`, (2, K, shoe.OUT), and returns what `balance_live` finds, (K, OUT)."""
    ticks = values.shape[1]
    q, heel = np.empty((2, 2, ticks, 4)), np.empty((2, ticks, 3))
    course, speed, up = np.empty((2, ticks)), np.empty((2, ticks)), np.empty((2, loads.shape[1]))
    bits, usable = np.empty((2, ticks), dtype=np.uint8), np.empty((2, ticks), dtype=np.uint8)
    for f in range(2):
        for k in range(ticks):
            for cell in range(2):
                for i in range(4):
                    q[f, cell, k, i] = values[2 * f + cell, k, _Q + i]
            for i in range(3):
                heel[f, k, i] = stepped[k, f, _O_PLACE + i]
            course[f, k], speed[f, k] = stepped[k, f, _O_COURSE], _speed(values[2 * f, k])
            bits[f, k] = 1 if values[2 * f, k, _STANDS] > 0.0 else 0
            if (flags[2 * f, k] | flags[2 * f + 1, k]) & _NOTHING:
                bits[f, k] += 2
        for k in range(loads.shape[1]):
            up[f, k] = loads[f, k, _UP[0]] + loads[f, k, _UP[1]]
    corners, zero = np.empty((2, ticks, 8, 2)), np.empty((2, ticks))
    shoe.shoes_live(shoes.settings, loads, q, heel, course, speed, bits, shoes.memory, out, corners, zero)
    for f in range(2):
        for k in range(ticks):
            state = out[f, k, shoe.STATE]
            if state == shoe.MEASURED:
                found = 2 if stepped[k, f, _O_PLACED] > 0.0 else 1
            else:
                found = 1 if state == shoe.UNTARED else 0
            if stepped[k, f, _O_JOINED] > 0.0:
                found += 4
            usable[f, k] = found
    balanced = np.empty((ticks, balance.OUT))
    balance.balance_live(
        shoes.balance_settings,
        out,
        corners,
        usable,
        up,
        zero,
        shoes.balance_memory,
        shoes.x,
        shoes.p,
        balanced,
    )
    return balanced


@compiled(WRITE_SHOES)
def write_shoes(
    values: Float, flags: NDArray[np.uint8], feet: Feet, loads: Float, shoes: Shoes, rows: Float
) -> None:
    """Write rows of two shoes in a room that they share, with their forces; other arguments as `write_feet`.

    Parameters
    ----------
    loads : ndarray, shape (2, K or more, LOADS)
        Of the ticks released and after them.
    """
    stepped = _stepped(values, flags, feet)
    out = np.empty((2, rows.shape[0], shoe.OUT))
    found = _felt(values, flags, stepped, loads, shoes, out)
    points, scalars = 2 * _TURN, 2 * _TURN + 3 * _ROOM_POINTS
    mass, cop, going = points + 3 * _MASS_POINT, points + 3 * _COP_POINT, points + 3 * _GOING_POINT
    pressed_first = points + 3 * _PRESSED
    forces = scalars + 2 * _PER_FOOT
    for k in range(rows.shape[0]):
        row = rows[k]
        shift = (0.0, 0.0)
        if not math.isnan(found[k, _SHIFT]):
            shift = (found[k, _SHIFT], shift[1])
        if not math.isnan(found[k, _SHIFT + 1]):
            shift = (shift[0], found[k, _SHIFT + 1])
        for f in range(2):
            for i in range(4):
                row[_TURN * f + i] = stepped[k, f, _O_Q + i]
                force = i if i < 3 else shoe.STATE
                row[forces + _FORCE_SCALARS * f + i] = out[f, k, force]
            for i in range(3):
                sole = stepped[k, f, _O_PLACE + i] - (shoes.settings[_HEIGHT] if i == 2 else 0.0)
                pressed = out[f, k, shoe.COP + i]
                if f == 1 and i < 2:
                    sole += shift[i]
                    pressed += shift[i]
                row[points + 3 * f + i] = sole
                row[pressed_first + 3 * f + i] = pressed
        for i in range(3):
            row[mass + i] = found[k, _MASS + i]
            row[cop + i] = found[k, _COP + i]
            row[going + i] = found[k, _GOING + i]
        row[forces + 2 * _FORCE_SCALARS] = found[k, _MARGIN]
        row[forces + 2 * _FORCE_SCALARS + 1] = found[k, _CENTRE_SIGMA]
        row[forces + 2 * _FORCE_SCALARS + 2] = found[k, _WEIGHT] / GRAVITY_MPS2
    _write_common(values, flags, stepped, feet, scalars, rows)
