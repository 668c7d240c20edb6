"""The relative-pose filter: contract, dynamics against finite differences, accuracy, decisions, faults."""

import itertools
from dataclasses import fields

import numpy as np
import pytest

from estimators import rotation
from estimators.errors import SetupError, ShapeError
from estimators.magnetic import RelativeFlag, RelativePoseFilter, Source, perpendicular_source
from estimators.magnetic.published import SPARING_PARAMETERS
from estimators.magnetic.relative import layout as at
from estimators.magnetic.relative import motion
from estimators.magnetic.relative import pulse as pulses
from estimators.magnetic.relative.smoother import difference, smooth_relative_pose, smooth_table
from estimators.simulation.coils import SourceFaults, relative_motion, relative_scene, run_closed_loop
from tests.estimators.magnetic.relative_scenes import SOURCE, as_chunk, closed_loop


def same(a, b):
    for field in fields(a):
        np.testing.assert_array_equal(getattr(a, field.name), getattr(b, field.name), err_msg=field.name)


def joined(parts):
    return type(parts[0])(
        *(np.concatenate([getattr(part, field.name) for part in parts]) for field in fields(parts[0]))
    )


class TestContract:
    def test_the_loop_equals_the_stream(self):
        _, result, samples, parameters, _ = closed_loop()
        same(RelativePoseFilter(SOURCE, 0.01, parameters).update(as_chunk(samples)), result)

    @pytest.mark.parametrize("seed", [0, 1])
    def test_uneven_chunks_and_single_samples(self, seed):
        _, result, samples, parameters, _ = closed_loop()
        relative, chunk = RelativePoseFilter(SOURCE, 0.01, parameters), as_chunk(samples)
        rng, parts, at_tick = np.random.default_rng(seed), [], 0
        while at_tick < len(samples):
            stop = min(len(samples), at_tick + int(rng.integers(1, 2 + 90 * seed)))
            parts.append(relative.update(chunk.ticks(at_tick, stop)))
            at_tick = stop
        same(joined(parts), result)

    def test_saved_and_restored(self):
        _, result, samples, parameters, _ = closed_loop()
        chunk, parts, state = as_chunk(samples), [], None
        # In the standstill, within the first burst, within a pulse, and later.
        cuts = [0, 120, 221, 230, 511, len(samples)]
        for start, stop in itertools.pairwise(cuts):
            relative = RelativePoseFilter(SOURCE, 0.01, parameters)
            if state is not None:
                relative.restore(state)
            parts.append(relative.update(chunk.ticks(start, stop)))
            state = relative.state()
            assert all(isinstance(values, np.ndarray) for values in state.values())
        same(joined(parts), result)

    def test_bad_input_is_named(self):
        _, _, samples, _, _ = closed_loop()
        relative, chunk = RelativePoseFilter(SOURCE, 0.01), as_chunk(samples)
        with pytest.raises(ShapeError, match="follow"):
            relative.update(chunk.ticks(5, 9))
        with pytest.raises(ShapeError):
            relative.restore({})
        with pytest.raises(SetupError, match="no parameter"):
            RelativePoseFilter(SOURCE, 0.01, {"nonsense": 1.0})
        with pytest.raises(SetupError, match="above zero"):
            RelativePoseFilter(SOURCE, 0.01, {"position_limit_m": 0.0})
        with pytest.raises(SetupError, match="three"):
            RelativePoseFilter(Source(SOURCE.coils[:2]), 0.01)
        with pytest.raises(SetupError, match="current"):
            RelativePoseFilter(perpendicular_source(0.06, current_limit_a=1.0), 0.01)
        with pytest.raises(SetupError, match="samples"):
            RelativePoseFilter(SOURCE, 0.001)


def random_state(seed):
    rng = np.random.default_rng(seed)
    nominal = np.zeros(at.NOMINAL)
    nominal[:6] = rng.normal(0.0, 0.3, 6)
    nominal[at.ATTITUDE : at.ATTITUDE + 4] = rotation.normalize(rng.standard_normal(4))
    nominal[at.FORCE_BIAS :] = rng.normal(0.0, 0.02, 12)
    signals = np.concatenate(
        [rng.normal(0, 2, 3), rng.normal(0, 6, 3), rng.normal(0, 2, 3), rng.normal(0, 6, 3)]
    )
    return nominal, signals


def disturbed(nominal, error):
    """The state with an error put in: injecting takes one out."""
    state = nominal.copy()
    motion.inject(state, -error)
    return state


@pytest.mark.parametrize("published", [False, True])
def test_error_dynamics_are_the_numeric_ones(published):
    """Check 7.7.1: the corrected blocks agree, offsets included; the published block for the attitude does not."""
    nominal, signals = random_state(4)
    step, size, decay = 1e-4, 1e-6, 0.5
    settings = np.zeros(at.SETTINGS)
    settings[at.TIME_STEP], settings[at.BIAS_DECAY], settings[at.PUBLISHED] = step, decay, published
    f = np.zeros((at.ERRORS, at.ERRORS))
    motion.dynamics(nominal, signals, decay, published, f)
    numeric = np.zeros_like(f)
    for i in range(at.ERRORS):
        outcome = []
        for sign in (1.0, -1.0):
            error = np.zeros(at.ERRORS)
            error[i] = sign * size
            state = disturbed(nominal, error)
            # An error of a bias is one of the corrected signal: estimate minus truth is f_hat - f.
            own = signals.copy()
            own[3:6] += error[at.E_FORCE : at.E_FORCE + 3]
            own[0:3] += error[at.E_RATE : at.E_RATE + 3]
            own[9:12] += error[at.E_SOURCE_FORCE : at.E_SOURCE_FORCE + 3]
            own[6:9] += error[at.E_SOURCE_RATE : at.E_SOURCE_RATE + 3]
            motion.mechanise(state, own, step, published)
            motion.relax(state, settings)
            truth = nominal.copy()
            motion.mechanise(truth, signals, step, published)
            motion.relax(truth, settings)
            left = np.zeros(at.ERRORS)
            difference(truth, state, left)
            outcome.append(left)
        numeric[:, i] = (outcome[0] - outcome[1]) / (2.0 * size)
    numeric = (numeric - np.eye(at.ERRORS)) / step
    exact = f + 0.5 * step * f @ f
    error = np.abs(numeric - exact)
    attitude = slice(at.E_ATTITUDE, at.E_ATTITUDE + 3)
    if published:
        assert error[attitude, attitude].max() > 1.0
        # The thesis says that an estimate is forgotten, and keeps it.
        assert error[at.E_FORCE, at.E_FORCE] > 0.9 * decay
    else:
        assert error.max() < 2e-3


def pulse_fields(nominal, trial, rates, delay, h, along):
    """Predict a pulse at its middle, or along three samples of a fast way."""
    value, loops = np.empty(3), SOURCE.loops
    if not along:
        pulses.predict_pulse(loops, 1.0, 1.3, delay, trial, rates, value, h)
        return value
    path = np.zeros((at.PATH, at.PATH_COLUMNS))
    for k, share in enumerate((-1.0, 0.0, 1.0)):
        path[k, :3] = nominal[:3] + share * np.array([0.03, -0.01, 0.02])
        turn = rotation.exp(share * np.array([0.05, 0.1, -0.02]))
        path[k, 3:] = rotation.multiply(turn, rotation.conjugate(nominal[at.ATTITUDE : at.ATTITUDE + 4]))
    pulse = np.array([0.0, 0.0, 0.0, 0.0, 1.3, 2.0, 3.0])
    pulses.predict_path(loops, 1.0, pulse, path, delay, nominal, trial, rates, value, h)
    return value


@pytest.mark.parametrize("along", [False, True])
def test_the_pulse_jacobian_is_the_numeric_one(along):
    nominal, signals = random_state(9)
    nominal[:3] = (0.3, -0.2, 0.25)
    rates, delay = np.concatenate([signals[:3], signals[6:9]]), 0.02
    h = np.zeros((3, at.ERRORS))
    pulse_fields(nominal, nominal, rates, delay, h, along)
    numeric = np.zeros_like(h)
    for i in range(9):
        found = []
        for sign in (1.0, -1.0):
            error = np.zeros(at.ERRORS)
            error[i] = sign * 1e-5
            found.append(
                pulse_fields(nominal, disturbed(nominal, error), rates, delay, np.zeros_like(h), along)
            )
        numeric[:, i] = (found[0] - found[1]) / 2e-5
    assert np.abs(h - numeric).max() / np.abs(numeric).max() < 1e-6


@pytest.mark.parametrize("movement", ["flexion", "walk_leg"])
def test_noise_free_dead_reckoning(movement):
    """Check 7.7.4: within a centimetre five seconds into the movement; the published integral is lost by then."""
    from estimators.simulation.coils import ModuleErrors

    quiet = ModuleErrors(0.0, 0.0, 1e-12, 0.0, 0.0)
    scene = relative_scene(SOURCE, relative_motion(movement, 10.0, 3), 10.0, errors=quiet)
    errors = []
    for published in (False, True):
        nominal = np.zeros(at.NOMINAL)
        nominal[:3], nominal[3:6] = scene.position_m[0], scene.velocity_mps[0]
        nominal[at.ATTITUDE : at.ATTITUDE + 4] = scene.q_source_sensor[0]
        table = np.hstack(
            [
                scene.gyroscope_radps,
                scene.accelerometer_mps2,
                scene.source_gyroscope_radps,
                scene.source_accelerometer_mps2,
            ]
        )
        for k in range(1, 900):
            motion.mechanise(nominal, 0.5 * (table[k - 1] + table[k]), 0.01, published)
        errors.append(np.linalg.norm(nominal[:3] - scene.position_m[899]))
    assert errors[0] < 0.012
    assert errors[1] > 0.2


def test_accuracy_and_consistency():
    scene, result, *_ = closed_loop("shoulder", 20.0, 2)
    on = scene.time_s >= 4.0
    error = np.linalg.norm(result.position_m - scene.position_m, axis=1)[on]
    turn = rotation.angle_between(scene.q_source_sensor, result.q_source_sensor)[on]
    assert np.sqrt(np.mean(error**2)) < 0.025
    assert np.degrees(np.sqrt(np.mean(turn**2))) < 2.5
    assert not (result.flags[on] & int(RelativeFlag.INVALID)).any()
    assert (result.flags[:100] & int(RelativeFlag.CALIBRATING)).all()
    covariance = result.covariance[on]
    np.testing.assert_array_equal(covariance, np.swapaxes(covariance, 1, 2))
    assert np.linalg.eigvalsh(covariance).min() > 0.0


def test_decisions():
    scene, result, samples, _, relative = closed_loop("random", 20.0, 4)
    fired = np.flatnonzero((result.fire_coil > 0) & (scene.time_s > 4.0))
    assert len(fired) > 8
    np.testing.assert_array_equal(np.argmin(result.scores[fired], axis=1) + 1, result.fire_coil[fired])
    above = (result.position_sigma_m > 0.006).any(axis=1) | (result.attitude_sigma_rad > np.radians(2.0)).any(
        axis=1
    )
    assert above[fired].all()
    # The source follows a tick later, for three ticks.
    np.testing.assert_array_equal(samples[fired + 1, at.COIL], result.fire_coil[fired])
    # The last one may not have ended.
    assert relative.energy.pulses == np.sum(result.fire_coil[:-5] > 0)
    assert relative.energy.on_time_s == pytest.approx(np.sum(samples[:, at.COIL] > 0) * 0.01)
    assert relative.energy.heat_j(2.0) == pytest.approx(2.0 * np.sum(samples[:, at.CURRENT] ** 2) * 0.01)


def test_current_and_limits_by_need():
    scene = relative_scene(SOURCE, relative_motion("random", 12.0, 4), 12.0, seed=4)
    found = []
    for own in ({}, {"adaptive_current": True}, {"distance_scaling": True}):
        parameters = (
            dict(SPARING_PARAMETERS) | {"mounting_direction": tuple(scene.position_m[0].tolist())} | own
        )
        result, _ = run_closed_loop(scene, RelativePoseFilter(SOURCE, 0.01, parameters), seed=4)
        fired = (result.fire_coil > 0) & (scene.time_s > 4.0)
        found.append((int(fired.sum()), result.fire_current_a[fired], result.position_sigma_m))
    currents = found[1][1]
    assert (found[0][1] == 1.3).all()
    assert 0.1 <= currents.min() < 1.0
    assert currents.max() <= 1.3
    # Nearer than 0.4 m the limit is lower, so that more is fired and less is uncertain.
    near = (np.linalg.norm(scene.position_m, axis=1) < 0.35) & (scene.time_s > 5.0)
    assert near.sum() > 50
    assert found[2][2][near].max() < found[0][2][near].max()


def test_without_pulses_the_uncertainty_grows_and_says_so():
    scene, result, _, _, _ = closed_loop("flexion", 16.0, 2, SourceFaults(silent_from_s=6.0))
    late = scene.time_s > 12.0
    assert (result.flags[late] & int(RelativeFlag.UNCERTAIN)).all()
    assert np.bitwise_or.reduce(result.flags) & int(RelativeFlag.MISSING_PULSE)
    assert (np.diff(result.position_sigma_m[late].max(axis=1)[::50]) > 0.0).all()
    error = np.linalg.norm(result.position_m - scene.position_m, axis=1)[late]
    assert (error < 3.0 * np.linalg.norm(result.position_sigma_m[late], axis=1)).all()


@pytest.mark.parametrize(
    ("faults", "flag"),
    [
        (SourceFaults(wired_as=(1, 0, 2)), RelativeFlag.FAULT),
        (SourceFaults(wired_as=(1, 2, 0)), RelativeFlag.FAULT),
        (SourceFaults(swapped=True), RelativeFlag.FAULT),
        (SourceFaults(missing_s=(6.0, 6.1)), RelativeFlag.GAP),
        (SourceFaults(lost_share=0.4), RelativeFlag.MISSING_PULSE),
    ],
)
def test_faults_are_flagged(faults, flag):
    scene, result, _, _, _ = closed_loop("shoulder", 9.0, 3, faults)
    assert np.bitwise_or.reduce(result.flags) & int(flag)
    valid = (result.flags & int(RelativeFlag.INVALID)) == 0
    error = np.linalg.norm(result.position_m - scene.position_m, axis=1)[valid]
    assert (error < 4.0 * np.linalg.norm(result.position_sigma_m[valid], axis=1)).all()


def test_smoothing():
    scene, result, samples, parameters, _ = closed_loop("shoulder", 20.0, 2)
    smoothed = smooth_relative_pose(SOURCE, as_chunk(samples), parameters)
    same(smoothed.filtered, result)
    on = scene.time_s >= 4.0
    error = [
        np.sqrt(np.mean(np.sum((p - scene.position_m)[on] ** 2, axis=1)))
        for p in (smoothed.position_m, smoothed.redistributed_position_m, result.position_m)
    ]
    assert error[0] < 0.010
    assert error[0] < error[1] < error[2]
    np.testing.assert_array_equal(smoothed.position_m[-1], result.position_m[-1])
    gain = result.covariance[on] - smoothed.covariance[on]
    scale = np.sqrt(np.einsum("kii,kjj->kij", result.covariance[on], result.covariance[on]))
    assert np.linalg.eigvalsh(gain / scale.max()).min() > -1e-6
    whole = smooth_table(SOURCE, 0.01, samples[:700], parameters)
    assert whole.position_m.shape == (700, 3)
