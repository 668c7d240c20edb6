"""Cameras: presets show the whole person at any shape of picture, keys walk around and never under the floor."""

import numpy as np
import pytest

from app.viewer.camera import FIELD_OF_VIEW_RAD, Camera, best_sight, preset
from app.viewer.figure.proportions import hip_half_width_m, hip_height_m, leg_lengths_m
from app.viewer.stage import limb_of
from estimators.body import BodyDimensions, body_from_stature


def in_picture(camera: Camera, point: tuple[float, float, float], aspect: float) -> bool:
    position, look_at = np.array(camera.position_m), np.array(camera.look_at_m)
    forward = (look_at - position) / np.linalg.norm(look_at - position)
    right = np.cross(forward, [0, 0, 1])
    right /= np.linalg.norm(right)
    up = np.cross(right, forward)
    offset = np.array(point) - position
    depth = offset @ forward
    tangent = np.tan(0.5 * FIELD_OF_VIEW_RAD)
    return bool(
        depth > 0 and abs(offset @ up) < depth * tangent and abs(offset @ right) < depth * tangent * aspect
    )


@pytest.mark.parametrize("aspect", [0.5, 1.0, 1.6, 2.4])
@pytest.mark.parametrize("name", ["start", "front", "side"])
@pytest.mark.parametrize("body", [BodyDimensions(), body_from_stature(1.2), body_from_stature(2.0)])
def test_crown_feet_and_outstretched_hand_are_in_the_picture(name, body, aspect: float) -> None:
    camera = preset(name, body, "right", aspect)
    reach = body.upper_arm_m + body.forearm_m + body.hand_m
    shoulder = 0.818 * body.stature_m
    points = [(0, 0, body.stature_m), (0, 0, 0)]
    points.append(
        (reach, -0.5 * body.shoulder_width_m, shoulder) if name == "side" else (0, -reach * 0.75, shoulder)
    )
    for point in points:
        assert in_picture(camera, point, aspect), (point, camera)


def test_the_arm_that_matters_is_on_the_near_side() -> None:
    for side, sign in (("left", 1), ("right", -1)):
        for name in ("start", "front", "side", "arm"):
            assert sign * preset(name, BodyDimensions(), side, 1.4).position_m[1] > 0


@pytest.mark.parametrize("aspect", [0.7, 1.0, 1.6])
@pytest.mark.parametrize("side", ["left", "right"])
@pytest.mark.parametrize("posture", ["standing", "seated"])
def test_near_to_a_leg_the_whole_leg_is_in_the_picture_and_the_head_is_not(posture, side, aspect) -> None:
    body = BodyDimensions()
    camera = preset("arm", body, side, aspect, posture=posture, limb="leg")
    thigh, shank, ankle = leg_lengths_m(body)
    sign = 1.0 if side == "left" else -1.0
    across, hip = sign * hip_half_width_m(body), hip_height_m(body, posture)
    bent = [(0, across, hip), (0, across, hip - thigh), (0.15, across, 0)]
    moved = [(0, across + sign * 0.5 * (thigh + shank), 0.35)]
    if posture == "seated":
        bent = [(0, across, hip), (thigh, across, hip), (thigh + 0.15, across, 0)]
        moved = [(thigh + shank + ankle, across, hip)]
    for point in (*bent, *moved):
        assert in_picture(camera, point, aspect), (point, camera)
    assert not in_picture(camera, (0, 0, hip + 0.45 * body.stature_m), aspect)
    assert preset("arm", body, side, aspect, posture=posture).look_at_m[2] > camera.look_at_m[2] + 0.2


def test_what_is_measured_says_whether_a_session_is_of_a_leg() -> None:
    assert limb_of({"sternum", "pelvis", "thigh_left", "shank_left"}) == "leg"
    assert limb_of({"sternum", "upper_arm_left", "thigh_left"}) == "arm"
    assert limb_of({"sternum"}) == "arm"


def test_from_above_forward_is_up_in_the_picture() -> None:
    camera = preset("top", BodyDimensions(), "right", 1.4)
    assert camera.position_m[2] > 3
    assert camera.position_m[0] < camera.look_at_m[0]
    assert camera.position_m[1] == pytest.approx(camera.look_at_m[1], abs=1e-9)


def test_steps_turn_rise_and_come_nearer() -> None:
    camera = Camera((3.0, 0.0, 1.0), (0.0, 0.0, 1.0))
    turned = camera.stepped(90.0, 0.0, 1.0)
    np.testing.assert_allclose(turned.position_m, (0.0, 3.0, 1.0), atol=1e-9)
    assert camera.stepped(0.0, 30.0, 1.0).position_m[2] == pytest.approx(1.0 + 3.0 * np.sin(np.radians(30)))
    nearer = camera.stepped(0.0, 0.0, 2.0)
    assert np.linalg.norm(np.subtract(nearer.position_m, nearer.look_at_m)) == pytest.approx(1.5)


def test_steps_stop_at_the_pole_the_floor_and_the_body() -> None:
    camera = Camera((3.0, 0.0, 1.0), (0.0, 0.0, 1.0))
    for _ in range(50):
        camera = camera.stepped(0.0, 20.0, 1.5)
    assert np.linalg.norm(np.subtract(camera.position_m, camera.look_at_m)) >= 0.6 - 1e-9
    assert np.hypot(camera.position_m[0], camera.position_m[1]) > 0.01
    for _ in range(50):
        camera = camera.stepped(0.0, -20.0, 0.5)
    assert camera.position_m[2] > 0.0


def moved(direction: list[float], side: str, length_m: float = 0.5) -> np.ndarray:
    """A hand that goes straight out and back, shape (101, 1, 3)."""
    there = np.sin(np.linspace(0.0, np.pi, 101))[:, None] * length_m
    sign = 1.0 if side == "left" else -1.0
    return (there * (np.array(direction) * [1.0, sign, 1.0]))[:, None]


def pictured_m(points: np.ndarray, camera: Camera) -> float:
    """How far the hand goes in the picture plane of a camera, in metres there."""
    sight = np.subtract(camera.position_m, camera.look_at_m)
    sight /= np.linalg.norm(sight)
    across = points[:, 0] - np.outer(points[:, 0] @ sight, sight)
    return float(np.linalg.norm(np.ptp(across, axis=0)))


@pytest.mark.parametrize("side", ["left", "right"])
@pytest.mark.parametrize(
    ("direction", "lowest_deg", "highest_deg"),
    [
        ([1.0, 0.0, 0.0], 70.0, 90.0),
        ([0.0, 1.0, 0.0], 0.0, 20.0),
        ([0.0, 0.0, 1.0], 44.0, 44.0),
        ([0.7, -0.7, 0.0], 25.0, 60.0),
    ],
    ids=["sagittal", "frontal", "upward", "across the body"],
)
def test_a_movement_is_looked_at_from_where_it_is_large(direction, lowest_deg, highest_deg, side) -> None:
    """The picture shows a straight way as long as the best of all views does, but for 3 %, and never from behind."""
    points = moved(direction, side)
    sight = best_sight(points, side)
    assert lowest_deg <= sight.azimuth_deg <= highest_deg
    assert not sight.is_near
    body = BodyDimensions()
    shown = pictured_m(points, preset("movement", body, side, 1.0, sight=sight))
    best = max(pictured_m(points, preset("front", body, side, 1.0).stepped(a, 0.0, 1.0)) for a in range(360))
    assert shown >= 0.97 * min(best, 0.5)
    assert preset("movement", body, side, 1.0, sight=sight).position_m[0] > -0.5


def test_a_hand_that_only_turns_is_looked_at_from_near_along_the_forearm() -> None:
    angle = np.linspace(-1.5, 1.5, 101)
    thumb = np.stack([0 * angle, 0.09 * np.cos(angle), 0.09 * np.sin(angle)], axis=1)
    sight = best_sight(np.stack([0 * thumb, thumb], axis=1) + np.array([0.3, -0.2, 0.2]), "right")
    assert sight.is_near
    assert 0.0 <= sight.azimuth_deg < 44.0
    near = preset("movement", BodyDimensions(), "right", 1.0, sight=sight)
    far = preset("start", BodyDimensions(), "right", 1.0)
    assert np.linalg.norm(near.position_m) < np.linalg.norm(far.position_m)


def test_without_a_template_the_kind_of_movement_says_from_where() -> None:
    body = BodyDimensions()
    for movement, name in (("abduction", "front"), ("reaching", "side"), ("pronation", "arm"), ("", "start")):
        assert preset("movement", body, "left", 1.0, movement=movement) == preset(name, body, "left", 1.0)


@pytest.mark.parametrize("aspect", [0.5, 1.0, 1.6])
def test_who_sits_is_in_the_picture_and_still_is_standing_up(aspect: float) -> None:
    body = BodyDimensions()
    camera = preset("start", body, "right", aspect, posture="seated")
    seated_crown = body.stature_m - hip_height_m(body) + hip_height_m(body, "seated")
    for height in (0.0, seated_crown, body.stature_m):
        assert in_picture(camera, (0, 0, height), aspect)
    toes_m = leg_lengths_m(body)[0] + 0.24
    for name in ("start", "front", "side"):
        feet = preset(name, body, "right", aspect, posture="seated")
        for side in (-1.6, 1.6):
            assert in_picture(feet, (toes_m, side * hip_half_width_m(body), 0), aspect), name
    # While the movement is followed nobody stands up: nearer, with crown, feet and hand in the picture.
    hand = moved([0.5, -0.2, 0.4], "right", 1.0) + np.array([0.1, -0.2, 0.2])
    follow = preset("movement", body, "right", aspect, posture="seated", sight=best_sight(hand, "right"))
    hip = np.array([0.0, 0.0, hip_height_m(body, "seated")])
    for point in [(0, 0, seated_crown), (0, 0, 0), (0.36 * body.stature_m, 0, 0), *(hand[:, 0] + hip)]:
        assert in_picture(follow, point, aspect), point
    away = [np.linalg.norm(np.subtract(one.position_m, one.look_at_m)) for one in (follow, camera)]
    assert away[0] < away[1]
    near = preset("arm", body, "right", aspect, posture="seated")
    assert near.look_at_m[2] < preset("arm", body, "right", aspect).look_at_m[2]
