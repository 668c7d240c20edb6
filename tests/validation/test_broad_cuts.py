"""Trials of BROAD cut inside their movement: where, and what of them is scored."""

import numpy as np
import pytest

from tests.validation.made_up import trial_at_rest
from validation import protocols
from validation.orientation import broad_cuts as cuts

RATE_HZ = 100.0


@pytest.fixture
def trial():
    return trial_at_rest(4, 7000, RATE_HZ, (10.0, 60.0))


def test_moments_lie_inside_the_movement_and_leave_enough_to_score(trial):
    moments = cuts.cut_moments(trial, 0)
    assert moments.size == 12
    assert ((moments >= 1000) & (moments < 2000)).all()
    np.testing.assert_array_equal(moments, cuts.cut_moments(trial, 0))
    assert not np.array_equal(moments, cuts.cut_moments(trial, 1))


def test_the_first_seconds_of_a_cut_are_not_scored(trial):
    cut = cuts.scored(cuts.started_at(trial, 1500))
    assert cut.sensors["imu"].time_s[0] == 0.0
    # Twenty seconds after the cut at 15 s, until the movement ends at 60 s.
    np.testing.assert_array_equal(np.flatnonzero(cut.reference["is_movement"])[[0, -1]], [2000, 4499])
    assert trial.reference["is_movement"].sum() == 5000


def test_every_figure_is_measured(trial):
    protocol = next(p for p in protocols() if p.name == "orientation_cuts")
    values = protocol.measure(range(5, 7), {"made up": trial})
    assert set(values) == {figure.name for figure in protocol.figures}
    assert values["lost, online"] == values["lost, off-line"] == 0.0
    assert values["Telemotion, online"][0] < 1.0
    assert len(values["share of what a run may have, online"]) == 12
