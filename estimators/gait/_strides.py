"""From a foot's trajectory to footholds, events and the strides between them."""

from dataclasses import dataclass, fields
from itertools import pairwise

import numpy as np
import scipy
from numpy.typing import NDArray

from estimators import rotation
from estimators.conventions import Side
from estimators.gait._rests import MOVED_M, find_rests, quietest
from estimators.gait._stride_flags import StrideFlag, long_strides, missing_samples
from estimators.gait.foot.trajectory import COAST_S, FootFlag, FootTrajectory
from estimators.recording import Float

Bool = NDArray[np.bool_]

_SMOOTH_S = 0.012
"""Of accelerations in which events are looked for: a second-order 15 Hz low-pass has about this width."""
_HEEL_RISE_SHARE, _PEAK_SHARE, _LANDING_SHARE, _FAST_SHARE = 0.9, 0.3, 0.5, 0.5
_PAUSE_S = 2.0
_SIDEWAYS_RAD = np.deg2rad(60.0)
_END_POINT_SIGMA_M = 0.003
"""A foot creeps and rolls in stance: two instants of one stance differ by so much."""
_UP = np.array([0.0, 0.0, 1.0])


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
        Where the foot points, about z from the world's x; unwrapped. See `foot_axes`.
    variance_m2 : ndarray, shape (n, 3)
        Of the position, grown since the start.
    """

    start_s: Float
    stop_s: Float
    quietest_s: Float
    position_m: Float
    heading_rad: Float
    variance_m2: Float

    def before(self, time_s: float) -> "Footholds":
        """Return those that had ended at a moment."""
        retained = self.stop_s <= time_s
        return Footholds(*(getattr(self, field.name)[retained] for field in fields(self)))


_SWING = np.dtype(
    [
        (name, np.float64)
        for name in (
            "toe_off_s",
            "contact_s",
            "clearance_m",
            "circumduction_m",
            "contact_pitch_rad",
            "toe_off_pitch_rad",
            "toe_out_rad",
            "turn_rad",
            "peak_speed_mps",
        )
    ]
)
"""What the swing of one stride says."""


@dataclass(frozen=True)
class Strides:
    """Strides of one foot, from one foothold to the next; n of them.

    Attributes
    ----------
    side : Side
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

    @property
    def count(self) -> int:
        """Number of strides."""
        return len(self.length_m)

    @property
    def whole_until_s(self) -> float:
        """End of the last stance before the first gap, after which the way from the start is not known."""
        lost = np.flatnonzero(self.flags & StrideFlag.MISSING)
        return float(self.footholds.stop_s[lost[0]]) if len(lost) else float("inf")


def find_strides(trajectory: FootTrajectory, side: Side) -> Strides:
    """Find footholds and strides of one foot.

    Parameters
    ----------
    trajectory : FootTrajectory
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
    forward, left = foot_axes(trajectory, rests)
    axes = np.stack([forward, left, np.cross(forward, left)], axis=1)
    holds = _footholds(trajectory, rests, forward)
    acceleration, rate = _derivatives(trajectory)
    count = max(len(rests) - 1, 0)
    rows = np.full(count, np.nan, _SWING)
    for k in range(count):
        rows[k] = _stride(trajectory, rests[k], rests[k + 1], holds, k, acceleration, rate, side)
    toe_off, contact = rows["toe_off_s"], rows["contact_s"]
    missing_s, is_doubtful = missing_samples(trajectory, rests)
    aloft = (holds.start_s[1:] - holds.stop_s[:-1] > COAST_S) & ~is_doubtful
    # A bout ends where the foot stays on the ground for long. Next to missing samples events are not known: there
    # the foot must have been seen to rest.
    beside = is_doubtful[1:] | is_doubtful[:-1]
    stood_s = (holds.stop_s - holds.start_s)[1:-1] - missing_s[1:]
    pause = np.where(beside, stood_s, toe_off[1:] - contact[:-1]) > _PAUSE_S
    bout = np.concatenate([[0], np.cumsum(pause)])[:count].astype(np.int64)
    is_apart = pause | beside
    before = np.concatenate([[np.nan], np.where(is_apart, np.nan, contact[:-1])])[:count]
    is_first = np.concatenate([[True], pause])[:count]
    is_last = np.concatenate([pause, [True]])[-count:] if count else np.zeros(0, dtype=np.bool_)
    sound = ~(is_doubtful | aloft | is_first | is_last)
    is_long = long_strides(contact - before, sound) | long_strides(np.diff(holds.quietest_s), sound)
    aside = np.abs(rows["toe_out_rad"]) > _SIDEWAYS_RAD
    flags = is_doubtful * StrideFlag.MISSING + aloft * StrideFlag.ALOFT
    flags = flags + is_long * StrideFlag.LONG + aside * StrideFlag.SIDEWAYS
    step = np.diff(holds.position_m, axis=0)
    length = np.linalg.norm(step[:, :2], axis=1)
    grown = np.maximum(np.diff(holds.variance_m2, axis=0), 0.0)
    along = step[:, :2] / np.maximum(length, 1e-9)[:, None]
    variance = np.sum(along**2 * grown[:, :2], axis=1) + 2.0 * _END_POINT_SIGMA_M**2
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
    )


def foot_axes(trajectory: FootTrajectory, rests: list[tuple[int, int]]) -> tuple[Float, Float]:
    """Find which way the foot points in the sensor's axes, from the walk itself.

    Parameters
    ----------
    trajectory : FootTrajectory
    rests : list of (int, int)
        Half-open stretches of samples in which the foot rests.

    Returns
    -------
    forward, left : ndarray, shape (3,)
        Unit vectors in the sensor's axes, level while the foot is flat.

    Notes
    -----
    A foot rolls over heel and toes about its own transverse axis: the principal axis of its angular rate. People
    walk forward more than backward, which settles the sign.
    """
    fallback = np.eye(3)[0], np.eye(3)[1]
    if len(rests) < 2:
        return fallback
    quiet = [quietest(trajectory, rest) for rest in rests]
    up = np.mean(
        [rotation.rotate(rotation.conjugate(trajectory.q_world_sensor[i]), _UP) for i in quiet], axis=0
    )
    up /= np.linalg.norm(up)
    _, rate = _derivatives(trajectory)
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


def _footholds(trajectory: FootTrajectory, rests: list[tuple[int, int]], forward: Float) -> Footholds:
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


def _derivatives(trajectory: FootTrajectory) -> tuple[Float, Float]:
    """Return acceleration and angular rate in the world, both shape (N, 3)."""
    time = trajectory.time_s
    step = np.maximum(np.diff(time), 1e-4)
    width = max(0.5, _SMOOTH_S / float(np.median(step)))
    acceleration = np.diff(trajectory.velocity_mps, axis=0) / step[:, None]
    q = trajectory.q_world_sensor
    rate = rotation.log(rotation.multiply(q[1:], rotation.conjugate(q[:-1]))) / step[:, None]
    both = scipy.ndimage.gaussian_filter1d(np.concatenate([acceleration, rate], axis=1), width, axis=0)
    both = np.concatenate([both, both[-1:]])
    return both[:, :3], both[:, 3:]


def _stride(
    trajectory: FootTrajectory,
    one: tuple[int, int],
    two: tuple[int, int],
    holds: Footholds,
    k: int,
    acceleration: Float,
    rate: Float,
    side: Side,
) -> tuple[float, ...]:
    """Return what one swing says, in the order of `_SWING`."""
    step = holds.position_m[k + 1] - holds.position_m[k]
    length = float(np.linalg.norm(step[:2]))
    heading = 0.5 * (holds.heading_rad[k] + holds.heading_rad[k + 1])
    along = step[:2] / length if length > MOVED_M else np.array([np.cos(heading), np.sin(heading)])
    left = np.array([-along[1], along[0]])
    foot_left = np.array([-np.sin(heading), np.cos(heading), 0.0])
    swing = slice(one[1] - 1, two[0] + 1)
    time, position = trajectory.time_s[swing], trajectory.position_m[swing]
    velocity = trajectory.velocity_mps[swing]
    falling_toes = rate[swing] @ foot_left
    speed = np.linalg.norm(velocity, axis=1)
    fastest = int(np.argmax(speed))
    # Heel rise: the last moment before the fastest one at which the toes still turn down nearly at their fastest.
    rise = falling_toes[: fastest + 1]
    quick = (
        np.flatnonzero(rise >= _HEEL_RISE_SHARE * rise.max()) if rise.max() > 0.0 else np.zeros(1, dtype=int)
    )
    toe_off = int(quick[-1])
    # Fall: after the speed has halved, its deceleration peaks and ends; later peaks are the sole or toes that follow.
    slow = fastest + int(np.argmax(speed[fastest:] < _FAST_SHARE * speed[fastest]))
    push = acceleration[swing][slow:, 2]
    high = push >= _PEAK_SHARE * push.max()
    peaks = np.flatnonzero(high[1:-1] & (push[1:-1] >= push[:-2]) & (push[1:-1] > push[2:])) + 1
    peak = int(peaks[0]) if len(peaks) else int(np.argmax(push))
    below = np.flatnonzero(push[peak:] < _LANDING_SHARE * push[peak])
    contact = slow + peak + (int(below[0]) if len(below) else 0)
    share = (position[:, :2] - holds.position_m[k, :2]) @ along / max(length, MOVED_M)
    line = holds.position_m[k, 2] + np.clip(share, 0.0, 1.0) * step[2]
    aside = (position[:, :2] - holds.position_m[k, :2]) @ left * (1.0 if side == "left" else -1.0)
    pitch = _pitch(trajectory, holds, k, swing, foot_left)
    course = np.arctan2(along[1], along[0])
    toe_out = _wrapped(heading - course) * (1.0 if side == "left" else -1.0)
    return (
        time[toe_off],
        time[contact],
        float((position[:, 2] - line).max()),
        float(aside.max()),
        pitch[contact],
        pitch[toe_off],
        toe_out,
        holds.heading_rad[k + 1] - holds.heading_rad[k],
        float(speed[fastest]),
    )


def _pitch(trajectory: FootTrajectory, holds: Footholds, k: int, swing: slice, foot_left: Float) -> Float:
    """Return how far the toes are up against the stances before and after, rad, shape of the swing."""
    q = trajectory.q_world_sensor
    ends = [q[int(np.searchsorted(trajectory.time_s, holds.quietest_s[j]))] for j in (k, k + 1)]
    turned = [rotation.log(rotation.multiply(q[swing], rotation.conjugate(end))) @ foot_left for end in ends]
    count = len(turned[0])
    share = np.linspace(0.0, 1.0, count)
    return np.asarray(-((1.0 - share) * turned[0] + share * turned[1]))


def _wrapped(angle: float) -> float:
    return float((angle + np.pi) % (2.0 * np.pi) - np.pi)


__all__ = ["Footholds", "Strides", "find_strides", "foot_axes"]
