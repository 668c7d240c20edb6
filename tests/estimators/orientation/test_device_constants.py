import json
from dataclasses import replace

import numpy as np
import pytest

from estimators import orientation, rotation
from estimators.conventions import GRAVITY_MPS2
from estimators.errors import ShapeError
from estimators.orientation import DeviceConstants
from estimators.pipelines import SessionSetup, create
from estimators.recording import ImuChunk, SampleQuality
from estimators.signals import interpolate_rotations

STEP_S = 0.005
GAIN_STATES, DELAY = slice(12, 21), 27
GAIN = np.array([[0.004, 0.002, 0.0], [-0.001, -0.003, 0.001], [0.0, 0.0, 0.005]])
DELAY_S = 0.015


def turning_sensor(seed, seconds=90.0, clip_radps=np.inf, rest_s=5.0, pace=1.0):
    """One sensor at one place that turns fast about all axes, its errors known: gain, delay, bias, noise."""
    rng = np.random.default_rng(seed)
    ticks = round(seconds / STEP_S)
    time = np.arange(ticks) * STEP_S
    rate = np.zeros((ticks, 3))
    for a in range(3):
        for f in rng.uniform(0.15, 0.9, 4):
            rate[:, a] += rng.uniform(0.7, 1.6) * np.sin(2 * np.pi * f * time + rng.uniform(0, 6))
    rate *= pace * np.clip((time - rest_s) / 0.5, 0.0, 1.0)[:, None]
    q = _integrated(rate)
    back = rotation.conjugate(q)
    late = rotation.rotate(
        rotation.conjugate(interpolate_rotations(time, q, time - DELAY_S)), np.array([0.0, 20e-6, -45e-6])
    )
    measured = np.linalg.solve(np.eye(3) + GAIN, (rate + 0.004).T).T + 0.003 * rng.standard_normal(rate.shape)
    force = rotation.rotate(back, np.array([0.0, 0.0, GRAVITY_MPS2])) + 0.03 * rng.standard_normal(rate.shape)
    return (
        ImuChunk(
            0,
            STEP_S,
            np.clip(measured, -clip_radps, clip_radps)[None],
            force[None],
            (late + 0.2e-6 * rng.standard_normal(rate.shape))[None],
            np.zeros((1, ticks), dtype=np.uint8),
        ),
        q,
    )


def _integrated(rate):
    q = np.empty((len(rate), 4))
    q[0] = rotation.identity()
    for k in range(1, len(rate)):
        q[k] = rotation.multiply(q[k - 1], rotation.exp(rate[k] * STEP_S))
    return q


@pytest.fixture(scope="module")
def learnt():
    estimator = orientation.create("telemotion", 1, STEP_S)
    estimator.update(turning_sensor(1)[0])
    return estimator.device_constants[0]


def test_gain_and_delay_are_found_within_their_sigma(learnt):
    error = learnt.array("gyroscope_gain") - GAIN
    sigma = learnt.array("gyroscope_gain_sigma")
    # Nine values within three sigma of the truth, and sigma says that something was learnt (priors 0.01 and 20 ms).
    assert (np.abs(error) < 3.0 * sigma).all()
    assert (sigma < 0.006).all()
    assert abs(learnt.magnetometer_delay_s - DELAY_S) < 3.0 * learnt.magnetometer_delay_sigma_s
    assert learnt.magnetometer_delay_sigma_s < 0.005
    assert (np.abs(learnt.array("hard_iron_t")) < 3.0 * learnt.array("hard_iron_sigma_t")).all()


@pytest.mark.slow
def test_next_session_is_better_from_the_first_turn(learnt):
    """The delay alone turns the field by 15 ms of rate, here 2 degrees; a gain of 0.5 % adds up per turn."""
    errors = {}
    for name, known in (("unknown", None), ("known", learnt)):
        squares = []
        for seed in range(2, 6):
            chunk, truth = turning_sensor(seed, seconds=20.0, rest_s=1.0)
            estimator = orientation.create("telemotion", 1, STEP_S)
            estimator.set_device_constants([known])
            found = estimator.update(chunk).q_earth_sensor[0]
            squares.append(np.mean(rotation.angle_between(found, truth)[400:2000] ** 2))
        errors[name] = np.sqrt(np.mean(squares))
    assert errors["known"] < 0.8 * errors["unknown"]


OFFSET_MPS2, SCALE = np.array([0.25, -0.15, 0.2]), 0.006


def with_offset(chunk):
    return replace(chunk, accelerometer_mps2=(1.0 + SCALE) * chunk.accelerometer_mps2 + OFFSET_MPS2)


@pytest.mark.parametrize("offline", [False, True])
def test_the_accelerometer_is_known_in_the_next_session(offline):
    """An offset of 0.25 m/s^2 tilts the start by 1.5 degrees; it is learnt within its sigma, and known next time."""
    first = with_offset(turning_sensor(1, seconds=60.0)[0])
    if offline:
        (known,) = orientation.smooth("telemotion_smoother", first).constants
    else:
        estimator = orientation.create("telemotion", 1, STEP_S)
        estimator.update(first)
        (known,) = estimator.device_constants
    sigma = known.array("accelerometer_offset_sigma_mps2")
    assert (np.abs(known.array("accelerometer_offset_mps2") - OFFSET_MPS2) < 3.0 * sigma).all()
    assert (sigma < 0.05).all()
    assert abs(known.accelerometer_scale - SCALE) < 3.0 * known.accelerometer_scale_sigma < 0.02
    chunk, truth = turning_sensor(2, seconds=8.0)
    tilts, sigmas = [], []
    for given in (None, known):
        estimator = orientation.create("telemotion", 1, STEP_S)
        estimator.set_device_constants([given])
        found = estimator.update(with_offset(chunk))
        error = rotation.log(rotation.multiply(found.q_earth_sensor[0], rotation.conjugate(truth)))
        tilts.append(np.hypot(*error[200:, :2].T).max())
        sigmas.append(found.sigma_rad[0, 950, 0])
        assert (np.abs(error[200:, :2]) < 4.0 * found.sigma_rad[0, 200:, :2]).all()
    assert tilts[0] > np.deg2rad(1.0) > 3.0 * tilts[1]
    assert sigmas[1] < sigmas[0]


def test_what_is_taken_off_is_known_less():
    known = DeviceConstants(
        accelerometer_offset_mps2=(0.2, 0.0, -0.1), accelerometer_offset_sigma_mps2=(0.02, 0.02, 0.02)
    )
    assert known.less_offset([0.2, -0.1, 0.0]).accelerometer_offset_mps2 == (0.0, 0.1, -0.1)
    assert known.less_offset([0.2, -0.1, 0.0]).less_offset([-0.2, 0.1, 0.0]) == known
    # Neither a silent sensor nor constants of an earlier version know an offset.
    for unknown in (DeviceConstants(), DeviceConstants(magnetometer_delay_s=0.01)):
        assert unknown.less_offset([0.2, -0.1, 0.0]) == unknown


def test_a_silent_sensor_tells_what_was_given(learnt):
    chunk, _ = turning_sensor(1, seconds=5.0)
    silent = np.full_like(chunk.gyroscope_radps, np.nan)
    quality = np.full_like(chunk.quality, int(SampleQuality.MISSING))
    nothing = ImuChunk(0, STEP_S, silent, silent, silent, quality)
    for given in (None, learnt):
        estimator = orientation.create("telemotion", 1, STEP_S)
        estimator.set_device_constants([given])
        estimator.update(nothing)
        assert estimator.device_constants[0] == (given or DeviceConstants())


def test_a_prior_is_not_told_as_hard_iron():
    """At rest the iron and the field cannot be told apart: sigma must allow for the magnet there may be."""
    chunk, _ = turning_sensor(1, seconds=4.0)
    chunk.magnetometer_t[:] += 20e-6
    estimator = orientation.create("telemotion", 1, STEP_S)
    estimator.update(chunk)
    known = estimator.device_constants[0]
    assert (np.abs(known.array("hard_iron_t") - 20e-6) < 4.0 * known.array("hard_iron_sigma_t")).all()
    assert (known.array("hard_iron_sigma_t") > 3e-6).all()


def test_constants_of_no_device_are_neither_learnt_nor_believed():
    chunk, truth = turning_sensor(3, seconds=25.0, rest_s=2.0)
    swapped = replace(chunk, gyroscope_radps=np.ascontiguousarray(chunk.gyroscope_radps[..., [1, 0, 2]]))
    estimator = orientation.create("telemotion", 1, STEP_S)
    estimator.update(swapped)
    assert np.abs(estimator.nominal[0, GAIN_STATES]).max() > 0.02  # it did learn nonsense
    assert estimator.device_constants[0] == DeviceConstants()
    stored = DeviceConstants(gyroscope_gain=((0.0, 0.1, 0.0),) * 3, gyroscope_gain_sigma=((1e-3,) * 3,) * 3)
    wrong, plain = (orientation.create("telemotion", 1, STEP_S) for _ in range(2))
    wrong.set_device_constants([stored])
    short = chunk.ticks(0, 1000)
    assert rotation.angle_between(wrong.update(short).q_earth_sensor, truth[:1000]).max() < np.deg2rad(5.0)
    assert plain.device_constants[0] == DeviceConstants()


def test_storing_changes_nothing(learnt):
    again = DeviceConstants.from_dict(json.loads(json.dumps(learnt.to_dict())))
    assert again == learnt
    chunk = turning_sensor(2, seconds=4.0)[0]
    results = []
    for known in (learnt, again):
        estimator = orientation.create("telemotion", 1, STEP_S)
        estimator.set_device_constants([known])
        results.append(estimator.update(chunk).q_earth_sensor)
    np.testing.assert_array_equal(*results)


def test_nothing_known_is_the_plain_start():
    chunk = turning_sensor(2, seconds=4.0)[0]
    plain, empty = (orientation.create("telemotion", 1, STEP_S) for _ in range(2))
    empty.set_device_constants([None])
    np.testing.assert_array_equal(plain.update(chunk).q_earth_sensor, empty.update(chunk).q_earth_sensor)


@pytest.mark.slow
def test_clip_level_is_learnt_used_and_unlearnt():
    chunk, _ = turning_sensor(7, seconds=40.0, clip_radps=4.3, pace=1.6)
    estimator = orientation.create("telemotion", 1, STEP_S)
    flags = estimator.update(chunk).flags[0]
    known = estimator.device_constants[0]
    assert known.gyroscope_clip_radps == 4.3
    assert known.accelerometer_clip_mps2 is None
    clipped = (np.abs(chunk.gyroscope_radps[0]) >= 0.999 * 4.3).any(axis=-1)  # as in `signals.at_clip`
    saturated = (flags & int(orientation.OrientationFlag.SATURATED)) != 0
    assert clipped.sum() > 50
    assert not saturated[~clipped].any()
    assert (clipped & ~saturated).sum() < 20  # the first few teach the level
    following = orientation.create("telemotion", 1, STEP_S)
    following.set_device_constants([known])
    saturated = (following.update(chunk).flags[0] & int(orientation.OrientationFlag.SATURATED)) != 0
    np.testing.assert_array_equal(saturated, clipped)
    wider = turning_sensor(7, seconds=40.0, pace=1.6)[0]
    wrong = orientation.create("telemotion", 1, STEP_S)
    wrong.set_device_constants([known])
    wrong.update(wider)
    assert wrong.device_constants[0].gyroscope_clip_radps is None


def test_looking_back_a_clip_that_nobody_declared_is_marked_and_doubted():
    chunk, truth = turning_sensor(7, seconds=40.0, clip_radps=4.3, pace=1.8)
    # Calibrated after it was cut off: the level differs from sample to sample, no two are equal.
    rate = chunk.gyroscope_radps * (1.0 + 0.0005 * np.random.default_rng(1).normal(size=(40 * 200, 1)))
    found = orientation.smooth("telemotion_smoother", replace(chunk, gyroscope_radps=rate)).orientation
    saturated = (found.flags[0] & int(orientation.OrientationFlag.SATURATED)) != 0
    clipped = (np.abs(chunk.gyroscope_radps[0]) >= 4.3).any(axis=-1)
    assert clipped.sum() > 100
    assert saturated[clipped].mean() > 0.95
    assert saturated[~clipped].mean() < 0.02
    error = rotation.log(rotation.multiply(found.q_earth_sensor[0], rotation.conjugate(truth)))
    squares = ((error / found.sigma_rad[0]) ** 2).sum(axis=-1)
    assert (squares < 7.8).mean() > 0.8


def test_vqf_has_no_use_for_them(learnt):
    estimator = orientation.create("vqf", 1, STEP_S)
    estimator.set_device_constants([learnt])
    assert estimator.device_constants == ()


def test_session_hands_them_on(learnt):
    setup = SessionSetup(
        "orientation", ("sternum",), 200.0, orientation="telemotion", device_constants={"sternum": learnt}
    )
    stored = json.loads(json.dumps(setup.to_dict()))
    assert SessionSetup.from_dict(stored) == setup
    del stored["device_constants"]  # a session stored before there were any
    assert SessionSetup.from_dict(stored).device_constants == {}
    assert create(setup).device_constants["sternum"] == learnt


def test_constants_age(learnt):
    estimator = orientation.create("telemotion", 1, STEP_S)
    estimator.set_device_constants([learnt])
    sigma = np.sqrt(np.diagonal(estimator.covariance[0]))
    assert sigma[DELAY] > 1.5 * learnt.magnetometer_delay_sigma_s
    assert (sigma[GAIN_STATES] > learnt.array("gyroscope_gain_sigma").T.ravel()).all()


@pytest.mark.parametrize(
    "wrong",
    [
        {"gyroscope_gain": [1.0, 2.0]},
        {"magnetometer_delay_s": float("nan")},
        {"hard_iron_t": "none"},
        {"magnetometer_delay_sigma_s": 0.0},
        {"gyroscope_clip_radps": -1.0},
        {"accelerometer_clip_mps2": float("inf")},
        {"gyroscope_offset": 1.0},
        {"accelerometer_offset_mps2": 0.1},
        {"accelerometer_scale_sigma": -0.01},
    ],
)
def test_wrong_constants_are_refused(wrong):
    with pytest.raises(ShapeError, match=next(iter(wrong))):
        DeviceConstants.from_dict(wrong)


def test_wrong_number_of_sensors_is_refused(learnt):
    with pytest.raises(ShapeError, match="2 sensors for 1"):
        orientation.create("telemotion", 1, STEP_S).set_device_constants([learnt, None])
