"""Sensors as they are delivered: errors by the grade of their data sheets, and the readings that they give."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from scipy import signal

from estimators.conventions import GRAVITY_MPS2
from estimators.recording import Float
from validation.worlds.conditions import Conditions

_MG: Final = 1e-3 * GRAVITY_MPS2
_DEG: Final = float(np.radians(1.0))
_UT: Final = 1e-6


@dataclass(frozen=True)
class Triad:
    """Errors of three axes, in the unit of the quantity.

    Attributes
    ----------
    offset : float
        Standard deviation over devices, of what is left where the device is calibrated.
    scale, cross : float
        Standard deviation of the gain of an axis, and of what it sees of another.
    density : float
        White noise, per root hertz.
    drift : float
        Bias instability: standard deviation of an offset that wanders within minutes.
    warming : float
        Standard deviation of how far the offset moves from switching on to its end.
    count : float
        Of the converter.
    calibration : float
        Standard deviation of the gains that a calibration inside the device has taken out. What a range cuts off is
        no single value after it.
    """

    offset: float = 0.0
    scale: float = 0.0
    cross: float = 0.0
    density: float = 0.0
    drift: float = 0.0
    warming: float = 0.0
    count: float = 0.0
    calibration: float = 0.0


@dataclass(frozen=True)
class Device:
    """Grade of a sensor.

    Attributes
    ----------
    g_sensitivity_sps : float
        Standard deviation of the rate that a gyroscope axis shows for one m/s^2 along an axis, rad/s per m/s^2.
    """

    gyroscope: Triad
    accelerometer: Triad
    magnetometer: Triad
    g_sensitivity_sps: float = 0.0


# Standard deviations are about two fifths of the tolerances that data sheets print.
# Looked up in a sheet: MPU-9250 and, in part, MTi-1. Those of BMI160, LSM6DSO and BMM150 are still to be checked.
# consumer: InvenSense MPU-9250, PS-MPU-9250A-01 rev. 1.0, tables 1 to 3: 5 deg/s, 3 %, cross-axis 2 %, 0.01
# deg/s/rtHz; 60 to 80 mg, 3 %, 300 ug/rtHz; 0.6 uT a count. It moves 30 deg/s from -40 to 85 degrees C, 0.24 deg/s a
# degree, and some degrees on a body: a part of that. Magnetometer after a turn in the hand by the application.
# usual: Bosch BMI160 (3 deg/s, 0.007 deg/s/rtHz; 40 mg, 180 ug/rtHz) and ST LSM6DSO (1 deg/s; 20 mg) after a static
# calibration of the gyroscope in the factory of the wearable; BMM150: 0.3 uT a count.
# laboratory: Xsens MTi-1 (0.007 deg/s/rtHz, 10 deg/h, 120 ug/rtHz, 0.03 mg), whose gains are calibrated inside to
# about a tenth of a percent and whose offset of rate is 0.2 deg/s.
_DEVICES: Final = {
    "ideal": Device(Triad(), Triad(), Triad()),
    "laboratory": Device(
        Triad(0.08 * _DEG, 0.001, 0.0008, 0.007 * _DEG, 0.003 * _DEG, 0.02 * _DEG, 0.004 * _DEG, 0.01),
        Triad(2.0 * _MG, 0.0006, 0.0006, 0.12 * _MG, 0.03 * _MG, 0.5 * _MG, 0.1 * _MG, 0.01),
        Triad(0.3 * _UT, 0.004, 0.003, 0.02 * _UT, 0.02 * _UT, 0.0, 0.025 * _UT, 0.01),
        0.001 * _DEG / GRAVITY_MPS2,
    ),
    "usual": Device(
        Triad(0.5 * _DEG, 0.005, 0.004, 0.007 * _DEG, 0.006 * _DEG, 0.15 * _DEG, 0.061 * _DEG),
        Triad(10.0 * _MG, 0.004, 0.004, 0.18 * _MG, 0.06 * _MG, 2.0 * _MG, 0.49 * _MG),
        Triad(1.2 * _UT, 0.01, 0.008, 0.06 * _UT, 0.05 * _UT, 0.0, 0.3 * _UT),
        0.02 * _DEG / GRAVITY_MPS2,
    ),
    "consumer": Device(
        Triad(2.0 * _DEG, 0.012, 0.008, 0.01 * _DEG, 0.015 * _DEG, 0.8 * _DEG, 0.061 * _DEG),
        Triad(28.0 * _MG, 0.012, 0.008, 0.3 * _MG, 0.15 * _MG, 5.0 * _MG, 0.49 * _MG),
        Triad(4.0 * _UT, 0.03, 0.02, 0.1 * _UT, 0.1 * _UT, 0.0, 0.6 * _UT),
        0.1 * _DEG / GRAVITY_MPS2,
    ),
}
_DRIFT_S: Final = 100.0
_WARM_S: Final = (60.0, 600.0)
_OPEN_BAND_HZ: Final = 100.0
"""Bandwidth of a device that takes single samples: its noise does not shrink with the rate."""
_CLIP_SHARE: Final = (0.6, 0.95)
_LEAST_RATE_RADPS: Final = float(np.radians(125.0))
_LEAST_FORCE_MPS2: Final = 2.0 * GRAVITY_MPS2


@dataclass(frozen=True)
class Readings:
    """Samples of one sensor, each shape (K, 3), and the ends of its ranges where something is cut off."""

    gyroscope_radps: Float
    accelerometer_mps2: Float
    magnetometer_t: Float
    gyroscope_clip_radps: float | None = None
    accelerometer_clip_mps2: float | None = None


def read(conditions: Conditions, true: Readings, generator: np.random.Generator) -> Readings:
    """Return what a device of the drawn grade reads of the true quantities.

    Parameters
    ----------
    true : Readings
        What an ideal device reads.

    Returns
    -------
    Readings
        A range is the end of what a triad can read before its calibration; None where nothing is cut off.
    """
    device = _DEVICES[conditions.grade]
    leak = device.g_sensitivity_sps * generator.normal(size=(3, 3))
    rate = true.gyroscope_radps + true.accelerometer_mps2 @ leak.T
    gyroscope, rate_clip = _triad(
        conditions,
        device.gyroscope,
        rate,
        generator,
        _LEAST_RATE_RADPS,
        is_cut=conditions.clip == "gyroscope",
    )
    accelerometer, force_clip = _triad(
        conditions,
        device.accelerometer,
        true.accelerometer_mps2,
        generator,
        _LEAST_FORCE_MPS2,
        is_cut=conditions.clip == "accelerometer",
    )
    magnetometer, _ = _triad(
        conditions, device.magnetometer, true.magnetometer_t, generator, np.inf, is_cut=False
    )
    return Readings(gyroscope, accelerometer, magnetometer, rate_clip, force_clip)


def _triad(
    conditions: Conditions,
    triad: Triad,
    true: Float,
    generator: np.random.Generator,
    least_range: float,
    *,
    is_cut: bool,
) -> tuple[Float, float | None]:
    """Return readings of three axes, and the end of their range where it cuts something off."""
    time_s = np.arange(len(true)) / conditions.rate_hz
    gains = np.eye(3) + np.diag(triad.scale * generator.normal(size=3))
    gains += triad.cross * generator.normal(size=(3, 3)) * (1.0 - np.eye(3))
    values = true @ gains.T + triad.offset * generator.normal(size=3)
    values += _drift(triad.drift, len(true), 1.0 / conditions.rate_hz, generator)
    warmth = 1.0 - np.exp(-time_s / generator.uniform(*_WARM_S))
    values += warmth[:, None] * (conditions.is_warming * triad.warming * generator.normal(size=3))
    band_hz = 0.5 * conditions.rate_hz
    if not conditions.is_averaging:
        band_hz = max(band_hz, _OPEN_BAND_HZ)
    values += triad.density * np.sqrt(band_hz) * generator.normal(size=values.shape)
    calibration = np.eye(3) + np.diag(triad.calibration * generator.normal(size=3))
    raw = values @ np.linalg.inv(calibration).T
    level = max(least_range, generator.uniform(*_CLIP_SHARE) * float(np.abs(raw).max()))
    is_cut = is_cut and level < float(np.abs(raw).max())
    if triad.count > 0.0:
        raw = triad.count * np.rint(raw / triad.count)
    if is_cut:
        raw = np.clip(raw, -level, level)
    return raw @ calibration.T, level if is_cut else None


def _drift(sigma: float, count: int, step_s: float, generator: np.random.Generator) -> Float:
    """Return offsets that wander: a Gauss-Markov process of the given standard deviation, shape (count, 3)."""
    held = np.exp(-step_s / _DRIFT_S)
    pushes = generator.normal(size=(count, 3)) * np.sqrt(1.0 - held**2)
    pushes[0] = generator.normal(size=3)
    return np.asarray(sigma * signal.lfilter([1.0], [1.0, -held], pushes, axis=0))
