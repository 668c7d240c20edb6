"""Coils from a bench where only places are known, and where on the bench a sensor lay."""

import numpy as np
import pytest

from estimators import rotation
from estimators.conventions import GRAVITY_MPS2
from estimators.errors import CalibrationError, ShapeError
from estimators.magnetic import Coil, Source, calibrate_at_places, find_stops, perpendicular_source
from estimators.magnetic.published import calibrate_coils, predict

DESIGNED = perpendicular_source(0.06)
TRUE = Source(
    (
        Coil(51.0, centre_m=(0.062, 0.003, -0.002), axis=(1.0, 0.03, 0.02)),
        Coil(49.2, centre_m=(0.001, 0.058, 0.002), axis=(-0.02, 1.0, 0.01)),
        Coil(50.4, centre_m=(-0.002, 0.001, 0.061), axis=(0.01, -0.03, 1.0)),
    )
)
RULER_M = 0.001


def bench(count=24, seed=0, ruler_m=RULER_M, noise_t=1e-8):
    """Return places as typed and the pulses there; the sensor lay somewhere near, in any orientation."""
    rng = np.random.default_rng([seed, 41])
    u = rng.normal(size=(count, 3))
    typed = u / np.linalg.norm(u, axis=1)[:, None] * rng.uniform(0.2, 0.4, (count, 1))
    place = typed + rng.normal(0.0, ruler_m, typed.shape)
    q = rotation.normalize(rng.normal(size=(count, 4)))
    pulses = np.stack([predict(TRUE, k, 1.3, place, q).field_sensor_t for k in range(3)], axis=1)
    return typed, q, pulses + rng.normal(0.0, noise_t, pulses.shape)


def field_error(found):
    rng = np.random.default_rng(7)
    u = rng.normal(size=(400, 3))
    points = u / np.linalg.norm(u, axis=1)[:, None] * rng.uniform(0.25, 0.6, (400, 1))
    shares = []
    for k in range(3):
        true = TRUE.field(k, 1.0, points)
        shares.append(np.sum((found.field(k, 1.0, points) - true) ** 2, axis=1) / np.sum(true**2, axis=1) / 3)
    return float(np.sqrt(np.mean(shares)))


@pytest.mark.slow
def test_places_alone_tell_the_coils_and_how_well_they_are_known():
    ratios, before = [], field_error(DESIGNED)
    for seed in range(8):
        typed, _, pulses = bench(seed=seed)
        found = calibrate_at_places(DESIGNED, typed, pulses, 1.3, 1e-8, RULER_M)
        for coil, true, moment, place, tilt in zip(
            found.source.coils,
            TRUE.coils,
            found.moment_sigma,
            found.place_sigma_m,
            found.direction_sigma_rad,
            strict=True,
        ):
            assert abs(coil.turns / true.turns - 1.0) < 4.5 * moment < 0.05
            assert np.abs(np.subtract(coil.centre_m, true.centre_m)).max() < 4.5 * place < 5e-3
            assert np.arccos(min(1.0, coil.unit_axis @ true.unit_axis)) < 4.5 * tilt < 0.05
        assert 0.002 <= found.gain_sigma < 0.01 < before
        ratios.append((field_error(found.source) / found.gain_sigma) ** 2)
        assert found.place_residual_m < 2.5 * RULER_M
    # What is said of the field is what it is wrong by: 18 unknowns, 8 benches.
    assert 0.4 < np.mean(ratios) < 1.8


def test_known_orientations_tell_more_than_places_alone():
    typed, q, pulses = bench(ruler_m=1e-9)
    both = calibrate_coils(DESIGNED, typed, q, pulses, 1.3, 1e-8)
    assert both.gain_sigma == 0.002
    assert field_error(both.source) < 0.002
    assert both.place_residual_m == 0.0


@pytest.mark.slow
@pytest.mark.parametrize("wrong", ["exchanged", "mirrored", "few", "one side", "iron"])
def test_benches_that_cannot_be_right_are_refused_in_words(wrong):
    typed, _, pulses = bench()
    match = "places"
    if wrong == "exchanged":
        typed = typed[np.r_[1, 0, 2:24]]
    elif wrong == "mirrored":
        typed = typed * [1.0, -1.0, 1.0]
    elif wrong == "few":
        typed, pulses, match = typed[:5], pulses[:5], "6 or more"
    elif wrong == "one side":
        typed, pulses = np.tile(typed[:1], (12, 1)), np.tile(pulses[:1], (12, 1, 1))
    else:
        pulses = pulses + 3e-7 * np.random.default_rng(3).normal(size=pulses.shape)
    with pytest.raises(CalibrationError, match=match):
        calibrate_at_places(DESIGNED, typed, pulses, 1.3, 1e-8, RULER_M)


def test_shapes_are_checked():
    typed, _, pulses = bench()
    with pytest.raises(ShapeError):
        calibrate_at_places(DESIGNED, typed, pulses[:, :2], 1.3, 1e-8)
    pulses[0, 0, 0] = np.nan
    with pytest.raises(ShapeError, match="finite"):
        calibrate_at_places(DESIGNED, typed, pulses, 1.3, 1e-8)


def recording(seconds=4.0, places=3, limit_t=np.inf, noise_t=3e-8, drop_coil=None):
    """Return what is measured while the sensor is laid at places one after the other, carried for 1.5 s between."""
    rng = np.random.default_rng(11)
    typed, q, _ = bench(places, ruler_m=1e-9)
    step, lie, carry = 0.01, round(seconds * 100), 150
    count = places * (lie + carry)
    gyroscope, force = rng.normal([0.01, -0.02, 0.0], 0.004, (count, 3)), rng.normal(0, 0.02, (count, 3))
    field, coil = rng.normal(0.0, noise_t, (count, 3)), np.zeros(count, dtype=int)
    for n in range(places):
        rows = slice(n * (lie + carry), n * (lie + carry) + lie)
        force[rows] += rotation.rotate(rotation.conjugate(q[n]), [0.0, 0.0, GRAVITY_MPS2])
        field[rows] += rotation.rotate(rotation.conjugate(q[n]), [2e-5, 0.0, -4.5e-5])
        for k in range(lie // 25):
            on = slice(rows.start + 25 * k + 12, rows.start + 25 * k + 20)
            coil[on] = k % 3 + 1
            if drop_coil == (n, k % 3):
                coil[on] = 0
            else:
                field[on] += predict(TRUE, k % 3, 1.3, typed[n], q[n]).field_sensor_t
        moved = slice(rows.stop, rows.stop + carry)
        gyroscope[moved] += rng.normal(0.0, 1.0, (carry, 3))
        force[moved] += rng.normal([0.0, 0.0, GRAVITY_MPS2], 3.0, (carry, 3))
    return typed, q, (gyroscope, force, np.clip(field, -limit_t, limit_t), coil, 1.3 * (coil > 0), step)


def test_stops_are_found_with_their_pulses():
    typed, q, measured = recording()
    stops = find_stops(*measured)
    assert len(stops) == 3
    for n, one in enumerate(stops):
        assert 550 * n <= one.start < one.stop <= 550 * n + 405
        assert (one.count >= 4).all()
        true = np.stack([predict(TRUE, k, 1.3, typed[n], q[n]).field_sensor_t for k in range(3)])
        assert np.abs(one.pulses_t - true).max() < 5.0 * one.sigma_t
        assert 3e-9 < one.sigma_t < 2e-8
        np.testing.assert_allclose(one.current_a, 1.3)


def test_a_coil_that_did_not_fire_and_a_magnetometer_at_its_limit():
    _, _, measured = recording(drop_coil=(1, 2))
    assert len(find_stops(*measured)) == 2
    # The earth's field alone is above this limit on an axis of every place.
    _, _, measured = recording(limit_t=2e-5)
    assert not find_stops(*measured, full_scale_t=2e-5)
    gyroscope, *rest = measured
    with pytest.raises(ShapeError):
        find_stops(gyroscope[:-1], *rest)
    assert find_stops(np.full_like(gyroscope, np.nan), *rest) == []
