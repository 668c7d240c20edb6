"""Whole recordings off-line: order and choice of sensors, the pose found or told, both passes."""

from dataclasses import replace

import numpy as np

from estimators import signals
from estimators.errors import SetupError
from estimators.pipelines import create, find_pose, run
from estimators.recording import Recording, SensorSignals
from tests.said import refuses


def test_run_calibrates_and_covers_everything(session):
    frames, setup = run(session.recording, session.setup)
    assert frames.tick_count == session.truth.frames.tick_count
    assert np.isfinite(frames.angle_rad).all()
    assert setup.calibration is not None
    told, _ = run(session.recording, session.setup, pose_s=(1.0, 5.0))
    assert np.isfinite(told.angle_rad).all()


def test_run_with_a_calibration_is_a_plain_pass(session):
    frames, setup = run(session.recording, session.setup)
    again, same = run(session.recording, setup)
    assert same == setup
    assert again.angle_rad.tobytes() == frames.angle_rad.tobytes()
    chunk = signals.to_common_ticks(session.recording, 100.0)
    assert create(setup).step(chunk).angle_rad.tobytes() == frames.angle_rad.tobytes()


def test_order_and_choice_follow_the_setup(session):
    worn = ("forearm_right", "upper_arm_right", "sternum")
    frames, _ = run(session.recording, replace(session.setup, placements=worn))
    assert frames.layout.segments == worn
    with refuses("setup.missing_sensors", error=SetupError, missing=["shank_left"]):
        run(session.recording, replace(session.setup, placements=(*worn, "shank_left")))


def test_another_rate(session):
    frames, _ = run(session.recording, replace(session.setup, rate_hz=50.0))
    assert frames.time_step_s == 0.02
    assert abs(frames.tick_count - session.truth.frames.tick_count / 2) <= 1


def test_pose_is_found_after_moving(session):
    """Cut so that the recording begins in the middle of a repetition: no pose, no guess."""
    start, stop = session.truth.repetitions_s[0]

    def cut(one, a, b):
        inside = (one.time_s >= a) & (one.time_s < b)
        return SensorSignals(
            one.time_s[inside] - a, *(x[inside] for x in (one.gyroscope_radps, one.accelerometer_mps2))
        )

    moving = Recording(
        {n: cut(s, start + 0.2, stop - 0.9) for n, s in session.recording.sensors.items()}, 100.0
    )
    with refuses("calibration.no_rest_found"):
        run(moving, session.setup)
    with refuses("calibration.pose_outside"):
        run(moving, session.setup, pose_s=(50.0, 60.0))
    first, last = find_pose(signals.to_common_ticks(session.recording, 100.0))
    assert 0 <= first < last <= 600
    assert last - first == 300


def test_single_sensors_need_no_pose(session):
    setup = replace(session.setup, pipeline="orientation", placements=("sternum",))
    frames, same = run(session.recording, setup)
    assert same.calibration is None
    assert frames.layout.angles == ()
