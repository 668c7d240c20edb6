"""The rows of a result that a task makes: itself, its frames, and what an interrupted attempt left of it."""

from typing import Final

from sqlalchemy import delete
from sqlalchemy.orm import Session

from app.database.unit_of_work import unit_of_work
from app.recordings.analysis.jobs import JobContext
from app.recordings.models import Result, SignalChunk
from app.recordings.signals.chunks import EncodedChunk, frames_stream
from app.recordings.signals.rows import insert_chunk
from estimators import orientation, pipelines
from estimators.pipelines import FrameLayout, SessionSetup

CHUNKS_A_COMMIT: Final = 8


def filter_of(pipeline: pipelines.Pipeline) -> tuple[str, str]:
    """Return name and version of the filter that estimates a session."""
    if not pipeline.takes_estimator:
        return pipeline.filter, pipeline.version
    name = pipeline.setup.orientation
    return name, orientation.available(with_offline=True)[name].version


def new_result(
    context: JobContext, setup: SessionSetup, pipeline: pipelines.Pipeline, *, smoothed: bool = False
) -> str:
    """Make the row of a new result; what an interrupted attempt left is removed.

    `smoothed` says so of a filter of the pipeline's own, so that the live result keeps the filter's name.
    """
    layout = pipeline.layout
    estimator, version = filter_of(pipeline)
    if smoothed:
        estimator = f"{estimator}_smoothed"
    with unit_of_work(context.engine) as session:
        earlier = context.arguments.get("result_id")
        if isinstance(earlier, str):
            forget(session, context.session_id, earlier)
        result = Result(
            session_id=context.session_id,
            kind="offline",
            pipeline=setup.pipeline,
            pipeline_version=pipeline.version,
            orientation=estimator,
            orientation_version=version,
            setup=setup.to_dict(),
            layout=layout_dict(layout),
        )
        session.add(result)
        session.flush()
        result_id = result.id
    context.remember(result_id=result_id)
    return result_id


def layout_dict(layout: FrameLayout) -> dict[str, list[str]]:
    """Return the names of the columns of frames as a result keeps them."""
    return {
        "segments": list(layout.segments),
        "points": list(layout.points),
        "angles": list(layout.angles),
        "scalars": list(layout.scalars),
    }


def forget(session: Session, session_id: str, result_id: str) -> None:
    """Remove a result with everything that was found: its frames, and whatever else is named after it."""
    session.execute(
        delete(SignalChunk).where(
            SignalChunk.session_id == session_id, SignalChunk.stream.endswith(f"/{result_id}")
        )
    )
    session.execute(delete(Result).where(Result.id == result_id))


def write_frames(context: JobContext, result_id: str, chunks: list[EncodedChunk]) -> None:
    """Store frames of a result."""
    if not chunks:
        return
    with unit_of_work(context.engine) as session:
        for chunk in chunks:
            insert_chunk(
                session, context.session_id, frames_stream(result_id), chunk.scale["first_tick"], chunk
            )
