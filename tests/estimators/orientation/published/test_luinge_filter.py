"""Luinge and Veltink's inclination filter: contract, dense oracles, derivatives, errata, invariances."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from estimators import orientation, rotation
from estimators.conventions import GRAVITY_MPS2 as G
from estimators.errors import SetupError
from estimators.orientation import OrientationFlag
from estimators.recording import ImuChunk, SampleQuality
from published.luinge import PUBLISHED
from tests.estimators.orientation import strapdown_twins as twins
from tests.estimators.orientation.orientation_contract import OrientationContract, moving_network

DEG = np.pi / 180.0
UP = np.array([0.0, 0.0, 1.0])
PAPER = {"rest_update": False, "bias_walk_degps_per_sqrt_s": 3e-3}
NO_HEADING = int(OrientationFlag.HEADING_NOT_TRUSTED)
START = 10


def inclination(found, truth):
    up = [rotation.rotate(rotation.conjugate(q), UP) for q in (found, truth)]
    return np.arctan2(np.linalg.norm(np.cross(*up), axis=-1), np.sum(up[0] * up[1], axis=-1))


def shaken(seed=3, ticks=900, sensors=1):
    """A moving network with pushes of 1 m/s^2 at 1 Hz, besides noise and bias."""
    chunk, truth = moving_network(sensors, ticks, seed)
    time = np.arange(ticks) * 0.01
    push = np.stack([np.sin(6 * time + i) * (time > 2) for i in range(3)], axis=-1)
    force = chunk.accelerometer_mps2 + rotation.rotate(rotation.conjugate(truth), push)
    return (
        ImuChunk(0, 0.01, chunk.gyroscope_radps, force, None, chunk.quality),
        truth,
    )


class LuingeContract(OrientationContract):
    """The contract where the heading is arbitrary: judged by inclination, and by the turn since the start."""

    name = "luinge_inclination"
    gap_hold_after_ticks = 20

    def test_follows_the_truth(self):
        chunk, truth = moving_network(sensors=6)
        q, _, sigma, flags = self.run(chunk)
        assert np.sqrt(np.mean(inclination(q, truth)[:, 300:] ** 2)) < 1.0 * DEG
        # The heading at the start cancels; what is left is its drift.
        since = [rotation.multiply(rotation.conjugate(p[:, 250:251]), p) for p in (q, truth)]
        assert rotation.angle_between(*since)[:, 250:].max() < 5.0 * DEG
        assert (flags & NO_HEADING).all()
        assert not (flags[:, 500:] & int(OrientationFlag.INVALID | OrientationFlag.CONVERGING)).any()
        np.testing.assert_array_less(sigma[:, -1, :2], 2.0 * DEG)

    def test_accurate_again_after_a_long_gap(self):
        chunk, truth = moving_network()
        chunk.quality[:, 400:460] = int(SampleQuality.MISSING)
        q, _, sigma, _ = self.run(chunk)
        error = inclination(q, truth)
        assert (error[:, 460] < 10 * DEG).all()
        assert error[:, 660:].max() < 3.0 * DEG
        # Where it faces was lost in the gap.
        assert (sigma[:, 460 + START :, 2] > 1.5).all()

    def test_the_magnetometer_is_not_used(self):
        chunk, _ = moving_network()
        without, _ = moving_network(field=False)
        for found, expected in zip(self.run(chunk), self.run(without), strict=True):
            np.testing.assert_array_equal(found, expected)

    def test_relabelled_axes_give_the_same_inclination(self):
        """Check 4.4.2: Z and b follow the sensor's axes, the acceleration in the earth frame does not."""
        chunk, _ = shaken()
        m = rotation.normalize([0.3, -0.5, 0.7, 0.4])
        other = ImuChunk(
            0,
            0.01,
            rotation.rotate(m, chunk.gyroscope_radps),
            rotation.rotate(m, chunk.accelerometer_mps2),
            None,
            chunk.quality,
        )
        first, second = (self.create(1, {"report_details": True}).update(c) for c in (chunk, other))
        z = [rotation.rotate(rotation.conjugate(r.q_earth_sensor), UP) for r in (first, second)]
        np.testing.assert_allclose(z[1], rotation.rotate(m, z[0]), atol=1e-9)
        np.testing.assert_allclose(
            second.gyroscope_bias_radps, rotation.rotate(m, first.gyroscope_bias_radps), atol=1e-9
        )
        # The start turns by the least angle, so the arbitrary headings differ: compare up and sideways.
        a, b = first.acceleration_earth_mps2[0, START:], second.acceleration_earth_mps2[0, START:]
        np.testing.assert_allclose(a[:, 2], b[:, 2], atol=1e-8)
        np.testing.assert_allclose(np.hypot(*a[:, :2].T), np.hypot(*b[:, :2].T), atol=1e-8)

    def test_bias_and_its_start_value_cancel(self):
        """Check 4.4.3."""
        chunk, _ = shaken()
        offset = np.array([0.3, -0.2, 0.1])
        moved = ImuChunk(
            0, 0.01, chunk.gyroscope_radps + offset, chunk.accelerometer_mps2, None, chunk.quality
        )
        results = []
        # Uncertainty at the start includes the turn of the first ten samples, in which the bias counts.
        for given, bias in ((chunk, 0 * offset), (moved, offset)):
            estimator = self.create(1, {"start_samples": 1.0})
            estimator.set_gyroscope_bias(bias[None], 0.01)
            results.append(estimator.update(given))
        error = rotation.angle_between(results[0].q_earth_sensor, results[1].q_earth_sensor)
        assert error.max() < 1e-3

    def test_start_heading_does_not_matter(self):
        """Check 4.4.1: turned about the vertical after the start, all else is unchanged."""
        chunk, _ = shaken()
        first, second = self.create(1), self.create(1)
        for estimator in (first, second):
            estimator.update(chunk.ticks(0, 50))
        turn_by = rotation.about_z(1.1)
        state = second.state()
        records = state["state"]
        records["q"] = rotation.multiply(turn_by, records["q"])
        horizontal = np.array(rotation.to_matrix(turn_by))
        records["acceleration"][0] = horizontal @ records["acceleration"][0]
        if not self.create(1).parameters["published_structure"]:
            whole = np.eye(6)
            whole[:3, :3] = horizontal
            state["covariance"][0] = whole @ state["covariance"][0] @ whole.T
        second.restore(state)
        a, b = (e.update(chunk.ticks(50, 900)) for e in (first, second))
        np.testing.assert_allclose(
            np.abs(rotation.multiply(turn_by, a.q_earth_sensor)), np.abs(b.q_earth_sensor), atol=1e-9
        )
        np.testing.assert_allclose(a.gyroscope_bias_radps, b.gyroscope_bias_radps, atol=1e-9)
        np.testing.assert_allclose(
            first.covariance[0, 3:, 3:], second.covariance[0, 3:, 3:], rtol=1e-7, atol=1e-15
        )

    def test_without_trust_in_gravity_it_is_the_gyroscope_alone(self):
        """Check 4.4.5."""
        chunk, _ = shaken()
        q = self.create(
            1, {"accelerometer_sigma_mps2": 1e9, "acceleration_correlation": 0.0, "rest_update": False}
        ).update(chunk)
        strapdown = [q.q_earth_sensor[0, START - 1]]
        for rate in chunk.gyroscope_radps[0, START:]:
            strapdown.append(rotation.multiply(strapdown[-1], rotation.exp(rate * 0.01)))
        assert rotation.angle_between(np.array(strapdown), q.q_earth_sensor[0, START - 1 :]).max() < 1e-6

    def test_covariance_is_symmetric_and_positive(self):
        """Check 4.4.8."""
        chunk, _ = shaken(sensors=2)
        estimator = self.create(2)
        for k in range(0, 900, 9):
            result = estimator.update(chunk.ticks(k, k + 9))
            p = estimator.covariance
            np.testing.assert_array_equal(p, np.swapaxes(p, 1, 2))
            assert np.linalg.eigvalsh(p).min() >= -1e-12
            np.testing.assert_allclose(np.linalg.norm(result.q_earth_sensor, axis=-1), 1.0, atol=1e-12)


class TestConsistentForm(LuingeContract):
    def test_kernel_equals_the_twin(self):
        chunk, _ = shaken()
        estimator = self.create(1, PAPER | {"report_details": True})
        bias = np.array([[0.002, -0.001, 0.003]])
        estimator.set_gyroscope_bias(bias, 0.004)
        before = estimator.update(chunk.ticks(0, START))
        start = rotation.to_scipy(before.q_earth_sensor[0, -1])
        expected = twins.luinge_consistent(
            chunk.gyroscope_radps[0, START:],
            chunk.accelerometer_mps2[0, START:],
            0.01,
            start,
            estimator.covariance[0],
            bias=bias[0],
        )
        result = estimator.update(chunk.ticks(START, 900))
        assert_equal(result, estimator, expected)
        # Whitening: one of the two at a time is the joint one by a triangular factor.
        for k in (5, 300, 800):
            z, s = expected[k][3:]
            nis = z @ np.linalg.solve(s, z)
            assert np.sum(result.whitened_innovations[0, k] ** 2) == pytest.approx(nis, rel=1e-6)

    def test_v14_row_is_the_derivative_with_the_acceleration_from_the_same_orientation(self):
        """E-7: where the model holds, z follows -(1 - c_a) [e_z x] xi and not the published -[(Z + a/g) x]."""
        rng = np.random.default_rng(4)
        c_a, step_s = 0.6, 0.01
        for truth in Rotation.random(20, rng=rng):
            rate, h = rng.normal(size=3), 1e-6
            later = truth * Rotation.from_rotvec(rate * step_s)
            a = rng.normal(size=3)
            y_now = truth.inv().apply(a + G * UP)
            y_then = later.inv().apply(c_a * a + G * UP)

            def innovation(xi, truth=truth, later=later, y_now=y_now, y_then=y_then):
                error = Rotation.from_rotvec(xi)
                kept = (error * truth).apply(y_now) - G * UP
                estimate = error * later
                vertical = y_then - estimate.inv().apply(c_a * kept)
                return (estimate.apply(vertical / np.linalg.norm(vertical)) - UP)[:2]

            numeric = np.stack([(innovation(h * e) - innovation(-h * e)) / (2 * h) for e in np.eye(3)], 1)
            consistent = (-(1 - c_a) * twins.skew(UP))[:2]
            np.testing.assert_allclose(numeric, consistent, atol=1e-5)
            published = (later.as_matrix() @ -twins.skew(later.inv().apply(UP + c_a * a / G)))[:2]
            assert np.abs(numeric - published @ later.as_matrix().T).max() > 0.3

    def test_v11_consistent_where_the_model_holds(self):
        """Normalised squared inclination errors average 2, innovations are white with variance 1."""
        chunk, truth = model_exact(sensors=20, seconds=60, seed=5)
        estimator = self.create(20, PAPER | {"report_details": True})
        estimator.set_gyroscope_bias(np.zeros((20, 3)), 0.0005)
        nees = []
        for k in range(0, chunk.tick_count, 25):
            result = estimator.update(chunk.ticks(k, k + 25))
            if k < 1000:
                continue
            error = rotation.log(
                rotation.multiply(result.q_earth_sensor[:, -1], rotation.conjugate(truth[:, k + 24]))
            )[:, :2]
            nees += [
                e @ np.linalg.solve(p, e) for e, p in zip(error, estimator.covariance[:, :2, :2], strict=True)
            ]
        assert np.mean(nees) == pytest.approx(2.0, abs=0.4)
        again = self.create(20, PAPER | {"report_details": True})
        again.set_gyroscope_bias(np.zeros((20, 3)), 0.0005)
        w = again.update(chunk).whitened_innovations[:, 1000:]
        assert np.var(w) == pytest.approx(1.0, abs=0.05)
        for lag in range(1, 6):
            assert abs(np.mean(w[:, lag:] * w[:, :-lag])) < 0.06

    def test_rest_finds_any_offset_at_once(self):
        """A5.6: 57 degrees a second are found within two seconds, and a movement is not taken for one."""
        chunk, truth = moving_network(sensors=6)
        chunk.gyroscope_radps[:] += 1.0
        estimator = self.create(6, {"initial_bias_sigma_degps": 57.3, "start_samples": 1.0})
        q, bias, _, _ = self.run(chunk, estimator=estimator)
        expected = chunk.gyroscope_radps[:, :200].mean(axis=1)
        np.testing.assert_allclose(bias[:, 199], expected, atol=0.1 * DEG)
        np.testing.assert_allclose(bias[:, -1], expected, atol=0.3 * DEG)
        assert np.sqrt(np.mean(inclination(q, truth)[:, 300:] ** 2)) < 1.0 * DEG

    def test_twice_the_rate_is_as_good(self):
        """Check 4.4.7: rescaled parameters, noise per sample times the root of two; within 15 %."""
        found = []
        for rate in (100, 200):
            rng = np.random.default_rng(1)
            time = np.arange(60 * rate) / rate
            angle = 0.8 * np.sin(2.0 * time)[:, None] * rotation.normalize([0, 1.0, 2.0, -1.0])[1:]
            q = rotation.exp(angle)
            step = rotation.log(rotation.multiply(rotation.conjugate(q[:-1]), q[1:])) * rate
            push = 1.5 * np.stack([np.sin(7 * time), np.cos(6 * time), np.sin(5 * time)], axis=-1)
            noise = np.sqrt(rate / 100) * rng.standard_normal((2, 40, len(time), 3))
            gyroscope = np.concatenate((step[:1], step)) + 0.01 * noise[0]
            force = rotation.rotate(rotation.conjugate(q), push + G * UP) + 0.1 * noise[1]
            quality = np.zeros((40, len(time)), dtype=np.uint8)
            chunk = ImuChunk(0, 1 / rate, gyroscope, force, None, quality)
            estimator = orientation.create(self.name, 40, 1 / rate, self.create().parameters)
            error = inclination(estimator.update(chunk).q_earth_sensor, q)
            found.append(np.sqrt(np.mean(error[:, 10 * rate :] ** 2)))
        assert found[1] == pytest.approx(found[0], rel=0.15)

    def test_the_arbitrary_heading_stays_unobserved(self):
        """What was unknown of it at the start never becomes known: the rows have no part along the vertical."""
        chunk, _ = shaken(ticks=3000)
        sigma = self.create(1, PAPER).update(chunk).sigma_rad[0, START:, 2]
        assert (sigma > 3.0 * DEG).all()

    def test_wrong_parameters_are_refused(self):
        with pytest.raises(SetupError, match="below 1"):
            self.create(parameters={"acceleration_correlation": 1.0})
        with pytest.raises(SetupError, match="above zero"):
            self.create(parameters={"rest_window_s": 0.0})


class TestPublishedStructure(LuingeContract):
    """A4: the same contract; its heading sigma, for which the structure is not fit, says unknown."""

    @classmethod
    def create(cls, sensors=3, parameters=None):
        return orientation.create(cls.name, sensors, 0.01, PUBLISHED | (parameters or {}))

    def test_kernel_equals_the_twin(self):
        chunk, _ = shaken()
        estimator = self.create(1)
        estimator.set_gyroscope_bias(np.full((1, 3), 0.002), 0.004)
        before = estimator.update(chunk.ticks(0, START))
        expected = twins.luinge_published(
            chunk.gyroscope_radps[0, START:],
            chunk.accelerometer_mps2[0, START:],
            0.01,
            rotation.to_scipy(before.q_earth_sensor[0, -1]),
            estimator.covariance[0],
            bias=np.full(3, 0.002),
        )
        assert_equal(estimator.update(chunk.ticks(START, 900)), estimator, expected)

    @pytest.mark.slow
    def test_e1_the_printed_sign_diverges(self):
        chunk, truth = shaken(ticks=2000)
        start = rotation.to_scipy(truth[0, 0])
        p = np.diag([(3 * DEG) ** 2] * 3 + [0.005**2] * 3)
        errors = []
        for sign in (-1.0, 1.0):
            found = twins.luinge_published(
                chunk.gyroscope_radps[0], chunk.accelerometer_mps2[0], 0.01, start, p, sign=sign
            )
            q = np.array([rotation.from_scipy(r) for r, *_ in found])
            errors.append(np.sqrt(np.mean(inclination(q, truth[0])[300:] ** 2)))
        assert errors[0] < 1.5 * DEG
        assert errors[1] > 8 * DEG

    def test_v14_published_row_is_the_derivative_with_the_acceleration_held(self):
        """E-1: -[(Z + a/g) x], after projection off Z; the printed +[(Z - a/g) x] is not."""
        rng = np.random.default_rng(6)
        h = 1e-6
        for truth in Rotation.random(20, rng=rng):
            a = rng.normal(size=3)
            z_s, a_s = truth.inv().apply(UP), truth.inv().apply(a)
            y = a_s + G * z_s

            def innovation(theta, truth=truth, a=a, y=y):
                estimate = truth * Rotation.from_rotvec(theta)
                vertical = y - estimate.inv().apply(a)
                return vertical / np.linalg.norm(vertical) - estimate.inv().apply(UP)

            numeric = np.stack([(innovation(h * e) - innovation(-h * e)) / (2 * h) for e in np.eye(3)], 1)
            across = np.eye(3) - np.outer(z_s, z_s)
            np.testing.assert_allclose(across @ numeric, across @ -twins.skew(z_s + a_s / G), atol=1e-5)
            assert np.abs(across @ (numeric - twins.skew(z_s - a_s / G))).max() > 0.5


def model_exact(sensors, seconds, seed, rate_sd=3.0):
    """S7: acceleration by its own model, turning at random with 3 rad/s."""
    rng = np.random.default_rng(seed)
    ticks = seconds * 100
    shape = (sensors, ticks, 3)
    rate = np.zeros(shape)
    a = np.zeros(shape)
    for k in range(1, ticks):
        rate[:, k] = 0.98 * rate[:, k - 1] + rate_sd * np.sqrt(1 - 0.98**2) * rng.normal(size=(sensors, 3))
        a[:, k] = 0.6 * a[:, k - 1] + 0.4 * rng.normal(size=(sensors, 3))
    q = np.empty((sensors, ticks, 4))
    q[:, 0] = rotation.normalize(rng.normal(size=(sensors, 4)))
    for k in range(1, ticks):
        q[:, k] = rotation.multiply(q[:, k - 1], rotation.exp(rate[:, k] * 0.01))
    force = rotation.rotate(rotation.conjugate(q), a + G * UP) + 0.1 * rng.normal(size=shape)
    gyroscope = rate + 0.01 * rng.normal(size=shape)
    return ImuChunk(0, 0.01, gyroscope, force, None, np.zeros(shape[:2], dtype=np.uint8)), q


def assert_equal(result, estimator, expected):
    q = np.array([rotation.from_scipy(r) for r, *_ in expected])
    assert rotation.angle_between(result.q_earth_sensor[0], q).max() < 1e-9
    np.testing.assert_allclose(result.gyroscope_bias_radps[0], [b for _, b, *_ in expected], atol=1e-11)
    np.testing.assert_allclose(estimator.covariance[0], expected[-1][2], rtol=1e-6, atol=1e-16)
