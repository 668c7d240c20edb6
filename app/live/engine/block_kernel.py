"""Rows of pooled frames as the numbers of binary blocks."""

import numpy as np
from numba import types
from numpy.typing import NDArray

from estimators.compiling import compiled
from estimators.kernels import VOID
from estimators.pipelines.pooled import COLUMNS, Columns


@compiled(
    VOID(
        types.int64[:, ::1],
        types.uint32[:, ::1],
        COLUMNS,
        types.uint32[::1],
        types.float32[::1],
    )
)
def write_blocks(
    places: NDArray[np.int64],
    heads: NDArray[np.uint32],
    columns: Columns,
    words: NDArray[np.uint32],
    out: NDArray[np.float32],
) -> None:
    """Write ticks of some sessions in the columns of `app.live.blocks.column_names`, each block behind its head.

    Parameters
    ----------
    places : ndarray of int64, shape (N, 3)
        First row in `columns`, rows, and where in `out` the block begins.
    heads : ndarray of uint32, shape (N, H)
    words, out : ndarray of uint32 and float32
        One memory, seen in two ways.
    """
    angles, scalars = columns.angle_rad.shape[1], columns.scalar.shape[1]
    points, segments = columns.point_room_m.shape[1], columns.segment_flags.shape[1]
    for n in range(places.shape[0]):
        at = places[n, 2]
        for h in range(heads.shape[1]):
            words[at + h] = heads[n, h]
        at += heads.shape[1]
        for k in range(places[n, 0], places[n, 0] + places[n, 1]):
            for a in range(angles):
                out[at + a] = columns.angle_rad[k, a]
                out[at + angles + a] = columns.angle_sigma_rad[k, a]
            at += 2 * angles
            for c in range(scalars):
                out[at + c] = columns.scalar[k, c]
            at += scalars
            for p in range(points):
                for i in range(3):
                    out[at + 3 * p + i] = columns.point_room_m[k, p, i]
            at += 3 * points
            for s in range(segments):
                out[at + s] = columns.segment_flags[k, s]
            at += segments
            for a in range(angles):
                out[at + a] = columns.angle_flags[k, a]
            at += angles
