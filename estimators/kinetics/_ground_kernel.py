"""Loads of two cells brought into the room, compiled: a live chunk has few samples and many small sums."""

import numpy as np

from estimators._kernels import kernel, rotate
from estimators.recording import Float

_HEEL, _FOREFOOT, _BOTH = 0, 1, 2


@kernel(
    "void(float64[:, :, ::1], float64[:, :, ::1], float64[:, :, ::1], float64[:, :, ::1], float64[::1],"
    " float64, float64[:, :, ::1], float64[:, :, ::1], float64[:, :, ::1], float64[::1])"
)
def reactions(
    q_room_cell: Float,
    position_m: Float,
    cell_force_n: Float,
    cell_moment_nm: Float,
    floor_m: Float,
    least_n: float,
    force_n: Float,
    moment_nm: Float,
    cop_m: Float,
    free_moment_nm: Float,
) -> None:
    """Write forces, moments about the origin and pressure centres of heel, forefoot and both.

    Parameters
    ----------
    q_room_cell : ndarray, shape (2, N, 4)
        Heel and forefoot cell.
    position_m, cell_force_n, cell_moment_nm : ndarray, shape (2, N, 3)
        Centres of the cells in the room; loads about them in the cells' axes.
    floor_m : ndarray, shape (N,)
    least_n : float
        At or below this vertical force there is no pressure centre.
    force_n, moment_nm, cop_m : ndarray, shape (3, N, 3)
        Output in the room: heel, forefoot, both.
    free_moment_nm : ndarray, shape (N,)
        Output, of both.
    """
    for k in range(floor_m.shape[0]):
        for cell in range(2):
            q, p = q_room_cell[cell, k], position_m[cell, k]
            f, m = cell_force_n[cell, k], cell_moment_nm[cell, k]
            fx, fy, fz = rotate(q[0], q[1], q[2], q[3], f[0], f[1], f[2])
            mx, my, mz = rotate(q[0], q[1], q[2], q[3], m[0], m[1], m[2])
            force_n[cell, k, 0], force_n[cell, k, 1], force_n[cell, k, 2] = fx, fy, fz
            # M = R M_S + p x (R F_S)
            moment_nm[cell, k, 0] = mx + (p[1] * fz - p[2] * fy)
            moment_nm[cell, k, 1] = my + (p[2] * fx - p[0] * fz)
            moment_nm[cell, k, 2] = mz + (p[0] * fy - p[1] * fx)
        for i in range(3):
            force_n[_BOTH, k, i] = force_n[_HEEL, k, i] + force_n[_FOREFOOT, k, i]
            moment_nm[_BOTH, k, i] = moment_nm[_HEEL, k, i] + moment_nm[_FOREFOOT, k, i]
        free_moment_nm[k] = np.nan
        for part in range(3):
            f, m = force_n[part, k], moment_nm[part, k]
            if f[2] > least_n:
                x = (floor_m[k] * f[0] - m[1]) / f[2]
                y = (m[0] + floor_m[k] * f[1]) / f[2]
                cop_m[part, k, 0], cop_m[part, k, 1], cop_m[part, k, 2] = x, y, floor_m[k]
                if part == _BOTH:
                    free_moment_nm[k] = m[2] - (x * f[1] - y * f[0])
            else:
                cop_m[part, k, :] = np.nan
