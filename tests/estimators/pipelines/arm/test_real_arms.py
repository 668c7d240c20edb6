"""The whole chain on a real recording of both arms and the trunk: plausible, whole, and the same in any chunks."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from pipeline_contract import PipelineContract

import validation
from estimators import signals
from estimators.comparison import find_repetitions, trajectory
from estimators.orientation import OrientationFlag
from estimators.pipelines import SessionSetup, run
from estimators.recording import Recording, SensorSignals

FILE = Path(__file__).parents[3] / "data" / "qmt" / "arms_25s.npz"
PLACEMENT_OF = {"upper_back": "sternum", "hip": "pelvis"}
BACKWARD = ("upper_back", "hip")
"""Worn on the back: half a turn about the long (x) axis makes them as if worn on the front."""
POSE_S = (0.95, 2.0)


@pytest.fixture(scope="module")
def recording() -> Recording:
    content = np.load(FILE)
    names = [
        key.removesuffix("_gyroscope_radps") for key in content.files if key.endswith("_gyroscope_radps")
    ]
    sensors = {}
    for name in names:
        turn = np.array([1.0, -1.0, -1.0]) if name in BACKWARD else np.ones(3)
        sensors[PLACEMENT_OF.get(name, name)] = SensorSignals(
            content["time_s"],
            turn * content[f"{name}_gyroscope_radps"].astype(float),
            turn * content[f"{name}_accelerometer_mps2"].astype(float),
        )
    return Recording(sensors, 100.0, origin="qmt")


@pytest.fixture(scope="module")
def setup(recording) -> SessionSetup:
    return SessionSetup("arm", recording.placements, 100.0)


class TestContract(PipelineContract):
    pose = (95, 200)

    @pytest.fixture
    def chunk(self, recording):
        return signals.to_common_ticks(recording, 100.0)


@pytest.fixture(scope="module")
def frames(recording, setup):
    return run(recording, setup, POSE_S)[0]


def angle_deg(frames, name):
    return np.degrees(frames.angle_rad[:, frames.layout.angles.index(name)])


def test_nothing_is_missing(frames):
    assert frames.tick_count == 2500
    for name in ("q_room_segment", "point_room_m", "angle_rad", "angle_sigma_rad", "scalar"):
        assert np.isfinite(getattr(frames, name)).all(), name
    assert not (frames.segment_flags & int(OrientationFlag.INVALID)).any()
    assert (frames.segment_flags[500:] & int(OrientationFlag.HEADING_NOT_TRUSTED)).any()


@pytest.mark.parametrize("side", ["left", "right"])
def test_joints_stay_where_joints_can_be(frames, side):
    """A margin of 15 degrees beyond human range for mounting by hand and heading without a compass."""
    flexion = angle_deg(frames, f"humerus_forearm_{side}_zxy_flexion")
    assert flexion.min() > -15
    assert flexion.max() < 165
    assert np.ptp(flexion) > 60, "the person moves the elbows"
    elevation = angle_deg(frames, f"thorax_humerus_{side}_yxy_elevation")
    assert elevation.min() >= 0
    assert elevation.max() < 150
    pose = slice(95, 200)
    assert np.abs(flexion[pose]).max() < 5
    assert elevation[pose].max() < 5
    assert np.abs(angle_deg(frames, f"forearm_hand_{side}_zxy_flexion")).max() < 90


@pytest.mark.slow
def test_every_joint_stays_within_human_reach(recording):
    """As the validation does it on the whole recording: here on the stretch that is kept with the tests."""
    whole = replace(recording, metadata={"format": "qmt_mat"})
    (result,) = validation.run(["arm_recording"], data={"arms_25s": whole})
    assert result.verdict == "pass", validation.to_table([result])


def test_the_trunk_bends_forward_and_comes_back(frames):
    """Sitting down bends the trunk forward, not backward; sitting it is upright within 10 degrees."""
    lean = np.degrees(frames.scalar[:, frames.layout.scalars.index("trunk_lean_forward_rad")])
    assert 25 < lean.max() < 75
    assert lean.min() > -12
    assert np.abs(lean[-200:]).max() < 10


def test_speed_is_that_of_the_path(frames):
    """From turning rates and from positions: two ways to the same number."""
    layout = frames.layout
    for side in ("left", "right"):
        path = frames.point_room_m[:, layout.points.index(f"hand_{side}")]
        from_path = np.linalg.norm(signals.derivative(path, 100.0, 0.1), axis=1)
        speed = frames.scalar[:, layout.scalars.index(f"hand_speed_{side}_mps")]
        assert np.corrcoef(from_path, speed)[0, 1] > 0.98
        assert np.abs(from_path - speed).mean() < 0.05


def test_lengths_hold(frames, setup):
    points = {name: frames.point_room_m[:, i] for i, name in enumerate(frames.layout.points)}
    for side in ("left", "right"):
        upper = np.linalg.norm(points[f"elbow_{side}"] - points[f"shoulder_{side}"], axis=1)
        assert np.allclose(upper, setup.body.upper_arm_m, atol=1e-12)
        fore = np.linalg.norm(points[f"wrist_{side}"] - points[f"elbow_{side}"], axis=1)
        assert np.allclose(fore, setup.body.forearm_m, atol=1e-12)


def test_no_repetitions_are_invented(frames):
    """Moving about and sitting down is no exercise."""
    for side in ("left", "right"):
        assert len(find_repetitions(trajectory(frames), side)) <= 1
