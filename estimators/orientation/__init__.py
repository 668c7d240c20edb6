"""Orientation of each sensor in the earth frame: one folder a filter, one contract, one registry."""

from collections.abc import Mapping
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
from estimators.orientation.luinge import LuingeEstimator
from estimators.orientation.marzouk import (
    MarzoukErrorStateEstimator,
    MarzoukEulerEstimator,
    MarzoukQuaternionEstimator,
)
from estimators.orientation.roetenberg import RoetenbergEstimator
from estimators.orientation.smoother import SmoothedOrientation
from estimators.orientation.telemotion import TelemotionEstimator
from estimators.orientation.vqf import VqfEstimator

DEFAULT: Final = TelemotionEstimator.name
"""The estimator of whoever names none."""

_REGISTRY: dict[str, type[OrientationEstimator]] = {
    kind.name: kind
    for kind in (
        TelemotionEstimator,
        VqfEstimator,
        MarzoukQuaternionEstimator,
        MarzoukErrorStateEstimator,
        MarzoukEulerEstimator,
        LuingeEstimator,
        RoetenbergEstimator,
    )
}


def available(*, with_offline: bool = False) -> dict[str, type[OrientationEstimator]]:
    """Return the estimators by name, the default first; `title` and `description` are for people.

    Parameters
    ----------
    with_offline : bool
        Also those that need the whole session and cannot run live (`is_offline`).
    """
    return {**_REGISTRY, **(smoothers() if with_offline else {})}


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
    known = available(with_offline=True)
    if name not in known:
        raise SetupError(f"no orientation estimator {name!r}; known are {', '.join(known)}")
    return known[name](sensor_count, time_step_s, parameters)


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
