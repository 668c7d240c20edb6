"""The filter of markers and a module: contract, truth, Jacobian, identities of the method page (4.4)."""

from itertools import pairwise

import numpy as np
import pytest

from estimators import rotation
from estimators.conventions import GRAVITY_MPS2
from estimators.errors import SetupError, ShapeError
from estimators.optical import Provenance
from estimators.optical import _kernel as kernel
from estimators.optical import _layout as at
from estimators.optical.published import (
    FixedLagSmoother,
    OpticalChunk,
    OpticalInertialFilter,
    OpticalStart,
    gap_report,
    smooth_optical,
    smooth_with_lag,
)
from validation.optical.scenes import PARAMETERS, STEP_S, Scene, free_motion


@pytest.fixture(scope="module")
def scene() -> Scene:
    return free_motion(3, 9.0)


def holed(scene: Scene) -> OpticalChunk:
    hidden = (scene.time_s >= 6.0) & (scene.time_s < 7.0)
    return scene.without(hidden)


def test_samples_chunks_batch_and_a_restored_filter_agree_bit_for_bit(scene: Scene) -> None:
    chunk = holed(scene).ticks(0, 700)
    whole = OpticalInertialFilter(STEP_S, PARAMETERS).update(chunk)
    single = OpticalInertialFilter(STEP_S, PARAMETERS)
    parts = [single.update(chunk.ticks(k, k + 1)) for k in range(300)]
    state = {name: value.copy() for name, value in single.state().items()}
    moved = OpticalInertialFilter(STEP_S, PARAMETERS)
    moved.restore(state)
    edges = [300, 301, 417, 418, 600, 700]
    parts += [moved.update(chunk.ticks(a, b)) for a, b in pairwise(edges)]
    for name in (
        "position_m",
        "velocity_mps",
        "acceleration_mps2",
        "q_room_sensor",
        "position_sigma_m",
        "nis",
    ):
        joined = np.concatenate([getattr(part, name) for part in parts])
        np.testing.assert_array_equal(joined, getattr(whole, name), err_msg=name)


def test_a_gap_is_filled_within_its_sigma_and_smoothing_closes_it(scene: Scene) -> None:
    chunk = holed(scene)
    live = OpticalInertialFilter(STEP_S, PARAMETERS).update(chunk)
    smoothed = smooth_optical(chunk, PARAMETERS)
    gap = slice(600, 700)
    for result, limit_m in ((live, 0.008), (smoothed, 0.0015)):
        error = result.position_m[gap] - scene.position_m[gap]
        assert np.abs(error).max() < limit_m
        assert np.mean(np.abs(error) < 3.0 * result.position_sigma_m[gap]) > 0.97
    assert (live.provenance[gap] == Provenance.FILLED).all()
    started = slice(200, None)
    assert (smoothed.position_sigma_m[started] <= live.position_sigma_m[started] * (1 + 1e-9)).all()
    np.testing.assert_array_equal(smoothed.position_m[-1], live.position_m[-1])
    found = [g for g in gap_report(smoothed, STEP_S) if g.length_s > 0.5]
    assert [(g.start, g.stop, g.withheld) for g in found] == [(600, 700, False)]
    # Noise of the acceleration is that of the accelerometer, a four-hundredth of twice differentiated markers.
    off = smoothed.acceleration_mps2[400:] - scene.acceleration_mps2[400:]
    assert np.sqrt(np.mean(off**2)) < 0.05


def test_a_fixed_lag_closes_gaps_that_the_filter_leaves_open(scene: Scene) -> None:
    chunk = holed(scene)
    live = OpticalInertialFilter(STEP_S, PARAMETERS).update(chunk)
    behind = smooth_with_lag(chunk, 1.5, PARAMETERS)
    assert len(behind.position_m) == len(live.position_m)
    gap = slice(600, 700)
    errors = [np.abs(one.position_m[gap] - scene.position_m[gap]).max() for one in (live, behind)]
    assert errors[1] < 0.0015
    assert errors[1] < 0.5 * errors[0]
    # What has all later samples is the whole recording's smoother.
    whole = FixedLagSmoother(STEP_S, 9.0, PARAMETERS)
    assert len(whole.update(chunk).position_m) == 0
    np.testing.assert_array_equal(whole.flush().position_m, smooth_optical(chunk, PARAMETERS).position_m)


def test_a_fixed_lag_is_the_same_by_samples_by_chunks_and_restored(scene: Scene) -> None:
    chunk = holed(scene).ticks(0, 700)
    whole = smooth_with_lag(chunk, 0.5, PARAMETERS)
    single = FixedLagSmoother(STEP_S, 0.5, PARAMETERS)
    parts = [single.update(chunk.ticks(k, k + 1)) for k in range(260)]
    # A tick is told when two lags have come, so that it has seen one at least.
    assert [len(part.nis) for part in parts].index(50) == 99
    moved = FixedLagSmoother(STEP_S, 0.5, PARAMETERS)
    moved.restore({name: value.copy() for name, value in single.state().items()})
    parts += [moved.update(chunk.ticks(a, b)) for a, b in pairwise([260, 417, 418, 700])]
    parts.append(moved.flush())
    for name in ("position_m", "position_sigma_m", "q_room_sensor", "provenance"):
        joined = np.concatenate([getattr(part, name) for part in parts])
        np.testing.assert_array_equal(joined, getattr(whole, name), err_msg=name)
    with pytest.raises(SetupError, match="lag_s"):
        FixedLagSmoother(STEP_S, 0.001)


def test_smoothing_in_pieces_is_smoothing_at_once(scene: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    from estimators.optical import _fusion

    chunk = holed(scene)
    once = smooth_optical(chunk, PARAMETERS)
    monkeypatch.setattr(_fusion, "_PIECE", 137)
    pieces = smooth_optical(chunk, PARAMETERS)
    np.testing.assert_array_equal(pieces.position_m, once.position_m)
    np.testing.assert_array_equal(pieces.position_sigma_m, once.position_sigma_m)


def test_transition_is_the_derivative_of_the_step() -> None:
    rng = np.random.default_rng(5)
    settings = OpticalInertialFilter(0.01).settings
    nominal = np.concatenate(
        [
            rng.normal(size=6),
            rotation.normalize(rng.normal(size=4)),
            rng.normal(0, 0.05, 6),
            rng.normal(0, 0.1, 3),
        ]
    )
    before, now = rng.normal(0, 3.0, at.MEMORY), rng.normal(0, 3.0, at.SAMPLE)
    phi, unused = np.empty((at.ERRORS, at.ERRORS)), np.empty((at.ERRORS, at.ERRORS))
    after = nominal.copy()
    kernel.predict_state(after, before, now, settings, phi)
    numeric = np.empty_like(phi)
    for j in range(at.ERRORS):
        ends = []
        for step in (1e-6, -1e-6):
            error = np.zeros(at.ERRORS)
            error[j] = step
            moved = nominal.copy()
            kernel.inject(moved, error)
            kernel.predict_state(moved, before, now, settings, unused)
            change = np.empty(at.ERRORS)
            kernel.difference(moved, after, change)
            ends.append(change)
        numeric[:, j] = (ends[0] - ends[1]) / 2e-6
    # Page 4.4.4: what the midpoint attitude leaves in the velocity row.
    assert np.abs(numeric - phi).max() < 5e-4


def test_marker_update_has_the_derivative_of_its_innovation() -> None:
    rng = np.random.default_rng(6)
    nominal = np.concatenate(
        [
            rng.normal(size=6),
            rotation.normalize(rng.normal(size=4)),
            rng.normal(0, 0.05, 6),
            rng.normal(0, 0.1, 3),
        ]
    )
    row = rng.normal(0, 2.0, at.SAMPLE)
    row[at.DELAY] = 0.004
    settings = OpticalInertialFilter(0.01, {"gate": 1e12}).settings
    work, seen = np.empty((at.ERRORS, at.ERRORS)), np.empty(3)

    def innovation(error: np.ndarray) -> np.ndarray:
        moved = nominal.copy()
        kernel.inject(moved, error)
        kernel.update_marker(moved, 1e-30 * np.eye(at.ERRORS), row, settings, 1e12, work, seen)
        return seen.copy()

    numeric = np.stack(
        [(innovation(1e-6 * e) - innovation(-1e-6 * e)) / -2e-6 for e in np.eye(at.ERRORS)], axis=1
    )
    # With P = I the gain is H^T (H H^T + R)^-1: the correction tells H.
    p = np.eye(at.ERRORS)
    h = np.zeros((3, at.ERRORS))
    for i in range(3):
        p[:] = np.eye(at.ERRORS)
        target = row.copy()
        base = nominal.copy()
        expected = row[at.MARKER : at.DELAY] - innovation(np.zeros(at.ERRORS))
        target[at.MARKER : at.DELAY] = expected + 1e-6 * np.eye(3)[i]
        kernel.update_marker(base, p, target, settings, 1e12, work, seen)
        change = np.empty(at.ERRORS)
        kernel.difference(base, nominal, change)
        h[i] = change
    gain = h.T / 1e-6
    expected_gain = numeric.T @ np.linalg.inv(numeric @ numeric.T + 0.0005**2 * np.eye(3))
    # Acceleration and turn within the delay of 4 ms depend on attitude and biases by less than 1e-3.
    np.testing.assert_allclose(gain, expected_gain, atol=1e-3)


def test_turning_and_moving_the_laboratory_turns_and_moves_the_result(scene: Scene) -> None:
    chunk = holed(scene)
    turn, shift = rotation.about_z(0.7), np.array([1.0, -2.0, 0.5])
    other = OpticalChunk(
        0,
        STEP_S,
        chunk.gyroscope_radps,
        chunk.accelerometer_mps2,
        rotation.rotate(turn, chunk.marker_m) + shift,
    )
    one = OpticalInertialFilter(STEP_S, PARAMETERS).update(chunk)
    two = OpticalInertialFilter(STEP_S, {**PARAMETERS, "heading_rad": 0.7}).update(other)
    np.testing.assert_allclose(two.position_m, rotation.rotate(turn, one.position_m) + shift, atol=1e-9)


def test_doubled_noise_scales_the_covariance_and_leaves_the_estimate(scene: Scene) -> None:
    chunk = scene.chunk.ticks(0, 600)
    start = OpticalStart(scene.position_m[0], np.zeros(3), rotation.identity(), np.zeros(3))
    names = ("force_sigma_mps2", "rate_sigma_radps", "marker_sigma_m", "force_walk", "rate_walk")
    biases = ("force_bias_sigma_mps2", "rate_bias_sigma_radps")
    defaults = OpticalInertialFilter(STEP_S).parameters
    results = []
    for factor in (1.0, 2.0):
        live = OpticalInertialFilter(
            STEP_S, {name: factor * defaults[name] for name in names + biases} | {"gate": 1e9}
        )
        sigma = {
            name: factor * getattr(start, name)
            for name in ("position_sigma_m", "velocity_sigma_mps", "tilt_sigma_rad", "heading_sigma_rad")
        }
        live.begin(
            OpticalStart(
                start.position_m, start.velocity_mps, start.q_room_sensor, start.rate_bias_radps, **sigma
            )
        )
        results.append(live.update(chunk))
    # What a heading is told depends on the force over its own noise; both at rest and in movement it stays alike.
    np.testing.assert_allclose(results[1].position_m, results[0].position_m, atol=5e-5)
    np.testing.assert_allclose(results[1].position_sigma_m, 2.0 * results[0].position_sigma_m, rtol=0.05)


def test_ghosts_are_shut_out_and_a_wrong_filter_gives_in(scene: Scene) -> None:
    marker = scene.chunk.marker_m.copy()
    marker[500:505] += 0.2
    chunk = OpticalChunk(0, STEP_S, scene.chunk.gyroscope_radps, scene.chunk.accelerometer_mps2, marker)
    live = OpticalInertialFilter(STEP_S, PARAMETERS).update(chunk)
    assert (live.provenance[500:505] == Provenance.REJECTED).all()
    assert np.abs(live.position_m[500:505] - scene.position_m[500:505]).max() < 0.002
    # The cameras are moved: every marker from now on is elsewhere.
    marker = scene.chunk.marker_m.copy()
    marker[500:] += 0.5
    chunk = OpticalChunk(0, STEP_S, scene.chunk.gyroscope_radps, scene.chunk.accelerometer_mps2, marker)
    live = OpticalInertialFilter(STEP_S, {**PARAMETERS, "recover_s": 1.0}).update(chunk)
    assert (live.provenance == Provenance.RECOVERED).sum() >= 1
    assert np.abs(live.position_m[-1] - scene.position_m[-1] - 0.5).max() < 0.01


def test_a_lever_arm_is_learnt_and_a_turn_about_the_module_is_no_speed() -> None:
    """Page 4.4.10: the module only turns; its marker, 10 cm away, moves."""
    t = np.arange(900) * STEP_S
    begin = np.clip(t - 3.0, 0.0, None) ** 2 / (1.0 + np.clip(t - 3.0, 0.0, None))
    # About two axes: a turn about one tells nothing of the arm along it.
    q = rotation.multiply(
        rotation.about_x(0.8 * begin * np.sin(2.0 * t)), rotation.about_y(0.6 * begin * np.sin(3.0 * t))
    )
    rate = rotation.log(rotation.multiply(rotation.conjugate(q[:-2]), q[2:])) / (2 * STEP_S)
    rate = np.vstack([rate[:1], rate, rate[-1:]])
    force = rotation.rotate(rotation.conjugate(q), np.broadcast_to([0.0, 0.0, GRAVITY_MPS2], (len(t), 3)))
    arm = np.array([0.1, 0.02, -0.03])
    chunk = OpticalChunk(0, STEP_S, rate, force, rotation.rotate(q, arm))
    known = OpticalInertialFilter(STEP_S, {"lever_arm_m": tuple(arm)}).update(chunk)
    assert np.abs(known.velocity_mps[200:]).max() < 0.005
    learnt = OpticalInertialFilter(STEP_S, {"lever_arm_sigma_m": 0.1}).update(chunk)
    np.testing.assert_allclose(learnt.lever_arm_m[-1], arm, atol=0.002)
    assert np.abs(learnt.marker_m[200:] - chunk.marker_m[200:]).max() < 0.002


def test_bad_input_is_told() -> None:
    with pytest.raises(SetupError, match="no parameter wrong"):
        OpticalInertialFilter(0.01, {"wrong": 1.0})
    with pytest.raises(SetupError, match="marker_sigma_m"):
        OpticalInertialFilter(0.01, {"marker_sigma_m": 0.0})
    with pytest.raises(SetupError, match="time_step_s"):
        OpticalInertialFilter(1.0)
    live = OpticalInertialFilter(0.01)
    rest = np.zeros((3, 3))
    with pytest.raises(ShapeError, match="does not follow"):
        live.update(OpticalChunk(5, 0.01, rest, rest, rest))
    with pytest.raises(ShapeError, match="missing"):
        live.update(OpticalChunk(0, 0.01, rest * np.nan, rest, rest))
