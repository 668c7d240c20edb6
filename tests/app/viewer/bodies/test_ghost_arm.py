"""The ghost's skin: it follows the same joints as the patient's tree, and is whole."""

import numpy as np
import pytest

from app.viewer.figure.ghost_arm import BONES, bone_track, skinned_arm
from app.viewer.figure.ghost_node import dashed
from app.viewer.figure.proportions import hip_height_m
from app.viewer.pose import track_from_frames
from estimators import rotation
from estimators.body import BodyDimensions, body_from_stature

BODY = BodyDimensions()


@pytest.mark.parametrize("body", [BODY, body_from_stature(1.2)])
def test_the_skin_is_closed_and_every_vertex_has_its_bones(body) -> None:
    arm = skinned_arm(body, "left")
    faces = arm.mesh.faces.astype(np.int64)
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    assert np.array_equal(
        np.sort(edges[:, 0] * 10**7 + edges[:, 1]), np.sort(edges[:, 1] * 10**7 + edges[:, 0])
    )
    assert arm.mesh.volume_m3 > 0
    assert arm.weights.shape == (len(arm.mesh.vertices_m), BONES)
    np.testing.assert_allclose(arm.weights.sum(axis=1), 1.0, atol=1e-5)
    assert (arm.weights >= 0).all()


def skinned(
    vertices: np.ndarray, weights: np.ndarray, joints: np.ndarray, wxyz: np.ndarray, place: np.ndarray
):
    """Linear blend skinning as a browser does it."""
    parts = [rotation.rotate(wxyz[b], vertices - joints[b]) + place[b] for b in range(BONES)]
    return np.einsum("vb,bvi->vi", weights, np.stack(parts))


def test_the_skin_reaches_where_the_estimators_hand_is(reaches) -> None:
    """The middle finger's tip lies within a finger's thickness of the end of the hand, and the elbow's skin around
    the elbow, in every posture: bent and pronated."""
    frames, _, _ = reaches
    track = track_from_frames(frames, BODY)
    wxyz, place = bone_track(track, BODY, "right")
    arm = skinned_arm(BODY, "right")
    hip = np.array([0, 0, hip_height_m(BODY)])
    points = frames.layout.points
    height = arm.mesh.vertices_m[:, 2]
    fingertips = height < height.min() + 0.01
    around_elbow = np.abs(height + BODY.upper_arm_m) < 0.005
    for tick in range(0, len(track), 23):
        skin = skinned(arm.mesh.vertices_m, arm.weights, arm.joints_m, wxyz[tick], place[tick]) + hip
        hand = frames.point_room_m[tick, points.index("hand_right")]
        elbow = frames.point_room_m[tick, points.index("elbow_right")]
        assert np.linalg.norm(skin[fingertips].mean(axis=0) - hand) < 0.03
        assert np.linalg.norm(skin[around_elbow].mean(axis=0) - elbow) < 0.015


def test_the_forearm_turns_along_its_length(reaches) -> None:
    """A quarter turn is shared out evenly: none at the elbow, half in the middle, all at the wrist."""
    frames, _, _ = reaches
    wxyz, _ = bone_track(track_from_frames(frames, BODY), BODY, "right")
    none, half, whole = wxyz[0, 1], wxyz[0, 2], wxyz[0, 3]
    total = rotation.angle_between(none, whole)
    assert np.degrees(total) == pytest.approx(86, abs=3)  # pronation of 1.5 rad
    assert rotation.angle_between(none, half) == pytest.approx(total / 2, abs=1e-3)


def test_dashes_are_even_and_leave_a_way_back_over_the_same_ground_away() -> None:
    out = np.linspace([0, 0, 0], [0.5, 0, 0.3], 50).astype(np.float32)
    there_and_back = dashed(np.concatenate([out, out[::-1]]))
    np.testing.assert_allclose(there_and_back, dashed(out))
    lengths = np.linalg.norm(there_and_back[:, 1] - there_and_back[:, 0], axis=1)
    np.testing.assert_allclose(lengths, 0.015, atol=1e-5)
    loop = np.stack([0.3 * np.cos(a := np.linspace(0, 2 * np.pi, 100)), 0.3 * np.sin(a), 0 * a], axis=1)
    assert len(dashed(loop.astype(np.float32))) > 60


def test_an_unknown_path_has_no_dashes() -> None:
    assert len(dashed(np.full((101, 3), np.nan, np.float32))) == 0
