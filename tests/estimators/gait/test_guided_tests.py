"""Walking tests from strides whose answer is known by counting."""

from dataclasses import replace

import numpy as np
import pytest

from estimators.conventions import Side
from estimators.errors import SetupError
from estimators.gait import Footholds, Strides, guided_test
from estimators.pipelines import SessionSetup, analyse_walk
from estimators.simulation import Bout, Leg, gait_preset, simulate_gait
from tests.said import codes, sentence


def walked(
    side: Side, count: int, length_m: float, first_s: float, turn_rad: dict[int, float] | None = None
) -> Strides:
    """Return even strides: off the ground for 0.4 s of every second."""
    number = np.arange(count, dtype=np.float64)
    turn = np.zeros(count)
    for stride, angle in (turn_rad or {}).items():
        turn[stride] = angle
    off = first_s + number
    holds = np.append(off, off[-1] + 1.0)
    zeros = np.zeros(count)
    return Strides(
        side=side,
        footholds=Footholds(
            holds - 0.5,
            holds - 0.1,
            holds - 0.3,
            np.outer(np.arange(count + 1), [length_m, 0.0, 0.0]),
            np.zeros(count + 1),
            np.zeros((count + 1, 3)),
        ),
        toe_off_s=off,
        contact_s=off + 0.4,
        duration_s=np.ones(count),
        stance_s=np.full(count, 0.6),
        swing_s=np.full(count, 0.4),
        length_m=np.full(count, length_m),
        length_sigma_m=np.full(count, 0.02),
        rise_m=zeros,
        clearance_m=zeros,
        circumduction_m=zeros,
        contact_pitch_rad=zeros,
        toe_off_pitch_rad=zeros,
        toe_out_rad=zeros,
        turn_rad=turn,
        peak_speed_mps=zeros,
        bout=np.zeros(count, dtype=np.int64),
        is_initiation=number == 0,
        is_termination=number == count - 1,
        missing_s=zeros,
        flags=np.zeros(count, dtype=np.uint8),
        q_sensor_foot=np.array([1.0, 0.0, 0.0, 0.0]),
    )


def test_a_walk_counts_way_time_and_steps() -> None:
    found = guided_test({"left": walked("left", 10, 1.2, 3.0), "right": walked("right", 10, 1.1, 3.5)})
    assert found is not None
    assert found.distance_m == pytest.approx(11.5)
    assert found.distance_sigma_m == pytest.approx(0.02 * np.sqrt(20) / 2)
    assert found.time_s == pytest.approx(12.9 - 3.0)
    assert (found.step_count, found.turn_count, found.pause_count) == (20, 0, 0)
    assert found.speed_mps == pytest.approx(11.5 / 9.9)
    assert found.reasons == ()


def test_six_minutes_are_six_minutes() -> None:
    found = guided_test({"right": walked("right", 400, 1.25, 2.0)}, "six_minute_walk")
    assert found is not None
    assert found.time_s == pytest.approx(360.0)
    # Contacts at 0.4, 1.4, ... 359.4 s after the first toe-off.
    assert found.distance_m == pytest.approx(360 * 1.25)
    assert found.step_count == 720
    assert found.minutes_m.shape == (6,)
    assert found.minutes_m == pytest.approx([75.0] * 6)
    short = guided_test({"right": walked("right", 100, 1.25, 2.0)}, "six_minute_walk")
    assert short is not None
    told = sentence(short.reasons, "walk.not_six_minutes")
    assert told.parameters["walked_s"] == pytest.approx(60.0 * 1.7, abs=3.0)
    assert short.minutes_m.sum() == pytest.approx(short.distance_m)


def test_up_and_go_finds_the_turn_about_and_says_what_feet_do_not_feel() -> None:
    there_and_back = {3: 1.2, 4: 1.9}
    feet: dict[Side, Strides] = {
        "left": walked("left", 8, 0.8, 1.0, there_and_back),
        "right": walked("right", 8, 0.8, 1.5),
    }
    found = guided_test(feet, "timed_up_and_go")
    assert found is not None
    assert found.turn_count == 1
    # From the toe-off of the fourth stride to the contact of the fifth.
    assert found.turn_s == pytest.approx(1.4)
    assert "walk.no_chair" in codes(found.reasons)
    straight = guided_test({"left": feet["right"]}, "timed_up_and_go")
    assert straight is not None
    assert np.isnan(straight.turn_s)
    assert "walk.no_turn" in codes(straight.reasons)


def test_nobody_walked_and_no_such_test() -> None:
    assert guided_test({}) is None
    with pytest.raises(SetupError, match="hop"):
        guided_test({}, "hop")  # type: ignore[arg-type]


@pytest.mark.slow
def test_a_simulated_up_and_go_agrees_with_its_truth() -> None:
    course = (Bout((Leg(6), Leg(6, turn_rad=float(np.pi), length_scale=0.4), Leg(6))),)
    walk = simulate_gait(replace(gait_preset("turns", 1), rate_hz=100.0, course=course))
    strides = analyse_walk(walk.recording, SessionSetup("gait", ("heel_left", "heel_right"), 100.0)).strides
    found = guided_test(strides, "timed_up_and_go")
    assert found is not None
    truth = walk.truth
    ways = [
        np.linalg.norm(np.diff(foot.foothold_m[:, :2], axis=0), axis=1).sum() for foot in truth.feet.values()
    ]
    assert found.distance_m == pytest.approx(np.mean(ways), rel=0.01)
    assert found.time_s == pytest.approx(float(np.ptp(truth.active_s[0])), abs=0.1)
    assert found.step_count == len(truth.step_side)
    assert found.turn_count == 1
    assert 1.5 < found.turn_s < 5.0
