"""Where a foot rested between strides: what is no walking is not made one."""

from dataclasses import dataclass, fields
from typing import Final

import numpy as np
from numpy.typing import NDArray

from estimators import rotation
from estimators.gait._stance import runs
from estimators.gait.foot.trajectory import FootFlag, FootTrajectory
from estimators.recording import Float

SHORTEST_SWING_S: Final = 0.15
MOVED_M: Final = 0.05
_LIFTED_M, _TURNED_RAD = 0.03, 0.26
_QUIET, _RESTLESS = 0.3, 3.0
_PAUSE_S, _HALT_SHARE, _NEAR = 2.0, 1.6, 3
_SLOWEST_S = 4.5
"""The longest stance of a gait: a stride of 5 s, nine tenths of it on the ground."""
_WALKING_CONTRAST, _RUNNING_CONTRAST, _RUNNING_MPS = 10.0, 4.0, 2.5


@dataclass(frozen=True)
class Footholds:
    """Where a foot stood; n of them, in order.

    Attributes
    ----------
    start_s, stop_s, quietest_s : ndarray, shape (n,)
        First and last moment found at rest, and the quietest.
    position_m : ndarray, shape (n, 3)
        Of the sensor at the quietest moment, world of the trajectory.
    heading_rad : ndarray, shape (n,)
        Where the foot points, about z from the world's x; unwrapped. See `foot_axes` of the strides.
    variance_m2 : ndarray, shape (n, 3)
        Of the position, grown since the start.
    """

    start_s: Float
    stop_s: Float
    quietest_s: Float
    position_m: Float
    heading_rad: Float
    variance_m2: Float

    @property
    def middle_s(self) -> Float:
        """Middle of each rest, shape (n,): in a long stance the quietest moment may be anywhere."""
        return np.asarray(0.5 * (self.start_s + self.stop_s))

    def before(self, time_s: float) -> "Footholds":
        """Return those that had ended at a moment."""
        retained = self.stop_s <= time_s
        return Footholds(*(getattr(self, field.name)[retained] for field in fields(self)))


def find_rests(trajectory: FootTrajectory) -> list[tuple[int, int]]:
    """Join stretches of stance between which the foot did not go anywhere, and leave out what is no walking.

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


def pauses(stood_s: Float) -> NDArray[np.bool_]:
    """Return which stances between strides end a bout, shape (n,).

    Parameters
    ----------
    stood_s : ndarray, shape (n,)
        How long the foot stood between one stride and the next.

    Notes
    -----
    Own. Nobody who walks at a usual pace stands on one foot for 2 s. Behind a walking frame a stance of 2 to 4 s is the
    gait itself: there the stances before and after last as long. A halt is longer than those.
    """
    found = stood_s > _PAUSE_S
    for k in np.flatnonzero(found).tolist():
        near = np.delete(stood_s[max(0, k - _NEAR) : k + _NEAR + 1], min(k, _NEAR))
        if len(near):
            usual = min(float(np.median(near)), _SLOWEST_S)
            found[k] = stood_s[k] > max(_PAUSE_S, _HALT_SHARE * usual)
    return found


def footholds_of(trajectory: FootTrajectory, rests: list[tuple[int, int]], forward: Float) -> Footholds:
    """Return where a foot stood in its rests; `forward`, shape (3,), points to the toes in the sensor's axes."""
    quiet = np.array([quietest(trajectory, rest) for rest in rests], dtype=np.int64)
    last = np.array([rest[1] - 1 for rest in rests], dtype=np.int64)
    first = np.array([rest[0] for rest in rests], dtype=np.int64)
    pointing = rotation.rotate(trajectory.q_world_sensor[quiet], forward).reshape(-1, 3)
    return Footholds(
        start_s=trajectory.time_s[first],
        stop_s=trajectory.time_s[last],
        quietest_s=trajectory.time_s[quiet],
        position_m=trajectory.position_m[quiet].reshape(-1, 3),
        heading_rad=np.unwrap(np.arctan2(pointing[:, 1], pointing[:, 0])),
        # The end of a stance has seen all of it.
        variance_m2=trajectory.position_sigma_m[last].reshape(-1, 3) ** 2,
    )
