"""Home and a hold differ in where people come back to, two bends that take turns and one that comes again in pace."""

import numpy as np
import pytest

from estimators.comparison import Trajectory, find_repetitions
from estimators.comparison.repetitions.cycles import explain, explaining_once
from estimators.comparison.repetitions.evidence import Evidence, evidence
from estimators.comparison.repetitions.home import at_home
from estimators.comparison.repetitions.path import path_of
from tests.estimators.comparison.conftest import minimum_jerk

SIZES = [1.0, 0.9, 1.08, 0.95, 1.05, 0.92, 1.03]
STEP_S = 0.01
JUMP = ((1.0, 0.7, 0.28, 0.35), (0.9, 0.25, 0.6, 0.8))
"""Depth, seconds down, up and straight: bent slowly and stretched quickly, the other way about on landing."""
SQUAT = ((1.0, 0.7, 0.3, 0.8),)


def knee(bends, drift_rad=0.0, seed=3):
    """A knee that bends again and again, its depth by 4 % and its pace by 8 % otherwise each time."""
    generator = np.random.default_rng(seed)
    pieces = [np.zeros(200)]
    for depth, down_s, up_s, straight_s in bends:
        slower_down, slower_up = np.exp(generator.normal(0.0, 0.08, 2))
        deep = depth * (1.0 + generator.normal(0.0, 0.04))
        down, up = (np.arange(0.0, lasts_s, STEP_S) for lasts_s in (down_s * slower_down, up_s * slower_up))
        pieces.append(deep * minimum_jerk(down, down_s * slower_down))
        pieces.append(deep * (1.0 - minimum_jerk(up, up_s * slower_up)))
        pieces.append(np.zeros(round(straight_s / STEP_S)))
    bent = np.concatenate([*pieces, np.zeros(200)])
    bent += generator.normal(0.0, 0.003, len(bent)) + drift_rad * np.linspace(0.0, 1.0, len(bent))
    return bent[:, None]


def found_in(bent):
    time_s = STEP_S * np.arange(len(bent))
    name = ("thigh_shank_right_zxy_flexion",)
    moved = Trajectory(time_s, name, bent, np.full(bent.shape, np.nan), np.ones(bent.shape, dtype=bool))
    return find_repetitions(moved, "right")


@pytest.mark.parametrize(("rest_s", "lead_s"), [(0.5, 0.4), (0.5, 0.8), (0.2, 0.8), (0.0, 0.8)])
def test_a_recording_that_ends_in_a_hold_is_cut_at_home(planar, rest_s, lead_s):
    """The hold is longer than the rest, and the recording rests in it as it ends: all were cut from hold to hold."""
    made = planar(sizes=SIZES, rest_s=rest_s, hold_s=2.0, lead_s=lead_s, noise_rad=0.002)
    held_s = made.truth[-1].start_s + 3.1
    found = find_repetitions(made.trajectory, "right", None, held_s)
    assert [one.start_s for one in found] == pytest.approx([one.start_s for one in made.truth[:-1]], abs=0.1)


@pytest.mark.parametrize(("rest_s", "lead_s"), [(0.5, 0.4), (0.5, 0.8), (0.2, 0.8), (0.0, 0.8)])
def test_a_recording_that_begins_in_a_hold_is_cut_at_home(planar, rest_s, lead_s):
    made = planar(sizes=SIZES, rest_s=rest_s, hold_s=2.0, lead_s=lead_s, noise_rad=0.002)
    found = find_repetitions(made.trajectory, "right", made.truth[0].start_s + 1.3)
    assert [one.start_s for one in found] == pytest.approx([one.start_s for one in made.truth[1:]], abs=0.1)


def spoken_for(bent):
    path = path_of(bent, STEP_S)
    best = explain(path, explaining_once(path))[0]
    return evidence(best, at_home(best, path), path, STEP_S), path, best


def test_a_posture_that_drifts_evenly_is_no_further_spread():
    still, _, _ = spoken_for(knee(SQUAT * 8))
    drifting, _, _ = spoken_for(knee(SQUAT * 8, drift_rad=0.4))
    # Not taken out, the drift alone would spread them by a quarter of it.
    assert drifting.spread < still.spread + 0.02


def test_a_spread_posture_speaks_against_home_and_below_the_finest_nothing_does():
    near, far = (Evidence(rest=0.5, outermost=0.3, spread=spread) for spread in (0.02, 0.08))
    # Four times as far: 0.6 times the logarithm of four.
    assert near.worth - far.worth == pytest.approx(0.8318, abs=1e-4)
    assert Evidence(0.5, 0.3, 0.001).worth == Evidence(0.5, 0.3, 0.01).worth


@pytest.mark.parametrize("count", [4, 5, 8])
def test_jumps_with_two_bends_of_one_depth_count_once(count):
    """Each bend was a repetition of its own."""
    assert len(found_in(knee(JUMP * count))) == count


@pytest.mark.parametrize(
    "bends", [SQUAT * 10, (*SQUAT, (1.0, 1.1, 0.5, 0.8)) * 5, (*SQUAT, (0.8, 0.7, 0.3, 0.8)) * 5]
)
def test_bends_of_one_kind_are_no_pairs_whether_slower_or_smaller_every_second_time(bends):
    assert len(found_in(knee(bends))) == 10


def test_three_jumps_are_too_few_to_tell_their_bends_apart():
    assert len(found_in(knee(JUMP * 3))) == 6
