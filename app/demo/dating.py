"""Moving what the demonstration recorded into its past."""

from datetime import timedelta

from sqlalchemy import Engine, select

from app.assessment.models import Comparison
from app.database.unit_of_work import unit_of_work
from app.recordings.models import MotionSession, Result


def date_back(engine: Engine, session_id: str, days: float) -> None:
    """Move a session and what was made of it into the past."""
    shift = timedelta(days=days)
    with unit_of_work(engine) as session:
        found = session.get_one(MotionSession, session_id)
        found.created_at -= shift
        if found.started_at is not None:
            found.started_at -= shift
        if found.ended_at is not None:
            found.ended_at -= shift
        for result in session.scalars(select(Result).where(Result.session_id == session_id)):
            result.created_at -= shift
        for comparison in session.scalars(select(Comparison).where(Comparison.session_id == session_id)):
            comparison.created_at -= shift
