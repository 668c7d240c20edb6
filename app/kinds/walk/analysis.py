"""Following the feet of a stored session: its frames and its walk become a new result."""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Final

from app.database.base import utc_now
from app.database.unit_of_work import read_only, unit_of_work
from app.errors import InvalidInput
from app.kinds.walk.shoes import load_shoes, shoes_of
from app.kinds.walk.stored import content_of, guided_kind_of, reasons_of, recording_of, store_walk
from app.recordings.analysis.jobs import JobContext
from app.recordings.analysis.offline import Analysis
from app.recordings.analysis.result_rows import CHUNKS_A_COMMIT, layout_dict, new_result, write_frames
from app.recordings.analysis.stamped import stored_recording
from app.recordings.models import MotionSession, Result
from app.recordings.signals.chunks import encode_frames
from estimators import pipelines
from estimators.errors import EstimationError
from estimators.gait import RelativeFeet
from estimators.pipelines import SessionSetup, ShoeWalk, Walk
from estimators.recording import ImuChunk
from estimators.sentences import CATALOGUE, say

_PIECE_TICKS: Final = 1000
_STILL_AT_START_S: Final = 1.0


def follow_feet(
    context: JobContext,
    setup: SessionSetup,
    pieces: Iterable[ImuChunk],
    progress_from: float,
    relative: RelativeFeet | None = None,
) -> Analysis:
    """Analyse a walk off-line and keep it; that of a file on the file's own stamps.

    Parameters
    ----------
    setup : SessionSetup
        Of the pipeline `gait`.
    pieces : iterable of ImuChunk
        The whole session.
    progress_from : float
        Where on the task's scale of 0 to 1 this work begins.
    relative : RelativeFeet, optional
        What a magnetic source on one shoe tells of the other.

    Raises
    ------
    InvalidInput
        The samples cannot be a walk; the message says why.
    """
    with read_only(context.engine) as session:
        found = session.get_one(MotionSession, context.session_id)
        hello, recorded_s = found.hello, found.recorded_s
    given = setup
    parts = list(pieces)
    measured = stored_recording(context.engine, context.session_id, hello, setup.placements)
    if measured is None:
        measured = recording_of(parts, setup, hello)
    context.progress(progress_from + 0.3 * (1 - progress_from), say("progress.feet"))
    result_id = new_result(context, setup, pipelines.create(setup))
    try:
        walk = pipelines.analyse_walk(measured, setup, recorded_s)
    except EstimationError as error:
        raise InvalidInput(error.message) from error
    note, related = "", None
    if relative is not None:
        try:
            walk = pipelines.with_relative_feet(walk, relative)
        except EstimationError as error:
            note = say("walk.feet_unrelated", reason=error.message)
        else:
            # The source tells forces and centre of mass how far the feet stand apart, and the steps themselves.
            related = walk.steps
            setup = replace(setup, feet_apart_m=pipelines.apart_at_start(walk), feet_apart_end_m=None)
    shoes, doubt = _with_forces(context, setup, walk, parts)
    if shoes is not None:
        walk = pipelines.with_shoes(walk, shoes)
        walk = walk if related is None else replace(walk, steps=related)
    notes = [text for text in (note, doubt) if text]
    frames = walk.frames
    starts = range(0, frames.tick_count, _PIECE_TICKS)
    for first in range(0, len(starts), CHUNKS_A_COMMIT):
        group = starts[first : first + CHUNKS_A_COMMIT]
        write_frames(context, result_id, [encode_frames(frames.ticks(i, i + _PIECE_TICKS)) for i in group])
    with unit_of_work(context.engine) as session:
        kind = guided_kind_of(session, session.get_one(MotionSession, context.session_id).exercise_id)
        content = content_of(walk, shoes, kind, notes)
        store_walk(session, context.session_id, result_id, content)
        result = session.get_one(Result, result_id)
        result.status, result.progress = "complete", 1.0
        result.layout = layout_dict(frames.layout)
        result.message = CATALOGUE.together([*reasons_of(walk, shoes), *notes])
        result.completed_at = utc_now()
    return Analysis(result_id, frames.first_tick + frames.tick_count, given, None, "")


def _with_forces(
    context: JobContext, setup: SessionSetup, walk: Walk, parts: Sequence[ImuChunk]
) -> tuple[ShoeWalk | None, str]:
    """Analyse the shoes where the session has them, uploaded or in its packets; otherwise say why not."""
    with read_only(context.engine) as session:
        recording = load_shoes(session, context.session_id)
    note = ""
    if recording is None:
        recording, late_s, note = shoes_of(parts, setup)
        if late_s > _STILL_AT_START_S:
            # How far the feet stood apart was measured before the first forces.
            setup = replace(setup, feet_apart_m=None)
    if recording is None:
        return None, note
    context.progress(0.7, say("progress.forces"))
    try:
        return pipelines.analyse_shoes(recording, setup, walk), note
    except EstimationError as error:
        return None, say("walk.no_forces", reason=error.message)
