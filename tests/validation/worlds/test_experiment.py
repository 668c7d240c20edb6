"""Runs in random worlds are scored rightly and counted by condition."""

from dataclasses import replace

import numpy as np
import pytest

from estimators import rotation
from estimators.errors import ShapeError
from estimators.orientation import OrientationFlag, OrientationResult
from validation.worlds import conditions_of, draw, scores
from validation.worlds.conditions import ROWS, WHOLE
from validation.worlds.experiment import ORIENTATION_WORLDS

WORLD = replace(conditions_of(0), motion="hand", field="clean", grade="ideal", freeze="none", loss="none")


def given(monkeypatch, estimate):
    _, package = scores.METHODS["online"]
    monkeypatch.setitem(scores.METHODS, "online", (estimate, package))


@pytest.mark.parametrize("axes", [6, 9])
def test_a_score_is_of_the_error_and_the_stated_sigma(monkeypatch, axes):
    world = draw(2, replace(WORLD, axes=axes))
    turn = rotation.about_z(np.radians(5.0))

    def estimate(chunk):
        q = rotation.multiply(turn, world.q_earth_sensor)[None]
        sigma = np.full((1, len(q[0]), 3), np.radians(1.0))
        flags = np.full((1, len(q[0])), int(OrientationFlag.HEADING_NOT_TRUSTED), dtype=np.uint8)
        return OrientationResult(q, np.zeros_like(sigma), sigma, flags)

    given(monkeypatch, estimate)
    found = scores.scored(world, "online")
    # Without magnetometer a heading that is off all along is no error.
    assert found.error_deg == pytest.approx(5.0 if axes == 9 else 0.0, abs=1e-6)
    assert found.inside_percent == (0.0 if axes == 9 else 100.0)
    assert found.sigma_deg == pytest.approx(np.sqrt(3.0))
    assert found.untrusted_percent == (100.0 if axes == 9 else None)
    assert not found.has_failed


def test_a_run_that_ends_in_an_error_counts_as_lost(monkeypatch):
    def estimate(chunk):
        raise ShapeError("made up")

    given(monkeypatch, estimate)
    found = scores.scored(draw(2, WORLD), "online")
    assert found.has_failed
    assert (found.error_deg, found.inside_percent) == (180.0, 0.0)


def test_runs_are_counted_by_condition():
    turned_whole = next(seed for seed in range(20) if WHOLE in conditions_of(seed).rows())
    values = ORIENTATION_WORLDS.measure([0, turned_whole], {})
    count = {row: len(values[f"{row}, online, error"]) for row in ("all", *ROWS)}
    drawn = conditions_of(0)
    assert {row for row, n in count.items() if n} == {"all", WHOLE, *drawn.rows()}
    assert set(count.values()) == {0, 1}
    assert len(values["all, off-line, runs that end in an error"]) == 1
