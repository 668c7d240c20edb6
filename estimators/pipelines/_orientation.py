"""The orientation pipeline: each sensor for itself, no body."""

from collections.abc import Mapping, Sequence
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from estimators.conventions import Placement
from estimators.errors import SetupError
from estimators.orientation import DeviceConstants
from estimators.pipelines._contract import Calibration, FrameLayout, Frames, Pipeline, SessionSetup
from estimators.pipelines.arm.body import BodyNetwork
from estimators.recording import ImuChunk
from estimators.sentences import say


class OrientationPipeline(Pipeline):
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
        self._network = BodyNetwork(setup)
        self._layout = FrameLayout(segments=tuple(setup.placements), points=(), angles=())

    @property
    def layout(self) -> FrameLayout:
        """Column names of every `Frames` this pipeline gives."""
        return self._layout

    @property
    def device_constants(self) -> dict[Placement, DeviceConstants]:
        """What is known of each sensor by now."""
        return self._network.device_constants

    @property
    def setup(self) -> SessionSetup:
        """The setup with the calibration in force."""
        return self._network.setup

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
        return self._network.calibrate(pose, method)

    def state(self) -> dict[str, NDArray[Any]]:
        """Return everything that the next step depends on, as arrays."""
        return self._network.state()

    def restore(self, state: Mapping[str, NDArray[Any]]) -> None:
        """Continue exactly where the instance that gave `state` stood."""
        self._network.restore(state)
