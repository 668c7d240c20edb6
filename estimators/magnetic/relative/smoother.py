"""Relative pose off line: the filter run again over a recording, smoothed backward (method page 3.12)."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from estimators import rotation
from estimators._kernels import kernel, multiply, step
from estimators.kernels.attitudes import logarithm
from estimators.kernels.backward import step_back
from estimators.magnetic._coil import Source
from estimators.magnetic.relative import layout as at
from estimators.magnetic.relative.motion import corrected, inject, mechanise, predict, relax
from estimators.magnetic.relative.pose import RelativeChunk, RelativePoseFilter, RelativeResult
from estimators.recording import Float

_T, _PUBLISHED, _FORCE, _RATE = (
    at.TIME_STEP,
    at.PUBLISHED,
    at.FORCE_SIGMA,
    at.RATE_SIGMA,
)
_P, _U, _Q, _BA, _NOMINAL = at.POSITION, at.VELOCITY, at.ATTITUDE, at.FORCE_BIAS, at.NOMINAL
_EP, _EU, _ET, _EA, _ERRORS = at.E_POSITION, at.E_VELOCITY, at.E_ATTITUDE, at.E_FORCE, at.ERRORS
_SIGNALS = at.SIGNALS


@dataclass(frozen=True)
class SmoothedPose:
    """Pose over the K ticks of a recording, from all of it.

    Attributes
    ----------
    position_m : ndarray, shape (K, 3)
    q_source_sensor : ndarray, shape (K, 4)
    velocity_mps : ndarray, shape (K, 3)
    covariance : ndarray, shape (K, 6, 6)
        As in `RelativeResult`.
    valid : ndarray of bool, shape (K,)
        From the first burst on.
    redistributed_position_m : ndarray, shape (K, 3)
        The filter's position with each correction spread over the interval before it (F-17), for comparison.
    filtered : RelativeResult
        What the filter said.
    """

    position_m: Float
    q_source_sensor: Float
    velocity_mps: Float
    covariance: Float
    valid: NDArray[np.bool_]
    redistributed_position_m: Float
    filtered: RelativeResult


@step("void(float64[::1], float64[::1], float64[::1])")
def difference(a: Float, b: Float, out: Float) -> None:
    """Write the error that, taken out of b, gives a: estimate minus truth with b as the estimate."""
    for i in range(3):
        out[_EP + i] = b[_P + i] - a[_P + i]
        out[_EU + i] = b[_U + i] - a[_U + i]
    q = multiply(a[_Q], -a[_Q + 1], -a[_Q + 2], -a[_Q + 3], b[_Q], b[_Q + 1], b[_Q + 2], b[_Q + 3])
    out[_ET], out[_ET + 1], out[_ET + 2] = logarithm(q[0], q[1], q[2], q[3])
    for i in range(_ERRORS - _EA):
        out[_EA + i] = a[_BA + i] - b[_BA + i]


@kernel(
    "void(float64[:, ::1], boolean[::1], boolean[::1], float64[:, ::1], float64[:, :, ::1], float64[::1],"
    "float64[:, ::1], float64[:, :, ::1], float64[:, ::1])"
)
def backward(
    samples: Float,
    restarted: NDArray[np.bool_],
    valid: NDArray[np.bool_],
    nominal: Float,
    covariance: Float,
    settings: Float,
    smoothed: Float,
    smoothed_covariance: Float,
    before: Float,
) -> None:
    """Run backward over the filter's states; `before` takes the states ahead of the corrections of their tick.

    Rauch-Tung-Striebel with the a priori covariance and differences on the manifold (method page, C4 2.4).
    """
    count, n = len(samples), covariance.shape[1]
    work, back, prior = np.empty((3, n, n)), np.empty((3, n, n)), np.empty((n, n))
    signals, error, moved = np.empty(_SIGNALS), np.empty(n), np.empty(n)
    t, published = settings[_T], settings[_PUBLISHED] > 0.0
    for k in range(count - 1, -1, -1):
        for i in range(nominal.shape[1]):
            smoothed[k, i] = nominal[k, i]
        smoothed_covariance[k, :, :] = covariance[k]
        if k == count - 1 or restarted[k + 1] or not valid[k]:
            continue
        state = before[k + 1]
        for i in range(nominal.shape[1]):
            state[i] = nominal[k, i]
        corrected(state, samples[k], samples[k + 1], signals)
        prior[:, :] = covariance[k]
        predict(state, signals, settings, settings[_FORCE], settings[_RATE], prior, work)
        mechanise(state, signals, t, published)
        relax(state, settings)
        difference(smoothed[k + 1], state, error)
        phi = work[1]
        if step_back(smoothed_covariance[k], phi, prior, smoothed_covariance[k + 1], error, moved, back):
            inject(smoothed[k], moved)


def smooth_relative_pose(
    source: Source, chunk: RelativeChunk, parameters: Mapping[str, Any] | None = None
) -> SmoothedPose:
    """Estimate the pose from a whole recording, with its pulses where they were.

    Parameters
    ----------
    chunk : RelativeChunk
        The recording, from tick 0, coil states included.
    parameters : mapping, optional
        As for `RelativePoseFilter`.
    """
    return smooth_table(source, chunk.time_step_s, chunk.table(), parameters)


def smooth_table(
    source: Source,
    time_step_s: float,
    samples: Float,
    parameters: Mapping[str, Any] | None = None,
    start: tuple[Float, Float, Float] | None = None,
) -> SmoothedPose:
    """Do the same with samples as a table, shape (K, 17); `start` is a known pose as in `set_pose`."""
    samples = np.ascontiguousarray(samples, dtype=np.float64)
    relative = RelativePoseFilter(source, time_step_s, parameters)
    if start is not None:
        relative.set_pose(*start)
    count = len(samples)
    out = np.empty((count, at.OUTPUT))
    nominal, covariance = np.empty((count, _NOMINAL)), np.empty((count, _ERRORS, _ERRORS))
    restarted, valid = np.zeros(count, dtype=np.bool_), np.zeros(count, dtype=np.bool_)
    _, settings, state, spread, _, counters, _ = relative.arrays()
    for k in range(count):
        before_tick = int(counters[at.RESTARTED])
        out[k] = relative.run(samples[k : k + 1])[0]
        nominal[k], covariance[k], valid[k] = state, spread, counters[at.STARTED] > 0
        restarted[k] = counters[at.RESTARTED] > before_tick
    held = samples.copy()
    _hold(held)
    smoothed, before = np.empty_like(nominal), nominal.copy()
    smoothed_covariance = np.empty_like(covariance)
    backward(held, restarted, valid, nominal, covariance, settings, smoothed, smoothed_covariance, before)
    filtered = RelativeResult.of_table(out)
    updates = np.isfinite(filtered.nis) | restarted
    return SmoothedPose(
        smoothed[:, _P : _P + 3],
        rotation.positive(smoothed[:, _Q : _Q + 4]),
        smoothed[:, _U : _U + 3],
        smoothed_covariance[:, at.POSE[:, None], at.POSE[None, :]],
        valid,
        _redistribute(nominal[:, _P : _P + 3], before[:, _P : _P + 3], updates & ~restarted, restarted),
        filtered,
    )


def _hold(samples: Float) -> None:
    """Put the last whole sample where one is missing, as the filter does."""
    bad = ~np.isfinite(samples[:, at.INERTIAL]).all(axis=1)
    for k in np.flatnonzero(bad):
        if k:
            samples[k, at.INERTIAL] = samples[k - 1, at.INERTIAL]
        else:
            samples[k, at.INERTIAL] = 0.0


def _redistribute(
    position: Float, before: Float, updates: NDArray[np.bool_], restarted: NDArray[np.bool_]
) -> Float:
    """Spread each correction over the interval before it with the square of time (3.12a)."""
    spread = position.copy()
    last = 0
    for k in np.flatnonzero(updates | restarted):
        if updates[k] and k > last:
            correction = position[k] - before[k]
            share = (np.arange(last + 1, k) - last) / (k - last)
            spread[last + 1 : k] += share[:, None] ** 2 * correction
        last = int(k)
    return spread
