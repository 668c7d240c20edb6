"""Segmental centre of mass, margin of stability, work, prediction without force sensors, and statistics."""

import numpy as np
import pytest
from scipy import stats

from estimators import rotation
from estimators.balance import base_of_support, sole_corners, stability_margin
from estimators.balance.published import (
    body_segments,
    extrapolated_mass_centre,
    margin_to_edge,
    repeated_measures,
    segmental_mass_centre,
    sideways_margin,
    walking_work,
)
from estimators.body import body_from_stature
from estimators.conventions import GRAVITY_MPS2, PLACEMENTS, SIDES
from estimators.errors import SetupError, ShapeError
from estimators.kinetics import ShoeGeometry
from estimators.kinetics.published import predicted_reaction
from validation.shoes.walk import analysed_walk, com_scenario


@pytest.fixture(scope="module")
def walk():
    return analysed_walk(com_scenario(1, errors="ideal"))


def upright(names=PLACEMENTS, ticks=2):
    return {name: rotation.identity((ticks,)) for name in names}


@pytest.mark.parametrize("sex", ["man", "woman"])
def test_standing_body_has_its_centre_where_anatomy_says(sex):
    body = body_from_stature(1.75)
    found = segmental_mass_centre(upright(), body_segments(sex), body)
    # Textbooks: 56 to 57 % of stature in men, 55 to 56 % in women.
    assert 0.54 < found.position_m[0, 2] / 1.75 < 0.585
    assert abs(found.position_m[0, 1]) < 1e-12
    assert abs(found.position_m[0, 0]) < 0.02
    assert sum(found.mass_share.values()) == pytest.approx(1.0, abs=1e-12)
    assert found.assumed == ()
    assert len(found.parts_m) == len(found.mass_share)


def test_arms_raised_shift_the_centre_by_their_share():
    segments, body = body_segments("man"), body_from_stature(1.75)
    low = segmental_mass_centre(upright(), segments, body)
    raised = upright()
    forward = rotation.about_y(np.full(2, -0.5 * np.pi))
    for side in SIDES:
        for part in ("upper_arm", "forearm", "hand"):
            raised[f"{part}_{side}"] = forward
    high = segmental_mass_centre(raised, segments, body)
    expected = sum(
        share * (high.parts_m[name] - low.parts_m[name])[0] for name, share in low.mass_share.items()
    )
    np.testing.assert_allclose((high.position_m - low.position_m)[0], expected, atol=1e-12)
    assert 0.02 < (high.position_m - low.position_m)[0, 0] < 0.06


def test_turning_mirroring_and_moving_the_body():
    rng = np.random.default_rng(1)
    q = {name: rotation.exp(0.3 * rng.normal(size=(4, 3))) for name in PLACEMENTS}
    hip = rng.normal(size=(4, 3))
    segments = body_segments("woman")
    one = segmental_mass_centre(q, segments, hip_m=hip).position_m
    turn = rotation.exp(np.array([0.2, -0.1, 0.8]))
    turned = segmental_mass_centre(
        {name: rotation.multiply(turn, value) for name, value in q.items()},
        segments,
        hip_m=rotation.rotate(turn, hip),
    ).position_m
    np.testing.assert_allclose(turned, rotation.rotate(turn, one), atol=1e-12)
    swapped = {}
    for name, value in q.items():
        other = name.replace("left", "?").replace("right", "left").replace("?", "right")
        swapped[other] = value * [1.0, -1.0, 1.0, -1.0]
    flip = np.array([1.0, -1.0, 1.0])
    mirrored = segmental_mass_centre(swapped, segments, hip_m=hip * flip).position_m
    np.testing.assert_allclose(mirrored, one * flip, atol=1e-12)


def test_fewer_sensors_are_said_and_own_masses_count():
    few = segmental_mass_centre(upright(("sternum", "thigh_left")), body_segments("man"))
    assert "pelvis" in few.assumed
    assert "shank_left" in few.assumed
    assert "thigh_left" not in few.assumed
    # A leg lost above the ankle with a light prosthesis moves the centre up and to the other side.
    own = segmental_mass_centre(upright(), body_segments("man", {"foot_left": 0.005, "shank_left": 0.02}))
    whole = segmental_mass_centre(upright(), body_segments("man"))
    assert own.position_m[0, 1] < whole.position_m[0, 1] - 0.001
    assert own.position_m[0, 2] > whole.position_m[0, 2]
    assert sum(own.mass_share.values()) == pytest.approx(1.0, abs=1e-12)
    with pytest.raises(SetupError, match="sternum or the pelvis"):
        segmental_mass_centre(upright(("head",)), body_segments("man"))
    with pytest.raises(SetupError, match="no part of the body"):
        body_segments("man", {"tail": 0.1}).masses()
    with pytest.raises(SetupError, match="'man' and 'woman'"):
        body_segments("child")
    with pytest.raises(ShapeError, match="one shape"):
        segmental_mass_centre(upright() | {"head": rotation.identity((5,))}, body_segments("man"))


def test_margin_to_a_square_is_what_one_sees():
    square = base_of_support(
        [np.array([[0, 0], [1, 0], [np.nan, np.nan]]), np.array([[1, 1], [0, 1], [0.5, 0.5]])]
    )
    assert len(square) == 4
    assert margin_to_edge(np.array([0.5, 0.5]), square) == pytest.approx(0.5)
    assert margin_to_edge(np.array([0.9, 0.5]), square) == pytest.approx(0.1)
    assert margin_to_edge(np.array([1.3, 0.5]), square) == pytest.approx(-0.3)
    assert margin_to_edge(np.array([1.3, 1.4]), square) == pytest.approx(-0.5)
    assert len(base_of_support([np.array([[0.0, 0.0], [1.0, 1.0], [2.0, 2.0]])])) == 0
    assert np.isnan(margin_to_edge(np.zeros(2), np.empty((0, 2))))


def test_pendulum_with_its_extrapolated_centre_at_the_pressure_centre_comes_to_rest_there():
    """Hof's reason for it: from speed v at distance v / w_0 the pendulum just reaches its support."""
    omega = np.sqrt(GRAVITY_MPS2 / 1.0)
    time = np.linspace(0.0, 3.0, 50)
    centre = np.zeros((50, 3))
    centre[:, 0], centre[:, 2] = -0.2 * np.exp(-omega * time), 1.0
    velocity = np.zeros((50, 3))
    velocity[:, 0] = 0.2 * omega * np.exp(-omega * time)
    found = extrapolated_mass_centre(centre, velocity)
    np.testing.assert_allclose(found, 0.0, atol=1e-12)
    with pytest.raises(ShapeError, match="above the floor"):
        extrapolated_mass_centre(centre - [0.0, 0.0, 2.0], velocity)


def test_margins_of_a_walk(walk):
    truth, shoe = walk.truth, ShoeGeometry()
    corners = {
        side: sole_corners(
            walk.feet.pose[side], shoe, walk.shoes[side].contact.heel, walk.shoes[side].contact.forefoot
        )
        for side in SIDES
    }
    found = stability_margin(truth.com.position, truth.com.velocity, corners)
    still = walk.feet.is_standing
    # Standing is safe; in the middle of every step the body falls forward, outside its base.
    assert found.margin_m[still].min() > 0.02
    walking = (truth.time_s > truth.active_s[0, 0] + 1.0) & (truth.time_s < truth.active_s[0, 1] - 1.0)
    assert np.nanmin(found.margin_m[walking]) < -0.05
    for side in SIDES:
        single = (
            walking
            & walk.shoes[side].contact.any
            & ~walk.shoes["left" if side == "right" else "right"].contact.any
        )
        aside = sideways_margin(found.extrapolated_m, corners[side], side)
        assert np.isfinite(aside[single]).all()
        assert aside[single].mean() > 0.0
    with pytest.raises(SetupError, match="both feet"):
        stability_margin(truth.com.position, truth.com.velocity, {"left": corners["left"]})


def test_forces_predicted_without_force_sensors(walk):
    truth = walk.truth
    contact = {side: truth.feet[side].is_contact for side in SIDES}
    found = predicted_reaction(truth.com.position, truth.com.acceleration, truth.mass_kg, contact)
    np.testing.assert_allclose(found.total_n, truth.force_n, atol=1e-9)
    weight = truth.mass_kg * GRAVITY_MPS2
    walking = (truth.time_s > truth.active_s[0, 0]) & (truth.time_s < truth.active_s[0, 1])
    for side in SIDES:
        error = (found.force_n[side] - truth.feet[side].force_n)[walking]
        assert np.sqrt(np.mean(error[:, 2] ** 2)) < 0.03 * weight
        assert np.sqrt(np.mean(error[:, :2] ** 2)) < 0.06 * weight
    cop = (found.cop_m - truth.cop_m)[walking, :2]
    # What is left is the angular momentum that the prediction takes for constant: 20 Nm are 24 mm here.
    assert np.sqrt(np.mean(cop**2)) < 0.025
    with pytest.raises(SetupError, match="both feet"):
        predicted_reaction(
            truth.com.position, truth.com.acceleration, truth.mass_kg, {"left": contact["left"]}
        )


def test_work_of_a_pure_pendulum_is_got_back():
    time = np.linspace(0.0, 10.0, 2001)
    height = 1.0 + 0.02 * np.cos(2 * np.pi * time)
    # Speed such that kinetic and potential energy add up to a constant: recovery is one.
    speed = np.sqrt(2.0 * GRAVITY_MPS2 * (1.15 - height))
    position = np.column_stack((np.cumsum(speed) * 0.005, np.zeros(2001), height))
    velocity = np.column_stack((speed, np.zeros(2001), np.zeros(2001)))
    found = walking_work(position, velocity, 70.0)
    assert found.recovery == pytest.approx(1.0, abs=1e-9)
    assert found.vertical_j == pytest.approx(10 * 70.0 * GRAVITY_MPS2 * 0.04, rel=1e-3)
    bounce = np.column_stack((np.full(2001, 1.0), np.zeros(2001), np.zeros(2001)))
    assert walking_work(position, bounce, 70.0).recovery == pytest.approx(0.0, abs=1e-9)


def test_two_by_two_design_is_three_paired_t_tests():
    rng = np.random.default_rng(4)
    values = rng.normal(size=(8, 2, 2)) + rng.normal(size=(8, 1, 1)) + np.array([[[0.0, 0.2], [0.5, 0.9]]])
    effects = {effect.name: effect for effect in repeated_measures(values, ("condition", "system"))}
    pairs = {
        "condition": values.mean(axis=2)[:, 1] - values.mean(axis=2)[:, 0],
        "system": values.mean(axis=1)[:, 1] - values.mean(axis=1)[:, 0],
        "condition x system": values[:, 0, 0] - values[:, 0, 1] - values[:, 1, 0] + values[:, 1, 1],
    }
    for name, difference in pairs.items():
        t, p = stats.ttest_1samp(difference, 0.0)
        assert effects[name].f == pytest.approx(t**2, rel=1e-10)
        assert effects[name].p == pytest.approx(p, rel=1e-9)
        assert effects[name].degrees == (1.0, 7.0)
        assert effects[name].epsilon == pytest.approx(1.0)
        assert effects[name].partial_eta_squared == pytest.approx(t**2 / (t**2 + 7.0), rel=1e-10)


def test_three_levels_by_sums_of_squares():
    """The textbook's table: effect, people and what is left add up to the whole."""
    rng = np.random.default_rng(5)
    values = rng.normal(size=(10, 3)) + rng.normal(size=(10, 1)) + [0.0, 0.4, 0.9]
    (effect,) = repeated_measures(values, ("speed",))
    grand = values.mean()
    of_effect = 10 * np.sum((values.mean(axis=0) - grand) ** 2)
    of_people = 3 * np.sum((values.mean(axis=1) - grand) ** 2)
    rest = np.sum((values - grand) ** 2) - of_effect - of_people
    assert effect.f == pytest.approx((of_effect / 2) / (rest / 18), rel=1e-10)
    assert effect.degrees == (2.0, 18.0)
    assert 0.5 <= effect.epsilon <= 1.0
    assert effect.p_corrected >= effect.p
    assert effect.is_significant(1.0)


def test_false_alarms_are_as_many_as_alpha_says():
    rng = np.random.default_rng(6)
    hits = [repeated_measures(rng.normal(size=(8, 2)), ("a",))[0].p < 0.05 for _ in range(1500)]
    # Standard error of a share of 5 % over 1500: 0.6 %.
    assert np.mean(hits) == pytest.approx(0.05, abs=0.018)


def test_designs_that_cannot_be_analysed():
    with pytest.raises(ShapeError, match="factor names"):
        repeated_measures(np.zeros((4, 2)), ("a", "b"))
    with pytest.raises(ShapeError, match="two people"):
        repeated_measures(np.zeros((1, 2)), ("a",))
    with pytest.raises(ShapeError, match="missing"):
        repeated_measures(np.array([[1.0, np.nan], [1.0, 2.0]]), ("a",))
