"""A source on the left shoe: both feet in one frame, step width without a start mould."""

from functools import cache

import numpy as np
import pytest

from estimators import pipelines, rotation
from estimators.errors import SetupError, ShapeError
from estimators.magnetic import coil_state
from estimators.magnetic.relative import layout as at
from estimators.pipelines import (
    SessionSetup,
    apart_at_start,
    relative_feet,
    relative_source,
    with_relative_feet,
)
from estimators.recording import ImuChunk, Recording, SensorSignals
from estimators.simulation.coils import SourceFaults, relative_motion, relative_scene, run_closed_loop

SHOES = {"coil_radius_m": 0.075, "current_a": 1.36}
SETUP = SessionSetup("relative_pose", ("foot_left", "foot_right"), 120.0, orientation_parameters=SHOES)
GAIT = SessionSetup("gait", ("foot_left", "foot_right"), 120.0)


@cache
def walked(seconds=25.0, faults=None):
    scene = relative_scene(
        relative_source(SETUP).coils, relative_motion("feet", seconds, 1), seconds, 120.0, seed=1
    )
    one = pipelines.create(SETUP).filters["foot_right"]
    _, samples = run_closed_loop(scene, one, faults or SourceFaults(), 1)
    state = np.zeros((2, len(samples)))
    state[0] = coil_state(samples[:, at.COIL].astype(int), samples[:, at.CURRENT])
    chunk = ImuChunk(
        0,
        1.0 / 120.0,
        np.stack([scene.source_gyroscope_radps, scene.gyroscope_radps]),
        np.stack([scene.source_accelerometer_mps2, scene.accelerometer_mps2]),
        np.stack([scene.source_ambient_t, samples[:, at.FIELD : at.FIELD + 3]]),
        np.zeros((2, len(samples)), dtype=np.uint8),
        coil_state=state,
    )
    sensors = {
        name: SensorSignals(scene.time_s, chunk.gyroscope_radps[i], chunk.accelerometer_mps2[i])
        for i, name in enumerate(GAIT.placements)
    }
    return scene, chunk, pipelines.analyse_walk(Recording(sensors, 120.0), GAIT)


def test_steps_and_both_feet_in_one_frame():
    scene, chunk, walk = walked()
    assert walk.steps is None
    related = with_relative_feet(walk, relative_feet(chunk, SETUP))
    width = related.steps["step_width"]
    assert width.count > 20
    # The simulated feet walk 18 cm apart; spread is that of a person who never varies.
    assert width.value == pytest.approx(0.18, abs=0.008)
    assert np.hypot(width.value - 0.18, width.spread) < 0.010
    assert apart_at_start(related) == pytest.approx(0.18, abs=0.02)
    # In one frame: what is between the feet at any moment is what was simulated, seen from the course.
    frames = related.frames
    between = frames.point_room_m[:, 1] - frames.point_room_m[:, 0]
    true = rotation.rotate(scene.q_world_source, scene.position_m)[: len(between)]
    late = slice(600, None)
    error = between[late] - true[late]
    assert np.sqrt(np.mean(np.sum(error[:, :2] ** 2, axis=1))) < 0.03
    np.testing.assert_allclose(np.linalg.norm(frames.q_room_segment, axis=-1), 1.0)


def test_the_source_may_be_on_either_shoe_and_both_are_needed():
    _, chunk, _ = walked()
    with pytest.raises(SetupError, match="other"):
        relative_feet(chunk, SessionSetup("relative_pose", ("pelvis", "foot_right"), 120.0))
    with pytest.raises(ShapeError, match="first tick"):
        relative_feet(chunk.ticks(5, 100), SETUP)


def test_a_silent_source_relates_nothing():
    _, chunk, walk = walked(seconds=15.0, faults=SourceFaults(silent_from_s=6.0))
    with pytest.raises(ShapeError, match="too few"):
        with_relative_feet(walk, relative_feet(chunk, SETUP))
