"""Where the centre of mass is going, and how far that is from the edge of the feet on the ground."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from estimators import rotation
from estimators.conventions import GRAVITY_MPS2, SIDES, Side
from estimators.errors import SetupError, ShapeError
from estimators.kinetics import ShoeGeometry, ShoePose
from estimators.recording import Float

SOLE_HALF_WIDTH_M = 0.045


def extrapolated_mass_centre(position_m: Float, velocity_mps: Float, floor_m: Float | float = 0.0) -> Float:
    """Return the extrapolated centre of mass, shape (N, 3), with z on the floor.

    Parameters
    ----------
    position_m, velocity_mps : ndarray, shape (N, 3)
    floor_m : float or ndarray, shape (N,)

    Raises
    ------
    ShapeError
        If the centre of mass is not above the floor.

    Notes
    -----
    `x + v / w_0` with `w_0 = sqrt(g / l)` and the height l of the centre of mass: Hof, Gazendam and Sinke
    (2005). An inverted pendulum that puts its pressure centre there comes to rest above it.
    """
    height = position_m[:, 2] - floor_m
    if not (height > 0.0).all():
        raise ShapeError("the centre of mass is not above the floor; give its absolute height")
    result = position_m + velocity_mps * np.sqrt(height / GRAVITY_MPS2)[:, None]
    result[:, 2] = floor_m
    return result


def sole_outline(geometry: ShoeGeometry, half_width_m: float = SOLE_HALF_WIDTH_M) -> tuple[Float, Float]:
    """Return the corners of the sole below heel and forefoot, each shape (4, 3), in heel and forefoot frame."""
    bottom = -geometry.sensor_height_m
    sides = (half_width_m, -half_width_m)
    heel = np.array([(x, y, bottom) for x in (geometry.rear_edge_m, geometry.hinge_m) for y in sides])
    forefoot = np.array([(x, y, bottom) for x in (0.0, geometry.toe_edge_m) for y in sides])
    return heel, forefoot


def sole_corners(
    pose: ShoePose,
    geometry: ShoeGeometry,
    heel_touches: NDArray[np.bool_],
    forefoot_touches: NDArray[np.bool_],
    half_width_m: float = SOLE_HALF_WIDTH_M,
) -> Float:
    """Return the corners of a sole on the floor, shape (N, 8, 2); NaN for parts that do not touch."""
    heel, forefoot = sole_outline(geometry, half_width_m)
    hinge = pose.heel_m + rotation.rotate(pose.q_room_heel, geometry.hinge_point_m)
    parts = []
    for origin, q, corners, touches in (
        (pose.heel_m, pose.q_room_heel, heel, heel_touches),
        (hinge, pose.q_room_forefoot, forefoot, forefoot_touches),
    ):
        points = origin[:, None] + rotation.rotate(q[:, None], corners[None])
        parts.append(np.where(touches[:, None, None], points[..., :2], np.nan))
    return np.concatenate(parts, axis=1)


def base_of_support(corners_m: Sequence[Float]) -> Float:
    """Return the convex hull of all points on the floor, shape (M, 2), counter-clockwise from the one of least x.

    Parameters
    ----------
    corners_m : sequence of ndarray, each shape (J, 2)
        NaN for points that do not touch.

    Returns
    -------
    ndarray, shape (M, 2)
        Empty when fewer than three points touch or all lie on a line.
    """
    points = np.concatenate([np.asarray(part).reshape(-1, 2) for part in corners_m])
    points = points[np.isfinite(points).all(axis=1)]
    if len(points) < 3:
        return np.empty((0, 2))
    try:
        hull = scipy.spatial.ConvexHull(points)
    except scipy.spatial.QhullError:
        return np.empty((0, 2))
    corners = points[hull.vertices]
    # Where the list begins is left open by the library, and differs between processors.
    return np.asarray(np.roll(corners, -int(np.argmin(corners[:, 0])), axis=0))


def margin_to_edge(point_m: Float, polygon_m: Float) -> float:
    """Return how far inside a convex polygon a point lies, metres; negative outside, NaN without a polygon.

    Parameters
    ----------
    point_m : ndarray, shape (2,)
    polygon_m : ndarray, shape (M, 2)
        Counter-clockwise.
    """
    if len(polygon_m) < 3:
        return float("nan")
    edge = np.roll(polygon_m, -1, axis=0) - polygon_m
    away = point_m - polygon_m
    inward = (edge[:, 0] * away[:, 1] - edge[:, 1] * away[:, 0]) / np.linalg.norm(edge, axis=1)
    if (inward >= 0.0).all():
        return float(inward.min())
    part = np.clip(np.sum(away * edge, axis=1) / np.sum(edge**2, axis=1), 0.0, 1.0)
    return -float(np.linalg.norm(away - part[:, None] * edge, axis=1).min())


@dataclass(frozen=True)
class StabilityMargin:
    """Balance over N samples.

    Attributes
    ----------
    extrapolated_m : ndarray, shape (N, 3)
        Extrapolated centre of mass, on the floor.
    margin_m : ndarray, shape (N,)
        To the nearest edge of the base of support, positive inside; NaN in the air.
    polygons : list of ndarray, each shape (M, 2)
        The base of support of each sample.
    """

    extrapolated_m: Float
    margin_m: Float
    polygons: list[Float]


def stability_margin(
    position_m: Float, velocity_mps: Float, corners_m: dict[Side, Float], floor_m: Float | float = 0.0
) -> StabilityMargin:
    """Return the margin of stability over the base of support of both feet.

    Parameters
    ----------
    position_m, velocity_mps : ndarray, shape (N, 3)
        Of the centre of mass.
    corners_m : dict of Side to ndarray, shape (N, J, 2)
        From `sole_corners`.
    floor_m : float or ndarray, shape (N,)

    Raises
    ------
    SetupError
        If a foot is missing or the samples differ.

    Notes
    -----
    Hof, Gazendam and Sinke (2005): shortest distance from the extrapolated centre of mass to the boundary.
    """
    if set(corners_m) != set(SIDES) or any(len(part) != len(position_m) for part in corners_m.values()):
        raise SetupError("the margin needs the soles of both feet at every sample of the centre of mass")
    going = extrapolated_mass_centre(position_m, velocity_mps, floor_m)
    polygons = [
        base_of_support((left, right))
        for left, right in zip(corners_m["left"], corners_m["right"], strict=True)
    ]
    margins = [margin_to_edge(point[:2], polygon) for point, polygon in zip(going, polygons, strict=True)]
    return StabilityMargin(going, np.array(margins), polygons)


def sideways_margin(
    extrapolated_m: Float, corners_m: Float, side: Side, heading_rad: Float | float = 0.0
) -> Float:
    """Return the margin to the outer edge of one foot, shape (N,), positive inside; NaN while it is in the air.

    Parameters
    ----------
    extrapolated_m : ndarray, shape (N, 3)
    corners_m : ndarray, shape (N, J, 2)
        Of that foot, from `sole_corners`.
    heading_rad : float or ndarray, shape (N,)
        Where the person walks.
    """
    heading = np.broadcast_to(np.asarray(heading_rad, dtype=np.float64), extrapolated_m.shape[:1])
    outward = np.column_stack((-np.sin(heading), np.cos(heading))) * (1.0 if side == "left" else -1.0)
    reach = np.einsum("njk,nk->nj", corners_m, outward)
    edge = np.max(np.where(np.isnan(reach), -np.inf, reach), axis=1)
    margin = edge - np.sum(extrapolated_m[:, :2] * outward, axis=1)
    return np.where(np.isfinite(edge), margin, np.nan)
