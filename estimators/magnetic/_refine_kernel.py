"""Least-squares pose from pulses of exact coils, compiled (Levenberg-Marquardt)."""

import math

import numpy as np
from numpy.typing import NDArray

from estimators._kernels import exponential, kernel, multiply, normalized, rotate_back, step
from estimators.kernels.matrices import cholesky, solve
from estimators.magnetic._loop_kernel import coil_field
from estimators.recording import Float

_PASSES = 60
_DONE_M = 1e-10
"""A step below a tenth of a nanometre and of a nanoradian changes nothing that is measured."""
_Q, _POSE = 3, 7
"""A pose is a position and, from there, a quaternion; a change of one is a way and a rotation vector."""
_TURN = 3


@step(
    "float64(float64[:, ::1], int64[::1], float64[::1], float64[:, ::1], float64[:, ::1], float64[:, ::1],"
    "float64[::1], float64[::1], float64[:, ::1], float64[::1])"
)
def normal_equations(
    loops: Float,
    coil: NDArray[np.int64],
    current: Float,
    offset: Float,
    turn: Float,
    pulses: Float,
    weight: Float,
    pose: Float,
    matrix: Float,
    right: Float,
) -> float:
    """Return the weighted sum of squares at a pose; fill J^T W J and J^T W (predicted - measured)."""
    cost = 0.0
    for i in range(6):
        right[i] = 0.0
        for j in range(6):
            matrix[i, j] = 0.0
    row = np.empty((3, 6))
    for k in range(pulses.shape[0]):
        bx, by, bz, gxx, gxy, gxz, gyy, gyz, gzz = coil_field(
            loops,
            float(coil[k]),
            current[k],
            pose[0] + offset[k, 0],
            pose[1] + offset[k, 1],
            pose[2] + offset[k, 2],
        )
        t = turn[k]
        w, x, y, z = multiply(pose[_Q], pose[_Q + 1], pose[_Q + 2], pose[_Q + 3], t[0], t[1], t[2], t[3])
        b = rotate_back(w, x, y, z, bx, by, bz)
        # The rotation error acts before the known turn: its lever is the field in the axes before it.
        s = rotate_back(pose[_Q], pose[_Q + 1], pose[_Q + 2], pose[_Q + 3], bx, by, bz)
        columns = (
            rotate_back(w, x, y, z, gxx, gxy, gxz),
            rotate_back(w, x, y, z, gxy, gyy, gyz),
            rotate_back(w, x, y, z, gxz, gyz, gzz),
            rotate_back(t[0], t[1], t[2], t[3], 0.0, s[2], -s[1]),
            rotate_back(t[0], t[1], t[2], t[3], -s[2], 0.0, s[0]),
            rotate_back(t[0], t[1], t[2], t[3], s[1], -s[0], 0.0),
        )
        for c in range(6):
            column = columns[c]
            row[0, c], row[1, c], row[2, c] = column[0], column[1], column[2]
        for a in range(3):
            residual = b[a] - pulses[k, a]
            cost += weight[k] * residual * residual
            for i in range(6):
                right[i] += weight[k] * row[a, i] * residual
                for j in range(6):
                    matrix[i, j] += weight[k] * row[a, i] * row[a, j]
    return cost


@step("void(float64[::1], float64[::1], float64[::1])")
def _move(pose: Float, change: Float, trial: Float) -> None:
    """Write the pose after a step, by no more than 0.2 m."""
    length = math.sqrt(change[0] * change[0] + change[1] * change[1] + change[2] * change[2])
    shrink = min(1.0, 0.2 / length) if length > 0.0 else 1.0
    for i in range(3):
        trial[i] = pose[i] - shrink * change[i]
    turned = exponential(-shrink * change[_TURN], -shrink * change[_TURN + 1], -shrink * change[_TURN + 2])
    q = multiply(
        pose[_Q], pose[_Q + 1], pose[_Q + 2], pose[_Q + 3], turned[0], turned[1], turned[2], turned[3]
    )
    q = normalized(q[0], q[1], q[2], q[3])
    trial[_Q], trial[_Q + 1], trial[_Q + 2], trial[_Q + 3] = q


@kernel(
    "float64(float64[:, ::1], int64[::1], float64[::1], float64[:, ::1], float64[:, ::1], float64[:, ::1],"
    "float64[::1], float64, float64[::1], float64[:, ::1])"
)
def refine(
    loops: Float,
    coil: NDArray[np.int64],
    current: Float,
    offset: Float,
    turn: Float,
    pulses: Float,
    weight: Float,
    nearest_m: float,
    pose: Float,
    information: Float,
) -> float:
    """Move a pose (position, quaternion) to the nearest minimum; fill its information matrix, return the cost.

    Steps into the sphere of `nearest_m` about the origin are refused: there the field diverges at the wires.
    """
    matrix, right = np.empty((6, 6)), np.empty(6)
    trial_matrix, trial_right = np.empty((6, 6)), np.empty(6)
    factor, step, trial = np.empty((6, 6)), np.empty(6), np.empty(_POSE)
    cost = normal_equations(loops, coil, current, offset, turn, pulses, weight, pose, matrix, right)
    damping = 1e-3
    for _ in range(_PASSES):
        for i in range(6):
            step[i] = right[i]
            for j in range(6):
                factor[i, j] = matrix[i, j]
            factor[i, i] *= 1.0 + damping
        if not cholesky(factor):
            damping = max(damping * 10.0, 1e-6)
            if damping > 1e12:
                break
            continue
        solve(factor, step)
        _move(pose, step, trial)
        inside = trial[0] * trial[0] + trial[1] * trial[1] + trial[2] * trial[2] < nearest_m * nearest_m
        after = (
            math.inf
            if inside
            else normal_equations(
                loops, coil, current, offset, turn, pulses, weight, trial, trial_matrix, trial_right
            )
        )
        if after <= cost:
            size = 0.0
            for i in range(6):
                size = max(size, abs(step[i]))
            for i in range(_POSE):
                pose[i] = trial[i]
            for i in range(6):
                right[i] = trial_right[i]
                for j in range(6):
                    matrix[i, j] = trial_matrix[i, j]
            cost = after
            damping = max(damping * 0.1, 1e-12)
            if size < _DONE_M:
                break
        else:
            damping *= 10.0
            if damping > 1e12:
                break
    for i in range(6):
        for j in range(6):
            information[i, j] = matrix[i, j]
    return cost
