"""Sensors on trunk, arms and legs to the body's centre of mass, against the simulator's truth."""

from dataclasses import replace

import numpy as np
import pytest
from pipeline_contract import PipelineContract

from estimators import pipelines, signals
from estimators.balance import MASS_SCALARS
from estimators.balance.published import mean_segments, segmental_mass_centre
from estimators.errors import SetupError
from estimators.orientation import OrientationFlag
from estimators.pipelines import SessionSetup, create
from estimators.recording import SampleQuality

LEGS = ("thigh_left", "shank_left", "thigh_right", "shank_right")
WORN = ("sternum", "pelvis", "upper_arm_left", "forearm_left", "upper_arm_right", "forearm_right", *LEGS)


@pytest.fixture(scope="module")
def whole(simulate):
    return simulate(exercise="abduction", both_arms=True, placements=WORN, rate_hz=60.0)


@pytest.mark.slow
class TestContractOfAWholeBody(PipelineContract):
    pose = (180, 360)

    @pytest.fixture
    def setup(self, whole):
        return whole.setup

    @pytest.fixture
    def chunk(self, whole, gaps):
        return gaps(signals.to_common_ticks(whole.recording, 60.0))


def mass_of(frames):
    columns = [frames.layout.scalars.index(name) for name in MASS_SCALARS]
    point = frames.point_room_m[:, frames.layout.points.index("centre_of_mass")]
    return point, frames.scalar[:, columns]


def true_mass(session):
    frames = session.truth.frames
    q = {name: frames.q_room_segment[:, i] for i, name in enumerate(frames.layout.segments)}
    return segmental_mass_centre(q, mean_segments(), session.setup.body)


def test_the_centre_follows_raised_arms(whole):
    frames, setup = pipelines.run(whole.recording, whole.setup, (3.0, 6.0))
    point, scalar = mass_of(frames)
    truth = true_mass(whole)
    ticks = slice(400, min(len(point), len(truth.position_m)))
    # The same table is used: what remains is of the sensors, and sigma covers it with what is not known of a body.
    error = scalar[ticks, 2] - truth.position_m[ticks, 2]
    assert np.abs(error).max() < 0.006
    assert np.ptp(truth.position_m[ticks, 2]) > 0.03
    above_hip = truth.position_m - truth.joints_m["hip"]
    away = (point - [0.0, 0.0, 0.53 * setup.body.stature_m])[ticks] - above_hip[ticks]
    assert np.abs(away).max() < 0.012
    sigma = scalar[ticks, 3:]
    assert (np.abs(error) < 2.0 * sigma[:, 2]).all()
    assert sigma.min() > 0.005
    assert sigma.max() < 0.04


def test_trunk_and_legs_alone_are_enough(simulate):
    session = simulate(placements=("pelvis", *LEGS), rate_hz=60.0, exercise="flexion")
    assert create(session.setup).layout.points == ("pelvis", "centre_of_mass")
    frames, _ = pipelines.run(session.recording, session.setup, (3.0, 6.0))
    point, scalar = mass_of(frames)
    assert np.isfinite(point).all()
    truth = true_mass(session)
    still = slice(370, 400)
    assert scalar[still, 2] == pytest.approx(truth.position_m[still, 2], abs=0.02)
    # Arms that nobody measures may be anywhere, and sigma says more than with them.
    assert scalar[still, 3].min() > 0.01


def test_before_the_calibration_and_in_gaps_nothing_is_told(whole):
    chunk = signals.to_common_ticks(whole.recording, 60.0)
    quality = chunk.quality.copy()
    gyroscope = chunk.gyroscope_radps.copy()
    row = WORN.index("shank_left")
    gyroscope[row, 500:560] = np.nan
    quality[row, 500:560] = SampleQuality.MISSING
    chunk = replace(chunk, quality=quality, gyroscope_radps=gyroscope)
    pipeline = create(whole.setup)
    before = pipeline.step(chunk.ticks(0, 360))
    pipeline.calibrate(chunk.ticks(180, 360))
    after = pipeline.step(chunk.ticks(360, 620))
    for values in mass_of(before):
        assert np.isnan(values).all()
    point, scalar = mass_of(after)
    is_lost = (after.segment_flags[:, row] & OrientationFlag.INVALID) != 0
    assert is_lost[160:200].all()
    assert np.isnan(scalar[is_lost]).all()
    assert np.isfinite(scalar[~is_lost]).all()
    assert np.isfinite(point).all()


def test_without_thighs_no_centre_is_made_up():
    layout = create(SessionSetup("arm", ("sternum", "upper_arm_left", "pelvis"), 100.0)).layout
    assert "centre_of_mass" not in layout.points
    with pytest.raises(SetupError, match="trunk and both thighs"):
        create(SessionSetup("arm", ("sternum", "thigh_left"), 100.0))
