"""Offset and scale of an accelerometer are found in movement, and what stays unknown is stated."""

from dataclasses import replace

import numpy as np
import pytest

from estimators import rotation
from estimators.calibration import RecordingCheck, correct
from estimators.calibration.force.errors import ForceErrors
from estimators.calibration.force.evidence import ForceEvidence
from estimators.calibration.force.verdict import is_found, is_uncalibrated
from estimators.calibration.force.windows import STILL
from estimators.conventions import GRAVITY_MPS2
from estimators.recording import Float, ImuChunk

RATE_HZ = 50.0
STEP_S = 1.0 / RATE_HZ


def held(seed: int, attitudes: int, *, noise: float = 1.0) -> tuple[Float, Float]:
    """Return true rate and specific force of a sensor that rests for 4 s in each attitude and is turned in between."""
    generator = np.random.default_rng([seed, 17])
    rest, turn = round(4.0 * RATE_HZ), round(1.5 * RATE_HZ)
    bell = np.sin(np.linspace(0.0, np.pi, turn)) ** 2
    bell /= bell.sum() * STEP_S
    parts = []
    for _ in range(attitudes):
        parts += [np.zeros((rest, 3)), bell[:, None] * generator.uniform(-2.0, 2.0, 3)]
    rate = np.concatenate(parts)
    begun = rotation.normalize(generator.normal(size=4))
    attitude = rotation.multiply(begun, rotation.running_product(rotation.exp(STEP_S * rate)))
    middle = rotation.multiply(attitude, rotation.exp(-0.5 * STEP_S * rate))
    moving = np.linalg.norm(rate, axis=1, keepdims=True)
    force = rotation.rotate(rotation.conjugate(middle), [0.0, 0.0, GRAVITY_MPS2])
    force += noise * 0.5 * moving * np.sin(2.0 * np.pi * 1.7 * STEP_S * np.arange(len(rate)))[:, None]
    return rate, force


def delivered(seed: int, force: Float, *, size: float = 1.0) -> tuple[Float, Float, Float]:
    """Return readings of a device as delivered, its scale errors and its offsets: 20 to 150 mg, 1 to 5 % an axis."""
    generator = np.random.default_rng([seed, 18])
    scale = size * generator.uniform(0.01, 0.05, 3) * generator.choice([-1.0, 1.0], 3)
    offset = size * GRAVITY_MPS2 * generator.uniform(0.02, 0.15, 3) * generator.choice([-1.0, 1.0], 3)
    return force * (1.0 + scale) + offset + generator.normal(0.0, 0.03, force.shape), scale, offset


def found(rate: Float, force: Float, seed: int = 0) -> ForceErrors:
    noise = np.random.default_rng([seed, 19]).normal(0.0, 0.003, rate.shape)
    evidence = ForceEvidence(keeps_readings=True)
    evidence.add(rate + 0.004 + noise, force, STEP_S)
    assert evidence.refined is not None
    return evidence.refined


def off(errors: ForceErrors, scale: Float, offset: Float) -> Float:
    """Return estimated less true errors."""
    return np.concatenate((errors.scale - scale, errors.offset_mps2 - offset))


def test_errors_are_found_where_the_sensor_was_held_in_many_attitudes():
    rate, force = held(1, 8)
    readings, scale, offset = delivered(1, force)
    errors = found(rate, readings)
    apart = off(errors, scale, offset)
    assert np.abs(apart[:3]).max() < 0.01
    assert np.abs(apart[3:]).max() < 0.01 * GRAVITY_MPS2
    assert errors.gain > 20.0
    assert errors.tilt_rad > 10.0 * errors.tilt_sigma_rad


@pytest.mark.parametrize("rate_hz", [1.0, 5.0, 9.0])
def test_what_was_filled_up_corrects_nothing(rate_hz):
    """Below 10 Hz files are filled up on the lines between their samples, or come as they are."""
    rate, force = held(1, 12)
    force = delivered(1, force)[0]
    time_s = STEP_S * np.arange(len(rate))
    at_s = np.arange(0.0, time_s[-1], 1.0 / rate_hz)
    slow_rate, slow_force = (
        np.stack([np.interp(at_s, time_s, values[:, axis]) for axis in range(3)], axis=1)
        for values in (rate + 0.01 * np.random.default_rng(1).normal(size=rate.shape), force)
    )
    as_it_is = ForceEvidence(keeps_readings=True)
    as_it_is.add(slow_rate, slow_force, 1.0 / rate_hz)
    assert as_it_is.errors is None
    count = int(np.ceil(20.0 / rate_hz))
    filled_s = np.arange(0.0, at_s[-1], 1.0 / rate_hz / count)
    filled = ForceEvidence(keeps_readings=True)
    filled.add(
        *(
            np.stack([np.interp(filled_s, at_s, values[:, axis]) for axis in range(3)], axis=1)
            for values in (slow_rate, slow_force)
        ),
        1.0 / rate_hz / count,
    )
    assert filled.errors is None


def test_windows_with_long_bridges_are_no_evidence_and_those_of_single_ones_are():
    rate, force = held(1, 8)
    force = delivered(1, force)[0]
    rate = rate + np.random.default_rng(1).normal(0.0, 0.003, rate.shape)
    for every, lasts, is_evidence in ((50, 1, True), (50, 10, False)):
        evidence = ForceEvidence(keeps_readings=True)
        evidence.add(rate, force, STEP_S, np.arange(len(rate)) % every < lasts)
        assert (evidence.errors is not None) == is_evidence


def test_the_stated_covariance_covers_the_truth():
    """In few attitudes and in many: normalised squares average at most six, the number of errors, but not far below.

    Rests are quieter than what is assumed of a limb, so the covariance is on the safe side here.
    """
    squares = []
    for seed in range(200, 240):
        rate, force = held(seed, 2 + seed % 5)
        readings, scale, offset = delivered(seed, force)
        errors = found(rate, readings, seed)
        apart = off(errors, scale, offset)
        squares.append(float(apart @ np.linalg.solve(errors.covariance, apart)))
    assert 0.6 < np.mean(squares) < 6.0
    # 16.8 holds 99 % of chi-square with six degrees of freedom.
    assert np.mean(np.array(squares) < 16.8) > 0.9


def test_what_a_single_rest_cannot_show_stays_unknown():
    """Across gravity an offset looks like a lean: the prior of a device as delivered remains."""
    rate, force = held(3, 1, noise=0.0)
    rest = slice(0, round(4.0 * RATE_HZ))
    errors = found(rate[rest], force[rest] + [0.5, 0.0, 0.0])
    assert np.degrees(errors.tilt_sigma_rad) > 4.0


def test_a_sound_device_has_no_errors_worth_a_word():
    for seed in range(300, 320):
        rate, force = held(seed, 2 + seed % 5)
        assert found(rate, delivered(seed, force, size=0.05)[0], seed).gain < 2.0


def test_rests_stay_however_long_the_sensor_moves_afterwards():
    """Three poses held for 13 s each, then five minutes of movement.

    Drawn for ten seeds with five poses before a hand that is pushed about, the lean that is left falls from 0.21 to
    0.14 degrees; where it moves less, or about one axis, nothing changes.
    """
    generator = np.random.default_rng(2)
    evidence = ForceEvidence(keeps_readings=True)
    for _ in range(3):
        up = GRAVITY_MPS2 * rotation.rotate(rotation.normalize(generator.normal(size=4)), [0.0, 0.0, 1.0])
        still = np.zeros((round(13.0 * RATE_HZ), 3))
        evidence.add(still, up + generator.normal(0.0, 0.03, still.shape), STEP_S)
    for seed in range(5):
        rate, force = held(seed, 12)
        evidence.add(rate, force + generator.normal(0.0, 0.03, force.shape), STEP_S)
    turned = evidence._windows.turned
    assert (len(turned), np.count_nonzero(turned < STILL)) == (40, 3)


def check_of(rate: Float, readings: Float) -> tuple[RecordingCheck, ImuChunk]:
    quality = np.zeros((1, len(rate)), np.uint8)
    chunk = ImuChunk(0, STEP_S, rate[None], readings[None], None, quality)
    check = RecordingCheck(["hand_left"], "unknown", corrects=True)
    check.add(chunk)
    return check, chunk


@pytest.mark.parametrize("seed", [11, 12, 13])
def test_a_recording_is_corrected_and_told(seed):
    rate, force = held(seed, 6)
    readings, _, _ = delivered(seed, force)
    check, chunk = check_of(rate, readings)
    assert [one.code for one in check.findings] == ["accelerometer_uncalibrated"]
    assert {one.severity for one in check.findings} == {"warning"}
    correction = check.corrections["hand_left"]
    left = correct(chunk, [correction.device]).accelerometer_mps2[0] - force
    before = readings - force
    assert np.sqrt(np.mean(left**2)) < 0.1 * np.sqrt(np.mean(before**2))
    assert 0.0 < correction.device.direction_sigma_rad[0] < np.radians(1.0)


def test_other_faults_are_not_called_an_offset():
    rate, force = held(21, 6)
    for fault in (
        replace(check_of(rate, force)[1], gyroscope_radps=rate[None][..., [1, 0, 2]]),
        replace(check_of(rate, force)[1], accelerometer_mps2=force[None] / GRAVITY_MPS2),
        replace(check_of(rate, force)[1], gyroscope_radps=np.degrees(rate)[None]),
    ):
        check = RecordingCheck(["hand_left"], "unknown", corrects=True)
        check.add(fault)
        assert check.findings
        assert "accelerometer_uncalibrated" not in {one.code for one in check.findings}
        assert check.corrections == {}


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_an_acceleration_in_the_rhythm_of_the_tilt_is_not_taken_for_an_offset(seed):
    """Squats and rowing: the trunk leans about one axis and is accelerated as it leans. It was corrected by 10 deg."""
    generator = np.random.default_rng(seed)
    ticks = round(120.0 * RATE_HZ)
    phase = (
        np.cumsum(2.0 * np.pi * 0.4 * (1.0 + 0.1 * np.repeat(generator.normal(size=60), ticks // 60)))
        * STEP_S
    )
    lean = np.radians(45.0) * 0.5 * (1.0 - np.cos(phase))
    rate = np.zeros((ticks, 3))
    rate[:, 1] = np.gradient(lean, STEP_S)
    attitude = rotation.running_product(rotation.exp(STEP_S * rate))
    pushed = np.zeros((ticks, 3))
    pushed[:, 0], pushed[:, 2] = 1.6 * np.cos(phase), GRAVITY_MPS2
    force = rotation.rotate(rotation.conjugate(attitude), pushed) + generator.normal(0.0, 0.03, (ticks, 3))
    errors = found(rate, force, seed)
    assert not is_found(errors)
    assert not is_uncalibrated(errors)
