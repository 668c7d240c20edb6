"""Which directions of the field a sensor has seen, and which to turn to next."""

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from estimators.calibration.field.ellipsoid import EllipsoidFit
from estimators.recording import Float
from estimators.sentences import Sentence, say

_BINS: Final = 72
_BIN_RADIUS_RAD: Final = math.radians(17.0)
_COMPANY_RAD: Final = math.radians(50.0)


def even_directions(count: int) -> Float:
    """Return evenly spread unit vectors: a Fibonacci spiral."""
    index = np.arange(count) + 0.5
    height = 1.0 - 2.0 * index / count
    azimuth = np.pi * (1.0 + math.sqrt(5.0)) * index
    radius = np.sqrt(1.0 - height**2)
    return np.stack((radius * np.cos(azimuth), radius * np.sin(azimuth), height), axis=1)


def visited_directions(fit: EllipsoidFit, cells: Float, directions: Float) -> NDArray[np.bool_]:
    """Return which directions, shape (B, 3), have a reading, shape (N, 3), within 17 degrees, shape (B,)."""
    true = fit.correct(cells)
    unit = true / np.maximum(np.linalg.norm(true, axis=1, keepdims=True), 1e-12)
    return np.asarray((directions @ unit.T).max(axis=1) > math.cos(_BIN_RADIUS_RAD))


def next_turn(directions: Float, visited: NDArray[np.bool_], is_complete: bool) -> Sentence:
    """Name the sensor axis toward the middle of the largest unvisited region."""
    if visited.all() or (is_complete and visited.mean() > 0.85):
        return say("compass.all_visited")
    open_ = directions[~visited]
    # The unvisited direction with the most unvisited company within 50 degrees.
    company = (open_ @ open_.T > math.cos(_COMPANY_RAD)).sum(axis=1)
    middle = open_[int(np.argmax(company))]
    axis = int(np.argmax(np.abs(middle)))
    # The field points north and down (up in the south), so this axis must come to lie along it.
    name = ("+" if middle[axis] > 0 else "-") + "xyz"[axis]
    return say("compass.next_turn", axis=name)


DIRECTIONS: Final = even_directions(_BINS)
