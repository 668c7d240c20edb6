"""How far gravity and field contradict a gyroscope, for every way its axes and its unit may have been mistaken."""

from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from estimators.calibration.plausibility.leftover import of_field, of_force
from estimators.calibration.plausibility.mistakes import SCALES, SIGNED_PERMUTATIONS
from estimators.calibration.plausibility.pace import Moved, at_pace, pace_of
from estimators.gravity import calm_size
from estimators.recording import Float

WINDOW_S: Final = 6.0
"""Long enough to turn, short enough for the drift of a gyroscope to be nothing."""
HOP: Final = 1.0 / 3.0
"""Of a window, from its beginning to that of the next."""
_RATE_HZ: Final = 50.0
"""Samples are averaged down to about this: a hand turns by less than a tenth of a turn meanwhile."""
_TURNED: Final = 0.02
"""Variance of a direction in the sensor, relative to its square, from which it has turned: by eight degrees."""
_TURNING_S: Final = 0.4
_CALM: Final = 0.05
"""Variance of the size of a direction, relative, from which it spoils what the direction says."""
_REST_SPREAD: Final = 0.02
_MOST_OFFSET: Final = 0.05
_MOST_WINDOWS: Final = 24
_UNITS, _AXES = len(SCALES), len(SIGNED_PERMUTATIONS)


@dataclass(frozen=True)
class Evidence:
    """What windows of a recording say together; sums, so that those of several stretches may be added.

    Attributes
    ----------
    force, field : ndarray, shape (11, 48)
        Sum over windows of the logarithm of what is left when gravity, or the field, is turned back by the gyroscope,
        for each of `SCALES` times each of `SIGNED_PERMUTATIONS` of it: the negative logarithm of a likelihood whose
        noise is different in each window and nowhere known. In single precision: a live session hands them to another
        process and back with each look.
    unturned : ndarray, shape (2,)
        The same for a gyroscope that says nothing, of force and of field.
    windows, stretches : ndarray of int, shape (2,)
        In how many windows the force, and the field, turned in the sensor, and in how many stretches.
    prices : ndarray, shape (2, 59)
        Sums over stretches of how unlikely the offsets are that were fitted: to force, and to field; of each of
        `SCALES`, and of each mapping in the right unit.
    paced : ndarray, shape (2, 2, 2)
        The same as in `force` and `field` for a gyroscope that turns `pace` times as far: because samples are that
        much longer apart, and because its unit or range is another one; of force and of field each; what is left, and
        the price of offsets.
    pace : float
        1 while the readings fit as they are, or no pace makes them fit.
    """

    force: NDArray[np.float32]
    field: NDArray[np.float32]
    unturned: Float
    windows: NDArray[np.int64]
    stretches: NDArray[np.int64]
    prices: NDArray[np.float32]
    paced: Float
    pace: float = 1.0

    @staticmethod
    def nothing() -> "Evidence":
        """Return what is known before anything was seen."""
        nothing, none = np.zeros((_UNITS, _AXES), np.float32), np.zeros(2, np.int64)
        prices = np.zeros((2, _UNITS + _AXES), np.float32)
        return Evidence(nothing, nothing, np.zeros(2), none, none, prices, np.zeros((2, 2, 2)))

    def __add__(self, other: "Evidence") -> "Evidence":
        return Evidence(
            self.force + other.force,
            self.field + other.field,
            self.unturned + other.unturned,
            self.windows + other.windows,
            self.stretches + other.stretches,
            self.prices + other.prices,
            self.paced + other.paced,
            self.pace if other.pace == 1.0 else other.pace,
        )

    def costs(self) -> tuple[Float, Float]:
        """Return what force, and field, leave with what the offsets cost, shape (11, 48) each.

        A device has one offset, which is fitted in each stretch again: it is paid once, not as often as it was seen.
        """
        prices = self.prices / np.maximum(self.stretches, 1)[:, None]
        found = np.stack((self.force, self.field)).astype(np.float64)
        found[:, 1:, 0] += prices[:, 1:_UNITS]
        found[:, 0] += prices[:, _UNITS:]
        return found[0], found[1]

    def paced_costs(self) -> Float:
        """Return the same at `pace`: of the clock and of the gyroscope, by force and field, shape (2, 2)."""
        return np.asarray(self.paced[..., 0] + self.paced[..., 1] / np.maximum(self.stretches, 1))


def gather(rate: Float, force: Float, field: Float | None, time_step_s: float, pace: float = 1.0) -> Evidence:
    """Weigh every reading of a gyroscope by how gravity and field turn in the sensor.

    Parameters
    ----------
    rate : ndarray, shape (N, 3)
        Gyroscope, taken for rad/s; NaN where a sample is missing, here and below.
    force : ndarray, shape (N, 3)
        Specific force, in any unit.
    field : ndarray, shape (N, 3), or None
        Magnetic field, in any unit.
    pace : float
        Found in what came before.

    Returns
    -------
    Evidence
        Of the windows in which force, or field, turned most: the gyroscope does not choose, as one that reads a
        hundredth of the truth seems at rest.

    Notes
    -----
    The velocity of a body stays bounded: specific force that is turned into one frame by the right gyroscope and
    summed up is a straight line, gravity its slope, but for the body's own speed. That is small wherever specific
    force has the size of gravity for a while, so these moments count most. The field turned back stands still; a hard
    iron that moves with the sensor is estimated with it, so that a magnet on the sensor is no contradiction.
    """
    rate, step_s = slowed(rate, time_step_s)
    force, _ = slowed(force, time_step_s)
    size = calm_size(force, step_s)
    found = Evidence.nothing()
    if not size > 0.0:
        return found
    rate = rate - resting_rate(rate, force, size, step_s)
    length = round(WINDOW_S / step_s)
    known = np.asarray(np.isfinite(rate).all(axis=1))
    starts = turning(force, known, size, length, step_s)
    still = Moved(np.empty((0, length, 3)), np.empty((0, length, 3)))
    of_gravity = of_earth = still
    if len(starts):
        chosen = starts[:, None] + np.arange(length)
        of_gravity = Moved(rate[chosen], force[chosen] / size)
        found += _of_one(*of_force(*of_gravity, step_s), len(starts), is_force=True)
    if field is not None:
        field, _ = slowed(field, time_step_s)
        strength = float(np.nanmedian(np.linalg.norm(field, axis=1))) if np.isfinite(field).any() else 0.0
        starts = turning(field, known, strength, length, step_s) if strength > 0.0 else starts[:0]
        if len(starts):
            chosen = starts[:, None] + np.arange(length)
            of_earth = Moved(rate[chosen], field[chosen] / strength)
            found += _of_one(*of_field(*of_earth, step_s), len(starts), is_force=False)
    as_they_are = _as_they_are(found)
    if pace == 1.0:
        pace = pace_of(of_gravity, of_earth, step_s, as_they_are.sum(axis=1))
    paced = at_pace(of_gravity, of_earth, step_s, pace) if pace != 1.0 else np.stack([as_they_are] * 2)
    return replace(found, paced=paced, pace=pace)


def _of_one(left: Float, unturned: float, windows: int, *, is_force: bool) -> Evidence:
    """Return what one stretch says by force or by field alone."""
    which, nothing = np.array([is_force, not is_force], dtype=np.int64), Evidence.nothing()
    sums = left[0].astype(np.float32)
    prices = np.concatenate((left[1, :, 0], left[1, 0])).astype(np.float32)
    return replace(
        nothing,
        force=sums if is_force else nothing.force,
        field=nothing.field if is_force else sums,
        unturned=np.where(which, unturned, 0.0),
        windows=windows * which,
        stretches=which,
        prices=which[:, None].astype(np.float32) * prices,
    )


def _as_they_are(found: Evidence) -> Float:
    """Return what one stretch leaves of force and field as it is, and the price of offsets, shape (2, 2)."""
    left = np.array([found.force[0, 0], found.field[0, 0]], dtype=np.float64)
    return np.stack((left, found.prices[:, _UNITS]), axis=1)


def slowed(values: Float, time_step_s: float) -> tuple[Float, float]:
    """Return means of consecutive samples, shape (M, 3), some fifty a second, and the time between them."""
    width = slowed_by(time_step_s)
    used = len(values) // width * width
    return np.asarray(values[:used].reshape(-1, width, 3).mean(axis=1)), width * time_step_s


def slowed_by(time_step_s: float) -> int:
    """Return how many samples make one mean; one where they are means already."""
    return max(1, round(1.0 / (_RATE_HZ * time_step_s)))


def turning(
    direction: Float, known: NDArray[np.bool_], calm: float, length: int, step_s: float
) -> NDArray[np.int64]:
    """Return where the windows of so many samples begin in which a direction, of usual size `calm`, says most.

    That is: in which it turned much in the sensor and little was added to it, and of which the turn is `known`, shape
    (N,): a gyroscope that misses samples would seem to stand still there.
    """
    width = max(1, round(_TURNING_S / step_s))
    parts = length // width
    found = []
    is_whole = known & np.isfinite(direction).all(axis=1)
    for start in range(0, len(direction) - length + 1, round(HOP * length)):
        means = direction[start : start + parts * width].reshape(parts, width, 3).mean(axis=1)
        size = np.linalg.norm(means, axis=1, keepdims=True)
        whole = bool(is_whole[start : start + length].all()) and bool((size > 0.0).all())
        turned = 1.0 - float(np.sum(np.mean(means / size, axis=0) ** 2)) if whole else 0.0
        if turned > _TURNED:
            sizes = np.linalg.norm(direction[start : start + length], axis=1)
            found.append((-turned / (_CALM + float(np.mean((sizes / calm - 1.0) ** 2))), start))
    return np.array([start for _, start in sorted(found)[:_MOST_WINDOWS]], dtype=np.int64)


def resting_rate(rate: Float, force: Float, size: float, step_s: float) -> Float:
    """Return what the gyroscope reads while the force stands still, unless that is a turn about the vertical."""
    width = max(1, round(1.0 / step_s))
    parts = len(force) // width
    pieces = force[: parts * width].reshape(parts, width, 3)
    still = pieces.std(axis=1).max(axis=1, initial=0.0) < _REST_SPREAD * size
    sound = rate[np.isfinite(rate).all(axis=1)]
    means = rate[: parts * width].reshape(parts, width, 3).mean(axis=1)
    still &= np.isfinite(means).all(axis=1)
    if not still.any():
        return np.zeros(3)
    offset = np.median(means[still], axis=0)
    fastest = float(np.percentile(np.linalg.norm(sound, axis=1), 99.0))
    return np.asarray(offset if np.linalg.norm(offset) < _MOST_OFFSET * fastest else np.zeros(3))
