"""How many valid repetitions of prescriptions a day has brought: toward the goal of the page and of today's card."""

from collections import Counter
from collections.abc import Collection
from datetime import UTC, datetime, time, tzinfo

from sqlalchemy import func, select
from sqlalchemy.orm import Session

from app.recordings.models import MotionSession, SessionEvent


def valid_of_the_day(
    session: Session, patient_id: str, prescription_ids: Collection[str], until: datetime, zone: tzinfo
) -> Counter[str]:
    """Count the valid repetitions of sessions of one day that were begun from prescriptions; access was checked.

    Parameters
    ----------
    until : datetime
        The day is that of this moment; sessions that began at it or later do not count.
    zone : tzinfo
        By whose clocks the day begins.

    Returns
    -------
    Counter of str
        By prescription.

    Notes
    -----
    As they were counted before the patient's eyes, from their end on; what nothing counted live counts as soon as its
    analysis has.
    """
    begins = datetime.combine(until.astimezone(zone).date(), time(), zone).astimezone(UTC)
    begun = session.execute(
        select(MotionSession.id, MotionSession.prescription_id, MotionSession.valid_repetitions).where(
            MotionSession.patient_id == patient_id,
            MotionSession.prescription_id.in_(prescription_ids),
            MotionSession.purpose == "exercise",
            # Not when it came here: a recording of another day that was uploaded today is not of today.
            func.coalesce(MotionSession.started_at, MotionSession.created_at) >= begins,
            func.coalesce(MotionSession.started_at, MotionSession.created_at) < until,
        )
    ).all()
    live: Counter[str] = Counter()
    events = select(SessionEvent.session_id, SessionEvent.details).where(
        SessionEvent.session_id.in_([one.id for one in begun]), SessionEvent.kind == "repetition"
    )
    for session_id, details in session.execute(events):
        live[session_id] += details.get("kind") == "valid"
    valid: Counter[str] = Counter()
    for session_id, prescription_id, analysed in begun:
        assert prescription_id is not None, "asked for by prescription"
        valid[prescription_id] += live.get(session_id, analysed or 0)
    return valid
