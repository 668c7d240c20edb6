"""Markers fused with a sensor in the product's own words: what the page, the command and the store take of it."""

from itertools import pairwise
from typing import Final

import numpy as np
from numpy.typing import NDArray

from app.errors import InvalidInput
from app.readers import METRES, MarkerTracks
from app.readers.markers.schemas import (
    MarkerCurves,
    MarkerFileIn,
    MarkerGap,
    MarkerGapCheck,
    MarkerReport,
)
from estimators.errors import ContradictionError, EstimationError
from estimators.optical import TURNS, OpticalFusion, OpticalResult, Provenance, fuse_markers
from estimators.recording import Float
from estimators.sentences import CATALOGUE, say

_POINTS: Final = 600
_GAPS: Final = 100
_SAME_UNIT: Final = 0.08


def fuse_tracks(
    tracks: MarkerTracks,
    declared: MarkerFileIn,
    time_step_s: float,
    gyroscope_radps: Float,
    accelerometer_mps2: Float,
    bridged: NDArray[np.bool_] | None = None,
    lag_s: float | None = None,
) -> tuple[OpticalFusion, str]:
    """Fuse the declared marker, or the one seen most, with a sensor; return its name too.

    Parameters
    ----------
    gyroscope_radps, accelerometer_mps2 : ndarray, shape (K, 3)
        Even ticks from time zero; NaN where nothing was measured.
    bridged : ndarray of bool, shape (K,), optional
        Samples that were interpolated over lost packets.
    lag_s : float, optional
        Also return what a smoother so far behind would have returned.

    Raises
    ------
    InvalidInput
        Markers and sensor do not show the same movement; the message says what to do.
    """
    name = declared.marker or _most_seen(tracks)
    try:
        fusion = fuse_markers(
            tracks.time_s,
            tracks.of(name),
            time_step_s,
            gyroscope_radps,
            accelerometer_mps2,
            lever_arm_m=None if declared.lever_arm_m is None else np.array(declared.lever_arm_m),
            cluster_m=_cluster(tracks, declared),
            largest_offset_s=declared.largest_offset_s,
            bridged=bridged,
            lag_s=lag_s,
        )
    except ContradictionError as error:
        field = "unit" if error.scale is not None else "up"
        raise InvalidInput(_contradiction(error, declared), field=field) from error
    except EstimationError as error:
        raise InvalidInput(say("marker_fusion.refused", reason=error.message)) from error
    return fusion, name


def _contradiction(error: ContradictionError, declared: MarkerFileIn) -> str:
    """Return what contradicts, and in the file's own axes and units what was probably meant."""
    said = [error.message]
    if error.up != "z" and not error.is_mirrored and declared.up != "z":
        # The error speaks of axes that were turned already, as declared.
        axis = np.array(TURNS[error.up][2]) @ np.array(TURNS[declared.up])
        name = "xyz"[int(np.argmax(np.abs(axis)))]
        said.append(say("marker_fusion.up", axis=f"{'-' if axis.sum() < 0 else ''}{name}"))
    if error.scale is not None:
        true_m = METRES[declared.unit] / error.scale
        near = [name for name, size in METRES.items() if abs(true_m / size - 1.0) < _SAME_UNIT]
        if near and declared.format == "csv":
            said.append(say("marker_fusion.unit", unit=near[0], declared=declared.unit))
        elif min(abs(error.scale / 2.54 - 1.0), abs(error.scale * 2.54 - 1.0)) < _SAME_UNIT:
            said.append(say("marker_fusion.inches"))
    return CATALOGUE.together(said)


def report_of(fusion: OpticalFusion, marker: str, start_s: float = 0.0) -> MarkerReport:
    """Return what people are shown of a fusion.

    Parameters
    ----------
    marker : str
        Its name.
    start_s : float
        Time of the first tick on the clock that the report speaks of.
    """
    used = np.isin(fusion.result.provenance, (Provenance.MEASURED, Provenance.RECOVERED))
    residual = fusion.residual_m[used]
    found, step = fusion.alignment, fusion.time_step_s
    gaps = sorted(fusion.gaps, key=lambda gap: -gap.length_s)[:_GAPS]
    return MarkerReport(
        marker=marker,
        offset_s=found.offset_s - start_s,
        offset_sigma_s=found.offset_sigma_s,
        drift_ppm=1e6 * found.drift,
        drift_sigma_ppm=1e6 * found.drift_sigma,
        correlation=found.correlation,
        rival=found.rival,
        overlap_s=found.overlap_s,
        aligned_by="rate" if found.signal == "rate" else "acceleration",
        lever_arm_m=[float(x) for x in fusion.lever_arm_m],
        lever_arm_sigma_m=[float(x) for x in fusion.lever_arm_sigma_m],
        heading_sigma_rad=fusion.heading_sigma_rad,
        residual_rms_m=[float(x) for x in np.sqrt(np.nanmean(residual**2, axis=0))],
        sigma_scale=fusion.sigma_scale,
        mean_nis=_plain(fusion.mean_nis),
        frame_count=fusion.frame_count,
        used_count=fusion.used_count,
        rejected_count=fusion.rejected_count,
        bridged_s=round(fusion.bridged_count * step, 4),
        gaps=[
            MarkerGap(
                start_s=round(start_s + (fusion.first_tick + gap.start) * step, 4),
                length_s=round(gap.length_s, 4),
                sigma_m=gap.sigma_m,
                withheld=gap.withheld,
            )
            for gap in sorted(gaps, key=lambda gap: gap.start)
        ],
        gap_count=len(fusion.gaps),
        checks=[
            MarkerGapCheck(
                length_s=check.length_s,
                count=check.count,
                inertial_m=check.inertial_m,
                spline_m=_plain(check.spline_m),
                within_three_sigma=check.within_three_sigma,
            )
            for check in fusion.checks
        ],
        curves=_curves(fusion, used, start_s),
        reasons=list(fusion.reasons),
    )


def _curves(fusion: OpticalFusion, used: NDArray[np.bool_], start_s: float) -> MarkerCurves:
    result = fusion.result
    count = len(result.position_m)
    residual = np.where(used, np.linalg.norm(fusion.residual_m, axis=1), np.nan)
    sigma = result.position_sigma_m.max(axis=1)
    speed = np.linalg.norm(result.velocity_mps, axis=1)
    edges = np.linspace(0, count, min(_POINTS, count) + 1).astype(int)
    middles = (edges[:-1] + edges[1:] - 1) // 2

    def largest(values: Float) -> list[float | None]:
        return [
            _plain(float(np.nanmax(part))) if np.isfinite(part := values[a:b]).any() else None
            for a, b in pairwise(edges)
        ]

    return MarkerCurves(
        time_s=[round(float(t), 3) for t in start_s + (fusion.first_tick + middles) * fusion.time_step_s],
        residual_m=largest(residual),
        sigma_m=largest(sigma),
        speed_mps=largest(speed),
    )


def motion_of(fusion: OpticalFusion, result: OpticalResult | None = None) -> NDArray[np.float32]:
    """Return the motion as it is stored and exported, shape (K, C); the columns are `app.recordings.markers.COLUMNS`.

    Parameters
    ----------
    result : OpticalResult, optional
        The smoothed one by default.
    """
    result = fusion.result if result is None else result
    q = np.where(np.isfinite(result.position_m[:, :1]), result.q_room_sensor, np.nan)
    is_gap = np.zeros(len(q))
    for gap in fusion.gaps:
        is_gap[gap.start : gap.stop] = 1.0
    return np.column_stack(
        [
            result.position_m,
            result.velocity_mps,
            result.acceleration_mps2,
            q,
            result.marker_m,
            result.position_sigma_m,
            result.provenance,
            is_gap,
            fusion.marker_m,
        ]
    ).astype(np.float32)


def _most_seen(tracks: MarkerTracks) -> str:
    seen = np.isfinite(tracks.position_m).all(axis=-1).sum(axis=0)
    return tracks.names[int(np.argmax(seen))]


def _cluster(tracks: MarkerTracks, declared: MarkerFileIn) -> Float | None:
    if not declared.cluster:
        return None
    if len(set(declared.cluster)) < 3:
        raise InvalidInput(say("marker_fusion.cluster"), field="cluster")
    return np.stack([tracks.of(name) for name in declared.cluster], axis=1)


def _plain(value: float) -> float | None:
    return round(value, 6) if np.isfinite(value) else None
