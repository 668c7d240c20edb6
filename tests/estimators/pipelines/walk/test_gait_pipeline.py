from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from pipeline_contract import PipelineContract

from estimators import pipelines, rotation
from estimators.calibration import DeviceCalibration, TriadCalibration
from estimators.errors import SetupError
from estimators.orientation import OrientationFlag
from estimators.pipelines import SessionSetup, analyse_walk
from estimators.recording import ImuChunk, Recording, SampleQuality, SensorSignals
from estimators.signals import to_common_ticks
from estimators.simulation import gait_preset, simulate_gait
from tests.said import codes, refuses

FEET = Path(__file__).parents[3] / "data" / "feet"


@cache
def walk():
    return simulate_gait(replace(gait_preset("placement", 3), rate_hz=100.0))


def network(*names):
    recording = walk().recording
    return replace(recording, sensors={name: recording.sensors[name] for name in names})


class TestGaitPipeline(PipelineContract):
    @pytest.fixture
    def setup(self):
        return SessionSetup("gait", ("heel_left", "pelvis", "heel_right", "sternum"), 100.0)

    @pytest.fixture
    def chunk(self):
        whole = to_common_ticks(network("heel_left", "pelvis", "heel_right", "sternum"), 100.0).ticks(0, 700)
        gyroscope, quality = whole.gyroscope_radps.copy(), whole.quality.copy()
        gyroscope[0, 420:430] = np.nan
        quality[0, 420:430] = SampleQuality.MISSING
        quality[2, 500:510] = SampleQuality.BRIDGED
        return replace(whole, gyroscope_radps=gyroscope, quality=quality)


def test_a_walk_off_line_is_drawn_along_its_course():
    setup = SessionSetup("gait", ("heel_left", "heel_right"), 100.0)
    recording = network("heel_left", "heel_right")
    found = analyse_walk(recording, setup)
    frames = found.frames
    assert frames.tick_count == len(walk().truth.time_s)
    for i, side in enumerate(("left", "right")):
        truth = walk().truth.feet[side]
        way = frames.point_room_m[-1, i] - frames.point_room_m[0, i]
        moved = truth.foothold_m[-1] - truth.foothold_m[0]
        assert way[0] == pytest.approx(np.linalg.norm(moved), rel=0.01)
        assert abs(way[1]) < 0.2
        # Toes point along the course, out by the foot's five degrees, on a level floor.
        toes = rotation.rotate(frames.q_room_segment[-1, i], [1.0, 0.0, 0.0])
        assert toes[0] > 0.97
        assert abs(toes[2]) < 0.03
        scalar = {name: frames.scalar[:, k] for k, name in enumerate(frames.layout.scalars)}
        stand = scalar[f"foot_{side}_stance"] == 1.0
        assert not (stand & ~truth.is_contact).any()
        assert scalar[f"foot_{side}_contact"].sum() == found.strides[side].count == len(truth.land_s) - 1
        at = np.flatnonzero(scalar[f"foot_{side}_toe_off"]) / 100.0
        np.testing.assert_allclose(at, truth.lift_s[:-1], atol=0.03)
        assert scalar[f"foot_{side}_stride_length_m"][-1] == found.strides[side].length_m[-1]
        assert np.isnan(scalar[f"foot_{side}_stride_length_m"][0])
        sigma = frames.point_sigma_m[:, i]
        # Of the sensor's path in its own world, whose level axes the room turns; they share one figure.
        path = found.trajectories[side].position_sigma_m[-1]
        np.testing.assert_allclose(sigma[-1], [*[np.sqrt(0.5 * (path[:2] ** 2).sum())] * 2, path[2]])
        assert np.linalg.norm(way[:2]) - np.linalg.norm(moved[:2]) == pytest.approx(
            0.0, abs=4.0 * sigma[-1, 0]
        )
        attitude = found.trajectories[side].attitude_sigma_rad[-1]
        assert frames.segment_sigma_rad[-1, i, 2] == attitude[2]
        assert np.isfinite(frames.segment_sigma_rad[:, i]).all()
    same, _ = pipelines.run(recording, setup)
    np.testing.assert_array_equal(same.point_room_m, frames.point_room_m)
    assert found.summary.feet["left"]["stride_length"].count >= 4


def test_live_lags_by_less_than_a_second_and_agrees_with_off_line():
    setup = SessionSetup("gait", ("heel_left", "heel_right"), 100.0)
    chunk = to_common_ticks(network("heel_left", "heel_right"), 100.0)
    pipeline = pipelines.create(setup)
    frames = pipeline.step(chunk)
    delay = pipeline.delay_ticks
    assert delay < 100
    assert (frames.segment_flags[:delay] == OrientationFlag.INVALID).all()
    assert not (frames.segment_flags[delay:] & OrientationFlag.INVALID).any()
    off_line = analyse_walk(network("heel_left", "heel_right"), setup).frames
    for i in range(2):
        live, smooth = frames.point_room_m[delay:, i], off_line.point_room_m[:-delay, i]
        np.testing.assert_allclose(
            np.linalg.norm(live - live[0], axis=1), np.linalg.norm(smooth - smooth[0], axis=1), atol=0.15
        )
    # What is stored of a live walk says how well each foot is known, from the first shown sample on.
    stored = frames.as_stored_live()
    for sigma in (stored.point_sigma_m, stored.segment_sigma_rad):
        assert np.isnan(sigma[:delay]).all()
        assert (sigma[delay:] > 0.0).all()


def test_a_real_walk_of_a_device_that_clips():
    content = np.load(FEET / "pyshoe_walk.npz")
    signals = SensorSignals(
        content["time_s"],
        content["gyroscope_radps"].astype(float),
        content["accelerometer_mps2"].astype(float),
    )
    recording = Recording({"foot_right": signals}, 200.0, metadata={"gyroscope_clip_radps": "9.09"})
    found = analyse_walk(recording, SessionSetup("gait", ("foot_right",), 200.0))
    assert (found.frames.segment_flags & OrientationFlag.SATURATED).any()
    assert found.strides["right"].count > 5
    assert found.frames.layout.segments == ("foot_right",)
    assert "walk.one_foot" in codes(found.summary.reasons)


def test_wrong_setups_are_refused():
    with refuses("walk.needs_foot", error=SetupError):
        pipelines.create(SessionSetup("gait", ("pelvis",), 100.0))
    with pytest.raises(SetupError, match="no_such"):
        pipelines.create(SessionSetup("gait", ("foot_left",), 100.0, orientation_parameters={"no_such": 1.0}))
    pipeline = pipelines.create(SessionSetup("gait", ("foot_left",), 100.0))
    still = ImuChunk(
        0, 0.01, np.zeros((1, 5, 3)), np.zeros((1, 5, 3)), None, np.zeros((1, 5), dtype=np.uint8)
    )
    with refuses("calibration.walk_needs_none"):
        pipeline.calibrate(still)


def test_device_calibrations_are_applied_live_and_off_line():
    """A device that reads 10 % too much, with its calibration, gives what a sound one gives."""
    sound = network("heel_left")
    sensor = sound.sensors["heel_left"]
    wrong = replace(
        sensor,
        gyroscope_radps=1.1 * sensor.gyroscope_radps + 0.05,
        accelerometer_mps2=sensor.accelerometer_mps2 + np.array([0.3, 0.0, -0.2]),
    )
    device = DeviceCalibration(
        accelerometer=TriadCalibration(bias=(0.3, 0.0, -0.2)),
        gyroscope=TriadCalibration(
            gain=((1 / 1.1, 0.0, 0.0), (0.0, 1 / 1.1, 0.0), (0.0, 0.0, 1 / 1.1)), bias=(0.05, 0.05, 0.05)
        ),
    )
    setup = SessionSetup("gait", ("heel_left",), 100.0)
    known = replace(setup, devices={"heel_left": device})
    calibrated = replace(sound, sensors={"heel_left": wrong})
    for own, recording in ((setup, sound), (known, calibrated)):
        frames = analyse_walk(recording, own).frames
        live = pipelines.create(own).step(to_common_ticks(recording, 100.0))
        if own is setup:
            expected, expected_live = frames, live
    np.testing.assert_allclose(frames.point_room_m, expected.point_room_m, atol=1e-6)
    np.testing.assert_allclose(live.point_room_m, expected_live.point_room_m, atol=1e-6)
