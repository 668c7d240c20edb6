"""The state of the live foot filter for S feet: rows, feet leading, read and written by Python and compiled code."""

from collections.abc import Callable
from typing import Any, Final, NamedTuple

import numpy as np
from numba import types
from numpy.typing import NDArray

from estimators.conventions import GRAVITY_MPS2
from estimators.gait._stance import Windows
from estimators.gait.foot import layout as at
from estimators.gait.foot import lost_places
from estimators.kernels import bundle, record, rows
from estimators.recording import Float

BRIDGED, MISSING, CLIPPED, FIELD = 1, 2, 4, 8
"""What there is to say of a sample: how it came about, and whether a magnetic field came with it; the bits above are
those of the axes that were cut off (`CutOffAxes`)."""
PIECE_TICKS: Final = 64
"""Most ticks that are taken at once."""
_RECORD_BLOCKS: Final = 6
"""Blocks of filter records beyond the lag, so that they are moved rarely."""

FOOT: Final = record(
    [
        # The first sample in the buffer: its place and its tick; the tick that comes next, and how many T are known.
        ("place", "i8"),
        ("origin", "i8"),
        ("stop", "i8"),
        ("known", "i8"),
        # The first measured tick, -1 before there is one; behind the last that is not measured as it stands.
        ("first", "i8"),
        ("flawed_stop", "i8"),
        # Judged ticks from the first that is not released: their place and how many.
        ("judged_place", "i8"),
        ("judged", "i8"),
        # Ticks filtered and released; the record of the first that is not released.
        ("filtered", "i8"),
        ("released", "i8"),
        ("base", "i8"),
        ("last_stance", "i8"),
        # Ticks missing in a row before the first that is not filtered yet; up to `wary` only a foot that surely stands
        # is believed to.
        ("gap", "i8"),
        ("wary", "i8"),
        ("marks", "i8"),
    ]
)
"""Where one foot stands; ticks are counted from the start of the stream."""
MARK: Final = record([("start", "i8"), ("gap", "i8"), ("wary", "i8")])


class FootRows(NamedTuple):
    """Rows of S feet.

    Attributes
    ----------
    foot : ndarray of FOOT, shape (S,)
    gyroscope, force, field : ndarray, shape (S, N, 3)
        Buffered samples, from a few before the first that is still judged on; zeros where there is no field.
    kind : ndarray of uint8, shape (S, N)
    statistic : ndarray, shape (S, N)
        T of the first of them.
    inputs : ndarray, shape (S, 3, J)
        Of judged ticks: standard deviation of the contact point's velocity, T, and noise density squared of force.
    bits : ndarray of uint8, shape (S, J)
        What is measured.
    rate_variance : ndarray, shape (S, J, 3)
        Noise density squared of turning.
    x, p, memory : ndarray, shapes (S, STATE), (S, ERRORS, ERRORS), (S, MEMORY)
        Of the filter.
    mark : ndarray of MARK, shape (S, M)
        Starts of blocks that are not released: from there the records are made again after a restart.
    mark_x, mark_p, mark_memory : ndarray, shapes (S, M, ...)
        The filter there.
    prior, prior_p, steps, row_count, measured, gains, ratios, posterior, spread : ndarray, shapes (S, R, ...)
        As `Trace`.
    last_good : ndarray, shape (S, 3)
        Newest specific force that was measured.
    largest : ndarray, shape (S, 2)
        As `CutOffAxes`.
    lost : ndarray, shape (S, lost_places.MEMORY)
        As `LostPlace`.
    """

    foot: NDArray[np.void]
    gyroscope: Float
    force: Float
    field: Float
    kind: NDArray[np.uint8]
    statistic: Float
    inputs: Float
    bits: NDArray[np.uint8]
    rate_variance: Float
    x: Float
    p: Float
    memory: Float
    mark: NDArray[np.void]
    mark_x: Float
    mark_p: Float
    mark_memory: Float
    prior: Float
    prior_p: Float
    steps: Float
    row_count: NDArray[np.int64]
    measured: Float
    gains: Float
    ratios: Float
    posterior: Float
    spread: Float
    last_good: Float
    largest: Float
    lost: Float


class Sizes(NamedTuple):
    """Ticks of a foot's windows and blocks.

    Attributes
    ----------
    half, stride, before, after, alone, ahead, back : int
        As `Windows`.
    block, lag : int
        Released at once; smoothed back over.
    """

    half: int
    stride: int
    before: int
    after: int
    alone: int
    ahead: int
    back: int
    block: int
    lag: int


def sizes_of(windows: Windows, block: int, lag: int) -> Sizes:
    """Return the ticks that compiled code reads."""
    w = windows
    return Sizes(w.half, w.stride, w.before, w.after, w.alone, w.ahead, w.back, block, lag)


def foot_rows(feet: int, sizes: Sizes, zeros: Callable[..., NDArray[Any]] = np.zeros) -> FootRows:
    """Return rows before the first sample.

    Parameters
    ----------
    zeros : callable(shape, dtype=...), optional
        Makes the arrays.
    """
    waiting = sizes.ahead + sizes.lag + 2 * sizes.block + PIECE_TICKS
    samples = 2 * (sizes.back + waiting) + PIECE_TICKS
    judged, records = 2 * waiting, sizes.lag + _RECORD_BLOCKS * sizes.block
    marks = waiting // sizes.block + 4
    foot = np.zeros(feet, dtype=FOOT)
    foot["first"] = foot["last_stance"] = -1
    found: dict[str, Any] = {
        "foot": foot,
        "kind": zeros((feet, samples), dtype=np.uint8),
        "bits": zeros((feet, judged), dtype=np.uint8),
        "mark": zeros((feet, marks), dtype=MARK),
        "row_count": zeros((feet, records), dtype=np.int64),
    }
    shapes = {
        "gyroscope": (samples, 3),
        "force": (samples, 3),
        "field": (samples, 3),
        "statistic": (samples,),
        "inputs": (3, judged),
        "rate_variance": (judged, 3),
        "x": (at.STATE,),
        "p": (at.ERRORS, at.ERRORS),
        "memory": (at.MEMORY,),
        "mark_x": (marks, at.STATE),
        "mark_p": (marks, at.ERRORS, at.ERRORS),
        "mark_memory": (marks, at.MEMORY),
        "prior": (records, at.STATE),
        "prior_p": (records, at.ERRORS, at.ERRORS),
        "steps": (records, at.STEP),
        "measured": (records, at.MOST_ROWS, at.ERRORS),
        "gains": (records, at.MOST_ROWS, at.ERRORS),
        "ratios": (records, at.MOST_ROWS),
        "posterior": (records, at.STATE),
        "spread": (records, 6),
        "last_good": (3,),
        "largest": (2,),
        "lost": (lost_places.MEMORY,),
    }
    made = found | {name: zeros((feet, *shape)) for name, shape in shapes.items()}
    made["last_good"][:, 2] = GRAVITY_MPS2
    return FootRows(**made)


_F2, _F3, _F4 = (types.Array(types.float64, n, "C") for n in (2, 3, 4))
_U2 = types.uint8[:, ::1]
_MARKS = types.Array(rows(MARK).dtype, 2, "C")
FOOT_ROWS: Final = bundle(
    FootRows,
    *(rows(FOOT), _F3, _F3, _F3, _U2, _F2, _F3, _U2, _F3, _F2, _F3, _F2, _MARKS, _F3, _F4, _F3),
    *(_F3, _F4, _F3, types.int64[:, ::1], _F4, _F4, _F3, _F3, _F3, _F2, _F2, _F2),
)
SIZES: Final = types.NamedUniTuple(types.int64, len(Sizes._fields), Sizes)
