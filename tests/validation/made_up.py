"""A trial like those of BROAD, made up: a sensor at rest in a whole field, with noise."""

import numpy as np

from estimators import rotation
from estimators.recording import Recording, SensorSignals


def trial_at_rest(seed: int, ticks: int, rate_hz: float, moves_s: tuple[float, float]) -> Recording:
    """One sensor at rest with its truth; samples from the first to the second moment count as movement."""
    rng = np.random.default_rng(seed)
    time_s = np.arange(ticks) / rate_hz
    imu = SensorSignals(
        time_s,
        0.01 * rng.standard_normal((ticks, 3)),
        np.array([0.0, 0.0, 9.81]) + 0.02 * rng.standard_normal((ticks, 3)),
        np.array([0.0, 20e-6, -45e-6]) + 0.2e-6 * rng.standard_normal((ticks, 3)),
    )
    is_movement = (time_s >= moves_s[0]) & (time_s < moves_s[1])
    reference = {"q_earth_sensor": rotation.identity((ticks,)), "is_movement": is_movement}
    return Recording({"imu": imu}, rate_hz, reference=reference)
