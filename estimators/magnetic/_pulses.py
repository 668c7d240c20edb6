"""Pulse values out of a sampled magnetometer: the earth's field taken away, sensor motion carried by the gyroscope.

A pulse value is the mean of the samples while a coil is on, less the mean of those around it (Schepers and Veltink
2010, 2.4; Roetenberg 2006, 5.2). Samples next to an edge are left out (eddy currents, sampling across the edge).
A turning sensor sees the earth's field turn by more than most pulses are strong (errata E9): every sample is first
turned into the axes of the middle of the pulse.
"""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from estimators import rotation
from estimators._kernels import exponential, kernel, multiply, normalized
from estimators.errors import SetupError, ShapeError
from estimators.magnetic._measurement import MAGNETOMETER_SIGMA_T
from estimators.recording import Float

_SHORT = 3
"""Pulses of no more samples keep their edges: nothing would be left (method page, erratum X8)."""


@dataclass(frozen=True)
class Pulse:
    """One pulse as the sensor saw it.

    Attributes
    ----------
    start, stop : int
        Samples of the coil being on, half open.
    middle : int
        Sample in whose axes the value is.
    field_sensor_t : ndarray, shape (3,)
    covariance : ndarray, shape (3, 3)
    spread_t : float
        Standard deviation of the on samples about their mean, all axes: far above the noise is motion.
    saturated : bool
        A sample that was used is at full scale.
    ambient_sensor_t : ndarray, shape (3,)
        What was taken away: the mean of the off samples, in the axes of the middle.
    on, off : ndarray of int
        Samples that were used.
    """

    coil: int
    current_a: float
    start: int
    stop: int
    middle: int
    field_sensor_t: Float
    covariance: Float
    spread_t: float
    saturated: bool = False
    ambient_sensor_t: Float = field(default_factory=lambda: np.zeros(3))
    on: NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    off: NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, dtype=np.int64))


@kernel("void(float64[:, ::1], float64, float64[:, ::1])")
def _integrate(gyroscope_radps: Float, time_step_s: float, attitude: Float) -> None:
    attitude[0, 0] = 1.0
    attitude[0, 1] = attitude[0, 2] = attitude[0, 3] = 0.0
    half = 0.5 * time_step_s
    for i in range(1, gyroscope_radps.shape[0]):
        a, b, before = gyroscope_radps[i - 1], gyroscope_radps[i], attitude[i - 1]
        turn = exponential(half * (a[0] + b[0]), half * (a[1] + b[1]), half * (a[2] + b[2]))
        q = multiply(before[0], before[1], before[2], before[3], turn[0], turn[1], turn[2], turn[3])
        q = normalized(q[0], q[1], q[2], q[3])
        attitude[i, 0], attitude[i, 1], attitude[i, 2], attitude[i, 3] = q[0], q[1], q[2], q[3]


def integrate_gyroscope(gyroscope_radps: ArrayLike, time_step_s: float) -> Float:
    """Return the attitude of every sample against the first, `q_first_sample`, shape (N, 4)."""
    rate = np.ascontiguousarray(gyroscope_radps, dtype=np.float64)
    if rate.ndim != 2 or rate.shape[1] != 3 or not len(rate):
        raise ShapeError(f"the gyroscope needs shape (N, 3), not {rate.shape}")
    attitude = np.empty((len(rate), 4))
    _integrate(rate, time_step_s, attitude)
    return attitude


def extract_pulses(
    magnetometer_t: ArrayLike,
    coil_state: ArrayLike,
    current_a: ArrayLike,
    attitude: Float | None,
    before: int = 9,
    after: int = 8,
    magnetometer_sigma_t: float = MAGNETOMETER_SIGMA_T,
    full_scale_t: float = np.inf,
    reach: int = 60,
) -> list[Pulse]:
    """Read the pulses of a recording whose coil commands are known.

    Parameters
    ----------
    magnetometer_t : array_like, shape (N, 3)
        Sensor axes.
    coil_state : array_like of int, shape (N,)
        0 off, otherwise the number of the coil plus one.
    current_a : array_like, shape (N,) or scalar
    attitude : ndarray, shape (N, 4), or None
        From `integrate_gyroscope`; None subtracts the plain mean of the neighbours, which only a still sensor bears.
    before, after : int
        Most samples of the baseline on each side; on samples and their neighbours are left out.
    full_scale_t : float
        Saturation of an axis.
    reach : int
        Samples farther than this from the pulse are not used.

    Returns
    -------
    list of Pulse
        Pulses without a usable sample on either count are left out.
    """
    measured = np.asarray(magnetometer_t, dtype=np.float64)
    state = np.asarray(coil_state)
    if measured.ndim != 2 or measured.shape[1:] != (3,) or state.shape != (len(measured),):
        raise ShapeError("the magnetometer needs shape (N, 3) and the coil state shape (N,)")
    if before < 0 or after < 0 or before + after < 1:
        raise SetupError("the baseline needs one sample or more")
    currents = np.broadcast_to(np.asarray(current_a, dtype=np.float64), state.shape)
    on: NDArray[np.bool_] = np.asarray(state > 0)
    guarded: NDArray[np.bool_] = np.array(on)
    guarded[1:] |= on[:-1]
    guarded[:-1] |= on[1:]
    finite: NDArray[np.bool_] = np.asarray(np.isfinite(measured).all(axis=1))
    quiet: NDArray[np.bool_] = np.asarray(~guarded & finite)
    edges = np.flatnonzero(np.diff(np.concatenate([[0], state, [0]])))
    found = []
    for start, stop in itertools.pairwise(edges.tolist()):
        if not on[start]:
            continue
        inner = np.arange(start, stop) if stop - start <= _SHORT else np.arange(start + 1, stop - 1)
        inner = inner[finite[inner]]
        low, high = max(0, start - reach), min(len(measured), stop + reach)
        ahead = low + np.flatnonzero(quiet[low:start])
        behind = stop + np.flatnonzero(quiet[stop:high])
        outer = np.concatenate([ahead[max(0, len(ahead) - before) :], behind[:after]])
        if not len(inner) or not len(outer):
            continue
        middle = int(start + stop - 1) // 2
        inside, outside = measured[inner], measured[outer]
        if attitude is not None:
            back = rotation.conjugate(attitude[middle])
            inside = rotation.rotate(rotation.multiply(back, attitude[inner]), inside)
            outside = rotation.rotate(rotation.multiply(back, attitude[outer]), outside)
        found.append(
            Pulse(
                int(state[start]) - 1,
                float(currents[start:stop].mean()),
                int(start),
                int(stop),
                middle,
                np.asarray(inside.mean(axis=0) - outside.mean(axis=0)),
                magnetometer_sigma_t**2 * (1.0 / len(inner) + 1.0 / len(outer)) * np.eye(3),
                float(np.sqrt(np.mean(np.var(inside, axis=0, ddof=1)))) if len(inner) > 1 else 0.0,
                bool(np.any(np.abs(measured[np.concatenate([inner, outer])]) >= full_scale_t)),
                np.asarray(outside.mean(axis=0)),
                inner,
                outer,
            )
        )
    return found


def find_pulses(
    magnetometer_t: ArrayLike, width: int, magnetometer_sigma_t: float = MAGNETOMETER_SIGMA_T
) -> NDArray[np.int64]:
    """Find pulses without command times by their edges (method page 4.6 step 1), for a sensor that hardly moves.

    A step of more than 5 sqrt(2) sigma on any axis, paired with an opposite one a pulse width later.

    Returns
    -------
    ndarray of int, shape (P, 2)
        First sample on and first sample off again.
    """
    field = np.asarray(magnetometer_t, dtype=np.float64)
    if field.ndim != 2 or field.shape[1:] != (3,) or width < 1:
        raise ShapeError("the magnetometer needs shape (N, 3) and the width one sample or more")
    step = np.diff(field, axis=0)
    edges: list[int] = np.flatnonzero(
        (np.abs(step) > 5.0 * np.sqrt(2.0) * magnetometer_sigma_t).any(axis=1)
    ).tolist()
    edges = [edge + 1 for edge in edges]
    pairs: list[tuple[int, int]] = []
    last = -1
    for start in edges:
        if start <= last:
            continue
        for stop in (start + width, start + width - 1, start + width + 1):
            if stop in edges and step[start - 1] @ step[stop - 1] < 0.0:
                pairs.append((start, stop))
                last = stop
                break
    return np.array(pairs, dtype=np.int64).reshape(-1, 2)


def bursts(pulses: Sequence[Pulse], coils: int = 3, longest: int = 60) -> list[list[Pulse]]:
    """Gather pulses into bursts in which every coil was on once, within so many samples."""
    found: list[list[Pulse]] = []
    group: list[Pulse] = []
    for pulse in pulses:
        group = [p for p in group if p.coil != pulse.coil and pulse.stop - p.start <= longest]
        group.append(pulse)
        if len({p.coil for p in group}) == coils:
            found.append(sorted(group, key=lambda p: p.coil))
            group = []
    return found
