"""Cameras: presets show the whole person at any shape of picture, keys walk around and never under the floor."""

import numpy as np
import pytest

from app.viewer.camera import FIELD_OF_VIEW_RAD, Camera, preset
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
