import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from estimators.errors import SetupError, ShapeError
from estimators.gait import foot_placement
from estimators.gait._placement import END_FACTOR_3, MIDDLE_FACTOR_3, RMS_FACTOR_3, steps_between
from tests.said import refuses


def walk(lateral, lengths, heading=0.0):
    x = np.concatenate([[0.0], np.cumsum(lengths)])
    cosine, sine = np.cos(heading), np.sin(heading)
    return np.stack([x, lateral], axis=1) @ np.array([[cosine, sine], [-sine, cosine]])


def test_equal_spacing_of_three_is_the_second_difference():
    lateral = np.array([0.01, -0.02, 0.005])
    found = foot_placement(walk(lateral, [1.2, 1.2]))
    second = lateral[0] - 2 * lateral[1] + lateral[2]
    # The line's own slope shortens perpendicular distances by its cosine, here 5e-5.
    np.testing.assert_allclose(found.lateral_m[0], second / 6 * np.array([1, -2, 1]), rtol=1e-4)


@settings(deadline=None)
@given(
    st.lists(st.floats(-0.2, 0.2), min_size=5, max_size=9),
    st.floats(-3.0, 3.0),
    st.integers(3, 5),
)
def test_turning_the_walk_changes_nothing_and_the_mirror_changes_the_sign(lateral, heading, window):
    lengths = np.linspace(0.9, 1.4, len(lateral) - 1)
    straight = foot_placement(walk(np.array(lateral), lengths), window)
    turned = foot_placement(walk(np.array(lateral), lengths, heading) + np.array([3.0, -2.0]), window)
    mirrored = foot_placement(walk(-np.array(lateral), lengths), window)
    np.testing.assert_allclose(turned.lateral_m, straight.lateral_m, atol=1e-12)
    np.testing.assert_allclose(turned.length_m, straight.length_m, atol=1e-12)
    np.testing.assert_allclose(mirrored.lateral_m, -straight.lateral_m, atol=1e-12)
    np.testing.assert_allclose(straight.lateral_m.sum(axis=1), 0.0, atol=1e-12)


def test_the_published_line_depends_on_the_direction_within_the_walk():
    positions = walk(np.array([0.0, 0.03, 0.0, 0.2, 0.4, 0.6]), np.full(5, 0.6))
    ols = foot_placement(positions, 3, "ols").lateral_m
    assert not np.allclose(ols, foot_placement(positions).lateral_m, atol=1e-4)
    along = walk(np.array([0.0, 0.03, -0.03, 0.0]), np.full(3, 1.2))
    np.testing.assert_allclose(
        foot_placement(along, 3, "ols").lateral_m, foot_placement(along).lateral_m, atol=2e-5
    )


def test_factors_of_independent_footholds():
    random = np.random.default_rng(5)
    lateral = 0.01 * random.standard_normal(20_000)
    found = foot_placement(walk(lateral, np.full(len(lateral) - 1, 1.2)))
    # 6667 independent windows: 1 % each.
    assert found.middle_m.std() == pytest.approx(0.01 * MIDDLE_FACTOR_3, rel=0.03)
    assert found.lateral_m[:, 0].std() == pytest.approx(0.01 * END_FACTOR_3, rel=0.03)
    assert np.sqrt(np.mean(found.lateral_m**2)) == pytest.approx(0.01 * RMS_FACTOR_3, rel=0.03)


def test_too_few_footholds_give_no_window_and_nonsense_is_refused():
    assert foot_placement(np.zeros((2, 2))).lateral_m.shape == (0, 3)
    with pytest.raises(SetupError, match="at least 3"):
        foot_placement(np.zeros((5, 2)), 2)
    with pytest.raises(SetupError, match="tls or ols"):
        foot_placement(np.zeros((5, 2)), 3, "huber")
    with pytest.raises(ShapeError, match="finite"):
        foot_placement(np.full((5, 2), np.nan))


def test_step_width_and_length_of_related_feet():
    left = np.array([[0.0, 0, 0], [1.2, 0, 0], [2.4, 0, 0], [3.6, 0, 0]])
    right = np.array([[0.0, 0, 0], [0.6, 0, 0], [1.8, 0, 0], [3.0, 0, 0]])
    turn = np.array([[np.cos(1.0), np.sin(1.0), 0], [-np.sin(1.0), np.cos(1.0), 0], [0, 0, 1]])
    steps = steps_between(
        left @ turn, np.arange(4) * 1.2, right, np.arange(4) * 1.2 + 0.6, np.array([0.0, -0.15])
    )
    np.testing.assert_allclose(steps.width_m, 0.15, atol=1e-12)
    assert steps.is_left.tolist() == [True, False] * 3
    np.testing.assert_allclose(steps.length_m[steps.is_left], [1.2, 1.8, 1.8])
    np.testing.assert_allclose(steps.length_m[~steps.is_left], -0.6, atol=1e-12)
    with refuses("walk.few_footholds", error=ShapeError, least=2):
        steps_between(left[:1], np.zeros(1), right, np.arange(4.0), np.zeros(2))
