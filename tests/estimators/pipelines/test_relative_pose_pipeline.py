from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from pipeline_contract import PipelineContract

from estimators import pipelines
from estimators.errors import SetupError
from estimators.magnetic import (
    RelativeFlag,
    RelativePoseFilter,
    coil_state,
    perpendicular_source,
    read_coil_state,
)
from estimators.magnetic.relative import layout as at
from estimators.magnetic.relative.smoother import smooth_table
from estimators.orientation import OrientationFlag
from estimators.pipelines import SessionSetup
from estimators.pipelines.relative import smoothing
from estimators.recording import ImuChunk, SampleQuality
from estimators.simulation.coils import SourceFaults, relative_motion, relative_scene, run_closed_loop
from tests.said import refuses

SOURCE = perpendicular_source(0.06)
# The coils are exactly as described: as after a calibration.
SETUP = SessionSetup(
    "relative_pose", ("pelvis", "sternum"), 100.0, orientation_parameters={"gain_sigma": 0.002}
)


@cache
def played(movement="flexion", seconds=12.0, faults=None):
    """Return truth, what the filter alone said, and the session as the network would deliver it."""
    scene = relative_scene(SOURCE, relative_motion(movement, seconds, 1), seconds, seed=1)
    one = RelativePoseFilter(SOURCE, 0.01, {"mounting_direction": (0.05, 0.0, 1.0), "response_s": 0.5})
    result, samples = run_closed_loop(scene, one, faults or SourceFaults(), 1)
    table = samples.copy()
    source = np.r_[at.SOURCE_GYROSCOPE : at.SOURCE_GYROSCOPE + 3]
    gyroscope = np.stack([table[:, source], table[:, at.GYROSCOPE : at.GYROSCOPE + 3]])
    accelerometer = np.stack(
        [
            table[:, at.SOURCE_ACCELEROMETER : at.SOURCE_ACCELEROMETER + 3],
            table[:, at.ACCELEROMETER : at.ACCELEROMETER + 3],
        ]
    )
    field = np.stack([scene.source_ambient_t, table[:, at.FIELD : at.FIELD + 3]])
    state = np.zeros((2, len(table)))
    state[0] = coil_state(table[:, at.COIL].astype(int), table[:, at.CURRENT])
    quality = np.zeros((2, len(table)), dtype=np.uint8)
    return scene, result, ImuChunk(0, 0.01, gyroscope, accelerometer, field, quality, coil_state=state)


class TestRelativePosePipeline(PipelineContract):
    @pytest.fixture
    def setup(self):
        return SETUP

    @pytest.fixture
    def chunk(self):
        whole = played()[2].ticks(0, 900)
        gyroscope, quality, state = (
            whole.gyroscope_radps.copy(),
            whole.quality.copy(),
            whole.coil_state.copy(),
        )
        gyroscope[1, 620:632] = np.nan
        quality[1, 620:632] = SampleQuality.MISSING
        quality[0, 700:705] = SampleQuality.BRIDGED
        state[0, 810:813] = 7.13
        return replace(whole, gyroscope_radps=gyroscope, quality=quality, coil_state=state)


def scalar(frames, name):
    return frames.scalar[:, frames.layout.scalars.index(name)]


def test_frames_say_what_the_filter_says_and_stand_in_the_room():
    scene, result, chunk = played()
    frames = pipelines.create(SETUP).step(chunk)
    started = (result.flags & RelativeFlag.INVALID) == 0
    assert started.sum() > 700
    here = np.stack([scalar(frames, f"sternum_{axis}_m") for axis in "xyz"], axis=1)
    np.testing.assert_allclose(here[started], result.position_m[started], atol=2e-3)
    assert np.isnan(here[~started]).all()
    error = np.linalg.norm(here - scene.position_m, axis=1)[started]
    assert np.sqrt(np.mean(error**2)) < 0.015
    sigma = np.stack([scalar(frames, f"sternum_{axis}_sigma_m") for axis in "xyz"], axis=1)[started]
    assert np.sqrt(np.mean((error / np.linalg.norm(sigma, axis=1)) ** 2)) < 1.6
    # In the room the trunk is above the pelvis, at the distance told.
    away = frames.point_room_m[:, 1] - frames.point_room_m[:, 0]
    np.testing.assert_allclose(
        np.linalg.norm(away[started], axis=1), scalar(frames, "sternum_distance_m")[started], rtol=1e-9
    )
    assert away[started][0, 2] > 0.4
    bent = frames.angle_rad[started, frames.layout.angles.index("pelvis_sternum_zyx_flexion")]
    assert np.degrees(bent.max()) == pytest.approx(42.0, abs=4.0)


def test_the_source_is_asked_and_its_account_kept():
    _, result, chunk = played()
    frames = pipelines.create(SETUP).step(chunk)
    np.testing.assert_array_equal(scalar(frames, "source_ask_coil"), result.fire_coil)
    asked = np.flatnonzero(scalar(frames, "source_ask_coil"))
    assert set(scalar(frames, "source_ask_coil")[asked]) == {1.0, 2.0, 3.0}
    on = scalar(frames, "source_coil") > 0
    assert scalar(frames, "source_on_time_s")[-1] == pytest.approx(on.sum() * 0.01)
    assert scalar(frames, "source_charge_as")[-1] == pytest.approx(1.3 * on.sum() * 0.01, rel=1e-4)


def test_a_whole_session_is_smoothed_block_by_block_as_in_one(monkeypatch):
    scene, result, chunk = played()
    whole = pipelines.smooth_modules([chunk], SETUP)[0]
    pipeline = pipelines.create(SETUP)
    one = pipeline.filters["sternum"]
    same = smooth_table(one.source, 0.01, pipeline.table("sternum", chunk), one.parameters)
    np.testing.assert_array_equal(whole.position_m, same.position_m)
    np.testing.assert_array_equal(whole.covariance, same.covariance)
    monkeypatch.setattr(smoothing, "_BLOCK", 333)
    pieces = [chunk.ticks(k, min(k + 400, chunk.tick_count)) for k in range(0, chunk.tick_count, 400)]
    parts = pipelines.smooth_modules(pieces, SETUP)
    np.testing.assert_array_equal(parts[0].position_m, whole.position_m)
    assert not (parts[0].flags & RelativeFlag.UNCERTAIN)[300:].any()

    started = (result.flags & RelativeFlag.INVALID) == 0
    starts = range(0, chunk.tick_count, 400)
    frames = pipelines.concatenate(
        [
            pipeline.step(pipelines.with_modules(piece, parts, k))
            for piece, k in zip(pieces, starts, strict=True)
        ]
    )
    here = np.stack([scalar(frames, f"sternum_{axis}_m") for axis in "xyz"], axis=1)
    np.testing.assert_array_equal(here[started], whole.position_m[started])

    def rms(position):
        return np.sqrt(np.mean(np.sum((position - scene.position_m)[started] ** 2, axis=1)))

    assert rms(here) < 0.7 * rms(result.position_m)
    np.testing.assert_array_equal(scalar(frames, "source_ask_coil"), result.fire_coil)


def test_a_dead_source_is_told_and_the_session_goes_on_with_growing_uncertainty():
    _, _, chunk = played(faults=SourceFaults(silent_from_s=6.0))
    frames = pipelines.create(SETUP).step(chunk)
    state = scalar(frames, "sternum_state").astype(int)
    after = slice(850, None)
    assert (state[after] & RelativeFlag.INERTIAL_ONLY).any()
    assert (state[after] & (RelativeFlag.MISSING_PULSE | RelativeFlag.FAULT)).all()
    assert not (state[500:560] & RelativeFlag.INERTIAL_ONLY).any()
    sigma = scalar(frames, "sternum_distance_sigma_m")
    assert sigma[-1] > 4.0 * sigma[590]
    flag = frames.segment_flags[:, 1]
    assert (flag[after] & (OrientationFlag.HEADING_NOT_TRUSTED | OrientationFlag.CONVERGING)).all()
    assert np.isfinite(frames.point_room_m[after]).all()


def test_an_impossible_coil_number_is_a_fault_and_no_end():
    _, _, chunk = played()
    state = chunk.coil_state.copy()
    on = state[0] > 0.0
    state[0, on] += np.where(np.arange(on.sum()) >= 27, 5.0, 0.0)
    frames = pipelines.create(SETUP).step(replace(chunk, coil_state=state))
    told = scalar(frames, "sternum_state").astype(int)
    assert (told & RelativeFlag.FAULT).any()
    assert not (told[400] & RelativeFlag.FAULT)
    assert np.isfinite(frames.angle_rad[-1]).all()


def test_two_sensors_share_a_source():
    _, _, chunk = played()
    rows = [0, 1, 1]
    both = replace(
        chunk,
        gyroscope_radps=chunk.gyroscope_radps[rows],
        accelerometer_mps2=chunk.accelerometer_mps2[rows],
        magnetometer_t=chunk.magnetometer_t[rows],
        quality=chunk.quality[rows],
        coil_state=chunk.coil_state[rows],
    )
    setup = SessionSetup("relative_pose", ("pelvis", "sternum", "head"), 100.0)
    frames = pipelines.create(setup).step(both)
    np.testing.assert_allclose(scalar(frames, "head_x_m")[-1], scalar(frames, "sternum_x_m")[-1], atol=1e-6)
    assert frames.layout.points == ("pelvis", "sternum", "head")


def test_coil_states_survive_the_wire():
    numbers, currents = np.array([0, 1, 2, 3, 3]), np.array([0.0, 1.3, -0.7, 0.0, 9.99])
    coil, current, wrong = read_coil_state(coil_state(numbers, currents).astype(np.float32))
    np.testing.assert_array_equal(coil, numbers)
    np.testing.assert_allclose(current, np.where(numbers > 0, currents, 0.0), atol=1e-5)
    assert not wrong.any()
    coil, _, wrong = read_coil_state([0.5, np.nan, 1e5, -1.2])
    assert wrong.tolist() == [True, True, True, False]
    assert coil.tolist() == [0, 0, 0, 1]
    with pytest.raises(SetupError, match="below 10"):
        coil_state(1, 10.0)
    with pytest.raises(SetupError, match="numbered"):
        coil_state(99, 1.0)


@pytest.mark.parametrize(
    ("placements", "parameters", "match"),
    [
        (("pelvis",), {}, "at least one sensor"),
        (("hand_left", "hand_right"), {}, "Choose where the magnetic source is worn"),
        (("pelvis", "sternum"), {"source": "head"}, "Choose where the magnetic source is worn"),
        (("pelvis", "sternum"), {"no_such": 1}, "no_such"),
        (("pelvis", "sternum"), {"coil_turns": 0.0}, "above zero"),
        (("pelvis", "sternum"), {"current_a": 5.0}, "current"),
        (("pelvis", "sternum"), {"current_limit_a": 500.0}, "below 10 A"),
        (("pelvis", "sternum"), {"coil_turns": 1e9}, "A m²"),
        (("pelvis", "sternum"), {"passes": 0.5}, "whole number"),
        (("pelvis", "sternum"), {"baseline_samples": 1}, "quiet samples"),
    ],
)
def test_wrong_setups_are_refused(placements, parameters, match):
    with pytest.raises(SetupError, match=match):
        pipelines.create(SessionSetup("relative_pose", placements, 100.0, orientation_parameters=parameters))


def test_no_pose_is_needed():
    with refuses("calibration.magnetic_needs_none"):
        pipelines.create(SETUP).calibrate(played()[2])
