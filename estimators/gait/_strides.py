"""From a foot's trajectory to footholds, events and the strides between them."""

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from estimators import rotation
from estimators.conventions import Side
from estimators.gait._rests import Footholds, find_rests, footholds_of, pauses, quietest
from estimators.gait._stride_flags import StrideFlag, long_strides, missing_samples
from estimators.gait.foot.trajectory import COAST_S, FootFlag, FootTrajectory
from estimators.gait.walk.swing import SWING, derivatives, swing_of, went_backward
from estimators.gait.walk.trembling import trembles
from estimators.recording import Float

Bool = NDArray[np.bool_]

_SIDEWAYS_RAD = np.deg2rad(60.0)
_END_POINT_SIGMA_M, _TREMBLING_SIGMA_M = 0.003, 0.03
"""A foot creeps and rolls in stance: two instants of one stance differ by so much; of a foot that trembles by more."""
_UP = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True)
class Strides:
    """Strides of one foot, from one foothold to the next; n of them.

    Attributes
    ----------
    footholds : Footholds
        One more than strides.
    toe_off_s, contact_s : ndarray, shape (n,)
        When the foot left the ground, and when it touched it again.
    duration_s, stance_s, swing_s : ndarray, shape (n,)
        From the contact before the stride to the one that ends it, and its parts; NaN where the contact
        before is not of the same bout, or not known because samples are missing.
    length_m, length_sigma_m : ndarray, shape (n,)
        Horizontal, and its standard deviation.
    rise_m : ndarray, shape (n,)
    clearance_m, circumduction_m : ndarray, shape (n,)
        Most that the sensor rose above the straight line between the footholds, and most that it
        went outward of it (to the left for a left foot).
    contact_pitch_rad, toe_off_pitch_rad : ndarray, shape (n,)
        Angle of the sole to that of the stances around: positive with the toes up.
    toe_out_rad : ndarray, shape (n,)
        Between the foot, halfway from the one stance to the other, and the line of progression, outward positive. On a
        curve the line is a chord: half of the stride's turn is so left out.
    turn_rad : ndarray, shape (n,)
        Turn of the foot about the vertical, left positive.
    peak_speed_mps : ndarray, shape (n,)
    bout : ndarray of int, shape (n,)
        Number of the walking bout.
    is_initiation, is_termination : ndarray of bool, shape (n,)
        First and last stride of a bout.
    missing_s : ndarray, shape (n,)
        Without samples, in the stance before and the swing; what lies there is an estimate of what was lost.
    flags : ndarray of uint8, shape (n,)
        `StrideFlag` bits.
    q_sensor_foot : ndarray, shape (4,)
        Turns foot axes (x to the toes, z up while flat) into the sensor's; found from the walk.
    is_backward : bool
        The foot went heel first; see `went_backward`.
    is_trembling : bool
        It shook while it stood, as in clonus: strides may be lost, and `length_sigma_m` is larger.
    is_carried : bool
        It did not stand while the other foot walked; see `carried_foot`. All its strides are `StrideFlag.ALOFT`.
    rolled_s : float
        For how long it was moved without stepping; see `rolled_s` of `walk.rolling`.
    """

    side: Side
    footholds: Footholds
    toe_off_s: Float
    contact_s: Float
    duration_s: Float
    stance_s: Float
    swing_s: Float
    length_m: Float
    length_sigma_m: Float
    rise_m: Float
    clearance_m: Float
    circumduction_m: Float
    contact_pitch_rad: Float
    toe_off_pitch_rad: Float
    toe_out_rad: Float
    turn_rad: Float
    peak_speed_mps: Float
    bout: NDArray[np.int64]
    is_initiation: Bool
    is_termination: Bool
    missing_s: Float
    flags: NDArray[np.uint8]
    q_sensor_foot: Float
    is_backward: bool = False
    is_trembling: bool = False
    is_carried: bool = False
    rolled_s: float = 0.0

    @property
    def count(self) -> int:
        """Number of strides."""
        return len(self.length_m)

    @property
    def is_inside(self) -> Bool:
        """Which strides lie between Record and Stop, shape (n,)."""
        return np.asarray((self.flags & StrideFlag.OUTSIDE) == 0)

    def has(self, flag: StrideFlag) -> Bool:
        """Return which strides between Record and Stop have a flag, shape (n,)."""
        return np.asarray((self.flags & flag) != 0) & self.is_inside

    def between(self, start_s: float, end_s: float) -> "Strides":
        """Mark the strides that are not wholly within a recording; all of them stay.

        Parameters
        ----------
        start_s, end_s : float
            When Record and Stop were pressed, on the clock of the strides.
        """
        outside = (self.toe_off_s < start_s) | (self.contact_s > end_s)
        return replace(self, flags=np.asarray(self.flags | outside * StrideFlag.OUTSIDE, dtype=np.uint8))

    @property
    def whole_until_s(self) -> float:
        """End of the last stance before the first gap, after which the way from the start is not known."""
        lost = np.flatnonzero(self.flags & StrideFlag.MISSING)
        return float(self.footholds.stop_s[lost[0]]) if len(lost) else float("inf")


def find_strides(trajectory: FootTrajectory, side: Side) -> Strides:
    """Find footholds and strides of one foot.

    Parameters
    ----------
    side : Side
        Decides what is outward.

    Returns
    -------
    Strides
        With no stride at all where the foot never stood as in walking or never left the ground; nothing is guessed.

    Notes
    -----
    Toe-off is the end of the fastest heel rise, contact the end of the last deceleration of the fall: both come
    from angular rate and acceleration alone, relative to each stride's own extremes. A shuffled step is found as
    long as the foot moves 5 cm, lifts 3 cm or turns 15 degrees between two rests.
    """
    rests = find_rests(trajectory)
    axes, holds, is_backward = _oriented(trajectory, rests)
    both = derivatives(trajectory)
    count = max(len(rests) - 1, 0)
    rows = np.full(count, np.nan, SWING)
    for k in range(count):
        rows[k] = swing_of(trajectory, rests, holds, k, both, side, is_backward=is_backward)
    toe_off, contact = rows["toe_off_s"], rows["contact_s"]
    missing_s, is_doubtful = missing_samples(trajectory, rests)
    aloft = (holds.start_s[1:] - holds.stop_s[:-1] > COAST_S) & ~is_doubtful
    # A bout ends where the foot stays on the ground for longer than its gait does. Next to missing samples events are
    # not known: there the foot must have been seen to rest.
    beside = is_doubtful[1:] | is_doubtful[:-1]
    stood_s = (holds.stop_s - holds.start_s)[1:-1] - missing_s[1:]
    pause = pauses(np.where(beside, stood_s, toe_off[1:] - contact[:-1]))
    bout = np.concatenate([[0], np.cumsum(pause)])[:count].astype(np.int64)
    is_apart = pause | beside
    before = np.concatenate([[np.nan], np.where(is_apart, np.nan, contact[:-1])])[:count]
    is_first = np.concatenate([[True], pause])[:count]
    is_last = np.concatenate([pause, [True]])[-count:] if count else np.zeros(0, dtype=np.bool_)
    sound = ~(is_doubtful | aloft | is_first | is_last)
    is_long = long_strides(contact - before, sound) | long_strides(np.diff(holds.middle_s), sound)
    aside = np.abs(rows["toe_out_rad"]) > _SIDEWAYS_RAD
    flags = is_doubtful * StrideFlag.MISSING + aloft * StrideFlag.ALOFT
    flags = flags + is_long * StrideFlag.LONG + aside * StrideFlag.SIDEWAYS
    step = np.diff(holds.position_m, axis=0)
    length = np.linalg.norm(step[:, :2], axis=1)
    grown = np.maximum(np.diff(holds.variance_m2, axis=0), 0.0)
    along = step[:, :2] / np.maximum(length, 1e-9)[:, None]
    is_trembling = trembles(trajectory, both[1], toe_off, contact)
    end_point_m = _TREMBLING_SIGMA_M if is_trembling else _END_POINT_SIGMA_M
    variance = np.sum(along**2 * grown[:, :2], axis=1) + 2.0 * end_point_m**2
    return Strides(
        side=side,
        footholds=holds,
        toe_off_s=toe_off,
        contact_s=contact,
        duration_s=contact - before,
        stance_s=toe_off - before,
        swing_s=contact - toe_off,
        length_m=length,
        length_sigma_m=np.sqrt(variance),
        rise_m=step[:, 2],
        clearance_m=rows["clearance_m"],
        circumduction_m=rows["circumduction_m"],
        contact_pitch_rad=rows["contact_pitch_rad"],
        toe_off_pitch_rad=rows["toe_off_pitch_rad"],
        toe_out_rad=rows["toe_out_rad"],
        turn_rad=rows["turn_rad"],
        peak_speed_mps=rows["peak_speed_mps"],
        bout=bout,
        is_initiation=is_first,
        is_termination=is_last,
        missing_s=missing_s,
        flags=np.asarray(flags, dtype=np.uint8),
        q_sensor_foot=rotation.from_matrix(axes),
        is_backward=is_backward,
        is_trembling=is_trembling,
    )


def _oriented(trajectory: FootTrajectory, rests: list[tuple[int, int]]) -> tuple[Float, Footholds, bool]:
    """Return the foot's axes in the sensor's as columns, its footholds, and whether it went backward."""
    forward, left = foot_axes(trajectory, rests)
    holds = footholds_of(trajectory, rests, forward)
    is_backward = went_backward(trajectory, rests, holds)
    if is_backward:
        forward, left = -forward, -left
        holds = footholds_of(trajectory, rests, forward)
    return np.stack([forward, left, np.cross(forward, left)], axis=1), holds, is_backward


def foot_axes(trajectory: FootTrajectory, rests: list[tuple[int, int]]) -> tuple[Float, Float]:
    """Find which way the foot points in the sensor's axes, from the walk itself.

    Parameters
    ----------
    rests : list of (int, int)
        Half-open stretches of samples in which the foot rests.

    Returns
    -------
    forward, left : ndarray, shape (3,)
        Unit vectors in the sensor's axes, level while the foot is flat.

    Notes
    -----
    A foot rolls over heel and toes about its own transverse axis: the principal axis of its angular rate. People
    walk forward more than backward, which settles the sign; `went_backward` finds who did not.
    """
    fallback = np.eye(3)[0], np.eye(3)[1]
    if len(rests) < 2:
        return fallback
    quiet = [quietest(trajectory, rest) for rest in rests]
    up = np.mean(
        [rotation.rotate(rotation.conjugate(trajectory.q_world_sensor[i]), _UP) for i in quiet], axis=0
    )
    up /= np.linalg.norm(up)
    _, rate = derivatives(trajectory)
    in_sensor = rotation.rotate(rotation.conjugate(trajectory.q_world_sensor), rate)
    in_sensor -= np.outer(in_sensor @ up, up)
    seen = (trajectory.flags & FootFlag.INVALID) == 0
    seen[: rests[0][1]], seen[rests[-1][0] :] = False, False
    _, vectors = np.linalg.eigh(in_sensor[seen].T @ in_sensor[seen])
    left = vectors[:, -1] - (vectors[:, -1] @ up) * up
    left /= np.linalg.norm(left)
    forward = np.cross(left, up)
    went = 0.0
    for a, b in pairwise(quiet):
        step = trajectory.position_m[b] - trajectory.position_m[a]
        went += float(step @ rotation.rotate(trajectory.q_world_sensor[a], forward))
    return (forward, left) if went >= 0.0 else (-forward, -left)
