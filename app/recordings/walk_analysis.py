"""Following the feet of a stored session: its frames and its walk become a new result."""

from collections.abc import Iterable
from typing import Any, Final

from app.database.base import utc_now
from app.database.unit_of_work import unit_of_work
from app.errors import InvalidInput
from app.recordings.chunks import encode_frames, slice_frames
from app.recordings.jobs import JobContext
from app.recordings.models import Result
from app.recordings.result_rows import CHUNKS_A_COMMIT, new_result, write_frames
from app.recordings.walks import content_of, recording_of, store_walk
from estimators import pipelines
from estimators.errors import EstimationError
from estimators.pipelines import SessionSetup
from estimators.recording import ImuChunk

_PIECE_TICKS: Final = 1000


def follow_feet(
    context: JobContext,
    setup: SessionSetup,
    pieces: Iterable[ImuChunk],
    hello: dict[str, Any] | None,
    progress_from: float,
) -> tuple[str, int]:
    """Analyse a walk off-line and keep it.

    Parameters
    ----------
    context : JobContext
    setup : SessionSetup
        Of the pipeline `gait`.
    pieces : iterable of ImuChunk
        The whole session.
    hello : dict or None
        Of the gateway; may tell where the gyroscopes clip.
    progress_from : float
        Where on the task's scale of 0 to 1 this work begins.

    Returns
    -------
    result_id : str
    ticks : int
        Length of the session.

    Raises
    ------
    InvalidInput
        The samples cannot be a walk; the message says why.
    """
    measured = recording_of(pieces, setup, (hello or {}).get("clip_gyroscope_radps"))
    context.progress(progress_from + 0.3 * (1 - progress_from), "Following the feet")
    result_id = new_result(context, setup, pipelines.create(setup))
    try:
        walk = pipelines.analyse_walk(measured, setup)
    except EstimationError as error:
        raise InvalidInput(str(error)) from error
    frames = walk.frames
    starts = range(0, frames.tick_count, _PIECE_TICKS)
    for first in range(0, len(starts), CHUNKS_A_COMMIT):
        group = starts[first : first + CHUNKS_A_COMMIT]
        write_frames(
            context, result_id, [encode_frames(slice_frames(frames, i, i + _PIECE_TICKS)) for i in group]
        )
    with unit_of_work(context.engine) as session:
        store_walk(session, context.session_id, result_id, content_of(walk))
        result = session.get_one(Result, result_id)
        result.status, result.progress = "complete", 1.0
        result.message = " ".join(walk.summary.reasons)[:500]
        result.completed_at = utc_now()
    return result_id, frames.first_tick + frames.tick_count


__all__ = ["follow_feet"]
