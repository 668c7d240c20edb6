"""A recorded session as comparisons and templates see it."""

from sqlalchemy.orm import Session

from app.recordings.analysis.kinds import kind_of
from app.recordings.compared import Source
from app.recordings.models import MotionSession, Result


def load_source(session: Session, found: MotionSession, result: Result) -> Source:
    """Read a result as what is compared, by its kind; access was checked."""
    return kind_of(result.setup).compared(session, found, result)
