"""A mounting remembered from an earlier session means nothing until headings are told anew."""

import math
from dataclasses import replace

import numpy as np
import pytest

from estimators import rotation, signals
from estimators.calibration._mounting import PUT_ON_RAD
from estimators.errors import CalibrationError
from estimators.orientation import OrientationFlag
from estimators.pipelines import Calibration, SessionSetup, create

pytestmark = pytest.mark.slow

ARM = ("upper_arm_right", "forearm_right")
UNTRUSTED = int(OrientationFlag.HEADING_NOT_TRUSTED)
ELSEWHERE_RAD = 0.6 + 0.5 * math.pi


@pytest.fixture(scope="module", params=[True, False], ids=["compass", "no compass"])
def played(simulate, request):
    """The same sensors on two days; on the second the patient faces a quarter turn away."""
    days = [
        simulate(exercise="abduction", placements=ARM, facing_rad=facing, has_magnetometer=request.param)
        for facing in (0.6, ELSEWHERE_RAD)
    ]
    chunks = [signals.to_common_ticks(day.recording, 100.0) for day in days]
    first = create(SessionSetup("arm", ARM, 100.0))
    first.step(chunks[0].ticks(0, 500))
    mounting = first.calibrate(chunks[0].ticks(200, 500)).q_sensor_segment
    known = Calibration(mounting, {}, unknown_headings=ARM)
    return days[1].truth.frames, chunks[1], SessionSetup("arm", ARM, 100.0, calibration=known)


def error_deg(frames, truth, name):
    found = frames.angle_rad[:, frames.layout.angles.index(name)]
    true = truth.angle_rad[frames.first_tick :, truth.layout.angles.index(name)][: len(found)]
    sound = (frames.angle_flags[:, frames.layout.angles.index(name)] & int(OrientationFlag.SINGULAR)) == 0
    apart = np.remainder(found - true + np.pi, 2 * np.pi)[sound] - np.pi
    return np.degrees(np.sqrt(np.mean(apart**2)))


def test_headings_are_flagged_until_a_pose_tells_them(played):
    truth, chunk, setup = played
    assert SessionSetup.from_dict(setup.to_dict()) == setup
    pipeline = create(setup)
    before = pipeline.step(chunk.ticks(0, 500))
    assert (before.segment_flags & UNTRUSTED).all()
    assert (before.angle_flags & UNTRUSTED).all()
    # Of sensors that share their heading one tells where the patient faces.
    has_compass = chunk.magnetometer_t is not None
    found = pipeline.reset_heading(chunk.ticks(200, 500), ARM[:1] if has_compass else ARM)
    assert found.unknown_headings == ()
    assert set(found.gyroscope_bias_radps) == set(ARM)
    after = pipeline.step(chunk.ticks(500, chunk.tick_count))
    for name in ("thorax_humerus_right_yxy_plane_of_elevation", "humerus_forearm_right_zxy_pronation"):
        assert error_deg(after, truth, name) < 6.0, name
    if has_compass:
        assert not (after.segment_flags[200:] & UNTRUSTED).any()
        assert found.heading_offset_rad == {}


def test_a_limb_left_out_stays_unknown(played):
    _, chunk, setup = played
    if chunk.magnetometer_t is not None:
        pytest.skip("sensors with compasses share their heading")
    pipeline = create(setup)
    pipeline.step(chunk.ticks(0, 500))
    assert pipeline.reset_heading(chunk.ticks(200, 500), ARM[1:]).unknown_headings == ARM[:1]
    flags = pipeline.step(chunk.ticks(500, 600)).segment_flags
    assert (flags[:, 0] & UNTRUSTED).all()
    offset = pipeline.setup.calibration.heading_offset_rad["forearm_right"]
    # The other one follows; what was told stays.
    found = pipeline.reset_heading(chunk.ticks(300, 600), ARM[:1])
    assert found.unknown_headings == ()
    assert found.heading_offset_rad["forearm_right"] == offset


def test_a_sensor_that_sits_otherwise_tells_no_heading(played):
    _, chunk, setup = played
    tilted = rotation.multiply(
        setup.calibration.q_sensor_segment["forearm_right"], rotation.exp([0.6, 0.0, 0.0])
    )
    mounting = {**setup.calibration.q_sensor_segment, "forearm_right": tuple(tilted)}
    pipeline = create(replace(setup, calibration=replace(setup.calibration, q_sensor_segment=mounting)))
    pipeline.step(chunk.ticks(0, 500))
    before = pipeline.setup.calibration
    with pytest.raises(CalibrationError, match="off the standing pose"):
        pipeline.reset_heading(chunk.ticks(200, 500), ARM)
    assert pipeline.setup.calibration is before


def put_on_otherwise(setup, method):
    """The sensors sit six degrees otherwise than is remembered."""
    known = setup.calibration
    mounting = {
        place: tuple(rotation.multiply(seat, rotation.exp([0.0, np.radians(6.0), 0.0])))
        for place, seat in known.q_sensor_segment.items()
    }
    sigma = dict.fromkeys(ARM, (0.01, 0.01, 0.03))
    return replace(
        setup,
        calibration=replace(known, q_sensor_segment=mounting, method=method, mounting_sigma_rad=sigma),
    )


def test_the_pose_tells_how_sensors_that_were_put_on_anew_are_tilted(played):
    """Six degrees beside a hanging arm are forty of the plane of elevation."""
    truth, chunk, setup = played
    pipeline = create(put_on_otherwise(setup, "n_pose"))
    pipeline.step(chunk.ticks(0, 500))
    found = pipeline.reset_heading(chunk.ticks(200, 500), ARM)
    for place in ARM:
        apart = rotation.multiply(
            rotation.conjugate(setup.calibration.q_sensor_segment[place]), found.q_sensor_segment[place]
        )
        assert np.degrees(2.0 * math.hypot(apart[1], apart[2])) < 2.0
        assert found.mounting_sigma_rad[place] == pytest.approx((0.01, 0.01, math.hypot(0.03, PUT_ON_RAD)))
    # Once it is known, it stays.
    pipeline.step(chunk.ticks(500, 510))
    assert pipeline.reset_heading(chunk.ticks(210, 510), ARM).q_sensor_segment == found.q_sensor_segment
    after = pipeline.step(chunk.ticks(510, chunk.tick_count))
    assert error_deg(after, truth, "thorax_humerus_right_yxy_elevation") < 3.0


def test_a_mounting_found_by_movement_stays_and_is_less_certain(played):
    _, chunk, setup = played
    setup = put_on_otherwise(setup, "functional")
    pipeline = create(setup)
    pipeline.step(chunk.ticks(0, 500))
    found = pipeline.reset_heading(chunk.ticks(200, 500), ARM)
    assert found.q_sensor_segment == setup.calibration.q_sensor_segment
    tilt = math.hypot(0.01, PUT_ON_RAD)
    assert found.mounting_sigma_rad["forearm_right"] == pytest.approx(
        (tilt, tilt, math.hypot(0.03, PUT_ON_RAD))
    )
