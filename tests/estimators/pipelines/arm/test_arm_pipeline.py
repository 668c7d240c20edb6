"""The arm pipeline: its contract with every filter, any sensible placements, calibration, gaps."""

import json
from dataclasses import asdict, replace

import numpy as np
import pytest
from pipeline_contract import PipelineContract

from estimators import signals
from estimators.conventions import PLACEMENTS
from estimators.errors import CalibrationError, SetupError, ShapeError
from estimators.orientation import OrientationFlag, available
from estimators.pipelines import DeviceConstants, SessionSetup, concatenate, create
from estimators.pipelines.arm import body
from estimators.recording import SampleQuality
from tests.said import refuses

INVALID, BRIDGED = int(OrientationFlag.INVALID), int(OrientationFlag.BRIDGED)


@pytest.mark.parametrize("orientation", sorted(available()))
class TestContract(PipelineContract):
    pose = (300, 600)

    @pytest.fixture
    def setup(self, session, orientation):
        return replace(session.setup, orientation=orientation)

    @pytest.fixture
    def chunk(self, ticks, gaps):
        return gaps(ticks)


class TestContractWithoutMagnetometer(PipelineContract):
    pose = (300, 600)

    @pytest.fixture
    def setup(self, simulate):
        return simulate(has_magnetometer=False).setup

    @pytest.fixture
    def chunk(self, simulate, gaps):
        return gaps(signals.to_common_ticks(simulate(has_magnetometer=False).recording, 100.0))


class TestContractUncalibrated(PipelineContract):
    @pytest.fixture
    def setup(self, session):
        return session.setup

    @pytest.fixture
    def chunk(self, ticks, gaps):
        return gaps(ticks)


def calibrated(setup, chunk, pose=(300, 600)):
    pipeline = create(setup)
    before = pipeline.step(chunk.ticks(0, pose[1]))
    found = pipeline.calibrate(chunk.ticks(*pose))
    after = pipeline.step(chunk.ticks(pose[1], chunk.tick_count))
    return before, after, found, pipeline


def test_names_of_the_layout(session):
    layout = create(session.setup).layout
    assert layout.segments == session.setup.placements
    assert {"shoulder_right", "elbow_right", "wrist_right", "hand_right", "neck", "pelvis"} <= set(
        layout.points
    )
    for side in ("left", "right"):
        for name in ("thorax_humerus_{}_yxy_elevation", "humerus_forearm_{}_zxy_flexion"):
            assert name.format(side) in layout.angles
        assert f"hand_speed_{side}_mps" in layout.scalars
    assert "trunk_lean_forward_rad" in layout.scalars


def test_uncalibrated_shows_sensor_motion_flagged(session, ticks):
    frames = create(session.setup).step(ticks.ticks(0, 800))
    assert np.isnan(frames.angle_rad).all()
    assert np.isnan(frames.point_room_m).all()
    assert np.isnan(frames.scalar).all()
    assert (frames.angle_flags & INVALID).all()
    needed = int(OrientationFlag.CONVERGING | OrientationFlag.HEADING_NOT_TRUSTED)
    assert ((frames.segment_flags & needed) == needed).all()
    assert np.isfinite(frames.q_room_segment).all()


def test_calibration_takes_effect_from_the_next_step(session, ticks):
    before, after, found, pipeline = calibrated(session.setup, ticks)
    assert np.isnan(before.angle_rad).all()
    assert np.isfinite(after.angle_rad).all()
    assert np.isfinite(after.angle_sigma_rad).all()
    assert (after.angle_sigma_rad > 0).all()
    assert np.isfinite(after.point_room_m).all()
    assert found.score > 0.5
    assert pipeline.setup.calibration == found
    assert session.setup.calibration is None


def test_close_to_truth(session, ticks):
    """Nominal errors and mounting by hand: as good as the rule that the sternum sensor faces forward."""
    _, after, _, _ = calibrated(session.setup, ticks)
    truth = session.truth.frames
    scored = slice(600, 600 + after.tick_count)
    for name in ("thorax_humerus_right_yxy_elevation", "humerus_forearm_right_zxy_flexion"):
        found = after.angle_rad[:, after.layout.angles.index(name)]
        error = found - truth.angle_rad[scored, truth.layout.angles.index(name)]
        assert np.degrees(np.sqrt(np.mean(error**2))) < 3.0, name
    hand = after.point_room_m[:, after.layout.points.index("wrist_right")]
    true_hand = truth.point_room_m[scored, truth.layout.points.index("wrist_right")]
    assert np.sqrt(np.mean(np.sum((hand - true_hand) ** 2, axis=1))) < 0.05
    speed = after.scalar[:, after.layout.scalars.index("hand_speed_right_mps")]
    true_speed = truth.scalar[scored, truth.layout.scalars.index("hand_speed_right_mps")]
    assert np.sqrt(np.mean((speed - true_speed) ** 2)) < 0.03


@pytest.mark.parametrize(
    "worn",
    [
        ("upper_arm_right",),
        ("upper_arm_right", "forearm_right"),
        ("sternum", "upper_arm_left", "forearm_left", "hand_left"),
        ("forearm_right", "upper_arm_right", "sternum"),
        ("upper_arm_left", "upper_arm_right"),
        ("forearm_left",),
        ("forearm_left", "hand_left"),
        ("upper_arm_right", "hand_right"),
        ("thigh_left", "shank_left"),
        ("foot_right", "sternum", "shank_right", "pelvis"),
        PLACEMENTS,
    ],
    ids=lambda worn: f"{len(worn)}:{worn[0]}",
)
def test_any_sensible_placements(simulate, worn):
    made = simulate(placements=worn)
    chunk = signals.to_common_ticks(made.recording, 100.0)
    _, after, _, pipeline = calibrated(made.setup, chunk)
    layout = pipeline.layout
    assert layout.segments == worn
    for name in layout.angles:
        side = "left" if "_left_" in name else "right"
        needed = {
            "thorax": ["upper_arm"],
            "humerus": ["upper_arm", "forearm"],
            "forearm": ["forearm", "hand"],
            "pelvis": ["thigh"],
            "thigh": ["thigh", "shank"],
            "shank": ["shank", "foot"],
        }
        assert all(f"{part}_{side}" in worn for part in needed[name.split("_")[0]])
    if {"upper_arm_right", "forearm_right"} <= set(worn):
        assert "humerus_forearm_right_zxy_flexion" in layout.angles
    assert np.isfinite(after.angle_rad).all()
    assert np.isfinite(after.q_room_segment).all()


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"placements": ("sternum", "thigh_left")}, "upper arm or a forearm"),
        ({"placements": ()}, "upper arm or a forearm"),
        ({"placements": ("upper_arm_right", "tail")}, "Placements that do not exist: tail"),
        ({"placements": ("upper_arm_right", "upper_arm_right")}, "twice"),
        ({"rate_hz": 5.0}, "between 10 and 1000"),
        ({"orientation": "guess"}, "guess"),
        ({"orientation_parameters": {"no_such_thing": 1.0}}, "no_such_thing"),
        ({"pipeline": "legs"}, "no pipeline legs"),
    ],
)
def test_impossible_setups_say_what_is_wrong(session, change, words):
    with pytest.raises(SetupError, match=words):
        create(replace(session.setup, **change))


def test_calibration_of_other_sensors_is_refused(session, ticks):
    _, _, found, _ = calibrated(session.setup, ticks)
    other = replace(session.setup, placements=("upper_arm_right", "shoulder_right"), calibration=found)
    with refuses("calibration.other_sensors", error=SetupError, where=["shoulder_right"]):
        create(other)


def test_pose_must_be_known_and_still(session, ticks):
    pipeline = create(session.setup)
    pipeline.step(ticks.ticks(0, 1700))
    with refuses("calibration.forgotten", memory_s=8.0):
        pipeline.calibrate(ticks.ticks(100, 400))
    with refuses("calibration.was_moving"):
        pipeline.calibrate(ticks.ticks(1400, 1700))
    assert pipeline.setup.calibration is None
    with pytest.raises(SetupError, match="dance"):
        pipeline.calibrate(ticks.ticks(1400, 1700), "dance")


def test_failed_calibration_leaves_the_old_one(session, ticks):
    _, _, found, pipeline = calibrated(session.setup, ticks.ticks(0, 1400))
    twin = create(session.setup)
    twin.step(ticks.ticks(0, 600))
    twin.calibrate(ticks.ticks(300, 600))
    twin.step(ticks.ticks(600, 1400))
    with pytest.raises(CalibrationError):
        twin.calibrate(ticks.ticks(1000, 1400))
    assert twin.setup.calibration == found
    rest = ticks.ticks(1400, 1500)
    assert twin.step(rest).angle_rad.tobytes() == pipeline.step(rest).angle_rad.tobytes()


def test_pose_may_end_before_the_last_tick(session, ticks):
    pipeline = create(session.setup)
    pipeline.step(ticks.ticks(0, 620))
    pipeline.calibrate(ticks.ticks(300, 600))
    assert np.isfinite(pipeline.step(ticks.ticks(620, 700)).angle_rad).all()


def test_a_lost_sensor_holds_flagged_and_comes_back(session, ticks):
    lost = slice(900, 1000)
    sensor = session.setup.placements.index("forearm_right")
    gyroscope, quality = ticks.gyroscope_radps.copy(), ticks.quality.copy()
    gyroscope[sensor, lost] = np.nan
    quality[sensor, lost] |= np.uint8(SampleQuality.MISSING)
    _, after, _, _ = calibrated(session.setup, replace(ticks, gyroscope_radps=gyroscope, quality=quality))
    layout = after.layout
    inside = slice(lost.start - 600, lost.stop - 600)
    flexion = layout.angles.index("humerus_forearm_right_zxy_flexion")
    elevation = layout.angles.index("thorax_humerus_right_yxy_elevation")
    assert (after.angle_flags[inside, flexion] & (INVALID | BRIDGED)).all()
    # What a short gap would be bridged over is over; the rest says nothing.
    assert (after.angle_flags[inside.start + 20 : inside.stop, flexion] & INVALID).all()
    assert not (after.angle_flags[inside, elevation] & INVALID).any()
    assert not (after.angle_flags[inside.stop :, flexion] & INVALID).any()
    assert np.isnan(after.scalar[inside, layout.scalars.index("hand_speed_right_mps")]).all()
    assert np.isfinite(after.scalar[inside, layout.scalars.index("hand_speed_left_mps")]).all()
    assert np.isfinite(after.angle_rad).all()


def test_angles_do_not_jump(simulate):
    """Between two ticks a joint turns less than 10 degrees: nothing wraps, whatever the chunks."""
    made = simulate(exercise="drinking", both_arms=True)
    chunk = signals.to_common_ticks(made.recording, 100.0)
    _, after, _, _ = calibrated(made.setup, chunk)
    assert np.abs(np.diff(after.angle_rad, axis=0)).max() < np.radians(10)


def test_extra_sensors_are_segments_only(simulate):
    made = simulate(placements=("upper_arm_right", "thigh_left", "foot_left"))
    chunk = signals.to_common_ticks(made.recording, 100.0)
    _, after, _, _ = calibrated(made.setup, chunk)
    truth = made.truth.frames
    column = truth.layout.segments.index("thigh_left")
    dot = np.abs(np.sum(after.q_room_segment[:, 1] * truth.q_room_segment[600:, column], axis=1))
    assert np.degrees(2 * np.arccos(np.clip(dot, 0, 1))).max() < 25


def test_the_calibration_is_written_once_for_all_checkpoints(session, ticks, monkeypatch):
    written = []
    monkeypatch.setattr(body, "asdict", lambda found: written.append(found) or asdict(found))
    pipeline = create(session.setup)
    assert pipeline.state()["calibration"].tobytes() == b"null"
    pipeline.step(ticks.ticks(0, 600))
    found = pipeline.calibrate(ticks.ticks(300, 600))
    states = [pipeline.state()["calibration"].tobytes() for _ in range(3)]
    assert written == [found]
    assert len(set(states)) == 1
    assert json.loads(states[0])["method"] == found.method


def test_wrong_state_is_refused(session, ticks):
    pipeline = create(session.setup)
    with pytest.raises(ShapeError, match="previous_angle_rad"):
        pipeline.restore({})
    other = create(replace(session.setup, placements=("upper_arm_right",)))
    with pytest.raises(ShapeError, match="1 sensors"):
        pipeline.restore(other.state())


def test_level_calibration_finds_the_accelerometer_bias(session, ticks):
    """Every sensor level with a known bias; then the N-pose keeps it, and the bias changes the result."""
    count, length = ticks.sensor_count, 300
    bias = np.random.default_rng(4).normal(0, 0.1, (count, 3))
    noise = np.random.default_rng(5).normal(0, 0.02, (count, length, 3))
    level = replace(
        ticks.ticks(0, length),
        gyroscope_radps=session.truth.gyroscope_bias_radps[:, :1] + 0.001 * noise,
        accelerometer_mps2=[0, 0, 9.80665] + bias[:, None] + noise,
        magnetometer_t=None,
    )
    pipeline = create(session.setup)
    pipeline.step(level)
    found = pipeline.calibrate(level, "level")
    told = np.array([found.accelerometer_bias_mps2[name] for name in session.setup.placements])
    # Standard error 0.02 / sqrt(300) = 0.0012 m/s^2.
    assert np.abs(told - bias).max() < 0.006
    assert np.isnan(pipeline.step(replace(level, first_tick=length)).angle_rad).all()
    shaken = replace(
        level, first_tick=2 * length, accelerometer_mps2=level.accelerometer_mps2 + np.array([3.0, 0, 0])
    )
    pipeline.step(shaken)
    with refuses("calibration.not_level"):
        pipeline.calibrate(shaken, "level")
    shifted = replace(ticks, accelerometer_mps2=ticks.accelerometer_mps2 + bias[:, None])
    known = create(pipeline.setup)
    known.step(shifted.ticks(0, 600))
    mounted = known.calibrate(shifted.ticks(300, 600))
    assert mounted.accelerometer_bias_mps2 == found.accelerometer_bias_mps2
    assert mounted.method == "level, n_pose"
    _, plain, _, _ = calibrated(session.setup, ticks)
    corrected = known.step(shifted.ticks(600, 1200))
    # The sensors' own bias of 0.05 m/s^2 (0.3 degrees of tilt, 0.7 of heading, on each of two sensors) is
    # unknown to both; the plain one corrects its part along gravity.
    assert np.degrees(np.abs(corrected.angle_rad - plain.angle_rad[:600]).max()) < 3.0


def test_what_a_calibration_takes_off_is_told_of_the_device(session, ticks):
    """The pose takes off a part of the offset: the filter expects what is left, the device has both."""
    count = ticks.sensor_count
    offset = np.random.default_rng(6).normal(0, 0.2, (count, 3))
    known = {
        name: DeviceConstants(
            accelerometer_offset_mps2=tuple(one), accelerometer_offset_sigma_mps2=(0.01, 0.01, 0.01)
        )
        for name, one in zip(session.setup.placements, offset, strict=True)
    }
    shifted = replace(ticks, accelerometer_mps2=ticks.accelerometer_mps2 + offset[:, None])
    pipeline = create(replace(session.setup, device_constants=known))

    def farthest():
        told = pipeline.device_constants
        return max(
            np.abs(told[name].array("accelerometer_offset_mps2") - one).max()
            for name, one in zip(session.setup.placements, offset, strict=True)
        )

    pipeline.step(shifted.ticks(0, 600))
    before = farthest()
    found = pipeline.calibrate(shifted.ticks(300, 600))
    assert max(np.abs(one).max() for one in found.accelerometer_bias_mps2.values()) > 0.1
    assert farthest() < before + 0.05
    pipeline.step(shifted.ticks(600, 1200))
    assert farthest() < 0.1
    again = create(pipeline.setup)
    again.restore(pipeline.state())
    assert again.device_constants == pipeline.device_constants
    # A pose that ticks have followed gives no new filter: the running one expects less from now on.
    pipeline.calibrate(shifted.ticks(300, 600))
    assert farthest() < 0.1


def test_concatenate_refuses_holes(session, ticks):
    pipeline = create(session.setup)
    one, two, three = (pipeline.step(ticks.ticks(k, k + 10)) for k in (0, 10, 20))
    assert concatenate([one, two, three]).tick_count == 30
    with pytest.raises(ShapeError, match="tick 10 is next"):
        concatenate([one, three])
    with pytest.raises(ShapeError, match="no frames"):
        concatenate([])
    with pytest.raises(ShapeError, match="layouts"):
        concatenate([one, replace(two, time_step_s=0.02)])


def test_setup_of_an_older_version_reads(session, ticks):
    """Sessions stored before accelerometer biases were kept."""
    _, _, _, pipeline = calibrated(session.setup, ticks)
    stored = pipeline.setup.to_dict()
    del stored["calibration"]["accelerometer_bias_mps2"]
    assert SessionSetup.from_dict(stored).calibration.accelerometer_bias_mps2 == {}
