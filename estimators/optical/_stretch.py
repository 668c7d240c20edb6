"""Stretches of a recording that can be fused: consecutive samples with markers, how to begin, how well gaps fill."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from estimators import rotation
from estimators.errors import ComparisonError
from estimators.optical._attitude import level_attitude
from estimators.optical._contract import OpticalChunk, OpticalResult, OpticalStart
from estimators.optical._fusion import OpticalInertialFilter, smooth_optical
from estimators.optical._gaps import fill_by_spline
from estimators.optical._lag import smooth_with_lag
from estimators.optical.alignment._mounting import (
    Accelerations,
    Mounting,
    accelerations,
    find_mounting,
    start_at,
)
from estimators.optical.alignment._signals import without_ghosts
from estimators.recording import Float
from estimators.sentences import say

_LEAST_S = 3.0
_CHECKED_TICKS = 12_000
CHECKED_GAPS_S = (0.1, 0.5, 1.0, 2.0)


@dataclass(frozen=True)
class GapCheck:
    """Markers that were seen are hidden, filled, and compared with what was seen.

    Attributes
    ----------
    count : int
        Gaps of this length.
    inertial_m, spline_m : float
        Mean over gaps of the largest distance from the marker.
    within_three_sigma : float
        Part of the components of the inertial error.
    """

    length_s: float
    count: int
    inertial_m: float
    spline_m: float
    within_three_sigma: float


@dataclass(frozen=True)
class Stretch:
    """Consecutive ticks with inertial samples, their markers, and how to begin."""

    first: int
    chunk: OpticalChunk
    mounting: Mounting
    start_tick: int
    parameters: dict[str, Any]
    camera_time_s: Float
    camera_marker_m: Float

    def smoothed(self, chunk: OpticalChunk | None = None) -> OpticalResult:
        """Fuse it, or the same with other markers."""
        chunk = self.chunk if chunk is None else chunk
        return smooth_optical(self._begun(chunk), self.parameters, self._start(chunk))

    def accelerations(self) -> Accelerations:
        """Return what the marker showed and the module felt."""
        return accelerations(
            self.chunk.accelerometer_mps2,
            self.mounting.q_room_sensor,
            self.chunk.time_step_s,
            self.camera_time_s,
            self.camera_marker_m,
        )

    def filtered(self) -> OpticalResult:
        """Fuse it forward only: what was known at each tick of the samples and markers up to it."""
        live = OpticalInertialFilter(self.chunk.time_step_s, self.parameters)
        start = self._start(self.chunk)
        if start is not None:
            live.begin(start)
        return live.update(self._begun(self.chunk))

    def lagged(self, lag_s: float) -> OpticalResult:
        """Fuse it as a smoother so far behind would have reported it."""
        return smooth_with_lag(self._begun(self.chunk), lag_s, self.parameters, self._start(self.chunk))

    def _begun(self, chunk: OpticalChunk) -> OpticalChunk:
        return replace(chunk.ticks(self.start_tick, len(chunk.marker_m)), first_tick=0)

    def _start(self, chunk: OpticalChunk) -> OpticalStart | None:
        return start_at(
            self.start_tick,
            chunk.time_step_s,
            self.mounting,
            chunk.gyroscope_radps,
            self.camera_time_s,
            self.camera_marker_m,
            self.parameters.get("marker_sigma_m", 0.0005),
        )


def onto_ticks(time_s: Float, marker_m: Float, time_step_s: float, count: int) -> tuple[Float, Float]:
    """Give each tick the frame nearest to it, if one lies within half a step, and how much later that is."""
    placed, delay = np.full((count, 3), np.nan), np.zeros(count)
    tick = np.rint(time_s / time_step_s).astype(np.int64)
    apart = time_s - tick * time_step_s
    good = np.isfinite(marker_m).all(axis=1) & (tick >= 0) & (tick < count)
    # The nearest of several is written last.
    order = np.flatnonzero(good)[np.argsort(-np.abs(apart[good]), kind="stable")]
    placed[tick[order]], delay[tick[order]] = marker_m[order], apart[order]
    return placed, delay


def prepare(
    gyroscope: Float,
    accelerometer: Float,
    step: float,
    on_ticks: Float,
    delay: Float,
    at: Float,
    marker: Float,
    parameters: Mapping[str, Any] | None,
    lever: Float | None,
    attitudes: dict[tuple[int, int], tuple[Float, Float]],
    noise: Float | None = None,
) -> tuple[list[Stretch], list[str]]:
    """Return what can be fused, and of the rest why not; attitudes of stretches are remembered for a next time."""
    seen = np.flatnonzero(np.isfinite(on_ticks).all(axis=1))
    if not len(seen):
        raise ComparisonError(say("markers.none_inside"))
    stretches: list[Stretch] = []
    reasons: list[str] = []
    for first, stop in _stretches(gyroscope, accelerometer, int(seen[0]), int(seen[-1]) + 1):
        part = slice(first, stop)
        chunk = OpticalChunk(
            0,
            step,
            gyroscope[part],
            accelerometer[part],
            on_ticks[part],
            delay[part],
            None if noise is None else noise[part],
        )
        try:
            stretches.append(_prepared(first, chunk, at, marker, parameters, lever, attitudes))
        except ComparisonError as error:
            reasons.append(
                say("markers.stretch", start_s=first * step, stop_s=stop * step, reason=error.message)
            )
    if not stretches:
        raise ComparisonError(reasons[0])
    return stretches, reasons


def _prepared(
    first: int,
    chunk: OpticalChunk,
    camera_inertial_s: Float,
    marker_m: Float,
    parameters: Mapping[str, Any] | None,
    lever_arm_m: Float | None,
    attitudes: dict[tuple[int, int], tuple[Float, Float]],
) -> Stretch:
    step = chunk.time_step_s
    count = len(chunk.marker_m)
    if count * step < _LEAST_S:
        raise ComparisonError(say("markers.short_stretch", least_s=_LEAST_S))
    time = camera_inertial_s - first * step
    inside = (time >= 0.0) & (time <= (count - 1) * step)
    # One ghost near the start would throw the filter far off.
    time, marker = time[inside], without_ghosts(marker_m[inside])
    key = first, first + count
    if key not in attitudes:
        attitudes[key] = level_attitude(chunk.gyroscope_radps, chunk.accelerometer_mps2, step)
    mounting = find_mounting(
        chunk.gyroscope_radps, chunk.accelerometer_mps2, step, time, marker, lever_arm_m, attitudes[key]
    )
    given = dict(parameters or {})
    given["lever_arm_m"] = tuple(float(x) for x in mounting.lever_arm_m)
    if lever_arm_m is None:
        given["lever_arm_sigma_m"] = float(np.hypot(0.005, 2.0 * mounting.lever_arm_sigma_m.max()))
    sigma = given.get("marker_sigma_m", 0.0005)
    for tick in np.flatnonzero(np.isfinite(chunk.marker_m).all(axis=1)).tolist():
        if start_at(tick, step, mounting, chunk.gyroscope_radps, time, marker, sigma) is not None:
            OpticalInertialFilter(step, given)  # a wrong parameter is reported now
            return Stretch(first, chunk, mounting, tick, given, time, marker)
    raise ComparisonError(say("markers.six_frames"))


def _stretches(gyroscope: Float, accelerometer: Float, first: int, stop: int) -> list[tuple[int, int]]:
    measured: NDArray[np.bool_] = np.asarray(np.isfinite(np.hstack([gyroscope, accelerometer])).all(axis=1))
    edges = np.flatnonzero(np.diff(np.concatenate([[0], measured[first:stop].astype(np.int8), [0]]))) + first
    return [(int(a), int(b)) for a, b in edges.reshape(-1, 2)]


def check_gaps(stretch: Stretch) -> list[GapCheck]:
    chunk, found = stretch.chunk, []
    step = chunk.time_step_s
    if len(chunk.marker_m) > stretch.start_tick + _CHECKED_TICKS:
        stretch = replace(stretch, chunk=chunk.ticks(0, stretch.start_tick + _CHECKED_TICKS))
        chunk = stretch.chunk
    seen: NDArray[np.bool_] = np.asarray(np.isfinite(chunk.marker_m).all(axis=1))
    for length_s in CHECKED_GAPS_S:
        length = max(1, round(length_s / step))
        margin = max(10, round(0.3 / step))
        apart = max(4 * length, round(2.0 / step))
        hidden = np.zeros(len(seen), dtype=np.bool_)
        places = []
        # Most of the frames must be there to compare with: slower cameras see every n-th tick only.
        usual = 0.8 * seen.mean()
        for start in range(stretch.start_tick + apart, len(seen) - length - margin, apart):
            if seen[start - margin : start + length + margin].mean() >= usual:
                hidden[start : start + length] = True
                places.append(slice(start, start + length))
        if len(places) < 2:
            continue
        holed = chunk.marker_m.copy()
        holed[hidden] = np.nan
        result = stretch.smoothed(replace(chunk, marker_m=holed))
        spline = fill_by_spline(holed, step)
        largest: list[tuple[float, float]] = []
        inside: list[Float] = []
        for place in places:
            rows = np.flatnonzero(seen[place]) + place.start
            own = rows - stretch.start_tick
            turning = np.cross(
                chunk.gyroscope_radps[rows] - result.rate_bias_radps[own], result.lever_arm_m[own]
            )
            speed = result.velocity_mps[own] + rotation.rotate(result.q_room_sensor[own], turning)
            delay = chunk.marker_delay_s
            late = speed * (0.0 if delay is None else delay[rows, None])
            error = chunk.marker_m[rows] - result.marker_m[own] - late
            sigma = np.hypot(result.position_sigma_m[own], stretch.parameters.get("marker_sigma_m", 0.0005))
            inside.append(np.abs(error) < 3.0 * sigma)
            drawn = np.linalg.norm(chunk.marker_m[rows] - spline[rows] - late, axis=1)
            largest.append((float(np.linalg.norm(error, axis=1).max()), float(drawn.max())))
        inertial, drawn_by_spline = np.array(largest).T
        found.append(
            GapCheck(
                length_s,
                len(places),
                float(np.mean(inertial)),
                float(np.nanmean(drawn_by_spline)) if np.isfinite(drawn_by_spline).any() else float("nan"),
                float(np.mean(np.concatenate(inside))),
            )
        )
    return found
