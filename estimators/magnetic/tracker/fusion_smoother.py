"""The tracker fusion off line: forward, then backward over the whole recording (Roetenberg 2006, 6.2.3)."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from estimators.magnetic.tracker import fusion_layout as at
from estimators.magnetic.tracker.fusion import TrackerFusion, TrackerFusionChunk, TrackerFusionResult
from estimators.magnetic.tracker.fusion_run import backward, report, run


def smooth_tracker_fusion(
    chunk: TrackerFusionChunk, parameters: Mapping[str, Any] | None = None
) -> tuple[TrackerFusionResult, TrackerFusionResult]:
    """Estimate the pose from a whole recording, from tick 0.

    Returns
    -------
    smoothed, filtered : TrackerFusionResult
        They are the same at the last tick, and before the first fix.
    """
    fusion, samples = TrackerFusion(chunk.time_step_s, parameters), chunk.table()
    settings, state, spread, memory, counters = fusion.arrays()
    count = len(samples)
    out, held = np.empty((count, at.OUTPUT)), samples.copy()
    nominal, covariance = np.empty((count, at.NOMINAL)), np.empty((count, at.ERRORS, at.ERRORS))
    restarted = np.zeros(count, dtype=np.bool_)
    for k in range(count):
        starts = int(counters[at.RESTARTED])
        run(samples[k : k + 1], settings, state, spread, memory, counters, out[k : k + 1])
        nominal[k], covariance[k] = state, spread
        held[k, : at.FILTER_ATTITUDE] = memory[at.LAST : at.LAST + at.FILTER_ATTITUDE]
        restarted[k] = int(counters[at.RESTARTED]) > starts
    smoothed, smoothed_covariance = np.empty_like(nominal), np.empty_like(covariance)
    backward(held, restarted, nominal, covariance, settings, smoothed, smoothed_covariance)
    after = out.copy()
    for k in range(count):
        q_source = held[k, at.SOURCE_ATTITUDE : at.SOURCE_ATTITUDE + 4]
        report(smoothed[k], np.ascontiguousarray(q_source), smoothed_covariance[k], after[k])
    return TrackerFusionResult.of_table(after), TrackerFusionResult.of_table(out)
