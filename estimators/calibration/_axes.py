"""Do gyroscope, accelerometer and magnetometer agree on axes, sign and unit? Told by how they turn together."""

import math
from dataclasses import dataclass
from itertools import permutations, product
from typing import Final

import numpy as np
from numpy.typing import NDArray

from estimators import rotation
from estimators.recording import Float

_BLOCK_S: Final = 0.6
_LONGEST_S: Final = 10.0
_FEWEST_BLOCKS: Final = 3
_MOVED: Final = 0.03
_FIT: Final = 0.06
_BETTER: Final = 0.3
_DISTINCT: Final = 0.6
_SAME: Final = 1.6
_SILENT_RADPS: Final = 0.05

SIGNED_PERMUTATIONS: Final = np.stack(
    [
        np.eye(3)[list(order)] * np.array(signs)[:, None]
        for order in permutations(range(3))
        for signs in product((1.0, -1.0), repeat=3)
    ]
)
"""All 48 ways to name and sign three axes, shape (48, 3, 3); the identity is the first."""
SCALES: Final = (1.0, math.pi / 180.0, 180.0 / math.pi, 0.0)
"""The unit is right; degrees a second were given; it was converted twice; the gyroscope says nothing."""


@dataclass(frozen=True)
class Agreement:
    """How a direction (gravity or field) turns against the gyroscope.

    Attributes
    ----------
    mapping : ndarray, shape (3, 3), or None
        Signed permutation that takes the gyroscope's axes to those of the direction: the identity where they
        agree. None while the movement does not tell.
    scale : float
        One of `SCALES`; NaN while the movement does not tell.
    unexplained : float
        Variance of the direction, relative, that is left when it is turned back by the gyroscope.
    moved : float
        The same when it is not turned back: how much the sensor turned across the direction.
    """

    mapping: Float | None
    scale: float
    unexplained: float
    moved: float

    @property
    def is_identity(self) -> bool:
        """Whether axes, signs and unit agree."""
        return self.mapping is not None and self.scale == 1.0 and bool((self.mapping == np.eye(3)).all())


def agreement(rate: Float, direction: Float, time_step_s: float) -> Agreement:
    """Compare how a fixed direction moves in the sensor with the gyroscope.

    Parameters
    ----------
    rate : ndarray, shape (N, 3)
        Gyroscope with the bias taken out, taken for rad/s. The first ten seconds count.
    direction : ndarray, shape (N, 3)
        Specific force or magnetic field, in any unit.
    time_step_s : float

    Returns
    -------
    Agreement

    Notes
    -----
    Turned back into one frame by the right gyroscope a fixed direction stands still, and specific force
    averaged over 0.6 s is nearly gravity whatever the arm does. For each of the 48 signed permutations and four
    scales of the gyroscope the variance of these averages is taken. Another reading than the plain one is
    named only if it leaves less than a third and no other comes near. A reversed direction (u to -u) changes
    nothing here: it is told by the dip of the field.
    """
    ticks = min(len(rate), round(_LONGEST_S / time_step_s))
    rate, direction = rate[:ticks], direction[:ticks]
    width = max(1, round(_BLOCK_S / time_step_s))
    blocks = ticks // width
    unknown = Agreement(None, float("nan"), float("nan"), 0.0)
    finite: NDArray[np.bool_] = np.asarray(np.isfinite(direction).all(axis=1))
    if blocks < _FEWEST_BLOCKS or finite.mean() < 0.8:
        return unknown
    size = float(np.median(np.linalg.norm(direction[finite], axis=1)))
    if size == 0.0:
        return unknown
    mappings = SIGNED_PERMUTATIONS
    used = blocks * width
    held = np.where(finite[:used, None], direction[:used], 0.0).reshape(blocks, width, 3)
    counts = finite[:used].reshape(blocks, width).sum(axis=1).astype(np.float64)
    still = held.sum(axis=1)
    turning = np.nan_to_num(rate[:used]) * time_step_s
    sums = np.empty((blocks, len(SCALES[:3]) * len(mappings), 3))
    for number, scale in enumerate(SCALES[:3]):
        group = slice(number * len(mappings), (number + 1) * len(mappings))
        sums[:, group] = _turned_back(scale * turning, held)
    seen = counts > 0.5 * width
    if seen.sum() < _FEWEST_BLOCKS:
        return unknown
    left = _variance(sums[seen] / counts[seen, None, None]) / size**2
    moved = float(_variance(still[seen] / counts[seen, None])) / size**2
    if moved < _MOVED:
        return Agreement(None, float("nan"), float(left[0]), moved)
    best = int(np.argmin(left))
    silent = float(np.abs(np.nan_to_num(rate)).max()) < _SILENT_RADPS
    if silent and min(left[0], left[best]) > _BETTER * moved:
        return Agreement(mappings[0], 0.0, moved, moved)
    if left[0] < _SAME * left[best] or left[0] < 0.01:
        return Agreement(mappings[0], 1.0, float(left[0]), moved)
    if left[0] > _BETTER**-1 * left[best] and left[best] < _FIT and left[best] < _BETTER * moved:
        rivals = np.delete(left, best)
        if left[best] < _DISTINCT * rivals.min():
            scale = SCALES[best // len(mappings)]
            return Agreement(mappings[best % len(mappings)], scale, float(left[best]), moved)
        if _is_one_scale(left, best, len(mappings)):
            # About one axis several mappings do equally well, but all in the same unit.
            unit = best // len(mappings)
            if left[unit * len(mappings)] < _SAME * left[best]:
                return Agreement(mappings[0], SCALES[unit], float(left[best]), moved)
    return Agreement(None, float("nan"), float(left[0]), moved)


def _turned_back(turning: Float, held: Float) -> Float:
    """Sum a direction over blocks after turning it back by every mapping of the gyroscope, up to that mapping.

    Parameters
    ----------
    turning : ndarray, shape (N, 3)
        Rotation vector of each sample.
    held : ndarray, shape (B, W, 3)
        The direction, N = B W samples.

    Returns
    -------
    ndarray, shape (B, 48, 3)

    Notes
    -----
    A proper mapping M turns the attitude R of the plain gyroscope into M R M', an improper one does the same with
    the reversed gyroscope and -M. So two attitudes do for all; the outer M does not change a variance.
    """
    blocks, width, _ = held.shape
    outer = np.empty((2, blocks, 3, 3, 3))
    for reversed_, sign in enumerate((1.0, -1.0)):
        matrices = rotation.to_matrix(_running_product(rotation.exp(sign * turning)))
        matrices = matrices.reshape(blocks, width, 9)
        outer[reversed_] = (matrices.transpose(0, 2, 1) @ held).reshape(blocks, 3, 3, 3)
    proper = np.linalg.det(SIGNED_PERMUTATIONS) > 0.0
    sums = np.empty((blocks, len(SIGNED_PERMUTATIONS), 3))
    sums[:, proper] = np.einsum("kabc,mcb->kma", outer[0], SIGNED_PERMUTATIONS[proper])
    sums[:, ~proper] = np.einsum("kabc,mcb->kma", outer[1], -SIGNED_PERMUTATIONS[~proper])
    return sums


def _running_product(increments: Float) -> Float:
    """Return the product of the increments up to each, shape (N, 4), by doubling stretches."""
    product = increments.copy()
    reach = 1
    while reach < len(product):
        product[reach:] = rotation.multiply(product[:-reach], product[reach:])
        reach *= 2
    return product


def _variance(blocks: Float) -> Float:
    """Return the variance over the first axis, summed over the last."""
    return np.asarray(np.sum(np.var(blocks, axis=0), axis=-1))


def _is_one_scale(left: Float, best: int, count: int) -> bool:
    group = best // count
    others = np.delete(left.reshape(-1, count), group, axis=0)
    return bool(left[best] < _DISTINCT * others.min())


__all__ = ["SCALES", "SIGNED_PERMUTATIONS", "Agreement", "agreement"]
