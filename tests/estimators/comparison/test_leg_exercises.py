"""Exercises of a leg by a simulated patient: angles against truth, repetitions, faults named, and guidance."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from estimators.comparison import Repetition, build_template, compare, find_repetitions, trajectory
from estimators.guidance import Guide, default_rules, prepare_template, signals
from estimators.pipelines import run
from estimators.simulation import (
    ArmScenario,
    Mounting,
    PlannedRepetition,
    Schedule,
    demonstration_scenario,
    simulate_arm,
)
from estimators.simulation.arm.exercises import LEG_EXERCISES
from estimators.simulation.arm.scenario import leg_placements
from tests.said import codes, sentence

SOUND = PlannedRepetition()
SHORT, SLOW, FAST = PlannedRepetition(size=0.62), PlannedRepetition(pace=0.5), PlannedRepetition(pace=1.9)
LEANING = PlannedRepetition(lean_rad=float(np.radians(-16.0)))
PLAN = (SOUND, SHORT, SOUND, SLOW, SOUND, FAST, SOUND, LEANING, SOUND)
FAULTS = {"smaller": SHORT, "slower": SLOW, "faster": FAST, "trunk": LEANING}
POSE_S = (2.0, 8.0)
REACH_M = 0.55


def primary(exercise, side="right"):
    return LEG_EXERCISES[exercise].primary_channel.format(side=side)


@cache
def done(exercise, plan, side="right", seed=3, soft_tissue_rad=0.0):
    """Let somebody do what is planned; returns the simulation and the estimated frames."""
    made = simulate_arm(
        ArmScenario(
            exercise=exercise,
            side=side,
            schedule=Schedule(repetitions=None, plan=plan),
            placements=leg_placements(side),
            mounting=Mounting(soft_tissue_rad=soft_tissue_rad),
            seed=seed,
        )
    )
    frames, _ = run(made.recording, made.setup, POSE_S)
    return made, frames


@cache
def shown(exercise):
    """The template of a therapist who does it five times."""
    scenario = demonstration_scenario("therapist_template", exercise, seed=4)
    made = simulate_arm(replace(scenario, schedule=Schedule(repetitions=5)))
    frames, _ = run(made.recording, made.setup, POSE_S)
    moved = trajectory(frames)
    return build_template(moved, find_repetitions(moved, "right"), "right", REACH_M, primary(exercise))


@pytest.mark.parametrize("side", ["left", "right"])
@pytest.mark.parametrize("exercise", LEG_EXERCISES)
def test_angles_are_those_of_the_truth_and_sigma_covers_them(exercise, side):
    made, frames = done(exercise, (SOUND,) * 5, side)
    moving = frames.time_s > made.truth.repetitions_s[0, 0]
    assert len(frames.layout.angles) == 9
    errors = (
        np.stack([made.truth.angle_rad(name) for name in frames.layout.angles], axis=1) - frames.angle_rad
    )
    assert np.degrees(np.sqrt((errors[moving] ** 2).mean(axis=0))).max() < 1.5
    within = np.abs(errors[moving]) < 2.0 * frames.angle_sigma_rad[moving]
    assert within.mean() > 0.9


@pytest.mark.parametrize("exercise", LEG_EXERCISES)
def test_every_repetition_is_found(exercise):
    made, frames = done(exercise, (SOUND,) * 5)
    found = find_repetitions(trajectory(frames), "right")
    assert len(found) == 5
    bounds = np.array([(one.start_s, one.end_s) for one in found])
    np.testing.assert_allclose(bounds, made.truth.repetitions_s, atol=0.35)


@cache
def guided():
    """Knee extensions with four faults as a live guide sees them: first tick, what it said, simulation and frames."""
    made, frames = done("knee_extension", PLAN)
    ready = prepare_template(shown("knee_extension"), "right", REACH_M)
    first = round((made.truth.repetitions_s[0, 0] - 1.5) * 100)
    values, sigma = signals(trajectory(frames.ticks(first, frames.tick_count)), ready)
    return first, Guide(ready, 0.01, rules=default_rules(ready)).feed(values, sigma), made, frames


def test_a_guide_counts_the_repetitions_and_cues_the_faults():
    first, chunk, made, _ = guided()
    attempts = [one for one in chunk.repetitions if one.kind != "ignored"]
    assert [one.kind for one in attempts] == ["valid" if one is not SHORT else "partial" for one in PLAN]
    start_s, end_s = made.truth.repetitions_s.T
    np.testing.assert_allclose([(first + one.end_tick) / 100 for one in attempts], end_s, atol=0.6)
    cued = {}
    for one in chunk.cues:
        if one.rule is not None:
            at_s = (first + one.tick) / 100
            cued.setdefault(int(np.flatnonzero((start_s < at_s) & (at_s < end_s + 0.4))[0]), one.sentence)
    assert cued == {
        PLAN.index(SHORT): "guidance.further",
        PLAN.index(SLOW): "guidance.quicker",
        PLAN.index(FAST): "guidance.slower",
        PLAN.index(LEANING): "guidance.sit_tall",
    }


@pytest.mark.parametrize("exercise", LEG_EXERCISES)
def test_a_short_repetition_is_partial_however_short_and_wherever_it_stands(exercise):
    sizes = (0.4, 0.4, 1.0, 1.0, 0.3, 0.3, 0.6, 0.2)
    made, frames = done(exercise, tuple(PlannedRepetition(size=size) for size in sizes))
    ready = prepare_template(shown(exercise), "right", REACH_M)
    first = round((made.truth.repetitions_s[0, 0] - 1.5) * 100)
    values, sigma = signals(trajectory(frames.ticks(first, frames.tick_count)), ready)
    chunk = Guide(ready, 0.01, rules=default_rules(ready)).feed(values, sigma)
    attempts = [one for one in chunk.repetitions if one.kind != "ignored"]
    assert [one.kind for one in attempts] == ["valid" if size == 1.0 else "partial" for size in sizes]
    np.testing.assert_allclose([one.quotient[0] for one in attempts], sizes, atol=0.1)
    cued = [one.sentence for one in chunk.cues if one.rule is not None]
    assert cued == ["guidance.further"] * sum(size < 1.0 for size in sizes)


def test_findings_name_four_faults_in_their_repetitions_and_no_others():
    first, chunk, _, frames = guided()
    counted = [
        Repetition(number, (first + one.start_tick) / 100, (first + one.end_tick) / 100, counted=one.kind)
        for number, one in enumerate((one for one in chunk.repetitions if one.kind != "ignored"), start=1)
    ]
    result = compare(trajectory(frames), shown("knee_extension"), "right", REACH_M, counted=counted)
    found = {code: sentence(result.findings, f"findings.some_{code}").parameters for code in FAULTS}
    assert {code: [int(n) - 1 for n in said["repetitions"]] for code, said in found.items()} == {
        code: [PLAN.index(one)] for code, one in FAULTS.items()
    }
    assert found["smaller"]["channel"] == "knee_flexion"
    assert found["trunk"]["channel"] == "trunk_forward_lean"
    assert codes(result.findings) == [
        f"findings.some_{code}" for code in ("trunk", "smaller", "slower", "faster")
    ]


def test_a_template_of_the_other_leg_is_mirrored():
    _, frames = done("leg_raise", (SOUND,) * 5, "left")
    result = compare(trajectory(frames), shown("leg_raise"), "left", REACH_M)
    assert result.channels[0] == "pelvis_thigh_left_zxy_flexion"
    assert len(result.repetitions) == 5
    ratio = [one.value for one in result.summary if one.name == f"range_ratio:{primary('leg_raise', 'left')}"]
    assert ratio == pytest.approx([1.0], abs=0.1)
