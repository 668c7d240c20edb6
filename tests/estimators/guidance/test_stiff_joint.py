"""One joint that goes a share of its way, all else whole: a partial repetition with a word, never another movement."""

from dataclasses import replace

import numpy as np
import pytest

from estimators.guidance import Guide, default_rules, signals
from tests.estimators.comparison.conftest import make_planar
from tests.estimators.guidance.conftest import RATE_HZ, follow, ready

ELEVATION = "thorax_humerus_right_yxy_elevation"
FLEXION = "humerus_forearm_right_zxy_flexion"
REPETITIONS = 6


def stiff(channel: str, share: float, seed: int = 3):
    """Repetitions in which this channel leaves its resting value by that share of what it should."""
    made = make_planar(repetitions=REPETITIONS, noise_rad=0.002, seed=seed)
    values = made.trajectory.values.copy()
    column = made.trajectory.channels.index(channel)
    rest = values[0, column]
    values[:, column] = rest + share * (values[:, column] - rest)
    return replace(made, trajectory=replace(made.trajectory, values=values))


def guided(made):
    guide = Guide(ready(), 1.0 / RATE_HZ, rules=default_rules(ready()))
    chunk = guide.feed(*signals(made.trajectory, ready()))
    counted = [one for one in chunk.repetitions if one.kind != "ignored"]
    return counted, [cue.sentence for cue in chunk.cues], [one.kind for one in chunk.stops]


@pytest.mark.parametrize("channel", [FLEXION, ELEVATION])
@pytest.mark.parametrize("share", [0.2, 0.3, 0.45, 0.6])
def test_a_joint_that_stays_behind_makes_a_partial_repetition(channel, share):
    counted, cues, stops = guided(stiff(channel, share))
    assert [one.kind for one in counted] == ["partial"] * REPETITIONS
    assert all(one.stiff_share > 0.2 and one.wrong_share < 0.1 for one in counted)
    assert "wrong_in_a_row" not in stops
    assert cues.count("guidance.further") == REPETITIONS


def test_the_phase_is_that_of_the_joints_that_move():
    error = np.abs(follow(stiff(FLEXION, 0.35)).phase_error(1.2))
    assert np.median(error) < 0.02
    assert np.percentile(error, 95) < 0.10


def test_a_joint_that_goes_the_other_way_is_another_movement():
    counted, _, _ = guided(stiff(FLEXION, -0.6))
    assert counted
    assert {one.kind for one in counted} == {"wrong"}


@pytest.mark.parametrize("size", [0.5, 0.8, 1.0])
def test_a_movement_that_fits_as_a_whole_needs_no_joint_left_out(size):
    counted, _, _ = guided(make_planar(repetitions=4, sizes=size, noise_rad=0.004, seed=5))
    assert len(counted) == 4
    assert all(one.stiff_share < 0.05 for one in counted)
    assert {one.kind for one in counted} == {"valid" if size >= 0.8 else "partial"}


def test_nothing_is_counted_of_a_main_channel_that_is_never_known():
    made = make_planar(repetitions=4, noise_rad=0.002, seed=6)
    column = made.trajectory.channels.index(FLEXION)
    valid = made.trajectory.valid.copy()
    valid[:, column] = False
    counted, cues, stops = guided(replace(made, trajectory=replace(made.trajectory, valid=valid)))
    assert (counted, cues, stops) == ([], [], [])
