"""Which wrong readings a movement shows is decided by the movement, not by what finds them."""

import numpy as np

from estimators.recording import Recording, SensorSignals
from estimators.signals import to_common_ticks
from validation.orientation.wrong_inputs import _changes, _Movement

RATE_HZ = 50.0


def movement(speed_radps: float) -> _Movement:
    """Turning to and fro about x, with truth: gravity turns in y and z."""
    time_s = np.arange(1500) / RATE_HZ
    angle = speed_radps * np.sin(time_s)
    truth = np.stack([np.cos(angle / 2), np.sin(angle / 2), 0 * angle, 0 * angle], axis=1)
    rate = np.stack([speed_radps * np.cos(time_s), 0 * angle, 0 * angle], axis=1)
    force = 9.81 * np.stack([0 * angle, np.sin(angle), np.cos(angle)], axis=1)
    recording = Recording(
        {"imu": SensorSignals(time_s, rate, force)}, RATE_HZ, reference={"q_earth_sensor": truth}
    )
    return _Movement(recording, to_common_ticks(recording, RATE_HZ))


def shown(found: _Movement) -> set[int]:
    """Numbers of the changes of gyroscope axes that the movement shows."""
    axes = [change for kind, triad, change in _changes() if triad == "gyroscope" and "axes" in kind]
    axes += [change for kind, triad, change in _changes() if triad == "gyroscope" and "axis" in kind]
    return {number for number, change in enumerate(axes) if found.shows("gyroscope", change)}


def test_a_rest_shows_no_axes_and_a_turn_those_it_turns_about():
    assert shown(movement(0.0)) == set()
    # Swaps of x with y and x with z, x reversed, and all reversed; y with z, y and z do not turn.
    assert shown(movement(1.5)) == {0, 1, 3, 6}
