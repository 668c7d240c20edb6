"""Camera frames and samples of one movement brought onto one clock, or the reason why that cannot be done."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from estimators.errors import ComparisonError
from estimators.optical._contradictions import check_mapping, explain
from estimators.optical._stretch import Stretch, onto_ticks, prepare
from estimators.optical.alignment._clusters import Alignment, align_cluster, align_markers
from estimators.recording import Float
from estimators.sentences import say

_ROUNDS = 6
_SAME_CLOCK_S = 5e-5
_FIRST_CORRELATION = 0.5


def match(
    camera_time_s: Float,
    marker_m: Float,
    step: float,
    gyroscope: Float,
    accelerometer: Float,
    parameters: Mapping[str, Any] | None,
    lever: Float | None,
    cluster: Float | None,
    largest: float | None,
    noise: Float | None,
) -> tuple[Alignment, list[Stretch], list[str], Float, Float]:
    """Match, and where that fails look for what may be wrong with the markers."""
    try:
        return _matched(
            camera_time_s,
            marker_m,
            step,
            gyroscope,
            accelerometer,
            parameters,
            lever,
            cluster,
            largest,
            noise,
        )
    except ComparisonError as error:
        why = explain(camera_time_s, marker_m, step, gyroscope, accelerometer, largest, lever)
        raise (why or error) from error


def _matched(
    camera_time_s: Float,
    marker_m: Float,
    step: float,
    gyroscope: Float,
    accelerometer: Float,
    parameters: Mapping[str, Any] | None,
    lever: Float | None,
    cluster: Float | None,
    largest: float | None,
    noise: Float | None,
) -> tuple[Alignment, list[Stretch], list[str], Float, Float]:
    """Return the clocks, what can be fused, what cannot and why, the frames on ticks and their delays."""
    count = len(gyroscope)
    ticks = np.arange(count, dtype=np.float64) * step
    samples = gyroscope, accelerometer
    # A far marker on a limb that turns is recognised only with its lever arm.
    found = _best_alignment(
        camera_time_s, marker_m, ticks, *samples, cluster, largest, lever, _FIRST_CORRELATION
    )
    attitudes: dict[tuple[int, int], tuple[Float, Float]] = {}
    for _ in range(_ROUNDS):
        at = found.inertial_time(camera_time_s)
        on_ticks, delay = onto_ticks(at, marker_m, step, count)
        stretches, reasons = prepare(
            *samples, step, on_ticks, delay, at, marker_m, parameters, lever, attitudes, noise
        )
        # The lever arm biases the clocks, and the clocks the lever arm.
        arm, before = stretches[0].mounting.lever_arm_m, found
        found = _best_alignment(camera_time_s, marker_m, ticks, *samples, cluster, largest, arm)
        # At both ends too: a drift may turn about a middle that stays.
        ends = found.reference_s + 0.5 * found.overlap_s * np.array([-1.0, 1.0])
        if np.abs(found.camera_time(ends) - before.camera_time(ends)).max() < _SAME_CLOCK_S:
            break
    _require_credible(found)
    for stretch in stretches:
        check_mapping(stretch.accelerations(), step, lever)
    return found, stretches, reasons, on_ticks, delay


def _best_alignment(
    camera_time_s: Float,
    marker_m: Float,
    ticks: Float,
    gyroscope: Float,
    accelerometer: Float,
    cluster: Float | None,
    largest: float | None,
    arm: Float | None,
    least: float | None = None,
) -> Alignment:
    found = align_markers(camera_time_s, marker_m, ticks, accelerometer, gyroscope, largest, arm)
    if cluster is not None:
        by_rate = align_cluster(camera_time_s, cluster, ticks, gyroscope, largest)
        if by_rate.is_credible and (not found.is_credible or by_rate.offset_sigma_s < found.offset_sigma_s):
            found = by_rate
    if least is None or found.correlation < least:
        _require_credible(found)
    return found


def _require_credible(found: Alignment) -> None:
    if not found.is_credible:
        raise ComparisonError(say("markers.no_correlation", correlation=found.correlation, rival=found.rival))
