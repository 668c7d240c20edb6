"""Markers that contradict their sensor: mirrored axes, another axis up, another unit, another movement."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from estimators import rotation
from estimators.conventions import GRAVITY_MPS2
from estimators.errors import ComparisonError, ContradictionError
from estimators.optical._attitude import level_attitude
from estimators.optical._contract import Provenance
from estimators.optical.alignment._clusters import LEAST_CORRELATION, Alignment, align_markers
from estimators.optical.alignment._mounting import Accelerations, Fit, accelerations, fit
from estimators.optical.alignment._signals import HALF_WIDTH_S
from estimators.recording import Float
from estimators.sentences import say

# Rows are the new x, y and z in the old axes: right-handed, z where the name says.
TURNS: Final[dict[str, tuple[tuple[int, int, int], ...]]] = {
    "z": ((1, 0, 0), (0, 1, 0), (0, 0, 1)),
    "y": ((1, 0, 0), (0, 0, -1), (0, 1, 0)),
    "x": ((0, 1, 0), (0, 0, 1), (1, 0, 0)),
    "-z": ((1, 0, 0), (0, -1, 0), (0, 0, -1)),
    "-y": ((1, 0, 0), (0, 0, 1), (0, -1, 0)),
    "-x": ((0, 1, 0), (0, 0, -1), (-1, 0, 0)),
}
"""Turns of a laboratory into one with z up, by the name of the axis that points up."""

_STRIDE_S: Final = 0.025
_MIRROR_GAIN: Final = 0.7
"""A mirror image that leaves less than this part of the variance is believed; sound recordings give 1.0 or more."""
_SCALE_FLOOR, _SCALE_SIGMAS = 0.08, 5.0
"""Scales of accelerometers and cameras and tilts of the level attitude reach three hundredths in real recordings."""
_WELL, _DOUBTFUL = 0.6, 0.7
_MOST_REJECTED: Final = 0.2
_FARTHEST_M: Final = 0.4
_MOST_RESIDUAL_M: Final = 0.02
_LARGEST_LEFT_OUT: Final = 95.0
_LIVELY: Final = 80.0

Stretch = tuple[int, Float, Float, Float]
"""First tick, gyroscope, accelerometer and level attitude of consecutive samples."""


def check_mapping(both: Accelerations, time_step_s: float, lever_arm_m: Float | None) -> Fit:
    """Refuse markers that are a mirror image of what the sensor felt, or have another scale.

    Parameters
    ----------
    lever_arm_m : ndarray, shape (3,), optional
        When it was measured.

    Returns
    -------
    Fit
        With a free scale.

    Raises
    ------
    ContradictionError
        It says which of both, and what to do.
    """
    found, is_mirrored = _best(both, time_step_s, lever_arm_m)
    if is_mirrored or (found.explained > _WELL and _is_another_scale(found)):
        raise _told("z", is_mirrored, found)
    return found


def _best(both: Accelerations, time_step_s: float, lever_arm_m: Float | None) -> tuple[Fit, bool]:
    few = both.every(max(1, round(_STRIDE_S / time_step_s)))
    # Any mirror will do: the heading is free.
    mirrored = Accelerations(few.seen * np.array([-1.0, 1.0, 1.0]), few.felt, few.arm)
    plain, other = fit(few, lever_arm_m, None), fit(mirrored, lever_arm_m, None)
    # Movement within one plane is its own mirror image: both then fit alike.
    is_mirrored = other.explained > _WELL and other.rest < _MIRROR_GAIN * plain.rest
    return (other, True) if is_mirrored else (plain, False)


def _is_another_scale(found: Fit) -> bool:
    return abs(found.scale - 1.0) > max(_SCALE_FLOOR, _SCALE_SIGMAS * found.scale_sigma)


def explain(
    camera_time_s: Float,
    marker_m: Float,
    time_step_s: float,
    gyroscope_radps: Float,
    accelerometer_mps2: Float,
    largest_offset_s: float | None,
    lever_arm_m: Float | None,
) -> ContradictionError | None:
    """Tell why markers do not fit a sensor: which axis points up, a mirror image, a unit; None when none of it helps.

    Each axis is tried as the one that points up, with the file's scale and with the scale that makes accelerations as
    large as those of the sensor.
    """
    samples = _longest(gyroscope_radps, accelerometer_mps2, time_step_s)
    if samples is None:
        return None
    first, gyroscope, accelerometer, q = samples
    ticks = np.arange(len(gyroscope), dtype=np.float64) * time_step_s
    level = rotation.rotate(q, accelerometer) - np.array([0.0, 0.0, GRAVITY_MPS2])
    rough = _rough_scale(camera_time_s, marker_m, level)
    trials: list[tuple[str, Float, Alignment]] = []
    for name, rows in TURNS.items():
        turned = marker_m @ np.array(rows, dtype=np.float64).T
        for scale in {1.0, rough}:
            try:
                # Times of the stretch begin at zero; limits of the offset count from the recording.
                found = align_markers(
                    camera_time_s - first * time_step_s,
                    turned / scale,
                    ticks,
                    accelerometer,
                    gyroscope,
                    largest_offset_s,
                    lever_arm_m,
                )
            except ComparisonError:
                continue
            if found.correlation >= LEAST_CORRELATION:
                trials.append((name, turned, found))
    best: tuple[float, str, bool, Fit] | None = None
    for name, turned, found in trials:
        at = found.inertial_time(camera_time_s - first * time_step_s)
        inside = (at >= 0.0) & (at <= ticks[-1])
        try:
            both = accelerations(accelerometer, q, time_step_s, at[inside], turned[inside])
        except ComparisonError:
            continue
        fitted, is_mirrored = _best(both, time_step_s, lever_arm_m)
        if best is None or fitted.explained > best[0]:
            best = fitted.explained, name, is_mirrored, fitted
    if best is None or best[0] < _DOUBTFUL:
        return None
    _, name, is_mirrored, fitted = best
    if name == "z" and not is_mirrored and not _is_another_scale(fitted):
        return None
    return _told(name, is_mirrored, fitted)


def _rough_scale(camera_time_s: Float, marker_m: Float, level_mps2: Float) -> float:
    """Return how much larger accelerations of the marker are than those of the sensor."""
    spacing = float(np.median(np.diff(camera_time_s)))
    reach = max(1, round(HALF_WIDTH_S / spacing))
    second = marker_m[2 * reach :] - 2.0 * marker_m[reach:-reach] + marker_m[: -2 * reach]
    seen = np.linalg.norm(second, axis=1) / (reach * spacing) ** 2
    if not np.isfinite(seen).any():
        return 1.0
    felt = float(np.percentile(np.linalg.norm(level_mps2, axis=1), _LIVELY))
    return float(np.nanpercentile(seen, _LIVELY)) / max(felt, 1e-3) or 1.0


def _longest(gyroscope: Float, accelerometer: Float, time_step_s: float) -> Stretch | None:
    measured = np.isfinite(np.hstack([gyroscope, accelerometer])).all(axis=1)
    edges = np.flatnonzero(np.diff(np.concatenate([[0], measured.astype(np.int8), [0]]))).reshape(-1, 2)
    if not len(edges):
        return None
    first, stop = edges[int(np.argmax(edges[:, 1] - edges[:, 0]))].tolist()
    g, a = gyroscope[first:stop], accelerometer[first:stop]
    return first, g, a, level_attitude(g, a, time_step_s)[0]


def _told(up: str, is_mirrored: bool, found: Fit) -> ContradictionError:
    wrong = []
    if is_mirrored:
        wrong.append(
            say("markers.mirrored_columns") if up.endswith("z") else say("markers.mirrored", one=up[-1])
        )
    if up != "z":
        wrong.append(say("markers.up_mirrored", up=up) if is_mirrored else say("markers.up", up=up))
    scale = found.scale if _is_another_scale(found) else None
    if scale is not None:
        wrong.append(say("markers.scale", scale=scale, sigma=found.scale_sigma))
    return ContradictionError(
        say("markers.contradict", wrong=wrong), scale=scale, up=up, is_mirrored=is_mirrored
    )


def check_result(
    residual_m: Float, provenance: NDArray[np.uint8], lever_arm_m: Float, is_lever_given: bool
) -> None:
    """Refuse a fusion that only seems one.

    Parameters
    ----------
    residual_m : ndarray, shape (K, 3)
        Of all frames, those that were shut out too; NaN without one.
    provenance : ndarray, shape (K,)
    lever_arm_m : ndarray, shape (3,)
    is_lever_given : bool
        It was measured, and is what it is.

    Raises
    ------
    ContradictionError
        Too many frames were shut out, the marker would be too far from its sensor, or what is left is too large.
    """
    seen = np.isfinite(residual_m).all(axis=1)
    shut_out = float(np.mean(provenance[seen] == Provenance.REJECTED)) if seen.any() else 0.0
    if shut_out > _MOST_REJECTED:
        raise ContradictionError(say("markers.shut_out", share=shut_out, most=_MOST_REJECTED))
    far = float(np.linalg.norm(lever_arm_m))
    if far > _FARTHEST_M and not is_lever_given:
        raise ContradictionError(say("markers.far", distance_m=far))
    size = np.linalg.norm(residual_m[seen], axis=1)
    # Ghosts are few, and far.
    size = size[size <= np.percentile(size, _LARGEST_LEFT_OUT)]
    rms = float(np.sqrt(np.mean(size**2))) if len(size) else 0.0
    if rms > _MOST_RESIDUAL_M:
        raise ContradictionError(say("markers.residual", residual_m=rms))
