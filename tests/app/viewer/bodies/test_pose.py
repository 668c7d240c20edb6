"""Poses: the tree of relative rotations puts every joint where the estimator's points are."""

import numpy as np
import pytest

from app.viewer.figure.proportions import hip_height_m
from app.viewer.layers.nodes import halo_opacity, joint_offsets_m
from app.viewer.pose import PARENT, SEGMENTS, PoseTrack, thinned, track_from_frames, track_from_room
from estimators import rotation
from estimators.body import BodyDimensions
from estimators.conventions import SIDES
from estimators.orientation import OrientationFlag

BODY = BodyDimensions()


def place_in_room(
    track: PoseTrack, tick: int, segment: str, point_m: tuple[float, float, float]
) -> np.ndarray:
    """Follow the tree as the browser does."""
    offsets = joint_offsets_m(BODY)
    place = np.array(point_m)
    name: str | None = segment
    while name is not None:
        place = rotation.rotate(track.wxyz[tick, SEGMENTS.index(name)], place)
        offset = np.array(offsets[name])
        for number, side in enumerate(SIDES):
            if name == f"upper_arm_{side}":
                offset = track.shoulder_m[tick, number]
        place = place + offset
        name = PARENT[name]
    return place + np.array([0.0, 0.0, hip_height_m(BODY)])


def test_joints_and_hand_lie_where_the_estimator_says(reaches) -> None:
    """Chain of float32 rotations against the estimator's float64 points: micrometres; 0.1 mm is generous."""
    frames, _, _ = reaches
    track = track_from_frames(frames, BODY)
    points = frames.layout.points
    for tick in range(0, len(track), 17):
        for point, segment, offset in (
            ("shoulder_right", "upper_arm_right", (0, 0, 0)),
            ("elbow_right", "forearm_right", (0, 0, 0)),
            ("wrist_right", "hand_right", (0, 0, 0)),
            ("hand_right", "hand_right", (0, 0, -BODY.hand_m)),
        ):
            expected = frames.point_room_m[tick, points.index(point)]
            np.testing.assert_allclose(place_in_room(track, tick, segment, offset), expected, atol=1e-4)


def test_a_hiked_shoulder_moves_its_arm(reaches) -> None:
    frames, _, _ = reaches
    column = frames.layout.points.index("shoulder_right")
    raised = frames.point_room_m.copy()
    raised[:, column, 2] += 0.04
    moved = track_from_frames(type(frames)(**{**vars(frames), "point_room_m": raised}), BODY)
    still = track_from_frames(frames, BODY)
    rise = np.linalg.norm(moved.shoulder_m[:, 1] - still.shoulder_m[:, 1], axis=-1)
    np.testing.assert_allclose(rise, 0.04, atol=1e-4)


def test_what_carries_no_sensor_hangs_or_stands(reaches) -> None:
    frames, _, _ = reaches
    track = track_from_frames(frames, BODY)
    left = place_in_room(track, 0, "hand_left", (0, 0, -BODY.hand_m))
    assert left[2] < hip_height_m(BODY)
    assert left[1] > 0.18
    assert place_in_room(track, 50, "foot_left", (0, 0, 0))[2] == pytest.approx(0.066, abs=0.002)


def test_lost_segments_are_marked_and_hold_their_last_pose(reaches) -> None:
    frames, _, _ = reaches
    flags, q = frames.segment_flags.copy(), frames.q_room_segment.copy()
    flags[60:90, 2] = OrientationFlag.INVALID
    q[60:90, 2] = np.nan
    track = track_from_frames(
        type(frames)(**{**vars(frames), "segment_flags": flags, "q_room_segment": q}), BODY
    )
    lost = track.lost[:, SEGMENTS.index("forearm_right")]
    assert lost[60:90].all()
    assert not lost[:60].any()
    assert not lost[90:].any()
    assert np.isfinite(track.wxyz).all()
    assert not track.lost[:, SEGMENTS.index("hand_right")].any()


def test_before_the_calibration_the_person_just_stands(reaches) -> None:
    """Sensors that do not know how they sit would twist the body."""
    frames, _, _ = reaches
    points = np.full_like(frames.point_room_m, np.nan)
    track = track_from_frames(type(frames)(**{**vars(frames), "point_room_m": points}), BODY)
    standing = track_from_room({}, frames.time_s, BODY)
    np.testing.assert_allclose(track.wxyz, standing.wxyz, atol=1e-6)


def test_halo_grows_from_the_elbow_to_the_hand(reaches) -> None:
    frames, _, _ = reaches
    halo = track_from_frames(frames, BODY).halo_m
    assert (halo[:, 1, 1] > halo[:, 1, 0]).all()
    assert (halo[:, 1, 0] > 0).all()
    assert (halo[:, 0] == 0).all()


def test_a_wider_halo_has_the_same_paint_over_more_room() -> None:
    assert halo_opacity(0.005) == 0.0
    assert halo_opacity(0.02) == halo_opacity(0.05) > 0.0
    assert halo_opacity(0.10) == pytest.approx(halo_opacity(0.05) / 2)
    assert halo_opacity(0.2) == 0.0


def test_thinning_keeps_time_and_at_least_the_rate(reaches) -> None:
    frames, _, _ = reaches
    fast = type(frames)(**{**vars(frames), "time_step_s": 1 / 250})
    thin = thinned(fast)
    assert 60 <= 1 / thin.time_step_s <= 120
    np.testing.assert_allclose(thin.time_s, fast.time_s[::4], atol=1e-9)
    assert thinned(frames) is frames
