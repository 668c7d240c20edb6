"""Mounting and heading of an arm from ordinary movement, against exact motion."""

import numpy as np
import pytest

from estimators import rotation
from estimators.arm.published import elbow_from_angles
from estimators.calibration import elbow_from_movement
from estimators.errors import ShapeError
from tests.said import refuses

RATE_HZ = 20.0


def arm(side, seconds=60.0, seed=2, bend=1.0):
    """Exact segments of an arm that moves about; the first two seconds stand in the N-pose."""
    rng = np.random.default_rng(seed)
    time_s = np.arange(round(seconds * RATE_HZ)) / RATE_HZ
    grow = np.clip((time_s - 2.0) / 3.0, 0.0, 1.0)

    def wander(size):
        return (
            grow
            * size
            * sum(np.sin(2 * np.pi * rng.uniform(0.05, 0.3) * time_s + rng.uniform(0, 6)) for _ in range(3))
        )

    flexion = grow * bend * np.radians(60) + bend * wander(np.radians(20))
    pronation = np.pi / 2 + wander(np.radians(18))
    upper = rotation.exp(np.stack((wander(0.25), wander(0.35), wander(0.3)), axis=1))
    carrying = np.full_like(time_s, np.radians(8)) * grow
    fore = rotation.multiply(upper, elbow_from_angles(flexion, carrying, pronation, side))
    return time_s, upper, fore


def misread(q, turn_rad):
    """What a wrong heading in the N-pose makes of a segment: it goes into the mounting too."""
    return rotation.multiply(rotation.about_z(-turn_rad), rotation.multiply(q, rotation.about_z(turn_rad)))


@pytest.mark.slow
@pytest.mark.parametrize("side", ["left", "right"])
@pytest.mark.parametrize(("upper_deg", "fore_deg"), [(55.0, -20.0), (-70.0, 10.0)])
def test_how_the_sensors_face_is_found(side, upper_deg, fore_deg):
    time_s, upper, fore = arm(side)
    seen = misread(upper, np.radians(upper_deg)), misread(fore, np.radians(fore_deg))
    found = elbow_from_movement(side, *seen, time_s, pose_s=1.0)
    assert np.degrees(found.upper_turn_rad) == pytest.approx(upper_deg, abs=8.0)
    turned = np.degrees(found.forearm_turn_rad)
    assert turned == pytest.approx(fore_deg, abs=9.0)
    assert np.degrees(found.residual_rad) < 3.0


@pytest.mark.slow
def test_drift_of_the_forearm_is_followed():
    time_s, upper, fore = arm("right")
    drift = np.radians(0.3) * time_s
    found = elbow_from_movement(
        "right", upper, rotation.multiply(rotation.about_z(-drift), fore), time_s, pose_s=1.0
    )
    seen = np.interp([10.0, 50.0], found.knots_s, found.forearm_turn_rad)
    assert np.degrees(seen[1] - seen[0]) == pytest.approx(12.0, abs=4.0)


def test_a_straight_arm_tells_nothing():
    time_s, upper, fore = arm("right", bend=0.05)
    with refuses("calibration.elbow_hardly_bent"):
        elbow_from_movement("right", upper, fore, time_s)
    with pytest.raises(ShapeError):
        elbow_from_movement("right", upper[:5], fore, time_s)
