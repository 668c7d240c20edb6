"""Rows of pooled frames as the numbers of binary blocks."""

from typing import Final

import numpy as np
from numba import types
from numpy.typing import NDArray

from estimators.compiling import compiled
from estimators.kernels import VOID, bundle
from estimators.pipelines.pooled import Columns

_F2, _F3 = (types.Array(types.float64, n, "C") for n in (2, 3))
_U2: Final = types.Array(types.uint8, 2, "C")


@compiled(
    VOID(types.int64[:, ::1], bundle(Columns, _F3, _F3, _F2, _F2, _F2, _U2, _U2, _F3), types.float32[::1])
)
def write_blocks(places: NDArray[np.int64], columns: Columns, out: NDArray[np.float32]) -> None:
    """Write ticks of some sessions in the columns of `app.live.blocks.column_names`.

    Parameters
    ----------
    places : ndarray of int64, shape (N, 3)
        First row in `columns`, rows, and where in `out` the block's numbers begin.
    columns : Columns
    out : ndarray of float32
    """
    angles, scalars = columns.angle_rad.shape[1], columns.scalar.shape[1]
    points, segments = columns.point_room_m.shape[1], columns.segment_flags.shape[1]
    for n in range(places.shape[0]):
        at = places[n, 2]
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


__all__ = ["write_blocks"]
