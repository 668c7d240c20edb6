"""Records of the compiled guidance: settings, memory, the prepared template, one chunk of ticks."""

from dataclasses import asdict
from typing import Any, Final, NamedTuple

import numpy as np
from numba import types
from numpy.typing import NDArray

from estimators.guidance._parameters import GuidanceParameters
from estimators.kernels import bundle, fields_of, record, rows
from estimators.recording import Float

SETTINGS: Final = record(
    fields_of(asdict(GuidanceParameters())),
    [
        ("tick_s", "f8"),
        ("update_s", "f8"),
        ("stride", "i8"),
        ("rest_ticks", "i8"),
        ("pace", "f8"),  # r0 = 1 / T
        ("main", "i8"),
        ("valid_share", "f8"),
    ],
)
"""Constants of one exercise."""

STATE: Final = record(
    [
        ("tick", "i8"),
        ("rested", "i8"),  # ticks of prompted rest seen
        ("rest_v", "f8"),  # V_rest of (5)
        ("rest_v_count", "i8"),
        ("pace", "f8"),  # at which this patient moves
        ("v", "f8"),  # V at the start posture now
        ("still_s", "f8"),  # how long still near the start posture without being at rest
        ("p_rest", "f8"),
        ("p_wrong", "f8"),
        ("p_stiff", "f8"),  # share of the movement that is one with a joint that does not come along
        ("phase", "f8"),
        ("rate", "f8"),  # at which the phase goes on, 1/s
        ("sigma", "f8"),
        ("size", "f8"),
        ("finished", "i8"),
        ("in_attempt", "i8"),
        ("attempt", "i8"),
        ("attempt_tick", "i8"),
        ("updates", "i8"),
        ("wrong_sum", "f8"),
        ("stiff_sum", "f8"),
        ("was_late", "i8"),
        ("was_wrong", "i8"),
    ]
)
"""What goes on from tick to tick, beside the arrays of `Memory`."""

REPETITION: Final = record(
    [
        ("tick", "i8"),
        ("kind", "i8"),
        ("attempt", "i8"),
        ("start_tick", "i8"),
        ("wrong", "f8"),
        ("stiff", "f8"),
        ("excursion", "f8"),
        ("size", "f8"),
    ]
)
"""A finished attempt. `kind` is VALID, PARTIAL, WRONG or IGNORED."""
VALID, PARTIAL, WRONG, IGNORED = range(4)

PHASE, SIGMA, REST, ASTRAY, SIZE, OUT = range(6)
"""Columns of what is written each tick."""


class Model(NamedTuple):
    """The template as the filter reads it: B phases, C channels, of them F that steer, A sizes, K targets, P paces.

    Attributes
    ----------
    offset : ndarray, shape (F, B)
        mu of the steering channels, by channel so that sums over phases run along memory.
    slope : ndarray, shape (P, F, B)
        mu', as late as the slopes that are held against it: of somebody at half the template's pace, at its pace, ...
    variance : ndarray, shape (F, B)
        (b / 1.64)^2 + (0.05 rho)^2 of equation (1).
    weight : ndarray, shape (F,)
    steering : ndarray of int64, shape (F,)
        Columns of the steering channels among all.
    excursion : ndarray, shape (F,)
        Largest |mu| of each.
    whole : ndarray, shape (B, C)
        mu of all channels, NaN where the template has none.
    turns : ndarray of uint8, shape (C,)
        1 for angles, which are known up to whole turns.
    absolute : ndarray of uint8, shape (C,)
        1 where the start posture does not count: angles without meaning in it.
    sizes : ndarray, shape (A,)
    target : ndarray, shape (K, 2)
        Phase of an extreme of the main channel and its offset there.
    """

    offset: Float
    slope: Float
    variance: Float
    weight: Float
    steering: NDArray[np.int64]
    excursion: Float
    whole: Float
    turns: NDArray[np.uint8]
    absolute: NDArray[np.uint8]
    sizes: Float
    target: Float


class Memory(NamedTuple):
    """Arrays that go on from tick to tick.

    Attributes
    ----------
    mass : ndarray, shape (A, B)
        P(phase, size).
    start : ndarray, shape (C,)
        y0.
    last : ndarray, shape (C,)
        Last known value of each channel, for whole turns.
    window : ndarray, shape (W, C)
        Ring of the last values, for the slope.
    rest : ndarray, shape (R, C)
        Values of the prompted rest.
    size_mean : ndarray, shape (A,)
        Equation (7): over finished repetitions.
    reached : ndarray, shape (F,)
        Largest |y - y0| of the attempt.
    quotient : ndarray, shape (K,)
        q of the attempt, equation (9).
    """

    mass: Float
    start: Float
    last: Float
    window: Float
    rest: Float
    size_mean: Float
    reached: Float
    quotient: Float


class Work(NamedTuple):
    """Room for intermediate values: nothing in it outlives an update.

    Attributes
    ----------
    sums : ndarray, shape (6, B)
        Sums over channels, once a phase, as (4) is quadratic in the size.
    moved : ndarray, shape (A, B)
    pace, strange : ndarray, shape (A, B)
        Equation (2), and how strange the slopes seen are at that pace.
    line : ndarray, shape (5, B)
    slope : ndarray, shape (F, B)
        mu' at the patient's pace.
    y, v, sigma : ndarray, shape (C,)
    prior : ndarray, shape (A,)
    sorted : ndarray, shape (R,)
    """

    sums: Float
    moved: Float
    pace: Float
    strange: Float
    line: Float
    slope: Float
    y: Float
    v: Float
    sigma: Float
    prior: Float
    sorted: Float


class Out(NamedTuple):
    """What one chunk gives.

    Attributes
    ----------
    follow : ndarray, shape (N, OUT)
    deviation, deviation_sigma : ndarray, shape (N, C)
        d of (10) and its standard deviation.
    repetitions : record array of `REPETITION`
    quotients : ndarray, shape (len(repetitions), K)
    counts : ndarray of int64, shape (1,)
        Repetitions written.
    """

    follow: Float
    deviation: Float
    deviation_sigma: Float
    repetitions: NDArray[Any]
    quotients: Float
    counts: NDArray[np.int64]


def _types() -> tuple[Any, ...]:
    row, table, tables = types.float64[::1], types.float64[:, ::1], types.float64[:, :, ::1]
    whole, small = types.int64[::1], types.uint8[::1]
    model = bundle(Model, table, tables, table, row, whole, row, table, small, small, row, table)
    memory = bundle(Memory, table, row, row, table, table, row, row, row)
    work = bundle(Work, table, table, table, table, table, table, row, row, row, row, row)
    out = bundle(Out, table, table, table, rows(REPETITION), table, whole)
    return model, memory, work, out


MODEL, MEMORY, WORK, OUTPUT = _types()
"""Types of the bundles for the signature of the kernel."""
