"""Repetitions against simulated truth: five movements, three levels of impairment, several people."""

from dataclasses import replace

import numpy as np
import pytest

from estimators.comparison import build_template, compare, find_repetitions, judge_repetitions, trajectory
from estimators.pipelines import run
from estimators.simulation import (
    EXERCISES,
    ArmScenario,
    PlannedRepetition,
    Schedule,
    simulate_arm,
    style_of_impairment,
)
from estimators.simulation.arm.exercises import LEG_EXERCISES
from estimators.simulation.arm.scenario import leg_placements

LEVELS = (0.0, 0.35, 0.7)
SEEDS = (11, 12, 13, 14)


def session(exercise, level, seed, **changes):
    scenario = ArmScenario(
        exercise=exercise,
        style=style_of_impairment(level),
        schedule=Schedule(n_pose_s=5.0, repetitions=5),
        placements=("sternum", "upper_arm_right", "forearm_right"),
        seed=seed,
    )
    return simulate_arm(replace(scenario, **changes))


def bounds_error(found, truth):
    return np.abs(np.array([[r.start_s, r.end_s] for r in found]) - truth)


@pytest.mark.parametrize("exercise", sorted(EXERCISES))
@pytest.mark.parametrize("level", LEVELS)
def test_exact_posture(exercise, level):
    errors = []
    for seed in SEEDS:
        made = session(exercise, level, seed, errors="ideal")
        moved = trajectory(made.truth.frames)
        found = find_repetitions(moved, "right")
        assert len(found) == len(made.truth.repetitions_s), f"seed {seed}"
        errors.append(bounds_error(found, made.truth.repetitions_s))
    assert np.median(np.concatenate(errors)) < 0.1
    # The spread that each duration is reported with (0.08 s a bound) is that of mild cases.
    assert np.concatenate(errors).std() < (0.10 if level < 0.5 else 0.35)


@pytest.mark.slow
@pytest.mark.parametrize("exercise", [*sorted(EXERCISES), *LEG_EXERCISES])
def test_two_short_repetitions_among_nine_good_ones_are_found_apart(exercise):
    """Two that follow each other were one, and where one was short its neighbours took parts of it with them."""
    counts = []
    for seed, size, places in (
        (911, 0.4, (5, 6)),
        (912, 0.4, (3, 8)),
        (913, 0.6, (5, 6)),
        (914, 0.6, (3, 8)),
    ):
        plan = tuple(PlannedRepetition(size=size if n in places else 1.0) for n in range(11))
        made = session(
            exercise,
            0.0,
            seed,
            errors="ideal",
            schedule=Schedule(n_pose_s=5.0, repetitions=None, plan=plan),
            **({"placements": leg_placements("right")} if exercise in LEG_EXERCISES else {}),
        )
        counts.append(len(find_repetitions(trajectory(made.truth.frames), "right")))
    # Of these 28 sets 27 are right; 14 were, two of the four of each exercise.
    assert counts.count(11) >= 3, counts


@pytest.mark.slow
@pytest.mark.parametrize("exercise", sorted(EXERCISES))
@pytest.mark.parametrize("level", LEVELS)
def test_estimated_posture(exercise, level):
    errors = []
    for seed in SEEDS[:2]:
        made = session(exercise, level, seed)
        frames, _ = run(made.recording, made.setup, (1.5, 4.5))
        found = find_repetitions(trajectory(frames), "right")
        assert len(found) == len(made.truth.repetitions_s), f"seed {seed}"
        errors.append(bounds_error(found, made.truth.repetitions_s))
    assert np.median(np.concatenate(errors)) < 0.25


@pytest.mark.parametrize("exercise", sorted(EXERCISES))
def test_healthy_repetitions_are_all_kept(exercise):
    for seed in SEEDS:
        moved = trajectory(session(exercise, 0.0, seed, errors="ideal").truth.frames)
        judged = judge_repetitions(moved, find_repetitions(moved, "right"), "right")
        assert all(r.is_kept for r in judged), [r.reason for r in judged]


def test_impairment_shows_in_the_measures():
    """What was simulated (less range, slower, in pieces, trunk lean) is what is reported."""
    reach_m = 0.55
    primary = EXERCISES["reaching"].primary_channel.format(side="right")
    healthy = session("reaching", 0.0, 21)
    frames, _ = run(healthy.recording, healthy.setup, (1.5, 4.5))
    moved = trajectory(frames)
    template = build_template(moved, find_repetitions(moved, "right"), "right", reach_m, primary)
    assert template.repetition_count >= 4
    patient = session("reaching", 0.7, 22)
    frames, _ = run(patient.recording, patient.setup, (1.5, 4.5))
    result = compare(trajectory(frames), template, "right", reach_m)
    value = {m.name: m.value for m in result.summary}
    style = style_of_impairment(0.7)
    assert value[f"range_ratio:{primary}"] == pytest.approx(style.amplitude * 0.93, abs=0.12)
    assert value["duration_ratio"] > 1.6
    assert value["compensation:trunk_lean_forward_rad"] == pytest.approx(style.trunk_lean_rad, abs=0.1)
    assert value["spectral_arc_length"] < template.measures["spectral_arc_length"] - 0.3
    assert value["movement_units"] > template.measures["movement_units"]
    assert result.findings[0].startswith("Compensation: the trunk"), "compensation first"
    assert len([one for one in result.findings if "outside the band" not in one.lower()]) <= 3
    assert any("trunk leaned" in sentence for sentence in result.findings)
    same = compare(moved, template, "right", reach_m)
    assert same.findings == ("The movement matched the template within what can be measured.",)
