"""Sphere and ellipsoid through points, with the covariance of what was fitted."""

from dataclasses import dataclass

import numpy as np
import scipy

from estimators import rotation
from estimators.recording import Float

_OUTLIER = 0.03
"""Relative distance from the surface at which a point begins to count less."""
_LEAST_NOISE = 0.002
_SHAPE_SIGMA = 0.2
"""Prior of each soft-iron element: consumer boards stay within some 10 to 20 percent of a sphere."""
UNKNOWN_SHAPE_SIGMA = 0.03
"""The same where no shape is fitted: what is common, not what is possible."""
_ROWS, _COLUMNS = np.triu_indices(3)


@dataclass(frozen=True)
class EllipsoidFit:
    """Surface `|shape (point - centre)| = 1`.

    Attributes
    ----------
    centre : ndarray, shape (3,)
    shape : ndarray, shape (3, 3)
        Symmetric, positive definite; for a sphere the identity over its radius.
    residual : float
        RMS of `|shape (point - centre)| - 1`.
    covariance : ndarray, shape (9, 9)
        Of centre over the mean radius (3) and of the upper triangle of shape times the mean radius (6).
    is_full : bool
        False for a sphere, whose shape was not fitted.
    """

    centre: Float
    shape: Float
    residual: float
    covariance: Float
    is_full: bool

    def correct(self, points: Float) -> Float:
        """Return points, shape (N, 3), brought to the unit sphere."""
        return np.asarray((points - self.centre) @ self.shape.T)


def fit_sphere(points: Float, shape_sigma: float = UNKNOWN_SHAPE_SIGMA) -> EllipsoidFit:
    """Fit a sphere: linear least squares, then robustly to the distances.

    Parameters
    ----------
    points : ndarray, shape (N, 3)
        N at least 4.
    shape_sigma : float
        How far from a sphere the surface may really be, per element of its shape: what is not fitted still
        counts in the covariance ("consider" covariance).
    """
    middle = points.mean(axis=0)
    size = float(np.linalg.norm(points - middle, axis=1).mean()) or 1.0
    scaled = (points - middle) / size
    design = np.column_stack((2.0 * scaled, np.ones(len(scaled))))
    solved = np.linalg.lstsq(design, np.sum(scaled**2, axis=1), rcond=None)[0]
    radius = float(np.sqrt(max(solved[3] + solved[:3] @ solved[:3], 1e-12)))

    def distance(x: Float) -> Float:
        return np.asarray(np.linalg.norm(scaled - x[:3], axis=1) / x[3] - 1.0)

    found = scipy.optimize.least_squares(
        distance,
        np.append(solved[:3], radius),
        loss="soft_l1",
        f_scale=_OUTLIER,
        bounds=([-np.inf] * 3 + [1e-6], np.inf),
    )
    x = found.x
    residual = float(np.sqrt(np.mean(distance(x) ** 2)))
    noise = max(residual, _LEAST_NOISE)
    unit = (scaled - x[:3]) / x[3]
    by_centre = -unit / np.linalg.norm(unit, axis=1, keepdims=True)
    by_shape = _by_shape(unit)
    # The radius is fitted along; it is the mean of the three diagonal elements of the shape.
    by_all = np.column_stack((by_centre, -np.ones(len(unit))))
    back = np.linalg.pinv(by_all)
    leak = -back @ by_shape
    covariance = np.zeros((9, 9))
    covariance[:3, :3] = noise**2 * (back @ back.T)[:3, :3] + shape_sigma**2 * (leak @ leak.T)[:3, :3]
    covariance[3:, 3:] = shape_sigma**2 * np.eye(6)
    covariance[:3, 3:] = -(shape_sigma**2) * leak[:3]
    covariance[3:, :3] = covariance[:3, 3:].T
    return EllipsoidFit(middle + size * x[:3], np.eye(3) / (size * x[3]), residual, covariance, False)


def fit_ellipsoid(points: Float, start: EllipsoidFit) -> EllipsoidFit:
    """Fit an ellipsoid robustly to the distances, from a sphere.

    Parameters
    ----------
    points : ndarray, shape (N, 3)
    start : EllipsoidFit
        Of the same points.

    Notes
    -----
    Minimises sum rho(|S (m - o)| - 1), S symmetric, with a weak prior S = I, in units of the start's radius:
    directions that were not visited stay near the sphere instead of running away. A symmetric S leaves open a
    turn of all axes, which no field norm can tell; see `align_with_gravity`.
    """
    radius = 1.0 / start.shape[0, 0]
    scaled = (points - start.centre) / radius
    weight = max(min(start.residual, _OUTLIER), _LEAST_NOISE) / _SHAPE_SIGMA
    sphere = np.array([1.0, 0.0, 0.0, 1.0, 0.0, 1.0])

    def distance(x: Float) -> Float:
        return np.asarray(np.linalg.norm((scaled - x[:3]) @ _symmetric(x[3:]), axis=1) - 1.0)

    def weighed(x: Float) -> Float:
        return np.concatenate((distance(x), weight * (x[3:] - sphere)))

    found = scipy.optimize.least_squares(
        weighed, np.concatenate((np.zeros(3), sphere)), loss="soft_l1", f_scale=_OUTLIER
    )
    shape = _symmetric(found.x[3:])
    if np.linalg.eigvalsh(shape).min() <= 0.1:
        return start
    residual = float(np.sqrt(np.mean(distance(found.x) ** 2)))
    noise = max(residual, _LEAST_NOISE)
    jacobian = np.asarray(found.jac, dtype=np.float64)[: len(points)]
    information = jacobian.T @ jacobian / noise**2
    information[3:, 3:] += np.eye(6) / _SHAPE_SIGMA**2
    covariance = np.linalg.inv(information)
    return EllipsoidFit(
        start.centre + radius * found.x[:3], shape / radius, residual, np.asarray(covariance), True
    )


def mean_direction_sigma(fit: EllipsoidFit) -> float:
    """Return the RMS error of a corrected direction, per axis across it, over all directions, rad."""
    radius = float(abs(np.linalg.det(fit.shape)) ** (-1.0 / 3.0))
    shape = fit.shape * radius
    back = np.linalg.inv(shape)
    total = 0.0
    directions = np.concatenate((np.eye(3), -np.eye(3), _CORNERS))
    for unit in directions:
        # d(corrected) = dS S^-1 u - S do
        jacobian = np.zeros((3, 9))
        jacobian[:, :3] = -shape
        raw = back @ unit
        for k, (i, j) in enumerate(zip(_ROWS, _COLUMNS, strict=True)):
            jacobian[i, 3 + k] += raw[j]
            if i != j:
                jacobian[j, 3 + k] += raw[i]
        across = np.eye(3) - np.outer(unit, unit)
        total += float(np.trace(across @ jacobian @ fit.covariance @ jacobian.T @ across)) / 2.0
    return float(np.sqrt(total / len(directions)))


def align_with_gravity(field: Float, up: Float) -> Float | None:
    """Find the turn that gives the field the same dip in every attitude.

    Parameters
    ----------
    field, up : ndarray, shape (N, 3)
        Corrected field (near unit norm) and up direction in sensor axes.

    Returns
    -------
    ndarray, shape (3,), or None
        Rotation vector to be applied to the field; None if the attitudes do not tell it to a degree.

    Notes
    -----
    up . (field + turn x field) = constant, least squares, iterated with the exact rotation.
    """
    unit = field / np.linalg.norm(field, axis=1, keepdims=True)
    turn = np.zeros(3)
    for _ in range(6):
        turned = rotation.rotate(rotation.exp(turn), unit)
        design = np.column_stack((np.cross(turned, up), -np.ones(len(up))))
        target = -np.sum(up * turned, axis=1)
        keep = np.ones(len(up), dtype=np.bool_)
        for _ in range(2):
            solved = np.linalg.lstsq(design[keep], target[keep], rcond=None)[0]
            error = np.abs(target - design @ solved)
            keep = error <= 3.0 * np.median(error) + 1e-9
        step = solved[:3]
        turn = rotation.log(rotation.multiply(rotation.exp(step), rotation.exp(turn)))
        if np.linalg.norm(step) < 1e-9:
            break
    information = design[keep].T @ design[keep]
    if np.linalg.cond(information) > 1e8:
        return None
    noise = max(float(np.std(error[keep])), _LEAST_NOISE)
    sigma = noise * np.sqrt(np.diag(np.linalg.inv(information))[:3].max())
    return turn if sigma < np.radians(1.0) else None


def _by_shape(unit: Float) -> Float:
    """Return the derivative of |S u| by the six elements of S at the identity, shape (N, 6)."""
    columns = [
        unit[:, i] * unit[:, j] * (1.0 if i == j else 2.0) for i, j in zip(_ROWS, _COLUMNS, strict=True)
    ]
    return np.asarray(np.stack(columns, axis=1) / np.linalg.norm(unit, axis=1, keepdims=True))


def _symmetric(six: Float) -> Float:
    result = np.zeros((3, 3))
    result[_ROWS, _COLUMNS] = six
    result[_COLUMNS, _ROWS] = six
    return result


_CORNERS = np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)]) / np.sqrt(3.0)
