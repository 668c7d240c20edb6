"""The ghost of a leg: whole, where the template's joints are, and seen by its foot."""

from dataclasses import replace

import numpy as np
import pytest

from app.viewer.figure.ghost import Ghost, ghost_from_template
from app.viewer.figure.ghost_leg import foot_points_m, leg_bones, skinned_leg
from app.viewer.figure.ghost_node import limb_points_m
from app.viewer.figure.proportions import hip_half_width_m, leg_lengths_m
from app.viewer.pose import SEGMENTS
from estimators import rotation
from estimators.body import BodyDimensions, body_from_stature
from estimators.comparison import PHASES, Template

BODY = BodyDimensions()
PHASE = np.linspace(0.0, 1.0, PHASES)
HIP, KNEE = np.radians(80.0) + 0.0 * PHASE, np.radians(85.0 - 70.0 * np.sin(np.pi * PHASE) ** 2)


def template(names: dict[str, np.ndarray], primary: str) -> Template:
    mean = np.stack(list(names.values()), axis=1)
    return Template(
        channels=tuple(names),
        mean=mean,
        tolerance=np.full_like(mean, 0.1),
        duration_s=3.0,
        duration_sd_s=0.1,
        repetition_count=5,
        primary_channel=primary,
        side="right",
        reach_m=0.55,
        measures={},
        measure_sd={},
    )


EXTENSION = template(
    {"pelvis_thigh_right_zxy_flexion": HIP, "thigh_shank_right_zxy_flexion": KNEE},
    "thigh_shank_right_zxy_flexion",
)


@pytest.fixture(scope="module")
def ghost() -> Ghost:
    return ghost_from_template(EXTENSION, BODY, "right", "seated")


@pytest.mark.parametrize("body", [BODY, body_from_stature(1.2)])
def test_the_skin_is_closed_and_every_vertex_has_its_bones(body: BodyDimensions) -> None:
    leg = skinned_leg(body, "left")
    faces = leg.mesh.faces.astype(np.int64)
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    assert np.array_equal(
        np.sort(edges[:, 0] * 10**7 + edges[:, 1]), np.sort(edges[:, 1] * 10**7 + edges[:, 0])
    )
    assert leg.mesh.volume_m3 > 0
    assert leg.weights.shape == (len(leg.mesh.vertices_m), 3)
    np.testing.assert_allclose(leg.weights.sum(axis=1), 1.0, atol=1e-5)
    assert (leg.weights >= 0).all()
    assert -leg.mesh.vertices_m[:, 2].min() == pytest.approx(sum(leg_lengths_m(body)), abs=0.02)


def test_the_joints_are_where_the_angles_put_them(ghost: Ghost) -> None:
    """In closed form: thigh and shank in a plane beside the middle of the body."""
    assert ghost.limb == "leg"
    thigh, shank, _ = leg_lengths_m(BODY)
    _, places = leg_bones(ghost.track, BODY, "right")
    across = np.full(PHASES, -hip_half_width_m(BODY))
    knee = np.stack([thigh * np.sin(HIP), across, -thigh * np.cos(HIP)], axis=1)
    ankle = knee + shank * np.stack([np.sin(HIP - KNEE), 0 * HIP, -np.cos(HIP - KNEE)], axis=1)
    np.testing.assert_allclose(places[:, 1], knee, atol=1e-5)
    np.testing.assert_allclose(places[:, 2], ankle, atol=1e-5)
    np.testing.assert_allclose(foot_points_m(ghost.track, BODY, "right")[:, 0], ankle, atol=1e-5)
    points = limb_points_m(ghost.track, BODY, "right", "leg")
    assert np.ptp(points[:, 0, 2]) > 0.2


def test_the_other_leg_gets_the_mirror_image(ghost: Ghost) -> None:
    other = ghost_from_template(EXTENSION, BODY, "left", "seated")
    _, mirrored = leg_bones(other.track, BODY, "left")
    _, places = leg_bones(ghost.track, BODY, "right")
    np.testing.assert_allclose(mirrored * [1, -1, 1], places, atol=1e-6)


def test_a_knee_without_a_hip_bends_below_the_thigh_of_the_posture() -> None:
    bare = replace(
        EXTENSION,
        channels=EXTENSION.channels[1:],
        mean=EXTENSION.mean[:, 1:],
        tolerance=EXTENSION.tolerance[:, 1:],
    )
    for posture, hip in (("seated", 90.0), ("standing", 0.0)):
        track = ghost_from_template(bare, BODY, "right", posture).track  # type: ignore[arg-type]
        thigh = track.wxyz[:, SEGMENTS.index("thigh_right")].astype(float)
        assert np.degrees(rotation.angle_between(thigh, rotation.identity())) == pytest.approx(hip, abs=1e-3)
        shank = track.wxyz[:, SEGMENTS.index("shank_right")].astype(float)
        np.testing.assert_allclose(rotation.angle_between(shank, rotation.identity()), KNEE, atol=1e-5)
