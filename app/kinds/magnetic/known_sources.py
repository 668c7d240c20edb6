"""A magnetic source of the clinic by its identifier, and what a session that wears it declares."""

from typing import Any, Final

from sqlalchemy.orm import Session

from app.accounts.subject import Subject
from app.errors import NotFound
from app.recordings.models import MagneticSource
from estimators.sentences import say

NO_SUCH_SOURCE: Final = say("source.not_found")


def find_source(session: Session, subject: Subject, source_id: str) -> MagneticSource:
    """Return a source of the subject's clinic, retired or not; `NotFound` otherwise."""
    row = session.get(MagneticSource, source_id)
    if row is None or row.clinic_id != subject.clinic_id:
        raise NotFound(NO_SUCH_SOURCE)
    return row


def parameters_of(session: Session, subject: Subject, source_id: str) -> dict[str, Any]:
    """Return what a session's setup declares of a source of the clinic.

    Raises
    ------
    NotFound
        No such source in this clinic, or it is retired.
    """
    row = find_source(session, subject, source_id)
    if row.retired_at is not None:
        raise NotFound(NO_SUCH_SOURCE)
    return {
        "calibrated_coils": row.coils,
        "current_limit_a": row.current_limit_a,
        "gain_sigma": row.gain_sigma,
        "source_name": row.name,
        "source_serial": row.serial,
        "calibrated_on": row.calibrated_at.date().isoformat(),
    }
