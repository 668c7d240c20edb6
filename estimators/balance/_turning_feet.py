"""Two shoes in one room on a course that turns."""

from dataclasses import replace

import numpy as np

from estimators import rotation
from estimators.balance._both_feet import BothFeet, standing, total_reaction
from estimators.conventions import Side
from estimators.errors import SetupError
from estimators.gait import CommonCourse, average_path, relate_by_course
from estimators.kinetics import GroundReaction, ShoeKinetics, ShoePose, ground_reaction
from estimators.recording import Float


def combine_turning_feet(
    left: ShoeKinetics,
    right: ShoeKinetics,
    start_width_m: float,
    *,
    end_width_m: float | None = None,
    width_sigma_m: float = 0.01,
) -> tuple[BothFeet, CommonCourse]:
    """Bring two shoes into one room where the person walks any course.

    Parameters
    ----------
    left, right : ShoeKinetics
        Same samples.
    start_width_m : float
        Distance of the heels at the start, level with each other.
    end_width_m : float, optional
        The same at the end.
    width_sigma_m : float
        How well the distance at the start is known.

    Returns
    -------
    feet : BothFeet
        Room with x along the first strides; `path_m` and `course_rad` say where the path goes.
    course : CommonCourse

    Raises
    ------
    SetupError, ShapeError
        If the shoes do not belong to one recording, or there are too few steps to relate them.

    Notes
    -----
    A straight course tells where forward is for each foot (`combine_feet`); on a turning one the path that both feet
    share does, see `relate_by_course`.
    """
    if left.pose.heel_m.shape != right.pose.heel_m.shape or left.rate_hz != right.rate_hz:
        raise SetupError("left and right shoe have different samples; bring them to one time base")
    rate_hz = left.rate_hz
    rests: dict[Side, np.ndarray[tuple[int, ...], np.dtype[np.int64]]] = {
        "left": left.contact.core.mean(axis=1).astype(np.int64),
        "right": right.contact.core.mean(axis=1).astype(np.int64),
    }
    holds = {"left": left.pose.heel_m[rests["left"]], "right": right.pose.heel_m[rests["right"]]}
    course = relate_by_course(
        holds["left"],
        rests["left"] / rate_hz,
        holds["right"],
        rests["right"] / rate_hz,
        start_width_m,
        end_apart_m=end_width_m,
        apart_sigma_m=width_sigma_m,
    )
    # At the start the right foot is beside the left one: across the first course.
    beside = course.right_m[0] - holds["left"][0, :2]
    forward = float(np.arctan2(beside[0], -beside[1]))
    samples = len(left.pose.heel_m)
    turn = course.turn_at(np.arange(samples) / rate_hz) - forward
    poses: dict[Side, ShoePose] = {
        "left": _from(left.pose.moved(-forward, np.zeros(3)), 0.5 * start_width_m),
        "right": _from(_turned(right.pose, turn), -0.5 * start_width_m),
    }
    reactions: dict[Side, GroundReaction] = {
        "left": ground_reaction(left.loads, poses["left"]),
        "right": ground_reaction(right.loads, poses["right"]),
    }
    force, cop = total_reaction(reactions)
    path, heading = average_path(
        poses["left"].heel_m[rests["left"]],
        rests["left"] / rate_hz,
        poses["right"].heel_m[rests["right"]],
        rests["right"] / rate_hz,
        np.arange(samples) / rate_hz,
    )
    both = standing(left.contact.any & right.contact.any, rate_hz)
    return BothFeet(rate_hz, poses, reactions, force, cop, both, path, heading), course


def _from(pose: ShoePose, aside_m: float) -> ShoePose:
    """Put the first heel position over the y axis, so far aside."""
    shift = np.array([0.0, aside_m, 0.0]) - pose.heel_m[0]
    shift[2] = 0.0
    return pose.moved(0.0, shift)


def _turned(pose: ShoePose, turn_rad: Float) -> ShoePose:
    """Turn every movement of a pose by the angle of its moment, shape (N,)."""
    turn = rotation.about_z(turn_rad)
    moved = np.zeros_like(pose.heel_m)
    moved[1:] = np.diff(pose.heel_m, axis=0)
    heel = pose.heel_m[0] + np.cumsum(rotation.rotate(turn, moved), axis=0)
    return replace(
        pose,
        q_room_heel=rotation.multiply(turn, pose.q_room_heel),
        q_room_forefoot=rotation.multiply(turn, pose.q_room_forefoot),
        heel_rate_radps=rotation.rotate(turn, pose.heel_rate_radps),
        forefoot_rate_radps=rotation.rotate(turn, pose.forefoot_rate_radps),
        heel_m=heel,
        forefoot_m=heel + rotation.rotate(turn, pose.forefoot_m - pose.heel_m),
        velocity_mps=rotation.rotate(turn, pose.velocity_mps),
        specific_force_mps2=rotation.rotate(turn, pose.specific_force_mps2),
    )
