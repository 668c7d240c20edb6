"""Sessions of one kind in pooled rows: what such a pool offers, and the items that its compiled step takes.

A pool holds the states of some sessions with equal sensors and settings, sessions leading. A pipeline that joins it
goes on over views of its rows: whichever way takes the next ticks, the pooled step or `Pipeline.step`, finds what the
other left. A kind has a pool when it has a compiled step; one without runs through `Pipeline.step` alone.
"""

from typing import Final, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from estimators.kernels import record
from estimators.pipelines._contract import FrameLayout, Frames, Pipeline
from estimators.recording import Float

STRETCH: Final = record(
    [
        ("slot", "i8"),
        ("first_tick", "i8"),
        # None of this session: nothing is done, nothing is written.
        ("ticks", "i8"),
        # First value in the signals, first quality, first row in what is written.
        ("signals_at", "i8"),
        ("quality_at", "i8"),
        ("tick_at", "i8"),
    ]
)
"""Consecutive ticks of one session, the next that its pipeline has not seen."""


class Columns(NamedTuple):
    """What a pooled step writes, a row a tick; columns are those of the layout.

    Attributes
    ----------
    q_room_segment : ndarray, shape (T, G, 4)
    point_room_m : ndarray, shape (T, P, 3)
    angle_rad, angle_sigma_rad : ndarray, shape (T, A)
    scalar : ndarray, shape (T, C)
    segment_flags : ndarray of uint8, shape (T, G)
    angle_flags : ndarray of uint8, shape (T, A)
    segment_sigma_rad : ndarray, shape (T, G, 3)
    """

    q_room_segment: Float
    point_room_m: Float
    angle_rad: Float
    angle_sigma_rad: Float
    scalar: Float
    segment_flags: NDArray[np.uint8]
    angle_flags: NDArray[np.uint8]
    segment_sigma_rad: Float


class Pool(Protocol):
    """Rows of some sessions of one kind, and their compiled step."""

    sessions: int
    """How many it has room for."""
    columns: Columns
    """What `step` has written, in the rows that its stretches name."""

    def join(self, slot: int, pipeline: Pipeline) -> bool:
        """Let a pipeline go on over the rows of a slot; False when it cannot, as it stands now.

        Called again after anything but `step` has moved the pipeline on; then it costs a few checks.
        """

    def leave(self, slot: int, pipeline: Pipeline) -> None:
        """Give a pipeline arrays of its own again."""

    def step(
        self, stretches: NDArray[np.void], count: int, signals: Float, quality: NDArray[np.uint8]
    ) -> None:
        """Take the next ticks of some sessions, without the interpreter's lock.

        Parameters
        ----------
        stretches : ndarray of STRETCH
        count : int
            How many of them there are.
        signals : ndarray, shape (values,)
            Gyroscope, accelerometer and, with a magnetometer, field, shape (channels, S, K, 3) each, as in `ImuChunk`.
        quality : ndarray of uint8, shape (samples,)
            Shape (S, K) each.
        """

    def stepped(self, pipeline: Pipeline, next_tick: int) -> None:
        """Carry on what a pipeline knows beside its rows, after `step` has taken its ticks up to `next_tick`."""

    def frames(self, first_tick: int, start: int, stop: int) -> Frames:
        """Return a copy of some rows of `columns` as frames, as they are stored live."""


def columns(ticks: int, layout: FrameLayout) -> Columns:
    """Return room for so many ticks."""
    segments, points, angles = len(layout.segments), len(layout.points), len(layout.angles)
    return Columns(
        np.empty((ticks, segments, 4)),
        np.empty((ticks, points, 3)),
        np.empty((ticks, angles)),
        np.empty((ticks, angles)),
        np.empty((ticks, len(layout.scalars))),
        np.empty((ticks, segments), dtype=np.uint8),
        np.empty((ticks, angles), dtype=np.uint8),
        np.empty((ticks, segments, 3)),
    )


__all__ = ["STRETCH", "Columns", "Pool", "columns"]
