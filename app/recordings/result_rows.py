"""The rows of a result that a task makes: itself, its frames, and what an interrupted attempt left of it."""

from typing import Final

from sqlalchemy import delete
from sqlalchemy.orm import Session

from app.database.unit_of_work import unit_of_work
from app.recordings._rows import insert_chunk
from app.recordings.chunks import EncodedChunk, frames_stream
from app.recordings.jobs import JobContext
from app.recordings.magnetic import PIPELINE as MAGNETIC
from app.recordings.models import Result, SignalChunk
from app.recordings.walks import estimator_of, forget_walk
from estimators import orientation, pipelines
from estimators.pipelines import FrameLayout, SessionSetup

CHUNKS_A_COMMIT: Final = 8


def new_result(context: JobContext, setup: SessionSetup, pipeline: pipelines.Pipeline) -> str:
    """Make the row of a new result; what an interrupted attempt left is removed."""
    layout = pipeline.layout
    version = orientation.available(with_offline=True)[setup.orientation].version
    estimator, version = estimator_of(setup, pipeline, version)
    if setup.pipeline == MAGNETIC:
        # Off line it is smoothed; the live result keeps the filter's name.
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
    """Remove a result with everything that was found."""
    session.execute(
        delete(SignalChunk).where(
            SignalChunk.session_id == session_id, SignalChunk.stream == frames_stream(result_id)
        )
    )
    forget_walk(session, session_id, result_id)
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


__all__ = ["CHUNKS_A_COMMIT", "forget", "layout_dict", "new_result", "write_frames"]
