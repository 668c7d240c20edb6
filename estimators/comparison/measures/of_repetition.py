"""Measures of one repetition beyond ranges: its outward stroke, and how two joints go together in it."""

import functools
from typing import Final

import numpy as np
import scipy

from estimators.comparison._contract import Measure
from estimators.comparison._smoothness import noise_levels
from estimators.comparison.channels.sided import SideChannels, fill_gaps
from estimators.comparison.measures.coordination import interjoint_coordination, interjoint_coordinations
from estimators.comparison.measures.strokes import (
    CUT_OFF_HZ,
    LEAST_PATH,
    SHORTEST_S,
    log_dimensionless_jerks,
    time_to_peak_speed,
    units_per_metre,
)
from estimators.recording import Float
from estimators.sentences import say

JOINT_FLOOR_RAD: Final = 0.087
"""Five degrees: a joint that moves less in the stroke takes no part in it."""
_DRAWS: Final = 8
_UNKNOWN: Final = float("nan")


def stroke_measures(
    speed: Float, path: Float, rate_hz: float, unit_rise: float, stroke: slice, noise: float
) -> list[Measure]:
    """Measure the outward stroke: when it is fastest, and how smooth it is by jerk.

    Parameters
    ----------
    speed : ndarray, shape (N,)
        Of the whole repetition, m/s or rad/s.
    path : ndarray, shape (N, D)
        Of the hand in m, or the turning angle in rad, D = 1, at the same ticks.
    unit_rise : float
        Smallest rise of speed that is a push, in the unit of the speed: a stroke slower than that is none.
    stroke : slice
        Of the path, from `measures.strokes.outward_stroke`.
    noise : float
        Of the speed, from `noise_level`.

    Returns
    -------
    list of Measure
        `time_to_peak_speed` (`measures.strokes.time_to_peak_speed`) and `log_dimensionless_jerk`
        (`measures.strokes.log_dimensionless_jerk`), NaN with the reason where they are undefined.

    Notes
    -----
    The stroke runs from 5 % of its largest speed to 98 % of the way (`measures.strokes.outward_stroke`); of a
    minimum-jerk movement that part alone has a jerk of -3.97. The low pass of 6 Hz goes over the whole repetition, so
    that the ends of the stroke are none of the filter's. Uncertainty is what noise of the level found in the signal
    changes, over draws with a fixed seed.
    """
    if stroke.stop - stroke.start < 3 or not speed[stroke].max() > unit_rise:
        reason = say("measure.no_stroke")
        return [
            Measure("time_to_peak_speed", "timing", _UNKNOWN, "%", _UNKNOWN, 1, reason),
            Measure("log_dimensionless_jerk", "smoothness", _UNKNOWN, "1", _UNKNOWN, 1, reason),
        ]
    return [_peak_time(speed, stroke, noise), _jerk(path, stroke, rate_hz)]


def _peak_time(speed: Float, stroke: slice, level: float) -> Measure:
    share = time_to_peak_speed(speed[stroke])
    own = speed[stroke]
    # Any moment whose speed is the largest but for noise might be the true peak.
    rivals = np.flatnonzero(own >= own.max() - 2.0 * level) if np.isfinite(level) else np.zeros(0)
    spread = float(np.ptp(rivals)) / np.sqrt(12.0) if len(rivals) else _UNKNOWN
    reason = "" if np.isfinite(share) else say("measure.no_peak")
    return Measure(
        "time_to_peak_speed", "timing", 100.0 * share, "%", 100.0 * spread / (len(own) - 1), 1, reason
    )


def _jerk(path: Float, stroke: slice, rate_hz: float) -> Measure:
    # Noise of places becomes noise of speed by the difference over two ticks.
    level = noise_levels(path.T, rate_hz)
    # The path itself comes first, the draws after it.
    paths = path[None]
    if np.isfinite(level).all() and (stroke.stop - stroke.start - 1) / rate_hz >= SHORTEST_S:
        generator = np.random.default_rng(0)
        paths = np.concatenate([paths, path + level * generator.standard_normal((_DRAWS, *path.shape))])
    velocity = _smooth(np.gradient(paths, 1.0 / rate_hz, axis=1), rate_hz)
    value, *drawn = log_dimensionless_jerks(velocity[:, stroke], rate_hz).tolist()
    reason = "" if np.isfinite(value) else say("measure.stroke_short", least_s=SHORTEST_S)
    sigma = float(np.std(drawn, ddof=1)) if np.isfinite(value) and drawn else _UNKNOWN
    return Measure("log_dimensionless_jerk", "smoothness", value, "1", sigma, 1, reason)


@functools.cache
def _low_pass(rate_hz: float) -> tuple[Float, Float]:
    """Return the sections of the low pass, and the state of one that has long seen a one."""
    sections = np.asarray(scipy.signal.butter(2, CUT_OFF_HZ, fs=rate_hz, output="sos"))
    return sections, np.asarray(scipy.signal.sosfilt_zi(sections))[:, None, None, :]


def _smooth(velocity: Float, rate_hz: float) -> Float:
    """Filter forwards and backwards along the second axis, shape (S, N, D): `scipy.signal.sosfiltfilt`.

    Its odd ends and its filter, with time along the memory and what is the same for all repetitions done once.
    """
    if 0.45 * rate_hz <= CUT_OFF_HZ:
        return velocity
    sections, settled = _low_pass(round(rate_hz, 6))
    samples = velocity.shape[1]
    pad = min(3 * round(rate_hz / CUT_OFF_HZ), samples - 1)
    within = slice(pad, pad + samples)
    own = np.swapaxes(velocity, 1, 2)
    longer = np.empty((*own.shape[:2], samples + 2 * pad))
    longer[..., within] = own
    longer[..., :pad] = 2 * own[..., :1] - own[..., pad:0:-1]
    longer[..., within.stop :] = 2 * own[..., -1:] - own[..., -2 : -(pad + 2) : -1]
    there, _ = scipy.signal.sosfilt(sections, longer, zi=settled * longer[..., :1])
    back, _ = scipy.signal.sosfilt(sections, there[..., ::-1], zi=settled * there[..., -1:])
    return np.ascontiguousarray(np.swapaxes(back[..., ::-1][..., within], 1, 2))


def units_measure(
    path_m: Float, rate_hz: float, reach_m: float, count_sigma: float, sigma_m: float
) -> Measure:
    """Return the movement units a metre of the hand's way (`measures.strokes.units_per_metre`).

    Parameters
    ----------
    path_m : ndarray, shape (N, 3)
    count_sigma : float
        Standard deviation of the number of units.
    sigma_m : float
        Standard deviation of a place of the hand.
    """
    value = units_per_metre(path_m, rate_hz, reach_m)
    if not np.isfinite(value):
        reason = say("measure.way_short", share=LEAST_PATH)
        return Measure("units_per_metre", "smoothness", _UNKNOWN, "1/m", _UNKNOWN, 1, reason)
    way_m = float(np.linalg.norm(np.diff(path_m, axis=0), axis=1).sum())
    sigma = float(np.hypot(count_sigma, 2.0 * value * sigma_m)) / way_m
    return Measure("units_per_metre", "smoothness", value, "1/m", sigma, 1)


def coordination_measures(arm: SideChannels, side: str, stroke: slice, rate_hz: float) -> list[Measure]:
    """Measure how shoulder and elbow go together in the outward stroke (`measures.coordination`).

    Parameters
    ----------
    arm : SideChannels
        Cut to the repetition.
    side : {"left", "right"}
    stroke : slice
        From `outward_stroke`.

    Returns
    -------
    list of Measure
        Empty where one of the two joints was not measured. Uncertainty is what a joint angle that drifts by its
        standard deviation over the stroke, the way that changes more, makes of it.
    """
    names = (f"thorax_humerus_{side}_yxy_elevation", f"humerus_forearm_{side}_zxy_flexion")
    if any(name not in arm.channels for name in names):
        return []
    columns = [arm.channels.index(name) for name in names]
    angles = fill_gaps(arm.values[:, columns])[0][stroke].T
    found = interjoint_coordination(angles[0], angles[1], rate_hz, JOINT_FLOOR_RAD)
    if found is None:
        reason = say("measure.joint_still", least_rad=JOINT_FLOOR_RAD)
        return [
            Measure(name, "coordination", _UNKNOWN, unit, _UNKNOWN, 1, reason)
            for name, unit in (("joint_correlation", "1"), ("joint_lag", "s"), ("joint_common_share", "%"))
        ]
    moved = np.full(3, _UNKNOWN)
    sigma = np.array([_typical(arm.sigma[stroke, column]) for column in columns])
    if np.isfinite(sigma).all():
        drift = np.linspace(0.0, 1.0, angles.shape[1])
        first, second = (
            angle + size * np.outer([1.0, -1.0], drift) for angle, size in zip(angles, sigma, strict=True)
        )
        # Either way, for where two lags explain the stroke alike a small change one way turns one into the other.
        others = interjoint_coordinations(
            np.vstack([first, angles[[0, 0]]]), np.vstack([angles[[1, 1]], second]), rate_hz, 0.0
        )
        here = np.array([found.correlation, found.lag_s, found.common_share])
        away = [
            [
                np.square(np.array([one.correlation, one.lag_s, one.common_share]) - here)
                for one in both
                if one
            ]
            for both in (others[:2], others[2:])
        ]
        if any(away):
            moved = np.sqrt(np.sum([np.max(squares, axis=0) for squares in away if squares], axis=0))
        # A lag is known to a tick at best.
        moved[1] = np.hypot(moved[1], 1.0 / rate_hz / np.sqrt(12.0))
    return [
        Measure("joint_correlation", "coordination", found.correlation, "1", float(moved[0]), 1),
        Measure("joint_lag", "coordination", found.lag_s, "s", float(moved[1]), 1),
        Measure(
            "joint_common_share", "coordination", 100.0 * found.common_share, "%", 100.0 * float(moved[2]), 1
        ),
    ]


def _typical(sigma: Float) -> float:
    known = sigma[np.isfinite(sigma)]
    return float(np.median(known)) if len(known) else _UNKNOWN
