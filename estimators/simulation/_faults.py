"""Faults of devices, on recordings: saturation, dead sensors, wrong clocks, samples that never came.

Pure functions: each returns a new recording and leaves the given one alone. Magnets are part of the scene
(`ArmScenario.magnets`), since their field depends on where the sensor is; faults of the link are in
`_delivery`.
"""

from dataclasses import replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from estimators import rotation
from estimators.errors import SetupError
from estimators.recording import Recording, SensorSignals

Float = NDArray[np.float64]


def saturate(
    recording: Recording,
    placement: str,
    *,
    gyroscope_radps: float = np.inf,
    accelerometer_mps2: float = np.inf,
) -> Recording:
    """Clip one sensor at lower levels than it has, as a device set to the wrong range does."""
    signals = _sensor(recording, placement)
    return _with(
        recording,
        placement,
        replace(
            signals,
            gyroscope_radps=np.clip(signals.gyroscope_radps, -gyroscope_radps, gyroscope_radps),
            accelerometer_mps2=np.clip(signals.accelerometer_mps2, -accelerometer_mps2, accelerometer_mps2),
        ),
    )


def kill_sensor(
    recording: Recording,
    placement: str,
    start_s: float,
    end_s: float = np.inf,
    mode: Literal["silent", "stuck", "zero"] = "silent",
) -> Recording:
    """Let one sensor fail in `[start_s, end_s)`.

    Parameters
    ----------
    mode : str
        `silent` sends nothing, `stuck` repeats its last sample, `zero` sends zeros.
    """
    signals = _sensor(recording, placement)
    dead = (signals.time_s >= start_s) & (signals.time_s < end_s)
    if mode == "silent":
        return drop_samples(recording, placement, dead)
    first = int(np.argmax(dead)) if dead.any() else 0

    def failed(values: Float) -> Float:
        result = values.copy()
        result[dead] = 0.0 if mode == "zero" else values[max(first - 1, 0)]
        return result

    field = signals.magnetometer_t
    return _with(
        recording,
        placement,
        SensorSignals(
            signals.time_s,
            failed(signals.gyroscope_radps),
            failed(signals.accelerometer_mps2),
            None if field is None else failed(field),
        ),
    )


def turn_in_strap(
    recording: Recording,
    placement: str,
    at_s: float,
    turn_rad: tuple[float, float, float],
    lasts_s: float = 0.3,
) -> Recording:
    """Let one sensor turn on its segment and stay so: from then on it reads everything in turned axes.

    Parameters
    ----------
    at_s : float
        Middle of the turn.
    turn_rad : (float, float, float)
        Rotation vector in the axes that the sensor had before.
    lasts_s : float
        From rest to rest; the gyroscope feels it.
    """
    signals = _sensor(recording, placement)
    u = np.clip((signals.time_s - at_s) / lasts_s + 0.5, 0.0, 1.0)
    share = u**3 * (10.0 - 15.0 * u + 6.0 * u**2)
    turn = np.array(turn_rad)
    back = rotation.conjugate(rotation.exp(share[:, None] * turn))
    own = np.gradient(share, signals.time_s)[:, None] * turn
    field = signals.magnetometer_t
    return _with(
        recording,
        placement,
        replace(
            signals,
            gyroscope_radps=rotation.rotate(back, signals.gyroscope_radps) + own,
            accelerometer_mps2=rotation.rotate(back, signals.accelerometer_mps2),
            magnetometer_t=None if field is None else rotation.rotate(back, field),
        ),
    )


def drop_samples(recording: Recording, placement: str, is_lost: NDArray[np.bool_]) -> Recording:
    """Take samples away, shape (N,) true where lost; at least one must stay."""
    signals = _sensor(recording, placement)
    if is_lost.shape != signals.time_s.shape or is_lost.all():
        raise SetupError(
            f"is_lost has shape {is_lost.shape}; give one truth value for each of "
            f"{signals.time_s.size} samples and leave at least one"
        )
    keep = ~is_lost
    field = signals.magnetometer_t
    return _with(
        recording,
        placement,
        SensorSignals(
            signals.time_s[keep],
            signals.gyroscope_radps[keep],
            signals.accelerometer_mps2[keep],
            None if field is None else field[keep],
        ),
    )


def skew_stamps(recording: Recording, placement: str, skew_ppm: float, offset_s: float = 0.0) -> Recording:
    """Let one sensor's clock run fast by `skew_ppm` and start `offset_s` late; the samples stay."""
    signals = _sensor(recording, placement)
    return _with(
        recording, placement, replace(signals, time_s=signals.time_s * (1.0 + 1e-6 * skew_ppm) + offset_s)
    )


def jitter_stamps(recording: Recording, placement: str, sd_s: float, seed: int) -> Recording:
    """Disturb one sensor's time stamps, normal and cut off where neighbours would meet; samples stay."""
    signals = _sensor(recording, placement)
    limit = 0.45 * float(np.diff(signals.time_s).min(initial=np.inf))
    shift = np.clip(np.random.default_rng([seed, 9]).normal(size=signals.time_s.size) * sd_s, -limit, limit)
    return _with(recording, placement, replace(signals, time_s=signals.time_s + shift))


def _sensor(recording: Recording, placement: str) -> SensorSignals:
    if placement not in recording.sensors:
        raise SetupError(
            f"the recording has no sensor {placement!r}; it has {', '.join(recording.placements)}"
        )
    return recording.sensors[placement]


def _with(recording: Recording, placement: str, signals: SensorSignals) -> Recording:
    return replace(recording, sensors=recording.sensors | {placement: signals})
