"""Sway and reach: an inverted pendulum with sway of known spectrum, on ideal and on cheap sensors."""

import numpy as np
import pytest

from estimators import pipelines, rotation, signals
from estimators.balance.sway import (
    SwayMeasure,
    Trial,
    posture,
    reach,
    romberg_ratio,
    sway_acceleration,
    sway_ellipse,
    sway_measures,
)
from estimators.balance.sway._posture import sway_lean
from estimators.body import BodyDimensions
from estimators.conventions import GRAVITY_MPS2
from estimators.errors import ShapeError
from estimators.pipelines import SessionSetup, hips_above_ankles_m, trunk_above_ankles_m
from estimators.simulation.standing import Lean, Stance, expected_measures, simulate_standing

RATE_HZ = 100.0
HEIGHT_M = hips_above_ankles_m(BodyDimensions())
SETUP = SessionSetup("balance", ("pelvis",), RATE_HZ)


def column(frames, name, span):
    first, stop = (round(bound * RATE_HZ) for bound in span)
    columns = [frames.layout.scalars.index(f"pelvis_{name}")]
    if "forward" in name:
        columns.append(frames.layout.scalars.index(f"pelvis_{name.replace('forward', 'left')}"))
    return frames.scalar[first:stop, columns]


def trial_of(frames, span, sensor_height_m):
    lean = column(frames, "lean_forward_rad", span)
    return Trial(
        sway_acceleration(lean, column(frames, "acceleration_forward_mps2", span)),
        column(frames, "rate_forward_radps", span),
        RATE_HZ,
        sensor_height_m,
        HEIGHT_M,
    )


def followed(trials, seed, errors="nominal"):
    person = simulate_standing(trials, seed, placements=("pelvis",), errors=errors)
    return person, pipelines.run(person.recording, SETUP)[0]


def test_posture_reads_lean_and_acceleration_whichever_way_the_person_faces():
    forward, left = 0.2, -0.1
    tilted = rotation.shortest([0.0, 0.0, 1.0], [np.tan(forward), np.tan(left), 1.0])
    for heading in (0.0, 1.3, -2.9):
        q = rotation.multiply(rotation.about_z(heading), tilted)
        moved = rotation.rotate(rotation.about_z(heading), np.array([0.3, -0.7, 0.0]))
        force = rotation.rotate(rotation.conjugate(q), moved + np.array([0.0, 0.0, GRAVITY_MPS2]))
        lean, acceleration = posture(q, force)
        np.testing.assert_allclose(lean, [forward, left], atol=1e-12)
        # Ahead is where the leaning segment's x axis points over the floor: some milliradians beside the heading.
        np.testing.assert_allclose(np.linalg.norm(acceleration), np.hypot(0.3, 0.7), atol=1e-12)
        np.testing.assert_allclose(acceleration, [0.3, -0.7], atol=0.02)


def test_an_error_of_the_orientation_cancels_in_the_acceleration():
    time = np.arange(0.0, 30.0, 0.01)
    lean = 0.006 * np.sin(2.0 * time)[:, None] * [1.0, 0.5]
    moved = -0.9 * 4.0 * lean
    error = 0.01 * np.sin(0.1 * time)[:, None]
    exact = sway_acceleration(lean, moved)
    found = sway_acceleration(lean + error, moved + GRAVITY_MPS2 * error)
    np.testing.assert_allclose(found, exact, atol=1e-5)


def test_the_lean_of_an_ideal_pendulum_is_found_at_every_frequency():
    time = np.arange(0.0, 60.0, 0.01)
    for frequency in (0.1, 0.2, 0.5, 2.0):
        omega = 2.0 * np.pi * frequency
        lean = 0.006 * np.sin(omega * time)[:, None] * [1.0, 0.5]
        acceleration = -(GRAVITY_MPS2 + 0.9 * omega**2) * lean
        rate = 0.006 * omega * np.cos(omega * time)[:, None] * [1.0, 0.5] + [0.01, -0.02]
        found = sway_lean(acceleration, rate, RATE_HZ, 0.9)
        inside = slice(500, -500)
        np.testing.assert_allclose(found[inside], lean[inside], atol=0.04 * 0.006)


@pytest.mark.slow("a hundred simulated trials, as coverage is a share")
def test_sigma_covers_the_truth_on_a_cheap_sensor():
    stance = Stance(30.0)
    off = {}
    for seed in range(100):
        person, frames = followed([stance], seed)
        trial = trial_of(frames, person.trials_s[0], person.height_m["pelvis"])
        found = sway_measures(trial)
        for name, truth in expected_measures(stance, trial.sensor_height_m, HEIGHT_M).items():
            off.setdefault(name, []).append((found[name].value - truth) / found[name].sigma)
        assert found["path_length"].value == pytest.approx(30.0 * found["sway_speed"].value)
    covered = {name: float(np.mean(np.abs(one) < 2.0)) for name, one in off.items()}
    # Of 100 runs; the mean of a sound one is a standard error of 0.1 from 0, and its own skew.
    assert min(covered.values()) >= 0.88, covered
    assert np.median(list(covered.values())) >= 0.90, covered
    assert max(abs(np.mean(one)) for one in off.values()) < 0.5


def test_noise_is_subtracted_and_not_taken_for_sway():
    person, frames = followed([Stance(30.0, 0.0005, 0.0005)], 3)
    trial = trial_of(frames, person.trials_s[0], person.height_m["pelvis"])
    floors = np.std(trial.acceleration_mps2, axis=0)
    truth = expected_measures(Stance(30.0, 0.0005, 0.0005), trial.sensor_height_m, HEIGHT_M)
    found = sway_measures(trial)["acceleration_rms"]
    assert (floors > 5.0 * truth["acceleration_rms"]).all()
    assert abs(found.value - truth["acceleration_rms"]) < 3.0 * found.sigma


def test_heights_are_those_above_the_ankles_on_which_the_body_turns():
    body = BodyDimensions()
    person = simulate_standing([Stance(10.0)], 5, body=body, errors="ideal")
    for placement, truth_m in person.height_m.items():
        assert trunk_above_ankles_m(placement, body) == pytest.approx(truth_m, abs=0.04), placement
    assert hips_above_ankles_m(body) == pytest.approx(0.491 * body.stature_m)


def test_the_ellipse_lies_along_the_way_and_holds_most_of_it():
    person, frames = followed([Stance(60.0, 0.010, 0.004)], 8, errors="ideal")
    trial = trial_of(frames, person.trials_s[0], person.height_m["pelvis"])
    ellipse = sway_ellipse(trial)
    turn = np.array([np.cos(ellipse.angle_rad), np.sin(ellipse.angle_rad)])
    across = np.array([-turn[1], turn[0]])
    inside = np.hypot(trial.shown_m @ turn / ellipse.long_m, trial.shown_m @ across / ellipse.short_m) < 1.0
    assert 0.90 < inside.mean() < 0.99
    assert abs(turn[0]) > 0.9, "it sways mostly forward and back"


def test_eyes_closed_over_eyes_open():
    ratio = romberg_ratio(SwayMeasure(0.03, 0.003, "m/s"), SwayMeasure(0.02, 0.002, "m/s"))
    assert ratio.value == pytest.approx(1.5)
    assert ratio.unit == "1"
    assert ratio.sigma == pytest.approx(1.5 * np.hypot(0.1, 0.1))
    assert np.isnan(romberg_ratio(ratio, SwayMeasure(float("nan"), 0.1, "m/s")).value)


def test_reaches_are_found_within_their_sigma():
    off = []
    for seed in range(10):
        lean = Lean(0.15 + 0.02 * seed)
        person, frames = followed([lean], seed)
        first, stop = (round(bound * RATE_HZ) for bound in person.trials_s[0])
        sigma = frames.segment_sigma_rad[first:stop, 0, :2].max(axis=1)
        found = reach(column(frames, "lean_forward_rad", person.trials_s[0])[:, 0], sigma, RATE_HZ, HEIGHT_M)
        off.append((found.lean.value - lean.angle_rad) / found.lean.sigma)
        assert found.displacement.value == pytest.approx(HEIGHT_M * np.sin(lean.angle_rad), abs=0.02)
        assert found.lean.value == pytest.approx(lean.angle_rad, abs=0.006)
        # How exactly the N-pose was stood, which this person stands without error, and what an accelerometer's offset
        # may tilt, which this one does not have.
        assert 0.005 < found.lean.sigma < 0.045
        assert 2.5 < found.peak_s < 4.5
    assert np.mean(np.abs(off) < 2.0) >= 0.9, off


def test_short_trials_and_other_shapes_are_refused():
    short = np.zeros((900, 2))
    with pytest.raises(ShapeError):
        Trial(short, short, RATE_HZ, 0.9, 0.9)
    with pytest.raises(ShapeError):
        Trial(np.zeros((2000, 3)), np.zeros((2000, 3)), RATE_HZ, 0.9, 0.9)
    with pytest.raises(ShapeError):
        reach(np.zeros(100), np.zeros(100), RATE_HZ, 0.9)


def test_frames_are_the_same_in_chunks_and_after_a_restart():
    person = simulate_standing([Stance(12.0)], 5)
    chunk = signals.to_common_ticks(person.recording, RATE_HZ)
    setup = SessionSetup("balance", ("pelvis", "sternum"), RATE_HZ)
    whole = pipelines.create(setup)
    whole.step(chunk.ticks(0, 800))
    whole.calibrate(chunk.ticks(300, 800))
    expected = whole.step(chunk.ticks(800, 1900)).scalar
    parts = pipelines.create(setup)
    parts.step(chunk.ticks(0, 800))
    parts.calibrate(chunk.ticks(300, 800))
    first = parts.step(chunk.ticks(800, 1177)).scalar
    other = pipelines.create(setup)
    other.restore(parts.state())
    np.testing.assert_array_equal(
        np.concatenate([first, other.step(chunk.ticks(1177, 1900)).scalar]), expected
    )
    assert np.isfinite(expected).all()
