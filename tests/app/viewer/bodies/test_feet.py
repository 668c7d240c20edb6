"""Feet in the 3D view: prints where a foot stood, the base of support, shoes that point to their toes."""

from dataclasses import replace

import numpy as np
import pytest

from app.viewer.figure.surface import Mesh
from app.viewer.layers.feet import feet_of, support_outline
from app.viewer.layers.feet_layer import shoe_mesh
from app.viewer.layers.feet_live import LiveCourse
from estimators import rotation
from estimators.pipelines import Frames, SessionSetup, create

STEP_M, STEP_TICKS, STEPS = 0.7, 60, 3
HEADING = 0.3


@pytest.fixture
def frames() -> Frames:
    """Return both feet taking three strides each, in turn, along x; toes point 0.3 rad to the left."""
    layout = create(SessionSetup("gait", ("foot_left", "foot_right"), 100.0)).layout
    ticks = 2 * STEP_TICKS * STEPS + STEP_TICKS
    time = np.arange(ticks)
    place = np.zeros((ticks, 2, 3))
    stands = np.ones((ticks, 2))
    for foot in range(2):
        place[:, foot, 1] = 0.1 - 0.2 * foot
        for step in range(STEPS):
            start = (2 * step + foot) * STEP_TICKS
            share = np.clip((time - start) / STEP_TICKS, 0.0, 1.0)
            place[:, foot, 0] += STEP_M * share
            stands[(share > 0.0) & (share < 1.0), foot] = 0.0
    scalar = np.full((ticks, len(layout.scalars)), np.nan)
    for foot, name in enumerate(("foot_left", "foot_right")):
        scalar[:, layout.scalars.index(f"{name}_stance")] = stands[:, foot]
    q = np.broadcast_to(rotation.about_z(HEADING), (ticks, 2, 4)).copy()
    return Frames(
        layout,
        0,
        0.01,
        q,
        place,
        np.empty((ticks, 0)),
        np.empty((ticks, 0)),
        scalar,
        np.zeros((ticks, 2), dtype=np.uint8),
        np.empty((ticks, 0), dtype=np.uint8),
    )


def test_every_place_where_a_foot_stood_has_one_print(frames: Frames) -> None:
    track = feet_of(frames)
    assert track is not None
    assert track.sides == ("left", "right")
    for foot in range(2):
        prints = [one for one in track.prints if one.foot == foot]
        assert [one.place_m[0] for one in prints] == pytest.approx([STEP_M * k for k in range(STEPS + 1)])
        assert [one.heading_rad for one in prints] == pytest.approx([HEADING] * (STEPS + 1))
    # The picture goes along without the steps.
    assert np.abs(np.diff(track.followed_m[:, 0])).max() < STEP_M / STEP_TICKS
    assert track.mass_m is None


def test_the_base_of_support_spans_the_feet_that_stand(frames: Frames) -> None:
    track = feet_of(frames)
    assert track is not None
    both = support_outline(track, 0)
    assert both[:, 1].max() > 0.1
    assert both[:, 1].min() < -0.1
    swing = support_outline(track, STEP_TICKS // 2)
    assert swing[:, 1].max() < 0.1
    nobody = replace(track, stands=np.zeros_like(track.stands))
    assert len(support_outline(nobody, 0)) == 0


def test_live_feet_walk_one_course_wherever_their_sensors_point(frames: Frames) -> None:
    """Each foot's world is turned by its own angle, and the sensors sit askew on the shoes."""
    place, q = frames.point_room_m.copy(), frames.q_room_segment.copy()
    askew = rotation.exp([0.4, -0.2, 1.1])
    for foot, angle in enumerate((0.5, -0.8)):
        turn = rotation.about_z(angle)
        place[:, foot] = rotation.rotate(turn, place[:, foot])
        q[:, foot] = rotation.multiply(rotation.multiply(turn, q[:, foot]), askew)
    course = LiveCourse()
    for start in range(0, frames.tick_count, 7):
        part = slice(start, start + 7)
        chunk = replace(
            frames,
            first_tick=start,
            point_room_m=place[part],
            q_room_segment=q[part],
            scalar=frames.scalar[part],
            segment_flags=frames.segment_flags[part],
        )
        track = feet_of(chunk)
        assert track is not None
        shown = course.turned(track)
    for foot in range(2):
        prints = [one for one in shown.prints if one.foot == foot]
        way = np.array(prints[-1].place_m) - np.array(prints[0].place_m)
        assert way[:2] == pytest.approx([STEPS * STEP_M, 0.0], abs=1e-5)
        # The shoe lies flat and points along the course, as it did when it first stood.
        assert shown.wxyz[-1, foot] == pytest.approx([1.0, 0.0, 0.0, 0.0], abs=1e-5)
        assert shown.place_m[-1, foot] == pytest.approx(prints[-1].place_m, abs=1e-5)


def test_shoes_are_closed_and_mirrored() -> None:
    volumes = []
    for side in ("left", "right"):
        vertices, faces = shoe_mesh(side)
        edges = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
        assert (np.unique(edges, axis=0, return_counts=True)[1] == 2).all()
        volumes.append(Mesh(vertices, faces).volume_m3)
    assert volumes[0] == pytest.approx(volumes[1], rel=1e-4)
    assert 0.0005 < volumes[0] < 0.003


def test_an_arm_has_no_feet() -> None:
    layout = create(SessionSetup("arm", ("upper_arm_right",), 100.0)).layout
    assert "foot_left_stance" not in layout.scalars
