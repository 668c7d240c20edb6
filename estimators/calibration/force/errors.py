"""Offset and scale of an accelerometer from windows of movement, with what is left unknown."""

import math
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from estimators.calibration.force.windows import BESIDE, ERRORS, SIZE, STILL, Windows
from estimators.conventions import GRAVITY_MPS2
from estimators.recording import Float

_CALIBRATED: Final = 0.007, 0.012 * GRAVITY_MPS2
_CHEAP: Final = 0.015, 0.025 * GRAVITY_MPS2
_DELIVERED: Final = 0.03, 0.08 * GRAVITY_MPS2
"""Scale error and offset (m/s^2), one-sigma an axis: of a device that was calibrated, of the worst that may pass for
sound, and of one as some makers deliver it."""
_BESIDE_SIGMA: Final = np.array([0.02] * 3 + [0.015] * 3 + [0.006] * 12 + [0.4] * 3 + [0.012])
_GRAVITY_SIGMA_MPS2: Final = 0.04
"""Gravity differs by so much between places; cross-axis errors and noise at rest add to it."""
_FREEDOM: Final = 4.0
"""Of the prior of each window's noise: a window that fits far worse than others loses its weight."""
_TILTED: Final = 0.1
"""Variance of the direction of force from which acceleration and tilt are as good as independent: 18 degrees."""
_ROUNDS: Final = 12
_SHARED: Final = np.arange(ERRORS + BESIDE)
_OWN: Final = np.r_[ERRORS : ERRORS + 3, ERRORS + BESIDE : SIZE]
"""Of each window: by how much the gyroscope's bias differs from that of the recording, and gravity."""
_BIAS_WANDERS_RADPS: Final = 0.005


@dataclass(frozen=True)
class ForceErrors:
    """What movement says of an accelerometer: `measured = (1 + scale) true + offset` on each axis.

    Attributes
    ----------
    scale : ndarray, shape (3,)
    offset_mps2 : ndarray, shape (3,)
    covariance : ndarray, shape (6, 6)
        Of both, scale first.
    gain, gain_over_cheap : float
        Logarithm of the odds of a device as delivered against one that was calibrated, and against a cheap one.
    up : ndarray, shape (K, 3)
        Directions of gravity in the sensor that were seen.
    """

    scale: Float
    offset_mps2: Float
    covariance: Float
    gain: float
    gain_over_cheap: float
    up: Float

    @property
    def tilt_rad(self) -> float:
        """Inclination error, root mean square over the attitudes seen, that readings as they are have."""
        return math.sqrt(float(np.mean(np.sum(self._tilts() ** 2, axis=1))))

    @property
    def tilt_sigma_rad(self) -> float:
        """The same of readings that are corrected, for each of both axes."""
        model, across = _model(self.up)
        left = across @ model @ self.covariance @ model.transpose(0, 2, 1) @ across
        return math.sqrt(float(np.mean(np.trace(left, axis1=1, axis2=2))) / 2.0) / GRAVITY_MPS2

    def _tilts(self) -> Float:
        model, across = _model(self.up)
        found = np.concatenate((self.scale, self.offset_mps2))
        return np.asarray((across @ (model @ found)[..., None])[..., 0] / GRAVITY_MPS2)


def force_errors(windows: Windows, first: "ForceErrors | None" = None) -> ForceErrors | None:
    """Estimate offset and scale; None without a window.

    Parameters
    ----------
    first : ForceErrors, optional
        What the readings of these windows were corrected by; the odds stay its own.

    Notes
    -----
    The most likely errors of a device as delivered, with a noise of each window of its own (Student's t, by weights
    found again each round). The odds compare its evidence, by Laplace's approximation, with that of a better device.
    Gravity is eliminated window by window: `normal + u u' / sigma^2`, u the direction found so far, holds its size.
    The covariance is that of the weights and, beside it, the spread between windows ("sandwich": Huber 1967; White
    1980), as speeds of a body are alike for longer than was assumed.

    A hand that carries a sensor to and fro tilts it in the same rhythm, and an acceleration that follows the tilt looks
    like an offset: the more, the faster it goes and the less it tilts. Odds and covariance are discounted by that.
    """
    if not len(windows.square):
        return None
    if first is not None:
        return _again(windows, first)
    calibrated, cheap, delivered = (
        _fitted(windows, _prior(device)) for device in (_CALIBRATED, _CHEAP, _DELIVERED)
    )
    found = delivered.shared[:ERRORS]
    doubt = _doubt(windows, delivered)
    return ForceErrors(
        found[:3],
        found[3:],
        doubt * delivered.covariance[:ERRORS, :ERRORS],
        (delivered.evidence - calibrated.evidence) / doubt,
        (delivered.evidence - cheap.evidence) / doubt,
        windows.up.reshape(-1, 3),
    )


def _again(windows: Windows, first: ForceErrors) -> ForceErrors:
    """Return the errors with what is left of them in windows of corrected readings."""
    known = np.concatenate((first.scale, first.offset_mps2, np.zeros(BESIDE)))
    left = _fitted(windows, _prior(_DELIVERED), -known)
    scale = (1.0 + first.scale) * (1.0 + left.shared[:3]) - 1.0
    offset = first.offset_mps2 + (1.0 + first.scale) * left.shared[3:ERRORS]
    return replace(
        first,
        scale=scale,
        offset_mps2=offset,
        covariance=_doubt(windows, left) * left.covariance[:ERRORS, :ERRORS],
        up=windows.up.reshape(-1, 3),
    )


def _doubt(windows: Windows, found: "_Fit") -> float:
    """Return by how much less is known than independent accelerations would tell, 1 at least."""
    turning = windows.turned > STILL
    if not turning.any():
        return 1.0
    misfit = float(np.median((found.left / windows.count)[turning]))
    return max(1.0, misfit * _TILTED / float(np.median(windows.turned[turning])))


def _prior(device: tuple[float, float]) -> Float:
    scale, offset = device
    return np.concatenate(([scale] * 3, [offset] * 3, _BESIDE_SIGMA))


@dataclass(frozen=True)
class _Fit:
    shared: Float
    covariance: Float
    left: Float
    evidence: float


def _fitted(windows: Windows, prior_sigma: Float, prior: Float | None = None) -> _Fit:
    """Return the most likely unknowns, where each is `prior` within `prior_sigma`."""
    precision = np.diag(prior_sigma**-2.0)
    prior = np.zeros(len(prior_sigma)) if prior is None else prior
    normal = windows.matrices
    of_shared, to_own_right = windows.right[:, _SHARED], windows.right[:, _OWN]
    of_both = normal[:, _SHARED[:, None], _OWN]
    count, weight = windows.count, np.ones(len(windows.count))
    gravity = GRAVITY_MPS2 * windows.up[:, 0]
    held = np.zeros((len(count), len(_OWN), len(_OWN)))
    held[:, :3, :3] = np.eye(3) / _BIAS_WANDERS_RADPS**2
    held_right = np.zeros((len(count), len(_OWN)))
    for _ in range(_ROUNDS):
        up = gravity / np.linalg.norm(gravity, axis=1, keepdims=True)
        held[:, 3:, 3:] = np.einsum("wi,wj->wij", up, up) / _GRAVITY_SIGMA_MPS2**2 + 1e-9 * np.eye(3)
        held_right[:, 3:] = GRAVITY_MPS2 / _GRAVITY_SIGMA_MPS2**2 * up
        of_own = weight[:, None, None] * normal[:, _OWN[:, None], _OWN] + held
        across = weight[:, None, None] * of_both
        to_own = np.linalg.solve(of_own, across.transpose(0, 2, 1))
        alone = np.linalg.solve(of_own, (weight[:, None] * to_own_right + held_right)[..., None])[..., 0]
        each = weight[:, None, None] * normal[:, _SHARED[:, None], _SHARED] - across @ to_own
        each_right = weight[:, None] * of_shared - np.einsum("wij,wj->wi", across, alone)
        whole = each.sum(axis=0) + precision
        shared = np.linalg.solve(whole, each_right.sum(axis=0) + precision @ prior)
        own = alone - to_own @ shared
        gravity = own[:, 3:]
        x = np.zeros((len(count), SIZE))
        x[:, _SHARED] = shared
        x[:, _OWN] += own
        left = windows.square - 2.0 * (x * windows.right).sum(axis=1)
        left = np.maximum(left + np.einsum("wi,wij,wj->w", x, normal, x), 0.0)
        weight = np.minimum((_FREEDOM + count) / (_FREEDOM + left), 1.0)
    covariance = np.linalg.inv(whole)
    scores = each_right - each @ shared
    covariance = covariance + covariance @ (scores.T @ scores) @ covariance
    off = np.linalg.norm(gravity, axis=1) - GRAVITY_MPS2
    cost = (
        0.5 * np.sum(np.minimum(left, count))
        + 0.5 * np.sum((_FREEDOM + count) * np.log((_FREEDOM + np.maximum(left, count)) / (_FREEDOM + count)))
        + 0.5 * np.sum(off**2) / _GRAVITY_SIGMA_MPS2**2
        + 0.5 * np.sum(own[:, :3] ** 2) / _BIAS_WANDERS_RADPS**2
        + 0.5 * np.sum(((shared - prior) / prior_sigma) ** 2)
        + 0.5 * np.linalg.slogdet(whole)[1]
        + np.log(prior_sigma).sum()
        + 0.5 * np.sum(np.linalg.slogdet(of_own)[1])
    )
    return _Fit(shared, covariance, left, -float(cost))


def _model(up: Float) -> tuple[Float, Float]:
    """Return how errors enter the force in each attitude, shape (K, 3, 6), and what is across gravity, (K, 3, 3)."""
    scales = GRAVITY_MPS2 * up[:, :, None] * np.eye(3)
    offsets = np.broadcast_to(np.eye(3), scales.shape)
    return np.concatenate((scales, offsets), axis=2), np.eye(3) - np.einsum("ki,kj->kij", up, up)
