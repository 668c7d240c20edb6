"""What differs by less than its own uncertainty at that phase is no finding, whatever it is called."""

from dataclasses import replace

import numpy as np
import pytest

from estimators.comparison import (
    build_template,
    compare,
    comparison_from_bytes,
    comparison_to_bytes,
)
from tests.estimators.comparison.conftest import make_planar

CHANNEL = "humerus_forearm_right_zxy_pronation"
OFF_RAD = float(np.radians(25.0))


@pytest.fixture(scope="module")
def shown():
    return make_planar(noise_rad=0.002)


@pytest.fixture(scope="module")
def template(shown):
    return build_template(shown.trajectory, shown.truth, "right", shown.reach_m, shown.primary)


def turned_while_low(made, sigma_rad):
    """One angle is off while the arm is low, where its uncertainty is `sigma_rad`."""
    source = made.trajectory
    column = source.channels.index(CHANNEL)
    is_low = source.values[:, 0] < 0.6
    values, sigma = source.values.copy(), source.sigma.copy()
    values[is_low, column] += OFF_RAD
    sigma[is_low, column] = sigma_rad
    return replace(source, values=values, sigma=sigma)


def compared(source, made, template):
    return compare(source, template, "right", made.reach_m, repetitions=made.truth)


def test_a_difference_within_its_uncertainty_is_no_finding(shown, template):
    sure = compared(turned_while_low(shown, 0.02), shown, template)
    assert any("forearm pronation" in text.lower() for text in sure.findings), sure.findings
    assert all(CHANNEL in one.outside for one in sure.repetitions)
    unsure = compared(turned_while_low(shown, OFF_RAD / 1.9), shown, template)
    assert not any("pronation" in text.lower() for text in unsure.findings), unsure.findings
    assert all(CHANNEL not in one.outside for one in unsure.repetitions)


def test_a_stretch_that_is_sure_is_found_beside_one_that_is_not(shown, template):
    """The largest difference may be the least certain one: what is certain elsewhere is found all the same."""
    source = turned_while_low(shown, np.pi / 2)
    column = source.channels.index(CHANNEL)
    values = source.values.copy()
    values[source.values[:, 0] > 1.0, column] += 0.8 * OFF_RAD
    result = compared(replace(source, values=values), shown, template)
    assert any("pronation" in text.lower() for text in result.findings), result.findings
    for one in result.repetitions:
        assert all(start > 5 and end < 96 for start, end in one.outside[CHANNEL])


def test_it_is_stored_and_a_comparison_from_before_is_read(shown, template):
    result = compared(turned_while_low(shown, 0.4), shown, template)
    column = result.channels.index(CHANNEL)
    stored = comparison_from_bytes(comparison_to_bytes(result))
    for one, other in zip(result.repetitions, stored.repetitions, strict=True):
        np.testing.assert_array_equal(other.sigma, one.sigma)
        assert one.sigma[0, column] == pytest.approx(0.4)
        assert one.sigma[50, column] == pytest.approx(0.01)
