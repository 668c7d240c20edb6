"""The task of uploaded markers: align their clock with the session's, fuse them with a sensor, report."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from app.database.base import new_id
from app.database.unit_of_work import read_only, unit_of_work
from app.errors import InvalidInput
from app.ingest.marker_fusion import fuse_tracks, motion_of, report_of
from app.readers import read_markers
from app.readers.markers.schemas import MarkerUploadIn
from app.recordings import markers
from app.recordings.analysis.jobs import JobContext
from app.recordings.analysis.offline import aligned
from app.recordings.files_in_passing import upload_folder
from app.recordings.models import MotionSession
from estimators.recording import Float, SampleQuality
from estimators.sentences import CATALOGUE, say


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
        context.progress(0.1, say("progress.reading_markers"))
        tracks = read_markers(path, declared)
    finally:
        path.unlink(missing_ok=True)
    gyroscope, accelerometer, bridged, step_s = _samples(context, hello, declared)
    context.progress(0.3, say("progress.fusing"))
    fusion, name = fuse_tracks(tracks, declared, step_s, gyroscope, accelerometer, bridged)
    with unit_of_work(context.engine) as session:
        markers.store_fusion(
            session,
            context.session_id,
            markers_id,
            report_of(fusion, name),
            fusion.first_tick,
            fusion.time_step_s,
            motion_of(fusion),
        )
    return CATALOGUE.together(fusion.reasons)


def _samples(
    context: JobContext, hello: dict[str, Any] | None, declared: MarkerUploadIn
) -> tuple[Float, Float, NDArray[np.bool_], float]:
    """Return gyroscope, accelerometer and which are bridged, on the ticks of the session; NaN where all was lost."""
    rates, forces, bridged, step_s = [], [], [], 0.01
    for piece in aligned(context.engine, context.session_id, hello, (declared.segment,)):
        missing = (piece.quality[0] & SampleQuality.MISSING) != 0
        rates.append(np.where(missing[:, None], np.nan, piece.gyroscope_radps[0]))
        forces.append(np.where(missing[:, None], np.nan, piece.accelerometer_mps2[0]))
        bridged.append((piece.quality[0] & SampleQuality.BRIDGED) != 0)
        step_s = piece.time_step_s
    if not rates:
        raise InvalidInput(say("session.no_samples"))
    return np.concatenate(rates), np.concatenate(forces), np.concatenate(bridged), step_s
