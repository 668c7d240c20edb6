"""Marzouk's Euler-angle filter: contract, dense oracle, derivatives, errata, and the page's protocols."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from estimators import rotation
from estimators.orientation import OrientationFlag
from published.marzouk._angles import euler, halves, quaternion, variances, wrap
from published.marzouk._euler import PUBLISHED_TUNING
from tests.estimators.orientation.orientation_contract import moving_network
from tests.estimators.orientation.published import marzouk_twins as twins
from tests.estimators.orientation.published import thesis_scene as scenes
from tests.estimators.orientation.published.test_marzouk_filters import (
    DEG,
    SEEDS,
    MarzoukContract,
    assert_equal_after_start,
    assert_v4,
    filtered,
    geodesic_deg,
    start_sigma,
)

SINGULAR = int(OrientationFlag.SINGULAR)


class TestEulerFilter(MarzoukContract):
    name = "marzouk_euler_ekf"

    @pytest.mark.parametrize("published", [False, True])
    def test_kernel_equals_the_twin(self, published):
        given = scenes.calibrated(scenes.scene(scenes.hand_motion, 40, 5))
        parameters = dict(PUBLISHED_TUNING) if published else {}
        result, estimator, (found,) = filtered(self.name, [given], parameters)
        angles, bias, covariance, _ = twins.euler_filter(
            given.rate_radps,
            given.gravity_g,
            given.field,
            given.step_s,
            published=published,
            attitude_sigma=start_sigma(given),
        )
        q = np.array([twins.from_euler(e) for e in angles])
        assert_equal_after_start(result, found, estimator, q, bias, covariance)

    def test_without_magnetometer_inclination_holds_and_heading_is_not_trusted(self):
        """As the contract, but for the samples where the filter itself says that it is lost."""
        chunk, truth = moving_network(field=False)
        q, _, _, flags = self.run(chunk)
        assert (flags & int(OrientationFlag.HEADING_NOT_TRUSTED)).all()
        up = np.array([0.0, 0.0, 1.0])
        tilts = [rotation.rotate(rotation.conjugate(a), up) for a in (q, truth)]
        error = np.arccos(np.clip(np.sum(tilts[0] * tilts[1], axis=-1), -1, 1))
        singular = (flags & SINGULAR) != 0
        for s in range(3):
            clear = np.convolve(singular[s], np.ones(100), "full")[: len(error[s])] < 0.5
            assert clear[300:].mean() > 0.7
            assert error[s, 300:][clear[300:]].max() < 2.0 * DEG
            assert error[s, 300:].max() < 6.0 * DEG

    @pytest.mark.parametrize(
        ("parameters", "handle", "published_deg", "limit_deg"),
        [
            (PUBLISHED_TUNING, 0.0, (2.81, 2.48, 5.41), (3.2287, 2.9146, 10.8224)),
            (PUBLISHED_TUNING, scenes.HANDLE, (2.81, 2.48, 8.35), (3.2287, 2.9146, 10.8224)),
            ({}, 0.0, (0.98, 0.87, 1.25), (1.5, 1.5, 2.5)),
            ({}, scenes.HANDLE, (0.98, 0.87, 7.46), (1.5, 1.5, 10.8)),
        ],
        ids=["published", "published, handle", "recommended", "recommended, handle"],
    )
    def test_v4_hand_motion(self, parameters, handle, published_deg, limit_deg):
        assert_v4(self.name, parameters, handle, published_deg, limit_deg)

    def test_clean_input_at_100_hz(self):
        """Check 9 of the page: static error under 0.01 degrees, V4 rotation under 0.6 (first-order steps)."""
        static = scenes.scene(scenes.at_rest, 30, 0, step_s=0.01, noise=0, bias=0)
        moving = scenes.scene(
            lambda t: (scenes.hand_motion(t)[0], np.zeros((t.size, 3))), 60, 0, step_s=0.01, noise=0, bias=0
        )
        for given, limit in ((static, 0.01), (moving, 0.6)):
            _, _, (found,) = filtered(self.name, [given])
            error = (found.inv() * given.true_rotation).magnitude()[given.time_s > 12]
            assert error.max() < limit * DEG

    def test_jacobian_is_the_derivative_of_the_rates(self):
        """V3: against central differences, 1e-7 relative."""
        rng = np.random.default_rng(3)
        for _ in range(50):
            e = rng.uniform(-1, 1, 3) * [3.1, 1.4, 3.1]
            u, h = rng.normal(size=3), 1e-6
            a = twins.euler_jacobian(e, u)
            for i, column in enumerate(np.eye(6)):
                moved = [
                    twins.euler_rates(e + sign * h * column[:3]) @ (u - sign * h * column[3:])
                    for sign in (1, -1)
                ]
                numeric = (moved[0] - moved[1]) / (2 * h)
                np.testing.assert_allclose(
                    a[:3, i], numeric, rtol=1e-7, atol=1e-7 * max(1, np.abs(numeric).max())
                )

    def test_rates_are_those_of_scipy_angles(self):
        rng = np.random.default_rng(5)
        for _ in range(20):
            e, u, h = rng.uniform(-1.2, 1.2, 3), rng.normal(size=3), 1e-6
            turned = rotation.multiply(quaternion(*e), rotation.exp(u * h))
            numeric = (np.array(euler(*turned)) - e) / h
            np.testing.assert_allclose(twins.euler_rates(e) @ u, numeric, rtol=1e-4, atol=1e-4)

    def test_conversions_are_scipys(self):
        """V3: A7 against scipy to 1e-12 for pitch up to 89 degrees."""
        rng = np.random.default_rng(7)
        for yaw, pitch, roll in rng.uniform(-1, 1, (2000, 3)) * [np.pi, 89 * DEG, np.pi]:
            expected = Rotation.from_euler("ZYX", [yaw, pitch, roll])
            found = rotation.to_scipy(np.array(quaternion(roll, pitch, yaw)))
            assert (found.inv() * expected).magnitude() < 1e-12
            back = np.array(euler(*quaternion(roll, pitch, yaw)))
            np.testing.assert_allclose(back, [roll, pitch, yaw], atol=1e-12 / np.cos(pitch))

    def test_variances_are_those_of_sampled_rotations(self):
        rng = np.random.default_rng(9)
        e = np.array([0.7, -0.9, 2.0])
        factor = 1e-3 * rng.normal(size=(6, 6))
        p = factor @ factor.T
        drawn = rng.multivariate_normal(np.zeros(3), p[:3, :3], 40_000)
        there = Rotation.from_euler("ZYX", e[::-1])
        errors = (Rotation.from_euler("ZYX", (e + drawn)[:, ::-1]) * there.inv()).as_rotvec()
        # 40 000 draws know a variance to 0.7 percent.
        np.testing.assert_allclose(variances(halves(*e), p), errors.var(axis=0), rtol=0.03)

    def test_v6_flags_the_singularity_and_recovers(self):
        given = [scenes.scene(scenes.through_the_singularity, 60, s, bias=0) for s in SEEDS]
        for parameters in ({}, PUBLISHED_TUNING):
            result, _, found = filtered(self.name, given, parameters)
            error = geodesic_deg(found, given)
            assert error.mean() < 34.6  # what the page's filter, which does not start anew, reaches
            flagged = (result.flags & SINGULAR) != 0
            assert 0.02 < flagged.mean() < 0.3
            lost = (result.flags & int(OrientationFlag.HEADING_NOT_TRUSTED)) != 0
            assert lost[flagged].all()
            # A second after the zone it is back.
            time_s = given[0].time_s[given[0].time_s > 12]
            for s in range(len(given)):
                near = np.convolve(flagged[s], np.ones(17), "full")[: flagged.shape[1]] > 0
                clear = ~near[given[0].time_s > 12]
                assert error[s][clear].max() < 25.0
                assert np.median(error[s][clear]) < 4.0
            assert time_s.size

    def test_angles_past_the_pole_are_the_same_attitude(self):
        for pitch in (1.7, -1.7, 3.0, -4.0):
            e = np.array([0.3, pitch, -2.0])
            before = Rotation.from_euler("ZYX", e[::-1])
            wrap(e)
            assert abs(e[1]) <= np.pi / 2
            assert (Rotation.from_euler("ZYX", e[::-1]).inv() * before).magnitude() < 1e-12

    def test_e10_printed_update_misses_a_static_attitude(self):
        """E-10: with the continuous Jacobian as transition and P' returned as P, (30, 20, 95) is not found.

        Literal (3.10)-(3.17): A x taken for the next state, P' = A P + P A' + Q returned as P' (1 + Ts).
        At rest A x is nothing, so the gain (1 + Ts)/(2 + Ts) stops half-way [page: 15.5, 10.3, 48.7].
        """
        target = np.array([30.0, 20.0, 95.0]) * DEG
        step_s, q, r = 1 / 17, np.diag(np.concatenate((twins.SIGMA_E, twins.SIGMA_B))), np.diag(twins.SIGMA_E)
        down = Rotation.from_euler("ZYX", target[::-1]).inv()
        s, m = down.apply([0, 0, 1]), down.apply([0.35, 0, 0.94])
        corrected, *_ = twins.euler_filter(
            np.zeros((1000, 3)), np.tile(s, (1000, 1)), np.tile(m, (1000, 1)), step_s, published=True
        )
        np.testing.assert_allclose(corrected[-1], target, atol=1e-6)
        x, p = np.zeros(6), q
        # E-11: the biases are "measured" as zero, without noise.
        z, whole = np.concatenate((target, np.zeros(3))), np.zeros((6, 6))
        whole[:3, :3] = r
        for _ in range(300):
            a = twins.euler_jacobian(x[:3], -x[3:])
            x = a @ x
            p = (a @ p + p @ a.T + q) * (1 + step_s)
            gain = p @ np.linalg.inv(p + whole)
            x, p = x + gain @ (z - x), p - gain @ p
        np.testing.assert_allclose(x[:3] / DEG, [15.5, 10.3, 48.7], atol=0.3)

    def test_nis_of_a_still_record(self):
        """Check 8: normalised innovations squared average 3 +- 0.5 [page: 3.35]."""
        given = scenes.calibrated(scenes.scene(scenes.at_rest, 240, 4))
        *_, nis = twins.euler_filter(given.rate_radps, given.gravity_g, given.field, given.step_s)
        assert np.nanmean(nis[400:]) == pytest.approx(3.0, abs=0.5)
