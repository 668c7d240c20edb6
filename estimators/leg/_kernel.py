"""The compiled live path of the leg: segment orientations of a few ticks to angles, sigmas and flags.

Every formula stands a second time, in numpy, in `_joint_angles`; the tests hold the two against each other.
"""

import math
from typing import NamedTuple

import numpy as np
from numba import types
from numpy.typing import NDArray

from estimators.arm._angle_kernel import SINGULAR_MARGIN_RAD, cardan, first_axes, relative_of, sigmas
from estimators.compiling import compiled
from estimators.kernels import VOID, bundle

Float = NDArray[np.float64]
Flags = NDArray[np.uint8]

_SINGULAR = np.uint8(128)  # OrientationFlag.SINGULAR


class LegTable(NamedTuple):
    """Which joints the worn sensors show, J of them.

    Attributes
    ----------
    segment : ndarray of int64, shape (J, 2)
        Columns of parent and child.
    is_left : ndarray of uint8, shape (J,)
    sign : ndarray, shape (J, 2)
        Of the first two angles.
    """

    segment: NDArray[np.int64]
    is_left: Flags
    sign: Float


_ROW, _TABLE, _CUBE = types.uint8[::1], types.float64[:, ::1], types.float64[:, :, ::1]
_BYTES = types.uint8[:, ::1]
LEG_TABLE = bundle(LegTable, types.int64[:, ::1], _ROW, _TABLE)


@compiled(VOID(_CUBE, _CUBE, _BYTES, LEG_TABLE, _TABLE, _TABLE, _BYTES))
def leg_kernel(
    q_room: Float,
    sigma_room_rad: Float,
    flags: Flags,
    table: LegTable,
    angle_rad: Float,
    angle_sigma_rad: Float,
    angle_flags: Flags,
) -> None:
    """Fill the last 3 J columns of the angles for every tick; q, sigma and flags are those of the segments."""
    relative, found, one_sigma = np.empty(4), np.empty(3), np.empty(3)
    matrix, axes, variance = np.empty((3, 3)), np.empty((3, 3)), np.empty(3)
    joints = table.segment.shape[0]
    first = angle_rad.shape[1] - 3 * joints
    for k in range(q_room.shape[0]):
        for j in range(joints):
            parent, child = table.segment[j, 0], table.segment[j, 1]
            is_left = table.is_left[j] != 0
            relative_of(q_room[k, parent], q_room[k, child], is_left, relative)
            forward, across, turn = cardan(relative)
            found[0], found[1], found[2] = table.sign[j, 0] * forward, table.sign[j, 1] * across, turn
            for i in range(3):
                variance[i] = sigma_room_rad[k, parent, i] ** 2 + sigma_room_rad[k, child, i] ** 2
            first_axes(q_room[k, parent], -forward, False, is_left, matrix, axes)
            sigmas(axes, variance, across, False, one_sigma)
            flag = flags[k, parent] | flags[k, child]
            is_singular = 0.5 * math.pi - abs(across) < SINGULAR_MARGIN_RAD
            for i in range(3):
                angle_rad[k, first + 3 * j + i] = found[i]
                angle_sigma_rad[k, first + 3 * j + i] = one_sigma[i]
                angle_flags[k, first + 3 * j + i] = flag | _SINGULAR if is_singular and i != 1 else flag
