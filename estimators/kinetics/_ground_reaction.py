"""Ground reaction on a foot, from two load cells under the shoe and the shoe's pose."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from estimators import rotation
from estimators.kinetics._ground_kernel import reactions
from estimators.kinetics._shoe_geometry import ShoeGeometry
from estimators.kinetics._shoe_pose import ShoePose
from estimators.recording import Float

LEAST_LOAD_N = 20.0
"""Below this vertical force a centre of pressure is not computed."""
REPORT_SHARE = 0.10
"""Part of body weight above which it is reported and scored."""


@dataclass(frozen=True)
class ShoeLoads:
    """Calibrated and tared loads of the ground on heel and forefoot cell, each in its axes about its centre.

    All shape (N, 3), N and Nm.
    """

    heel_force_n: Float
    heel_moment_nm: Float
    forefoot_force_n: Float
    forefoot_moment_nm: Float

    def scaled(self, factor: float) -> "ShoeLoads":
        """Return all loads times a factor."""
        return ShoeLoads(
            factor * self.heel_force_n,
            factor * self.heel_moment_nm,
            factor * self.forefoot_force_n,
            factor * self.forefoot_moment_nm,
        )


@dataclass(frozen=True)
class GroundReaction:
    """Of the ground on one foot over N samples, room frame.

    Attributes
    ----------
    force_n, moment_nm : ndarray, shape (N, 3)
        The moment is about the room's origin.
    cop_m : ndarray, shape (N, 3)
        Centre of pressure on the floor; NaN below `LEAST_LOAD_N`.
    free_moment_nm : ndarray, shape (N,)
        About the vertical through the centre of pressure; NaN as that.
    forefoot_force_n, forefoot_moment_nm : ndarray, shape (N, 3)
        The forefoot cell's part, moment about the room's origin.
    heel_cop_m, forefoot_cop_m : ndarray, shape (N, 3)
        Of each cell's plate alone.
    forefoot_share : ndarray, shape (N,)
        Of the vertical force: the hand-over from heel (0) to forefoot (1); NaN without load.
    is_loaded : ndarray of bool, shape (N,)
    """

    force_n: Float
    moment_nm: Float
    cop_m: Float
    free_moment_nm: Float
    forefoot_force_n: Float
    forefoot_moment_nm: Float
    heel_cop_m: Float
    forefoot_cop_m: Float
    forefoot_share: Float
    is_loaded: NDArray[np.bool_]


def ground_reaction(
    loads: ShoeLoads,
    pose: ShoePose,
    *,
    floor_m: ArrayLike = 0.0,
    least_n: float = LEAST_LOAD_N,
) -> GroundReaction:
    """Bring the loads of both cells into the room and find centre of pressure and free moment.

    Parameters
    ----------
    floor_m : float or ndarray, shape (N,)
        Height of the floor. Schepers (2009) equation 2.8 takes the height of the heel sensor for it (E2):
        to repeat that, give `ShoeGeometry.sensor_height_m`.

    Notes
    -----
    Equations 2.7 and 2.8 with their errata: `M = R M_S + p x (R F_S)` with the force in room axes (E1);
    `x = (z F_x - M_y) / F_z`, `y = (M_x + z F_y) / F_z` on the floor z (E2); and the free moment
    `T = M_z - (x F_y - y F_x)` instead of the moment about the origin (E3).
    """
    samples = len(loads.heel_force_n)
    force, moment, cop = np.empty((3, 3, samples, 3))
    free, share = np.empty(samples), np.full(samples, np.nan)
    reactions(
        np.array((pose.q_room_heel, pose.q_room_forefoot), dtype=np.float64),
        np.array((pose.heel_m, pose.forefoot_m), dtype=np.float64),
        np.array((loads.heel_force_n, loads.forefoot_force_n), dtype=np.float64),
        np.array((loads.heel_moment_nm, loads.forefoot_moment_nm), dtype=np.float64),
        np.array(np.broadcast_to(floor_m, (samples,)), dtype=np.float64),
        least_n,
        force,
        moment,
        cop,
        free,
    )
    is_loaded = force[2, :, 2] > least_n
    np.divide(force[1, :, 2], force[2, :, 2], out=share, where=is_loaded)
    return GroundReaction(
        force[2], moment[2], cop[2], free, force[1], moment[1], cop[0], cop[1], share, is_loaded
    )


def pressure_point(force_n: Float, moment_nm: Float, floor_m: Float, least_n: float) -> tuple[Float, Float]:
    """Return the point of the floor about which no horizontal moment is left, and the vertical moment there.

    Parameters
    ----------
    force_n, moment_nm : ndarray, shape (..., N, 3)
        Moment about the origin of the frame.
    floor_m : ndarray, shape (N,)

    Returns
    -------
    (ndarray, shape (..., N, 3), ndarray, shape (..., N))
        NaN where the vertical force is at most `least_n`.
    """
    vertical = np.where(force_n[..., 2] > least_n, force_n[..., 2], np.nan)
    x = (floor_m * force_n[..., 0] - moment_nm[..., 1]) / vertical
    y = (moment_nm[..., 0] + floor_m * force_n[..., 1]) / vertical
    point = np.stack((x, y, np.where(np.isnan(vertical), np.nan, floor_m)), axis=-1)
    return point, moment_nm[..., 2] - (x * force_n[..., 1] - y * force_n[..., 0])


def is_inside_sole(
    point_m: Float, pose: ShoePose, geometry: ShoeGeometry, half_width_m: float = 0.05, margin_m: float = 0.01
) -> NDArray[np.bool_]:
    """Return whether points of the floor, shape (N, 3), lie under the shoe; a check of every measurement.

    True where the point is NaN. The sole is a rectangle along the heel segment, `half_width_m` to each side.
    """
    along = rotation.rotate(pose.q_room_heel, np.array([1.0, 0.0, 0.0]))[:, :2]
    along = along / np.linalg.norm(along, axis=1, keepdims=True)
    from_heel = point_m[:, :2] - pose.heel_m[:, :2]
    forward = np.sum(from_heel * along, axis=1)
    aside = along[:, 0] * from_heel[:, 1] - along[:, 1] * from_heel[:, 0]
    front = geometry.hinge_m + geometry.toe_edge_m
    with np.errstate(invalid="ignore"):
        outside = (forward < geometry.rear_edge_m - margin_m) | (forward > front + margin_m)
        return np.asarray(~(outside | (np.abs(aside) > half_width_m + margin_m)))
