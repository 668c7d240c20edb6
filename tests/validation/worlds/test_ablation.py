"""Each variant switches off one mechanism, and its figures are differences in the same worlds."""

from dataclasses import asdict

import numpy as np
import pytest

from estimators import orientation, rotation
from estimators.orientation import OrientationResult
from estimators.orientation.telemotion._parameters import TelemotionParameters
from validation.worlds import conditions_of, draw, scores
from validation.worlds.ablation import ORIENTATION_ABLATION, VARIANTS
from validation.worlds.conditions import WHOLE


@pytest.mark.parametrize("variant", VARIANTS)
def test_a_variant_differs_from_the_defaults_and_is_accepted(variant):
    defaults = asdict(TelemotionParameters())
    assert all(defaults[name] != value for name, value in VARIANTS[variant].items())
    orientation.create("telemotion", 1, 0.01, VARIANTS[variant])


def test_figures_are_differences_and_worlds_turned_all_along_do_not_count(monkeypatch):
    seed = next(seed for seed in range(20) if WHOLE not in conditions_of(seed).rows())
    turned_whole = next(seed for seed in range(20) if WHOLE in conditions_of(seed).rows())
    world = draw(seed)

    def estimate(chunk, parameters=None):
        # Without sway the made-up method is twice as far off about an axis that no reference removes.
        off_deg = 4.0 if parameters and "rest_sway_s" in parameters else 2.0
        turn = rotation.exp(np.radians([off_deg, 0.0, 0.0]))
        q = rotation.multiply(turn, world.q_earth_sensor)[None]
        sigma = np.full((1, len(q[0]), 3), np.radians(1.0))
        return OrientationResult(q, np.zeros_like(sigma), sigma, np.zeros(q.shape[:2], np.uint8))

    monkeypatch.setattr(
        scores, "METHODS", {name: (estimate, lambda *_: world.q_earth_sensor) for name in scores.METHODS}
    )
    values = ORIENTATION_ABLATION.measure([seed, turned_whole], {})
    assert set(values) == {figure.name for figure in ORIENTATION_ABLATION.figures}
    assert values["whole filter, online, error"] == pytest.approx([2.0], abs=0.01)
    assert values["without sway at rest, online, error"] == pytest.approx([2.0], abs=0.01)
    assert values["without sway at rest, online, inside the 95 % region"] == pytest.approx([-100.0])
    assert values["without gravity, off-line, error"] == pytest.approx([0.0], abs=1e-9)
