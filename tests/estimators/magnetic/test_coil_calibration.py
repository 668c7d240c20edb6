"""Coils are found back from pulses at known poses."""

import numpy as np
import pytest

from estimators import rotation
from estimators.errors import CalibrationError, ShapeError
from estimators.magnetic import Coil, Source, perpendicular_source
from estimators.magnetic.published import calibrate_coils, calibrate_moments, predict

DESIGNED = perpendicular_source(0.06)
TRUE = Source(
    (
        Coil(51.0, centre_m=(0.062, 0.003, -0.002), axis=(1.0, 0.03, 0.02)),
        Coil(49.2, centre_m=(0.001, 0.058, 0.002), axis=(-0.02, 1.0, 0.01)),
        Coil(50.4, centre_m=(-0.002, 0.001, 0.061), axis=(0.01, -0.03, 1.0)),
    )
)


def measured(count, noise=1e-8, low=0.15, high=0.35, seed=0):
    rng = np.random.default_rng(seed)
    u = rng.normal(size=(count, 3))
    u /= np.linalg.norm(u, axis=1)[:, None]
    p, q = u * rng.uniform(low, high, (count, 1)), rotation.normalize(rng.normal(size=(count, 4)))
    pulses = np.stack([predict(TRUE, k, 1.3, p, q).field_sensor_t for k in range(3)], axis=1)
    return p, q, pulses + rng.normal(0.0, noise, pulses.shape)


def test_coils_are_found_within_their_errors():
    p, q, pulses = measured(24)
    found = calibrate_coils(DESIGNED, p, q, pulses, 1.3, 1e-8)
    for coil, true, moment, place, tilt in zip(
        found.source.coils,
        TRUE.coils,
        found.moment_sigma,
        found.place_sigma_m,
        found.direction_sigma_rad,
        strict=True,
    ):
        assert abs(coil.turns / true.turns - 1.0) < 4 * moment < 0.01
        assert np.abs(np.subtract(coil.centre_m, true.centre_m)).max() < 4 * place < 2e-3
        assert np.arccos(min(1.0, coil.unit_axis @ true.unit_axis)) < 4 * tilt < 0.02
    assert found.residual_t == pytest.approx(1e-8, rel=0.2)


def test_moments_from_one_coaxial_measurement():
    strength = [
        float(TRUE.field(k, 1.5, np.array(coil.centre_m) + 0.3 * coil.unit_axis) @ coil.unit_axis)
        for k, coil in enumerate(TRUE.coils)
    ]
    found = calibrate_moments(DESIGNED, 0.3, strength, 1.5)
    np.testing.assert_allclose([coil.turns for coil in found.coils], [51.0, 49.2, 50.4], rtol=1e-9)
    with pytest.raises(ShapeError):
        calibrate_moments(DESIGNED, 0.3, [1e-6], 1.5)


def test_unusable_calibrations_are_refused():
    p, q, pulses = measured(3)
    with pytest.raises(CalibrationError, match="4 or more"):
        calibrate_coils(DESIGNED, p, q, pulses, 1.3, 1e-8)
    p, q, pulses = measured(12)
    with pytest.raises(CalibrationError, match="iron"):
        calibrate_coils(
            DESIGNED, p, q, pulses + 1e-6 * np.random.default_rng(1).normal(size=pulses.shape), 1.3, 1e-8
        )
    same = np.tile(p[:1], (12, 1)), np.tile(q[:1], (12, 1)), np.tile(pulses[:1], (12, 1, 1))
    with pytest.raises(CalibrationError, match="directions"):
        calibrate_coils(DESIGNED, *same, 1.3, 1e-8)
    with pytest.raises(ShapeError):
        calibrate_coils(DESIGNED, p, q, pulses[:, :2], 1.3, 1e-8)
