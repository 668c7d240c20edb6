"""Consequences of an accelerometer's offset and scale: a correction, and whether somebody must calibrate it."""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from estimators.calibration._device import DeviceCalibration, TriadCalibration, matrix, vector
from estimators.calibration.force.errors import ForceErrors
from estimators.conventions import GRAVITY_MPS2
from estimators.sentences import Sentence, say

_FOUND: Final = 7.0
"""Logarithm of the odds against a calibrated device from which a correction is believed where it is known well."""
_LIKELY: Final = 4.0
_CERTAIN: Final = 5.0
"""The same against a cheap device, from which something is done however little is known, and from which it is a fault:
of 3,000 cheap devices one has such errors."""
_KNOWN: Final = 2.0
"""Sigmas that a lean must exceed before it is said."""
_LEAST_RAD: Final = math.radians(1.0)
_FAULT_RAD: Final = math.radians(2.0)
"""A lean that is at least so large is called a fault: cheap devices that are sold as sound have two degrees."""
_LEAST_SPREAD: Final = 0.01
"""Middle variance of the directions of gravity in the sensor. A limb that swings about one axis sees them on one arc,
with hardly 0.002: there, an acceleration in the rhythm of the tilt, as in squats and at the oars, is like an offset."""
_MOST_SCALE, _MOST_OFFSET_MPS2 = 0.1, 0.3 * GRAVITY_MPS2
"""No device is worse; where more is found, the movement deceives."""
_STEEPEST_RAD: Final = math.radians(75.0)
_USUAL_RAD: Final = math.radians(65.0)


@dataclass(frozen=True)
class Correction:
    """What takes the errors of an accelerometer off.

    Attributes
    ----------
    device : DeviceCalibration
        The correction, and what it leaves unknown of orientations.
    message : Sentence
        What was found and done, for people.
    is_fault : bool
        No device that was calibrated has such errors: a warning, no note.
    """

    device: DeviceCalibration
    message: Sentence
    is_fault: bool


def is_uncalibrated(errors: ForceErrors) -> bool:
    """Tell whether the accelerometer has errors that no device has that was calibrated."""
    if not _is_told(errors):
        return False
    least = _least_lean(errors)
    # Where the movement shows the errors and not how far they tilt, nobody can say that they do little.
    return errors.gain_over_cheap > _CERTAIN and (least > _FAULT_RAD or least < 0.0)


def is_found(errors: ForceErrors) -> bool:
    """Tell whether the movement shows errors that must be corrected, or be stated as unknown."""
    if not _is_told(errors):
        return False
    is_known = errors.gain > _FOUND and _least_lean(errors) > 0.0 and errors.tilt_rad > _LEAST_RAD
    return is_known or (errors.gain > _CERTAIN and errors.gain_over_cheap > _LIKELY)


def _is_told(errors: ForceErrors) -> bool:
    """Tell whether the sensor was turned in so many ways that its errors are no matter of how the body accelerates."""
    spread = np.linalg.eigvalsh(np.cov(errors.up, rowvar=False))[1] if len(errors.up) > 2 else 0.0
    is_possible = (
        np.abs(errors.scale).max() < _MOST_SCALE and np.abs(errors.offset_mps2).max() < _MOST_OFFSET_MPS2
    )
    return bool(spread > _LEAST_SPREAD and is_possible)


def _least_lean(errors: ForceErrors) -> float:
    return errors.tilt_rad - _KNOWN * math.sqrt(2.0) * errors.tilt_sigma_rad


def correction(name: str, errors: ForceErrors, dip_rad: float) -> Correction:
    """Return what takes the errors off, and what they leave unknown.

    Parameters
    ----------
    name : str
        Of the sensor.
    dip_rad : float
        Of the magnetic field, positive downward; NaN where it is not known, zero without a magnetometer.

    Notes
    -----
    A compass that is thought level and leans by d shows north `d tan(dip)` aside.
    """
    gain = 1.0 / (1.0 + errors.scale)
    dip = min(abs(_USUAL_RAD if math.isnan(dip_rad) else dip_rad), _STEEPEST_RAD)
    tilt = errors.tilt_sigma_rad
    device = DeviceCalibration(
        accelerometer=TriadCalibration(matrix(np.diag(gain)), vector(errors.offset_mps2)),
        direction_sigma_rad=(tilt, tilt, tilt * max(1.0, math.tan(dip))),
    )
    message = say(
        "readings.accelerometer_corrected",
        where=[name],
        angle_rad=errors.tilt_rad,
        sigma_rad=math.sqrt(2.0) * tilt,
    )
    return Correction(device, message, is_uncalibrated(errors))
