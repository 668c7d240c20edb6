"""Which template a session follows, on which side, and how often: what its prescription says."""

from dataclasses import dataclass, replace

from sqlalchemy import select
from sqlalchemy.orm import Session

from app.assessment.design.compiled import Guidance, guidance_of
from app.assessment.design.day import valid_of_the_day
from app.assessment.design.dose import Dose, dose_of
from app.assessment.practice import zone_of
from app.exercises.design import StopDesign
from app.exercises.models import Exercise, Prescription, TemplateVersion
from app.patients.models import Patient
from app.recordings.analysis.kinds import kind_of
from app.recordings.models import MotionSession
from estimators.conventions import Side
from estimators.errors import SetupError
from estimators.leg import lower_segment
from estimators.pipelines import SessionSetup


@dataclass(frozen=True)
class PrescribedGuidance:
    """What a session is guided by.

    Attributes
    ----------
    guidance : Guidance
        Its stop rules are those that look at the movement and the time; numbers of repetitions are in `dose`.
    """

    guidance: Guidance
    dose: Dose


class NotGuided(SetupError):
    """What is prescribed is compared with its template afterwards; the message says so, for people."""


def prescribed_guidance(session: Session, session_id: str, default_zone: str) -> PrescribedGuidance | None:
    """Return what a session is guided by; None without a prescription that has a template.

    For the service's own work: access to the session was checked.

    Parameters
    ----------
    default_zone : str
        Setting `time_zone`, for clinics that have not set theirs.

    Raises
    ------
    SetupError
        If the template does not move enough to be followed; `NotGuided` where this kind of session is not guided.
    """
    found = session.get(MotionSession, session_id)
    version_id = None if found is None else prescribed_version(session, found)
    if found is None or version_id is None:
        return None
    version = session.get_one(TemplateVersion, version_id)
    prescription = session.get_one(Prescription, found.prescription_id)
    setup = SessionSetup.from_dict(found.setup)
    if refused := kind_of(setup).guidance_refused:
        raise NotGuided(refused)
    guidance = guidance_of(
        version,
        exercise_side(session, found, frozenset(setup.placements)),
        setup.body.upper_arm_m + setup.body.forearm_m,
        scale=prescription.tolerance_scale,
        more_stops=[StopDesign.model_validate(one) for one in prescription.stops],
        posture=session.get_one(Exercise, prescription.exercise_id).posture,
    )
    dose = dose_of(prescription.repetitions, prescription.sets, guidance.stops)
    zone = zone_of(session, found.clinic_id, default_zone)
    valid = valid_of_the_day(session, found.patient_id, [prescription.id], found.created_at, zone)
    dose = dose.after(valid[prescription.id], len(prescription.times))
    # Whoever counts for the page stops at these numbers too, so that both are always the same.
    others = tuple(rule for rule in guidance.stops if rule.kind not in ("valid_count", "attempt_count"))
    return PrescribedGuidance(replace(guidance, stops=others), dose)


def prescribed_version(session: Session, found: MotionSession) -> str | None:
    """Return the newest version of the template that a session was prescribed with; None without one."""
    if found.prescription_id is None:
        return None
    return session.scalar(
        select(TemplateVersion.id)
        .join(Prescription, Prescription.template_id == TemplateVersion.template_id)
        .where(Prescription.id == found.prescription_id, TemplateVersion.is_published)
        .order_by(TemplateVersion.number.desc())
        .limit(1)
    )


def exercise_side(session: Session, found: MotionSession, measured: frozenset[str]) -> Side:
    """Return the side of the exercise; if its arm or leg carries no sensor and the other does, the other.

    Parameters
    ----------
    measured : frozenset of str
        Segments that carry a sensor.
    """
    exercise = session.get(Exercise, found.exercise_id) if found.exercise_id else None
    patient = session.get_one(Patient, found.patient_id)
    named = exercise.side if exercise is not None else patient.affected_side
    side: Side = "left" if named == "left" else "right"
    other: Side = "right" if side == "left" else "left"
    limb = (lower_segment(exercise.primary_angle) if exercise is not None else "") or "upper_arm"
    if f"{limb}_{side}" not in measured and f"{limb}_{other}" in measured:
        return other
    return side
