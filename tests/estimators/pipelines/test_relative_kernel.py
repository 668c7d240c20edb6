"""The compiled way to frames beside the same in numpy."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from estimators import rotation
from estimators.magnetic import RelativeFlag, RelativeResult, read_coil_state
from estimators.magnetic.relative import layout as at
from estimators.orientation import OrientationFlag
from estimators.pipelines.relative import kernel
from estimators.pipelines.relative.columns import SENSOR_SCALARS, SOURCE_SCALARS, table_of
from estimators.recording import SampleQuality

SENSORS, TICKS, STEP_S = 2, 40, 0.01


def results(rng):
    """Return outputs of filters at random poses, whose covariances are whole."""
    made = []
    for _ in range(SENSORS):
        root = rng.normal(size=(TICKS, 6, 6)) * 0.02
        q = rotation.normalize(rng.normal(size=(TICKS, 4)))
        # Bent forward by nearly a right angle: singular.
        q[7] = rotation.exp([0.0, np.radians(85.0), 0.0])
        flags = rng.integers(0, 2**9, TICKS).astype(np.uint16)
        flags[::2] &= ~np.uint16(int(RelativeFlag.INVALID))
        flags[7] = 0
        made.append(
            RelativeResult(
                rng.normal(size=(TICKS, 3)),
                q,
                rng.normal(size=(TICKS, 3)),
                root @ root.swapaxes(1, 2),
                np.where(rng.random(TICKS) < 0.2, rng.chisquare(3, TICKS), np.nan),
                rng.integers(0, 4, TICKS),
                rng.uniform(0.1, 1.3, TICKS),
                rng.integers(0, 9, TICKS),
                rng.normal(size=(TICKS, 3)),
                flags,
            )
        )
    return made


@pytest.fixture
def written():
    """Return what went into the kernel and what came out."""
    rng = np.random.default_rng(3)
    found = results(rng)
    q_source = rotation.exp(rng.normal(size=(TICKS, 3)))
    samples = np.zeros((SENSORS, TICKS, at.SAMPLE))
    samples[:, :, at.COIL] = rng.integers(0, 4, TICKS)
    samples[:, :, at.CURRENT] = np.where(samples[0, :, at.COIL] > 0, rng.uniform(-1.3, 1.3, TICKS), 0.0)
    wrong = rng.random(TICKS) < 0.1
    wrong[7] = False
    segments, angles = SENSORS + 1, 3 * SENSORS
    columns = len(SENSOR_SCALARS) * SENSORS + len(SOURCE_SCALARS)
    out = {
        "q": np.empty((TICKS, segments, 4)),
        "point": np.empty((TICKS, segments, 3)),
        "sigma": np.empty((TICKS, segments, 3)),
        "flags": np.empty((TICKS, segments), np.uint8),
        "angle": np.empty((TICKS, angles)),
        "angle_sigma": np.empty((TICKS, angles)),
        "angle_flags": np.empty((TICKS, angles), np.uint8),
        "scalar": np.empty((TICKS, columns)),
    }
    source_flags = np.full(TICKS, 255, dtype=np.uint8)
    account, last, turns = np.array([3.0, 1.0, 2.0]), np.zeros(angles), np.zeros(angles, dtype=np.int64)
    outs = np.stack([table_of(result) for result in found])
    running, written = kernel.Running(account, last, turns), kernel.Written(*out.values())
    kernel.write_frames(q_source, source_flags, samples, outs, wrong, 1.0, STEP_S, running, written)
    return found, q_source, samples, wrong, account, out


def states(result, wrong):
    flags = result.flags | np.where(wrong, int(RelativeFlag.FAULT), 0)
    return flags, (flags & int(RelativeFlag.INVALID)) == 0


def test_a_result_as_a_table_and_back():
    result = results(np.random.default_rng(5))[0]
    again = RelativeResult.of_table(table_of(result))
    for name, values in vars(result).items():
        np.testing.assert_array_equal(getattr(again, name), values, err_msg=name)


def test_places_and_scalars_are_those_of_numpy(written):
    found, q_source, _, wrong, _, out = written
    assert (len(SENSOR_SCALARS), len(SOURCE_SCALARS)) == (kernel.SENSOR_COLUMNS, kernel.SOURCE_COLUMNS)
    for i, result in enumerate(found):
        flags, known = states(result, wrong)
        np.testing.assert_allclose(
            out["q"][:, i + 1], rotation.multiply(q_source, result.q_source_sensor), atol=1e-14
        )
        away = rotation.rotate(q_source, result.position_m) + np.array([0.0, 0.0, 1.0])
        np.testing.assert_allclose(out["point"][known, i + 1], away[known], atol=1e-14)
        assert np.isnan(out["point"][~known, i + 1]).all()
        here = out["scalar"][:, len(SENSOR_SCALARS) * i :][:, : len(SENSOR_SCALARS)]
        distance = np.linalg.norm(result.position_m, axis=1)
        unit, cov = result.position_m / distance[:, None], result.covariance[:, :3, :3]
        sigma = result.position_sigma_m
        correlation = cov / (sigma[:, :, None] * sigma[:, None, :])
        expected = np.column_stack(
            [
                distance,
                np.sqrt(np.einsum("ka,kab,kb->k", unit, cov, unit)),
                result.position_m,
                sigma,
                correlation[:, 0, 1],
                correlation[:, 0, 2],
                correlation[:, 1, 2],
            ]
        )
        np.testing.assert_allclose(here[known, :11], expected[known], rtol=1e-12)
        assert np.isnan(here[~known, :11]).all()
        np.testing.assert_array_equal(here[:, 11], result.nis)
        np.testing.assert_array_equal(here[:, 12], flags)
        bits = out["flags"][:, i + 1]
        np.testing.assert_array_equal((bits & OrientationFlag.INVALID) > 0, ~known)
        np.testing.assert_array_equal(
            (bits & OrientationFlag.CONVERGING) > 0,
            (flags & (RelativeFlag.CALIBRATING | RelativeFlag.UNCERTAIN)) > 0,
        )
        assert not (bits[known] & OrientationFlag.SINGULAR).any()
    assert (out["flags"][:, 0] == 255 - OrientationFlag.HEADING_NOT_TRUSTED).all()
    assert (out["point"][:, 0] == [0.0, 0.0, 1.0]).all()


def test_angles_and_their_sigmas_are_those_of_scipy_and_of_differences(written):
    found, _, _, wrong, _, out = written
    for i, result in enumerate(found):
        _, known = states(result, wrong)
        columns = slice(3 * i, 3 * i + 3)
        angle = out["angle"][known][:, columns]
        pose = rotation.to_scipy(result.q_source_sensor[known])
        expected = pose.as_euler("ZYX")
        np.testing.assert_allclose(np.angle(np.exp(1j * (angle - expected))), 0.0, atol=1e-12)
        assert np.abs(np.diff(angle, axis=0)).max() <= np.pi
        h = 1e-6
        change = np.stack(
            [
                (pose * Rotation.from_rotvec(h * axis)).as_euler("ZYX")
                - (pose * Rotation.from_rotvec(-h * axis)).as_euler("ZYX")
                for axis in np.eye(3)
            ],
            axis=2,
        )
        jacobian = np.angle(np.exp(1j * change)) / (2.0 * h)
        cov = result.covariance[known, 3:, 3:]
        variance = np.einsum("kia,kab,kib->ki", jacobian, cov, jacobian)
        np.testing.assert_allclose(out["angle_sigma"][known][:, columns], np.sqrt(variance), rtol=1e-5)
        matrix = rotation.to_matrix(out["q"][known, i + 1])
        variance = np.einsum("kia,kab,kib->ki", matrix, cov, matrix)
        np.testing.assert_allclose(out["sigma"][known, i + 1], np.sqrt(variance), rtol=1e-11)
        assert np.isnan(out["angle"][~known][:, columns]).all()
        singular = (out["angle_flags"][:, 3 * i] & OrientationFlag.SINGULAR) > 0
        assert singular[7]
        np.testing.assert_array_equal(singular[known], np.abs(np.cos(angle[:, 1])) < np.sin(np.radians(10.0)))


def test_the_longest_request_goes_first_and_the_account_goes_on(written):
    found, _, samples, _, account, out = written
    last = out["scalar"][:, -len(SOURCE_SCALARS) :]
    first, second = found
    later = second.fire_ticks > first.fire_ticks
    none = (first.fire_ticks == 0) & ~later
    for column, name in enumerate(("fire_coil", "fire_current_a", "fire_ticks")):
        asked = np.where(later, getattr(second, name), getattr(first, name))
        np.testing.assert_array_equal(last[:, 2 + column], np.where(none, 0.0, asked))
    coil, current = samples[0, :, at.COIL], samples[0, :, at.CURRENT]
    np.testing.assert_allclose(last[:, 5], STEP_S * (3 + np.cumsum(coil > 0)))
    np.testing.assert_allclose(last[:, 6], 1.0 + STEP_S * np.cumsum(np.abs(current)))
    np.testing.assert_allclose(last[:, 7], 2.0 + STEP_S * np.cumsum(current**2))
    np.testing.assert_allclose(account[1:], last[-1, 6:])


def test_samples_are_those_of_numpy():
    rng = np.random.default_rng(4)
    rate, force, field = rng.normal(size=(3, 3, TICKS, 3))
    quality = np.zeros((3, TICKS), dtype=np.uint8)
    quality[0, 3], quality[1, 5], quality[2, 6] = (
        SampleQuality.MISSING,
        SampleQuality.BRIDGED,
        SampleQuality.SATURATED,
    )
    state = np.zeros((3, TICKS))
    state[1, 10:22] = [1.13, -2.1, 3.0, 4.1, 0.5, 31.9, 32.0, np.nan, np.inf, -np.inf, -3.13, 1.0]
    state[0, 30], state[2, 31], state[2, 32] = 1.13, np.nan, np.inf
    samples, wrong = np.empty((2, TICKS, at.SAMPLE)), np.empty(TICKS, dtype=np.bool_)
    # The second module is the source; views without order in memory, as the alignment gives them.
    kernel.take(rate, np.asfortranarray(force), field, quality, state, 1, 3, samples, wrong)
    coil, current, strange = read_coil_state(np.nan_to_num(state[1]))
    elsewhere = (np.nan_to_num(state[[0, 2]]) != 0.0).any(axis=0)
    np.testing.assert_array_equal(wrong, strange | elsewhere | (coil > 3))
    assert wrong[[13, 14, 15, 16, 18, 19, 30, 32]].all()
    assert wrong.sum() == 8
    for i, row in enumerate((0, 2)):
        lost = ((quality[row] | quality[1]) & 3) > 0
        assert lost.any()
        assert np.isnan(samples[i, lost, : at.COIL]).all()
        for column, values in (
            (at.GYROSCOPE, rate[row]),
            (at.ACCELEROMETER, force[row]),
            (at.FIELD, field[row]),
            (at.SOURCE_GYROSCOPE, rate[1]),
            (at.SOURCE_ACCELEROMETER, force[1]),
        ):
            np.testing.assert_array_equal(samples[i, ~lost, column : column + 3], values[~lost])
        np.testing.assert_array_equal(samples[i, :, at.COIL], coil)
        np.testing.assert_array_equal(samples[i, :, at.CURRENT], current)
    kernel.take(rate, force, np.empty((0, 0, 3)), quality, np.empty((0, 0)), 1, 3, samples, wrong)
    assert np.isnan(samples[0, :, at.FIELD]).all()
    assert not wrong.any()
    assert not samples[:, :, at.COIL :].any()
