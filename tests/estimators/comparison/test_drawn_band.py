"""What a therapist draws on a template: judged in that phase and nowhere else, mirrored, and what only watches."""

from dataclasses import replace

import numpy as np
import pytest

from estimators.comparison import (
    FREE,
    Knot,
    NamedPhase,
    Template,
    ToleranceCurve,
    build_template,
    compare,
    mirror_template,
    mirror_trajectory,
)
from tests.estimators.comparison.conftest import make_planar

LEAN = "trunk_lean_lateral_rad"
FORWARD = "trunk_lean_forward_rad"
RATE_HZ = 100.0


def narrowed(channel: str, start: float, end: float, below: float, above: float) -> ToleranceCurve:
    """The recorded band, but for one phase."""
    return ToleranceCurve(
        channel,
        (Knot(start - 0.02), Knot(start, below, above), Knot(end, below, above), Knot(end + 0.02)),
    )


def template() -> Template:
    made = make_planar(noise_rad=0.001)
    return build_template(made.trajectory, made.truth, "right", made.reach_m, made.primary)


def with_fault(channel: str, at: float, extra_rad: float, sway_at: float | None = None):
    """Three repetitions; the channel goes off by a bump of 0.12 of the movement around one phase, and another."""
    made = make_planar(repetitions=3, noise_rad=0.001, seed=3)
    values = made.trajectory.values.copy()
    column = made.trajectory.channels.index(channel)
    for one in made.truth:
        share = (made.trajectory.time_s - one.start_s) / (one.end_s - one.start_s)
        for centre in (at, sway_at):
            if centre is not None:
                values[:, column] += extra_rad * np.exp(-0.5 * ((share - centre) / 0.04) ** 2)
    return made, replace(made.trajectory, values=values)


def outside(drawn: Template, source, side: str = "right"):
    result = compare(source, drawn, side, 0.55, repetitions=make_planar(repetitions=3).truth)
    return result, [one.outside for one in result.repetitions]


def test_a_fault_is_found_in_the_phase_that_was_narrowed_and_not_elsewhere():
    # 2.3 degrees more forward lean at 25 and at 75 % of the movement: inside the recorded band of 3 degrees.
    _, source = with_fault(FORWARD, 0.25, 0.04, sway_at=0.75)
    recorded = template()
    _, found = outside(recorded, source)
    assert all(FORWARD not in one for one in found)
    drawn = replace(
        recorded,
        phases=(NamedPhase("Lift", 0.1, 0.4), NamedPhase("Lower", 0.6, 0.9)),
        tolerances=(narrowed(FORWARD, 0.1, 0.4, 1.0, 0.4),),
    )
    result, found = outside(drawn, source)
    for one in found:
        assert set(one) == {FORWARD}
        ((start, end),) = one[FORWARD]
        # Beyond 0.021 of 0.04 rad: within sqrt(2 ln 1.9) = 1.13 widths of 4 %, +-4.5 % around the phase.
        assert 17 <= start <= 23
        assert 27 <= end <= 33
    (said,) = [str(sentence) for sentence in result.findings if "trunk" in str(sentence).lower()]
    assert said.endswith("Mostly in: Lift.")
    # The other side of the mean has its own limit.
    low = replace(recorded, tolerances=(narrowed(FORWARD, 0.1, 0.4, 0.4, 1.0),))
    assert all(FORWARD not in one for one in outside(low, source)[1])


def test_what_is_free_or_only_watched_is_not_judged():
    _, source = with_fault(FORWARD, 0.25, 0.3)
    recorded = template()
    result, found = outside(recorded, source)
    assert all(FORWARD in one for one in found)
    assert any("lean" in str(sentence).lower() for sentence in result.findings)
    free = replace(recorded, tolerances=(ToleranceCurve(FORWARD, (Knot(0.0, 1.0, FREE),)),))
    watched = replace(recorded, watched=(FORWARD,))
    for drawn in (free, watched):
        result, found = outside(drawn, source)
        assert all(FORWARD not in one for one in found)
        shares = [m.value for m in result.summary if m.name == "inside_band"]
        assert shares == [pytest.approx(100.0)]
    assert not any("lean" in str(sentence).lower() for sentence in outside(watched, source)[0].findings)


def test_the_mirrored_template_judges_the_mirrored_movement_alike():
    _, source = with_fault(LEAN, 0.3, 0.04)
    drawn = replace(
        template(),
        tolerances=(narrowed(LEAN, 0.2, 0.4, 1.0, 0.3),),
        watched=("humerus_forearm_right_zxy_pronation",),
        phases=(NamedPhase("Lift", 0.2, 0.4),),
    )
    _, here = outside(drawn, source)
    mirrored = mirror_template(drawn)
    assert mirrored.watched == ("humerus_forearm_left_zxy_pronation",)
    assert mirrored.phases == drawn.phases
    column = drawn.channels.index(LEAN)
    assert np.array_equal(mirrored.below[:, column], drawn.above[:, column])
    for given in (drawn, mirrored):
        _, across = outside(given, mirror_trajectory(source), "left")
        assert across == here
        assert all(set(one) == {LEAN} for one in across)
    again = mirror_template(mirrored)
    assert again.tolerances == drawn.tolerances
    assert np.array_equal(again.mean, drawn.mean)


def test_a_band_that_was_not_drawn_is_the_recorded_one():
    recorded = template()
    assert np.array_equal(recorded.below, recorded.tolerance, equal_nan=True)
    assert np.array_equal(recorded.above, recorded.tolerance, equal_nan=True)
    assert recorded.counts.all()
