"""Where a foot rested between strides: what is no walking is not made one."""

from typing import Final

import numpy as np

from estimators import rotation
from estimators.gait._stance import runs
from estimators.gait.foot.trajectory import FootFlag, FootTrajectory

SHORTEST_SWING_S: Final = 0.15
MOVED_M: Final = 0.05
_LIFTED_M, _TURNED_RAD = 0.03, 0.26
_QUIET, _RESTLESS = 0.3, 3.0
_WALKING_CONTRAST, _RUNNING_CONTRAST, _RUNNING_MPS = 10.0, 4.0, 2.5


def find_rests(trajectory: FootTrajectory) -> list[tuple[int, int]]:
    """Join stretches of stance between which the foot did not go anywhere, and leave out what is no walking.

    Parameters
    ----------
    trajectory : FootTrajectory

    Returns
    -------
    list of (int, int)
        Half-open stretches of samples.

    Notes
    -----
    Own. A leg that swings from a chair, or a foot on a pedal, is least restless at the ends of its way without ever
    standing. The strides of the recordings that are known (walking, stairs, a patient's) have a stance statistic T at
    least 15 times that of the rests beside them; a runner's rests have T above 3, and at least 4 times that in a
    swing of more than 2.5 m/s. Where T is below 0.3 the foot stands, whatever it does before and after.
    """
    known = trajectory.stance.is_stance & ((trajectory.flags & FootFlag.NO_STANCE) == 0)
    joined: list[tuple[int, int]] = []
    for start, stop in runs(np.asarray(known)):
        if joined and not _went(trajectory, joined[-1], (start, stop)):
            joined[-1] = (joined[-1][0], stop)
        else:
            joined.append((start, stop))
    return _as_in_walking(trajectory, joined)


def _as_in_walking(trajectory: FootTrajectory, rests: list[tuple[int, int]]) -> list[tuple[int, int]]:
    """Leave out rests on neither side of which the foot swings as in walking or running."""
    statistic, speed = trajectory.stance.statistic, np.linalg.norm(trajectory.velocity_mps, axis=1)
    edges = [0, *(stop for _, stop in rests)], [*(start for start, _ in rests), len(statistic)]
    swings = [
        (float(statistic[a:b].max()), float(speed[a:b].max())) if b > a else (0.0, 0.0)
        for a, b in zip(*edges, strict=True)
    ]
    retained = []
    for k, (start, stop) in enumerate(rests):
        least = float(statistic[start:stop].min())
        for most, fastest in (swings[k], swings[k + 1]):
            if least < _QUIET or (least < _RESTLESS and most > _WALKING_CONTRAST * least):
                break
            if most > _RUNNING_CONTRAST * least and fastest > _RUNNING_MPS:
                break
        else:
            continue
        retained.append((start, stop))
    return retained


def _went(trajectory: FootTrajectory, one: tuple[int, int], two: tuple[int, int]) -> bool:
    if trajectory.time_s[two[0]] - trajectory.time_s[one[1] - 1] < SHORTEST_SWING_S:
        return False
    a, b = quietest(trajectory, one), quietest(trajectory, two)
    position = trajectory.position_m
    step = position[b] - position[a]
    above = position[a : b + 1, 2].max() - max(position[a, 2], position[b, 2])
    turned = rotation.log(
        rotation.multiply(trajectory.q_world_sensor[b], rotation.conjugate(trajectory.q_world_sensor[a]))
    )
    far = float(np.linalg.norm(step)) > MOVED_M
    return bool(far or above > _LIFTED_M or abs(turned[2]) > _TURNED_RAD)


def quietest(trajectory: FootTrajectory, rest: tuple[int, int]) -> int:
    """Return the sample of a rest in which the foot is surest to stand."""
    return rest[0] + int(np.argmin(trajectory.stance.sigma_mps[rest[0] : rest[1]]))


__all__ = ["MOVED_M", "find_rests", "quietest"]
