"""Two shoes in one room: their common heading and distance, and the ground reaction of both together."""

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from estimators import rotation
from estimators.conventions import GRAVITY_MPS2, SIDES, Side
from estimators.errors import SetupError, ShapeError
from estimators.kinetics import GroundReaction, ShoeKinetics, ShoePose, ground_reaction, stretches
from estimators.recording import Float
from estimators.sentences import say

Weights = Literal["vertical", "published"]
FOOTHOLD_SD_M = 0.02
DRIFT_SD_PER_M = 6e-4
"""Scatter of footholds sideways; heading that is lost a metre, rad: 0.02 deg/s at a slow pace."""
_LEAST_WAY_M = 0.3
LEAST_TOTAL_N = 100.0
"""Below this vertical force of both feet the pressure centre is bridged; walking never comes so low."""


@dataclass(frozen=True)
class BothFeet:
    """Both feet over N samples, room frame: x where the feet went, y left, z up from the floor.

    Attributes
    ----------
    force_n : ndarray, shape (N, 3)
        Of the ground on the person.
    cop_m : ndarray, shape (N, 3)
        Of both feet, weighted by their vertical forces; bridged where nobody stands.
    is_standing : ndarray of bool, shape (N,)
        Both feet loaded for long, with the ends of that left out.
    path_m, course_rad : ndarray, shape (N, 2) and (N,), or None
        On a course that turns: the path that both feet share, and where it goes. None where it is the x axis.
    """

    rate_hz: float
    pose: dict[Side, ShoePose]
    reaction: dict[Side, GroundReaction]
    force_n: Float
    cop_m: Float
    is_standing: NDArray[np.bool_]
    path_m: Float | None = None
    course_rad: Float | None = None

    def aside(self, points_m: Float) -> Float:
        """Return how far left of the path points are, shape (N, 2 or 3) to (N,)."""
        if self.path_m is None or self.course_rad is None:
            return np.asarray(points_m[:, 1])
        away = points_m[:, :2] - self.path_m
        return np.asarray(away[:, 1] * np.cos(self.course_rad) - away[:, 0] * np.sin(self.course_rad))

    def ahead(self, vectors: Float) -> Float:
        """Return the parts of vectors along the path, shape (N, 3) to (N,)."""
        if self.course_rad is None:
            return np.asarray(vectors[:, 0])
        return np.asarray(vectors[:, 0] * np.cos(self.course_rad) + vectors[:, 1] * np.sin(self.course_rad))


def combine_feet(
    left: ShoeKinetics,
    right: ShoeKinetics,
    start_width_m: float,
    *,
    end_width_m: float | None = None,
    weights: Weights = "vertical",
) -> BothFeet:
    """Bring two shoes into one room.

    Parameters
    ----------
    left, right : ShoeKinetics
        Same samples.
    start_width_m : float
        Distance of the heels at the start: both feet against a floor mould, level with each other.
    end_width_m : float, optional
        The same at the end, when known and the feet are level again: the drift between the feet is then
        taken out, half of it from each and in proportion to the way walked.
    weights : {"vertical", "published"}
        See `total_reaction`.

    Raises
    ------
    SetupError
        If the shoes do not belong to one recording.

    Notes
    -----
    Schepers (2009) section 4.2.1: each foot is turned so that its net displacement points forward, which
    takes a straight course. A foot that did not move keeps the heading it started with. The heading of a
    gyroscope also drifts on the way, which bows a straight course: the bow that the footholds show, weighed
    against their own scatter, is taken out. It matters from about fifteen metres on.
    """
    if left.pose.heel_m.shape != right.pose.heel_m.shape or left.rate_hz != right.rate_hz:
        raise SetupError("left and right shoe have different samples; bring them to one time base")
    poses: dict[Side, ShoePose] = {}
    for side in SIDES:
        shoe, sign = (left, 0.5) if side == "left" else (right, -0.5)
        rests = shoe.contact.core.mean(axis=1).astype(np.int64)
        poses[side] = _forward(_straightened(shoe.pose, rests), np.array([0.0, sign * start_width_m, 0.0]))
    if end_width_m is not None:
        apart = poses["left"].heel_m[-1] - poses["right"].heel_m[-1] - [0.0, end_width_m, 0.0]
        poses["left"] = _drawn(poses["left"], -0.5 * apart[:2])
        poses["right"] = _drawn(poses["right"], 0.5 * apart[:2])
    reactions: dict[Side, GroundReaction] = {
        "left": ground_reaction(left.loads, poses["left"]),
        "right": ground_reaction(right.loads, poses["right"]),
    }
    touching = {"left": left.contact.any, "right": right.contact.any}
    force, cop = total_reaction(reactions, weights=weights)
    return BothFeet(
        left.rate_hz,
        poses,
        reactions,
        force,
        cop,
        standing(touching["left"] & touching["right"], left.rate_hz),
    )


def total_reaction(
    reactions: dict[Side, GroundReaction], *, weights: Weights = "vertical", least_n: float = LEAST_TOTAL_N
) -> tuple[Float, Float]:
    """Return force and pressure centre of both feet, each shape (N, 3).

    Parameters
    ----------
    reactions : dict of Side to GroundReaction
        A foot without load counts as zero.
    weights : {"vertical", "published"}
        By the vertical forces, which add up to one; or by the sizes of the forces as equation 4.4 has it,
        which do not while the feet push against each other (E1), so that the result depends on the origin.
    least_n : float
        Below this the pressure centre is interpolated.

    Raises
    ------
    ShapeError
        If nobody ever stood on the shoes.
    """
    force = {
        side: np.where(reactions[side].is_loaded[:, None], reactions[side].force_n, 0.0) for side in SIDES
    }
    total = force["left"] + force["right"]
    size = {
        side: force[side][:, 2] if weights == "vertical" else np.linalg.norm(force[side], axis=1)
        for side in SIDES
    }
    all_of_it = total[:, 2] if weights == "vertical" else np.linalg.norm(total, axis=1)
    carried = total[:, 2] > least_n
    if not carried.any():
        raise ShapeError(say("shoes.never_loaded"))
    with np.errstate(invalid="ignore", divide="ignore"):
        parts = [
            np.where(reactions[side].is_loaded, size[side] / all_of_it, 0.0)[:, None]
            * np.where(reactions[side].is_loaded[:, None], reactions[side].cop_m, 0.0)
            for side in SIDES
        ]
    cop = parts[0] + parts[1]
    if not carried.all():
        at = np.arange(total.shape[0])
        for axis in range(3):
            cop[~carried, axis] = np.interp(at[~carried], at[carried], cop[carried, axis])
    return total, cop


def standing(
    both_loaded: NDArray[np.bool_], rate_hz: float, least_s: float = 1.5, guard_s: float = 0.7
) -> NDArray[np.bool_]:
    """Return where somebody stands: both feet loaded for `least_s`, `guard_s` off at each inner end.

    Double support in walking is far shorter, and shifting weight to and from a step takes about the guard.
    """
    result = np.zeros(both_loaded.size, dtype=np.bool_)
    guard = round(guard_s * rate_hz)
    for start, end in stretches(both_loaded):
        if end - start >= least_s * rate_hz:
            first = start if start == 0 else start + guard
            last = end if end == both_loaded.size else end - guard
            result[first:last] = True
    return result


def body_mass(force_n: Float, is_standing: NDArray[np.bool_]) -> float:
    """Return the mass that the shoes feel while standing, in kg.

    Nominal weight must not be used: one per cent of gain would put the vertical 10 mm off.

    Raises
    ------
    ShapeError
        Without standing; give mean force over whole strides divided by g instead.
    """
    if not is_standing.any():
        raise ShapeError(say("shoes.never_still"))
    return float(force_n[is_standing, 2].mean() / GRAVITY_MPS2)


def _forward(pose: ShoePose, start_m: Float) -> ShoePose:
    """Turn a pose so that it goes forward, and put its first heel position over `start_m`."""
    way = pose.heel_m[-1] - pose.heel_m[0]
    heading = float(np.arctan2(way[1], way[0])) if np.hypot(way[0], way[1]) > _LEAST_WAY_M else 0.0
    turned = pose.moved(-heading, np.zeros(3))
    shift = start_m - turned.heel_m[0]
    shift[2] = 0.0
    return turned.moved(0.0, shift)


def _straightened(pose: ShoePose, rests: NDArray[np.int64]) -> ShoePose:
    """Take out the curvature of the heading's drift from a straight course.

    `y = kappa / 2 s (s - L)` over the way s is fitted to the footholds; the footholds' scatter and what a
    gyroscope drifts, as a curvature, say how far the fit is believed.
    """
    way = pose.heel_m[rests[-1]] - pose.heel_m[rests[0]]
    length = float(np.hypot(way[0], way[1]))
    if length < _LEAST_WAY_M or rests.size < 4:
        return pose
    heading = float(np.arctan2(way[1], way[0]))
    points = pose.moved(-heading, np.zeros(3)).heel_m
    steps = points[rests] - points[rests[0]]
    bow = 0.5 * steps[:, 0] * (steps[:, 0] - length)
    curvature = float(bow @ steps[:, 1]) / (float(bow @ bow) + (FOOTHOLD_SD_M / DRIFT_SD_PER_M) ** 2)
    along = np.clip(points[:, 0] - points[rests[0], 0], 0.0, length)
    turn = rotation.about_z(-curvature * (along - 0.5 * length))
    moved = np.zeros_like(pose.heel_m)
    moved[1:] = np.diff(pose.heel_m, axis=0)
    heel = pose.heel_m[0] + np.cumsum(rotation.rotate(turn, moved), axis=0)
    ahead = rotation.rotate(turn, pose.forefoot_m - pose.heel_m)
    return ShoePose(
        rotation.multiply(turn, pose.q_room_heel),
        rotation.multiply(turn, pose.q_room_forefoot),
        rotation.rotate(turn, pose.heel_rate_radps),
        rotation.rotate(turn, pose.forefoot_rate_radps),
        heel,
        heel + ahead,
        rotation.rotate(turn, pose.velocity_mps),
        rotation.rotate(turn, pose.specific_force_mps2),
        pose.is_known,
    )


def _drawn(pose: ShoePose, shift_m: Float) -> ShoePose:
    """Move a pose by `shift_m`, shape (2,), in proportion to the way that it has gone."""
    way = np.linalg.norm(np.diff(pose.heel_m[:, :2], axis=0, prepend=pose.heel_m[:1, :2]), axis=1)
    part = np.cumsum(way) / max(float(way.sum()), 1e-9)
    drift = np.column_stack((part[:, None] * shift_m, np.zeros(part.size)))
    return replace(pose, heel_m=pose.heel_m + drift, forefoot_m=pose.forefoot_m + drift)
