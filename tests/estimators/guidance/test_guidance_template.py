"""A template made ready: weights, targets, other side and size; and the therapist's band."""

from dataclasses import replace

import numpy as np
import pytest

from estimators.comparison import FREE, Knot, NamedPhase, ToleranceCurve, mirror_template
from estimators.errors import SetupError
from estimators.guidance import prepare_template, steers
from estimators.guidance._template import PACES
from tests.estimators.guidance.conftest import ready, template

ELEVATION = "thorax_humerus_right_yxy_elevation"
LEAN = "trunk_lean_lateral_rad"


def test_compensation_and_singular_angles_do_not_steer():
    assert steers(ELEVATION)
    assert steers("wrist_right.z")
    assert steers("thigh_left_lean_forward_rad")
    for name in (
        "trunk_lean_forward_rad",
        "shoulder_hike_right_m",
        "thorax_humerus_right_yxy_axial_rotation",
        "thorax_humerus_right_yxy_plane_of_elevation",
        "forearm_hand_right_zxy_flexion",
        "hand_right.x",
    ):
        assert not steers(name)
    assert "trunk_lean_forward_rad" not in ready().steering


def test_the_wrist_steers_only_where_angles_hardly_move():
    made = ready()
    assert made.steering
    assert not any("." in name for name in made.steering)
    assert prepare_template(template(), "right", 0.55, steering=["wrist_right.z"]).steering == (
        made.main,
        "wrist_right.z",
    )
    mean = template().mean.copy()
    for column, name in enumerate(template().channels):
        if "." not in name:
            mean[:, column] = mean[0, column] + 0.13 * (mean[:, column] - mean[0, column])
    # 1.0 rad becomes 0.13, half as much again as the floor: (1.5 - 1) / 3 is far from enough.
    assert "wrist_right.z" in prepare_template(replace(template(), mean=mean), "right", 0.55).steering


def test_slopes_of_the_template_are_as_late_as_those_that_are_measured():
    phase = np.linspace(0.0, 1.0, 101)
    main = template().channels.index(template().primary_channel)
    mean = template().mean.copy()
    mean[:, main] = 4.0 * phase * (1.0 - phase)
    made = prepare_template(replace(template(), mean=mean), "right", 0.55)
    row = made.steering.index(made.main)
    middle = (np.arange(64) + 0.5) / 64
    for number, pace in enumerate(PACES):
        slope, late = made.model.slope[number, row], 0.12 * pace / template().duration_s
        # Of a parabola a line through the past 0.24 s has the slope 0.12 s ago; before its beginning there is rest.
        known = middle > 2.0 * late
        assert slope[known] == pytest.approx(4.0 - 8.0 * (middle[known] - late), abs=0.01)
        assert slope[0] < 4.0 - 8.0 * (middle[0] - late) - 0.5


def test_weights_follow_the_range():
    made = ready()
    column = made.steering.index("humerus_forearm_right_zxy_pronation")
    # 0.4 rad and a floor of 0.087: (0.4 / 0.087 - 1) / 3 is above one.
    assert made.model.weight[column] == 1.0
    small = replace(template(), mean=template().mean * 0.3)
    weight = prepare_template(small, "right", 0.55).model.weight
    name = prepare_template(small, "right", 0.55).steering.index("humerus_forearm_right_zxy_pronation")
    assert weight[name] == pytest.approx((0.12 / 0.087 - 1) / 3, abs=0.01)


def test_targets_are_the_extremes_of_the_main_channel():
    assert ready().target_phase == pytest.approx([0.5], abs=0.06)
    assert ready().target_offset == pytest.approx([0.9], abs=0.01)
    phase = np.linspace(0.0, 1.0, 101)
    mean = template().mean.copy()
    main = template().channels.index(template().primary_channel)
    mean[:, main] = 0.5 * np.sin(2 * np.pi * phase)
    two = prepare_template(replace(template(), mean=mean), "right", 0.55)
    assert two.target_phase == pytest.approx([0.25, 0.75], abs=0.011)
    assert two.target_offset == pytest.approx([0.5, -0.5], abs=0.001)


def test_other_side_and_size():
    made = prepare_template(mirror_template(template()), "right", 2.0 * template().reach_m)
    assert made.side == "right"
    assert made.main == ready().main
    point = made.channels.index("wrist_right.x")
    assert np.allclose(made.mean[:, point], 2.0 * ready().mean[:, point])
    angle = made.channels.index(ELEVATION)
    assert np.allclose(made.mean[:, angle], ready().mean[:, angle])


def test_band_is_piecewise_linear_and_apart_for_both_sides():
    curve = ToleranceCurve(ELEVATION, (Knot(0.2, 1.0, 2.0), Knot(0.4, 1.0, 4.0), Knot(0.6, 0.5, FREE)))
    drawn = replace(template(), tolerances=(curve,))
    below, above = drawn.below, drawn.above
    column = template().channels.index(ELEVATION)
    own = template().tolerance[:, column]
    assert above[[0, 20, 30, 40], column] == pytest.approx(own[[0, 20, 30, 40]] * [2.0, 2.0, 3.0, 4.0])
    assert np.isinf(above[41:, column]).all()
    assert below[[30, 50, 100], column] == pytest.approx(own[[30, 50, 100]] * [1.0, 0.75, 0.5])
    others = [i for i in range(len(template().channels)) if i != column]
    assert np.array_equal(above[:, others], template().tolerance[:, others], equal_nan=True)


def test_band_turns_round_with_the_sign():
    curve = ToleranceCurve(LEAN, (Knot(0.0, 1.0, 3.0),))
    drawn = replace(template(), tolerances=(curve,))
    here, across = prepare_template(drawn, "right", 0.55), prepare_template(drawn, "left", 0.55)
    column = here.channels.index(LEAN)
    assert np.allclose(across.below[:, column], here.above[:, column])
    assert np.allclose(across.above[:, column], here.below[:, column])


def test_what_cannot_be_prepared_is_refused():
    with pytest.raises(SetupError):
        prepare_template(template(), "right", 0.0)
    with pytest.raises(SetupError):
        prepare_template(template(), "right", 0.55, steering=["nothing"])
    with pytest.raises(SetupError):
        prepare_template(replace(template(), mean=0.0 * template().mean), "right", 0.55)
    for knots in ((), (Knot(0.5), Knot(0.5)), (Knot(0.6), Knot(0.5))):
        with pytest.raises(SetupError):
            ToleranceCurve(ELEVATION, knots)
    for wrong in ((1.5, 1.0, 1.0), (0.5, 0.0, 1.0), (0.5, 1.0, float("nan"))):
        with pytest.raises(SetupError):
            Knot(*wrong)
    with pytest.raises(SetupError):
        replace(template(), tolerances=(ToleranceCurve("nothing", (Knot(0.5),)),))
    with pytest.raises(SetupError):
        replace(template(), watched=(template().primary_channel,))
    with pytest.raises(SetupError):
        replace(template(), phases=(NamedPhase("Out", 0.0, 0.5), NamedPhase("Back", 0.4, 1.0)))
    for wrong_phase in (("", 0.0, 1.0), ("Out", 0.5, 0.5), ("Out", -0.1, 0.5)):
        with pytest.raises(SetupError):
            NamedPhase(*wrong_phase)
