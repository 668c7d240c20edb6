"""Getting signals ready: one even time base with load cells, gaps, synchronisation, a lower leg's mounting."""

import numpy as np
import scipy
from numpy.typing import NDArray

from estimators import rotation
from estimators.errors import CalibrationError, SetupError, ShapeError
from estimators.kinetics._contact import stretches
from estimators.recording import Float, Recording, SensorSignals
from estimators.sentences import say
from estimators.signals import low_pass

LONGEST_GAP_SAMPLES = 15


def on_one_time_base(
    recording: Recording, names: tuple[str, ...], rate_hz: float, cutoff_hz: float = 15.0
) -> dict[str, SensorSignals]:
    """Bring sensors with load cells to one even time base.

    Parameters
    ----------
    recording : Recording
        Finite samples; inertial and load channels of one sensor share their stamps.
    cutoff_hz : float
        A sensor more than twice as fast is low-passed with this first, there and back, so that nothing above
        half the new rate is folded down.

    Returns
    -------
    dict of str to SensorSignals
        From the latest first sample to the earliest last one.

    Raises
    ------
    SetupError
        If a sensor is missing or they never measured at the same time.
    """
    missing = [name for name in names if name not in recording.sensors]
    if missing:
        raise SetupError(
            f"the recording has no sensor {', '.join(missing)}; it has {', '.join(recording.sensors)}"
        )
    sensors = {name: recording.sensors[name] for name in names}
    start = max(float(sensor.time_s[0]) for sensor in sensors.values())
    end = min(float(sensor.time_s[-1]) for sensor in sensors.values())
    count = int(np.floor((end - start) * rate_hz + 1e-6)) + 1
    if count < 2:
        raise SetupError("the sensors never measured at the same time")
    stamps = start + np.arange(count) / rate_hz

    def resampled(sensor: SensorSignals, values: Float | None) -> Float | None:
        if values is None:
            return None
        own_rate = float(1.0 / np.median(np.diff(sensor.time_s)))
        if own_rate > 2.0 * rate_hz:
            values = low_pass(values, own_rate, cutoff_hz, axis=0)
        return np.column_stack([np.interp(stamps, sensor.time_s, values[:, axis]) for axis in range(3)])

    result = {}
    for name, sensor in sensors.items():
        gyroscope = resampled(sensor, sensor.gyroscope_radps)
        accelerometer = resampled(sensor, sensor.accelerometer_mps2)
        assert gyroscope is not None
        assert accelerometer is not None
        result[name] = SensorSignals(
            stamps,
            gyroscope,
            accelerometer,
            resampled(sensor, sensor.magnetometer_t),
            resampled(sensor, sensor.force_n),
            resampled(sensor, sensor.moment_nm),
        )
    return result


def fill_gaps(values: Float, longest_samples: int = LONGEST_GAP_SAMPLES) -> tuple[Float, NDArray[np.bool_]]:
    """Fill short gaps with a cubic spline through all measured samples; before any filtering.

    Parameters
    ----------
    values : ndarray, shape (N, C)
        NaN where nothing was measured.
    longest_samples : int
        Longer gaps, and those at the ends, stay NaN: 15 samples were 0.3 s of markers.

    Returns
    -------
    (ndarray, shape (N, C), ndarray of bool, shape (N,))
        Filled values and where they were filled.

    Raises
    ------
    ShapeError
        If fewer than four samples were measured.
    """
    measured = np.asarray(np.isfinite(values).all(axis=1))
    if measured.sum() < 4:
        raise ShapeError("a spline needs at least four measured samples")
    at = np.arange(values.shape[0])
    curve = scipy.interpolate.CubicSpline(at[measured], values[measured], axis=0)
    filled = np.zeros(values.shape[0], dtype=np.bool_)
    for start, end in stretches(~measured):
        if start > 0 and end < values.shape[0] and end - start <= longest_samples:
            filled[start:end] = True
    result = np.where(measured[:, None], values, np.nan)
    result[filled] = curve(at[filled])
    return result, filled


def lag_s(first: Float, second: Float, rate_hz: float, longest_s: float = 5.0) -> float:
    """Return how much later `second` shows what `first` shows, by their largest correlation.

    Parameters
    ----------
    first, second : ndarray, shape (N,) and (M,)
        The same quantity from two systems, the turning of the lower leg say, at one rate.
    longest_s : float
        Where to look, both ways.

    Returns
    -------
    float
        Finer than a sample, by a parabola through the highest point and its neighbours.

    Raises
    ------
    ShapeError
        If a signal does not change or they are too short.
    """
    a, b = first - first.mean(), second - second.mean()
    if min(a.size, b.size) < 3 or not (a.any() and b.any()):
        raise ShapeError("two systems can only be laid over each other by a signal that changes")
    product = scipy.signal.correlate(b, a, method="fft")
    lags = scipy.signal.correlation_lags(b.size, a.size)
    near = np.flatnonzero(np.abs(lags) <= longest_s * rate_hz)
    best = int(near[np.argmax(product[near])])
    shift = 0.0
    if 0 < best < product.size - 1:
        before, top, after = product[best - 1 : best + 2]
        bend = before - 2.0 * top + after
        shift = 0.5 * float((before - after) / bend) if bend < 0.0 else 0.0
    return (float(lags[best]) + shift) / rate_hz


def shank_mounting(standing_accelerometer_mps2: Float, bending_gyroscope_radps: Float) -> Float:
    """Return `q_segment_sensor`, shape (4,), of a sensor on the lower leg.

    Parameters
    ----------
    standing_accelerometer_mps2 : ndarray, shape (N, 3)
        While the person stands upright: its mean is the long axis.
    bending_gyroscope_radps : ndarray, shape (M, 3)
        While the knee is bent and stretched, first bent: its main axis points left.

    Raises
    ------
    CalibrationError
        If the knee was not moved, not about one axis, or about the long axis; the message says what to redo.

    Notes
    -----
    Schepers (2009) section 2.2.4; the source does not say which of the two axes gives way: here the turning
    axis is made square to the long axis.
    """
    up = standing_accelerometer_mps2.mean(axis=0)
    up = up / np.linalg.norm(up)
    size, axes = np.linalg.eigh(
        bending_gyroscope_radps.T @ bending_gyroscope_radps / len(bending_gyroscope_radps)
    )
    if np.sqrt(size[2]) < 0.3:
        raise CalibrationError(say("calibration.knee_hardly_moved"))
    if size[1] > 0.2 * size[2]:
        raise CalibrationError(say("calibration.leg_two_axes"))
    left = axes[:, 2]
    if abs(float(left @ up)) > 0.5:
        raise CalibrationError(say("calibration.leg_twisted"))
    turned = bending_gyroscope_radps @ left
    # Bending moves the shank backward, toe down: positive about the axis that points left.
    angle = np.cumsum(turned)
    left = left if angle[np.argmax(np.abs(angle))] > 0.0 else -left
    forward = np.cross(left, up)
    forward = forward / np.linalg.norm(forward)
    return rotation.from_matrix(np.vstack((forward, np.cross(up, forward), up)))
