"""From a device's own time stamps to a common tick, and the filters that everybody needs."""

from typing import Any

import numpy as np
import scipy
from numpy.typing import ArrayLike, NDArray

from estimators import rotation
from estimators._time_base import ON_THE_TICK, TimeBase, bridge, interpolate
from estimators.conventions import GRAVITY_MPS2
from estimators.errors import SetupError, ShapeError
from estimators.recording import Float, ImuChunk, Recording, SampleQuality, SensorSignals
from estimators.sentences import say

BRIDGE_S = 0.2
"""The longest stretch without samples that is interpolated."""
_CLIP_SHARE = 0.999
_TICKS_A_SAMPLE = 50
_TICKS_BEYOND = 1_000_000
"""A recording may hold pauses of hours; stamps that would ask for more ticks than this are wrong."""


def to_common_ticks(
    recording: Recording,
    rate_hz: float,
    *,
    gyroscope_clip_radps: float | None = None,
    accelerometer_clip_mps2: float | None = None,
    bridge_s: float = BRIDGE_S,
) -> ImuChunk:
    """Bring all sensors of a recording to one even time base.

    Parameters
    ----------
    recording : Recording
        Each sensor on its own stamps, which may be uneven, late or have holes; NaN counts as a hole.
    rate_hz : float
        The common rate.
    gyroscope_clip_radps, accelerometer_clip_mps2 : float, optional
        Clip levels of the devices: ticks that use a sample at this level are marked SATURATED.
    bridge_s : float
        Missing stretches up to this long are interpolated and marked BRIDGED, longer ones are NaN and
        MISSING, as is the time before the first and after the last sample of a sensor.

    Returns
    -------
    ImuChunk
        From the first to the last sample of any sensor. The first tick is the earliest sample; its
        number is that sample's time in ticks, rounded, so the grid may lie up to half a tick off zero.

    Raises
    ------
    SetupError
        If the recording has no samples or the rate cannot be used.

    Notes
    -----
    Across a short gap gyroscope and accelerometer follow a cubic with the slopes of the samples beside it
    (`bridge`), the magnetometer the chord. A sensor that is even at `rate_hz` passes bit for bit. Otherwise
    values are interpolated linearly; where the sensor is much faster than the ticks, the mean of that line
    over one tick is taken, which keeps the angle that the gyroscope turned through.
    """
    if not (np.isfinite(rate_hz) and 1.0 <= rate_hz <= 10_000.0):
        raise SetupError(say("recording.tick_rate", rate_hz=rate_hz))
    sensors = [_without_holes(sensor) for sensor in recording.sensors.values()]
    filled = [sensor for sensor in sensors if sensor.time_s.size]
    if not filled:
        raise SetupError(say("recording.no_samples"))
    start_s = min(float(sensor.time_s[0]) for sensor in filled)
    end_s = max(float(sensor.time_s[-1]) for sensor in filled)
    span = np.floor((end_s - start_s) * rate_hz + ON_THE_TICK) + 1.0
    samples = max(sensor.time_s.size for sensor in filled)
    if span > _TICKS_A_SAMPLE * samples + _TICKS_BEYOND:
        raise SetupError(say("recording.span", span_s=end_s - start_s, samples=samples))
    ticks = int(span)
    shape = (len(sensors), ticks, 3)
    gyroscope, accelerometer = np.full(shape, np.nan), np.full(shape, np.nan)
    magnetometer = np.full(shape, np.nan)
    quality = np.full(shape[:2], int(SampleQuality.MISSING), dtype=np.uint8)
    for s, sensor in enumerate(sensors):
        if not sensor.time_s.size:
            continue
        position = (sensor.time_s - start_s) * rate_hz
        base = TimeBase(position, ticks, bridge_s * rate_hz, 1.0 / rate_hz)
        clipped = at_clip(sensor.gyroscope_radps, gyroscope_clip_radps)
        clipped |= at_clip(sensor.accelerometer_mps2, accelerometer_clip_mps2)
        gyroscope[s], accelerometer[s] = (
            base.take(sensor.gyroscope_radps, curved=True),
            base.take(sensor.accelerometer_mps2, curved=True),
        )
        quality[s] = base.quality(clipped)
        if sensor.magnetometer_t is not None:
            measured = np.isfinite(sensor.magnetometer_t).all(axis=1)
            if measured.any():
                field_base = (
                    base if measured.all() else TimeBase(position[measured], ticks, bridge_s * rate_hz)
                )
                magnetometer[s] = field_base.take(sensor.magnetometer_t[measured])
    return ImuChunk(
        first_tick=round(start_s * rate_hz),
        time_step_s=1.0 / rate_hz,
        gyroscope_radps=gyroscope,
        accelerometer_mps2=accelerometer,
        magnetometer_t=magnetometer if np.isfinite(magnetometer).any() else None,
        quality=quality,
    )


def _without_holes(sensor: SensorSignals) -> SensorSignals:
    """Leave out samples whose gyroscope or accelerometer is not finite: they are gaps."""
    finite = np.isfinite(sensor.gyroscope_radps).all(axis=1) & np.isfinite(sensor.accelerometer_mps2).all(
        axis=1
    )
    if finite.all():
        return sensor
    field = sensor.magnetometer_t
    return SensorSignals(
        sensor.time_s[finite],
        sensor.gyroscope_radps[finite],
        sensor.accelerometer_mps2[finite],
        None if field is None else field[finite],
    )


def at_clip(values: Float, clip: float | None) -> NDArray[np.bool_]:
    """Return which samples, shape (..., 3) to (...), touch the clip level of their device."""
    if clip is None:
        return np.zeros(values.shape[:-1], dtype=np.bool_)
    return np.asarray(np.any(np.abs(values) >= _CLIP_SHARE * clip, axis=-1))


def interpolate_rotations(time_s: ArrayLike, q: ArrayLike, new_time_s: ArrayLike) -> Float:
    """Interpolate quaternions at constant rate between samples, shape (N, 4) to (K, 4); ends are held."""
    time, table = np.asarray(time_s, dtype=np.float64), np.asarray(q, dtype=np.float64)
    if time.size == 1:
        return np.repeat(table, np.size(new_time_s), axis=0)
    at = np.clip(np.asarray(new_time_s, dtype=np.float64), time[0], time[-1])
    i = np.clip(np.searchsorted(time, at, side="right") - 1, 0, time.size - 2)
    return rotation.slerp(table[i], table[i + 1], (at - time[i]) / (time[i + 1] - time[i]))


def _second_order_sections(cutoff_hz: float, rate_hz: float, order: int) -> NDArray[Any]:
    if not 0.0 < cutoff_hz < 0.5 * rate_hz:
        raise SetupError(
            f"cut-off {cutoff_hz} Hz; it must lie between 0 and half the rate, {0.5 * rate_hz} Hz"
        )
    return np.asarray(scipy.signal.butter(order, cutoff_hz, fs=rate_hz, output="sos"))


def low_pass(values: ArrayLike, rate_hz: float, cutoff_hz: float, order: int = 2, axis: int = -2) -> Float:
    """Smooth without delay: a Butterworth filter there and back.

    Parameters
    ----------
    values : array_like
        Finite; time along `axis`.
    rate_hz, cutoff_hz : float
        -6 dB of both passes together.
    order : int
        Of each pass.

    Raises
    ------
    ShapeError
        For values that are not finite: fill gaps first.
    """
    table = np.asarray(values, dtype=np.float64)
    if not np.isfinite(table).all():
        raise ShapeError("a filter without delay needs finite values; fill or cut out the gaps first")
    sections = _second_order_sections(cutoff_hz, rate_hz, order)
    padding = min(table.shape[axis] - 1, 3 * (2 * order + 1))
    return np.asarray(scipy.signal.sosfiltfilt(sections, table, axis=axis, padlen=max(padding, 0)))


def derivative(
    values: ArrayLike, rate_hz: float, window_s: float = 0.5, order: int = 3, axis: int = -2
) -> Float:
    """Differentiate by local polynomials (Savitzky and Golay), without delay.

    Parameters
    ----------
    values : array_like
        Time along `axis`, evenly sampled.
    window_s : float
        Length of the polynomial pieces; shortened where the record is shorter.

    Returns
    -------
    ndarray, same shape, per second
    """
    table = np.asarray(values, dtype=np.float64)
    longest = table.shape[axis] - (1 - table.shape[axis] % 2)
    window = min(max(2 * round(0.5 * window_s * rate_hz) + 1, order + 1 + (order % 2)), longest)
    if window <= order:
        raise ShapeError(f"{table.shape[axis]} samples are too few for a derivative of order {order}")
    return np.asarray(
        scipy.signal.savgol_filter(table, window, order, deriv=1, delta=1.0 / rate_hz, axis=axis)
    )


def stillness(
    gyroscope_radps: Float,
    accelerometer_mps2: Float,
    rate_hz: float,
    *,
    window_s: float = 0.5,
    gyroscope_limit_radps: float = np.deg2rad(3.0),
    accelerometer_limit_mps2: float = 0.4,
) -> NDArray[np.bool_]:
    """Find when a sensor was held still, from spread within a centred window.

    Parameters
    ----------
    gyroscope_radps, accelerometer_mps2 : ndarray, shape (..., K, 3)
    gyroscope_limit_radps, accelerometer_limit_mps2 : float
        Largest standard deviation, root of the sum over axes, inside the window. The mean of the
        gyroscope is its bias and does not count; the mean norm of specific force must be near gravity.

    Returns
    -------
    ndarray of bool, shape (..., K)
        False where anything in the window is not finite.
    """
    half = max(1, round(0.5 * window_s * rate_hz))
    rate_spread, _ = _moving_spread(gyroscope_radps, half)
    force_spread, force_mean = _moving_spread(accelerometer_mps2, half)
    near_gravity = np.abs(np.linalg.norm(force_mean, axis=-1) - GRAVITY_MPS2) < 0.1 * GRAVITY_MPS2
    return np.asarray(
        (rate_spread <= gyroscope_limit_radps) & (force_spread <= accelerometer_limit_mps2) & near_gravity
    )


def _moving_spread(values: Float, half: int) -> tuple[Float, Float]:
    """Return root-summed standard deviation (..., K) and mean (..., K, 3) over 2 half + 1 samples."""
    count = values.shape[-2]
    start = np.maximum(np.arange(count) - half, 0)
    stop = np.minimum(np.arange(count) + half + 1, count)
    width = (stop - start)[:, None]
    finite = np.isfinite(values).all(axis=-1, keepdims=True)
    held: Float = np.where(finite, values, 0.0)
    # Taken from the mean, the difference of sums below stays well conditioned.
    centre = np.asarray(held.mean(axis=-2, keepdims=True))

    def window_sum(table: Float) -> Float:
        total = np.concatenate((np.zeros_like(table[..., :1, :]), np.cumsum(table, axis=-2)), axis=-2)
        return np.asarray(total[..., stop, :] - total[..., start, :])

    centred = held - centre
    mean = window_sum(centred) / width
    variance = window_sum(centred * centred) / width - mean**2
    spread = np.sqrt(np.maximum(variance.sum(axis=-1), 0.0))
    holes = window_sum(np.asarray(~finite, dtype=np.float64))[..., 0] > 0.5
    return np.where(holes, np.inf, spread), mean + centre


__all__ = [
    "BRIDGE_S",
    "at_clip",
    "bridge",
    "derivative",
    "interpolate",
    "interpolate_rotations",
    "low_pass",
    "stillness",
    "to_common_ticks",
]
