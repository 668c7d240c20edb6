"""Whole recordings with an off-line smoother: both pipelines, the pose, and no live use."""

from dataclasses import replace

import numpy as np
import pytest

from estimators import orientation, rotation, signals
from estimators.calibration import DeviceCalibration, TriadCalibration
from estimators.errors import SetupError
from estimators.pipelines import SessionSetup, create, run, smooth_network, step_through
from estimators.pipelines._offline import smoothed_chunk


@pytest.fixture(scope="module")
def setup(session):
    return replace(session.setup, orientation="telemotion_smoother")


@pytest.fixture(scope="module")
def smoothed(session, setup):
    return run(session.recording, setup)


def rms_deg(session, frames):
    truth = session.truth.frames
    apart = np.unwrap(frames.angle_rad - truth.angle_rad[: frames.tick_count], axis=0)
    sound = (frames.angle_flags & int(orientation.OrientationFlag.SINGULAR)) == 0
    return float(np.degrees(np.sqrt(np.mean((apart**2)[sound]))))


def test_the_arm_pipeline_runs_on_the_smoothed_session(session, setup, smoothed):
    frames, used = smoothed
    assert used.orientation == "telemotion_smoother"
    assert used.calibration is not None
    assert np.isfinite(frames.angle_rad).all()
    live, _ = run(session.recording, replace(setup, orientation="telemotion"))
    # Known to a tenth of a degree, the live filter is already at what mountings and soft tissue leave.
    assert rms_deg(session, frames) < 0.1 + rms_deg(session, live)
    assert rms_deg(session, frames) < 1.0


def test_segments_are_the_smoothers_orientations(session, setup):
    placements = setup.placements[:2]
    alone = SessionSetup("orientation", placements, 100.0, orientation="telemotion_smoother")
    frames, _ = run(session.recording, alone)
    worn = replace(session.recording, sensors={name: session.recording.sensors[name] for name in placements})
    chunk = signals.to_common_ticks(worn, 100.0)
    found = orientation.smooth("telemotion_smoother", chunk).orientation
    apart = rotation.angle_between(frames.q_room_segment.swapaxes(0, 1), found.q_earth_sensor)
    assert apart.max() < 1e-12
    np.testing.assert_array_equal(frames.segment_flags.T, found.flags)


def test_pieces_of_a_session_smooth_as_one(session, setup):
    worn = replace(setup, placements=setup.placements[:1])
    chunk = signals.to_common_ticks(session.recording, 100.0)
    rows = signals.to_common_ticks(
        replace(session.recording, sensors={n: session.recording.sensors[n] for n in worn.placements}), 100.0
    )
    pieces = [rows.ticks(a, min(a + 777, rows.tick_count)) for a in range(0, rows.tick_count, 777)]
    found, constants = smooth_network(pieces, worn)
    whole = smoothed_chunk(rows, worn)
    assert isinstance(whole, orientation.SmoothedChunk)
    np.testing.assert_array_equal(found.q_earth_sensor, whole.orientation.q_earth_sensor)
    assert constants == whole.constants
    assert smoothed_chunk(chunk, replace(setup, orientation="vqf")) is chunk


def test_known_accelerometer_biases_are_taken_off_first(session, setup):
    name = setup.placements[0]
    worn = SessionSetup("orientation", (name,), 100.0, orientation="telemotion_smoother")
    chunk = signals.to_common_ticks(
        replace(session.recording, sensors={name: session.recording.sensors[name]}), 100.0
    )
    shifted = replace(chunk, accelerometer_mps2=chunk.accelerometer_mps2 + np.array([0.5, 0.0, 0.0]))
    pipeline = create(replace(worn, orientation="vqf"))
    step_through(pipeline, chunk)
    known = replace(
        pipeline.calibrate(chunk.ticks(0, 100), "static"), accelerometer_bias_mps2={name: (0.5, 0.0, 0.0)}
    )
    expected, learnt = smooth_network([chunk], worn)
    found, told = smooth_network([shifted], replace(worn, calibration=known))
    assert rotation.angle_between(found.q_earth_sensor, expected.q_earth_sensor).max() < 1e-9
    # Of the device as it reads: what the calibration took off is its own, then and in the next session.
    assert told[0].less_offset([0.5, 0.0, 0.0]).accelerometer_offset_mps2 == pytest.approx(
        learnt[0].accelerometer_offset_mps2, abs=1e-6
    )
    constants = {name: learnt[0].less_offset([-0.5, 0.0, 0.0])}
    plain, _ = smooth_network([chunk], replace(worn, device_constants={name: learnt[0]}))
    again, _ = smooth_network([shifted], replace(worn, calibration=known, device_constants=constants))
    assert rotation.angle_between(again.q_earth_sensor, plain.q_earth_sensor).max() < 1e-9


def test_a_device_calibrated_in_the_hand_is_corrected_first(session, setup):
    name = setup.placements[0]
    worn = SessionSetup("orientation", (name,), 100.0, orientation="telemotion_smoother")
    chunk = signals.to_common_ticks(
        replace(session.recording, sensors={name: session.recording.sensors[name]}), 100.0
    )
    device = DeviceCalibration(gyroscope=TriadCalibration(bias=(0.2, -0.1, 0.3)))
    biased = replace(chunk, gyroscope_radps=chunk.gyroscope_radps + np.array([0.2, -0.1, 0.3]))
    expected, _ = smooth_network([chunk], worn)
    found, _ = smooth_network([biased], replace(worn, devices={name: device}))
    assert rotation.angle_between(found.q_earth_sensor, expected.q_earth_sensor).max() < 1e-9


def test_a_smoother_does_not_run_live(session, setup):
    chunk = signals.to_common_ticks(
        replace(session.recording, sensors={n: session.recording.sensors[n] for n in setup.placements}), 100.0
    )
    with pytest.raises(SetupError, match="needs the whole session"):
        create(setup).step(chunk.ticks(0, 10))
