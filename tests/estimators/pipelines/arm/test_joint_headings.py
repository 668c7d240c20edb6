"""Joint constraints in the arm pipeline: same bits in any chunks, off by default, better angles without a compass."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from pipeline_contract import PipelineContract, assert_same_bits

from estimators import rotation, signals
from estimators.orientation import OrientationFlag
from estimators.pipelines import SessionSetup, run
from estimators.pipelines.arm.joint_headings import JointHeadings
from estimators.recording import Recording, SensorSignals
from estimators.simulation import ArmScenario, Schedule, simulate_arm

QMT = Path(__file__).parents[3] / "data" / "qmt" / "arms_25s.npz"
NO_HEADING = int(OrientationFlag.HEADING_NOT_TRUSTED)


class TestContract(PipelineContract):
    pose = (300, 600)

    @pytest.fixture
    def setup(self, simulate):
        return replace(simulate(has_magnetometer=False).setup, constrain_joint_headings=True)

    @pytest.fixture
    def chunk(self, simulate, gaps):
        return gaps(signals.to_common_ticks(simulate(has_magnetometer=False).recording, 100.0))


def test_off_is_the_default_and_old_setups_read(session):
    assert not session.setup.constrain_joint_headings
    stored = session.setup.to_dict()
    del stored["constrain_joint_headings"]
    assert SessionSetup.from_dict(stored) == session.setup


def test_without_a_joint_nothing_changes(simulate):
    made = simulate(placements=("sternum", "upper_arm_right"), has_magnetometer=False)
    plain = run(made.recording, made.setup, (3.0, 6.0))[0]
    other = run(made.recording, replace(made.setup, constrain_joint_headings=True), (3.0, 6.0))[0]
    assert_same_bits(plain, other)


def drifting(setup, deg_per_min):
    """A calibrated session whose right forearm's heading drifts: its gyroscope's bias about the vertical."""
    scenario = ArmScenario(
        exercise="drinking",
        schedule=Schedule(n_pose_s=6.0, repetitions=None, duration_s=120.0),
        has_magnetometer=False,
        seed=9,
    )
    made = simulate_arm(scenario)
    column = made.setup.placements.index("forearm_right")
    down = rotation.rotate(rotation.conjugate(made.truth.q_earth_sensor[column]), (0.0, 0.0, 1.0))
    sensor = made.recording.sensors["forearm_right"]
    moving = (sensor.time_s > 8.0)[:, None]
    spoilt = replace(
        sensor, gyroscope_radps=sensor.gyroscope_radps + moving * np.radians(deg_per_min / 60) * down
    )
    recording = replace(made.recording, sensors={**made.recording.sensors, "forearm_right": spoilt})
    # The filter may not learn the bias from rest here: what it knows is the pose's.
    return made, run(recording, replace(made.setup, **setup), (3.0, 6.0))[0]


@pytest.mark.slow
def test_a_drifting_forearm_is_brought_back():
    name = "humerus_forearm_right_zxy_carrying"
    errors = {}
    for is_on in (False, True):
        made, frames = drifting({"constrain_joint_headings": is_on}, 12.0)
        truth = made.truth.frames
        error = (
            frames.angle_rad[:, frames.layout.angles.index(name)]
            - truth.angle_rad[:, truth.layout.angles.index(name)]
        )
        errors[is_on] = np.degrees(np.sqrt(np.mean(error[6000:] ** 2)))
        flags = frames.angle_flags[:, frames.layout.angles.index(name)] & NO_HEADING
        assert (flags[6000:] != 0).mean() == pytest.approx(0.0 if is_on else 1.0, abs=0.2)
    assert errors[True] < 0.6 * errors[False], errors


def test_trusted_magnetometers_are_left_alone(session):
    plain = run(session.recording, session.setup, (3.0, 6.0))[0]
    other = run(session.recording, replace(session.setup, constrain_joint_headings=True), (3.0, 6.0))[0]
    assert np.degrees(np.sqrt(np.mean((other.angle_rad - plain.angle_rad)[700:] ** 2))) < 2.5


def test_a_hand_takes_its_forearms_turn_along():
    """The correction of the wrist adds to that of the elbow, and the order of sensors does not matter."""
    rng = np.random.default_rng(90)
    worn = ("hand_right", "upper_arm_right", "forearm_right")
    q = rotation.exp(np.cumsum(rng.normal(0, 0.02, (500, 3, 3)), axis=0))
    zeros, flags = np.zeros((500, 3, 3)), np.full((500, 3), NO_HEADING, dtype=np.uint8)
    found = JointHeadings(worn, 0.01).apply(q, zeros, zeros + 1.0, flags, 0)
    swapped = JointHeadings(worn[::-1], 0.01).apply(q[:, ::-1], zeros, zeros + 1.0, flags, 0)
    np.testing.assert_array_equal(found.q_room_segment, swapped.q_room_segment[:, ::-1])
    turn = [
        rotation.log(rotation.multiply(found.q_room_segment[:, i], rotation.conjugate(q[:, i])))
        for i in range(3)
    ]
    assert np.abs(turn[1]).max() < 1e-12
    assert np.abs(turn[0][:, :2]).max() < 1e-9
    assert np.abs(turn[0][:, 2] - turn[2][:, 2]).max() > 1e-3


def recording():
    content = np.load(QMT)
    sensors = {}
    for key in content.files:
        if key.endswith("_gyroscope_radps"):
            name = key.removesuffix("_gyroscope_radps")
            turn = np.array([1.0, -1.0, -1.0]) if name in ("upper_back", "hip") else np.ones(3)
            place = {"upper_back": "sternum", "hip": "pelvis"}.get(name, name)
            sensors[place] = SensorSignals(
                content["time_s"],
                turn * content[key].astype(float),
                turn * content[f"{name}_accelerometer_mps2"].astype(float),
            )
    return Recording(sensors, 100.0, origin="qmt")


def test_a_real_recording_is_not_made_worse():
    """No magnetometer, sensors on by hand, N-pose only, 25 s: flexion stays an elbow's, carrying strays no more.

    Carrying angles of 55 to 80 degrees are left in while the elbow bends: axes that the N-pose cannot know, not
    drift. 25 s are too short to tell the two apart; a functional calibration of the axes is the cure.
    """
    worn = recording()
    setup = SessionSetup("arm", worn.placements, 100.0)
    plain = run(worn, setup, (0.95, 2.0))[0]
    other = run(worn, replace(setup, constrain_joint_headings=True), (0.95, 2.0))[0]

    def angle_deg(frames, name):
        return np.degrees(frames.angle_rad[300:, frames.layout.angles.index(name)])

    for side in ("left", "right"):
        carrying = f"humerus_forearm_{side}_zxy_carrying"
        before, after = angle_deg(plain, carrying), angle_deg(other, carrying)
        assert np.sqrt(np.mean(after**2)) < np.sqrt(np.mean(before**2))
        assert np.abs(after).max() < np.abs(before).max() + 1.0
        flexion = angle_deg(other, f"humerus_forearm_{side}_zxy_flexion")
        assert flexion.min() > -15
        assert flexion.max() < 165
