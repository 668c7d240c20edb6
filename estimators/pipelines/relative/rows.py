"""Records and rows of pooled relative-pose sessions: what a session is, what all share, where a step works."""

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from estimators.kernels import record
from estimators.magnetic.relative import layout as at
from estimators.orientation._screen import MEMORY as SCREEN
from estimators.orientation.vqf._steps import STATE
from estimators.pipelines.relative import kernel
from estimators.recording import Float

LEVEL_STATES: Final = 3
"""Of the filter that levels the source: its gyroscope's offset."""

PROGRESS: Final = record(
    [
        ("stretch", "i8"),
        # The filter that is at work on it, and the ticks it has taken; below zero before the first filter.
        ("filter", "i8"),
        ("ticks", "i8"),
    ]
)
"""How far a step has come: it is left where a burst has to be solved, and goes on behind it."""
BEGIN: Final = -1


class RelativeRows(NamedTuple):
    """Rows of N sessions of one source and F sensors; arrays by sensor have N * F rows, a session's in one piece.

    Attributes
    ----------
    level : ndarray of the level filter's STATE, shape (N,)
    level_covariance : ndarray, shape (N, 3, 3)
    screen : ndarray, shape (N, SCREEN)
        What judging the next sample of the source depends on.
    loops : ndarray, shape (N, L, 10)
        Of the coils.
    settings, nominal, memory : ndarray, shape (N * F, ...)
        Of the filters, see `estimators.magnetic.relative.layout`.
    covariance : ndarray, shape (N * F, ERRORS, ERRORS)
    counters : ndarray of int64, shape (N * F, COUNTERS)
    ring : ndarray, shape (N * F, RING, RING_COLUMNS)
    account : ndarray, shape (N, 3)
        What the source has used, with `last_angle` and `turns` as in `kernel.Running`.
    last_angle : ndarray, shape (N, A)
    turns : ndarray of int64, shape (N, A)
    is_stopped : ndarray of uint8, shape (N,)
        Nothing more is taken of a session in this step.
    """

    level: NDArray[np.void]
    level_covariance: Float
    screen: Float
    loops: Float
    settings: Float
    nominal: Float
    covariance: Float
    memory: Float
    counters: NDArray[np.int64]
    ring: Float
    account: Float
    last_angle: Float
    turns: NDArray[np.int64]
    is_stopped: NDArray[np.uint8]


class RelativeTables(NamedTuple):
    """What all sessions of a pool share.

    Attributes
    ----------
    channels : int
        Two, or three with a magnetometer.
    width : int
        Numbers a sample beside motion.
    coil_column : int
        Of the coil state among them; below zero without.
    source : int
        Row of the module that carries the source.
    sensors : int
        Modules beside it.
    coils : int
        Of a source.
    height_m : float
        At which the source is drawn.
    level_settings : ndarray of the level filter's SETTINGS, shape (1,)
    """

    channels: int
    width: int
    coil_column: int
    source: int
    sensors: int
    coils: int
    height_m: float
    step_s: float
    level_settings: NDArray[np.void]


class RelativeWork(NamedTuple):
    """Room for one stretch.

    Attributes
    ----------
    samples, outs : ndarray, shape (values,)
        What the filters take and put out, (F, K, SAMPLE) and (F, K, OUTPUT).
    wrong : ndarray of bool, shape (ticks,)
        Where the coils do what the source cannot.
    wild, quality, flags : ndarray of uint8, shape (ticks,)
        Of the source: what was judged, quality after that, flags of its orientation.
    q, bias, sigma : ndarray, shape (values,)
        Of its orientation, (K, 4) and (K, 3).
    """

    samples: Float
    outs: Float
    wrong: NDArray[np.bool_]
    wild: NDArray[np.uint8]
    quality: NDArray[np.uint8]
    flags: NDArray[np.uint8]
    q: Float
    bias: Float
    sigma: Float


def relative_rows(sessions: int, sensors: int, loops: tuple[int, ...], angles: int) -> RelativeRows:
    """Return rows for so many sessions; memory is used only where a session is."""
    both = sessions * sensors
    return RelativeRows(
        np.zeros(sessions, dtype=STATE),
        np.zeros((sessions, LEVEL_STATES, LEVEL_STATES)),
        np.zeros((sessions, SCREEN)),
        np.zeros((sessions, *loops)),
        np.zeros((both, at.SETTINGS)),
        np.zeros((both, at.NOMINAL)),
        np.zeros((both, at.ERRORS, at.ERRORS)),
        np.zeros((both, at.MEMORY)),
        np.zeros((both, at.COUNTERS), dtype=np.int64),
        np.zeros((both, at.RING, at.RING_COLUMNS)),
        np.zeros((sessions, kernel.ACCOUNT)),
        np.zeros((sessions, angles)),
        np.zeros((sessions, angles), dtype=np.int64),
        np.zeros(sessions, dtype=np.uint8),
    )


def relative_work(sensors: int, most_ticks: int) -> RelativeWork:
    """Return room for a stretch of up to so many ticks."""
    samples = sensors * most_ticks
    return RelativeWork(
        samples=np.empty(at.SAMPLE * samples),
        outs=np.empty(at.OUTPUT * samples),
        wrong=np.empty(most_ticks, dtype=np.bool_),
        wild=np.empty(most_ticks, dtype=np.uint8),
        quality=np.empty(most_ticks, dtype=np.uint8),
        flags=np.empty(most_ticks, dtype=np.uint8),
        q=np.empty(4 * most_ticks),
        bias=np.empty(3 * most_ticks),
        sigma=np.empty(3 * most_ticks),
    )
