"""A bench on which a source is measured: it lies still, the sensor is laid at places around it, one after another."""

from dataclasses import replace

import numpy as np
from scipy.interpolate import make_interp_spline
from scipy.spatial.transform import Rotation, RotationSpline

from estimators.magnetic import Source
from estimators.recording import Float
from estimators.simulation.coil.motion import RelativeMotion, smoothstep

_GRID_S = 0.02
LIES_S, CARRIED_S, FIRST_S = 4.0, 1.5, 6.0
"""The first place is retained longer: the filter begins there."""


def bench_places(count: int = 14) -> Float:
    """Return places around a source that lies on a table, m, shape (count, 3): on all sides, to the millimetre."""
    turn = np.arange(count) * 2.399963
    height = np.array([0.06, 0.14, 0.24])[np.arange(count) % 3]
    away = 0.2 + 0.05 * (np.arange(count) % 4)
    return np.round(np.stack([away * np.cos(turn), away * np.sin(turn), height], axis=1), 3)


def wound_by_hand(source: Source, seed: int) -> Source:
    """Return coils as they come out of a workshop: moment to 2 %, place to 2 mm an axis, direction to 1.7 degrees."""
    rng = np.random.default_rng([seed, 5])
    coils = []
    for coil in source.coils:
        turns = coil.turns * (1.0 + rng.normal(0.0, 0.02))
        centre = np.asarray(coil.centre_m) + rng.normal(0.0, 0.002, 3)
        axis = coil.unit_axis + rng.normal(0.0, 0.03 / np.sqrt(2.0), 3)
        coils.append(replace(coil, turns=turns, centre_m=tuple(centre.tolist()), axis=tuple(axis.tolist())))
    return replace(source, coils=tuple(coils))


def bench_motion(
    places_m: Float, seed: int, ruler_sigma_m: float = 0.001, lies_s: float = LIES_S
) -> tuple[RelativeMotion, float]:
    """Return the motion of a sensor that is carried from place to place, and how long it takes.

    Parameters
    ----------
    places_m : ndarray, shape (N, 3)
        As measured, in the source frame.
    seed : int
        Draws the orientations, and how far the sensor is from each place.
    ruler_sigma_m : float
        Of that distance, an axis.
    """
    rng = np.random.default_rng([seed, 89])
    count = len(places_m)
    there = places_m + rng.normal(0.0, ruler_sigma_m, places_m.shape)
    vectors = rng.normal(0.0, 0.6, (count, 3))
    duration_s = FIRST_S + count * (lies_s + CARRIED_S)
    grid = np.arange(0.0, duration_s + 0.2, _GRID_S)
    place, turned = np.tile(there[0], (len(grid), 1)), np.tile(vectors[0], (len(grid), 1))
    for n in range(1, count):
        share = smoothstep((grid - (FIRST_S + n * (lies_s + CARRIED_S) - CARRIED_S)) / CARRIED_S)[:, None]
        lifted = np.array([0.0, 0.0, 0.05]) * np.sin(np.pi * share) ** 2
        place += share * (there[n] - there[n - 1]) + lifted
        turned += share * (vectors[n] - vectors[n - 1])
    motion = RelativeMotion(
        RotationSpline(grid, Rotation.identity(len(grid))),
        make_interp_spline(grid, np.zeros((len(grid), 3)), k=5),
        RotationSpline(grid, Rotation.from_rotvec(turned)),
        make_interp_spline(grid, place, k=5),
    )
    return motion, duration_s
