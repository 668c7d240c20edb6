"""One path laid on another: what is left, and what turn and scale were taken away."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from estimators.errors import ShapeError
from estimators.recording import Float

_STRAIGHT: Final = 0.01
"""Second principal spread over the first below which a path is a line."""


@dataclass(frozen=True)
class Superposition:
    """A path laid on another as well as a turn, a shift and a scale allow.

    Attributes
    ----------
    residual : float
        Root mean square distance that is left, in the unit of the paths.
    angle_rad : float
        How far it was turned; of a straight path the smallest turn that does.
    scale : float
        By what it was multiplied.
    is_straight : bool
        A turn about a straight path changes nothing: how far it was turned about itself is undefined.
    """

    residual: float
    angle_rad: float
    scale: float
    is_straight: bool


def superimpose(path: Float, onto: Float) -> Superposition:
    """Lay one path on another: the smallest ||k R X + t - Y|| over turn R, shift t and scale k.

    Parameters
    ----------
    path, onto : ndarray, shape (N, 3)
        At the same phases, without gaps.

    Raises
    ------
    ShapeError
        If the shapes differ, there are fewer than three points, gaps, or a path is a single point.

    Notes
    -----
    Gower 1975, Psychometrika 40:33; the turn after Umeyama 1991, IEEE PAMI 13:376. The residual alone would hide a
    shape made in another direction or size, so both are reported.
    """
    if path.shape != onto.shape or path.ndim != 2 or path.shape[1] != 3 or len(path) < 3:
        raise ShapeError(f"paths of shapes {path.shape} and {onto.shape}; both must be (N, 3), N at least 3")
    x, y = path - path.mean(axis=0), onto - onto.mean(axis=0)
    size_x, size_y = float(np.sum(x**2)), float(np.sum(y**2))
    if not (np.isfinite(size_x + size_y) and size_x > 0 and size_y > 0):
        raise ShapeError("a path has gaps or does not move")
    left, singular, right = np.linalg.svd(y.T @ x)
    proper = np.array([1.0, 1.0, np.sign(np.linalg.det(left @ right))])
    turn = left @ (proper[:, None] * right)
    scale = float((singular * proper).sum() / size_x)
    left_over = max(size_y - scale**2 * size_x, 0.0)
    variances = [np.linalg.eigvalsh(one.T @ one) for one in (x, y)]
    is_straight = any(bool(v[1] < _STRAIGHT**2 * v[2]) for v in variances)
    cosine = float(left[:, 0] @ right[0]) if is_straight else 0.5 * (float(np.trace(turn)) - 1.0)
    return Superposition(
        residual=float(np.sqrt(left_over / len(x))),
        angle_rad=float(np.arccos(np.clip(cosine, -1.0, 1.0))),
        scale=scale,
        is_straight=is_straight,
    )
