"""Both feet in one world, where a magnetic source on one shoe tells the pose of the other."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from estimators import rotation
from estimators.errors import ShapeError
from estimators.gait._placement import Steps, steps_in_one_world
from estimators.gait._rests import Footholds
from estimators.gait.foot.trajectory import FootTrajectory
from estimators.recording import Float
from estimators.sentences import say
from estimators.signals import interpolate_rotations

_LEAST_SAMPLES = 3
_LEAST_SHARE = 0.5
"""Of the footholds of the right foot: fewer seen through the source do not relate the feet."""
_WIDEST_SIGMA_M = 0.05


@dataclass(frozen=True)
class RelativeFeet:
    """Pose of the right foot's sensor against the left foot's over K samples.

    Attributes
    ----------
    time_s : ndarray, shape (K,)
        Rising; the clock of the feet's recordings.
    position_m : ndarray, shape (K, 3)
        Of the right sensor in the axes of the left one.
    q_left_right : ndarray, shape (K, 4)
    sigma_m : ndarray, shape (K,)
        One sigma of the position, the largest of its axes.
    valid : ndarray of bool, shape (K,)
    """

    time_s: Float
    position_m: Float
    q_left_right: Float
    sigma_m: Float
    valid: NDArray[np.bool_]


@dataclass(frozen=True)
class RelatedFeet:
    """Both feet in the world of the left one.

    Attributes
    ----------
    right_m : ndarray, shape (n, 3)
        Footholds of the right foot.
    seen : ndarray of bool, shape (n,)
        Whether the source saw this foothold; the others lie where the right foot's own way puts them between those.
    heading_rad : ndarray, shape (n,)
        By which the right foot's world is turned against the left one's, at each foothold.
    right : FootTrajectory
        The right foot's whole way, in the left one's world.
    """

    right_m: Float
    seen: NDArray[np.bool_]
    heading_rad: Float
    steps: Steps
    right: FootTrajectory


def relate_feet(
    left: FootTrajectory,
    right: FootTrajectory,
    left_holds: Footholds,
    right_holds: Footholds,
    relative: RelativeFeet,
) -> RelatedFeet:
    """Put the right foot into the world of the left one, foothold by foothold.

    While the right foot stands, the left one's path and the measured pose tell where it stands; what the right foot
    has moved since its quietest moment is taken from its own path, so that heels may be up. Each foothold is a
    weighted mean over its stance. The feet's worlds, which drift apart in place and heading, need no common start.

    Parameters
    ----------
    left, right : FootTrajectory
        Each in its own world.

    Raises
    ------
    ShapeError
        When fewer than half of the right foot's footholds, or fewer than two, were seen.
    """
    use = relative.valid & (relative.sigma_m < _WIDEST_SIGMA_M)
    use &= (relative.time_s >= left.time_s[0]) & (relative.time_s <= left.time_s[-1])
    use &= (relative.time_s >= right.time_s[0]) & (relative.time_s <= right.time_s[-1])
    time_s = relative.time_s[use]
    q_left = interpolate_rotations(left.time_s, left.q_world_sensor, time_s)
    q_right = interpolate_rotations(right.time_s, right.q_world_sensor, time_s)
    place = _at(left, time_s) + rotation.rotate(q_left, relative.position_m[use])
    q_between = rotation.multiply(
        rotation.multiply(q_left, relative.q_left_right[use]), rotation.conjugate(q_right)
    )
    heading = rotation.split_heading(q_between)[0]
    right_own = _at(right, time_s)
    count = len(right_holds.start_s)
    found, turned = np.full((count, 3), np.nan), np.full(count, np.nan)
    for i in range(count):
        inside = (time_s >= right_holds.start_s[i]) & (time_s <= right_holds.stop_s[i])
        if inside.sum() < _LEAST_SAMPLES:
            continue
        weight = 1.0 / relative.sigma_m[use][inside] ** 2
        angle = np.angle(np.sum(weight * np.exp(1j * heading[inside])))
        own = right_holds.position_m[i] - right_own[inside]
        stood = place[inside] + rotation.rotate(rotation.about_z(angle), own)
        found[i], turned[i] = np.average(stood, axis=0, weights=weight), angle
    seen = np.isfinite(turned)
    if seen.sum() < max(2, _LEAST_SHARE * count):
        raise ShapeError(say("walk.source_saw_few", seen=seen.sum(), count=count))
    at_s = right_holds.quietest_s
    angles = np.interp(at_s, at_s[seen], np.unwrap(turned[seen]))
    away = found - rotation.rotate(rotation.about_z(angles), right_holds.position_m)
    shift = np.stack([np.interp(at_s, at_s[seen], away[seen, k]) for k in range(3)], axis=1)
    right_m = rotation.rotate(rotation.about_z(angles), right_holds.position_m) + shift
    right_m[seen] = found[seen]
    turn = rotation.about_z(np.interp(right.time_s, at_s, angles))
    moved = np.stack([np.interp(right.time_s, at_s, shift[:, k]) for k in range(3)], axis=1)
    return RelatedFeet(
        right_m,
        seen,
        angles,
        steps_in_one_world(left_holds.position_m, left_holds.quietest_s, right_m, at_s),
        replace(
            right,
            position_m=rotation.rotate(turn, right.position_m) + moved,
            velocity_mps=rotation.rotate(turn, right.velocity_mps),
            q_world_sensor=rotation.multiply(turn, right.q_world_sensor),
        ),
    )


def _at(path: FootTrajectory, time_s: Float) -> Float:
    return np.stack([np.interp(time_s, path.time_s, path.position_m[:, k]) for k in range(3)], axis=1)
