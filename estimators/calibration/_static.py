"""Gyroscope and accelerometer bias from a few seconds of rest."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from estimators import rotation
from estimators.conventions import GRAVITY_MPS2
from estimators.errors import CalibrationError, ShapeError
from estimators.recording import Float
from estimators.sentences import Sentence, say

MINIMUM_SAMPLES = 100
"""Marzouk (2009), 2.1.1.2: 100 to 150 samples at 17 Hz."""
MINIMUM_S = 1.0
THESIS_GYROSCOPE_SD_RADPS = float(np.deg2rad(np.sqrt((0.2460 + 0.3601 + 0.2684) / 3.0)))
THESIS_ACCELEROMETER_SD_MPS2 = 0.0155 * GRAVITY_MPS2
"""Noise per axis of the thesis' unit (T2.1, T2.2), averaged over axes; stillness allows twice as much."""
_BLOCKS = 8
_OUTLIER = 5.0
UNUSUAL_BIAS_SCORE = 0.5
_UNUSUAL_RADPS = float(np.deg2rad(3.0))
_BIAS_LIMIT_RADPS = float(np.deg2rad(10.0))


@dataclass(frozen=True)
class StaticBias:
    """Constants found at rest, for S sensors.

    Attributes
    ----------
    gyroscope_bias_radps : ndarray, shape (S, 3)
    gyroscope_sd_radps : ndarray, shape (S, 3)
        Spread of single samples.
    gyroscope_standard_error_radps : ndarray, shape (S, 3)
        Of the bias; counts slow sway, not only white noise.
    accelerometer_bias_mps2 : ndarray, shape (S, 3), or None
        None unless the attitude was given. Tilt that was not known is in it: 1 degree makes 0.17 m/s^2.
    accelerometer_sd_mps2 : ndarray, shape (S, 3)
    still : ndarray of bool, shape (S,)
        Whether the sensor stayed within the limits.
    sample_count : ndarray of int, shape (S,)
        Samples that counted: finite and no outliers.
    """

    gyroscope_bias_radps: Float
    gyroscope_sd_radps: Float
    gyroscope_standard_error_radps: Float
    accelerometer_bias_mps2: Float | None
    accelerometer_sd_mps2: Float
    still: NDArray[np.bool_]
    sample_count: NDArray[np.intp]

    @property
    def unusual(self) -> NDArray[np.bool_]:
        """Sensors whose bias is more than 3 deg/s, shape (S,): few gyroscopes have that, a slow turn looks the same."""
        return np.asarray((np.abs(self.gyroscope_bias_radps) > _UNUSUAL_RADPS).any(axis=1))


def static_bias(
    gyroscope_radps: Float,
    accelerometer_mps2: Float,
    time_step_s: float,
    *,
    q_earth_sensor: Float | None = None,
    gyroscope_limit_radps: float = 2.0 * THESIS_GYROSCOPE_SD_RADPS,
    accelerometer_limit_mps2: float = 2.0 * THESIS_ACCELEROMETER_SD_MPS2,
    require_still: bool = True,
    names: Sequence[str] | None = None,
) -> StaticBias:
    """Find the bias of sensors that lie still.

    Parameters
    ----------
    gyroscope_radps, accelerometer_mps2 : ndarray, shape (S, K, 3)
        Sensor axes; NaN where samples are missing.
    q_earth_sensor : ndarray, shape (S, 4), optional
        The known attitude of each sensor; needed for the bias of the accelerometer.
    gyroscope_limit_radps, accelerometer_limit_mps2 : float
        Largest standard deviation per axis (root mean square over the axes) that counts as still.
    require_still : bool
        Refuse if a sensor moved; otherwise only say so in `still`.
    names : sequence of str, optional
        What to call the sensors in errors: placements, or other names; numbers otherwise.

    Raises
    ------
    CalibrationError
        Too few samples, a sensor that moved, or a mean rate that no bias reaches; with what to redo.

    Notes
    -----
    Marzouk (2009) 2.1.1.2 and 3.1.1, corrected: b_g = mean(gyro), b_a = mean(f) - R'(g up), not mean(f).
    The standard error is the larger of SD/sqrt(N) and that of eight block means, so that slow sway
    shows. Samples more than five robust SDs from the median are left out.
    """
    shape = gyroscope_radps.shape
    if len(shape) != 3 or shape[2] != 3 or accelerometer_mps2.shape != shape:
        raise ShapeError(f"gyroscope {shape} and accelerometer {accelerometer_mps2.shape} must be (S, K, 3)")
    sensors = shape[0]
    called = names or [f"sensor {s + 1}" for s in range(sensors)]
    bias, spread, error = np.empty((sensors, 3)), np.empty((sensors, 3)), np.empty((sensors, 3))
    force, force_spread = np.empty((sensors, 3)), np.empty((sensors, 3))
    counts = np.zeros(sensors, dtype=np.intp)
    for s in range(sensors):
        keep = np.isfinite(gyroscope_radps[s]).all(axis=-1) & np.isfinite(accelerometer_mps2[s]).all(axis=-1)
        keep[keep] &= ~_outliers(gyroscope_radps[s, keep]) & ~_outliers(accelerometer_mps2[s, keep])
        counts[s] = np.count_nonzero(keep)
        needed = max(round(MINIMUM_S / time_step_s), 2 * _BLOCKS)
        if counts[s] < min(needed, MINIMUM_SAMPLES):
            raise CalibrationError(
                say(
                    "calibration.too_few_samples",
                    where=[called[s]],
                    samples=counts[s],
                    least_s=MINIMUM_S,
                )
            )
        rate = gyroscope_radps[s, keep]
        bias[s], spread[s] = rate.mean(axis=0), rate.std(axis=0, ddof=1)
        error[s] = _standard_error(rate)
        force[s], force_spread[s] = (
            accelerometer_mps2[s, keep].mean(axis=0),
            accelerometer_mps2[s, keep].std(axis=0, ddof=1),
        )
    still = np.asarray(
        (_rms(spread) <= gyroscope_limit_radps) & (_rms(force_spread) <= accelerometer_limit_mps2)
    )
    if require_still and not still.all():
        raise CalibrationError(say("calibration.moved", where=_named(called, ~still)))
    absurd = np.asarray((np.abs(bias) > _BIAS_LIMIT_RADPS).any(axis=1))
    if absurd.any():
        raise CalibrationError(
            say(
                "calibration.turned_steadily",
                where=_named(called, absurd),
                limit_radps=_BIAS_LIMIT_RADPS,
            )
        )
    accelerometer_bias = None
    if q_earth_sensor is not None:
        up = rotation.rotate(rotation.conjugate(q_earth_sensor), [0.0, 0.0, GRAVITY_MPS2])
        accelerometer_bias = force - up
    return StaticBias(bias, spread, error, accelerometer_bias, force_spread, still, counts)


def unusual_bias(called: Sequence[str]) -> Sentence:
    """Say of which sensors the bias is unusual, and what to do.

    Parameters
    ----------
    called : sequence of str
        Placements, or other names.
    """
    return say("calibration.unusual_zero", where=list(called), limit_radps=_UNUSUAL_RADPS)


def _outliers(values: Float) -> NDArray[np.bool_]:
    """Return the samples, shape (K,), of (K, 3) that lie far from the median on any axis."""
    if not len(values):
        return np.zeros(0, dtype=np.bool_)
    distance = np.abs(values - np.median(values, axis=0))
    # 1.4826 brings the median distance of a normal distribution to its standard deviation.
    limit = _OUTLIER * 1.4826 * np.median(distance, axis=0)
    return np.asarray(((distance > limit) & (limit > 0.0)).any(axis=1))


def _standard_error(values: Float) -> Float:
    white = values.std(axis=0, ddof=1) / np.sqrt(len(values))
    means = np.stack([block.mean(axis=0) for block in np.array_split(values, _BLOCKS)])
    return np.asarray(np.maximum(white, means.std(axis=0, ddof=1) / np.sqrt(_BLOCKS)))


def _rms(values: Float) -> Float:
    return np.asarray(np.sqrt(np.mean(values**2, axis=-1)))


def _named(called: Sequence[str], which: NDArray[np.bool_]) -> list[str]:
    return [name for name, bad in zip(called, which, strict=True) if bad]
