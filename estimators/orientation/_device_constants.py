"""Constants that a filter learns about a device, carried from one session to the next."""

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from estimators.errors import ShapeError
from estimators.recording import Float

Row = tuple[float, float, float]
Table = tuple[Row, Row, Row]
_NONE: Row = (0.0, 0.0, 0.0)
_GAIN_UNKNOWN, _IRON_UNKNOWN_T = 0.01, 30e-6
_OFFSET_UNKNOWN_MPS2, _SCALE_UNKNOWN = 0.2, 0.02
_BELIEVED_SIGMAS = 4.0


@dataclass(frozen=True)
class DeviceConstants:
    """Errors of one sensor that outlast a session, each with its standard deviation.

    The defaults say that nothing is known. A value holds plain numbers only, so `to_dict` is ready for JSON.

    Attributes
    ----------
    magnetometer_delay_s, magnetometer_delay_sigma_s : float
        Delay of the magnetometer against the gyroscope.
    gyroscope_gain, gyroscope_gain_sigma : tuple, shape (3, 3)
        Scale and axis errors K by rows: true rate = (I + K) measured - bias.
    hard_iron_t, hard_iron_sigma_t : tuple, shape (3,)
        Sensor axes.
    gyroscope_clip_radps, accelerometer_clip_mps2 : float or None
        The largest value that the device shows; None until it was reached.
    accelerometer_offset_mps2, accelerometer_offset_sigma_mps2 : tuple, shape (3,)
        What it shows too much, sensor axes.
    accelerometer_scale, accelerometer_scale_sigma : float
        By which share it shows too much of gravity.
    """

    magnetometer_delay_s: float = 0.0
    magnetometer_delay_sigma_s: float = 0.02
    gyroscope_gain: Table = (_NONE, _NONE, _NONE)
    gyroscope_gain_sigma: Table = ((_GAIN_UNKNOWN,) * 3,) * 3
    hard_iron_t: Row = _NONE
    hard_iron_sigma_t: Row = (_IRON_UNKNOWN_T,) * 3
    gyroscope_clip_radps: float | None = None
    accelerometer_clip_mps2: float | None = None
    accelerometer_offset_mps2: Row = _NONE
    accelerometer_offset_sigma_mps2: Row = (_OFFSET_UNKNOWN_MPS2,) * 3
    accelerometer_scale: float = 0.0
    accelerometer_scale_sigma: float = _SCALE_UNKNOWN

    def __post_init__(self) -> None:
        for name, shape in _SHAPES.items():
            value = getattr(self, name)
            try:
                array = np.asarray(value, dtype=np.float64)
            except (TypeError, ValueError):
                raise ShapeError(f"{name} must be numbers of shape {shape}, not {value!r}") from None
            if array.shape != shape or not np.isfinite(array).all():
                raise ShapeError(f"{name} must be finite numbers of shape {shape}, not {value!r}")
            if "sigma" in name and not (array > 0.0).all():
                raise ShapeError(f"{name} must be above zero")
            object.__setattr__(self, name, _plain(array))
        for name in ("gyroscope_clip_radps", "accelerometer_clip_mps2"):
            value = getattr(self, name)
            if value is None:
                continue
            if not (isinstance(value, (int, float)) and math.isfinite(value) and value > 0.0):
                raise ShapeError(f"{name} must be a number above zero or None, not {value!r}")

    def to_dict(self) -> dict[str, Any]:
        """Return plain JSON types; `from_dict` reverses it exactly."""
        return asdict(self)

    @classmethod
    def from_dict(cls, stored: Mapping[str, Any]) -> "DeviceConstants":
        """Rebuild from `to_dict` after a trip through JSON; what is missing is unknown.

        Raises
        ------
        ShapeError
            For a name that is no constant, or a value of the wrong kind.
        """
        if unknown := sorted(set(stored) - set(cls.__dataclass_fields__)):
            raise ShapeError(f"{', '.join(unknown)}: no constant of a device")
        return cls(**stored)

    def believed(
        self, gain_sigma: float, delay_sigma_s: float, iron_sigma_t: float, offset_sigma_mps2: float
    ) -> "DeviceConstants":
        """Return what can be true of a device, given the spread of its kind; the rest as unknown.

        A gain or delay more than four sigmas out is what swapped axes or a wrong unit teach, and then all else was
        learnt with them, as it was with an offset of the accelerometer that far out; hard iron that far out is a
        magnet that was near. Clip levels were seen as such.
        """
        if (
            np.abs(self.array("gyroscope_gain")).max() > _BELIEVED_SIGMAS * gain_sigma
            or abs(self.magnetometer_delay_s) > _BELIEVED_SIGMAS * delay_sigma_s
            or np.abs(self.array("accelerometer_offset_mps2")).max() > _BELIEVED_SIGMAS * offset_sigma_mps2
        ):
            return DeviceConstants(
                gyroscope_clip_radps=self.gyroscope_clip_radps,
                accelerometer_clip_mps2=self.accelerometer_clip_mps2,
            )
        if np.abs(self.array("hard_iron_t")).max() > _BELIEVED_SIGMAS * iron_sigma_t:
            return replace(self, hard_iron_t=_NONE, hard_iron_sigma_t=(_IRON_UNKNOWN_T,) * 3)
        return self

    def less_offset(self, taken_off_mps2: ArrayLike) -> "DeviceConstants":
        """Return the constants of readings from which an offset of the accelerometer, shape (3,), is taken off.

        Where the offset is not known, what is left of it is not known either.
        """
        if self.accelerometer_offset_sigma_mps2 == DeviceConstants.accelerometer_offset_sigma_mps2:
            return self
        left = self.array("accelerometer_offset_mps2") - np.asarray(taken_off_mps2, dtype=np.float64)
        return replace(self, accelerometer_offset_mps2=_plain(left))

    def array(self, name: str) -> Float:
        """Return one constant as an array."""
        return np.asarray(getattr(self, name), dtype=np.float64)


def _plain(array: Float) -> Any:
    """Nest tuples of floats as the array is nested."""
    return tuple(_plain(row) for row in array) if array.ndim else float(array)


_SHAPES: dict[str, tuple[int, ...]] = {
    "magnetometer_delay_s": (),
    "magnetometer_delay_sigma_s": (),
    "gyroscope_gain": (3, 3),
    "gyroscope_gain_sigma": (3, 3),
    "hard_iron_t": (3,),
    "hard_iron_sigma_t": (3,),
    "accelerometer_offset_mps2": (3,),
    "accelerometer_offset_sigma_mps2": (3,),
    "accelerometer_scale": (),
    "accelerometer_scale_sigma": (),
}
