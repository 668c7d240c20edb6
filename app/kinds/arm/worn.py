"""Events of the time line about a stored session's standing pose, as its movements showed it."""

from typing import Final

from app.database.unit_of_work import unit_of_work
from app.recordings.analysis.jobs import JobContext
from app.recordings.models import SessionEvent
from app.recordings.repository import replace_events
from estimators.calibration import JUDGED
from estimators.pipelines import SessionSetup

EVENT: Final = "calibration_checked"


def report_worn(context: JobContext, setup: SessionSetup, at_s: float) -> None:
    """Put what was found on the time line in place of what an earlier analysis found.

    Parameters
    ----------
    setup : SessionSetup
        Judged.
    at_s : float
        Session time of the end of the pose.
    """
    reasons = () if setup.calibration is None else setup.calibration.reasons
    events = [
        SessionEvent(session_id=context.session_id, kind=EVENT, time_s=max(0.0, at_s), text=reason)
        for reason in reasons
        if getattr(reason, "code", "") in JUDGED
    ]
    with unit_of_work(context.engine) as session:
        replace_events(session, context.session_id, EVENT, events)
