"""VQF: the contract, and equality with the package whose algorithm it is."""

from pathlib import Path

import numpy as np
import pytest
from vqf import VQF

from estimators import orientation, rotation
from estimators.orientation import OrientationFlag, orientation_errors
from estimators.recording import ImuChunk
from tests.estimators.orientation.orientation_contract import (
    NO_HEADING,
    STEP_S,
    OrientationContract,
    moving_network,
)

EXCERPT = Path(__file__).parents[2] / "data" / "broad" / "fast_combined_15s.npz"
DISTURBED = int(OrientationFlag.MAGNETIC_DISTURBANCE)
PACKAGE_NAMES = {
    "tauAcc": "accelerometer_time_constant_s",
    "tauMag": "magnetometer_time_constant_s",
    "motionBiasEstEnabled": "motion_bias_estimation",
    "restBiasEstEnabled": "rest_bias_estimation",
    "magDistRejectionEnabled": "magnetic_disturbance_rejection",
    "biasSigmaInit": "bias_sigma_initial_degps",
    "biasForgettingTime": "bias_forgetting_time_s",
    "biasClip": "bias_clip_degps",
    "biasSigmaMotion": "bias_sigma_motion_degps",
    "biasVerticalForgettingFactor": "bias_vertical_forgetting_factor",
    "biasSigmaRest": "bias_sigma_rest_degps",
    "restMinT": "rest_minimum_s",
    "restFilterTau": "rest_time_constant_s",
    "restThGyr": "rest_gyroscope_threshold_degps",
    "restThAcc": "rest_accelerometer_threshold_mps2",
    "magCurrentTau": "magnetic_current_time_constant_s",
    "magRefTau": "magnetic_reference_time_constant_s",
    "magNormTh": "magnetic_norm_tolerance",
    "magDipTh": "magnetic_dip_tolerance_deg",
    "magNewTime": "magnetic_new_field_s",
    "magNewFirstTime": "magnetic_first_field_s",
    "magNewMinGyr": "magnetic_new_field_minimum_degps",
    "magMinUndisturbedTime": "magnetic_minimum_undisturbed_s",
    "magMaxRejectionTime": "magnetic_maximum_rejection_s",
    "magRejectionFactor": "magnetic_rejection_factor",
}


@pytest.fixture(scope="module")
def broad():
    with np.load(EXCERPT) as file:
        return dict(file)


def as_chunk(broad, field=True) -> ImuChunk:
    return ImuChunk(
        0,
        1.0 / float(broad["sampling_rate_hz"]),
        broad["gyroscope_radps"][None],
        broad["accelerometer_mps2"][None],
        broad["magnetometer_ut"][None] * 1e-6 if field else None,
        np.zeros((1, len(broad["gyroscope_radps"])), dtype=np.uint8),
    )


class TestVqf(OrientationContract):
    name = "vqf"

    def test_live_chunks_equal_the_package_on_broad(self, broad):
        step_s = 1.0 / float(broad["sampling_rate_hz"])
        batch = VQF(step_s).updateBatch(
            broad["gyroscope_radps"], broad["accelerometer_mps2"], broad["magnetometer_ut"]
        )
        chunk = as_chunk(broad)
        estimator = orientation.create("vqf", 1, step_s)
        parts = [estimator.update(chunk.ticks(i, i + 5)) for i in range(0, chunk.tick_count, 5)]
        q = np.concatenate([part.q_earth_sensor[0] for part in parts])
        bias = np.concatenate([part.gyroscope_bias_radps[0] for part in parts])
        # Tesla to microtesla and back costs a rounding; the acceptance is 1e-6.
        np.testing.assert_allclose(q, batch["quat9D"], atol=1e-9, rtol=0)
        np.testing.assert_allclose(bias, batch["bias"], atol=1e-9, rtol=0)

    def test_six_axis_equals_the_package_on_broad(self, broad):
        step_s = 1.0 / float(broad["sampling_rate_hz"])
        batch = VQF(step_s).updateBatch(broad["gyroscope_radps"], broad["accelerometer_mps2"])
        result = orientation.create("vqf", 1, step_s).update(as_chunk(broad, field=False))
        np.testing.assert_allclose(result.q_earth_sensor[0], batch["quat6D"], atol=1e-9, rtol=0)

    @pytest.mark.parametrize(
        "changed",
        [
            {"tauAcc": 1.0, "tauMag": 2.0, "magDistRejectionEnabled": False},
            {"motionBiasEstEnabled": False},
            {"restBiasEstEnabled": False, "biasSigmaInit": 1.0, "biasSigmaMotion": 0.3},
            {"motionBiasEstEnabled": False, "restBiasEstEnabled": False},
            {"restBiasEstEnabled": False, "magDistRejectionEnabled": False},
            {
                "magNormTh": 0.02,
                "magDipTh": 1.0,
                "magNewTime": 1.0,
                "magNewFirstTime": 0.5,
                "magMaxRejectionTime": 2.0,
            },
            {"magCurrentTau": 0.0, "magRefTau": 0.0, "tauMag": 0.0},
            {"tauMag": -1.0, "biasClip": 0.1, "restThGyr": 0.3, "restThAcc": 0.1, "restMinT": 0.5},
            {"tauAcc": 0.001, "restFilterTau": 0.1, "biasForgettingTime": 10.0, "biasSigmaRest": 0.1},
            {"biasVerticalForgettingFactor": 0.01, "magRejectionFactor": 5.0, "magNewMinGyr": 5.0},
        ],
        ids=lambda changed: " ".join(changed),
    )
    def test_every_parameter_does_what_it_does_in_the_package(self, broad, changed):
        step_s = 1.0 / float(broad["sampling_rate_hz"])
        field = broad["magnetometer_ut"].copy()
        field[1500:2200] += [30.0, -10.0, 0.0]  # something to reject
        batch = VQF(step_s, **changed).updateBatch(
            broad["gyroscope_radps"], broad["accelerometer_mps2"], field
        )
        estimator = orientation.create("vqf", 1, step_s, {PACKAGE_NAMES[k]: v for k, v in changed.items()})
        result = estimator.update(as_chunk(broad | {"magnetometer_ut": field}))
        np.testing.assert_allclose(result.q_earth_sensor[0], batch["quat9D"], atol=1e-9, rtol=0)
        np.testing.assert_allclose(result.gyroscope_bias_radps[0], batch["bias"], atol=1e-9, rtol=0)

    def test_edge_samples_are_taken_as_in_the_package(self):
        """Zero vectors (skipped), free turning by nothing, upside down at the start, field straight down."""
        gyroscope, accelerometer, field = np.zeros((3, 400, 3))
        accelerometer[:] = [0.0, 0.0, -9.81]
        field[:] = [0.0, 0.0, 40.0]
        field[100:200] = [5.0, 20.0, -30.0]
        gyroscope[150:] = [1.0, -0.5, 2.0]
        accelerometer[120:130] = 0.0
        field[140:150] = 0.0
        batch = VQF(STEP_S).updateBatch(gyroscope, accelerometer, field)
        chunk = ImuChunk(
            0, STEP_S, gyroscope[None], accelerometer[None], field[None] * 1e-6, np.zeros((1, 400), np.uint8)
        )
        result = orientation.create("vqf", 1, STEP_S).update(chunk)
        np.testing.assert_allclose(result.q_earth_sensor[0], batch["quat9D"], atol=1e-9, rtol=0)

    def test_bias_calibration_is_taken_as_in_the_package(self, broad):
        step_s = 1.0 / float(broad["sampling_rate_hz"])
        package = VQF(step_s)
        package.setBiasEstimate(np.array([0.01, -0.02, 0.005]), 0.002)
        batch = package.updateBatch(
            broad["gyroscope_radps"], broad["accelerometer_mps2"], broad["magnetometer_ut"]
        )
        estimator = orientation.create("vqf", 1, step_s)
        estimator.set_gyroscope_bias(np.array([[0.01, -0.02, 0.005]]), 0.002)
        result = estimator.update(as_chunk(broad))
        np.testing.assert_allclose(result.gyroscope_bias_radps[0], batch["bias"], atol=1e-9, rtol=0)

    def test_defaults_are_those_of_the_package(self):
        ours, package = orientation.create("vqf", 1, 0.01).parameters, VQF(0.01).params
        assert {theirs: ours[name] for theirs, name in PACKAGE_NAMES.items()} == package

    def test_accuracy_on_broad(self, broad):
        """Snapshot of 15 s from rest into fast motion; the whole trial scores 4.1 / 3.7 / 1.7 degrees."""
        result = orientation.create("vqf", 1, 1.0 / float(broad["sampling_rate_hz"])).update(as_chunk(broad))
        errors = orientation_errors(
            result.q_earth_sensor[0], broad["q_earth_sensor_optical"], broad["movement"]
        )
        found = np.rad2deg([errors.total_rad, errors.heading_rad, errors.inclination_rad])
        np.testing.assert_allclose(found, [1.823, 1.261, 1.317], atol=0.005)

    def test_magnetometer_latency_is_undone(self):
        chunk, truth = moving_network(noise=0.0, seed=3)
        ticks = np.arange(chunk.tick_count)
        delayed = np.stack(
            [
                np.stack([np.interp(ticks - 1.5, ticks, axis) for axis in sensor.T], axis=-1)
                for sensor in chunk.magnetometer_t
            ]
        )
        late = ImuChunk(0, STEP_S, chunk.gyroscope_radps, chunk.accelerometer_mps2, delayed, chunk.quality)
        errors = []
        for latency_s in (0.0, 0.015):
            estimator = self.create(
                parameters={"magnetometer_latency_s": latency_s, "magnetometer_time_constant_s": 0.2}
            )
            q = self.run(late, estimator=estimator)[0][:, 400:]
            errors.append(np.sqrt(np.mean(rotation.angle_between(q, truth[:, 400:]) ** 2)))
        assert errors[1] < 0.5 * errors[0]

    def test_sigma_covers_the_error_on_broad(self, broad):
        result = orientation.create("vqf", 1, 1.0 / float(broad["sampling_rate_hz"])).update(as_chunk(broad))
        moving = broad["movement"]
        error = rotation.log(
            rotation.multiply(
                result.q_earth_sensor[0][moving], rotation.conjugate(broad["q_earth_sensor_optical"][moving])
            )
        )
        # Two sigma of an honest budget hold about 95 % of the errors.
        assert np.mean(np.abs(error) < 2.0 * result.sigma_rad[0][moving]) > 0.9

    def test_a_magnet_is_flagged_and_then_distrusted(self):
        chunk, _ = moving_network(ticks=6000, seed=2)
        chunk.magnetometer_t[0, 3000:] += [40e-6, 0.0, 0.0]
        flags = self.run(chunk)[3]
        assert not (flags[:, 800:3000] & DISTURBED).any()
        assert np.mean((flags[0, 3100:] & DISTURBED) != 0) > 0.9
        assert not (flags[1:, 3000:] & DISTURBED).any()

    def test_heading_of_a_long_session_without_field_loses_trust_in_sigma(self):
        chunk, _ = moving_network(ticks=3000, field=False)
        _, _, sigma, flags = self.run(chunk)
        assert (sigma[:, 2900, 2] > 1.5 * sigma[:, 800, 2]).all()
        assert (flags & NO_HEADING).all()

    def test_restart_weights_decide_how_much_is_kept(self):
        chunk, truth = moving_network(seed=8)
        gap = np.s_[:, 400:440]
        chunk.gyroscope_radps[gap] = np.nan
        after = []
        for weight_s in (0.0, 5.0):
            parameters = {"restart_inclination_weight_s": weight_s, "restart_heading_weight_s": weight_s}
            q = self.run(chunk, estimator=self.create(parameters=parameters))[0]
            after.append(rotation.angle_between(q[:, 441], truth[:, 441]))
        assert (after[0] < after[1]).all()
