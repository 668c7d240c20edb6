"""The orientation pipeline: each sensor for itself, no body."""

from collections.abc import Sequence
from typing import ClassVar

import numpy as np

from estimators.conventions import Placement
from estimators.errors import SetupError
from estimators.pipelines._contract import Calibration, FrameLayout, Frames, SessionSetup
from estimators.pipelines._network import NetworkPipeline
from estimators.recording import ImuChunk
from estimators.sentences import say


class OrientationPipeline(NetworkPipeline):
    """Single sensors to their orientation: segments are the sensors, room is the earth frame (x east).

    Placements may have any name. There is nothing to calibrate but the gyroscopes' bias, method `static`,
    and no need to: the filters find it.
    """

    name: ClassVar[str] = "orientation"
    version: ClassVar[str] = "1"
    title: ClassVar[str] = "Single sensors"
    axes: ClassVar[str] = "earth: x east, y north, z up; without a magnetometer the heading is arbitrary"
    takes_estimator: ClassVar[bool] = True
    is_worn: ClassVar[bool] = False
    is_streamed: ClassVar[bool] = False

    @classmethod
    def used(cls, placements: Sequence[Placement], *, with_legs: bool = False) -> tuple[Placement, ...]:
        """Return all sensors."""
        return tuple(placements)

    def __init__(self, setup: SessionSetup) -> None:
        super().__init__(setup)
        self._layout = FrameLayout(segments=tuple(setup.placements), points=(), angles=())

    def step(self, chunk: ImuChunk) -> Frames:
        """Take the next ticks of all sensors, in the order of `setup.placements`."""
        result, q_room_segment, _, sigma, _ = self._network.step(chunk)
        ticks = chunk.tick_count
        return Frames(
            layout=self._layout,
            first_tick=chunk.first_tick,
            time_step_s=chunk.time_step_s,
            q_room_segment=q_room_segment,
            point_room_m=np.empty((ticks, 0, 3)),
            angle_rad=np.empty((ticks, 0)),
            angle_sigma_rad=np.empty((ticks, 0)),
            scalar=np.empty((ticks, 0)),
            segment_flags=np.ascontiguousarray(result.flags.T),
            angle_flags=np.empty((ticks, 0), dtype=np.uint8),
            segment_sigma_rad=sigma,
        )

    def calibrate(self, pose: ImuChunk, method: str = "static") -> Calibration:
        """Find the gyroscopes' bias while every sensor lies still."""
        if method != "static":
            raise SetupError(say("calibration.single_sensors"))
        return super().calibrate(pose, method)
