"""Windows of ordinary movement, each summed up to what it says of an accelerometer's offset and scale."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from estimators import rotation
from estimators.calibration.plausibility.contradiction import resting_rate, slowed
from estimators.conventions import GRAVITY_MPS2
from estimators.gravity import calm_size
from estimators.recording import Float

_WINDOW_S: Final = 6.0
_LEAST_S: Final = 2.0
_BLOCK_S: Final = 0.1
_AROUND_S: Final = 0.4
"""Acceleration is seen as what force, turned back, changes within so long."""
_SPEED_S: Final = 0.15
"""Speed that goes with a spread of acceleration: of a limb that swings once a second."""
_SPEED_FLOOR_MPS: Final = 0.02
_LEVER_M: Final = 0.1
"""A forearm turns about the elbow and the shoulder: by so much the lever about a joint is none that stays."""
_ALIKE: Final = 4.0
"""Speeds of so many blocks, one after the other, say one thing."""
ERRORS: Final = 6
"""Scale of three axes, then offset of three axes."""
BESIDE: Final = 22
"""What is fitted beside them: offset (3), scale (3) and cross-axis errors (6) of the gyroscope, cross-axis errors of
the accelerometer (6), the lever about a joint (3), and the delay of the accelerometer (1)."""
SIZE: Final = ERRORS + BESIDE + 3
"""Last comes gravity in the axes that the sensor had at the beginning of the window."""
_ROWS, _COLUMNS = np.triu_indices(SIZE)
_UNDRAWN: Final = 3
_LONGEST_STEP_S: Final = 0.1
"""Below 10 Hz a sensor turns and turns back between two samples."""
_MOST_BRIDGED: Final = 0.1
"""Of the samples of a window: samples that were not measured say nothing of a device."""
_ON_LINE: Final = 1e-4, 1e-6
"""Of what changes around it and of its size: no measured sample lies nearer to the line through its neighbours."""
STILL: Final = 1e-3
"""Variance of the direction of force below which a window is a rest: two degrees."""


@dataclass(frozen=True)
class Cut:
    """Readings of W windows of one length.

    Attributes
    ----------
    rate, force : ndarray, shape (W, N, 3)
        rad/s without what the gyroscope reads at rest, and m/s^2; means of about 20 ms.
    """

    rate: NDArray[np.floating]
    force: NDArray[np.floating]
    step_s: float

    def __getitem__(self, which: NDArray[np.bool_]) -> "Cut":
        return Cut(self.rate[which], self.force[which], self.step_s)

    @property
    def turned(self) -> Float:
        """Variance of the direction of specific force in the sensor, shape (W,): none says little."""
        means = self.force.reshape(len(self.force), -1, 3)[:, :: max(1, round(0.1 / self.step_s))]
        up = means / np.maximum(np.linalg.norm(means, axis=2, keepdims=True), 1e-9)
        return np.asarray(1.0 - np.sum(up.mean(axis=1) ** 2, axis=1), dtype=np.float64)


@dataclass(frozen=True)
class Windows:
    """W windows as quadratic forms: what is left of the speed is `square - 2 x' right + x' normal x`.

    Attributes
    ----------
    normal : ndarray, shape (W, 496)
        Upper triangle of the symmetric matrix, row by row.
    right : ndarray, shape (W, 31)
    square : ndarray, shape (W,)
        All relative to what speeds may be; x holds scale errors (3), offset (m/s^2, 3), what is fitted
        `BESIDE` (rad/s, 1, 1, 1, m, s), and gravity (m/s^2, 3).
    count : ndarray, shape (W,)
        Independent numbers that `square` sums up.
    up : ndarray, shape (W, 3, 3)
        Specific force over its size at beginning, middle and end, sensor axes.
    turned : ndarray, shape (W,)
        Variance of the direction of specific force in the sensor.
    """

    normal: Float
    right: Float
    square: Float
    count: Float
    up: Float
    turned: Float

    @staticmethod
    def nothing() -> "Windows":
        """Return none."""
        nothing = np.zeros(0)
        return Windows(
            np.zeros((0, len(_ROWS))), np.zeros((0, SIZE)), nothing, nothing, np.zeros((0, 3, 3)), nothing
        )

    @property
    def matrices(self) -> Float:
        """`normal` as matrices, shape (W, 31, 31)."""
        whole = np.zeros((len(self.normal), SIZE, SIZE))
        whole[:, _ROWS, _COLUMNS] = whole[:, _COLUMNS, _ROWS] = self.normal
        return whole

    def __getitem__(self, which: NDArray[np.bool_]) -> "Windows":
        return Windows(*(getattr(self, name)[which] for name in self.__dataclass_fields__))

    def __add__(self, other: "Windows") -> "Windows":
        return Windows(
            *(np.concatenate((getattr(self, f), getattr(other, f))) for f in self.__dataclass_fields__)
        )


def cut(
    rate: Float, force: Float, time_step_s: float, is_bridged: NDArray[np.bool_] | None = None
) -> Cut | None:
    """Cut a stretch of readings.

    Parameters
    ----------
    rate, force : ndarray, shape (N, 3)
        rad/s and m/s^2, sensor axes; NaN where a sample is missing: its window is left out.
    is_bridged : ndarray of bool, shape (N,), optional
        Samples that were interpolated across a gap.

    Returns
    -------
    Cut or None
        Windows of 6 s one after the other; one of the whole stretch if that is shorter, None below 2 s. Readings of
        less than 10 Hz are never cut, nor windows of which more than a tenth was interpolated: by us, as slow files are
        filled up, or by whoever wrote them.
    """
    if time_step_s > _LONGEST_STEP_S:
        return None
    interpolated = _on_lines(np.concatenate((rate, force), axis=1))
    if is_bridged is not None:
        interpolated |= is_bridged
    rate, step_s = slowed(rate, time_step_s)
    force, _ = slowed(force, time_step_s)
    length = min(round(_WINDOW_S / step_s), len(force))
    size = calm_size(force, step_s)
    if length * step_s < _LEAST_S or not size > 0.0:
        return None
    rate = rate - resting_rate(rate, force, size, step_s)
    count = len(force) // length
    rate, force = (part[: count * length].reshape(count, length, 3) for part in (rate, force))
    whole = np.isfinite(rate).all(axis=(1, 2)) & np.isfinite(force).all(axis=(1, 2))
    used = count * length * round(step_s / time_step_s)
    whole &= interpolated[:used].reshape(count, -1).mean(axis=1) <= _MOST_BRIDGED
    return Cut(rate, force, step_s)[np.asarray(whole)] if whole.any() else None


def _on_lines(values: Float) -> NDArray[np.bool_]:
    """Return which samples, shape (N, C), lie on the line through their neighbours in all that they hold, shape (N,).

    A sensor that lies so still that nothing changes is none of them.
    """
    found = np.zeros(len(values), dtype=np.bool_)
    across = np.abs(values[2:] - values[:-2])
    apart = np.abs(values[1:-1] - 0.5 * (values[:-2] + values[2:]))
    near = apart <= _ON_LINE[0] * across + _ON_LINE[1] * (1.0 + np.abs(values[1:-1]))
    found[1:-1] = near.all(axis=1) & (across > 0.0).any(axis=1)
    return found


def summed(windows: Cut) -> Windows:
    """Sum up windows.

    Notes
    -----
    With R the attitude since the beginning of the window, s the scale error and c the offset of the accelerometer,
    `measured = (1 + s) f + c`, the speed of the body is

        v(t) = v(0) + integral R measured dt - integral R diag(f) dt s - integral R dt c - g t.

    It stays bounded, and is small where force, turned back, does not change. Errors of the gyroscope, bias d and
    scale k, turn R by `Phi = -integral R (d + diag(rate) k) dt` and so add `integral [Phi] R f dt`; a limb of length r
    moves its sensor by `R (rate x r)`; an accelerometer that is late by T, as one read at the end of a step, adds
    `integral (R rate) x g dt T`. In all terms but the first f is gravity, turned as the mean of R measured: with
    the body's own acceleration in them a smaller scale would leave less. So all is linear in what is unknown. v(0) is
    eliminated here, gravity later: its direction is free, its size is known.
    """
    step_s = windows.step_s
    width = max(1, round(_BLOCK_S / step_s))
    blocks = windows.rate.shape[1] // width
    rate, force = (
        np.asarray(part[:, : blocks * width], dtype=np.float64) for part in (windows.rate, windows.force)
    )
    attitude = rotation.running_product(rotation.exp(step_s * rate))
    # A sample is the mean over a step: it is turned by the attitude in the middle of it.
    middle = rotation.to_matrix(rotation.multiply(attitude, rotation.exp(-0.5 * step_s * rate)))
    turned = np.einsum("wnij,wnj->wni", middle, force)
    gravity = turned.mean(axis=1)
    gravity *= GRAVITY_MPS2 / np.maximum(np.linalg.norm(gravity, axis=1, keepdims=True), 1e-9)
    design = _design(rate, middle, turned, gravity, width, step_s)
    speed = _SPEED_S**2 * _changes(turned, step_s) + _LEVER_M**2 * (rate**2).sum(axis=2)
    variance = _SPEED_FLOOR_MPS**2 + _blocks(speed, width)
    weight = 1.0 / (_ALIKE * variance)
    # Of the speed at the beginning nothing is known.
    design = design - np.einsum("wb,wbij->wij", weight / weight.sum(axis=1, keepdims=True), design)[:, None]
    flat = (np.sqrt(weight)[..., None, None] * design).reshape(len(rate), -1, SIZE + 1)
    sums = flat.transpose(0, 2, 1) @ flat
    at = [0, blocks * width // 2, blocks * width - 1]
    up = force[:, at] / np.maximum(np.linalg.norm(force[:, at], axis=2, keepdims=True), 1e-9)
    return Windows(
        sums[:, _ROWS, _COLUMNS],
        sums[:, :SIZE, SIZE],
        sums[:, SIZE, SIZE],
        np.full(len(rate), 3.0 * blocks / _ALIKE - _UNDRAWN),
        up,
        windows.turned,
    )


def _design(rate: Float, middle: Float, turned: Float, gravity: Float, width: int, step_s: float) -> Float:
    """Return what one unit of each unknown adds to the speed at each block, and last less what was measured."""
    pull = np.einsum("wnji,wj->wni", middle, gravity)
    scales, crossings, gains, attitudes, levers, turning, forces = (
        _blocks(part, width)
        for part in (
            middle * pull[:, :, None],
            _crossing(middle, pull),
            np.concatenate((middle * rate[:, :, None], _crossing(middle, rate)), axis=3),
            middle,
            middle @ _cross(rate),
            np.einsum("wnij,wnj->wni", middle, rate)[..., None],
            turned[..., None],
        )
    )
    step_s = width * step_s
    crossed = _cross(gravity)[:, None]
    of_bias = _integral(attitudes, step_s)
    times = step_s * (np.arange(scales.shape[1]) + 0.5)
    return np.concatenate(
        (
            -_integral(scales, step_s),
            -of_bias,
            _integral(crossed @ of_bias, step_s),
            _integral(crossed @ _integral(gains, step_s), step_s),
            -_integral(crossings, step_s),
            levers,
            _integral(crossed @ turning, step_s),
            -np.broadcast_to(times[None, :, None, None] * np.eye(3), attitudes.shape),
            -_integral(forces, step_s),
        ),
        axis=3,
    )


def _crossing(attitude: Float, vector: Float) -> Float:
    """Return what each axis that reads a share of another adds, turned back, shape (W, N, 3, 6)."""
    first, second = np.array([0, 0, 1, 1, 2, 2]), np.array([1, 2, 0, 2, 0, 1])
    return np.asarray(attitude[..., first] * vector[:, :, None, second])


def _integral(values: Float, step_s: float) -> Float:
    """Return the running integral along the second axis, at the middle of each step."""
    return np.asarray(step_s * (np.cumsum(values, axis=1) - 0.5 * values))


def _blocks(values: Float, width: int) -> Float:
    return np.asarray(values.reshape(len(values), -1, width, *values.shape[2:]).mean(axis=2))


def _cross(vector: Float) -> Float:
    """Return [vector]x, shape (..., 3, 3)."""
    crossed = np.zeros((*vector.shape, 3))
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        crossed[..., j, i], crossed[..., k, i] = vector[..., k], -vector[..., j]
    return crossed


def _changes(turned: Float, step_s: float) -> Float:
    """Return the variance of specific force around each sample, shape (W, N)."""
    reach = max(1, round(0.5 * _AROUND_S / step_s))
    number = turned.shape[1]
    at = np.arange(number)
    first, stop = np.maximum(at - reach, 0), np.minimum(at + reach + 1, number)
    centred = turned - turned.mean(axis=1, keepdims=True)
    sums = [
        np.concatenate((np.zeros((len(turned), 1, 3)), np.cumsum(power, axis=1)), axis=1)
        for power in (centred, centred**2)
    ]
    mean, square = ((total[:, stop] - total[:, first]) / (stop - first)[:, None] for total in sums)
    return np.asarray(np.maximum(square - mean**2, 0.0).sum(axis=2))
