"""Iron on a device is found where it turned enough, and a wrong unit is never called iron."""

import numpy as np
import pytest

from estimators.calibration.field.device_iron import device_iron


def turned(seed: int, iron_ut: np.ndarray, cone: float = np.pi, noise_ut: float = 0.4) -> np.ndarray:
    """The earth's field in a sensor that turns into attitudes within a cone."""
    rng = np.random.default_rng(seed)
    away = rng.normal(size=(600, 3))
    direction = (
        np.array([0.4, 0.0, -0.9])
        + np.tan(min(cone, 1.5) / 2.0) * away / np.linalg.norm(away, axis=1)[:, None]
    )
    direction = away if cone >= np.pi else direction
    field = 49.0 * direction / np.linalg.norm(direction, axis=1)[:, None]
    return 1e-6 * (field + iron_ut + noise_ut * rng.normal(size=field.shape))


@pytest.mark.parametrize("seed", range(8))
def test_iron_is_found_by_turning(seed):
    iron = np.random.default_rng(100 + seed).normal(size=3) * 200.0
    found = device_iron(turned(seed, iron))
    assert found is not None
    np.testing.assert_allclose(1e6 * found, iron, atol=1.0)


@pytest.mark.parametrize("seed", range(8))
def test_what_hardly_turned_shows_none(seed):
    assert device_iron(turned(seed, np.array([150.0, -300.0, 80.0]), cone=0.1)) is None


@pytest.mark.parametrize("factor", [10.0, 0.1, 1e3])
def test_a_wrong_unit_is_no_iron(factor):
    assert device_iron(factor * turned(3, np.zeros(3))) is None


def test_nothing_shows_nothing():
    assert device_iron(np.full((100, 3), np.nan)) is None
