"""Marker positions and an inertial module together: live filter, smoother, gaps (Roetenberg 2006, chapter 4)."""

import math
from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np

from estimators import rotation
from estimators.conventions import GRAVITY_MPS2
from estimators.errors import SetupError, ShapeError
from estimators.kernels.array_filter import ArrayFilter, with_overrides
from estimators.optical import _kernel as kernel
from estimators.optical import _layout as at
from estimators.optical._contract import OpticalChunk, OpticalParameters, OpticalResult, OpticalStart
from estimators.recording import Float

_RATE, _FORCE = slice(at.GYROSCOPE, at.ACCELEROMETER), slice(at.ACCELEROMETER, at.MARKER)

_PIECE = 6000
"""Ticks whose covariances are held at a time."""


def _read(parameters: Mapping[str, Any] | None) -> OpticalParameters:
    result = with_overrides(OpticalParameters(), parameters)
    for name in ("force_sigma_mps2", "rate_sigma_radps", "marker_sigma_m", "gate", "start_s"):
        if not getattr(result, name) > 0.0:
            raise SetupError(f"{name} must be above zero")
    return result


class OpticalInertialFilter(ArrayFilter):
    """Error-state filter of position, velocity, attitude and biases; a marker corrects when it is seen.

    The same samples give the same result, bit for bit, one by one, in chunks, or across `state` and `restore`.
    """

    name: ClassVar[str] = "optical_inertial"
    version: ClassVar[str] = "3"
    _ARRAYS: ClassVar[tuple[str, ...]] = ("nominal", "covariance", "memory", "start", "counters")

    def __init__(self, time_step_s: float, parameters: Mapping[str, Any] | None = None) -> None:
        if not 1e-4 < time_step_s < 0.1:
            raise SetupError(f"time_step_s must be between 0.1 ms and 100 ms, not {time_step_s}")
        self._parameters, self._time_step_s = _read(parameters), time_step_s
        p = self._parameters
        self._settings = np.array(
            [
                time_step_s,
                GRAVITY_MPS2,
                p.force_sigma_mps2,
                p.rate_sigma_radps,
                p.marker_sigma_m,
                p.force_walk,
                p.rate_walk,
                p.gate,
                max(1.0, round(p.recover_s / time_step_s)),
            ]
        )
        self._nominal, self._covariance = np.zeros(at.NOMINAL), np.zeros((at.ERRORS, at.ERRORS))
        self._nominal[at.ATTITUDE] = 1.0
        self._nominal[at.LEVER :] = p.lever_arm_m
        self._memory, self._start = np.zeros(at.MEMORY), np.zeros(at.SAMPLE)
        # Ticks taken, ticks of standstill, whether started.
        self._counters = np.zeros(3, dtype=np.int64)

    def update(self, chunk: OpticalChunk) -> OpticalResult:
        """Take the next ticks; `chunk.first_tick` must continue the last one."""
        if chunk.first_tick != int(self._counters[0]):
            raise ShapeError(f"tick {chunk.first_tick} does not follow {int(self._counters[0]) - 1}")
        if abs(chunk.time_step_s - self._time_step_s) > 1e-9:
            raise ShapeError(f"the filter was built for {self._time_step_s} s, not {chunk.time_step_s} s")
        return to_result(*self.run(chunk.table()))

    def begin(self, start: OpticalStart) -> None:
        """Begin from a known state, valid at the next tick; instead of a standstill."""
        self._nominal[: at.VELOCITY] = start.position_m
        self._nominal[at.VELOCITY : at.ATTITUDE] = start.velocity_mps
        self._nominal[at.ATTITUDE : at.FORCE_BIAS] = rotation.normalize(start.q_room_sensor)
        self._nominal[at.RATE_BIAS : at.LEVER] = start.rate_bias_radps
        tilt = start.tilt_sigma_rad
        self._begin(
            [start.position_sigma_m] * 3
            + [start.velocity_sigma_mps] * 3
            + [tilt, tilt, start.heading_sigma_rad]
        )
        # Nothing leads to this tick: the first sample is not integrated.
        self._memory[0] = np.nan

    def _begin(self, sigma: list[float]) -> None:
        p = self._parameters
        rest = [p.force_bias_sigma_mps2, p.rate_bias_sigma_radps, p.lever_arm_sigma_m]
        self._covariance[:] = np.diag(np.concatenate([sigma, np.repeat(rest, 3)]) ** 2)
        self._counters[2] = 1

    def run(self, samples: Float, covariances: Float | None = None) -> tuple[Float, Float]:
        """Return states and details of samples given as a table; fill `covariances`, shape (K, 18, 18), if given."""
        count = len(samples)
        states = np.full((count, at.NOMINAL), np.nan)
        out = np.full((count, at.OUTPUT), np.nan)
        out[:, at.O_STATE] = at.BEFORE
        k = 0
        while k < count and not self._counters[2]:
            self._gather(samples[k])
            k += 1
        if k < count:
            room = np.empty((0, at.ERRORS, at.ERRORS)) if covariances is None else covariances[k:]
            kernel.run(
                samples[k:],
                self._settings,
                self._nominal,
                self._covariance,
                self._memory,
                states[k:],
                room,
                out[k:],
            )
        self._counters[0] += count
        return states, out

    def _gather(self, sample: Float) -> None:
        """Take a sample of the standstill; start when there are enough (page 2.5)."""
        still = np.linalg.norm(sample[_RATE]) < 0.2
        still = still and abs(np.linalg.norm(sample[_FORCE]) - GRAVITY_MPS2) < 0.5
        if not still or not np.isfinite(sample).all():
            self._counters[1] = 0
            self._start[:] = 0.0
            return
        self._start += sample
        self._counters[1] += 1
        p = self._parameters
        if self._counters[1] < round(p.start_s / self._time_step_s):
            return
        mean = self._start / self._counters[1]
        q = rotation.shortest(mean[_FORCE], np.array([0.0, 0.0, 1.0]))
        heading, level = rotation.split_heading(q)
        del heading
        q = rotation.multiply(rotation.about_z(p.heading_rad), level)
        self._nominal[at.ATTITUDE : at.FORCE_BIAS] = q
        self._nominal[:3] = mean[at.MARKER : at.DELAY] - rotation.rotate(q, np.array(p.lever_arm_m))
        self._nominal[at.RATE_BIAS : at.LEVER] = mean[_RATE]
        tilt = math.radians(1.0)
        # A lever arm that is not known yet makes the place of the accelerometer uncertain too.
        place = math.hypot(1e-3, p.lever_arm_sigma_m)
        self._begin([place] * 3 + [1e-2] * 3 + [tilt, tilt, math.radians(p.heading_sigma_deg)])
        self._memory[: at.SAMPLE] = sample

    @property
    def settings(self) -> Float:
        """Settings of the compiled loop."""
        return self._settings


def to_result(states: Float, out: Float) -> OpticalResult:
    """Put the arrays of the compiled loop into a result."""
    q = states[:, at.ATTITUDE : at.FORCE_BIAS]
    q = np.where(np.isnan(q[:, :1]), rotation.identity(), q)
    lever = states[:, at.LEVER :]
    sigma = out[:, at.O_SIGMA :]
    return OpticalResult(
        states[:, :3],
        states[:, at.VELOCITY : at.ATTITUDE],
        out[:, : at.O_NIS],
        q,
        states[:, :3] + rotation.rotate(q, lever),
        lever,
        states[:, at.FORCE_BIAS : at.RATE_BIAS],
        states[:, at.RATE_BIAS : at.LEVER],
        sigma[:, : at.E_VELOCITY],
        sigma[:, at.E_VELOCITY : at.E_ATTITUDE],
        sigma[:, at.E_ATTITUDE : at.E_FORCE],
        sigma[:, at.E_LEVER :],
        out[:, at.O_INNOVATION : at.O_SIGMA],
        out[:, at.O_NIS],
        out[:, at.O_STATE].astype(np.uint8),
    )


def smooth_optical(
    chunk: OpticalChunk,
    parameters: Mapping[str, Any] | None = None,
    start: OpticalStart | None = None,
) -> OpticalResult:
    """Estimate from a whole recording: the filter, then backward (fixed interval).

    Parameters
    ----------
    parameters : mapping, optional
        Of `OpticalParameters`, what differs from the defaults.
    start : OpticalStart, optional
        At the first tick; by default the recording must hold a standstill with the marker in sight.

    Returns
    -------
    OpticalResult
        Smoothed; `nis` and `provenance` are those of the filter.
    """
    return filter_and_smooth(chunk, parameters, start)[1]


def filter_and_smooth(
    chunk: OpticalChunk,
    parameters: Mapping[str, Any] | None = None,
    start: OpticalStart | None = None,
) -> tuple[OpticalResult, OpticalResult]:
    """Return what the filter gives and what `smooth_optical` makes of it, for little more than the latter.

    Notes
    -----
    Covariances are retained for a minute at a time only: the filter runs a second time, piece by piece from the last to
    the first, from the states it had there. The result is that of one piece, bit for bit.
    """
    live = OpticalInertialFilter(chunk.time_step_s, parameters)
    if start is not None:
        live.begin(start)
    samples = chunk.table()
    count = len(samples)
    marks, states, out = [], np.empty((count, at.NOMINAL)), np.empty((count, at.OUTPUT))
    retained = np.empty((count, at.ERRORS, at.ERRORS)) if count <= _PIECE else None
    for begin in range(0, count, _PIECE):
        marks.append((begin, live.state()))
        end = begin + _PIECE
        states[begin:end], out[begin:end] = live.run(samples[begin:end], retained)
    begun = np.flatnonzero(np.isfinite(states[:, 0]))
    filtered = to_result(states.copy(), out.copy())
    if not len(begun):
        return filtered, to_result(states, out)
    first, later, later_covariance = int(begun[0]), np.empty(at.NOMINAL), np.empty((at.ERRORS, at.ERRORS))
    for begin, mark in reversed(marks):
        end = min(begin + _PIECE, count)
        if end <= first:
            break
        covariances = np.empty((end - begin, at.ERRORS, at.ERRORS)) if retained is None else retained
        if retained is None:
            live.restore(mark)
            live.run(samples[begin:end], covariances)
        part = slice(max(begin, first), end)
        kernel.backward(
            samples[part.start : end + 1],
            live.settings,
            states[part],
            covariances[part.start - begin :],
            out[part.start : end + 1],
            later,
            later_covariance,
            end == count,
        )
    return filtered, to_result(states, out)
