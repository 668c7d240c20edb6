"""The complementary filter over the tracker's fixes: contract, dynamics, the white states, both orientations."""

import functools
from dataclasses import fields

import numpy as np
import pytest

from estimators import rotation
from estimators.errors import SetupError, ShapeError
from estimators.magnetic import TrackerFusionChunk, perpendicular_source, smooth_tracker_fusion
from estimators.magnetic.published import TrackerFusion
from estimators.magnetic.tracker import fusion_fix as fix_kernel
from estimators.magnetic.tracker import fusion_kernel as kernel
from estimators.magnetic.tracker import fusion_layout as at
from estimators.magnetic.tracker.fusion_run import difference
from estimators.simulation.coils import ModuleErrors, burst_motion, relative_scene

SIGMAS = np.array([0.006] * 3 + [0.03] * 3)


@functools.cache
def scene_and_chunk():
    """Six seconds of trunk flexion at 120 Hz with a noisy fix every 0.6 s; shared, do not write to it."""
    scene = relative_scene(
        perpendicular_source(), burst_motion("flexion", 6.0, 1), 6.0, 120.0, ModuleErrors(0.05, 0.01), 1
    )
    rng, count = np.random.default_rng(5), len(scene.time_s)
    position, q = np.full((count, 3), np.nan), np.full((count, 4), np.nan)
    covariance = np.full((count, 6, 6), np.nan)
    ticks = np.arange(120, count, 72)
    noise = rng.normal(0.0, SIGMAS, (len(ticks), 6))
    position[ticks] = scene.position_m[ticks] + noise[:, :3]
    q[ticks] = rotation.multiply(scene.q_source_sensor[ticks], rotation.exp(noise[:, 3:]))
    covariance[ticks] = np.diag(SIGMAS**2)
    chunk = TrackerFusionChunk(
        0,
        scene.time_step_s,
        scene.gyroscope_radps - scene.gyroscope_radps[:120].mean(axis=0),
        scene.accelerometer_mps2,
        scene.source_accelerometer_mps2,
        scene.q_world_source,
        rotation.multiply(scene.q_world_source, scene.q_source_sensor),
        position,
        q,
        covariance,
    )
    return scene, chunk


def same(a, b):
    for field in fields(a):
        np.testing.assert_array_equal(getattr(a, field.name), getattr(b, field.name), err_msg=field.name)


def test_stream_chunks_and_restored_state_are_the_batch():
    scene, chunk = scene_and_chunk()
    whole = TrackerFusion(scene.time_step_s).update(chunk)
    parts, state, start = [], None, 0
    # In the standstill, on a fix, single samples, and the rest.
    for stop in (50, 120, 121, 122, 400, chunk.tick_count):
        fusion = TrackerFusion(scene.time_step_s)
        if state is not None:
            fusion.restore(state)
        parts.append(fusion.update(chunk.ticks(start, stop)))
        state, start = fusion.state(), stop
    joined = type(whole)(
        *(np.concatenate([getattr(part, field.name) for part in parts]) for field in fields(whole))
    )
    same(joined, whole)
    with pytest.raises(ShapeError, match="follow"):
        TrackerFusion(scene.time_step_s).update(chunk.ticks(3, 5))
    with pytest.raises(ShapeError, match="stored state"):
        TrackerFusion(scene.time_step_s).restore({})
    with pytest.raises(SetupError, match="no parameter"):
        TrackerFusion(scene.time_step_s, {"nonsense": 1.0})
    with pytest.raises(SetupError, match="gate"):
        TrackerFusion(scene.time_step_s, {"gate": 0.0})


def test_smoothing_beats_the_filter_and_both_are_honest():
    scene, chunk = scene_and_chunk()
    smoothed, filtered = smooth_tracker_fusion(chunk)
    same(filtered, TrackerFusion(scene.time_step_s).update(chunk))
    np.testing.assert_array_equal(smoothed.position_m[-1], filtered.position_m[-1])
    assert not filtered.valid[:120].any()
    assert filtered.valid[120:].all()
    on = scene.time_s > 2.0
    errors = []
    for result in (smoothed, filtered):
        turn = rotation.log(
            rotation.multiply(rotation.conjugate(scene.q_source_sensor), result.q_source_sensor)
        )
        error = np.concatenate([result.position_m - scene.position_m, turn], axis=1)[on]
        errors.append(np.sqrt(np.mean(np.sum(error[:, :3] ** 2, axis=1))))
        covariance = result.covariance[on]
        assert np.linalg.eigvalsh(covariance).min() > 0.0
        np.testing.assert_array_equal(covariance, np.swapaxes(covariance, 1, 2))
        nees = np.mean(np.sum(error * np.linalg.solve(covariance, error[..., None])[..., 0], axis=1)) / 6.0
        assert nees < 2.0
    assert errors[0] < 0.6 * errors[1]
    assert errors[1] < 0.03


def test_error_dynamics_are_the_numeric_ones():
    rng = np.random.default_rng(3)
    settings = TrackerFusion(0.01).arrays()[0]
    nominal = rng.normal(0.0, 0.3, at.NOMINAL)
    nominal[at.ATTITUDE : at.ATTITUDE + 4] = rotation.normalize(rng.standard_normal(4))
    before = rng.normal(0.0, 2.0, at.FILTER_ATTITUDE)
    before[at.SOURCE_ATTITUDE :] = rotation.normalize(rng.standard_normal(4))
    now = before + rng.normal(0.0, 0.01, at.FILTER_ATTITUDE)
    now[at.SOURCE_ATTITUDE :] = rotation.normalize(now[at.SOURCE_ATTITUDE :])
    a, unused = np.empty((at.ERRORS, at.ERRORS)), np.empty((at.ERRORS, at.ERRORS))
    numeric, estimate = np.zeros_like(a), nominal.copy()
    kernel.propagate(estimate, before, now, settings, a)
    for i in (*range(at.E_FIX_POSITION), *range(at.E_FILTER, at.ERRORS)):
        found = []
        for sign in (1.0, -1.0):
            truth, error = nominal.copy(), np.zeros(at.ERRORS)
            error[i] = sign * 1e-6
            kernel.inject(truth, error)
            kernel.propagate(truth, before, now, settings, unused)
            difference(truth, estimate, error)
            found.append(error)
        numeric[:, i] = (found[0] - found[1]) / 2e-6
    kept = np.r_[: at.E_FIX_POSITION, at.E_FILTER : at.ERRORS]
    # First order in the step: what turns within it is left out.
    assert np.abs(numeric - a)[np.ix_(kept, kept)].max() < 1e-3
    assert not a[at.E_FIX_POSITION : at.E_FILTER].any()


def test_white_states_are_measurement_noise():
    """Check 9 of the page: 21 states with white errors of the fix equal 15 with their covariance in R."""
    rng = np.random.default_rng(7)
    root = rng.normal(0.0, 0.1, (at.ERRORS, at.ERRORS))
    p = root @ root.T
    white = slice(at.E_FIX_POSITION, at.E_FILTER)
    p[white] = p[:, white] = 0.0
    r, z = np.diag([1e-4, 2e-4, 3e-4]), np.array([0.01, -0.02, 0.005])
    h, work = np.zeros((3, at.ERRORS)), np.empty((at.ERRORS, at.ERRORS))
    h[:, :3] = np.eye(3)
    outcomes = []
    for folded in (True, False):
        covariance, rows, nominal = p.copy(), h.copy(), np.zeros(at.NOMINAL)
        nominal[at.ATTITUDE] = 1.0
        if not folded:
            rows[:, at.E_FIX_POSITION : at.E_FIX_POSITION + 3] = np.eye(3)
            covariance[
                at.E_FIX_POSITION : at.E_FIX_POSITION + 3, at.E_FIX_POSITION : at.E_FIX_POSITION + 3
            ] = r
        noise = r if folded else 1e-16 * np.eye(3)
        nis = fix_kernel.correct(covariance, rows, noise, z, np.inf, nominal, work)
        covariance[white] = covariance[:, white] = 0.0
        outcomes.append((nis, nominal, covariance))
    for one, other in zip(*outcomes, strict=True):
        np.testing.assert_allclose(one, other, rtol=0.0, atol=1e-9)


def test_a_wrong_fix_is_left_out_and_three_start_anew():
    scene, chunk = scene_and_chunk()
    position = chunk.fix_position_m.copy()
    ticks = np.flatnonzero(np.isfinite(position[:, 0]))
    position[ticks[2]] += 2.0
    position[ticks[4:]] += 2.0
    moved = TrackerFusionChunk(
        *(position if f.name == "fix_position_m" else getattr(chunk, f.name) for f in fields(chunk))
    )
    result = TrackerFusion(scene.time_step_s).update(moved)
    assert result.gated[ticks[[2, 4, 5, 6]]].all()
    assert not result.gated[ticks[[1, 3]]].any()
    assert np.linalg.norm(result.position_m - scene.position_m, axis=1)[ticks[3]] < 0.05
    # The third in a row is believed.
    np.testing.assert_allclose(result.position_m[ticks[6]], position[ticks[6]], atol=1e-9)


def test_a_fix_is_one_measurement_of_pose_and_velocity():
    """Six correlated rows, with what the velocity does to the fix, as a Kalman update written out says."""
    rng = np.random.default_rng(11)
    q_source, q_fix, q = (rotation.normalize(rng.standard_normal(4)) for _ in range(3))
    q_fix = rotation.multiply(
        rotation.multiply(rotation.conjugate(q_source), q), rotation.exp([0.02, 0.0, -0.03])
    )
    root = rng.normal(0.0, 0.02, (6, 6))
    cov, effect, solved = root @ root.T, rng.normal(0.0, 0.05, (6, 3)), rng.normal(0.0, 0.3, 3)
    sample = np.full(at.SAMPLE, np.nan)
    sample[at.SOURCE_ATTITUDE : at.SOURCE_ATTITUDE + 4] = q_source
    sample[at.FIX_ATTITUDE : at.FIX_ATTITUDE + 4] = q_fix
    sample[at.FIX_COVARIANCE : at.FIX_COVARIANCE + 36] = cov.ravel()
    sample[at.FIX_VELOCITY : at.FIX_VELOCITY + 3], sample[at.FIX_EFFECT :] = solved, effect.ravel()
    nominal = np.zeros(at.NOMINAL)
    nominal[at.POSITION : at.POSITION + 6] = rng.normal(0.0, 0.3, 6)
    nominal[at.ATTITUDE : at.ATTITUDE + 4] = q
    place = rotation.rotate(rotation.conjugate(q_source), nominal[:3]) + np.array([0.01, -0.02, 0.015])
    sample[at.FIX_POSITION : at.FIX_POSITION + 3] = place
    root = rng.normal(0.0, 0.1, (at.ERRORS, at.ERRORS))
    p = root @ root.T
    white = slice(at.E_FIX_POSITION, at.E_FILTER)
    p[white] = p[:, white] = 0.0

    source, sensor = rotation.to_matrix(q_source), rotation.to_matrix(rotation.multiply(q_source, q_fix))
    frame = np.block([[source, np.zeros((3, 3))], [np.zeros((3, 3)), sensor]])
    h = np.zeros((6, at.ERRORS))
    h[:3, at.E_POSITION : at.E_POSITION + 3] = h[3:, at.E_ATTITUDE : at.E_ATTITUDE + 3] = np.eye(3)
    h[:, at.E_VELOCITY : at.E_VELOCITY + 3] = frame @ effect @ source.T
    turn = rotation.log(rotation.multiply(rotation.multiply(q_source, q_fix), rotation.conjugate(q)))
    z = np.concatenate([source @ place - nominal[:3], turn])
    z -= frame @ effect @ (source.T @ nominal[at.VELOCITY : at.VELOCITY + 3] - solved)
    gain = p @ h.T @ np.linalg.inv(h @ p @ h.T + frame @ cov @ frame.T)
    error, after = gain @ z, p - gain @ h @ p

    settings = TrackerFusion(0.01, {"use_filter_attitude": False, "fix_gate": 1e9}).arrays()[0]
    noise = np.empty((6, 6))
    fix_kernel.fix_noise(sample, settings, 5.0, noise)
    np.testing.assert_allclose(noise, frame @ cov @ frame.T, atol=1e-15)
    covariance, before = p.copy(), nominal.copy()
    covariance[white, white] = noise
    fix_kernel.use_fix(
        sample,
        settings,
        nominal,
        covariance,
        np.zeros(at.COUNTERS, dtype=np.int64),
        np.empty((at.ERRORS, at.ERRORS)),
        np.empty(1),
    )
    found = np.empty(at.ERRORS)
    difference(nominal, before, found)
    kept = np.r_[: at.E_FIX_POSITION, at.E_FILTER : at.ERRORS]
    np.testing.assert_allclose(found[kept], error[kept], atol=1e-9)
    np.testing.assert_allclose(covariance[np.ix_(kept, kept)], after[np.ix_(kept, kept)], atol=1e-9)


def test_a_lasting_error_of_the_source_filter_does_nothing_to_the_pose():
    """The world is the one that the source's filter says: turned as a whole, it says the same of the sensor."""
    scene, chunk = scene_and_chunk()
    plain = TrackerFusion(scene.time_step_s).update(chunk)
    turn = rotation.exp([0.05, -0.08, 0.6])
    turned = TrackerFusionChunk(
        *(
            rotation.multiply(turn, getattr(chunk, f.name))
            if f.name in ("q_world_source", "q_world_sensor")
            else getattr(chunk, f.name)
            for f in fields(chunk)
        )
    )
    result = TrackerFusion(scene.time_step_s).update(turned)
    np.testing.assert_allclose(result.position_m, plain.position_m, atol=1e-9)
    np.testing.assert_allclose(result.covariance, plain.covariance, atol=1e-9)
    angle = rotation.angle_between(result.q_source_sensor, plain.q_source_sensor)
    assert angle[plain.valid].max() < 1e-6
