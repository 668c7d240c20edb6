"""The contract of every orientation estimator, and what it returns."""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import IntFlag
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from estimators.orientation._device_constants import DeviceConstants
from estimators.recording import Float, ImuChunk
from estimators.samples import Samples


class OrientationFlag(IntFlag):
    """What a therapist or a later stage must know about one estimate; zero means sound."""

    SOUND = 0
    INVALID = 1
    """No estimate: before the first usable sample, or inside a gap that could not be bridged."""
    BRIDGED = 2
    """The sample was interpolated across a short gap."""
    CONVERGING = 4
    """Just started or restarted after a gap: the error may be large."""
    ACCELERATION_NOT_TRUSTED = 8
    """Specific force is not mainly gravity."""
    MAGNETIC_DISTURBANCE = 16
    """The field differs from the local reference, or repeats one value while the sensor turns."""
    HEADING_NOT_TRUSTED = 32
    """No magnetometer, or disturbed for so long that heading has drifted beyond use."""
    SATURATED = 64
    """A channel was at its clip level."""
    SINGULAR = 128
    """The filter's own parameterisation is singular here (Euler-angle filters near 90 degrees)."""


@dataclass(frozen=True)
class OrientationResult(Samples):
    """Orientation of S sensors over K ticks.

    Attributes
    ----------
    q_earth_sensor : ndarray, shape (S, K, 4)
        Rotates sensor vectors into the earth frame (x east, y north, z up). Never NaN once started:
        inside a gap it holds the last estimate, flagged INVALID.
    gyroscope_bias_radps : ndarray, shape (S, K, 3)
    sigma_rad : ndarray, shape (S, K, 3), or None
        One-sigma of the orientation error about the earth x, y and z axes, where the method yields it.
    flags : ndarray of uint8, shape (S, K)
        `OrientationFlag` bits.
    """

    TICK_AXIS: ClassVar[int] = 1

    q_earth_sensor: Float
    gyroscope_bias_radps: Float
    sigma_rad: Float | None
    flags: NDArray[np.uint8]


class OrientationEstimator(ABC):
    """Streams the orientation of S sensors; one call serves a whole network.

    The same samples give the same result, bit for bit, one by one, in uneven chunks, in one batch, or
    across `state` and `restore` into a fresh instance built with the same arguments.
    """

    name: ClassVar[str]
    """The key in the registry, stored with every result."""
    version: ClassVar[str]
    """Changes whenever the numbers change."""
    title: ClassVar[str]
    """For people, two to four words."""
    description: ClassVar[str]
    """One sentence a therapist understands."""
    is_offline: ClassVar[bool] = False
    """Needs the whole session and cannot run live."""

    @abstractmethod
    def __init__(
        self, sensor_count: int, time_step_s: float, parameters: Mapping[str, Any] | None = None
    ) -> None:
        """Start with no samples seen. Unknown parameter names raise `SetupError`."""

    @abstractmethod
    def update(self, chunk: ImuChunk) -> OrientationResult:
        """Take the next ticks; `chunk.first_tick` must continue the last one."""

    @abstractmethod
    def state(self) -> dict[str, NDArray[Any]]:
        """Return everything that the next update depends on, as arrays that can be stored."""

    @abstractmethod
    def restore(self, state: Mapping[str, NDArray[Any]]) -> None:
        """Continue exactly where the instance that gave `state` stood."""

    @abstractmethod
    def set_gyroscope_bias(self, bias_radps: Float, sigma_radps: float) -> None:
        """Take a static calibration, shape (S, 3), with its standard error."""

    def set_device_constants(self, constants: Sequence[DeviceConstants | None]) -> None:
        """Begin with what earlier sessions learnt about the same sensors (None: nothing), before the first sample.

        A method that has no use for them leaves them alone.
        """
        return

    def take_off_force(self, offset_mps2: Float) -> None:
        """Expect specific force less an offset, shape (S, 3), from the next sample on: somebody takes it off.

        A method that learns no offset leaves it alone.
        """
        return

    @property
    def device_constants(self) -> tuple[DeviceConstants, ...]:
        """What is known of each sensor by now, to be stored with its device; empty where the method learns none."""
        return ()

    @property
    @abstractmethod
    def parameters(self) -> dict[str, Any]:
        """Every parameter with its value and its unit in its name, ready for JSON."""
