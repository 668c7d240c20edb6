"""Poses: the tree of relative rotations puts every joint where the estimator's points are."""

from dataclasses import replace

import numpy as np
import pytest
import viser

from app.viewer.figure.ghost import ghost_from_template
from app.viewer.figure.proportions import hip_half_width_m, hip_height_m, leg_lengths_m
from app.viewer.layers.nodes import halo_opacity, joint_offsets_m
from app.viewer.layers.seat import seat_height_m
from app.viewer.pose import (
    PARENT,
    SEGMENTS,
    PoseTrack,
    _complete,
    thinned,
    track_from_frames,
    track_from_room,
)
from app.viewer.scene import BodyScene
from estimators import rotation
from estimators.body import BodyDimensions
from estimators.conventions import SIDES
from estimators.orientation import OrientationFlag
from estimators.pipelines import Frames

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


def lowered(track: PoseTrack, segment: str, point_m: tuple[float, float, float]) -> np.ndarray:
    """Where a point of the seated figure is, its hips on the seat."""
    drop = hip_height_m(BODY) - hip_height_m(BODY, "seated")
    return place_in_room(track, 50, segment, point_m) - np.array([0.0, 0.0, drop])


def test_who_sits_has_hips_and_knees_at_right_angles_and_the_feet_on_the_floor(reaches) -> None:
    frames, _, _ = reaches
    track = track_from_frames(frames, BODY, "seated")
    thigh, shank, ankle = leg_lengths_m(BODY)
    half, knee_height = hip_half_width_m(BODY), shank + ankle
    for side, sign in (("left", 1.0), ("right", -1.0)):
        for segment, point, place in (
            ("thigh", (0, 0, 0), (0.0, sign * half, knee_height)),
            ("shank", (0, 0, 0), (thigh, sign * half, knee_height)),
            ("foot", (0, 0, 0), (thigh, sign * half, ankle)),
            ("foot", (0.1, 0, -ankle), (thigh + 0.1, sign * half, 0.0)),
        ):
            np.testing.assert_allclose(lowered(track, f"{segment}_{side}", point), place, atol=1e-5)
    # The arm that is measured does what it did: only as much lower as the hips are.
    standing = track_from_frames(frames, BODY)
    upper = [SEGMENTS.index(name) for name in SEGMENTS if not name.startswith(("thigh", "shank", "foot"))]
    assert np.array_equal(track.wxyz[:, upper], standing.wxyz[:, upper])


def test_measured_legs_win_over_the_posture_of_the_exercise() -> None:
    """A thigh lifted 20 degrees above the seat, a trunk turned by 30 degrees and bent by 10."""
    turned = rotation.about_z(np.radians(30.0))
    lifted = rotation.multiply(turned, rotation.about_y(np.radians(-110.0)))
    leaning = rotation.multiply(turned, rotation.about_y(np.radians(10.0)))
    room = _complete({"pelvis": leaning[None], "thigh_left": lifted[None]}, 1, "seated")
    np.testing.assert_allclose(room["thigh_left"][0], lifted)
    for segment, down in (
        ("thigh_right", [np.cos(np.radians(30.0)), np.sin(np.radians(30.0)), 0.0]),
        ("shank_left", [0.0, 0.0, -1.0]),
        ("shank_right", [0.0, 0.0, -1.0]),
    ):
        np.testing.assert_allclose(
            rotation.rotate(room[segment][0], np.array([0.0, 0.0, -1.0])), down, atol=1e-12
        )


def on_a_leg(frames: Frames, lifted_deg: float) -> Frames:
    """Add a sensor on the right thigh, which hangs for the first half and is then lifted so far."""
    ticks = frames.tick_count
    lifted = np.where(np.arange(ticks) < ticks // 2, 0.0, -np.radians(lifted_deg))
    thigh = np.stack([rotation.about_y(angle) for angle in lifted])[:, None]
    return replace(
        frames,
        layout=replace(frames.layout, segments=(*frames.layout.segments, "thigh_right")),
        q_room_segment=np.concatenate([frames.q_room_segment, thigh], axis=1),
        segment_flags=np.concatenate(
            [frames.segment_flags, np.zeros_like(frames.segment_flags[:, :1])], axis=1
        ),
    )


def test_who_still_stands_before_a_seated_exercise_is_drawn_standing(reaches) -> None:
    """A thigh that hangs is of nobody who sits: its foot would be below the floor, and the other leg in the air."""
    frames = on_a_leg(reaches[0], 80.0)
    track = track_from_frames(frames, BODY, "seated")
    half = frames.tick_count // 2
    assert track.stands is not None
    assert track.stands[:half].all()
    assert not track.stands[half:].any()
    knee = SEGMENTS.index("shank_left")
    np.testing.assert_allclose(track.wxyz[0, knee], rotation.identity(), atol=1e-6)
    assert rotation.angle_between(track.wxyz[-1, knee].astype(float), rotation.identity()) > np.radians(85)
    assert track_from_frames(reaches[0], BODY, "seated").stands is None, "no thigh says so"
    assert track_from_frames(frames, BODY).stands is None
    server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
    try:
        scene = BodyScene(server, BODY, frozenset(), posture="seated")
        scene.draw(track, 0)
        assert (scene.posture, scene.exercise_posture) == ("standing", "seated")
        scene.draw(track, frames.tick_count - 1)
        assert scene.posture == "seated"
    finally:
        server.stop()


def test_a_scene_sits_on_its_seat_and_stands_up_for_the_pose(reaches) -> None:
    """The numbers that go to the browser: the frame of the hips, the seat, the template."""
    _, template, _ = reaches
    server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
    try:
        ghost = ghost_from_template(template, BODY, "right")
        scene = BodyScene(server, BODY, frozenset(), None, ghost.track, "right", "seated")
        handles = server.scene._handle_from_node_name
        sitting = hip_height_m(BODY, "seated")
        assert handles["/patient"].position[2] == pytest.approx(sitting)
        assert handles["/template"].position[2] == pytest.approx(sitting - hip_height_m(BODY))
        assert handles["/seat"].visible
        hips = handles["/patient/pelvis/trousers"]
        assert hips.vertices[:, 2].min() + sitting == pytest.approx(seat_height_m(BODY))
        scene.sit(False)
        assert scene.posture == "standing"
        assert handles["/patient"].position[2] == pytest.approx(hip_height_m(BODY))
        assert not handles["/seat"].visible
        assert hips.vertices[:, 2].min() + sitting < seat_height_m(BODY) - 0.1
    finally:
        server.stop()
