"""Sessions of one kind in pooled rows: what such a pool offers, and the items that its compiled step takes.

A pool holds the states of some sessions with equal sensors and settings, sessions leading. A pipeline that joins it
goes on over views of its rows: whichever way takes the next ticks, the pooled step or `Pipeline.step`, finds what the
other left. A kind has a pool of its own when it has a compiled step for many sessions; others are in a `StepPool`.
"""

from collections.abc import Hashable, Mapping
from typing import Final, NamedTuple, Protocol

import numpy as np
from numba import types
from numpy.typing import NDArray

from estimators.kernels import bundle, record
from estimators.kernels.slots import sparse_zeros
from estimators.pipelines._contract import FrameLayout, Frames, Pipeline
from estimators.recording import Float, ImuChunk

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


_F2, _F3 = (types.Array(types.float64, n, "C") for n in (2, 3))
_U2: Final = types.Array(types.uint8, 2, "C")
COLUMNS: Final = bundle(Columns, _F3, _F3, _F2, _F2, _F2, _U2, _U2, _F3)
"""Their type in compiled code."""


class Pool(Protocol):
    """Rows of some sessions of one kind, and their compiled step.

    Parameters
    ----------
    like : Pipeline
        One of the sessions, which `key` accepts.
    channels : int
        Two, or three with a magnetometer.
    sessions : int
        Room for so many.
    rows : int
        Of `columns`.
    carried : mapping of str to slice
        Fields of `ImuChunk` that come beside motion, and their columns.
    """

    sessions: int
    """How many it has room for."""
    columns: Columns
    """What `step` has written, in the rows that its stretches name."""
    errors: dict[int, tuple[int, Exception]]
    """By slot whose pipeline raised in the last step: the stretch from which on nothing of it was written, and what it
    raised."""

    def __init__(
        self, like: Pipeline, channels: int, sessions: int, rows: int, carried: Mapping[str, slice]
    ) -> None: ...

    @staticmethod
    def key(pipeline: Pipeline) -> Hashable | None:
        """Return what sessions of a pool have in common; None when the pipeline can be in none as it stands."""

    def join(self, slot: int, pipeline: Pipeline) -> bool:
        """Let a pipeline go on over the rows of a slot; False when it cannot, as it stands now.

        Called again after anything but `step` has moved the pipeline on; then it costs a few checks.
        """

    def leave(self, slot: int, pipeline: Pipeline) -> None:
        """Give a pipeline arrays of its own again."""

    def step(
        self,
        stretches: NDArray[np.void],
        count: int,
        signals: Float,
        quality: NDArray[np.uint8],
        carried: Float,
    ) -> None:
        """Take the next ticks of some sessions; one that is compiled does so without the interpreter's lock.

        Parameters
        ----------
        stretches : ndarray of STRETCH
        count : int
            How many of them there are.
        signals : ndarray, shape (values,)
            Gyroscope, accelerometer and, with a magnetometer, field, shape (channels, S, K, 3) each, as in `ImuChunk`.
        quality : ndarray of uint8, shape (samples,)
            Shape (S, K) each.
        carried : ndarray, shape (values,)
            What the sensors sent beside motion, shape (S, K, W) each.
        """

    def stepped(self, pipeline: Pipeline, next_tick: int) -> None:
        """Carry on what a pipeline knows beside its rows, after `step` has taken its ticks up to `next_tick`."""

    def frames(self, first_tick: int, start: int, stop: int) -> Frames:
        """Return a copy of some rows of `columns` as frames, as they are stored live."""


def columns(ticks: int, layout: FrameLayout) -> Columns:
    """Return room for so many ticks."""
    segments, points, angles = len(layout.segments), len(layout.points), len(layout.angles)
    return Columns(
        sparse_zeros((ticks, segments, 4)),
        sparse_zeros((ticks, points, 3)),
        sparse_zeros((ticks, angles)),
        sparse_zeros((ticks, angles)),
        sparse_zeros((ticks, len(layout.scalars))),
        sparse_zeros((ticks, segments), np.uint8),
        sparse_zeros((ticks, angles), np.uint8),
        sparse_zeros((ticks, segments, 3)),
    )


def chunk_of(
    shape: tuple[int, float, int, int, int],
    signals: Float,
    quality: NDArray[np.uint8],
    carried: Float,
    fields: Mapping[str, slice],
) -> ImuChunk:
    """Return a copy of a stretch's samples as a chunk; pipelines may hold on to it, while the room is written again.

    Parameters
    ----------
    shape : tuple
        First tick, seconds of a tick, ticks, sensors and channels.
    signals, quality, carried : ndarray
        As of `Pool.step`, from the first value of the stretch on.
    fields : mapping of str to slice
        Fields of `ImuChunk` that come beside motion, and their columns.
    """
    first_tick, time_step_s, ticks, sensors, channels = shape
    samples, width = sensors * ticks, sum(part.stop - part.start for part in fields.values())
    found = signals[: 3 * channels * samples].reshape(channels, sensors, ticks, 3).copy()
    beside = carried[: width * samples].reshape(sensors, ticks, width)
    return ImuChunk(
        first_tick,
        time_step_s,
        found[0],
        found[1],
        found[2] if channels == 3 else None,
        quality[:samples].reshape(sensors, ticks).copy(),
        **{name: _values(beside[:, :, part]) for name, part in fields.items()},
    )


_SHOWN: Final = (
    "point_room_m",
    "angle_rad",
    "angle_sigma_rad",
    "scalar",
    "segment_flags",
    "angle_flags",
)
"""Columns of the blocks that are shown live."""


class StepPool:
    """Sessions whose pipelines are called one by one; implements `Pool`."""

    def __init__(
        self, like: Pipeline, channels: int, sessions: int, rows: int, carried: Mapping[str, slice]
    ) -> None:
        self.sessions = sessions
        self.columns = columns(rows, like.layout)
        self.errors: dict[int, tuple[int, Exception]] = {}
        self._channels, self._sensors = channels, len(like.setup.placements)
        self._time_step_s = 1.0 / like.setup.rate_hz
        self._carried = dict(carried)
        self._width = sum(part.stop - part.start for part in carried.values())
        self._pipelines: dict[int, Pipeline] = {}
        self._made: dict[int, dict[int, Frames]] = {}
        """Of each slot: frames by their first row, since the rows were last written from the start."""
        self._rows_each = rows // sessions

    @staticmethod
    def key(pipeline: Pipeline) -> Hashable | None:
        """Return what sessions of a pool have in common; any pipeline can be in one."""
        return pipeline.setup.placements, pipeline.setup.rate_hz, pipeline.layout

    def join(self, slot: int, pipeline: Pipeline) -> bool:
        """Let a pipeline take the ticks of a slot; see `Pool.join`."""
        self._pipelines[slot] = pipeline
        return True

    def leave(self, slot: int, pipeline: Pipeline) -> None:
        """Free a slot."""
        self._pipelines.pop(slot, None)
        self._made.pop(slot, None)

    def step(
        self,
        stretches: NDArray[np.void],
        count: int,
        signals: Float,
        quality: NDArray[np.uint8],
        carried: Float,
    ) -> None:
        """Take the next ticks of some sessions; see `Pool.step`."""
        self.errors = {}
        for number, (slot, first_tick, ticks, signals_at, quality_at, tick_at) in enumerate(
            stretches[:count].tolist()
        ):
            if not ticks or slot in self.errors:
                continue
            chunk = chunk_of(
                (first_tick, self._time_step_s, ticks, self._sensors, self._channels),
                signals[signals_at:],
                quality[quality_at:],
                carried[self._width * quality_at :],
                self._carried,
            )
            try:
                frames = self._pipelines[slot].step(chunk)
            except Exception as error:
                self.errors[slot] = number, error
                continue
            if tick_at % self._rows_each == 0:
                self._made[slot] = {}
            self._made[slot][tick_at] = frames
            for name in _SHOWN:
                getattr(self.columns, name)[tick_at : tick_at + ticks] = getattr(frames, name)

    def stepped(self, pipeline: Pipeline, next_tick: int) -> None:
        """Do nothing: a pipeline knows what it has taken."""

    def frames(self, first_tick: int, start: int, stop: int) -> Frames:
        """Return some rows as frames; see `Pool.frames`."""
        made, parts = self._made[start // self._rows_each], []
        while start < stop:
            parts.append(made[start])
            start += parts[-1].tick_count
        return Frames.join(parts).as_stored_live()


def _values(beside: Float) -> Float:
    """Return a channel of (S, K, width) as its field of a chunk."""
    return beside.copy() if beside.shape[2] > 1 else beside[:, :, 0].copy()
