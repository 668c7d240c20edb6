"""Residual of gravity and field turned back by a gyroscope, for each way it may have been mistaken."""

from collections.abc import Callable
from typing import Final, NamedTuple

import numpy as np

from estimators import rotation
from estimators.calibration.plausibility.mistakes import IS_PROPER, SCALES, SIGNED_PERMUTATIONS
from estimators.conventions import GRAVITY_MPS2
from estimators.recording import Float

_BLOCK_S: Final = 0.1
_SHAKEN_S: Final = 0.06
"""Specific force says how fast a sensor may be going by its size within this time before and after."""
_SPEED_S: Final = 0.35
_SPEED_FLOOR_S: Final = 0.02
"""Speed over gravity's acceleration that is expected for each multiple of gravity by which specific force differs from
it, and where it does not: a foot on the ground stands, one that swings runs at several metres a second."""
_FIELD_FLOOR: Final = 1e-3
"""Of the variance of the field's direction: two degrees."""
_IRON_WEIGHT: Final = 0.02
"""A hard iron as large as the field costs this share of the field's square."""
_OFFSETS: Final = np.array([0.05] * 3 + [0.05] * 3)
"""Usual offsets of a gyroscope, rad/s, and of an accelerometer, in multiples of gravity: who exchanges axes turns the
offsets as well, and they may fit better there by chance."""
_LEVER_M: Final = 0.4
"""A sensor on a limb is so far from the joint it swings about: that says how fast it goes whenever the limb turns."""
_ROUNDS: Final = 3

Left = Callable[[Float, Float], Float]
"""Takes attitudes, shape (W, N, 3, 3), and mappings, shape (M, 3, 3); returns the cost of each, shape (M,)."""
Fitted = Callable[[Float, Float, float], Float]
"""The same of a gyroscope multiplied with a scale, with fitted offsets; returns the cost and their price, (2, M)."""


def of_force(rate: Float, force: Float, step_s: float) -> tuple[Float, float]:
    """Return the sums of `Evidence` for windows of specific force in units of gravity, shape (W, N, 3)."""
    left, fitted_left, unturned = _left_of_force(rate, force, step_s)
    return _over_readings(rate, step_s, left, fitted_left), unturned


def of_force_at(rate: Float, force: Float, step_s: float) -> Float:
    """Return the same sum and price for readings as they are, shape (2,)."""
    return _as_it_is(rate, step_s, _left_of_force(rate, force, step_s)[1])


def of_field(rate: Float, field: Float, step_s: float) -> tuple[Float, float]:
    """Return the sums of `Evidence` for windows of a field of about unit size, shape (W, N, 3)."""
    left, fitted_left, unturned = _left_of_field(field, step_s)
    return _over_readings(rate, step_s, left, fitted_left), unturned


def of_field_at(rate: Float, field: Float, step_s: float) -> Float:
    """Return the same sum and price for readings as they are, shape (2,)."""
    return _as_it_is(rate, step_s, _left_of_field(field, step_s)[1])


def _left_of_force(rate: Float, force: Float, step_s: float) -> tuple[Left, Fitted, float]:
    """Return what is left as it is and with fitted offsets, and for a gyroscope that says nothing."""
    windows = len(force)
    width = max(1, round(_BLOCK_S / step_s))
    blocks = force.shape[1] // width
    used = blocks * width
    shaken = _smoothed((np.linalg.norm(force, axis=2) - 1.0) ** 2, max(1, round(_SHAKEN_S / step_s)))
    shaken = shaken[:, :used].reshape(windows, blocks, width).mean(axis=2)
    weight = 1.0 / (_SPEED_FLOOR_S**2 + _SPEED_S**2 * shaken)
    floor = blocks / weight.sum(axis=1)
    pieces = force[:, :used].reshape(windows, blocks, width, 3) * step_s
    # Of the speeds, what no straight line explains, each by its weight.
    line = np.stack((np.ones(blocks), np.arange(blocks) - 0.5 * (blocks - 1)), axis=1)
    normal = np.linalg.inv(np.einsum("bi,wb,bj->wij", line, weight, line))
    fitted = np.einsum("bi,wij,cj,wc->wbc", line, normal, line, weight, optimize=True)
    rest = np.sqrt(weight / weight.sum(axis=1, keepdims=True))[:, :, None] * (np.eye(blocks) - fitted)
    levelled = rest
    # Speed at the middle of each block.
    rest = levelled @ (np.tri(blocks) - 0.5 * np.eye(blocks))

    def turned_back(attitude: Float, mappings: Float) -> Float:
        matrices = attitude[:, :used].reshape(windows, blocks, width, 9).transpose(0, 1, 3, 2)
        outer = (matrices @ pieces).reshape(windows, blocks, 3, 3, 3)
        return np.asarray(np.einsum("wbijk,mkj->wbmi", outer, mappings, optimize=True))

    def remaining(back: Float) -> Float:
        return np.asarray((rest @ back.reshape(windows, blocks, -1)).reshape(back.shape))

    def cost(left: Float) -> Float:
        return np.asarray(np.log1p(left / floor[:, None]).sum(axis=0))

    def left(attitude: Float, mappings: Float) -> Float:
        return cost((remaining(turned_back(attitude, mappings)) ** 2).sum(axis=(1, 3)))

    def fitted_left(attitude: Float, mappings: Float, scale: float) -> Float:
        back = turned_back(attitude, mappings)
        means, drift = _blocks(attitude, width, step_s)
        offsets = np.broadcast_to(width * step_s * means[:, :, None], (*back.shape, 3))
        design = remaining(np.concatenate((_drifts(back, drift), offsets), axis=4))
        speeds = (levelled @ _swings(scale * rate, attitude, width).reshape(windows, blocks, -1)).reshape(
            windows, blocks, 1, 3, 3
        )
        design = np.concatenate((design, np.broadcast_to(speeds, (*back.shape, 3))), axis=4)
        sums = _Sums.of(remaining(back), design)
        return sums.cost(floor[:, None], np.concatenate((_OFFSETS, [_LEVER_M] * 3)))

    still = pieces.sum(axis=2)[:, :, None]
    unturned = float(cost((remaining(still) ** 2).sum(axis=(1, 3)))[0])
    return left, fitted_left, unturned


def _left_of_field(field: Float, step_s: float) -> tuple[Left, Fitted, float]:
    """Return the same of a field."""
    windows = len(field)
    width = max(1, round(_BLOCK_S / step_s))
    blocks = field.shape[1] // width
    used = blocks * width
    pieces = field[:, :used].reshape(windows, blocks, width, 3) / width

    def fitted_left(attitude: Float, mappings: Float, scale: float) -> Float:
        matrices = attitude[:, :used].reshape(windows, blocks, width, 9).transpose(0, 1, 3, 2)
        outer = (matrices @ pieces).reshape(windows, blocks, 3, 3, 3)
        back = np.einsum("wbijk,mkj->wbmi", outer, mappings, optimize=True)
        means, drift = _blocks(attitude, width, step_s)
        iron = np.broadcast_to(means[:, :, None], (*back.shape, 3))
        design = np.concatenate((_drifts(back, drift), iron), axis=4)
        # What does not change is the field itself.
        design, back = (
            (part - part.mean(axis=1, keepdims=True)) / np.sqrt(blocks) for part in (design, back)
        )
        # Iron may be another one in each window: it comes and goes in the room as well.
        sums = _Sums.of(back, design).without(_IRON_WEIGHT)
        return sums.cost(np.full((1, 1), _FIELD_FLOOR), _OFFSETS[:3])

    mean, square = field.mean(axis=1), (field**2).sum(axis=2).mean(axis=1)
    unturned = float(np.log1p((square - (mean**2).sum(axis=1)) / _FIELD_FLOOR).sum())

    def left(attitude: Float, mappings: Float) -> Float:
        middle = attitude.mean(axis=1)
        flat = attitude.reshape(*attitude.shape[:2], 9).transpose(0, 2, 1)
        outer = (flat @ field).reshape(-1, 3, 3, 3) / field.shape[1]
        # Iron and field that leave the least: the means of the field in the sensor and of the field turned back.
        means = np.concatenate(
            (
                np.einsum("mkj,wk->wmj", mappings, mean),
                np.einsum("wijk,mkj->wmi", outer, mappings, optimize=True),
            ),
            axis=2,
        )
        normal = np.tile(np.diag([1.0 + _IRON_WEIGHT] * 3 + [1.0 + 1e-9] * 3), (len(mean), 1, 1))
        normal[:, 3:, :3], normal[:, :3, 3:] = middle, middle.transpose(0, 2, 1)
        explained = np.einsum("wmi,wij,wmj->wm", means, np.linalg.inv(normal), means, optimize=True)
        return np.asarray(np.log1p(np.maximum(square[:, None] - explained, 0.0) / _FIELD_FLOOR).sum(axis=0))

    return left, fitted_left, unturned


def _as_it_is(rate: Float, step_s: float, fitted_left: Fitted) -> Float:
    attitude = rotation.to_matrix(rotation.running_product(rotation.exp(step_s * rate)))
    return fitted_left(attitude, np.eye(3)[np.newaxis], 1.0)[:, 0]


def _over_readings(rate: Float, step_s: float, left: Left, fitted_left: Fitted) -> Float:
    """Return what is left for each scale and mapping of the gyroscope, and the price of offsets, shape (2, 11, 48).

    Notes
    -----
    A proper mapping M turns the attitude R of the plain gyroscope into M R M', an improper one does the same with
    the reversed gyroscope and -M. So two attitudes a scale do for all; the outer M does not change a variance.
    Offsets are fitted where one mistake alone is asked for: axes in the right unit, a unit of the right axes.
    """
    found = np.zeros((2, len(SCALES), len(SIGNED_PERMUTATIONS)))
    for number, scale in enumerate(SCALES):
        for sign, where in ((1.0, IS_PROPER), (-1.0, ~IS_PROPER)):
            attitude = rotation.to_matrix(
                rotation.running_product(rotation.exp(sign * scale * step_s * rate))
            )
            mappings = sign * SIGNED_PERMUTATIONS[where]
            if number == 0:
                found[:, number, where] = fitted_left(attitude, mappings, scale)
                continue
            found[0, number, where] = left(attitude, mappings)
            if sign > 0.0:
                found[:, number, 0] = fitted_left(attitude, mappings[:1], scale)[:, 0]
    return found


def _blocks(attitude: Float, width: int, step_s: float) -> tuple[Float, Float]:
    """Return for blocks of so many samples the mean attitude, and its integral up to the middle, (W, B, 3, 3) each."""
    blocks = attitude.shape[1] // width
    means = attitude[:, : blocks * width].reshape(len(attitude), blocks, width, 3, 3).mean(axis=2)
    return means, width * step_s * (np.cumsum(means, axis=1) - 0.5 * means)


def _swings(rate: Float, attitude: Float, width: int) -> Float:
    """Return the speed over gravity's acceleration that a metre of lever along each axis gives, shape (W, B, 3, 3)."""
    crossed = np.zeros((*rate.shape, 3))
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        crossed[..., j, i], crossed[..., k, i] = rate[..., k], -rate[..., j]
    speeds = (attitude @ crossed) / GRAVITY_MPS2
    windows, samples = rate.shape[:2]
    blocks = samples // width
    return np.asarray(speeds[:, : blocks * width].reshape(windows, blocks, width, 3, 3).mean(axis=2))


def _drifts(back: Float, drift: Float) -> Float:
    """Return how what was turned back changes with an offset of each axis of the gyroscope, shape (W, B, M, 3, 3)."""
    x, y, z = (back[..., axis, None] for axis in range(3))
    along_x, along_y, along_z = (drift[:, :, None, axis] for axis in range(3))
    return np.stack((y * along_z - z * along_y, z * along_x - x * along_z, x * along_y - y * along_x), axis=3)


class _Sums(NamedTuple):
    """Squares of what is left in each window, as a quadratic form of offsets: (W, M), (W, M, P) and (W, M, P, P)."""

    square: Float
    right: Float
    normal: Float

    @staticmethod
    def of(values: Float, design: Float) -> "_Sums":
        """Sum up values, shape (W, B, M, 3), and what a unit of each offset adds to them, shape (W, B, M, 3, P)."""
        windows, _, mappings, _, offsets = design.shape
        flat = design.transpose(0, 2, 1, 3, 4).reshape(windows, mappings, -1, offsets)
        each = values.transpose(0, 2, 1, 3).reshape(windows, mappings, -1)
        across = flat.swapaxes(2, 3)
        return _Sums((each**2).sum(axis=2), -(across @ each[..., None])[..., 0], across @ flat)

    def without(self, weight: float) -> "_Sums":
        """Fit the last three offsets in each window by themselves, at a price of so much for each unit squared."""
        first, last = slice(None, -3), slice(-3, None)
        inverse = np.linalg.inv(self.normal[..., last, last] + weight * np.eye(3))
        beside = self.normal[..., first, last] @ inverse
        return _Sums(
            self.square
            - np.einsum("wmi,wmij,wmj->wm", self.right[..., last], inverse, self.right[..., last]),
            self.right[..., first] - (beside @ self.right[..., last, None])[..., 0],
            self.normal[..., first, first] - beside @ self.normal[..., last, first],
        )

    def cost(self, floor: Float, usual: Float) -> Float:
        """Return the logarithm of what is left with the likeliest offsets, summed over windows, and their price.

        Shape (2, M). The price is how unlikely such offsets are, `usual` being their one-sigma.
        """
        price = np.diag(usual**-2.0)
        offsets = np.zeros((self.square.shape[1], len(usual)))
        left = np.maximum(self.square, 0.0)
        for _ in range(_ROUNDS):
            weight = 1.0 / (left + floor)
            normal = np.einsum("wm,wmij->mij", weight, self.normal) + price
            right = np.einsum("wm,wmi->mi", weight, self.right)
            offsets = np.linalg.solve(normal, right[..., None])[..., 0]
            shared = np.einsum("wmij,mj->wmi", self.normal, offsets) - 2.0 * self.right
            left = np.maximum(self.square + np.einsum("wmi,mi->wm", shared, offsets), 0.0)
        return np.stack((np.log1p(left / floor).sum(axis=0), ((offsets / usual) ** 2).sum(axis=1)))


def _smoothed(values: Float, reach: int) -> Float:
    """Return the running mean along the second axis over `reach` before and after."""
    total = np.concatenate((np.zeros((len(values), 1)), np.cumsum(values, axis=1)), axis=1)
    at = np.arange(values.shape[1])
    first, stop = np.maximum(at - reach, 0), np.minimum(at + reach + 1, values.shape[1])
    return np.asarray((total[:, stop] - total[:, first]) / (stop - first))
