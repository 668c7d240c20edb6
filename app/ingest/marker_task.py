"""The task of uploaded markers: align their clock with the session's, fuse them with a sensor, report."""

from itertools import pairwise
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from app.database.base import new_id
from app.database.unit_of_work import read_only, unit_of_work
from app.errors import InvalidInput
from app.ingest.readers import MarkerTracks, read_markers
from app.ingest.upload import upload_folder
from app.recordings import markers
from app.recordings.jobs import JobContext
from app.recordings.marker_schemas import (
    MarkerCurves,
    MarkerGap,
    MarkerGapCheck,
    MarkerReport,
    MarkerUploadIn,
)
from app.recordings.models import MotionSession
from app.recordings.reprocess import aligned
from estimators.errors import EstimationError
from estimators.optical import OpticalFusion, Provenance, fuse_markers
from estimators.recording import Float, SampleQuality

_POINTS: Final = 600
_GAPS: Final = 100


def fuse(context: JobContext) -> str:
    """Do the task `markers`; its argument `markers_id` names the stored file.

    Raises
    ------
    InvalidInput
        Markers and sensor do not show the same movement; the message says what to do.
    """
    markers_id = str(context.arguments["markers_id"])
    path = upload_folder(context.settings) / f"{new_id()}.markers"
    try:
        with read_only(context.engine) as session:
            found = session.get_one(MotionSession, context.session_id)
            hello = found.hello
            declared = markers.write_file(session, found.id, markers_id, path)
        context.progress(0.1, "Reading the markers")
        tracks = read_markers(path, declared)
    finally:
        path.unlink(missing_ok=True)
    name = declared.marker or _most_seen(tracks)
    gyroscope, accelerometer, step_s = _samples(context, hello, declared)
    context.progress(0.3, "Aligning and fusing")
    try:
        fusion = fuse_markers(
            tracks.time_s,
            tracks.of(name),
            step_s,
            gyroscope,
            accelerometer,
            lever_arm_m=None if declared.lever_arm_m is None else np.array(declared.lever_arm_m),
            cluster_m=_cluster(tracks, declared),
            largest_offset_s=declared.largest_offset_s,
        )
    except EstimationError as error:
        raise InvalidInput(f"{error}. Check the segment and which axis points up.") from error
    with unit_of_work(context.engine) as session:
        markers.store_fusion(
            session,
            context.session_id,
            markers_id,
            report_of(fusion, name),
            fusion.first_tick,
            fusion.time_step_s,
            _motion(fusion),
        )
    return " ".join(fusion.reasons)[:500]


def _most_seen(tracks: MarkerTracks) -> str:
    seen = np.isfinite(tracks.position_m).all(axis=-1).sum(axis=0)
    return tracks.names[int(np.argmax(seen))]


def _cluster(tracks: MarkerTracks, declared: MarkerUploadIn) -> Float | None:
    if not declared.cluster:
        return None
    if len(set(declared.cluster)) < 3:
        raise InvalidInput("A cluster needs three different markers at least.", field="cluster")
    return np.stack([tracks.of(name) for name in declared.cluster], axis=1)


def _samples(
    context: JobContext, hello: dict[str, Any] | None, declared: MarkerUploadIn
) -> tuple[Float, Float, float]:
    """Return gyroscope and accelerometer of the segment on the ticks of the session, NaN where nothing was measured."""
    rates, forces, step_s = [], [], 0.01
    for piece in aligned(context.engine, context.session_id, hello, (declared.segment,)):
        missing = (piece.quality[0] & SampleQuality.MISSING) != 0
        rates.append(np.where(missing[:, None], np.nan, piece.gyroscope_radps[0]))
        forces.append(np.where(missing[:, None], np.nan, piece.accelerometer_mps2[0]))
        step_s = piece.time_step_s
    if not rates:
        raise InvalidInput("This session holds no samples.")
    return np.concatenate(rates), np.concatenate(forces), step_s


def report_of(fusion: OpticalFusion, marker: str) -> MarkerReport:
    """Return what people are told of a fusion."""
    used = np.isin(fusion.result.provenance, (Provenance.MEASURED, Provenance.RECOVERED))
    residual = fusion.residual_m[used]
    found, step = fusion.alignment, fusion.time_step_s
    gaps = sorted(fusion.gaps, key=lambda gap: -gap.length_s)[:_GAPS]
    return MarkerReport(
        marker=marker,
        offset_s=found.offset_s,
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
        gaps=[
            MarkerGap(
                start_s=round((fusion.first_tick + gap.start) * step, 4),
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
        curves=_curves(fusion, used),
        reasons=list(fusion.reasons),
    )


def _curves(fusion: OpticalFusion, used: NDArray[np.bool_]) -> MarkerCurves:
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
        time_s=[round(float(t), 3) for t in (fusion.first_tick + middles) * fusion.time_step_s],
        residual_m=largest(residual),
        sigma_m=largest(sigma),
        speed_mps=largest(speed),
    )


def _motion(fusion: OpticalFusion) -> NDArray[np.float32]:
    result = fusion.result
    q = np.where(np.isfinite(result.position_m[:, :1]), result.q_room_sensor, np.nan)
    return np.column_stack(
        [
            result.position_m,
            result.velocity_mps,
            result.acceleration_mps2,
            q,
            result.marker_m,
            result.position_sigma_m,
            result.provenance,
        ]
    ).astype(np.float32)


def _plain(value: float) -> float | None:
    return round(value, 6) if np.isfinite(value) else None


__all__ = ["fuse", "report_of"]
