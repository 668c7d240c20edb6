"""Markers and an inertial module of one recording: clocks, heading, lever arm, fusion and a report, all off-line."""

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from estimators import rotation
from estimators.errors import ShapeError
from estimators.optical._bridging import bridging_noise
from estimators.optical._contract import OpticalResult, Provenance
from estimators.optical._contradictions import check_result
from estimators.optical._fusion import OpticalInertialFilter
from estimators.optical._gaps import Gap, fill_by_spline, gap_report
from estimators.optical._matching import match
from estimators.optical._stretch import GapCheck, Stretch, check_gaps
from estimators.optical.alignment._clusters import Alignment
from estimators.recording import Float
from estimators.sentences import say

# Frames in a row that a sound filter does not shut out: ghosts are single.
_STREAK = 5
_WALKS = (10.0, 100.0, 300.0, 1000.0, 3000.0)


@dataclass(frozen=True)
class OpticalFusion:
    """A fused recording.

    Attributes
    ----------
    first_tick : int
        Of `result`; ticks of the inertial recording.
    result : OpticalResult
        Smoothed; NaN where there was nothing to fuse.
    filtered : OpticalResult
        Forward only: what the samples and markers up to each tick stated.
    marker_m : ndarray, shape (K, 3)
        The frames, each at its nearest tick; NaN without one.
    residual_m : ndarray, shape (K, 3)
        Marker minus fused marker at the time of the frame; NaN without one, rejected ones included.
    spline_m : ndarray, shape (K, 3)
        The markers with gaps filled by quintics, for comparison.
    gaps : list of Gap
        Their ticks count from `first_tick`.
    lever_arm_m, lever_arm_sigma_m : ndarray, shape (3,)
        From the accelerometer to the marker, sensor axes.
    heading_sigma_rad : float
        Of the start, from the movement.
    sigma_scale : float
        By how much all noise was raised so that the innovations fit their covariance; 1 when they did at once.
    mean_nis : float
        Of accepted markers; 3 is expected.
    reasons : tuple of str
        What was left out, in words.
    bridged_count : int
        Ticks whose samples were interpolated over lost packets.
    lagged : OpticalResult or None
        Of `FixedLagSmoother`, when a lag was asked for: what was reported one to two lags after each tick.
    """

    first_tick: int
    time_step_s: float
    alignment: Alignment
    result: OpticalResult
    filtered: OpticalResult
    marker_m: Float
    residual_m: Float
    spline_m: Float
    gaps: list[Gap]
    checks: list[GapCheck]
    lever_arm_m: Float
    lever_arm_sigma_m: Float
    heading_sigma_rad: float
    sigma_scale: float
    mean_nis: float
    frame_count: int
    used_count: int
    rejected_count: int
    reasons: tuple[str, ...]
    bridged_count: int
    lagged: OpticalResult | None


def _smoothed(stretches: list[Stretch]) -> tuple[list[Stretch], list[OpticalResult], float, list[str]]:
    """Smooth every stretch, again with wider markers or walks where they fit worse than stated.

    Returns also by how much the markers were widened, and reasons for people.
    """
    results = [stretch.smoothed() for stretch in stretches]
    scale = _sigma_scale(results)
    if scale > 1.2:
        stretches = [replace(s, parameters=_scaled(s.parameters, scale)) for s in stretches]
        results = [stretch.smoothed() for stretch in stretches]
    else:
        scale = 1.0
    stretches, results, walk = _with_walks(stretches, results)
    return stretches, results, scale, [say("markers.walk", times=walk)] if walk > 1.0 else []


def _gaps(result: OpticalResult, camera_time_s: Float, step: float) -> list[Gap]:
    """Return the gaps; between two frames of slow cameras there is none."""
    spacing = max(float(np.median(np.diff(camera_time_s))), 0.7 * step)
    return [gap for gap in gap_report(result, step) if gap.length_s > 1.6 * spacing]


def _counts(result: OpticalResult, marker_m: Float) -> tuple[float, int, int, int]:
    """Return the mean innovation of accepted markers, and how many were seen, used and rejected."""
    accepted = result.provenance == Provenance.MEASURED
    return (
        float(np.mean(result.nis[accepted])) if accepted.any() else float("nan"),
        int(np.isfinite(marker_m).all(axis=1).sum()),
        int(np.isin(result.provenance, (Provenance.MEASURED, Provenance.RECOVERED)).sum()),
        int((result.provenance == Provenance.REJECTED).sum()),
    )


def _after(result: OpticalResult, delay_s: Float, rate_radps: Float) -> Float:
    """Return where the marker is so much later than each tick; shapes (K, 1), (K, 3)."""
    turning = rotation.rotate(
        result.q_room_sensor, np.cross(rate_radps - result.rate_bias_radps, result.lever_arm_m)
    )
    moved = delay_s * (result.velocity_mps + turning)
    return np.asarray(result.marker_m + moved + 0.5 * delay_s**2 * result.acceleration_mps2)


def fuse_markers(
    camera_time_s: Float,
    marker_m: Float,
    time_step_s: float,
    gyroscope_radps: Float,
    accelerometer_mps2: Float,
    *,
    parameters: Mapping[str, Any] | None = None,
    lever_arm_m: Float | None = None,
    cluster_m: Float | None = None,
    largest_offset_s: float | None = None,
    bridged: NDArray[np.bool_] | None = None,
    lag_s: float | None = None,
    gap_checks: bool = True,
) -> OpticalFusion:
    """Fuse a marker with the module near it.

    Parameters
    ----------
    camera_time_s : ndarray, shape (N,)
        On the cameras' own clock.
    marker_m : ndarray, shape (N, 3)
        Laboratory with z up; NaN in gaps.
    gyroscope_radps, accelerometer_mps2 : ndarray, shape (K, 3)
        Even ticks from time zero; NaN where samples are missing.
    parameters : mapping, optional
        Of `OpticalParameters`, what differs from the defaults.
    lever_arm_m : ndarray, shape (3,), optional
        From the accelerometer to the marker in sensor axes, when it was measured; otherwise it is found.
    cluster_m : ndarray, shape (N, M, 3), optional
        Three or more markers on the same rigid body: clocks can then be aligned by the angular rate too.
    largest_offset_s : float, optional
        How far the clocks can be apart; anything by default.
    bridged : ndarray of bool, shape (K,), optional
        Samples that were interpolated over lost packets: they count as noisier, by what such a line misses elsewhere.
    lag_s : float, optional
        Also report what a smoother so far behind would have reported.
    gap_checks : bool
        Also hide seen markers and measure how well they are filled.

    Raises
    ------
    ComparisonError
        The streams do not show the same movement, or too little of it; the message says what to do.
    ContradictionError
        They do, but the markers are mirrored, have another axis up or another unit, or too much of them does not fit.
    """
    camera_time_s, marker_m = np.asarray(camera_time_s, np.float64), np.asarray(marker_m, np.float64)
    count = len(gyroscope_radps)
    if accelerometer_mps2.shape != (count, 3) or gyroscope_radps.shape != (count, 3):
        raise ShapeError(f"gyroscope and accelerometer both need shape ({count}, 3)")
    samples = gyroscope_radps, accelerometer_mps2
    noise, stated = _noise(*samples, time_step_s, bridged, parameters)
    found, stretches, reasons, on_ticks, delay = match(
        camera_time_s, marker_m, time_step_s, *samples, parameters,
        lever_arm_m, cluster_m, largest_offset_s, noise,
    )  # fmt: skip
    stretches, results, scale, widened = _smoothed(stretches)
    reasons += [*stated, *widened]
    first = stretches[0].first
    total = stretches[-1].first + len(stretches[-1].chunk.marker_m) - first
    part, time_s = slice(first, first + total), np.arange(first, first + total) * time_step_s
    # What the clocks may be apart moves a marker along its path.
    clocks = np.hypot(found.offset_sigma_s, (time_s - found.reference_s)[:, None] * found.drift_sigma)

    def whole(pieces: list[OpticalResult]) -> OpticalResult:
        return _with_clocks(_joined(stretches, pieces, first, total), clocks)

    result = whole(results)
    residual = on_ticks[part] - _after(result, delay[part, None], gyroscope_radps[part])
    last = results[0].lever_arm_m[-1], results[0].lever_arm_sigma_m[-1]
    check_result(residual, result.provenance, last[0], lever_arm_m is not None)
    return OpticalFusion(
        first,
        time_step_s,
        found,
        result,
        whole([stretch.filtered() for stretch in stretches]),
        on_ticks[part],
        residual,
        fill_by_spline(on_ticks[part], time_step_s),
        _gaps(result, camera_time_s, time_step_s),
        check_gaps(stretches[0]) if gap_checks else [],
        last[0],
        last[1],
        stretches[0].mounting.heading_sigma_rad,
        scale,
        *_counts(result, marker_m),
        tuple(reasons),
        0 if bridged is None else int(bridged[part].sum()),
        None if lag_s is None else whole([stretch.lagged(lag_s) for stretch in stretches]),
    )


def _noise(
    gyroscope: Float,
    accelerometer: Float,
    step: float,
    bridged: NDArray[np.bool_] | None,
    parameters: Mapping[str, Any] | None,
) -> tuple[Float | None, list[str]]:
    if bridged is None or not bridged.any():
        return None, []
    known = OpticalInertialFilter(step, parameters).parameters
    both = [
        bridging_noise(values, bridged, known[name], step)
        for values, name in ((gyroscope, "rate_sigma_radps"), (accelerometer, "force_sigma_mps2"))
    ]
    words = say("markers.bridged", lost_s=float(bridged.sum()) * step, count=both[0][1])
    return np.column_stack([noise for noise, _ in both]), [words]


def _with_clocks(result: OpticalResult, apart_s: Float) -> OpticalResult:
    sigma = np.hypot(result.position_sigma_m, np.abs(result.velocity_mps) * apart_s)
    return replace(result, position_sigma_m=sigma)


def _sigma_scale(results: list[OpticalResult]) -> float:
    nis = np.concatenate(
        [r.nis[np.isin(r.provenance, (Provenance.MEASURED, Provenance.REJECTED))] for r in results]
    )
    # The median of chi-square with three degrees of freedom is 2.366; ghosts do not move it.
    return float(np.sqrt(np.median(nis) / 2.366)) if len(nis) > 20 else 1.0


def _with_walks(
    stretches: list[Stretch], results: list[OpticalResult]
) -> tuple[list[Stretch], list[OpticalResult], float]:
    """Let offsets change faster while sound markers are shut out.

    A scale or alignment error of a sensor acts as an offset that changes with attitude. With the page's walks the
    filter is then too sure after a gap, and shuts out all markers until it gives in.
    """
    best, walk = _shut_out(results), 1.0
    first = stretches
    for factor in _WALKS:
        if best == 0:
            break
        tried = [replace(s, parameters=_scaled(s.parameters, factor, _BIAS_WALKS)) for s in first]
        found = [stretch.smoothed() for stretch in tried]
        count = _shut_out(found)
        if count < best:
            stretches, results, best, walk = tried, found, count, factor
    return stretches, results, walk


def _shut_out(results: list[OpticalResult]) -> int:
    """Count markers that were shut out in long rows."""
    count = 0
    for result in results:
        seen = result.provenance[result.provenance >= Provenance.MEASURED]
        missed = np.concatenate([[0], (seen == Provenance.REJECTED).astype(np.int8), [0]])
        lengths = np.diff(np.flatnonzero(np.diff(missed)).reshape(-1, 2), axis=1)
        count += int(lengths[lengths >= _STREAK].sum())
    return count


_BIAS_WALKS = ("force_walk", "rate_walk")
_ALL_NOISE = ("force_sigma_mps2", "rate_sigma_radps", "marker_sigma_m", *_BIAS_WALKS)


def _scaled(parameters: dict[str, Any], scale: float, names: tuple[str, ...] = _ALL_NOISE) -> dict[str, Any]:
    defaults = OpticalInertialFilter(0.01, parameters).parameters
    return {**parameters, **{name: scale * float(defaults[name]) for name in names}}


def _joined(stretches: list[Stretch], results: list[OpticalResult], first: int, total: int) -> OpticalResult:
    values: dict[str, NDArray[Any]] = {}
    for field in fields(OpticalResult):
        one = getattr(results[0], field.name)
        whole = (
            np.full((total, *one.shape[1:]), np.nan) if one.dtype.kind == "f" else np.zeros(total, one.dtype)
        )
        if field.name == "q_room_sensor":
            whole[:] = rotation.identity()
        for stretch, result in zip(stretches, results, strict=True):
            begin = stretch.first + stretch.start_tick - first
            part = getattr(result, field.name)
            whole[begin : begin + len(part)] = part
        values[field.name] = whole
    return OpticalResult(**values)
