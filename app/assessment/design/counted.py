"""Counts made while a session goes on: the same afterwards in comparison, practice and reports."""

from sqlalchemy import select
from sqlalchemy.orm import Session

from app.recordings.models import MotionSession, SessionEvent
from estimators.comparison import Repetition
from estimators.sentences import say


def counted_live(session: Session, found: MotionSession) -> list[Repetition] | None:
    """Return the repetitions that the guidance of a session counted, in session time.

    Parameters
    ----------
    found : MotionSession
        Access was checked.

    Returns
    -------
    list of Repetition or None
        None where nothing was counted: whoever compares looks for repetitions then. Another movement than that of the
        template is left out; what did not go far enough is compared all the same.
    """
    events = session.scalars(
        select(SessionEvent)
        .where(SessionEvent.session_id == found.id, SessionEvent.kind == "repetition")
        .order_by(SessionEvent.time_s, SessionEvent.id)
    ).all()
    counted = []
    for number, one in enumerate(events, start=1):
        kind = str(one.details["kind"])
        is_other = kind == "wrong"
        counted.append(
            Repetition(
                number,
                float(one.details["start_s"]),
                one.time_s,
                is_kept=not is_other,
                reason=say("repetition.other_movement") if is_other else "",
                counted=kind,
            )
        )
    return counted or None
