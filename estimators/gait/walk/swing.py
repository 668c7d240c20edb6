"""The swing of one stride: its events, its height and how the foot is turned; forward or backward."""

from typing import Final

import numpy as np
import scipy

from estimators import rotation
from estimators.conventions import Side
from estimators.gait._rests import MOVED_M, Footholds
from estimators.gait.foot.trajectory import FootTrajectory
from estimators.recording import Float

_SMOOTH_S = 0.012
"""Of accelerations in which events are looked for: a second-order 15 Hz low-pass has about this width."""
_HEEL_RISE_SHARE, _PEAK_SHARE, _LANDING_SHARE, _FAST_SHARE = 0.9, 0.3, 0.5, 0.5
_STEEPER_RAD, _BACKWARD_SHARE, _LEAST_BACKWARD = np.deg2rad(5.0), 0.7, 2

SWING: Final = np.dtype(
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


def derivatives(trajectory: FootTrajectory) -> tuple[Float, Float]:
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


def swing_of(
    trajectory: FootTrajectory,
    rests: list[tuple[int, int]],
    holds: Footholds,
    k: int,
    derived: tuple[Float, Float],
    side: Side,
    *,
    is_backward: bool = False,
) -> tuple[float, ...]:
    """Return what one swing says, in the order of `SWING`.

    Parameters
    ----------
    rests : list of (int, int)
    holds : Footholds
        Of these rests.
    k : int
        Number of the rest before the swing.
    derived : tuple of ndarray
        See `derivatives`.
    is_backward : bool
        The foot went heel first: its events are those of the same movement played backward in time, which is a
        forward step.

    Notes
    -----
    Winter, Pluck, Yang. Backward walking: a simple reversal of forward walking? J Mot Behav 21 (1989) 291-305.
    """
    step = holds.position_m[k + 1] - holds.position_m[k]
    length = float(np.linalg.norm(step[:2]))
    heading = 0.5 * (holds.heading_rad[k] + holds.heading_rad[k + 1])
    along = step[:2] / length if length > MOVED_M else np.array([np.cos(heading), np.sin(heading)])
    toes_first = -along if is_backward and length > MOVED_M else along
    left = np.array([-toes_first[1], toes_first[0]])
    foot_left = np.array([-np.sin(heading), np.cos(heading), 0.0])
    swing = slice(rests[k][1] - 1, rests[k + 1][0] + 1)
    time, position = trajectory.time_s[swing], trajectory.position_m[swing]
    speed = np.linalg.norm(trajectory.velocity_mps[swing], axis=1)
    acceleration, rate = derived
    falling_toes, upward = rate[swing] @ foot_left, acceleration[swing][:, 2]
    if is_backward:
        contact, toe_off = _events(-falling_toes[::-1], speed[::-1], upward[::-1])
        toe_off, contact = len(speed) - 1 - toe_off, len(speed) - 1 - contact
    else:
        toe_off, contact = _events(falling_toes, speed, upward)
    share = (position[:, :2] - holds.position_m[k, :2]) @ along / max(length, MOVED_M)
    line = holds.position_m[k, 2] + np.clip(share, 0.0, 1.0) * step[2]
    outward = 1.0 if side == "left" else -1.0
    aside = (position[:, :2] - holds.position_m[k, :2]) @ left * outward
    pitch = _pitch(trajectory, holds, k, swing, foot_left)
    toe_out = _wrapped(heading - np.arctan2(toes_first[1], toes_first[0])) * outward
    return (
        time[toe_off],
        time[contact],
        float((position[:, 2] - line).max()),
        float(aside.max()),
        pitch[contact],
        pitch[toe_off],
        toe_out,
        holds.heading_rad[k + 1] - holds.heading_rad[k],
        float(speed.max()),
    )


def _events(falling_toes: Float, speed: Float, upward: Float) -> tuple[int, int]:
    """Return the samples of toe-off and contact from the toes' rate, the speed and the acceleration upward."""
    fastest = int(np.argmax(speed))
    # Heel rise: the last moment before the fastest one at which the toes still turn down nearly at their fastest.
    rise = falling_toes[: fastest + 1]
    quick = (
        np.flatnonzero(rise >= _HEEL_RISE_SHARE * rise.max()) if rise.max() > 0.0 else np.zeros(1, dtype=int)
    )
    # Fall: after the speed has halved, its deceleration peaks and ends; later peaks are the sole or toes that follow.
    slow = fastest + int(np.argmax(speed[fastest:] < _FAST_SHARE * speed[fastest]))
    push = upward[slow:]
    high = push >= _PEAK_SHARE * push.max()
    peaks = np.flatnonzero(high[1:-1] & (push[1:-1] >= push[:-2]) & (push[1:-1] > push[2:])) + 1
    peak = int(peaks[0]) if len(peaks) else int(np.argmax(push))
    below = np.flatnonzero(push[peak:] < _LANDING_SHARE * push[peak])
    return int(quick[-1]), slow + peak + (int(below[0]) if len(below) else 0)


def went_backward(trajectory: FootTrajectory, rests: list[tuple[int, int]], holds: Footholds) -> bool:
    """Say whether a foot, taken to go toes first, went heel first in truth.

    Parameters
    ----------
    rests : list of (int, int)
    holds : Footholds
        With headings toward where the foot went.

    Notes
    -----
    Own. A forward step begins with the heel rising steeply (50 to 80 degrees; 15 behind a walking frame) and lands with
    the toes up a little, a backward one the other way round: in all recordings at hand 0 to 8 % of forward strides
    land steeper than they begin.
    """
    steeper = []
    for k in range(len(rests) - 1):
        heading = 0.5 * (holds.heading_rad[k] + holds.heading_rad[k + 1])
        step = holds.position_m[k + 1] - holds.position_m[k]
        if float(step[0] * np.cos(heading) + step[1] * np.sin(heading)) < MOVED_M:
            continue
        foot_left = np.array([-np.sin(heading), np.cos(heading), 0.0])
        pitch = _pitch(trajectory, holds, k, slice(rests[k][1] - 1, rests[k + 1][0] + 1), foot_left)
        steeper.append(float(pitch.max()) > max(-float(pitch.min()), 0.0) + _STEEPER_RAD)
    return len(steeper) >= _LEAST_BACKWARD and float(np.mean(steeper)) >= _BACKWARD_SHARE


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
