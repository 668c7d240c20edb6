"""A standing pose held against what elbows and raised arms can do, on exact motion."""

import math
from dataclasses import replace

import numpy as np
import pytest

from estimators import rotation
from estimators.arm.published import elbow_from_angles
from estimators.calibration import Calibration, Postures, judged_by_movement, raisings
from estimators.conventions import SIDES, Placement
from estimators.recording import Float
from estimators.simulation._sensors import outward_mounting
from tests.said import codes

STEP_S = 0.1
BOTH: tuple[Placement, ...] = (
    "sternum",
    "upper_arm_left",
    "forearm_left",
    "upper_arm_right",
    "forearm_right",
)
RIGHT: tuple[Placement, ...] = ("sternum", "upper_arm_right", "forearm_right")


def moves(
    names: tuple[Placement, ...], *, least_deg: float = 5.0, most_deg: float = 130.0, raised_deg: float = 85.0
) -> Postures:
    """Segments of somebody who bends the elbows and raises the arms forward and outward, a minute long."""
    time_s = np.arange(0.0, 60.0, STEP_S)
    bend = 0.5 - 0.5 * np.cos(2.0 * np.pi * time_s / 5.0)
    lift = np.radians(raised_deg) * (0.5 - 0.5 * np.cos(2.0 * np.pi * time_s / 7.0))
    q = {"sternum": rotation.exp(np.stack([0 * bend, 0.1 * bend, 0 * bend], axis=1))}
    for side in SIDES:
        outward = np.radians(40.0) * np.sin(2.0 * np.pi * time_s / 23.0) * (1.0 if side == "left" else -1.0)
        # Raised forward, then turned outward about the vertical.
        upper = rotation.multiply(
            rotation.about_z(outward), rotation.exp(np.stack([0 * lift, -lift, 0 * lift], axis=1))
        )
        flexion = np.radians(least_deg + (most_deg - least_deg) * bend)
        carrying = np.full_like(flexion, np.radians(6.0))
        elbow = elbow_from_angles(flexion, carrying, np.radians(80.0) + 0.3 * bend, side)
        q[f"upper_arm_{side}"], q[f"forearm_{side}"] = upper, rotation.multiply(upper, elbow)
    return Postures(names, np.stack([q[name] for name in names], axis=1), STEP_S)


def misread(q: Float, off_rad: float) -> Float:
    """What a wrong direction of the patient in the pose makes of a segment."""
    return rotation.multiply(rotation.about_z(-off_rad), rotation.multiply(q, rotation.about_z(off_rad)))


def by_pose(names: tuple[Placement, ...], off_rad: float = 0.0, **turned_deg: float) -> Calibration:
    """A calibration whose direction is off; sensors face as the rule has it, but for those turned about the body."""
    mounted = {}
    for name in names:
        turn = rotation.about_z(math.radians(turned_deg.get(name, 0.0)))
        true = rotation.conjugate(rotation.multiply(turn, outward_mounting(name)))
        w, x, y, z = rotation.multiply(true, rotation.about_z(off_rad))
        mounted[name] = (float(w), float(x), float(y), float(z))
    sigma = dict.fromkeys(names, (0.01, 0.01, 0.07))
    return Calibration(mounted, {}, facing_rad=0.3 + off_rad, mounting_sigma_rad=sigma)


def seen(true: Postures, off_rad: float) -> Postures:
    return replace(true, q_room_segment=misread(true.q_room_segment, off_rad))


@pytest.mark.parametrize("names", [BOTH, RIGHT])
def test_a_sound_pose_stays_as_it_is(names: tuple[Placement, ...]) -> None:
    known = by_pose(names)
    assert judged_by_movement(known, moves(names)) is known


@pytest.mark.parametrize("names", [BOTH, RIGHT])
def test_a_chest_sensor_back_to_front_is_turned(names: tuple[Placement, ...]) -> None:
    true = moves(names)
    found = judged_by_movement(by_pose(names, math.pi, sternum=180.0), seen(true, math.pi))
    assert codes(found.reasons) == ["placement.back_to_front"]
    assert found.reasons[0].parameters["where"] == ["sternum"]  # type: ignore[attr-defined]
    assert math.remainder(found.facing_rad - 0.3, 2.0 * math.pi) == pytest.approx(0.0, abs=1e-9)
    assert found.contradicted == ()
    right = by_pose(names, 0.0, sternum=180.0)
    for name in names:
        away = rotation.angle_between(
            np.array(found.q_sensor_segment[name]), np.array(right.q_sensor_segment[name])
        )
        assert float(away) < 1e-6
    # Judged once more there is nothing left to say.
    assert judged_by_movement(found, true) is found


@pytest.mark.parametrize("side_deg", [90.0, -90.0, 110.0])
def test_a_chest_sensor_on_the_side_is_turned_as_far_as_the_elbow_shows(side_deg: float) -> None:
    off = math.radians(side_deg)
    found = judged_by_movement(by_pose(RIGHT, off, sternum=side_deg), seen(moves(RIGHT), off))
    assert codes(found.reasons) == ["placement.faced_away"]
    away = math.remainder(found.facing_rad - 0.3, 2.0 * math.pi)
    assert abs(away) < math.radians(15.0)
    assert found.mounting_sigma_rad["forearm_right"][2] > math.radians(10.0)


def test_arms_any_way_round_need_to_be_raised() -> None:
    """Nothing else says where the patient faced: bent elbows alone may be those of a pose with bent elbows."""
    odd = {"upper_arm_right": 70.0, "forearm_right": -80.0, "sternum": 180.0}
    known = by_pose(RIGHT, math.pi, **odd)
    raised = judged_by_movement(known, seen(moves(RIGHT), math.pi))
    assert codes(raised.reasons) == ["placement.back_to_front"]
    hanging = judged_by_movement(known, seen(moves(RIGHT, raised_deg=20.0), math.pi))
    assert codes(hanging.reasons) == ["placement.elbow_impossible"]
    assert hanging.contradicted == RIGHT


def posed_bent(true: Postures, bent_deg: float) -> Postures:
    """What is read after a pose in which the right elbow was bent."""
    q = true.q_room_segment.copy()
    straight, bent = (
        elbow_from_angles(np.radians(angle), 0.0, np.radians(80.0), "right") for angle in (0.0, bent_deg)
    )
    column = true.names.index("forearm_right")
    q[:, column] = rotation.multiply(q[:, column], rotation.multiply(rotation.conjugate(bent), straight))
    return replace(true, q_room_segment=q)


@pytest.mark.parametrize(("least_deg", "most_deg"), [(20.0, 130.0), (10.0, 88.0)])
def test_an_elbow_bent_in_the_pose_is_no_chest_sensor_back_to_front(
    least_deg: float, most_deg: float
) -> None:
    true = moves(BOTH, least_deg=least_deg, most_deg=most_deg)
    found = judged_by_movement(by_pose(BOTH), posed_bent(true, 90.0))
    assert codes(found.reasons) == ["placement.elbow_impossible"]
    assert found.reasons[0].parameters["angle_rad"] < math.radians(-55.0)  # type: ignore[attr-defined]
    # The other arm says that the patient faced as was assumed.
    assert found.contradicted == ("upper_arm_right", "forearm_right")
    assert found.score <= 0.3
    assert judged_by_movement(found, posed_bent(true, 90.0)) is found


def test_a_sensor_without_compass_is_doubted_and_never_turned() -> None:
    known = replace(by_pose(RIGHT), heading_offset_rad=dict.fromkeys(RIGHT, 0.0))
    true = moves(RIGHT)
    q = true.q_room_segment.copy()
    q[:, 2] = misread(q[:, 2], math.pi)
    found = judged_by_movement(known, replace(true, q_room_segment=q))
    assert codes(found.reasons) == ["placement.elbow_impossible"]
    assert found.contradicted == ("upper_arm_right", "forearm_right")
    assert found.facing_rad == known.facing_rad


def test_a_person_who_turns_round_is_not_accused() -> None:
    true = moves(BOTH)
    turned = rotation.multiply(
        rotation.about_z(np.linspace(0.0, 4.0 * np.pi, len(true.q_room_segment)))[:, None],
        true.q_room_segment,
    )
    for names in (BOTH, BOTH[1:]):
        columns = [BOTH.index(name) for name in names]
        known = by_pose(names)
        assert judged_by_movement(known, Postures(names, turned[:, columns], STEP_S)) is known


def test_a_chest_sensor_without_compass_is_doubted_by_a_deep_bow() -> None:
    """As in a real recording of a person who sits down: the arms hang, and the trunk seems to lean back."""
    bow = np.radians(75.0) * (0.5 - 0.5 * np.cos(np.arange(0.0, 60.0, STEP_S)))
    nothing = np.zeros_like(bow)
    trunk = rotation.exp(np.stack([nothing, bow, nothing], axis=1))
    hanging = np.broadcast_to([1.0, 0.0, 0.0, 0.0], (len(bow), 4))
    elbow = elbow_from_angles(nothing + 0.1, nothing, nothing + 1.4, "right")
    known = replace(by_pose(RIGHT), heading_offset_rad=dict.fromkeys(RIGHT, 0.0))
    sound = Postures(RIGHT, np.stack([trunk, hanging, elbow], axis=1), STEP_S)
    assert judged_by_movement(known, sound) is known
    q = sound.q_room_segment.copy()
    q[:, 0] = misread(q[:, 0], math.pi)
    found = judged_by_movement(known, replace(sound, q_room_segment=q))
    assert codes(found.reasons) == ["placement.trunk_backward"]
    assert found.contradicted == ("sternum",)


def test_what_movements_measured_is_left_alone() -> None:
    known = replace(by_pose(RIGHT, math.pi), method="functional")
    assert judged_by_movement(known, seen(moves(RIGHT), math.pi)) is known


def test_an_arm_is_judged_from_the_chest_and_not_from_the_pelvis() -> None:
    """Held sideways while the chest turns by 50 degrees over the pelvis, an arm seems to be behind the pelvis."""
    sideways = rotation.exp(np.array([-math.radians(90.0), 0.0, 0.0]))
    upper = rotation.multiply(rotation.about_z(-math.radians(50.0)), sideways)
    q = np.tile(np.stack((np.array([1.0, 0.0, 0.0, 0.0]), upper)), (100, 1, 1))
    (of_chest,) = raisings(("sternum", "upper_arm_right"), q, STEP_S)
    assert of_chest.is_wrong
    assert raisings(("pelvis", "upper_arm_right"), q, STEP_S) == ()
