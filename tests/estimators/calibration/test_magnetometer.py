"""Hard and soft iron: found from simulated turning, honest about coverage, refused with what to do."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from estimators import rotation, signals
from estimators.calibration import LocalField, MagnetometerCollector, TriadCalibration, circle_fit, odd_fields
from estimators.calibration.field.local_field import local_field
from estimators.calibration.field.online_iron import OnlineHardIron
from estimators.conventions import GRAVITY_MPS2
from estimators.errors import CalibrationError, ShapeError
from estimators.simulation import SENSOR_PRESETS, ArmScenario, EarthField, Schedule, simulate_arm
from tests.said import codes, refuses, sentence

NORM_T, DIP_RAD = 49e-6, np.radians(67.0)
EARTH_T = NORM_T * np.array([0.0, np.cos(DIP_RAD), -np.sin(DIP_RAD)])


class Turning:
    """A sensor with iron about it, turned by a person; `spread` is how far, in rad."""

    def __init__(
        self, seed, spread=1.9, soft=0.05, hard_t=20e-6, misaligned_deg=0.0, noise=1.0, samples=3000
    ):
        rng = np.random.default_rng(seed)
        time_s = np.arange(samples) / 100
        waves = [
            spread * np.sin(2 * np.pi * rng.uniform(0.05, 0.25) * time_s + rng.uniform(0, 6))
            for _ in range(3)
        ]
        attitude = Rotation.random(random_state=seed) * Rotation.from_rotvec(np.stack(waves, axis=1))
        self.true_t = attitude.inv().apply(EARTH_T)
        self.force = attitude.inv().apply([0, 0, GRAVITY_MPS2]) + noise * 0.1 * rng.normal(size=(samples, 3))
        shape = rng.normal(size=(3, 3))
        self.iron = np.eye(3) + soft * 0.5 * (shape + shape.T)
        axis = rng.normal(size=3)
        turn = Rotation.from_rotvec(np.radians(misaligned_deg) * axis / np.linalg.norm(axis)).as_matrix()
        self.hard_t = hard_t * rng.normal(size=3)
        clean = self.true_t @ (self.iron @ turn).T + self.hard_t
        self.field_t = clean + noise * 0.3e-6 * rng.normal(size=(samples, 3))
        self.clean_t = clean

    def result(self, **how):
        collector = MagnetometerCollector()
        collector.add(self.field_t, self.force)
        return collector.result(**how)

    def direction_error_deg(self, found):
        corrected = found.calibration.apply(self.clean_t)
        cross = np.linalg.norm(np.cross(corrected, self.true_t), axis=1)
        return np.degrees(np.arctan2(cross, np.sum(corrected * self.true_t, axis=1)))


@pytest.mark.parametrize("seed", range(6))
def test_hard_and_soft_iron_are_found(seed):
    turning = Turning(seed, misaligned_deg=5.0)
    found = turning.result()
    assert found.method == "ellipsoid"
    assert found.coverage > 0.4
    # Uncorrected the direction is off by tens of degrees; the noise of a sample alone is 0.35 degrees.
    assert np.sqrt(np.mean(turning.direction_error_deg(found) ** 2)) < 0.6
    assert np.degrees(found.misalignment_rad) == pytest.approx(
        5.0, abs=3.5
    )  # a symmetric iron turns a little too
    assert np.degrees(found.field.dip_rad) == pytest.approx(67.0, abs=0.5)
    assert found.residual < 0.01
    assert found.score > 0.9


def test_norm_keeps_its_unit_or_takes_the_known_one():
    turning = Turning(3)
    assert turning.result().field.norm == pytest.approx(NORM_T, rel=0.1)
    assert turning.result(norm=NORM_T).field.norm == pytest.approx(NORM_T, rel=0.005)
    turning.field_t = turning.field_t * 1e6  # microtesla, as raw devices give
    assert turning.result().field.norm == pytest.approx(49.0, rel=0.1)


@pytest.mark.parametrize("seed", range(4))
def test_uncertainty_is_honest(seed):
    """The offset of a perfect sphere lies within three reported sigmas."""
    turning = Turning(seed, soft=0.0, spread=1.9)
    found = turning.result()
    heading_deg = np.sqrt(np.mean(turning.direction_error_deg(found) ** 2)) / np.sqrt(2.0) / np.cos(DIP_RAD)
    assert heading_deg < 3.0 * np.degrees(found.heading_sigma_rad) + 0.2


def test_little_coverage_is_enough_only_where_the_soft_iron_is_known():
    turning = Turning(1, spread=0.6, soft=0.0)
    # Nine degrees of heading would be worse than what many a sensor has uncorrected: not to be stored over that.
    with refuses("compass.unusable") as caught:
        turning.result()
    uncertain = sentence([caught.value.message], "compass.heading_uncertain")
    assert np.radians(9.0) < uncertain.parameters["sigma_rad"] < np.radians(10.0)
    assert codes(caught.value.message)[1:] == [
        "compass.heading_uncertain",
        "compass.next_turn",
        "compass.hard_iron_only",
        "compass.next_turn",
    ]
    found = turning.result(known=TriadCalibration())
    assert found.method == "sphere"
    assert found.coverage < 0.4
    assert found.score >= 0.25
    np.testing.assert_allclose(found.calibration.bias, turning.hard_t, atol=3e-6)


def test_known_soft_iron_is_kept_and_hard_iron_found_anew():
    full = Turning(4, misaligned_deg=3.0)
    known = full.result().calibration
    later = Turning(4, spread=0.8, misaligned_deg=3.0)
    later.hard_t = full.hard_t + 8e-6
    later.clean_t = later.clean_t + 8e-6
    later.field_t = later.field_t + 8e-6
    found = later.result(known=known)
    assert found.method == "sphere"
    assert np.median(later.direction_error_deg(found)) < 1.5
    with_old = replace(found, calibration=known)
    assert np.median(later.direction_error_deg(with_old)) > 5.0


@pytest.mark.parametrize(("spread", "code"), [(0.02, "compass.hardly_turned"), (0.25, "compass.next_turn")])
def test_poor_coverage_is_refused_with_what_to_do(spread, code):
    with refuses(code):
        Turning(2, spread=spread).result()


def test_a_field_that_is_not_uniform_is_refused():
    turning = Turning(5)
    place = np.linspace(0, 12, len(turning.field_t))[:, None]
    turning.field_t = turning.field_t + 18e-6 * np.column_stack(
        (np.sin(place), np.sin(1.7 * place), np.cos(place))
    )
    with refuses("compass.not_uniform"):
        turning.result()


def test_progress_grows_and_ends_with_nothing_to_do():
    turning = Turning(0, spread=3.0, samples=6000)
    collector = MagnetometerCollector()
    coverage = []
    for start in range(0, 6000, 500):
        collector.add(turning.field_t[start : start + 500], turning.force[start : start + 500])
        shown = collector.progress()
        coverage.append(shown.coverage)
        assert shown.visited.shape == (len(shown.directions),)
    assert codes(MagnetometerCollector().progress().hint) == ["compass.begin"]
    assert coverage[-1] > 0.8 > coverage[0]
    assert shown.is_complete
    assert shown.residual < 0.02
    assert collector.sample_count == 6000


def test_collector_stays_small_and_skips_holes():
    collector = MagnetometerCollector()
    rng = np.random.default_rng(1)
    field = rng.normal(size=(20_000, 3))
    field = 50e-6 * field / np.linalg.norm(field, axis=1, keepdims=True)
    field[::7] = np.nan
    # The first sample is small against the sphere that follows, so cells must be made coarser on the way.
    collector.add(np.array([[1e-6, 0, 0]]))
    collector.add(field[:9000])
    assert len(collector.cells[0]) <= 900
    assert collector.sample_count == 1 + np.isfinite(field[:9000]).all(axis=1).sum()
    with pytest.raises(ShapeError):
        collector.add(field[:, :2])


def test_local_field_from_a_still_sensor():
    up = np.tile([0.0, 0.0, GRAVITY_MPS2], (50, 1))
    found = local_field(np.tile(EARTH_T, (50, 1)), up)
    assert found.norm == pytest.approx(NORM_T)
    assert found.dip_rad == pytest.approx(DIP_RAD)
    assert found.dip_spread_rad == pytest.approx(0.0, abs=1e-9)
    assert np.isnan(local_field(np.tile(EARTH_T, (5, 1))).dip_rad)
    with pytest.raises(CalibrationError):
        local_field(np.full((5, 3), np.nan))


def test_a_field_that_cannot_be_the_earths_is_doubted():
    earth = LocalField(48e-6, np.radians(66.0), 0.3e-6, 0.01)
    assert earth.doubts("north") == ()
    assert earth.doubts() == ()
    assert codes(earth.doubts("south")) == ["compass.points_down"]
    assert earth.doubts("south")[0].parameters["angle_rad"] == earth.dip_rad
    assert codes(replace(earth, norm=90e-6).doubts("north")) == ["compass.norm_implausible"]
    assert codes(replace(earth, dip_rad=np.radians(84.0)).doubts("north")) == ["compass.hardly_level"]
    upward = replace(earth, dip_rad=-earth.dip_rad).doubts("north")
    assert codes(upward) == ["compass.points_up"]
    assert upward[0].parameters["angle_rad"] == earth.dip_rad, "up by a positive angle"
    # Without an accelerometer, and near the magnetic equator, the dip tells nothing.
    assert replace(earth, dip_rad=np.nan).doubts("south") == ()
    assert replace(earth, dip_rad=np.radians(10.0)).doubts("south") == ()


def test_a_sensor_that_saw_another_field_than_the_others_is_named():
    earth = LocalField(48e-6, np.radians(66.0), 0.3e-6, 0.01)
    three = {"a": earth, "b": replace(earth, norm=49e-6), "c": replace(earth, dip_rad=np.radians(50.0))}
    assert set(odd_fields(three)) == {"c"}
    assert codes(odd_fields(three)["c"]) == ["compass.odd_dip"]
    assert odd_fields(three)["c"].parameters["dip_rad"] == three["c"].dip_rad
    assert set(odd_fields(three | {"c": replace(earth, norm=60e-6)})) == {"c"}
    # Of two nobody knows which one is wrong.
    assert odd_fields({"a": three["a"], "c": three["c"]}) == {}


def level_turns(seed, turns=2.0, tilt=(0.0, 0.0), hard_t=(6e-6, -4e-6, 0.0), noise=1.0, samples=400):
    rng = np.random.default_rng(seed)
    heading = np.linspace(0, 2 * np.pi * turns, samples)
    mount = Rotation.from_euler("XY", tilt)
    attitude = Rotation.from_euler("Z", heading[:, None]) * mount
    hard = mount.inv().apply(hard_t)
    field = attitude.inv().apply(EARTH_T) + hard + noise * 0.3e-6 * rng.normal(size=(samples, 3))
    force = attitude.inv().apply([0, 0, GRAVITY_MPS2]) + noise * 0.1 * rng.normal(size=(samples, 3))
    return field, force, hard


@pytest.mark.parametrize("tilt", [(0.0, 0.0), (0.5, -0.3), (1.5, 0.2)])
def test_two_level_turns_tell_the_hard_iron_across_the_vertical(tilt):
    field, force, hard = level_turns(1, tilt=tilt, noise=0.0)
    found = circle_fit(field, force)
    np.testing.assert_allclose(found.calibration.bias, hard, atol=1e-12)
    assert found.method == "circle"
    assert found.reasons
    field, force, hard = level_turns(2, tilt=tilt)
    np.testing.assert_allclose(circle_fit(field, force).calibration.bias, hard, atol=0.3e-6)


def test_part_of_a_turn_tilt_or_no_turn_are_refused():
    field, force, _ = level_turns(1, turns=0.6)
    with refuses("compass.part_of_turn"):
        circle_fit(field, force)
    field, force, _ = level_turns(1)
    wobble = Rotation.from_euler("X", np.linspace(-1.2, 1.2, len(force))[:, None])
    with refuses("compass.tilted"):
        circle_fit(wobble.apply(field), wobble.apply(force))
    with refuses("compass.field_constant", "compass.part_of_turn"):
        circle_fit(np.tile(EARTH_T, (100, 1)) + 1e-8 * np.random.default_rng(0).normal(size=(100, 3)))
    with refuses("compass.few_samples", samples=5):
        circle_fit(field[:5])


@pytest.fixture(scope="module")
def magnetised():
    """Nobody calibrated the magnetometers: several microtesla of hard iron in each."""
    errors = SENSOR_PRESETS["nominal"]
    errors = replace(errors, magnetometer=replace(errors.magnetometer, bias_sd=6e-6))
    made = simulate_arm(
        ArmScenario(
            exercise="reaching",
            both_arms=True,
            errors=errors,
            schedule=Schedule(repetitions=None, duration_s=60.0),
        )
    )
    chunk = signals.to_common_ticks(made.recording, 100.0)
    true = rotation.rotate(rotation.conjugate(made.truth.q_earth_sensor), EarthField().earth_t)
    return made, chunk, (chunk.magnetometer_t - true).mean(axis=1)


def test_ordinary_exercise_tells_the_hard_iron(magnetised):
    made, chunk, true = magnetised
    online = OnlineHardIron(chunk.sensor_count, chunk.time_step_s)
    online.update(chunk, made.truth.gyroscope_bias_radps[:, 3000])
    error = online.offset_t - true
    arms = [s for s, name in enumerate(made.setup.placements) if name != "sternum"]
    assert online.is_known(2.5e-6)[arms].all()
    assert np.sqrt(np.mean(error[arms] ** 2)) < 0.8e-6
    assert np.abs(error[arms] / online.sigma_t[arms]).max() < 3.5
    # The trunk hardly turned: nothing is claimed about it.
    trunk = made.setup.placements.index("sternum")
    assert not online.is_known()[trunk]
    assert (online.sigma_t[trunk] > 5e-6).all()


def test_online_iron_does_not_mind_chunks_or_a_move(magnetised):
    made, chunk, _ = magnetised
    bias = made.truth.gyroscope_bias_radps[:, 3000]
    whole = OnlineHardIron(chunk.sensor_count, chunk.time_step_s)
    whole.update(chunk.ticks(0, 2500), bias)
    pieces = OnlineHardIron(chunk.sensor_count, chunk.time_step_s)
    start = 0
    for size in (1, 7, 400, 92, 1000, 1000):
        pieces.update(chunk.ticks(start, start + size), bias)
        start += size
        moved = OnlineHardIron(chunk.sensor_count, chunk.time_step_s)
        moved.restore(pieces.state())
        pieces = moved
    assert start == 2500
    np.testing.assert_allclose(pieces.offset_t, whole.offset_t, rtol=0, atol=1e-15)
    np.testing.assert_array_equal(pieces.used, whole.used)


def test_online_iron_survives_gaps_and_missing_magnetometers(magnetised):
    _, chunk, _ = magnetised
    holes = chunk.magnetometer_t.copy()
    holes[1, ::50] = np.nan
    rates = chunk.gyroscope_radps.copy()
    rates[2, 500:600] = np.nan
    online = OnlineHardIron(chunk.sensor_count, chunk.time_step_s)
    online.update(replace(chunk, magnetometer_t=holes, gyroscope_radps=rates))
    assert np.isfinite(online.offset_t).all()
    before = online.offset_t
    np.testing.assert_array_equal(online.update(replace(chunk, magnetometer_t=None)), before)
