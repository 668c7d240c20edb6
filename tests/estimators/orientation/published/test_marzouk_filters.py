"""Marzouk's quaternion filter and its error-state successor: contract, oracle, and the page's protocols."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from estimators import orientation, rotation
from estimators.conventions import GRAVITY_MPS2
from estimators.errors import SetupError
from estimators.orientation import OrientationFlag
from estimators.recording import ImuChunk, SampleQuality
from published.marzouk._quaternion import PUBLISHED_TUNING
from published.marzouk._quaternion_kernel import pitch_row, roll_row, yaw_row
from tests.estimators.orientation.orientation_contract import OrientationContract, moving_network
from tests.estimators.orientation.published import marzouk_twins as twins
from tests.estimators.orientation.published import thesis_scene as scenes

DEG = np.pi / 180.0
SEEDS = range(8)
COASTED = 20
SINGULAR = int(OrientationFlag.SINGULAR)
DISTURBED = int(OrientationFlag.MAGNETIC_DISTURBANCE)


def filtered(name, given, parameters=None, bias_sigma_radps=0.05 * DEG):
    """Run scenes as one network; returns the result, the estimator and R_US per scene."""
    estimator = orientation.create(name, len(given), given[0].step_s, parameters)
    if bias_sigma_radps:
        estimator.set_gyroscope_bias(np.zeros((len(given), 3)), bias_sigma_radps)
    result = estimator.update(scenes.as_chunk(given))
    return result, estimator, [scenes.thesis_rotation(q) for q in result.q_earth_sensor]


class MarzoukContract(OrientationContract):
    gap_hold_after_ticks = COASTED

    def test_short_gap_is_coasted_at_the_last_rate(self):
        chunk, truth = moving_network()
        gap = np.s_[:, 400:415]
        chunk.quality[gap] = int(SampleQuality.MISSING)
        q, _, sigma, flags = self.run(chunk)
        error = rotation.angle_between(q, truth)
        turned = rotation.angle_between(truth[:, 399], truth[:, 414])
        assert (error[:, 414] < 0.5 * turned).all()  # holding still would be wrong by all of it
        assert (np.diff(sigma[:, 399:415].max(axis=2)) > 0).all()
        # The rate was taken to be wrong by 57 deg/s per axis.
        np.testing.assert_allclose(sigma[:, 414, 0], 0.15, rtol=0.1)
        assert (flags[:, 400:415] & int(OrientationFlag.BRIDGED)).all()
        assert not (flags[:, 400:] & int(OrientationFlag.INVALID)).any()

    def test_covariance_stays_symmetric_and_positive(self):
        chunk, _ = moving_network(ticks=600)
        estimator = self.create()
        for k in range(0, 600, 7):
            estimator.update(chunk.ticks(k, k + 7))
            covariance = estimator.covariance
            np.testing.assert_array_equal(covariance, np.swapaxes(covariance, 1, 2))
            eigenvalues = np.linalg.eigvalsh(covariance)
            assert (eigenvalues >= -1e-12 * eigenvalues[:, -1:]).all()

    def test_covariance_survives_certainty_and_doubt(self):
        """Bias known to 1e-9 rad/s beside an attitude just inflated by a coasted gap."""
        chunk, _ = moving_network(ticks=600)
        chunk.quality[:, 300:318] = int(SampleQuality.MISSING)
        estimator = self.create()
        estimator.set_gyroscope_bias(np.zeros((3, 3)), 1e-9)
        result = estimator.update(chunk)
        assert np.isfinite(result.q_earth_sensor).all()
        assert (np.linalg.eigvalsh(estimator.covariance) > -1e-15).all()

    def test_rate_of_samples_does_not_change_how_much_a_second_weighs(self):
        """Uncertainty after one second is the same at 50 and at 200 Hz."""
        found = []
        for rate in (50, 200):
            still = ImuChunk(
                0,
                1.0 / rate,
                np.zeros((1, 4 * rate, 3)),
                np.tile([0.0, 0.0, GRAVITY_MPS2], (1, 4 * rate, 1)),
                np.tile([0.0, 2e-5, -4e-5], (1, 4 * rate, 1)),
                np.zeros((1, 4 * rate), dtype=np.uint8),
            )
            estimator = orientation.create(self.name, 1, 1.0 / rate)
            estimator.set_gyroscope_bias(np.zeros((1, 3)), 1e-4)
            found.append(estimator.update(still).sigma_rad[0, -1])
        np.testing.assert_allclose(found[0], found[1], rtol=0.05)

    def test_norm_of_the_field_does_not_matter(self):
        chunk, _ = moving_network()
        doubled = ImuChunk(
            0,
            chunk.time_step_s,
            chunk.gyroscope_radps,
            chunk.accelerometer_mps2,
            2.0 * chunk.magnetometer_t,
            chunk.quality,
        )
        np.testing.assert_allclose(self.run(doubled)[0], self.run(chunk)[0], atol=1e-12)

    def test_a_magnet_is_flagged_and_then_distrusted(self):
        chunk, _ = moving_network(ticks=2500)
        chunk.magnetometer_t[0, 1000:] += [60e-6, 0.0, 0.0]
        flags = self.run(chunk)[3]
        assert not (flags[:, :1000] & DISTURBED).any()
        assert np.mean((flags[0, 1000:] & DISTURBED) != 0) > 0.5
        assert not (flags[1:] & DISTURBED).any()

    def test_field_that_appears_late_sets_the_heading(self):
        chunk, truth = moving_network()
        chunk.magnetometer_t[:, :300] = np.nan
        q, _, _, flags = self.run(chunk)
        no_heading = int(OrientationFlag.HEADING_NOT_TRUSTED)
        assert (flags[:, 290:300] & no_heading).all()
        assert rotation.angle_between(q, truth)[:, 500:].max() < 8 * DEG

    def test_negative_parameters_are_refused(self):
        with pytest.raises(SetupError, match="negative"):
            self.create(parameters={"coast_s": -1.0})
        with pytest.raises(SetupError, match="above zero"):
            self.create(parameters={"start_samples": 0.0})

    def test_clean_input_at_100_hz(self):
        """Check 9 of the page: static error under 0.01 degrees, V4 rotation under 0.05."""
        static = scenes.scene(scenes.at_rest, 30, 0, step_s=0.01, noise=0, bias=0)
        moving = scenes.scene(
            lambda t: (scenes.hand_motion(t)[0], np.zeros((t.size, 3))), 60, 0, step_s=0.01, noise=0, bias=0
        )
        for given, limit in ((static, 0.01), (moving, 0.05)):
            _, _, (found,) = filtered(self.name, [given])
            error = (found.inv() * given.true_rotation).magnitude()[given.time_s > 12]
            assert error.max() < limit * DEG


class TestQuaternionFilter(MarzoukContract):
    name = "marzouk_quaternion_ekf"

    @pytest.mark.parametrize("published", [False, True])
    def test_kernel_equals_the_twin(self, published):
        given = scenes.calibrated(scenes.scene(scenes.hand_motion, 40, 5))
        parameters = dict(PUBLISHED_TUNING if published else {"singular_weighting": False})
        result, estimator, (found,) = filtered(self.name, [given], parameters)
        q, bias, covariance = twins.quaternion_filter(
            given.rate_radps,
            given.gravity_g,
            given.field,
            given.step_s,
            published=published,
            attitude_sigma=0.5 * start_sigma(given),
        )
        assert_equal_after_start(result, found, estimator, q, bias, covariance)

    def test_rows_are_derivatives_of_the_angles(self):
        """V3: against central differences along the unit sphere, to 1e-7."""
        attitudes = Rotation.random(300, rng=np.random.default_rng(8))
        attitudes = attitudes[np.abs(attitudes.as_euler("ZYX")[:, 1]) < 80 * DEG]
        for q in rotation.from_scipy(attitudes):
            for angle_row, index in ((roll_row, 2), (pitch_row, 1), (yaw_row, 0)):
                sine, cosine, length, *row = angle_row(*q)
                assert np.arctan2(sine, cosine) == pytest.approx(
                    rotation.to_scipy(q).as_euler("ZYX")[index], abs=1e-12
                )
                row = np.array(row) / length
                # The part of the page's row along q, which says that the norm were measured, is left out.
                page = twins.angle_rows(q)[2 - index]
                np.testing.assert_allclose(row, page - (page @ q) * q, atol=1e-11 * np.linalg.norm(page))
                for tangent in twins.xi(q).T:
                    h = 1e-5
                    angles = [
                        np.arctan2(*angle_row(*((q + s * h * tangent) / np.hypot(1, h)))[:2]) for s in (1, -1)
                    ]
                    numeric = twins.wrap(angles[0] - angles[1]) / (2 * np.arctan(h))
                    assert numeric == pytest.approx(row @ tangent, rel=1e-7, abs=1e-7)

    def test_transition_is_the_derivative_of_the_propagation(self):
        """The oracle's Phi, which the kernel equals above, to second order in the step."""
        q, u, step_s = rotation.normalize([0.5, -0.3, 0.7, 0.2]), np.array([0.4, -0.7, 0.3]), 1e-3
        phi = twins.transition(q, u, step_s)
        h = 1e-6
        for i, column in enumerate(np.eye(7)):

            def moved(sign, column=column):
                return twins.product(
                    q + sign * h * column[:4], twins.exponential((u - sign * h * column[4:]) * step_s)
                )

            numeric = (moved(1) - moved(-1)) / (2 * h)
            # The bias acts on half the turn of the step: u step^2 / 8 is 1e-7.
            np.testing.assert_allclose(phi[:4, i], numeric, atol=1e-9 if i < 4 else 2e-7)

    @pytest.mark.parametrize(
        ("parameters", "handle", "published_deg", "limit_deg"),
        [
            (PUBLISHED_TUNING, 0.0, (0.73, 0.58, 0.98), (1.7051, 1.8102, 8.9811)),
            (PUBLISHED_TUNING, scenes.HANDLE, (0.79, 0.54, 7.71), (1.7051, 1.8102, 8.9811)),
            ({}, 0.0, (0.96, 0.65, 0.87), (1.5, 1.2, 2.0)),
            ({}, scenes.HANDLE, (0.96, 0.65, 7.66), (1.7, 1.8, 8.98)),
        ],
        ids=["published", "published, handle", "recommended", "recommended, handle"],
    )
    def test_v4_hand_motion(self, parameters, handle, published_deg, limit_deg):
        assert_v4(self.name, parameters, handle, published_deg, limit_deg)

    def test_v5_bias_states(self):
        given = [scenes.calibrated(scenes.scene(scenes.hand_motion, 130, s), gyroscope=False) for s in SEEDS]
        result, _, _ = filtered(self.name, given, bias_sigma_radps=None)
        final = result.gyroscope_bias_radps[:, -1] / DEG
        np.testing.assert_allclose(final.mean(axis=0), scenes.GYROSCOPE_BIAS_DEGPS, atol=0.3)

    def test_v6_through_the_singularity(self):
        given = [scenes.scene(scenes.through_the_singularity, 60, s, bias=0) for s in SEEDS]
        for parameters, mean_deg, largest_deg in (({}, 1.0, 2.0), (PUBLISHED_TUNING, 4.0, 10.0)):
            result, _, found = filtered(self.name, given, parameters)
            error = geodesic_deg(found, given)
            assert error.mean(axis=1).max() < mean_deg
            assert error.max() < largest_deg
            # The filter flags by its own pitch, which differs from the true one by up to the error.
            pitch = np.abs(found[0].as_euler("ZYX")[:, 1]) / DEG
            flagged = (result.flags[0] & SINGULAR) != 0
            assert flagged[pitch > 85.001].all()
            assert not flagged[pitch < 84.999].any()

    def test_nis_of_a_still_record(self):
        """Check 8: normalised innovations squared of roll, pitch and yaw average 3, a little more as
        yaw is as noisy as roll and pitch together make it."""
        given = scenes.calibrated(scenes.scene(scenes.at_rest, 240, 4))
        q, _, p = twins.quaternion_filter(given.rate_radps, given.gravity_g, given.field, given.step_s)
        nis = []
        for k in range(400, len(q) - 1):
            u = 0.5 * (given.rate_radps[k] + given.rate_radps[k + 1])
            phi = twins.transition(q[k], u, given.step_s)
            noise = np.zeros((7, 7))
            noise[:4, :4] = (
                0.25 * twins.xi(q[k]) @ (given.step_s**2 * np.diag(twins.SIGMA_B)) @ twins.xi(q[k]).T
            )
            prior = phi @ p[k] @ phi.T + noise
            predicted = twins.product(q[k], twins.exponential(u * given.step_s))
            h = np.hstack((twins.angle_rows(predicted), np.zeros((3, 3))))
            z = twins.measured_angles(given.gravity_g[k + 1], given.field[k + 1])
            y = twins.wrap(z - twins.euler(predicted))
            nis.append(y @ np.linalg.solve(h @ prior @ h.T + np.diag(twins.SIGMA_E), y))
        # The page accepts 3 +- 0.5 for the Euler filter; measured angles repeat the accelerometer's noise
        # in the yaw, so the diagonal covariance is a little off.
        assert np.mean(nis) == pytest.approx(3.3, abs=0.5)

    def test_weight_falls_with_motion_when_asked(self):
        chunk, truth = moving_network()
        rng = np.random.default_rng(0)
        chunk.accelerometer_mps2[:, 300:] += (
            4.0 * np.sin(0.02 * np.arange(600))[:, None] * rng.standard_normal((3, 1, 3))
        )
        plain = self.run(chunk)[0]
        weighted = self.run(chunk, estimator=self.create(parameters={"motion_scale_mps2": 0.166}))[0]
        rms = [np.sqrt(np.mean(rotation.angle_between(q, truth)[:, 400:] ** 2)) for q in (plain, weighted)]
        assert rms[1] < 0.5 * rms[0]


class TestErrorStateFilter(MarzoukContract):
    name = "marzouk_error_state_ekf"

    def test_kernel_equals_the_twin(self):
        given = scenes.calibrated(scenes.scene(scenes.hand_motion, 40, 5))
        result, estimator, (found,) = filtered(self.name, [given], {"magnetic_norm_tolerance": 1e9})
        q, bias, covariance = twins.error_state_filter(
            given.rate_radps,
            given.gravity_g,
            given.field,
            given.step_s,
            attitude_sigma=start_sigma(given),
            gate=False,
        )
        to_earth = np.eye(6)
        to_earth[:3, :3] = twins.passive(q[-1]).T
        covariance[-1] = to_earth @ covariance[-1] @ to_earth.T
        assert_equal_after_start(result, found, estimator, q, bias, covariance)

    @pytest.mark.parametrize(
        ("handle", "published_deg", "limit_deg"),
        [(0.0, (0.32, 0.29, 0.63), (0.6, 0.6, 1.5)), (scenes.HANDLE, (0.34, 0.30, 7.22), (0.6, 0.6, 8.98))],
        ids=["clean", "handle"],
    )
    def test_v4_hand_motion(self, handle, published_deg, limit_deg):
        assert_v4(self.name, {}, handle, published_deg, limit_deg)

    def test_a_handle_of_iron_does_not_tilt_it(self):
        means = []
        for handle in (0.0, scenes.HANDLE):
            given = hand_motion_scenes(handle)
            _, _, found = filtered(self.name, given)
            means.append(
                np.mean([scenes.euler_errors_deg(f, g) for f, g in zip(found, given, strict=True)], axis=0)
            )
        np.testing.assert_allclose(means[0][:2], means[1][:2], atol=0.2)

    def test_v6_through_the_singularity(self):
        given = [scenes.scene(scenes.through_the_singularity, 60, s, bias=0) for s in SEEDS]
        _, _, found = filtered(self.name, given)
        error = geodesic_deg(found, given)
        assert error.mean(axis=1).max() < 1.0
        assert error.max() < 2.0

    def test_relabelled_axes_give_the_same_attitude(self):
        """Check 5: isotropic noise, so a sensor glued on another way round is the same filter."""
        chunk, _ = moving_network()
        turn = rotation.normalize([0.3, -0.5, 0.7, 0.4])
        turned = ImuChunk(
            0,
            chunk.time_step_s,
            *(
                rotation.rotate(turn, v)
                for v in (chunk.gyroscope_radps, chunk.accelerometer_mps2, chunk.magnetometer_t)
            ),
            chunk.quality,
        )
        back = rotation.multiply(self.run(turned)[0], turn)
        np.testing.assert_allclose(rotation.angle_between(back, self.run(chunk)[0]), 0.0, atol=1e-9)

    def test_jacobians(self):
        """Transition and measurement rows against differences of the true nonlinear functions."""
        q, u, step_s, h = rotation.normalize([0.6, 0.1, -0.4, 0.3]), np.array([0.5, 0.2, -0.9]), 0.02, 1e-6
        turn = twins.exponential(u * step_s)
        f = np.hstack((twins.passive(turn), -step_s * np.eye(3)))
        down = twins.passive(q)[:, 2]
        field = np.array([0.7, 0.0, 0.7])  # in U

        def propagated(error):
            true = twins.product(q, twins.exponential(error[:3]))
            true = twins.product(true, twins.exponential((u - error[3:]) * step_s))
            return rotation.log(twins.product(rotation.conjugate(twins.product(q, turn)), true))

        def gravity(error):
            return twins.passive(twins.product(q, twins.exponential(error[:3])))[:, 2]

        def heading(error):
            true = twins.product(q, twins.exponential(error[:3]))
            horizontal = twins.passive(q).T @ twins.passive(true) @ field
            return -np.arctan2(horizontal[1], horizontal[0])

        for i, column in enumerate(np.eye(6)):
            numeric = (propagated(h * column) - propagated(-h * column)) / (2 * h)
            # The bias column leaves out half the turn of a step: |u| step^2 / 2 is 2e-4.
            np.testing.assert_allclose(f[:, i], numeric, atol=1e-8 if i < 3 else 3e-4)
        for column in np.eye(3):
            numeric = (gravity(h * column) - gravity(-h * column)) / (2 * h)
            np.testing.assert_allclose(twins.skew(down) @ column, numeric, atol=1e-9)
        # Of the heading the row keeps the turn about the vertical; tilt is not to be read from a field.
        assert (heading(h * down) - heading(-h * down)) / (2 * h) == pytest.approx(down @ down, abs=1e-8)

    def test_nis_of_a_still_record(self):
        """Innovations of gravity across the vertical: two directions, so the mean is two."""
        given = scenes.calibrated(scenes.scene(scenes.at_rest, 240, 4))
        q, _, p = twins.error_state_filter(given.rate_radps, given.gravity_g, given.field, given.step_s)
        nis = []
        for k in range(400, len(q) - 1):
            down = twins.passive(q[k])[:, 2]
            across = np.linalg.svd(down[None])[2][1:]
            y = across @ (given.gravity_g[k + 1] / np.linalg.norm(given.gravity_g[k + 1]) - down)
            h = across @ twins.skew(down)
            prior = p[k][:3, :3] + (0.54 * DEG * given.step_s) ** 2 * np.eye(3)
            nis.append(y @ np.linalg.solve(h @ prior @ h.T + 0.034**2 * np.eye(2), y))
        # The unit's noise is 0.015 g where the filter assumes 0.034 to allow for motion: (15/34)^2 of two.
        assert np.mean(nis) == pytest.approx(2 * (0.0155 / 0.034) ** 2, rel=0.3)


def start_sigma(given, samples=10):
    """What `start_variance` gives for this record."""
    turned = np.linalg.norm(given.rate_radps[:samples].sum(axis=0) * given.step_s)
    push = np.linalg.norm(given.gravity_g[:samples].mean(axis=0)) - 1.0
    return np.sqrt((2 * DEG) ** 2 + turned**2 + push**2)


def assert_equal_after_start(result, found, estimator, q, bias, covariance, samples=10):
    expected = Rotation.from_quat(q[:, [1, 2, 3, 0]])
    difference = (found.inv() * expected).magnitude()[samples:]
    assert difference.max() < 1e-9
    np.testing.assert_allclose(result.gyroscope_bias_radps[0, samples:], bias[samples:], atol=1e-11)
    # q and -q differ in the sign of the quaternion's covariance with the bias.
    np.testing.assert_allclose(np.abs(estimator.covariance[0]), np.abs(covariance[-1]), rtol=1e-6, atol=1e-15)


def hand_motion_scenes(handle):
    return [
        scenes.calibrated(scenes.scene(scenes.hand_motion, 130, seed, body_field=(0, handle, 0)))
        for seed in SEEDS
    ]


def assert_v4(name, parameters, handle, published_deg, limit_deg):
    given = hand_motion_scenes(handle)
    _, _, found = filtered(name, given, parameters)
    errors = np.array([scenes.euler_errors_deg(f, g) for f, g in zip(found, given, strict=True)])
    mean = errors.mean(axis=0)
    assert (mean <= limit_deg).all()
    # Another eight runs differ by 0.01 in roll and pitch and 0.05 in yaw, which moreover lacks the error
    # that the page's A5 makes while the arm is pushed.
    np.testing.assert_array_less(np.abs(mean - published_deg), [0.04, 0.04, 0.2])


def geodesic_deg(found, given):
    return np.array(
        [
            (f.inv() * g.true_rotation).magnitude()[g.time_s > 12] / DEG
            for f, g in zip(found, given, strict=True)
        ]
    )
