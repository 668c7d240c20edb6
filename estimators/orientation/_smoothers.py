"""Off-line smoothers: their registry, and how a pipeline plays what they found."""

from abc import abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, fields
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from estimators.errors import SetupError
from estimators.orientation._contract import OrientationEstimator, OrientationResult
from estimators.orientation._device_constants import DeviceConstants
from estimators.orientation._parameters import read_parameters
from estimators.orientation._streaming import ChunkGuard, bias_array, copied
from estimators.orientation.smoother import SmoothedOrientation, SmootherParameters
from estimators.orientation.smoother import smooth as smooth_telemotion
from estimators.recording import Float, ImuChunk


@dataclass(frozen=True)
class SmoothedChunk(ImuChunk):
    """Ticks whose orientation is known from the whole session.

    Attributes
    ----------
    orientation : OrientationResult
        Of these ticks.
    constants : tuple of DeviceConstants
        One a sensor.
    """

    orientation: OrientationResult
    constants: tuple[DeviceConstants, ...]


def with_orientation(
    chunk: ImuChunk, orientation: OrientationResult, constants: Sequence[DeviceConstants]
) -> SmoothedChunk:
    """Put a chunk and its known orientation together."""
    measured = {field.name: getattr(chunk, field.name) for field in fields(ImuChunk)}
    return SmoothedChunk(**measured, orientation=orientation, constants=tuple(constants))


class Smoother(OrientationEstimator):
    """An off-line method: `smooth` works on a whole session, `update` gives back what it found.

    So whatever takes an estimator, a pipeline above all, runs on a smoothed session as it runs live.
    """

    is_offline: ClassVar[bool] = True
    follows: ClassVar[str]
    """The filter that gives the live result of the same method."""
    _parameter_kind: ClassVar[type[SmootherParameters]]

    def __init__(
        self, sensor_count: int, time_step_s: float, parameters: Mapping[str, Any] | None = None
    ) -> None:
        self._guard = ChunkGuard(sensor_count, time_step_s, is_whole=True)
        self._parameters = read_parameters(self._parameter_kind, parameters)
        self._constants: tuple[DeviceConstants, ...] = ()

    @classmethod
    @abstractmethod
    def smooth(
        cls,
        chunk: ImuChunk,
        parameters: Mapping[str, Any] | None = None,
        constants: Sequence[DeviceConstants | None] | None = None,
    ) -> SmoothedOrientation:
        """Estimate orientation from a whole session; see `estimators.orientation.smooth`."""

    def update(self, chunk: ImuChunk) -> OrientationResult:
        """Give back what was found for these ticks.

        Raises
        ------
        SetupError
            If the chunk was not smoothed: a live stream has no end to look back from.
        """
        if not isinstance(chunk, SmoothedChunk):
            raise SetupError(
                f"{self.name} needs the whole session; use {self.follows} while it is recorded, and smooth afterwards"
            )
        self._guard.accept(chunk)
        self._constants = chunk.constants
        found = chunk.orientation
        # Pieces of a session are views of it; compiled stages behind this one need arrays of their own.
        return OrientationResult(
            np.ascontiguousarray(found.q_earth_sensor),
            np.ascontiguousarray(found.gyroscope_bias_radps),
            None if found.sigma_rad is None else np.ascontiguousarray(found.sigma_rad),
            np.ascontiguousarray(found.flags),
        )

    def state(self) -> dict[str, NDArray[Any]]:
        """Return the next tick; all else is in the smoothed chunks."""
        return {"next_tick": np.array(self._guard.next_tick, dtype=np.int64)}

    def restore(self, state: Mapping[str, NDArray[Any]]) -> None:
        """Continue where the instance that gave `state` stood."""
        self._guard.next_tick = int(copied(state, "next_tick", np.array(0, dtype=np.int64)))

    def set_gyroscope_bias(self, bias_radps: Float, sigma_radps: float) -> None:
        """Check a static calibration; the whole session shows the bias better."""
        bias_array(bias_radps, sigma_radps, self._guard.sensor_count)

    @property
    def device_constants(self) -> tuple[DeviceConstants, ...]:
        """What the whole session taught about each sensor."""
        return self._constants

    @property
    def parameters(self) -> dict[str, Any]:
        """Every parameter with its value and its unit in its name, ready for JSON."""
        return asdict(self._parameters)


class TelemotionSmoother(Smoother):
    """Our own filter's model over the whole session, both ways."""

    name: ClassVar[str] = "telemotion_smoother"
    version: ClassVar[str] = "9"
    title: ClassVar[str] = "Telemotion, off-line"
    description: ClassVar[str] = (
        "Looks at the whole session, forward and backward, once it is recorded; the most accurate."
    )
    follows: ClassVar[str] = "telemotion"
    _parameter_kind = SmootherParameters

    @classmethod
    def smooth(
        cls,
        chunk: ImuChunk,
        parameters: Mapping[str, Any] | None = None,
        constants: Sequence[DeviceConstants | None] | None = None,
    ) -> SmoothedOrientation:
        """Estimate orientation from a whole session; see `estimators.orientation.smooth`."""
        return smooth_telemotion(chunk, parameters, constants)


_REGISTRY: dict[str, type[Smoother]] = {kind.name: kind for kind in (TelemotionSmoother,)}


def smoothers() -> dict[str, type[Smoother]]:
    """Return the off-line smoothers by name."""
    return dict(_REGISTRY)


def smooth(
    name: str,
    chunk: ImuChunk,
    parameters: Mapping[str, Any] | None = None,
    constants: Sequence[DeviceConstants | None] | None = None,
) -> SmoothedOrientation:
    """Estimate orientation from a whole session.

    Parameters
    ----------
    name : str
        A key of `smoothers()`.
    chunk : ImuChunk
        All ticks of the session.
    parameters : mapping, optional
        What differs from the defaults.
    constants : sequence of DeviceConstants or None, optional
        What is known of the devices, one a sensor.

    Returns
    -------
    SmoothedOrientation
        Orientation, and the constants as they are now known.

    Raises
    ------
    SetupError
        For an unknown name or parameter.
    ShapeError
        For a chunk without ticks, or arrays that do not fit together.
    """
    if name not in _REGISTRY:
        raise SetupError(f"no smoother {name!r}; known are {', '.join(_REGISTRY)}")
    return _REGISTRY[name].smooth(chunk, parameters, constants)
