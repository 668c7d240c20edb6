"""How well places are known, and that nothing is stated of them that is smaller than that."""

from dataclasses import replace

import numpy as np
import pytest

from estimators import rotation
from estimators.comparison import build_template, compare, trajectory
from estimators.pipelines import FrameLayout, Frames
from tests.estimators.comparison.conftest import make_planar

SIDE_AXIS = "wrist_right.y"


def reaching_frames(segments, sigma_rad):
    """One tick of an arm held forward, elbow bent: upper arm 0.3 m ahead, forearm 0.25 m up, hand 0.1 m beyond."""
    points = np.array([[0.0, -0.18, 1.4], [0.3, -0.18, 1.4], [0.3, -0.18, 1.65], [0.3, -0.18, 1.75]])
    layout = FrameLayout(
        segments=segments, points=("shoulder_right", "elbow_right", "wrist_right", "hand_right"), angles=()
    )
    count = len(segments)
    return Frames(
        layout=layout,
        first_tick=0,
        time_step_s=0.01,
        q_room_segment=np.tile([1.0, 0.0, 0.0, 0.0], (1, count, 1)),
        point_room_m=points[None],
        angle_rad=np.zeros((1, 0)),
        angle_sigma_rad=np.zeros((1, 0)),
        scalar=np.zeros((1, 0)),
        segment_flags=np.zeros((1, count), dtype=np.uint8),
        angle_flags=np.zeros((1, 0), dtype=np.uint8),
        segment_sigma_rad=None if sigma_rad is None else np.asarray(sigma_rad, float)[None],
    )


def sigma_of(frames, point):
    source = trajectory(frames)
    return np.array([source.sigma[0, source.channels.index(f"{point}_right.{axis}")] for axis in "xyz"])


def test_a_place_is_known_as_well_as_the_segments_that_carry_it():
    """Against random turns of each segment about each axis, 20 000 of them, to 3 %."""
    segments = ("sternum", "upper_arm_right", "forearm_right", "hand_right")
    sigma_rad = np.radians([[9.0, 9.0, 9.0], [1.0, 2.0, 5.0], [0.5, 3.0, 1.0], [2.0, 1.0, 4.0]])
    generator = np.random.default_rng(7)
    links = {1: [0.3, 0.0, 0.0], 2: [0.0, 0.0, 0.25], 3: [0.0, 0.0, 0.1]}
    place = np.zeros((20_000, 3))
    for column, (point, link) in enumerate(zip(("elbow", "wrist", "hand"), links.items(), strict=True)):
        turn = generator.normal(0.0, sigma_rad[link[0]], (20_000, 3))
        place += rotation.rotate(rotation.exp(turn), np.array(link[1]))
        found = sigma_of(reaching_frames(segments, sigma_rad), point)
        # What turns about itself moves by the square of the turn only, which first order leaves out.
        np.testing.assert_allclose(found, place.std(axis=0), rtol=0.03, atol=2e-3, err_msg=str(column))


def test_a_hand_without_a_sensor_goes_with_its_forearm():
    worn = ("sternum", "upper_arm_right", "forearm_right")
    sigma_rad = np.radians([[0.0, 0.0, 0.0], [0.0, 0.0, 0.0], [2.0, 2.0, 2.0]])
    frames = reaching_frames(worn, sigma_rad)
    wrist, hand = sigma_of(frames, "wrist"), sigma_of(frames, "hand")
    np.testing.assert_allclose(wrist, np.radians(2.0) * np.array([0.25, 0.25, 0.0]), atol=1e-12)
    np.testing.assert_allclose(hand, np.radians(2.0) * np.array([0.35, 0.35, 0.0]), atol=1e-12)


def test_without_a_sigma_of_segments_that_of_places_is_unknown():
    assert np.isnan(sigma_of(reaching_frames(("sternum", "upper_arm_right"), None), "elbow")).all()


@pytest.fixture(scope="module")
def shown():
    return make_planar(noise_rad=0.002)


@pytest.fixture(scope="module")
def template(shown):
    return build_template(shown.trajectory, shown.truth, "right", shown.reach_m, shown.primary)


def beside(shown, off_m, sigma_m=np.nan):
    """The hand is off to the left throughout, its place as uncertain as given."""
    source = shown.trajectory
    values, sigma = source.values.copy(), source.sigma.copy()
    column = source.channels.index(SIDE_AXIS)
    values[:, column] += off_m
    sigma[:, column] = sigma_m
    return replace(source, values=values, sigma=sigma)


def findings(source, shown, template):
    result = compare(source, template, "right", shown.reach_m, repetitions=shown.truth)
    return result, " ".join(result.findings).lower()


def test_a_place_is_stated_only_where_it_is_beyond_the_band_by_more_than_its_uncertainty(shown, template):
    width = float(template.above[50, template.channels.index(SIDE_AXIS)])
    off_m = width + 0.03
    result, text = findings(beside(shown, off_m, 0.012), shown, template)
    assert "left" in text, text
    assert all(SIDE_AXIS in one.outside for one in result.repetitions)
    # Not on the template's curve for certain, but perhaps within the band: 1.28 x 2.5 cm are more than the 3 cm.
    assert off_m > 2.0 * 0.025
    _, text = findings(beside(shown, off_m, 0.025), shown, template)
    assert "left" not in text, text
    # And to the template's own curve: nothing is marked either.
    result, text = findings(beside(shown, off_m, 0.6 * off_m), shown, template)
    assert "left" not in text
    assert not any(SIDE_AXIS in one.outside for one in result.repetitions)


def test_an_uncertain_plane_of_elevation_makes_the_place_uncertain(shown, template):
    """Results that state no sigma of segments: the plane turns what the arm reaches outward."""
    source = beside(shown, float(template.above[50, template.channels.index(SIDE_AXIS)]) + 0.03)
    _, text = findings(source, shown, template)
    assert "left" in text, text
    plane_rad = np.radians(6.0)
    with_plane = replace(
        source,
        channels=("thorax_humerus_right_yxy_plane_of_elevation", *source.channels),
        values=np.column_stack([np.zeros(len(source.time_s)), source.values]),
        sigma=np.column_stack([np.full(len(source.time_s), plane_rad), source.sigma]),
        valid=np.column_stack([np.ones(len(source.time_s), bool), source.valid]),
    )
    _, text = findings(with_plane, shown, template)
    assert "left" not in text, text
