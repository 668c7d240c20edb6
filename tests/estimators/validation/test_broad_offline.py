"""What the off-line figures of BROAD are made of."""

import numpy as np
import pytest

from estimators import rotation
from estimators.recording import Recording, SensorSignals
from estimators.validation import _broad_offline as offline
from estimators.validation import protocols

RATE_HZ = 200.0


@pytest.fixture
def trial():
    rng = np.random.default_rng(3)
    ticks = 3000
    time_s = np.arange(ticks) / RATE_HZ
    imu = SensorSignals(
        time_s,
        0.01 * rng.standard_normal((ticks, 3)),
        np.array([0.0, 0.0, 9.81]) + 0.02 * rng.standard_normal((ticks, 3)),
        np.array([0.0, 20e-6, -45e-6]) + 0.2e-6 * rng.standard_normal((ticks, 3)),
    )
    reference = {"q_earth_sensor": rotation.identity((ticks,)), "is_movement": time_s >= 6.0}
    return Recording({"imu": imu}, RATE_HZ, reference=reference)


def test_drift_counts_from_the_start_of_the_movement(trial):
    ticks = len(trial.reference["q_earth_sensor"])
    turned_rad = np.where(np.arange(ticks) < 1200, 0.0, np.linspace(2.0, 4.0, ticks))
    slope = turned_rad[1200:] - turned_rad[1200]
    found = offline.heading_drift(trial, rotation.about_z(turned_rad))
    assert found == pytest.approx(np.sqrt(np.mean(slope**2)), rel=1e-9)
    assert offline.without_magnetometer(trial).sensors["imu"].magnetometer_t is None


def test_every_off_line_figure_is_measured(trial):
    protocol = next(p for p in protocols() if p.name == "broad_offline")
    values = protocol.measure(range(2), {"made up": trial})
    assert set(values) == {figure.name for figure in protocol.figures}
    assert values["smoother, total, mean of the trials"][0] < 0.5
    assert len(values["smoother, samples lost"]) == 2
