"""How far an orientation is from the truth, in all and split into heading and inclination."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from estimators import rotation
from estimators.errors import ShapeError
from estimators.recording import Float


@dataclass(frozen=True)
class OrientationErrors:
    """Root-mean-square errors in radians over the scored samples.

    Attributes
    ----------
    sample_count : int
        Scored samples that had a truth.
    """

    total_rad: float
    heading_rad: float
    inclination_rad: float
    sample_count: int


def orientation_errors(
    q_estimate: Float, q_truth: Float, mask: NDArray[np.bool_] | None = None
) -> OrientationErrors:
    """Score estimates against the truth without any alignment.

    Parameters
    ----------
    q_estimate, q_truth : ndarray, shape (K, 4)
        Sensor to earth, z up. The truth may be NaN where there is none.
    mask : ndarray of bool, shape (K,), optional
        Samples to score.

    Notes
    -----
    With q_error = q_estimate * conj(q_truth) in the earth frame: total 2 acos|w|, heading
    2 atan|z/w|, inclination 2 acos sqrt(w^2 + z^2) (Laidig et al. 2021, the BROAD benchmark).
    """
    if q_estimate.shape != q_truth.shape or q_estimate.shape[-1] != 4:
        raise ShapeError(f"estimates {q_estimate.shape} and truth {q_truth.shape} must both be (K, 4)")
    scored = np.isfinite(q_truth).all(axis=-1) & np.isfinite(q_estimate).all(axis=-1)
    if mask is not None:
        scored &= mask
    if not scored.any():
        raise ShapeError("no sample to score: the truth is missing wherever the mask is set")
    error = rotation.multiply(q_estimate[scored], rotation.conjugate(q_truth[scored]))
    turned = np.hypot(error[:, 0], error[:, 3])
    tilted = np.hypot(error[:, 1], error[:, 2])
    total = 2.0 * np.arctan2(np.linalg.norm(error[:, 1:], axis=1), np.abs(error[:, 0]))
    heading = 2.0 * np.arctan2(np.abs(error[:, 3]), np.abs(error[:, 0]))
    inclination = 2.0 * np.arctan2(tilted, turned)

    def root_mean_square(angle: Float) -> float:
        return float(np.sqrt(np.mean(angle**2)))

    return OrientationErrors(
        root_mean_square(total), root_mean_square(heading), root_mean_square(inclination), int(scored.sum())
    )
