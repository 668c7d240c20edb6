"""Feet that clinics see, carried, walking backward, trembling, exchanged or on wheels: said, and not averaged."""

import numpy as np
import pytest
from two_feet import OVER, RATE_HZ, SIDES, analysed, bump, even_walk, path, readings, turned

from estimators import rotation
from estimators.recording import SensorSignals
from tests.said import codes


def backward(feet):
    """Return the readings of the same walk played backward in time."""
    return {
        side: SensorSignals(one.time_s, -one.gyroscope_radps[::-1], one.accelerometer_mps2[::-1])
        for side, one in feet.items()
    }


def crutches(carried, sway_hz, sway_rad):
    """Return eight hops of 0.5 m on one foot while the other one hangs 20 cm above the floor."""
    lifts = 4.0 + 1.6 * np.arange(8)
    feet = {}
    for side in SIDES:
        aside, out = (0.08, 0.1) if side == "left" else (-0.08, -0.1)
        time, place, q = path(lifts, lifts + 0.5, np.full(8, 0.5), 21.0, aside_m=aside, out_rad=out)
        if side == carried:
            up = np.interp(time, [2.5, 3.3, 17.7, 18.5], [0.0, 1.0, 1.0, 0.0])
            up = up**3 * (10.0 - 15.0 * up + 6.0 * up**2)
            sway = np.sin(2.0 * np.pi * sway_hz * time)
            place = place * [1.0, 1.0, 0.0] + np.outer(up * (0.2 + 0.1 * sway_rad * sway), [0.0, 0.0, 1.0])
            q = turned(out, up * (0.5 + sway_rad * sway))
        feet[side] = readings(place, q, seed=7 if side == "left" else 8)
    return feet


def trembling(hz, degrees):
    """Return what shakes the foot about its heel, 6 cm below the sensor and 4 behind it."""

    def change(side, time, place, q):
        angle = np.radians(degrees) * (
            np.sin(2.0 * np.pi * hz * time + (0.7 if side == "left" else 2.0)) - 1.0
        )
        shaken = rotation.multiply(q, turned(0.0, angle))
        heel = np.tile([-0.04, 0.0, -0.06], (len(time), 1))
        return place + rotation.rotate(q, heel) - rotation.rotate(shaken, heel), shaken

    return change


def rolling(push_mps2):
    """Return two feet on a footrest: pushed each 1.2 s for 15 s, then braked."""
    time = np.arange(round(25.0 * RATE_HZ * OVER)) / (RATE_HZ * OVER)
    acceleration = np.zeros_like(time)
    for start_s in 4.0 + 1.2 * np.arange(12):
        acceleration += push_mps2 * bump(time, start_s, start_s + 0.7)
        acceleration -= push_mps2 * bump(time, start_s + 0.6, start_s + 1.3)
    along = np.cumsum(np.cumsum(acceleration)) / (RATE_HZ * OVER) ** 2
    feet = {}
    for number, side in enumerate(SIDES):
        place = np.stack([along, np.zeros_like(time), np.zeros_like(time)], axis=1)
        feet[side] = readings(place, turned(0.1, np.zeros_like(time)), seed=number)
    return feet


@pytest.mark.parametrize(
    ("carried", "sway_hz", "sway_rad"), [("left", 0.6, 0.15), ("right", 1.0, 0.15), ("left", 0.3, 0.02)]
)
def test_a_carried_foot_is_said_and_the_way_is_that_of_the_other(carried, sway_hz, sway_rad):
    walk, test = analysed(crutches(carried, sway_hz, sway_rad), apart_m=0.16)
    assert test.distance_m == pytest.approx(4.0, abs=0.1)
    assert test.step_count == 8
    assert "walk.carried_way" in codes(test.reasons)
    assert codes(walk.summary.reasons) == ["walk.carried"]
    assert walk.steps is None
    assert walk.summary.both == {}
    assert walk.summary.asymmetry == {}
    assert walk.summary.feet[carried]["stride_length"].count == 0


def test_a_walk_backward_is_said_and_its_events_are_the_right_way_round():
    feet = even_walk(out_rad=0.1)
    forward, _ = analysed(feet)
    found, _ = analysed(backward(feet))
    assert codes(forward.summary.reasons) == []
    assert codes(found.summary.reasons) == ["walk.backward"]
    for side in SIDES:
        there, back = forward.summary.feet[side], found.summary.feet[side]
        assert back["stance_share"].value == pytest.approx(there["stance_share"].value, abs=0.03)
        assert back["toe_out"].value == pytest.approx(there["toe_out"].value, abs=0.03)
        # What was lifted steeply is put down steeply.
        assert back["toe_off_pitch"].value == pytest.approx(there["contact_pitch"].value, abs=0.05)
    shares = [walk.summary.both["double_support_share"].value for walk in (forward, found)]
    assert shares[1] == pytest.approx(shares[0], abs=0.03)


@pytest.mark.parametrize(("hz", "degrees"), [(5.0, 3.0), (4.0, 3.0), (6.0, 1.0)])
def test_clonus_is_said_and_no_difference_between_the_feet_is_made_of_it(hz, degrees):
    walk, _ = analysed(even_walk(count=8, length_m=0.9, change=trembling(hz, degrees)))
    said = codes(walk.summary.reasons)
    assert said.count("walk.trembling") == 2
    for side in SIDES:
        found = walk.summary.feet[side]["stride_length"]
        assert found.count == 0 or abs(found.value - 0.9) < 3.0 * found.sigma
    asymmetry = walk.summary.asymmetry["stride_length"]
    assert not abs(asymmetry.value) > 3.0 * asymmetry.sigma


def test_two_feet_that_cannot_have_gone_so_are_said_to_have_lost_strides():
    feet = even_walk(count=12)
    other = even_walk(count=8)
    walk, test = analysed({"left": feet["left"], "right": other["right"]})
    assert "walk.counts_apart" in codes(walk.summary.reasons)
    assert codes(test.reasons) == ["walk.ways_apart"]
    assert test.distance_m == pytest.approx(11.5 * 1.2, abs=0.1)


@pytest.mark.parametrize(
    ("left_deg", "right_deg", "asks"),
    [
        (6.0, 6.0, False),
        (-6.0, -6.0, True),
        (-10.0, 5.0, False),
        (24.0, 10.0, False),
        (-10.0, -24.0, True),
        (0.0, 1.0, False),
    ],
)
def test_both_feet_inward_ask_whether_the_shoes_are_exchanged(left_deg, right_deg, asks):
    left = even_walk(out_rad=np.radians(left_deg))["left"]
    right = even_walk(out_rad=-np.radians(right_deg))["right"]
    walk, _ = analysed({"left": left, "right": right})
    assert ("walk.exchanged" in codes(walk.summary.reasons)) == asks


def test_feet_on_wheels_are_said_and_feet_on_the_floor_are_not():
    walk, test = analysed(rolling(0.6))
    assert "walk.rolled" in codes(walk.summary.reasons)
    assert test is None
    walk, _ = analysed(rolling(0.0))
    assert "walk.rolled" not in codes(walk.summary.reasons)
