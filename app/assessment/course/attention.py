"""What of a patient's last session asks for attention: pain, compensation, too few valid repetitions."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

from sqlalchemy import select
from sqlalchemy.orm import Session

from app.assessment.models import Comparison
from app.exercises.models import Exercise, Prescription
from app.recordings.models import MotionSession, SessionAnswers, SessionEvent
from app.sentences import say
from estimators.comparison import channel_name
from estimators.gait import GUIDED_KINDS

PAIN: Final = "pain"
"""Kind of the event that stands on the time line where a patient stopped because it hurt."""
MUCH_PAIN: Final = 5
"""Of 10, answered after a session: from here on it is a reason to look."""
LEAST_VALID: Final = 0.5
"""Share of the prescribed repetitions below which too few were valid."""
LEAST_MORE: Final = {"deg": 5.0, "m": 0.025}
"""A trunk that leans less than this more than in the template, or a shoulder that rises less, is no reason to look."""
_SIGMAS: Final = 2.0


@dataclass(frozen=True)
class Last:
    """A patient's last session.

    Attributes
    ----------
    session : MotionSession
    has_pain : bool
        It was stopped because it hurt.
    compensation : str
        What helped the arm, in words; empty where nothing did.
    pain_mark : int or None
        What the patient answered afterwards, where it is much.
    """

    session: MotionSession
    has_pain: bool
    compensation: str
    pain_mark: int | None = None

    def too_few(self, given: Sequence[tuple[Prescription, Exercise]]) -> str:
        """Say that too few repetitions were valid; empty where there were enough, or none are counted.

        Parameters
        ----------
        given : sequence of (Prescription, Exercise)
            What is prescribed now. Walks are not counted in repetitions.
        """
        valid = self.session.valid_repetitions
        wanted = [
            prescription.repetitions * prescription.sets
            for prescription, exercise in given
            if exercise.id == self.session.exercise_id and exercise.movement not in GUIDED_KINDS
        ]
        if self.session.state != "analysed" or valid is None or not wanted:
            return ""
        if valid >= LEAST_VALID * min(wanted):
            return ""
        return say("caseload.few_repetitions", valid=valid, count=min(wanted))


def last_sessions(session: Session, found: Sequence[MotionSession]) -> dict[str, Last]:
    """Return what of each last session asks for attention, by patient; access was checked.

    Parameters
    ----------
    session : Session
    found : sequence of MotionSession
        One of each patient.
    """
    ids = [one.id for one in found]
    hurt = set(
        session.scalars(
            select(SessionEvent.session_id).where(SessionEvent.session_id.in_(ids), SessionEvent.kind == PAIN)
        )
    )
    answered = select(SessionAnswers.session_id, SessionAnswers.pain).where(
        SessionAnswers.session_id.in_(ids), SessionAnswers.pain >= MUCH_PAIN
    )
    marks = {row.session_id: row.pain for row in session.execute(answered)}
    compared = select(Comparison.session_id, Comparison.result_id, Comparison.summary).where(
        Comparison.session_id.in_(ids)
    )
    main = {one.id: one.main_result_id for one in found}
    # The newest of the main result wins.
    summaries: dict[str, dict[str, Any]] = {
        session_id: summary
        for session_id, result_id, summary in session.execute(compared.order_by(Comparison.created_at))
        if result_id == main[session_id]
    }
    return {
        one.patient_id: Last(one, one.id in hurt, _compensation(summaries.get(one.id, {})), marks.get(one.id))
        for one in found
    }


def _compensation(summary: dict[str, Any]) -> str:
    """Return the largest excess over the template that is neither small nor within its own uncertainty, in words."""
    largest, text = 1.0, ""
    for one in summary.get("measures", []):
        if one["group"] != "compensation" or one["value"] is None or one["template_value"] is None:
            continue
        more, count = one["value"] - one["template_value"], max(one["count"], 1)
        chance = _SIGMAS * (one["uncertainty"] or 0.0) / math.sqrt(count)
        share = more / LEAST_MORE.get(one["unit"], math.inf)
        if more > chance and share > largest:
            channel = channel_name(one["measure"].partition(":")[2])
            largest = share
            text = (
                say("caseload.compensation_length", channel=channel, more_m=more)
                if one["unit"] == "m"
                else say("caseload.compensation_angle", channel=channel, more_rad=math.radians(more))
            )
    return text


__all__ = ["LEAST_MORE", "LEAST_VALID", "PAIN", "Last", "last_sessions"]
