"""Reasons to look at a patient's last session: too few valid repetitions."""

from collections.abc import Sequence
from typing import Final

from app.exercises.doses import DoseHistory, dose_on, doses_of
from app.exercises.models import Exercise, Prescription
from app.recordings.models import MotionSession
from estimators.gait import GUIDED_KINDS
from estimators.sentences import say

PAIN: Final = "pain"
"""Kind of the event that stands on the time line where a patient stopped because it hurt."""
LEAST_VALID: Final = 0.5
"""Share of the prescribed repetitions below which too few were valid."""


def too_few(
    last: MotionSession, given: Sequence[tuple[Prescription, Exercise]], doses: DoseHistory | None = None
) -> str:
    """Say that too few repetitions were valid; empty where there were enough, or none are counted.

    Parameters
    ----------
    last : MotionSession
        The patient's last one.
    given : sequence of (Prescription, Exercise)
        What is prescribed now. Walks are not counted in repetitions.
    doses : mapping of str to sequence of DoseThen, optional
        Over time: the session is judged by the dose that held when it began. Without it, by the present one.
    """
    valid = last.valid_repetitions
    began = last.started_at or last.created_at
    held = [
        dose_on((doses or {}).get(prescription.id) or doses_of(prescription), began)
        for prescription, exercise in given
        if exercise.id == last.exercise_id and exercise.movement not in GUIDED_KINDS
    ]
    wanted = [one.repetitions * one.sets for one in held]
    if last.state != "analysed" or valid is None or not wanted:
        return ""
    if valid >= LEAST_VALID * min(wanted):
        return ""
    return say("caseload.few_repetitions", valid=valid, count=min(wanted))
