"""Motion of the worn sensors over a stretch of a session, in the room: turning rates, accelerations, postures."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from estimators import rotation
from estimators.conventions import GRAVITY_MPS2, Placement
from estimators.orientation import OrientationFlag
from estimators.pipelines._contract import Frames, SessionSetup
from estimators.recording import Float, ImuChunk

RATE_HZ: Final = 50.0
_UNUSABLE: Final = int(OrientationFlag.INVALID | OrientationFlag.BRIDGED | OrientationFlag.SATURATED)
"""A gyroscope at its end, or one that was not heard for a moment, turned further than it says."""


@dataclass(frozen=True)
class Motion:
    """Thinned ticks of some sensors.

    Attributes
    ----------
    time_s : ndarray, shape (K,)
    q_room_segment : ndarray, shape (K, S, 4)
        NaN where a sensor gave nothing, or was at its end.
    rate_room_radps : ndarray, shape (K, S, 3)
        As the gyroscopes measured it: what a filter corrects is no turn of a sensor. Zero where nothing was measured.
    acceleration_room_mps2 : ndarray, shape (K, S, 3)
        Of the sensor, gravity taken off; zero where nothing was measured.
    """

    names: tuple[Placement, ...]
    time_s: Float
    q_room_segment: Float
    rate_room_radps: Float
    acceleration_room_mps2: Float

    @property
    def step_s(self) -> float:
        """Time between two of its ticks."""
        return float(self.time_s[-1] - self.time_s[0]) / max(len(self.time_s) - 1, 1)

    def after(self, time_s: float) -> "Motion":
        """Return what lies at and after a time."""
        first = int(np.searchsorted(self.time_s, time_s))
        return Motion(
            self.names,
            self.time_s[first:],
            self.q_room_segment[first:],
            self.rate_room_radps[first:],
            self.acceleration_room_mps2[first:],
        )

    @staticmethod
    def join(parts: Sequence["Motion"]) -> "Motion":
        """Put consecutive parts together."""
        return Motion(
            parts[0].names,
            np.concatenate([part.time_s for part in parts]),
            np.concatenate([part.q_room_segment for part in parts]),
            np.concatenate([part.rate_room_radps for part in parts]),
            np.concatenate([part.acceleration_room_mps2 for part in parts]),
        )


def stride_of(time_step_s: float) -> int:
    """Return of how many ticks one is looked at."""
    return max(1, round(1.0 / (RATE_HZ * time_step_s)))


def motion_of(frames: Frames, chunk: ImuChunk, setup: SessionSetup, names: Sequence[Placement]) -> Motion:
    """Return the motion of some sensors during the ticks of frames.

    Parameters
    ----------
    frames : Frames
        Of the arm pipeline, calibrated.
    chunk : ImuChunk
        The same ticks as measured, in the order of the placements.
    setup : SessionSetup
        With the calibration in force.
    names : sequence of Placement
        Among the placements.
    """
    assert setup.calibration is not None
    stride = stride_of(frames.time_step_s)
    ticks = np.arange(-frames.first_tick % stride, frames.tick_count, stride)
    shape = (len(ticks), len(names))
    postures, rates, accelerations = np.empty((*shape, 4)), np.empty((*shape, 3)), np.empty((*shape, 3))
    for column, name in enumerate(names):
        s = setup.placements.index(name)
        q = frames.q_room_segment[ticks, s]
        lost = (frames.segment_flags[ticks, s] & _UNUSABLE) != 0
        seat = rotation.conjugate(np.array(setup.calibration.q_sensor_segment[name]))
        q_room_sensor = rotation.multiply(q, seat)
        bias = np.array(setup.calibration.gyroscope_bias_radps.get(name, (0.0, 0.0, 0.0)))
        rate = rotation.rotate(q_room_sensor, chunk.gyroscope_radps[s, ticks] - bias)
        force = rotation.rotate(q_room_sensor, chunk.accelerometer_mps2[s, ticks])
        force[:, 2] -= GRAVITY_MPS2
        q[lost] = np.nan
        postures[:, column] = q
        for values, filled in ((rate, rates), (force, accelerations)):
            filled[:, column] = np.where(np.isfinite(values) & ~lost[:, None], values, 0.0)
    return Motion(tuple(names), frames.time_s[ticks], postures, rates, accelerations)
