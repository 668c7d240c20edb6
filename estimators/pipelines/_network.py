"""The pipeline of a network of worn sensors: what all kinds that stand on `BodyNetwork` answer alike."""

from collections.abc import Mapping
from typing import Any

from numpy.typing import NDArray

from estimators.conventions import Placement
from estimators.orientation import DeviceConstants
from estimators.pipelines._contract import Calibration, FrameLayout, Pipeline, SessionSetup
from estimators.pipelines.arm.body import BodyNetwork
from estimators.recording import ImuChunk


class NetworkPipeline(Pipeline):
    """Sensors on segments; a subclass sets `_layout` and steps."""

    _layout: FrameLayout

    def __init__(self, setup: SessionSetup) -> None:
        self._network = BodyNetwork(setup)

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

    def calibrate(self, pose: ImuChunk, method: str = "n_pose") -> Calibration:
        """Find bias, mounting and facing from the ticks of a pose; see the contract."""
        return self._network.calibrate(pose, method)

    def state(self) -> dict[str, NDArray[Any]]:
        """Return everything that the next step depends on, as arrays."""
        return self._network.state()

    def restore(self, state: Mapping[str, NDArray[Any]]) -> None:
        """Continue exactly where the instance that gave `state` stood."""
        self._network.restore(state)
