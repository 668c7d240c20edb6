"""How the sensors of arms and legs are worn, judged by the movements after a standing pose."""

import math
from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from estimators.calibration import Calibration, Postures, has_impossible, judged_by_movement
from estimators.orientation import OrientationFlag
from estimators.pipelines._contract import Frames, SessionSetup
from estimators.recording import Float

_LOST: Final = np.uint8(OrientationFlag.INVALID | OrientationFlag.CONVERGING)
_DRIFTING: Final = np.uint8(OrientationFlag.HEADING_NOT_TRUSTED)
_STEADY_S: Final = 120.0
"""So long after a pose a heading without a compass still tells which way a joint bent."""
_HELD_S: Final = 1.0
_MOVED_RAD: Final = np.radians(3.0)
"""What moves less in a second counts once: sensors may lie on a table, or an arm on a lap."""
_SAMPLE_S: Final = 0.2
_LOOK: Final = 25
_DOUBTS: Final = 2
_MEMORY: Final = 300
"""Live a posture is remembered so often; so many are looked at together, so many looks in turn must doubt, and so many
are remembered."""


def judge_worn(frames: Frames, setup: SessionSetup, from_s: float) -> SessionSetup:
    """Return the setup with what the movements of a recording leave of its calibration.

    Parameters
    ----------
    frames : Frames
        Of the arm pipeline under `setup`, of the whole recording or its poses; see `elbow_poses`.
    setup : SessionSetup
        Calibrated by a standing pose.
    from_s : float
        Session time of the end of that pose.

    Returns
    -------
    SessionSetup
        The same object where nothing speaks against the calibration; see `judged_by_movement`.
    """
    if setup.calibration is None or not setup.calibration.q_sensor_segment:
        return setup
    found = judged_by_movement(setup.calibration, postures_of(frames, from_s))
    return setup if found is setup.calibration else replace(setup, calibration=found)


def postures_of(frames: Frames, from_s: float) -> Postures:
    """Return the postures of frames that tell how sensors are worn: after the pose, tracked, and in movement."""
    return _postures(
        frames.layout.segments,
        frames.q_room_segment.copy(),
        frames.segment_flags,
        frames.time_s,
        frames.time_step_s,
        from_s,
    )


def _postures(
    names: tuple[str, ...], q: Float, flags: NDArray[np.uint8], times: Float, step_s: float, from_s: float
) -> Postures:
    lost = (flags & _LOST) != 0
    lost |= ((flags & _DRIFTING) != 0) & (times > from_s + _STEADY_S)[:, None]
    q[lost] = np.nan
    is_after = times > from_s
    return Postures(names, q[is_after & _moves(q, round(_HELD_S / step_s))], step_s)


class WornCheck:
    """Judges a standing pose by the movements that follow, while they go on, in little memory.

    Parameters
    ----------
    calibration : Calibration
        In force.
    """

    def __init__(self, calibration: Calibration) -> None:
        self.calibration = calibration
        self._from_s = math.nan
        self._is_answered = False
        self._doubted = 0
        self._next_tick = self._rows = self._new = 0
        self._q: NDArray[np.float32] | None = None
        self._ticks = np.zeros(_MEMORY, dtype=np.int64)
        self._flags: NDArray[np.uint8] | None = None

    def add(self, frames: Frames) -> Calibration | None:
        """Take the next frames under that calibration; return another one once they contradict it."""
        if math.isnan(self._from_s):
            self._from_s = frames.first_tick * frames.time_step_s
        stride = max(1, round(_SAMPLE_S / frames.time_step_s))
        if self._q is None or self._flags is None:
            self._q = np.empty((_MEMORY, *frames.q_room_segment.shape[1:]), dtype=np.float32)
            self._flags = np.empty((_MEMORY, frames.segment_flags.shape[1]), dtype=np.uint8)
        for k in range(max(0, self._next_tick - frames.first_tick), frames.tick_count, stride):
            row = self._rows % _MEMORY
            self._q[row], self._flags[row] = frames.q_room_segment[k], frames.segment_flags[k]
            self._ticks[row] = (frames.first_tick + k) // stride
            self._next_tick = frames.first_tick + k + stride
            self._rows, self._new = self._rows + 1, self._new + 1
        if self._new < _LOOK:
            return None
        self._new = 0
        step_s = stride * frames.time_step_s
        if not has_impossible(self._postures(frames, _LOOK + round(_HELD_S / step_s), step_s)):
            self._doubted = 0
            return None
        self._doubted += 1
        found = judged_by_movement(self.calibration, self._postures(frames, _MEMORY, step_s))
        # What was wrong for some seconds only, as while a strap is put right, is no matter of the pose.
        if found is self.calibration or self._is_answered or self._doubted < _DOUBTS:
            return None
        self._is_answered = True
        return found

    def _postures(self, frames: Frames, rows: int, step_s: float) -> Postures:
        """Return the newest postures."""
        assert self._q is not None
        assert self._flags is not None
        newest = np.arange(max(0, self._rows - min(rows, _MEMORY)), self._rows) % _MEMORY
        return _postures(
            frames.layout.segments,
            self._q[newest].astype(np.float64),
            self._flags[newest],
            np.asarray(self._ticks[newest] * step_s, dtype=np.float64),
            step_s,
            self._from_s,
        )


def _moves(q_room_segment: Float, ticks: int) -> NDArray[np.bool_]:
    """Say at which ticks anything has turned since so many ticks before."""
    moved = np.zeros(len(q_room_segment), dtype=np.bool_)
    if 0 < ticks < len(moved):
        alike = np.abs(np.sum(q_room_segment[ticks:] * q_room_segment[:-ticks], axis=2))
        moved[ticks:] = (np.nan_to_num(alike, nan=1.0) < np.cos(_MOVED_RAD / 2.0)).any(axis=1)
    return moved
