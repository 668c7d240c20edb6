"""Clock of the cameras against the clock of the inertial module: offset and drift, found by correlation."""

from dataclasses import dataclass

import numpy as np
import scipy

from estimators import rotation
from estimators.conventions import GRAVITY_MPS2
from estimators.errors import ComparisonError
from estimators.optical._attitude import strapdown
from estimators.optical.alignment._signals import (
    HALF_WIDTH_S,
    correlations,
    evenly,
    linear,
    repetition,
    step_of,
    triangle,
    without_ghosts,
)
from estimators.recording import Float
from estimators.sentences import say

LEAST_CORRELATION = 0.7
"""Below this the two streams do not show the same movement."""
_LEAST_OVERLAP_S = 3.0
_DRIFT_SIGMA = 200e-6
"""What clocks may differ by, before anything is measured."""
_HALF_WIDTHS_S = (HALF_WIDTH_S, 2.0 * HALF_WIDTH_S, 4.0 * HALF_WIDTH_S)
_WINDOW_S, _LOCAL_S, _APART_S = 20.0, 0.5, 0.3


@dataclass(frozen=True)
class Alignment:
    """How camera time follows from inertial time: `camera = inertial + offset + drift (inertial - reference)`.

    Attributes
    ----------
    offset_s, offset_sigma_s : float
        At the reference, the middle of the overlap.
    drift, drift_sigma : float
        Seconds a second; a sigma of 2e-4 says that the recording was too short to tell.
    reference_s : float
        Inertial time.
    correlation : float
        Of the aligned streams.
    rival : float
        Highest correlation of an offset elsewhere; near `correlation` when the movement repeats itself.
    signal : str
        `acceleration` (one marker is enough) or `rate` (three markers on one body).
    """

    offset_s: float
    offset_sigma_s: float
    drift: float
    drift_sigma: float
    reference_s: float
    correlation: float
    rival: float
    overlap_s: float
    signal: str

    @property
    def is_credible(self) -> bool:
        """Whether the streams show the same movement and no other offset does nearly as well."""
        return self.correlation >= LEAST_CORRELATION and self.correlation - self.rival >= 0.02

    def camera_time(self, time_s: Float) -> Float:
        """Turn inertial into camera time."""
        return time_s + self.offset_s + self.drift * (time_s - self.reference_s)

    def inertial_time(self, camera_time_s: Float) -> Float:
        """Turn camera into inertial time."""
        apart = camera_time_s - self.reference_s - self.offset_s
        return self.reference_s + apart / (1.0 + self.drift)


def align_markers(
    camera_time_s: Float,
    marker_m: Float,
    time_s: Float,
    accelerometer_mps2: Float,
    gyroscope_radps: Float,
    largest_offset_s: float | None = None,
    lever_arm_m: Float | None = None,
) -> Alignment:
    """Align one marker with a module: the size of the specific force needs no heading.

    Parameters
    ----------
    camera_time_s : ndarray, shape (N,)
        Evenly spaced but for lost frames.
    marker_m : ndarray, shape (N, 3)
        Laboratory frame, z up; NaN in gaps.
    time_s : ndarray, shape (K,)
        Even ticks of the inertial module.
    accelerometer_mps2, gyroscope_radps : ndarray, shape (K, 3)
        Specific force and rate; NaN in gaps.
    largest_offset_s : float, optional
        Searched to both sides; by default wherever the recordings overlap.
    lever_arm_m : ndarray, shape (3,), optional
        From the accelerometer to the marker, sensor axes, as far as known: it biases the offset by milliseconds.

    Raises
    ------
    ComparisonError
        The recordings are too short, or nothing moves.

    Notes
    -----
    The second difference of a path over +-h is its acceleration under a triangle of that width; the force is seen
    through the same triangle, in axes that do not turn within it, so neither stream is delayed against the other.
    The cameras' noise in it falls with h squared: of slow movement only wider windows show enough. The narrowest
    that is credible is taken, else the one with the highest correlation.
    """
    camera_step = step_of(camera_time_s, marker_m, "markers")
    step = step_of(time_s, accelerometer_mps2, "accelerometer")
    even, path = evenly(camera_time_s, without_ghosts(marker_m), camera_step)
    attitude = strapdown(gyroscope_radps, step)
    force = rotation.rotate(attitude, accelerometer_mps2)
    arm = None if lever_arm_m is None else rotation.rotate(attitude, lever_arm_m)
    found: list[Alignment] = []
    for half_width_s in _HALF_WIDTHS_S:
        width = max(1, round(half_width_s / camera_step))
        half = width * camera_step
        size = np.full(len(even), np.nan)
        if len(even) > 2 * width:
            acceleration = (path[2 * width :] - 2.0 * path[width:-width] + path[: -2 * width]) / half**2
            acceleration[:, 2] += GRAVITY_MPS2
            size[width:-width] = np.linalg.norm(acceleration, axis=1)
        felt = _felt(force, arm, max(1, round(half / step)), step)
        try:
            found.append(_align(even, size, time_s, felt, step, largest_offset_s, "acceleration"))
        except ComparisonError:
            # A wide window leaves less of a short overlap; what the narrow one said of it stands.
            if not found:
                raise
        if found[-1].is_credible:
            return found[-1]
    return max(found, key=lambda one: one.correlation)


def _felt(force: Float, arm: Float | None, reach: int, step_s: float) -> Float:
    """Return the size of the force at the marker, in axes that do not turn, under a triangle of `reach` ticks."""
    seen = triangle(force, reach)
    if arm is not None and len(seen) > 2 * reach:
        seen[reach:-reach] += (arm[2 * reach :] - 2.0 * arm[reach:-reach] + arm[: -2 * reach]) / (
            reach * step_s
        ) ** 2
    size = np.asarray(np.linalg.norm(seen, axis=1))
    size[:reach] = size[len(size) - reach :] = np.nan
    return size


def align_cluster(
    camera_time_s: Float,
    markers_m: Float,
    time_s: Float,
    gyroscope_radps: Float,
    largest_offset_s: float | None = None,
) -> Alignment:
    """Align three or more markers of one rigid body, shape (N, M, 3), with a gyroscope by the size of their rates.

    Raises
    ------
    ComparisonError
        The recordings are too short, nothing moves, or there are fewer than three markers.
    """
    camera_step = step_of(camera_time_s, markers_m[:, 0] if markers_m.ndim == 3 else markers_m, "markers")
    step = step_of(time_s, gyroscope_radps, "gyroscope")
    size, half = cluster_rate(camera_time_s, markers_m, camera_step)
    # A turn between -h and +h is the mean rate between: seen through a box of that width.
    reach = max(1, round(half / step))
    felt = np.convolve(
        np.linalg.norm(gyroscope_radps, axis=1), np.ones(2 * reach + 1) / (2 * reach + 1), mode="same"
    )
    felt[:reach] = felt[len(felt) - reach :] = np.nan
    even, sized = evenly(camera_time_s, size[:, None], camera_step)
    return _align(even, sized[:, 0], time_s, felt, step, largest_offset_s, "rate")


def cluster_rate(camera_time_s: Float, markers_m: Float, camera_step_s: float) -> tuple[Float, float]:
    """Return the size of the angular rate of a rigid cluster at each frame, and half the span it is a mean over.

    Rotations between two frames are those of Kabsch; NaN where a marker was hidden or frames are lost.
    """
    if markers_m.ndim != 3 or markers_m.shape[1] < 3 or markers_m.shape[2] != 3:
        raise ComparisonError(say("markers.rate_needs_three"))
    width = max(1, round(0.5 * HALF_WIDTH_S / camera_step_s))
    size = np.full(len(markers_m), np.nan)
    if len(markers_m) <= 2 * width:
        return size, width * camera_step_s
    before, after = markers_m[: -2 * width], markers_m[2 * width :]
    span = camera_time_s[2 * width :] - camera_time_s[: -2 * width]
    good = np.isfinite(before).all(axis=(1, 2)) & np.isfinite(after).all(axis=(1, 2))
    good &= np.abs(span - 2 * width * camera_step_s) < 0.5 * camera_step_s
    a = before[good] - before[good].mean(axis=1, keepdims=True)
    b = after[good] - after[good].mean(axis=1, keepdims=True)
    u, _, vt = np.linalg.svd(np.einsum("kmi,kmj->kij", a, b))
    sign = np.sign(np.linalg.det(u) * np.linalg.det(vt))
    trace = np.einsum("kji,kij->k", vt[:, :2], u[:, :, :2]) + sign * np.einsum(
        "kj,kj->k", vt[:, 2], u[:, :, 2]
    )
    angle = np.arccos(np.clip(0.5 * (trace - 1.0), -1.0, 1.0))
    size[width:-width][good] = angle / span[good]
    return size, width * camera_step_s


def _align(
    camera_time_s: Float,
    seen: Float,
    time_s: Float,
    felt: Float,
    step_s: float,
    largest_s: float | None,
    signal: str,
) -> Alignment:
    camera_step = camera_time_s[1] - camera_time_s[0]
    grid = np.arange(camera_time_s[0], camera_time_s[-1], step_s)
    coarse = linear(camera_time_s, seen, grid, 1.6 * camera_step)
    # Index of `felt` plus lag is index of `coarse`; in time that is lag * step + what the grids begin apart.
    scores, lags, overlaps = correlations(coarse, felt, round(_LEAST_OVERLAP_S / step_s))
    offsets = lags * step_s + grid[0] - time_s[0]
    if largest_s is not None:
        scores = np.where(np.abs(offsets) <= largest_s, scores, np.nan)
    if not np.isfinite(scores).any():
        raise ComparisonError(say("markers.little_overlap"))
    # A short overlap correlates by chance more easily.
    weighed = scores * np.sqrt(np.minimum(1.0, overlaps * step_s / 10.0))
    best = int(np.nanargmax(weighed))
    elsewhere = np.abs(offsets - offsets[best]) > _APART_S
    rival = float(np.nanmax(weighed[elsewhere])) if np.isfinite(weighed[elsewhere]).any() else -1.0
    begin = max(time_s[0], camera_time_s[0] - offsets[best])
    end = min(time_s[-1], camera_time_s[-1] - offsets[best])
    reference = 0.5 * (begin + end)
    offset, drift = _first_line(coarse, grid, felt, time_s, step_s, float(offsets[best]), reference)
    found, sigma, correlation = _refined(camera_time_s, seen, time_s, felt, offset, drift, reference, step_s)
    return Alignment(
        float(found[0]),
        float(sigma[0]),
        float(found[1]),
        float(sigma[1]),
        float(reference),
        correlation,
        rival,
        float(end - begin),
        signal,
    )


def _first_line(
    coarse: Float, grid: Float, felt: Float, time_s: Float, step_s: float, offset: float, reference: float
) -> tuple[float, float]:
    """Return offset and drift from windows of a long recording, each aligned alone; the middle of the slopes."""
    window, found = round(_WINDOW_S / step_s), []
    for start in range(0, len(felt) - window + 1, window):
        middle = time_s[start] + 0.5 * _WINDOW_S
        low = round((time_s[start] + offset - _LOCAL_S - grid[0]) / step_s)
        part = slice(max(0, low), max(0, low + window + round(2 * _LOCAL_S / step_s)))
        if part.stop - part.start < window // 2 or not np.isfinite(coarse[part]).any():
            continue
        if not np.isfinite(felt[start : start + window]).any():
            continue
        scores, lags, _ = correlations(coarse[part], felt[start : start + window], window // 2)
        if np.isfinite(scores).any() and np.nanmax(scores) >= LEAST_CORRELATION:
            lag = lags[int(np.nanargmax(scores))]
            found.append((middle, lag * step_s + grid[part.start] - time_s[start]))
    if len(found) < 3:
        return offset, 0.0
    t, o = np.array(found).T
    i, j = np.triu_indices(len(t), 1)
    drift = float(np.median((o[j] - o[i]) / (t[j] - t[i])))
    # Ticks of a hundredth in windows half a minute apart tell no drift; the refinement does.
    if abs(drift) * (t[-1] - t[0]) < 2.0 * step_s:
        drift = 0.0
    return float(np.median(o - drift * (t - reference))), drift


def _refined(
    camera_time_s: Float,
    seen: Float,
    time_s: Float,
    felt: Float,
    offset: float,
    drift: float,
    reference: float,
    step_s: float,
) -> tuple[Float, Float, float]:
    """Fit gain, level, offset and drift by least squares, with the far-off residuals held down (Huber).

    Sigma counts residuals as many as are independent of each other: lever arms and frames make them alike for long.
    """
    present = np.isfinite(seen)
    spline = scipy.interpolate.CubicSpline(camera_time_s[present], seen[present])
    hole = np.where(present, seen, np.nan)
    # The module's signal is the quieter: its slope tells what a shift does, the cameras' noise is all in the residual.
    slope = np.gradient(felt, step_s)
    x = np.array([offset, drift])
    covariance, correlation = np.diag([1.0, _DRIFT_SIGMA**2]), 0.0
    for _ in range(12):
        at = time_s + x[0] + x[1] * (time_s - reference)
        near = linear(camera_time_s, hole, at, 1.6 * (camera_time_s[1] - camera_time_s[0]))
        good = np.isfinite(near) & np.isfinite(felt) & np.isfinite(slope)
        a, b, t = spline(at[good]), felt[good], time_s[good] - reference
        if len(b) < 10 or not a.std() > 0.0 or not b.std() > 0.0:
            break
        gain, level = np.polyfit(b, a, 1)
        residual = a - gain * b - level
        scale = 1.4826 * np.median(np.abs(residual)) + 1e-12
        weight = 1.0 / np.maximum(1.0, np.abs(residual) / (2.0 * scale))
        d = -gain * slope[good]
        j = np.column_stack([b, np.ones_like(b), d, d * t])
        noise = float(np.average(residual**2, weights=weight)) * repetition(residual)
        normal = j.T @ (j * weight[:, None]) / noise
        right = j.T @ (weight * residual) / noise
        normal[3, 3] += 1.0 / _DRIFT_SIGMA**2
        right[3] -= x[1] / _DRIFT_SIGMA**2
        root = np.sqrt(np.diag(normal))
        inverse = np.linalg.pinv(normal / np.outer(root, root)) / np.outer(root, root)
        covariance, correlation = inverse[2:, 2:], float(np.corrcoef(a, b)[0, 1])
        change = (inverse @ right)[2:]
        x = x + np.clip(change, [-0.05, -1e-3], [0.05, 1e-3])
        if abs(change[0]) < 1e-7 and abs(change[1]) < 1e-9:
            break
    return x, np.sqrt(np.maximum(np.diag(covariance), 0.0)), correlation
