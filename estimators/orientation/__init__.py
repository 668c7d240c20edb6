"""Orientation of each sensor in the earth frame: one folder a filter, one contract, one registry."""

from collections.abc import Mapping
from importlib import import_module
from typing import Any, Final

from estimators.errors import SetupError
from estimators.orientation._contract import OrientationEstimator, OrientationFlag, OrientationResult
from estimators.orientation._device_constants import DeviceConstants
from estimators.orientation._scoring import OrientationErrors, orientation_errors
from estimators.orientation._smoothers import (
    SmoothedChunk,
    Smoother,
    smooth,
    smoothers,
    with_orientation,
)
from estimators.orientation.smoother import SmoothedOrientation
from estimators.orientation.telemotion import TelemotionEstimator
from estimators.orientation.vqf import VqfEstimator

DEFAULT: Final = TelemotionEstimator.name
"""The estimator of whoever names none."""

_OWN: Final = {kind.name: kind for kind in (TelemotionEstimator, VqfEstimator)}
_PUBLISHED: Final = {
    "marzouk_quaternion_ekf": ("published.marzouk", "MarzoukQuaternionEstimator"),
    "marzouk_error_state_ekf": ("published.marzouk", "MarzoukErrorStateEstimator"),
    "marzouk_euler_ekf": ("published.marzouk", "MarzoukEulerEstimator"),
    "luinge_inclination": ("published.luinge", "LuingeEstimator"),
    "roetenberg_disturbance": ("published.roetenberg", "RoetenbergEstimator"),
}
"""Where the filters of papers stand: module and class. They are loaded when somebody asks for them."""


def _published(name: str) -> type[OrientationEstimator]:
    module, kind = _PUBLISHED[name]
    found: type[OrientationEstimator] = getattr(import_module(module), kind)
    return found


def available(*, with_offline: bool = False) -> dict[str, type[OrientationEstimator]]:
    """Return the estimators by name, the default first; `title` and `description` are for people.

    Parameters
    ----------
    with_offline : bool
        Also those that need the whole session and cannot run live (`is_offline`).
    """
    published = {name: _published(name) for name in _PUBLISHED}
    return {**_OWN, **published, **(smoothers() if with_offline else {})}


def create(
    name: str, sensor_count: int, time_step_s: float, parameters: Mapping[str, Any] | None = None
) -> OrientationEstimator:
    """Build an estimator that has seen no samples; off-line ones take only chunks already smoothed.

    Parameters
    ----------
    name : str
        A key of `available(with_offline=True)`.
    parameters : mapping, optional
        What differs from the defaults.

    Raises
    ------
    SetupError
        For an unknown name or parameter.
    """
    loaded = {**_OWN, **smoothers()}
    if name not in loaded and name not in _PUBLISHED:
        raise SetupError(
            f"no orientation estimator {name!r}; known are {', '.join(available(with_offline=True))}"
        )
    kind = loaded[name] if name in loaded else _published(name)
    return kind(sensor_count, time_step_s, parameters)


__all__ = [
    "DEFAULT",
    "DeviceConstants",
    "OrientationErrors",
    "OrientationEstimator",
    "OrientationFlag",
    "OrientationResult",
    "SmoothedChunk",
    "SmoothedOrientation",
    "Smoother",
    "TelemotionEstimator",
    "available",
    "create",
    "orientation_errors",
    "smooth",
    "smoothers",
    "with_orientation",
]
