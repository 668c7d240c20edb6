"""Plots hold what they say: peaks survive the thinning, white noise has its Allan deviation."""

from dataclasses import replace

import numpy as np
import pytest

import validation
from estimators.errors import ShapeError
from validation import Curve
from validation.plots import allan_deviation
from validation.protocol import run_protocol, thinned


def test_thinning_keeps_peaks_and_holes():
    x = np.arange(10_000.0)
    y = np.zeros(10_000)
    y[1234] = 7.0
    y[5000:6000] = np.nan
    curve = thinned("error", x, y, 100)
    assert len(curve.x) == 100
    assert curve.x[np.nanargmax(curve.y)] == 1234.0
    assert np.isnan(curve.y).sum() == 10
    assert thinned("short", x[:5], y[:5]).x.tolist() == [0, 1, 2, 3, 4]


def test_a_curve_has_as_many_x_as_y():
    with pytest.raises(ShapeError, match="error"):
        Curve("error", np.zeros(3), np.zeros(4))


def test_allan_deviation_of_white_noise_falls_with_the_square_root():
    # 1e5 samples: the relative standard error at 100 samples' averaging is about sqrt(100 / 1e5) = 3 %.
    noise = np.random.default_rng(1).normal(size=100_000) * 0.5
    tau, deviation = allan_deviation(noise, 0.01)
    short = tau <= 1.0
    np.testing.assert_allclose(deviation[short], 0.5 * np.sqrt(0.01 / tau[short]), rtol=0.1)
    assert tau[0] == pytest.approx(0.01)


def test_allan_deviation_of_a_ramp_rises_with_time():
    # values = r t: theta'' is constant, the deviation r tau / sqrt(2).
    tau, deviation = allan_deviation(0.3 * np.arange(3000) * 0.01, 0.01)
    np.testing.assert_allclose(deviation, 0.3 * tau / np.sqrt(2), rtol=1e-6)


def test_plots_are_drawn_when_wanted():
    (plain,) = validation.run(["arm_gyroscope_drift"], seeds=1)
    assert plain.plots == ()
    told = []
    (drawn,) = validation.run(["arm_gyroscope_drift"], seeds=1, plots=True, report=told.append)
    assert told == [drawn]
    (entry,) = validation.to_data([drawn])
    (plot,) = entry["plots"]
    assert plot["logarithmic"]
    assert [curve["name"] for curve in plot["curves"]] == ["x", "y", "z"]
    assert all(len(curve["x"]) == len(curve["y"]) > 10 for curve in plot["curves"])
    assert run_protocol(replace(drawn.protocol, plots=None), 1, {}, plots=True).plots == ()
