"""Identities of the fusion of markers and a module (method page on chapter 4 of Roetenberg, 4.4)."""

from dataclasses import replace

import numpy as np
import pytest

from estimators import rotation
from estimators.conventions import GRAVITY_MPS2
from estimators.optical.published import (
    OpticalChunk,
    OpticalInertialFilter,
    OpticalStart,
    filter_and_smooth,
    smooth_optical,
)
from validation.optical.scenes import MARKER_SIGMA_M, STEP_S, Scene, free_motion, measured


@pytest.fixture(scope="module")
def scene() -> Scene:
    return free_motion(7, 9.0)


def test_a_record_played_backward_gives_the_same_places() -> None:
    rng = np.random.default_rng(3)
    grid = np.arange(0.0, 12.2, 0.02)
    x = np.clip((grid - 2.0) / 1.5, 0.0, 1.0) * np.clip((10.0 - grid) / 1.5, 0.0, 1.0)
    still = (x**3 * (10 - 15 * x + 6 * x * x))[:, None]
    wave = np.sin(2 * np.pi * np.array([0.5, 0.4, 0.6]) * grid[:, None]) * 0.3 * still
    there = measured(rng, grid, wave, wave[:, [1, 2, 0]], 12.0, MARKER_SIGMA_M)
    hidden = (there.time_s >= 5.0) & (there.time_s < 6.5)
    chunk = there.without(hidden)
    back = OpticalChunk(
        0,
        STEP_S,
        np.ascontiguousarray(-chunk.gyroscope_radps[::-1]),
        np.ascontiguousarray(chunk.accelerometer_mps2[::-1]),
        np.ascontiguousarray(chunk.marker_m[::-1]),
    )
    one, other = smooth_optical(chunk), smooth_optical(back)
    both = slice(200, -200)
    apart = np.linalg.norm(one.position_m - other.position_m[::-1], axis=1)[both]
    assert apart.max() < 0.001
    np.testing.assert_allclose(one.velocity_mps[both], -other.velocity_mps[::-1][both], atol=0.02)


def test_perfect_markers_are_followed_and_worthless_ones_ignored(scene: Scene) -> None:
    seen = OpticalInertialFilter(STEP_S, {"marker_sigma_m": 1e-8, "gate": 1e18}).update(scene.chunk)
    on = slice(300, None)
    np.testing.assert_allclose(seen.position_m[on], scene.chunk.marker_m[on], atol=1e-6)
    start = OpticalStart(scene.position_m[0], np.zeros(3), rotation.identity(), np.zeros(3))
    blind = OpticalInertialFilter(STEP_S, {"marker_sigma_m": 1e9})
    alone = OpticalInertialFilter(STEP_S)
    for live in (blind, alone):
        live.begin(start)
    nothing = replace(scene.chunk, marker_m=np.full_like(scene.chunk.marker_m, np.nan))
    one, other = blind.update(scene.chunk), alone.update(nothing)
    np.testing.assert_allclose(one.position_m, other.position_m, atol=1e-9)
    np.testing.assert_allclose(one.position_sigma_m, other.position_sigma_m, rtol=1e-6)


def test_smoothing_is_never_less_certain_and_ends_with_the_filter(scene: Scene) -> None:
    live, smoothed = filter_and_smooth(scene.without((scene.time_s >= 5.0) & (scene.time_s < 7.0)))
    for name in ("position_sigma_m", "velocity_sigma_mps", "attitude_sigma_rad"):
        before, after = getattr(live, name)[160:], getattr(smoothed, name)[160:]
        assert (after <= before * (1.0 + 1e-9)).all(), name
        np.testing.assert_array_equal(after[-1], before[-1])


def test_what_a_gap_ends_with_is_the_innovation(scene: Scene) -> None:
    hidden = (scene.time_s >= 5.0) & (scene.time_s < 7.0)
    first = int(np.flatnonzero(hidden)[-1]) + 1
    longer = hidden.copy()
    longer[first] = True
    live, blind = (OpticalInertialFilter(STEP_S).update(scene.without(gap)) for gap in (hidden, longer))
    error = scene.chunk.marker_m[first] - blind.position_m[first]
    np.testing.assert_allclose(live.innovation_m[first], error, atol=1e-12)
    assert np.linalg.norm(error) > 1e-4


@pytest.mark.slow
@pytest.mark.parametrize("source", ["accelerometer", "gyroscope"])
def test_dead_reckoning_spreads_as_the_law_says(source: str) -> None:
    """Check 4.4.9: s_a sqrt(dt t^3/3), and g s_g sqrt(dt t^5/20) across the vertical; the filter tells the same."""
    count, trials, rng = 300, 400, np.random.default_rng(4)
    force, rate = (0.05, 1e-9) if source == "accelerometer" else (1e-9, 0.01)
    own = {"force_sigma_mps2": force, "rate_sigma_radps": rate, "force_walk": 0.0, "rate_walk": 0.0}
    own |= {"force_bias_sigma_mps2": 0.0, "rate_bias_sigma_radps": 0.0}
    start = OpticalStart(
        np.zeros(3), np.zeros(3), rotation.identity(), np.zeros(3), 1e-12, 1e-12, 1e-12, 1e-12
    )
    ends, told = np.empty((trials, 3)), np.empty(3)
    for k in range(trials):
        live = OpticalInertialFilter(STEP_S, own)
        live.begin(start)
        found = live.update(
            OpticalChunk(
                0,
                STEP_S,
                rng.normal(0.0, rate, (count, 3)),
                rng.normal(0.0, force, (count, 3)) + np.array([0.0, 0.0, GRAVITY_MPS2]),
                np.full((count, 3), np.nan),
            )
        )
        ends[k], told = found.position_m[-1], found.position_sigma_m[-1]
    t = count * STEP_S
    if source == "accelerometer":
        spread, law, said = ends.std(), 0.05 * np.sqrt(STEP_S * t**3 / 3.0), told
    else:
        spread, law, said = ends[:, :2].std(), GRAVITY_MPS2 * 0.01 * np.sqrt(STEP_S * t**5 / 20.0), told[:2]
    assert spread == pytest.approx(law, rel=0.10)
    np.testing.assert_allclose(said, law, rtol=0.05)
