"""Smooth curves that motions are made of: noise, steps, bumps, vibrations, and the time that rests stop.

Every curve has two continuous derivatives, so that the acceleration of a place on it has no jumps.
"""

from typing import Final

import numpy as np
from scipy.interpolate import make_interp_spline

from estimators.recording import Float

_SPARE: Final = 6
"""Knots before the first and after the last instant: a spline is not tied at its ends."""
_FADE_S: Final = 0.5


def smooth_step(share: Float) -> Float:
    """Return the way of least jerk from 0 to 1; held outside of them."""
    u = np.clip(share, 0.0, 1.0)
    return np.asarray(u**3 * (10.0 - 15.0 * u + 6.0 * u**2))


def bump(offset: Float) -> Float:
    """Return a hill of height 1 at zero that ends at -1 and 1."""
    return np.asarray(np.clip(1.0 - offset**2, 0.0, None) ** 3)


def noise(time_s: Float, generator: np.random.Generator, width: int, knot_s: float) -> Float:
    """Return curves through random knots, shape (N, width), of about unit variance.

    Parameters
    ----------
    time_s : ndarray, shape (N,)
        Not falling.
    knot_s : float
        Between knots: half a period of the fastest swing.
    """
    count = int(np.ceil((time_s[-1] - time_s[0]) / knot_s)) + 2 * _SPARE
    knots = time_s[0] + knot_s * (np.arange(count) - _SPARE)
    return np.asarray(make_interp_spline(knots, generator.normal(size=(count, width)), k=5)(time_s))


def targets(time_s: Float, generator: np.random.Generator, points: Float, least_s: float) -> Float:
    """Go from point to point by the way of least jerk, each within 1 to 2.5 times `least_s`, with pauses between.

    Parameters
    ----------
    points : ndarray, shape (P, M)
        Used again from the first when they end.
    """
    count = int((time_s[-1] - time_s[0]) / least_s) + 2
    lasts = least_s * generator.uniform(1.0, 2.5, count)
    pauses = generator.uniform(0.0, 1.0, count) * (generator.random(count) < 0.5)
    starts = time_s[0] + np.concatenate(([0.0], np.cumsum(lasts + pauses)[:-1]))
    leg = np.searchsorted(starts, time_s, side="right") - 1
    share = smooth_step((time_s - starts[leg]) / lasts[leg])[:, None]
    here, there = points[leg % len(points)], points[(leg + 1) % len(points)]
    return np.asarray(here + share * (there - here))


def vibration(time_s: Float, starts_s: Float, peaks_mps2: Float, frequency_hz: float) -> Float:
    """Return the place of something struck at `starts_s`, metres: a swing that dies away within a period or two.

    Parameters
    ----------
    starts_s, peaks_mps2 : ndarray, shape (P,)
        Rising; the acceleration of each stroke at its peak, roughly.
    """
    if not len(starts_s):
        return np.zeros(len(time_s))
    last = np.searchsorted(starts_s, time_s, side="right") - 1
    since = np.where(last >= 0, time_s - starts_s[last], 0.0)
    turn = 2.0 * np.pi * frequency_hz
    decay = since * frequency_hz
    size = np.where(last >= 0, peaks_mps2[last], 0.0) / turn**2
    return np.asarray(6.0 * size * decay**2 * np.exp(-2.5 * decay) * np.sin(turn * since))


def own_time(
    time_s: Float, generator: np.random.Generator, rest_s: float, *, pause_share: float = 0.5
) -> Float:
    """Return the time of a movement, which stands still in rests.

    Parameters
    ----------
    rest_s : float
        Rest at the start; zero for a movement that goes on at the first sample.
    pause_share : float
        So many of the stretches of movement end in a rest.

    Returns
    -------
    ndarray, shape (N,)
        Zero at the start of the movement, never falling.
    """
    knots, pace = [time_s[0], max(time_s[0], rest_s)], [0.0 if rest_s > 0.0 else 1.0] * 2
    while knots[-1] < time_s[-1]:
        stop = knots[-1] + generator.uniform(4.0, 25.0)
        rests = generator.random() < pause_share
        knots += [knots[-1] + _FADE_S, stop]
        pace += [1.0, 1.0]
        if rests:
            knots += [stop + _FADE_S, stop + _FADE_S + generator.uniform(0.5, 6.0)]
            pace += [0.0, 0.0]
    speed = smooth_step(np.interp(time_s, knots, pace))
    steps = 0.5 * (speed[1:] + speed[:-1]) * np.diff(time_s)
    return np.concatenate(([0.0], np.cumsum(steps)))
