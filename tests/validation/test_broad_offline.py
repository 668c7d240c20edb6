"""What the off-line figures of BROAD are made of."""

import numpy as np
import pytest

from estimators import rotation
from tests.validation.made_up import trial_at_rest
from validation import protocols
from validation.orientation import broad_offline as offline

RATE_HZ = 200.0


@pytest.fixture
def trial():
    return trial_at_rest(3, 3000, RATE_HZ, (6.0, 15.0))


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
