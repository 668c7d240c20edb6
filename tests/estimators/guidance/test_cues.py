"""Cues against faults of known size and place, silence when unsure, and what stops."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from estimators.comparison import Knot, ToleranceCurve
from estimators.errors import SetupError
from estimators.guidance import (
    SENTENCES,
    CuePace,
    CueRule,
    Guide,
    StopRule,
    default_rules,
    prepare_template,
    range_limits,
    signals,
)
from tests.estimators.comparison.conftest import make_planar
from tests.estimators.guidance.conftest import RATE_HZ, follow, ready, template

LEAN = "trunk_lean_forward_rad"
SIT_TALL = CueRule("deviation", "guidance.sit_tall", LEAN, side="above", tolerance=np.radians(8.0))


def leaning(made, number, extra_rad):
    """Values with one repetition in which the trunk leans more, as far as the repetition is away from rest."""
    values, sigma = signals(made.trajectory, ready())
    one = made.truth[number]
    ticks = np.arange(round(one.start_s * RATE_HZ), round(one.end_s * RATE_HZ))
    share = (ticks / RATE_HZ - one.start_s) / (one.end_s - one.start_s)
    values[ticks, ready().channels.index(LEAN)] += extra_rad * np.sin(np.pi * share) ** 2
    return values, sigma


def test_a_lean_is_cued_once_where_it_is():
    made = make_planar(repetitions=4)
    guide = Guide(ready(), 0.01, rules=[SIT_TALL])
    chunk = guide.feed(*leaning(made, 2, np.radians(16.0)))
    cues = [one for one in chunk.cues if one.rule is not None]
    assert [one.sentence for one in cues] == ["guidance.sit_tall"]
    assert cues[0].value > cues[0].limit == pytest.approx(np.radians(8.0))
    one = made.truth[2]
    # 8 degrees and 1.28 times 1.5 are passed at 0.285 of the repetition; then it must hold for a quarter of a second.
    passes_s = one.start_s + 0.285 * (one.end_s - one.start_s)
    assert 0.2 <= cues[0].tick / RATE_HZ - passes_s <= 0.45


def test_nothing_is_said_where_the_estimate_is_less_certain_than_the_deviation():
    made = make_planar(repetitions=4)
    values, sigma = leaning(made, 2, np.radians(16.0))
    sigma[:, ready().channels.index(LEAN)] = np.radians(16.0)
    chunk = Guide(ready(), 0.01, rules=[SIT_TALL]).feed(values, sigma)
    assert not [one for one in chunk.cues if one.rule is not None]


def test_sides_phases_and_switches_of_a_rule():
    made = make_planar(repetitions=3)
    values, sigma = leaning(made, 1, np.radians(16.0))

    def said(**changes):
        rule = CueRule("deviation", "guidance.sit_tall", LEAN, **{"tolerance": 0.14, **changes})
        return len([c for c in Guide(ready(), 0.01, rules=[rule]).feed(values, sigma).cues if c.rule])

    assert said() == said(side="above") == 1
    assert said(side="below") == 0
    assert said(is_on=False) == 0
    assert said(phases=(0.9, 1.0)) == 0
    assert said(tolerance=0.3) == 0
    assert said(hold_s=3.0) == 0


def test_band_of_the_therapist_is_the_tolerance():
    made = make_planar(repetitions=3)
    values, sigma = leaning(made, 1, np.radians(12.0))
    rule = CueRule("deviation", "guidance.sit_tall", LEAN)
    drawn = replace(template(), tolerances=(ToleranceCurve(LEAN, (Knot(0.0, 1.0, 9.0),)),))
    wide = prepare_template(drawn, "right", template().reach_m)
    for made_ready, count in ((ready(), 1), (wide, 0)):
        chunk = Guide(made_ready, 0.01, rules=[rule]).feed(values, sigma)
        assert len([one for one in chunk.cues if one.rule]) == count


def test_silence_after_a_cue_and_the_most_urgent_first():
    made = make_planar(repetitions=3)
    values, sigma = leaning(made, 1, np.radians(16.0))
    other = CueRule("deviation", "guidance.shoulder_down", LEAN, tolerance=0.14, priority=2)
    for rules in ([other, SIT_TALL], [SIT_TALL, other]):
        cues = [one for one in Guide(ready(), 0.01, rules=rules).feed(values, sigma).cues if one.rule]
        assert cues[0].sentence == "guidance.sit_tall"
        assert all(b.tick - a.tick >= 150 for a, b in pairwise(cues))


def test_range_speed_and_praise():
    rules = default_rules(ready())
    small = follow(make_planar(repetitions=3, sizes=[1.0, 0.6, 1.0]), rules=rules)
    (cue,) = small.chunk.cues
    assert cue.sentence == "guidance.further"
    assert small.made.truth[1].start_s < cue.tick / RATE_HZ < small.made.truth[1].end_s
    # It is said on the way back, when the turn is over.
    assert cue.phase > small.guide.ready.target_phase[0]
    hasty = follow(make_planar(repetitions=3, out_s=0.55, hold_s=0.1), rules=rules)
    assert {one.sentence for one in hasty.chunk.cues} == {"guidance.slower"}
    tardy = follow(make_planar(repetitions=3, out_s=2.6), rules=rules)
    assert {one.sentence for one in tardy.chunk.cues} == {"guidance.quicker"}
    sound = follow(make_planar(repetitions=6), rules=rules)
    assert [one.sentence for one in sound.chunk.cues] == ["guidance.well_done"] * 2


def test_pace_is_read_where_the_arm_is_and_not_where_the_phase_is_thought_to_be():
    fast = CueRule("fast", "guidance.slower", tolerance=1.2, hold_s=0.0)
    made = make_planar(repetitions=4, out_s=0.7)
    chunk = follow(made, rules=[fast]).chunk
    cues = [one for one in chunk.cues if one.rule]
    assert [one.value for one in cues] == pytest.approx([0.7 / 1.2] * 4, rel=0.06)
    values, sigma = signals(made.trajectory, ready())
    sigma[:, ready().channels.index(ready().main)] = np.radians(25.0)
    assert not [one for one in Guide(ready(), 0.01, rules=[fast]).feed(values, sigma).cues if one.rule]


def test_a_target_that_lay_behind_when_the_attempt_began_is_not_missed():
    """A wrong movement goes over into the template's way back: its end tells nothing of how far it went."""
    made = make_planar(repetitions=3)
    values, sigma = signals(made.trajectory, ready())
    one = made.truth[1]
    share = (made.trajectory.time_s - one.start_s) / (one.end_s - one.start_s)
    is_wrong = (share > 0.0) & (share < 0.8)
    for place in ready().steering:
        column = ready().channels.index(place)
        values[is_wrong, column] = 2.0 * values[0, column] - values[is_wrong, column]
    chunk = Guide(ready(), 0.01, rules=default_rules(ready())).feed(values, sigma)
    assert "guidance.further" not in {one.sentence for one in chunk.cues}
    assert next(one.kind for one in chunk.repetitions if one.kind != "ignored") == "valid"


def test_fading_leaves_repetitions_without_a_word():
    made = make_planar(repetitions=4, sizes=0.6)
    every = follow(made, pace=CuePace(cue_every=1)).chunk.cues
    second = follow(made, pace=CuePace(cue_every=2)).chunk.cues
    assert len(every) == 4
    assert [one.tick for one in second] == [every[0].tick, every[2].tick]


def test_plane_is_judged_at_equal_elevation():
    plane = "thorax_humerus_right_yxy_plane_of_elevation"
    base = template()
    channels = (*base.channels, plane)
    mean = np.column_stack([base.mean, np.full(101, np.radians(80.0))])
    tolerance = np.column_stack([base.tolerance, np.full(101, 0.087)])
    wide = prepare_template(
        replace(base, channels=channels, mean=mean, tolerance=tolerance),
        "right",
        base.reach_m,
    )
    assert plane not in wide.steering
    made = make_planar(repetitions=3)
    values, sigma = signals(made.trajectory, wide)
    column, elevation = channels.index(plane), channels.index("thorax_humerus_right_yxy_elevation")
    rules = [one for one in default_rules(wide) if one.quantity == "at_equal"]
    for off_deg, sentences in (
        (0.0, []),
        (40.0, ["guidance.arm_to_side"]),
        (-40.0, ["guidance.arm_in_front"]),
    ):
        values[:, column] = np.where(values[:, elevation] > 0.4, np.radians(80.0), np.nan)
        values[made.truth[1].start_s < made.trajectory.time_s, column] += np.radians(off_deg)
        values[made.truth[2].start_s < made.trajectory.time_s, column] -= np.radians(off_deg)
        cues = Guide(wide, 0.01, rules=rules).feed(values, sigma).cues
        assert [one.sentence for one in cues if one.rule] == sentences


def test_range_limit_stops_within_sixty_milliseconds():
    name = "thorax_humerus_right_yxy_elevation"
    made = make_planar(repetitions=2)
    values, sigma = signals(made.trajectory, ready())
    column = ready().channels.index(name)
    low, high = range_limits(name, -0.5, 1.0)
    chunk = Guide(ready(), 0.01, stops=(low, high)).feed(values, sigma)
    (stop,) = chunk.stops
    beyond = np.flatnonzero(values[:, column] + 2.0 * sigma[:, column] > 1.0)[0]
    assert 0 < stop.tick - beyond <= 6
    assert (stop.kind, stop.limit, stop.is_pause) == ("limit", 1.0, False)
    assert stop.value == pytest.approx(values[stop.tick, column])
    # Nothing is counted from there on.
    assert [one.kind for one in chunk.repetitions if one.kind != "ignored"] == []


def test_a_touch_of_the_limit_does_not_stop():
    name = "thorax_humerus_right_yxy_elevation"
    made = make_planar(repetitions=1)
    values, sigma = signals(made.trajectory, ready())
    values[300:304, ready().channels.index(name)] += 2.0
    assert Guide(ready(), 0.01, stops=range_limits(name, -0.5, 2.5)).feed(values, sigma).stops == ()
    values[300:305, ready().channels.index(name)] += 2.0
    assert len(Guide(ready(), 0.01, stops=range_limits(name, -0.5, 2.5)).feed(values, sigma).stops) == 1


def test_counts_time_and_lost_tracking_stop():
    made = make_planar(repetitions=5, sizes=[1.0, 0.5, 1.0, 1.0, 1.0])
    values, sigma = signals(made.trajectory, ready())

    def stop(*rules, of=values):
        return Guide(ready(), 0.01, stops=rules).feed(of, sigma).stops

    (three,) = stop(StopRule("valid_count", 3))
    assert three.value == 3.0
    assert 0.0 <= three.tick / RATE_HZ - made.truth[3].end_s < 0.4
    (tries,) = stop(StopRule("attempt_count", 3))
    assert 0.0 <= tries.tick / RATE_HZ - made.truth[2].end_s < 0.4
    (time,) = stop(StopRule("time", 5.0))
    # The first second is the prompted rest.
    assert time.tick == 99 + 500
    lost = values.copy()
    lost[700:] = np.nan
    (gone,) = stop(StopRule("lost", hold_s=2.0), of=lost)
    assert gone.tick == 899
    assert gone.is_pause
    unsure = sigma.copy()
    unsure[700:, ready().channels.index("thorax_humerus_right_yxy_elevation")] = 0.4
    guide = Guide(ready(), 0.01, stops=[StopRule("unsure", 0.3, hold_s=5.0)])
    assert [one.tick for one in guide.feed(values, unsure).stops] == [1199]
    assert stop(StopRule("wrong_in_a_row", 3)) == ()


def test_pain_stops_at_once_until_somebody_resumes():
    made = make_planar(repetitions=4)
    values, sigma = signals(made.trajectory, ready())
    guide = Guide(ready(), 0.01, stops=())
    first = guide.feed(values[:600], sigma[:600])
    stop = guide.stop_for_pain()
    assert (stop.tick, stop.kind, stop.is_pause) == (599, "pain", False)
    during = guide.feed(values[600:1000], sigma[600:1000])
    assert guide.is_stopped
    assert during.repetitions == during.cues == ()
    guide.resume()
    after = guide.feed(values[1000:], sigma[1000:])
    kinds = [one.kind for part in (first, after) for one in part.repetitions]
    assert kinds.count("valid") == 3


def test_a_reached_count_does_not_stop_again():
    made = make_planar(repetitions=4)
    values, sigma = signals(made.trajectory, ready())
    guide = Guide(ready(), 0.01, stops=[StopRule("valid_count", 2)])
    assert len(guide.feed(values[:1000], sigma[:1000]).stops) == 1
    guide.resume()
    assert guide.feed(values[1000:], sigma[1000:]).stops == ()


def test_rules_that_cannot_be_followed_are_refused():
    for wrong in (
        {"quantity": "speed"},
        {"side": "left"},
        {"phases": (0.5, 0.2)},
        {"tolerance": 0.0},
        {"hold_s": -1.0},
        {"quantity": "range", "tolerance": None},
    ):
        with pytest.raises(SetupError):
            CueRule(**{"quantity": "deviation", "sentence": "guidance.sit_tall", "channel": LEAN, **wrong})
    for kind, limit in (("pain", 1.0), ("time", 0.0), ("limit", float("nan"))):
        with pytest.raises(SetupError):
            StopRule(kind, limit)
    with pytest.raises(SetupError):
        Guide(ready(), 0.01, rules=[CueRule("deviation", "guidance.sit_tall", "nothing")])
    with pytest.raises(SetupError):
        range_limits(LEAN, 1.0, 0.0)
    with pytest.raises(SetupError):
        CuePace(cue_every=0)
    assert all(rule.sentence in SENTENCES for rule in default_rules(ready()))
