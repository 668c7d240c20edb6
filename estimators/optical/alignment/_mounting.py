"""How a module is turned in the laboratory and where its marker is, from accelerations seen and felt."""

from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from estimators import rotation
from estimators.conventions import GRAVITY_MPS2
from estimators.errors import ComparisonError
from estimators.optical._attitude import level_attitude
from estimators.optical._contract import OpticalStart
from estimators.optical.alignment._signals import HALF_WIDTH_S, linear, repetition, triangle, without_ghosts
from estimators.recording import Float
from estimators.samples import Samples
from estimators.sentences import say

_LONGEST_S, _STRIDE_S = 60.0, 5.0
_LEAST_S = 2.0
_LEAST_EXPLAINED = 0.5
_TRIALS = 24
_ARM_M = 0.1
"""Doubt of a lever arm: a module that does not turn tells none."""


@dataclass(frozen=True)
class Mounting:
    """How a module is turned in the laboratory, and where its marker is.

    Attributes
    ----------
    q_room_sensor : ndarray, shape (K, 4)
        Level by gravity, heading by the markers; good to a few degrees, to begin a filter with.
    rate_bias_radps : ndarray, shape (K, 3)
    lever_arm_m, lever_arm_sigma_m : ndarray, shape (3,)
        From the accelerometer to the marker, sensor axes.
    explained : float
        Part of the variance of the marker's acceleration that the module explains.
    """

    q_room_sensor: Float
    rate_bias_radps: Float
    heading_sigma_rad: float
    lever_arm_m: Float
    lever_arm_sigma_m: Float
    explained: float


@dataclass(frozen=True)
class Accelerations(Samples):
    """Of a marker and of its module, through one window, level axes with the heading of the module.

    Attributes
    ----------
    seen : ndarray, shape (K, 3)
        Second differences of the marker, laboratory axes.
    felt : ndarray, shape (K, 3)
        Of the module, gravity taken off.
    arm : ndarray, shape (K, 3, 3)
        Second differences of its attitude: times a lever arm they are what the turning adds.
    """

    seen: Float
    felt: Float
    arm: Float


@dataclass(frozen=True)
class Fit:
    """What maps accelerations of a module onto those of its marker.

    Attributes
    ----------
    scale, scale_sigma : float
        Length of the file over true length; 1 and 0 when it was held.
    lever_arm_m, lever_arm_sigma_m : ndarray, shape (3,)
    explained : float
        Part of the variance of the marker's acceleration.
    rest : float
        Variance of what is left.
    """

    heading_rad: float
    heading_sigma_rad: float
    scale: float
    scale_sigma: float
    lever_arm_m: Float
    lever_arm_sigma_m: Float
    explained: float
    rest: float


def accelerations(
    accelerometer_mps2: Float,
    q_level_sensor: Float,
    time_step_s: float,
    camera_time_s: Float,
    marker_m: Float,
) -> Accelerations:
    """Return accelerations of the liveliest minute that both saw.

    Parameters
    ----------
    accelerometer_mps2 : ndarray, shape (K, 3)
        Without holes; the first tick is at time zero.
    q_level_sensor : ndarray, shape (K, 4)
        Of `level_attitude`.
    camera_time_s : ndarray, shape (N,)
        On the clock of the ticks.
    marker_m : ndarray, shape (N, 3)
        Laboratory, z up; NaN in gaps.

    Raises
    ------
    ComparisonError
        Too little of the marker was seen.
    """
    count = len(accelerometer_mps2)
    spacing = float(np.median(np.diff(camera_time_s)))
    reach = max(1, round(max(HALF_WIDTH_S, spacing) / time_step_s))
    if count <= 2 * reach + 1:
        raise ComparisonError(say("markers.short"))
    marker_m = without_ghosts(marker_m)
    ticks = np.arange(count, dtype=np.float64) * time_step_s
    present = np.isfinite(marker_m).all(axis=1)
    if present.sum() < 10:
        raise ComparisonError(say("markers.few_frames"))
    held = linear(camera_time_s, np.where(present, 0.0, np.nan), ticks, 1.6 * spacing)
    path = scipy.interpolate.CubicSpline(camera_time_s[present], marker_m[present])(ticks) + held[:, None]
    span = (reach * time_step_s) ** 2
    seen = (path[2 * reach :] - 2.0 * path[reach:-reach] + path[: -2 * reach]) / span
    level = rotation.rotate(q_level_sensor, accelerometer_mps2) - np.array([0.0, 0.0, GRAVITY_MPS2])
    felt = triangle(level, reach)[reach:-reach]
    matrix = rotation.to_matrix(q_level_sensor)
    arm = (matrix[2 * reach :] - 2.0 * matrix[reach:-reach] + matrix[: -2 * reach]) / span
    good = np.flatnonzero(np.isfinite(seen).all(axis=1))
    if len(good) < _LEAST_S / time_step_s:
        raise ComparisonError(say("markers.seen_short", least_s=_LEAST_S))
    good = good[_liveliest(good, felt[good], time_step_s)]
    return Accelerations(seen[good], felt[good], arm[good])


def _liveliest(ticks: NDArray[np.int64], felt: Float, time_step_s: float) -> slice:
    """Return the minute with most movement: a heading drifts over more, and a rest tells nothing."""
    energy = np.concatenate([[0.0], np.cumsum((felt**2).sum(axis=1))])
    starts = np.arange(
        ticks[0], max(ticks[0] + 1, ticks[-1] - _LONGEST_S / time_step_s), _STRIDE_S / time_step_s
    )
    first = np.searchsorted(ticks, starts)
    last = np.searchsorted(ticks, starts + _LONGEST_S / time_step_s)
    best = int(np.argmax(energy[last] - energy[first]))
    return slice(int(first[best]), int(last[best]))


def _turned(seen: Float, heading_rad: float) -> Float:
    c, s = np.cos(heading_rad), np.sin(heading_rad)
    return np.column_stack([c * seen[:, 0] + s * seen[:, 1], c * seen[:, 1] - s * seen[:, 0], seen[:, 2]])


def _best_of_circle(seen: Float, columns: Float, free: list[int], scale: float) -> tuple[float, Float]:
    """Return the heading of a circle of trials whose least squares leave least, and its solution, shape (4,)."""
    start = np.array([scale, 0.0, 0.0, 0.0])
    normal = np.einsum("kia,kib->ab", columns, columns) + 1e-9 * np.eye(4)
    costs = []
    for psi in np.linspace(-np.pi, np.pi, _TRIALS, endpoint=False).tolist():
        y, x = _turned(seen, psi), start.copy()
        if free:
            held = [k for k in range(4) if k not in free]
            right = np.einsum("kia,ki->a", columns, y) - normal[:, held] @ x[held]
            x[free] = np.linalg.solve(normal[np.ix_(free, free)], right[free])
            x[0] = max(x[0], 1e-6)
            # A far marker is rather a wrong heading.
            x[1:] *= min(1.0, 0.3 * x[0] / max(float(np.linalg.norm(x[1:])), 1e-12))
        costs.append((float(np.median(np.abs(y - columns @ x))), psi, x))
    _, psi, x = min(costs, key=lambda cost: cost[0])
    return psi, x


def fit(both: Accelerations, lever_arm_m: Float | None = None, scale: float | None = 1.0) -> Fit:
    """Find heading and lever arm, and a scale unless one is held.

    Notes
    -----
    `Rz(-heading) seen = s (felt + arm r)`: for a given heading linear in s and s r. The heading is found on a circle of
    trials and refined by the same least squares, far-off residuals held down (Huber).
    """
    seen, felt, arm = both.seen, both.felt, both.arm
    given = None if lever_arm_m is None else np.asarray(lever_arm_m, dtype=np.float64)
    columns = np.concatenate([felt[:, :, None], arm], axis=2)
    # Columns that are free: scale, then the arm times the scale.
    free = ([] if scale is not None else [0]) + ([1, 2, 3] if given is None else [])
    if given is not None:
        columns[:, :, 0] += arm @ given
    psi, x = _best_of_circle(seen, columns, free, 1.0 if scale is None else scale)
    covariance, weight, rest = np.eye(1 + len(free)), np.ones(len(seen)), seen
    for _ in range(12):
        rest = _turned(seen, psi) - columns @ x
        size = np.linalg.norm(rest, axis=1)
        weight = 1.0 / np.maximum(1.0, size / (2.0 * np.median(size) + 1e-12))
        model = columns @ x
        by_psi = np.column_stack([-model[:, 1], model[:, 0], np.zeros(len(model))])
        jacobian = np.concatenate([by_psi[:, :, None], columns[:, :, free]], axis=2)
        normal = np.einsum("kia,k,kib->ab", jacobian, weight, jacobian)
        noise = float(np.average(rest**2, weights=np.repeat(weight[:, None], 3, 1)))
        noise *= max(repetition(rest[:, axis]) for axis in range(3))
        doubt = [np.pi] + [1e6 if k == 0 else _ARM_M * max(x[0], 1e-6) for k in free]
        pull = np.array([0.0] + [0.0 if k == 0 else -float(x[k]) for k in free])
        prior = noise / np.array(doubt) ** 2
        covariance = np.linalg.inv(normal + np.diag(prior))
        step = covariance @ (np.einsum("kia,k,ki->a", jacobian, weight, rest) + prior * pull)
        covariance = noise * covariance
        psi += float(step[0])
        x[free] += step[1:]
        x[0] = max(x[0], 1e-6)
        if abs(float(step[0])) < 1e-6:
            break
    sigma = np.sqrt(np.diag(covariance))
    total = np.average((seen - np.average(seen, axis=0, weights=weight)) ** 2, axis=0, weights=weight).sum()
    left = float(np.average(rest**2, axis=0, weights=weight).sum())
    tail = sigma[-3:] / x[0] if given is None else np.zeros(3)
    return Fit(
        psi,
        float(sigma[0]),
        float(x[0]),
        float(sigma[1]) if scale is None else 0.0,
        x[1:] / x[0] if given is None else given,
        tail,
        1.0 - left / max(float(total), 1e-12),
        left,
    )


def find_mounting(
    gyroscope_radps: Float,
    accelerometer_mps2: Float,
    time_step_s: float,
    camera_time_s: Float,
    marker_m: Float,
    lever_arm_m: Float | None = None,
    attitude: tuple[Float, Float] | None = None,
) -> Mounting:
    """Find heading and lever arm from movement.

    Parameters
    ----------
    gyroscope_radps, accelerometer_mps2 : ndarray, shape (K, 3)
        Without holes; the first tick is at time zero.
    camera_time_s : ndarray, shape (N,)
        On the clock of the ticks.
    marker_m : ndarray, shape (N, 3)
        Laboratory, z up; NaN in gaps.
    lever_arm_m : ndarray, shape (3,), optional
        When it was measured; otherwise it is found.
    attitude : tuple of ndarray, optional
        What `level_attitude` gave for these samples, when it is known already.

    Raises
    ------
    ComparisonError
        Too little of the marker was seen, or it moved too little for a heading (page: R 4.5).
    """
    q, bias = attitude or level_attitude(gyroscope_radps, accelerometer_mps2, time_step_s)
    found = fit(accelerations(accelerometer_mps2, q, time_step_s, camera_time_s, marker_m), lever_arm_m)
    if not found.heading_sigma_rad < np.radians(15.0):
        raise ComparisonError(say("markers.moved_little"))
    if found.explained < _LEAST_EXPLAINED:
        raise ComparisonError(say("markers.unexplained", explained=max(found.explained, 0.0)))
    return Mounting(
        rotation.multiply(rotation.about_z(found.heading_rad), q),
        bias,
        found.heading_sigma_rad,
        found.lever_arm_m,
        found.lever_arm_sigma_m,
        found.explained,
    )


def start_at(
    tick: int,
    time_step_s: float,
    mounting: Mounting,
    gyroscope_radps: Float,
    camera_time_s: Float,
    marker_m: Float,
    marker_sigma_m: float,
) -> OpticalStart | None:
    """Return the state at a tick from the markers around it; None where fewer than six frames are near.

    The marker's place and velocity are a parabola through its frames; the module is a lever arm away.
    """
    time = tick * time_step_s
    window = max(0.15, 3.6 * float(np.median(np.diff(camera_time_s))))
    near = np.flatnonzero(np.abs(camera_time_s - time) <= window)
    near = near[np.isfinite(marker_m[near]).all(axis=1)]
    if len(near) < 6:
        return None
    t = camera_time_s[near] - time
    design = np.column_stack([np.ones_like(t), t, t * t])
    fit, *_ = np.linalg.lstsq(design, marker_m[near], rcond=None)
    spread = np.sqrt(np.diag(np.linalg.inv(design.T @ design))) * marker_sigma_m
    q, bias = mounting.q_room_sensor[tick], mounting.rate_bias_radps[tick]
    turning = np.cross(gyroscope_radps[tick] - bias, mounting.lever_arm_m)
    unsure = float(np.linalg.norm(mounting.lever_arm_sigma_m))
    rate = float(np.linalg.norm(gyroscope_radps[tick]))
    return OpticalStart(
        fit[0] - rotation.rotate(q, mounting.lever_arm_m),
        fit[1] - rotation.rotate(q, turning),
        q,
        bias,
        # Beside the fit's own: what a parabola misses of a jerk of 100 m/s^3, and the lever arm.
        float(np.hypot(np.hypot(3.0 * spread[0], 6.0 * window**3), unsure)),
        float(np.hypot(np.hypot(3.0 * spread[1], 17.0 * window**2), rate * unsure)),
        0.05,
        float(max(np.hypot(3.0 * mounting.heading_sigma_rad, 0.05), 0.05)),
    )
