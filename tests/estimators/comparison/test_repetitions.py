"""Repetitions on a movement whose bounds are known exactly, and on movement that does not repeat."""

import itertools
from dataclasses import replace

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter1d

from estimators.comparison import Repetition, Trajectory, find_repetitions, judge_repetitions
from estimators.comparison.repetitions import cycles, home
from estimators.comparison.repetitions.cycles_kernel import search, turning_points
from estimators.comparison.repetitions.home import at_home
from estimators.errors import ComparisonError, SetupError


def worst_bound_s(found: list[Repetition], truth: list[Repetition]) -> float:
    return max(
        max(abs(a.start_s - b.start_s), abs(a.end_s - b.end_s)) for a, b in zip(found, truth, strict=True)
    )


@pytest.mark.parametrize(
    "movement",
    [
        {},
        {"tremor_rad": 0.05},
        {"rest_s": 0.0, "hold_s": 0.0},
        {"rest_s": 0.0, "hold_s": 2.0},
        {"sizes": 0.2},
        {"repetitions": 1},
        {"repetitions": 15, "out_s": 0.5, "rest_s": 0.2, "hold_s": 0.0},
        {"out_s": 3.0, "hold_s": 1.0},
        {"sizes": [1.0, 0.8, 1.1, 0.75, 1.0, 0.9]},
        {"rate_hz": 17.0},
        {"lead_s": 12.0},
    ],
    ids=str,
)
def test_known_repetitions_are_found(planar, movement):
    made = planar(noise_rad=0.002, **movement)
    found = find_repetitions(made.trajectory, "right")
    assert len(found) == len(made.truth)
    # A minimum-jerk start moves 0.3 percent of the way in the first 6 percent of its time (0.2 s of 3 s).
    assert worst_bound_s(found, made.truth) < 0.25


def test_numbers_order_and_window(planar):
    made = planar(repetitions=6)
    found = find_repetitions(made.trajectory, "right")
    assert [r.number for r in found] == [1, 2, 3, 4, 5, 6]
    assert all(a.end_s <= b.start_s for a, b in itertools.pairwise(found))
    middle = find_repetitions(
        made.trajectory, "right", made.truth[1].start_s - 0.4, made.truth[4].end_s + 0.4
    )
    assert len(middle) == 4
    assert middle[0].start_s == pytest.approx(made.truth[1].start_s, abs=0.15)
    assert find_repetitions(made.trajectory, "right", 100.0, 200.0) == []


def test_scale_of_movement_and_time_does_not_matter(planar):
    """No threshold per person: half the size at a third of the pace gives the same cuts, stretched."""
    brisk = find_repetitions(planar().trajectory, "right")
    slow = find_repetitions(
        planar(sizes=0.5, out_s=3.6, hold_s=0.9, rest_s=3.0, lead_s=6.0).trajectory, "right"
    )
    assert len(brisk) == len(slow)
    # Smoothing is fixed in seconds, hence not exactly equal.
    assert np.allclose([3 * r.start_s for r in brisk], [r.start_s for r in slow], atol=0.3)


@pytest.mark.parametrize("smoothing", [20, 60, 120])
@pytest.mark.parametrize("seed", range(6))
def test_random_movement_has_no_repetitions(planar, smoothing, seed):
    template = planar(repetitions=10).trajectory
    values = gaussian_filter1d(
        np.random.default_rng(seed).normal(size=template.values.shape), smoothing, axis=0
    )
    moved = replace(template, values=0.4 * values / values.std())
    assert find_repetitions(moved, "right") == [], f"seed {seed}"


def test_stillness_and_drift_have_no_repetitions(planar):
    still = planar(sizes=0.01, noise_rad=0.001, lean_rad=0.0).trajectory
    assert find_repetitions(still, "right") == []
    drifting = replace(still, values=still.values + 0.002 * still.time_s[:, None])
    assert find_repetitions(drifting, "right") == []


def test_gap_is_bridged_for_finding_but_judged(planar):
    made = planar()
    lost = (made.trajectory.time_s > made.truth[2].start_s + 0.5) & (
        made.trajectory.time_s < made.truth[2].start_s + 1.2
    )
    valid = made.trajectory.valid & ~lost[:, None]
    holed = replace(made.trajectory, valid=valid, values=np.where(valid, made.trajectory.values, np.nan))
    found = find_repetitions(holed, "right")
    assert len(found) == 5
    judged = judge_repetitions(holed, found, "right")
    assert [r.is_kept for r in judged] == [True, True, False, True, True]
    assert "lost track for 0.7 s" in judged[2].reason


def test_half_movement_is_dropped_with_its_reason(planar):
    made = planar(sizes=[1.0, 1.0, 0.5, 1.0, 1.0])
    judged = judge_repetitions(made.trajectory, find_repetitions(made.trajectory, "right"), "right")
    assert [r.is_kept for r in judged] == [True, True, False, True, True]
    assert judged[2].reason.startswith("Stopped half way")


def test_wrong_direction_is_dropped_with_its_reason(planar):
    made = planar(sizes=[1.0, 1.0, -1.0, 1.0, 1.0])
    judged = judge_repetitions(made.trajectory, made.truth, "right")
    assert [r.is_kept for r in judged] == [True, True, False, True, True]
    assert "opposite direction" in judged[2].reason


def test_odd_duration_is_dropped_with_its_reason(planar):
    made = planar()
    truth = list(made.truth)
    truth[1] = replace(truth[1], end_s=truth[1].start_s + 0.9)
    truth[3] = replace(truth[3], end_s=truth[3].end_s + 6.0)
    judged = judge_repetitions(made.trajectory, truth, "right")
    assert "shorter" in judged[1].reason
    assert "longer" in judged[3].reason


def test_another_way_is_dropped_with_its_reason(planar):
    made = planar(repetitions=6)
    time_s, truth = made.trajectory.time_s, made.truth[4]
    share = np.clip((time_s - truth.start_s) / (truth.end_s - truth.start_s), 0, 1)
    swing = np.sin(np.pi * share) ** 2
    values = made.trajectory.values.copy()
    values[:, made.trajectory.channels.index("wrist_right.y")] += 0.35 * swing
    values[:, made.trajectory.channels.index("humerus_forearm_right_zxy_pronation")] -= 1.2 * swing
    judged = judge_repetitions(replace(made.trajectory, values=values), made.truth, "right")
    assert [r.number for r in judged if not r.is_kept] == [5]
    assert judged[4].reason.startswith("Unlike the others")


def test_equal_repetitions_are_all_kept_and_a_person_may_drop(planar):
    made = planar(noise_rad=0.003)
    assert all(r.is_kept for r in judge_repetitions(made.trajectory, made.truth, "right"))
    by_hand = [replace(made.truth[0], is_kept=False, reason="Coughed."), *made.truth[1:]]
    assert judge_repetitions(made.trajectory, by_hand, "right")[0].reason == "Coughed."


def test_wrong_side_says_what_to_do(planar):
    made = planar()
    with pytest.raises(ComparisonError, match="left side"):
        find_repetitions(made.trajectory, "left")
    with pytest.raises(SetupError, match="'left' or 'right'"):
        find_repetitions(made.trajectory, "both")


def test_empty_trajectory_gives_none():
    empty = Trajectory(np.zeros(0), ("x",), np.zeros((0, 1)), np.zeros((0, 1)), np.zeros((0, 1), bool))
    assert find_repetitions(empty, "right", 0.0, 1.0) == []


def test_work_grows_no_faster_than_the_session(planar, monkeypatch):
    """Cells that the search goes through, and walks over all matches, in a session and in one ten times as long."""
    searched, walked = [], []

    def walk(one, path):
        walked.append(one)
        return at_home(one, path)

    def counted(piece, path, furthest, stray):
        searched.append(len(piece) * len(path))
        return search(piece, path, furthest, stray)

    monkeypatch.setattr(cycles, "search", counted)
    monkeypatch.setattr(home, "at_home", walk)
    work, walks = [], []
    for count in (30, 300):
        searched.clear()
        walked.clear()
        made = planar(repetitions=count, rate_hz=20.0)
        assert len(find_repetitions(made.trajectory, "right")) == count
        work.append(sum(searched))
        walks.append(len(walked))
    assert made.trajectory.time_s[-1] > 1000
    assert work[1] < 11 * work[0]
    # Each walk is as long as the session: their number must not grow with it, or the whole is quadratic.
    assert 0 < walks[1] <= 1.5 * walks[0], walks


def turns_of(signal: list[float], reversal: float) -> list[int]:
    """Where a signal turns, one sample after the other."""
    turns, extreme, direction = [0], 0, 0
    for i in range(1, len(signal)):
        way = signal[i] - signal[extreme]
        if way * direction > 0 or direction == 0:
            if direction == 0 and abs(way) > reversal:
                direction = 1 if way > 0 else -1
                extreme = i
            elif direction:
                extreme = i
        elif abs(way) > reversal:
            turns.append(extreme)
            direction, extreme = -direction, i
    return [*turns, extreme]


def test_turns_are_found_as_one_after_the_other() -> None:
    random = np.random.default_rng(11)
    for size in (1, 2, 3, 50, 400, 400, 400):
        signal = np.cumsum(random.normal(size=size))
        assert turning_points(signal, 1.5).tolist() == turns_of(signal.tolist(), 1.5)
    steps = np.array([0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 2.0])
    assert turning_points(steps, 0.5).tolist() == turns_of(steps.tolist(), 0.5) == [0, 2, 4, 6]
    assert turning_points(np.zeros(9), 0.5).tolist() == [0, 0]
    assert turning_points(np.zeros(0), 0.5).tolist() == [0, 0]
