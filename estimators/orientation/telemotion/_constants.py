"""Constants of a device and the states of our filter that hold them: how one becomes the other."""

import math
from typing import Any

import numpy as np

from estimators.conventions import GRAVITY_MPS2
from estimators.orientation._device_constants import DeviceConstants
from estimators.orientation.telemotion import _records as at
from estimators.orientation.telemotion._parameters import TelemotionParameters
from estimators.recording import Float

MICROTESLA_PER_TESLA = 1e6
_GAIN_AGEING, _DELAY_AGEING_S, _IRON_AGEING_UT, _OFFSET_AGEING_MPS2, _SCALE_AGEING = (
    0.003,
    0.002,
    0.5,
    0.03,
    0.003,
)
"""What temperature and time change between two sessions, one sigma."""


def begin_with(
    known: DeviceConstants, memory: Any, covariance: Float, parameters: TelemotionParameters
) -> None:
    """Write what is known of a device into the states of a sensor and into its covariance, before the first sample.

    Nothing makes a state less certain than it is without constants.

    Parameters
    ----------
    memory : record
        Of the sensor, changed.
    covariance : ndarray, shape (STATES, STATES)
        Diagonal, changed.
    """
    p = parameters

    def narrow(first: int, sigma: Float, ageing: float, unknown: float) -> None:
        for i, one in enumerate(np.ravel(sigma)):
            covariance[first + i, first + i] = min(one**2 + ageing**2, unknown**2)

    # One variance serves the three axes of a hypothesis; what is as good as unknown stays unknown.
    iron_sigma_ut = MICROTESLA_PER_TESLA * known.array("hard_iron_sigma_t")
    iron_variance = float(np.mean(iron_sigma_ut**2)) + _IRON_AGEING_UT**2
    if iron_variance < p.iron_middle_ut**2:
        memory["iron"] = memory["iron_known"] = MICROTESLA_PER_TESLA * known.array("hard_iron_t")
        memory["iron_known_variance"] = iron_variance
        for i in range(at.IRON, at.IRON + 3):
            covariance[i, i] = p.iron_wide_ut**2 + iron_variance
    memory["delay"] = known.magnetometer_delay_s
    narrow(at.DELAY, known.array("magnetometer_delay_sigma_s"), _DELAY_AGEING_S, p.delay_sigma_s)
    memory["gain"] = known.array("gyroscope_gain").T.ravel()
    narrow(at.GAIN, known.array("gyroscope_gain_sigma").T, _GAIN_AGEING, p.gain_sigma)
    memory["gains_settled"] = 1  # the hypotheses are on devices of which nothing is known
    memory["force_offset"] = offset = known.array("accelerometer_offset_mps2")
    # It was learnt in the attitudes of one session, where the scale of an axis looks like an offset.
    uneven = p.tilt_sigma_per_offset * float(np.linalg.norm(offset))
    narrow(
        at.OFFSET,
        known.array("accelerometer_offset_sigma_mps2"),
        math.hypot(_OFFSET_AGEING_MPS2, uneven),
        p.force_offset_sigma_mps2,
    )
    memory["gravity"] = GRAVITY_MPS2 * (1.0 + known.accelerometer_scale)
    narrow(
        at.WEIGHT,
        GRAVITY_MPS2 * known.array("accelerometer_scale_sigma"),
        GRAVITY_MPS2 * _SCALE_AGEING,
        p.gravity_sigma_mps2,
    )
    for kind, clip in enumerate((known.gyroscope_clip_radps, known.accelerometer_clip_mps2)):
        if clip is not None:
            memory["clip_level"][kind] = memory["largest"][kind] = clip


def constants_of(
    nominal: Float,
    sigma: Float,
    iron_ut: Float,
    iron_sigma_ut: Float,
    clips: tuple[float | None, float | None],
    parameters: TelemotionParameters,
) -> DeviceConstants:
    """Return what is known of a device, as far as it can be true of one.

    Parameters
    ----------
    nominal, sigma : ndarray, shape (STATES,)
        States and their standard deviations.
    iron_ut, iron_sigma_ut : ndarray, shape (3,)
        Hard iron in sensor axes.
    clips : tuple of two
        Clip level of gyroscope and accelerometer, or None.
    """
    gain, offset = slice(at.GAIN, at.GAIN + 9), slice(at.OFFSET, at.OFFSET + 3)
    found: Any = {
        "magnetometer_delay_s": nominal[at.DELAY],
        "magnetometer_delay_sigma_s": sigma[at.DELAY],
        "gyroscope_gain": nominal[gain].reshape(3, 3).T,
        "gyroscope_gain_sigma": sigma[gain].reshape(3, 3).T,
        "hard_iron_t": iron_ut / MICROTESLA_PER_TESLA,
        "hard_iron_sigma_t": iron_sigma_ut / MICROTESLA_PER_TESLA,
        "gyroscope_clip_radps": clips[0],
        "accelerometer_clip_mps2": clips[1],
        "accelerometer_offset_mps2": nominal[offset],
        "accelerometer_offset_sigma_mps2": sigma[offset],
        "accelerometer_scale": nominal[at.WEIGHT] / GRAVITY_MPS2 - 1.0,
        "accelerometer_scale_sigma": sigma[at.WEIGHT] / GRAVITY_MPS2,
    }
    return believed(DeviceConstants(**found), parameters)


def believed(constants: DeviceConstants, parameters: TelemotionParameters) -> DeviceConstants:
    """Return what can be true of a device, given the spread of its kind."""
    p = parameters
    return constants.believed(
        p.gain_sigma, p.delay_sigma_s, p.iron_wide_ut / MICROTESLA_PER_TESLA, p.force_offset_sigma_mps2
    )
