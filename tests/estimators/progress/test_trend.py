"""When a change is a change: scatter without trend, priors, intervals, breaks, unusual days."""

import numpy as np
import pytest

from estimators.errors import ShapeError
from estimators.progress import (
    NO_PRIOR,
    Scatter,
    detectable_change,
    discoveries,
    learn_scatter,
    second_differences,
    trends,
)
from estimators.progress._scatter import scatter_of

OPENS = np.array([39.0, 44.0, 50.0, 54.0, 54.0, 59.0])
"""Degrees that an elbow opened in six sessions, each within two."""
DAYS = np.array([0.0, 4.0, 9.0, 15.0, 20.0, 23.0])


def test_improvement_is_no_scatter():
    """S is 1.4 degrees and two single sessions differ by 3.8; the scatter of the first three would have said 27."""
    variance, _ = second_differences(np.arange(6.0), OPENS)
    assert np.sqrt(variance) == pytest.approx(1.4, abs=0.05)
    assert detectable_change(float(np.sqrt(variance))) == pytest.approx(3.8, abs=0.05)
    leaning, _ = second_differences(np.arange(6.0), OPENS + 10.0 * np.arange(6.0))
    assert leaning == pytest.approx(variance)


@pytest.mark.parametrize("days", [np.arange(6.0), DAYS])
def test_an_elbow_that_opens_more_is_said_to(days):
    found = trends(days, OPENS, np.full(6, 2.0 / np.sqrt(6.0)))
    assert found.probability[0] > 0.975
    assert found.lasts[0]
    assert found.change[0] >= 15.0
    assert found.change[0] == pytest.approx(found.end[0] - found.start[0])
    assert found.half_width[0] < found.change[0]


def test_second_differences_do_not_see_a_line_at_uneven_days():
    rng = np.random.default_rng(4)
    days = np.cumsum(rng.uniform(0.5, 9.0, 4000))
    assert second_differences(days, 3.0 - 0.7 * days)[0] == pytest.approx(0.0, abs=1e-18)
    variance, freedom = second_differences(days, 0.5 * days + 3.0 * rng.normal(size=days.shape))
    assert np.sqrt(variance) == pytest.approx(3.0, rel=0.05)
    assert freedom == pytest.approx(4000 / 1.944, rel=0.01)


def test_triples_across_a_break_do_not_count():
    values = np.array([1.0, 1.0, 1.0, 9.0, 9.0, 9.0])
    assert second_differences(np.arange(6.0), values)[0] > 1.0
    assert second_differences(np.arange(6.0), values, np.repeat([0.0, 1.0], 3))[0] == 0.0
    assert np.isnan(second_differences(np.arange(2.0), values[:2])[0])


def test_a_clinic_teaches_the_scatter_of_a_measure():
    """Truth: people whose variances are inverse chi-square with 8 degrees of freedom about 9."""
    rng = np.random.default_rng(2)
    own = 9.0 * 8.0 / rng.chisquare(8.0, 3000)
    freedom = rng.uniform(2.0, 9.0, 3000)
    found = learn_scatter(own * rng.chisquare(freedom) / freedom, freedom)
    assert found.variance == pytest.approx(9.0, rel=0.08)
    assert found.freedom == pytest.approx(8.0, rel=0.3)
    assert found.people == 3000
    assert learn_scatter(own[:4], freedom[:4]) == NO_PRIOR
    assert learn_scatter(np.zeros(9), np.ones(9)) == NO_PRIOR


def test_scatter_is_shrunk_and_never_below_what_repetitions_say():
    assert scatter_of(4.0, 3.0, Scatter(16.0, 9.0)) == pytest.approx(np.sqrt((12.0 + 144.0) / 12.0))
    assert scatter_of(0.0, 3.0, NO_PRIOR, error=1.5) == 1.5
    assert np.isnan(scatter_of(np.nan, 0.0, NO_PRIOR))
    still = trends(np.arange(8.0), np.full(8, 50.0), np.full(8, 2.0))
    assert still.scatter[0] == pytest.approx(2.0)
    assert still.half_width[0] > 2.0


def test_a_session_of_one_repetition_counts_for_less():
    values = np.array([50.0, 50.5, 49.5, 50.0, 50.2, 49.8, 50.1, 54.0])
    alike = trends(np.arange(8.0), values, np.full(8, 0.5), priors=Scatter(4.0, 20.0))
    errors = np.append(np.full(7, 0.5), 8.0)
    unsure = trends(np.arange(8.0), values, errors, priors=Scatter(4.0, 20.0))
    assert alike.change[0] > 2.0 * abs(unsure.change[0])


def test_one_good_day_is_unusual_and_changes_nothing():
    rng = np.random.default_rng(1)
    days = np.arange(10.0)
    values = 50.0 + rng.normal(size=10)
    usual = trends(days, values, priors=Scatter(1.0, 10.0))
    assert not usual.unusual[0]
    values[-1] = 60.0
    found = trends(days, values, priors=Scatter(1.0, 10.0))
    assert found.unusual[0]
    assert found.expected[0] == pytest.approx(50.0, abs=2.0)
    assert 0.025 < found.probability[0] < 0.975
    assert abs(found.change[0]) < 3.0


def test_a_step_at_a_break_is_no_change():
    rng = np.random.default_rng(3)
    values = 50.0 + rng.normal(size=12) + np.repeat([0.0, 8.0], 6)
    days = 2.0 * np.arange(12)
    prior = Scatter(1.0, 10.0)
    assert trends(days, values, priors=prior).probability[0] > 0.975
    found = trends(days, values, segments=np.repeat([0.0, 1.0], 6), priors=prior)
    assert abs(found.change[0]) < found.half_width[0]


def test_what_lies_before_eight_weeks_is_another_time():
    days = 7.0 * np.arange(16)
    values = np.where(days < 50.0, days, 50.0) + 0.1 * (-1.0) ** np.arange(16)
    found = trends(days, values)
    assert days[found.first] == days[-1] - 56.0
    assert abs(found.change[0]) < 1.0


def test_three_days_give_values_only():
    found = trends(np.arange(3.0), OPENS[:3])
    assert np.isnan([found.change[0], found.half_width[0], found.probability[0]]).all()
    four = trends(np.arange(4.0), OPENS[:4])
    assert np.isfinite(four.change[0])


def test_units_do_not_matter():
    degrees = trends(DAYS, OPENS, priors=Scatter(4.0, 8.0))
    turns = trends(DAYS, OPENS / 360.0, priors=Scatter(4.0 / 360.0**2, 8.0))
    assert turns.change == pytest.approx(degrees.change / 360.0)
    assert turns.half_width == pytest.approx(degrees.half_width / 360.0)
    assert turns.probability == pytest.approx(degrees.probability)
    falls = trends(DAYS, -OPENS, priors=Scatter(4.0, 8.0))
    assert falls.probability == pytest.approx(1.0 - degrees.probability)


def test_days_must_ascend():
    with pytest.raises(ShapeError):
        trends(np.array([0.0, 1.0, 1.0, 2.0]), OPENS[:4])


def test_false_discoveries_are_held_by_benjamini_and_hochberg():
    """Of their table 1: fifteen p, of which four are rejected at 0.05."""
    p = np.array([0.0001, 0.0004, 0.0019, 0.0095, 0.0201, 0.0278, 0.0298, 0.0344, 0.0459, 0.3240, 0.4262])
    p = np.append(p, [0.5719, 0.6528, 0.7590, 1.0])
    assert discoveries(1.0 - 0.5 * p, main=None).tolist() == [True] * 4 + [False] * 11
    alone = discoveries(1.0 - 0.5 * np.append(0.049, p), main=0)
    assert alone.tolist() == [True] * 5 + [False] * 11
    assert not discoveries(np.array([np.nan, np.nan])).any()
