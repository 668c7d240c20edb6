"""A patient's progress in one exercise: values over sessions, what may be said of their trend, and events beside it."""

from collections import defaultdict
from collections.abc import Mapping
from datetime import tzinfo
from itertools import pairwise

from sqlalchemy import select
from sqlalchemy.orm import Session

from app.accounts import audit
from app.accounts.subject import Subject
from app.assessment.course.attention import PAIN
from app.assessment.course.bands import bands_of, other_side_values, walked_other_side
from app.assessment.course.judgement import judged
from app.assessment.course.scatter import scatters_of
from app.assessment.measures import SessionValue, pooled_spread, session_values
from app.assessment.practice import zone_of
from app.assessment.schemas import Progress, ProgressEvent, ProgressMeasure, ProgressPoint, ProgressTrend
from app.assessment.walk_progress import walk_label, walk_order, walk_values
from app.errors import NotFound
from app.exercises.doses import DoseThen, dose_histories, lasting
from app.exercises.models import Exercise, Prescription, Template, TemplateVersion
from app.patients.access import require_patient
from app.patients.models import Patient
from app.recordings.models import SessionEvent
from estimators.comparison import measure_label
from estimators.gait import GUIDED_KINDS
from estimators.sentences import Sentence, say


def progress(
    session: Session,
    subject: Subject,
    patient_id: str,
    exercise_id: str | None,
    default_zone: str,
    until: str | None = None,
) -> Progress:
    """Return a patient's progress.

    Parameters
    ----------
    subject : Subject
        With the level `read`.
    exercise_id : str, optional
        The exercise practised last when absent: values of different exercises do not belong on one axis.
    default_zone : str
        Setting `time_zone`, for clinics that have not set theirs.
    until : str, optional
        A session: later ones are left out, so that its report says what was known with it.

    Raises
    ------
    NotFound
        No such patient or exercise in reach.
    """
    patient = require_patient(session, subject, patient_id, "read")
    audit.record(session, subject, "progress.read", patient_id, exercise_id)
    if exercise_id is not None:
        exercise = session.get(Exercise, exercise_id)
        if exercise is None or exercise.clinic_id != patient.clinic_id:
            raise NotFound(say("exercise.not_found"))
    values = session_values(session, [patient_id], exercise_id)
    walked = walk_values(session, [patient_id], exercise_id)
    last = next((value.at for value in [*values, *walked] if value.session_id == until), None)
    if last is not None:
        values, walked = ([one for one in found if one.at <= last] for found in (values, walked))
    zone = zone_of(session, patient.clinic_id, default_zone)
    if walked and (not values or walked[-1].at >= values[-1].at):
        return _of_walks(session, patient, walked, values, zone)
    if exercise_id is None and values:
        exercise_id = values[-1].exercise_id
        values = [value for value in values if value.exercise_id == exercise_id]
    # Of no exercise there are walks and other movements; whose strides were compared is not on one axis with these.
    walks = {value.session_id for value in walked}
    values = [value for value in values if value.session_id not in walks]
    exercise = session.get(Exercise, exercise_id) if exercise_id else None
    first = main_measure(exercise) if exercise else ""
    measures = _by_measure(values)
    names = sorted(measures, key=lambda name: (name != first, name))
    others = other_side_values(session, patient, exercise)
    known = scatters_of(session, patient.clinic_id, exercise, zone)
    found = judged({name: measures[name] for name in names}, names[0] if names else None, known, zone)
    return Progress(
        exercise_id=exercise_id,
        measures=[_measure(patient, measures[name], found[name], others) for name in names],
        events=_events(session, patient_id, exercise_id, values),
    )


def _of_walks(
    session: Session,
    patient: Patient,
    walked: list[SessionValue],
    compared: list[SessionValue],
    zone: tzinfo,
) -> Progress:
    """Return the progress of the walks of one kind; of all kinds, that of the newest.

    After the measures of the walk come those of its strides beside a template, where they were compared with one.
    """
    exercise_id = walked[-1].exercise_id
    values = [value for value in walked if value.exercise_id == exercise_id]
    walks = {value.session_id for value in values}
    beside = [value for value in compared if value.session_id in walks]
    measures, of_strides = _by_measure(values), _by_measure(beside)
    others = walked_other_side(patient, values)
    names, strides = sorted(measures, key=walk_order), sorted(of_strides)
    exercise = session.get(Exercise, exercise_id) if exercise_id else None
    known = scatters_of(session, patient.clinic_id, exercise, zone)
    found = judged(
        {name: measures[name] for name in names} | {name: of_strides[name] for name in strides},
        names[0],
        known,
        zone,
    )
    return Progress(
        exercise_id=exercise_id,
        measures=[_measure(patient, measures[name], found[name], others, walk_label(name)) for name in names]
        + [_measure(patient, of_strides[name], found[name], {}) for name in strides],
        events=_events(session, patient.id, exercise_id, sorted([*values, *beside], key=lambda one: one.at)),
    )


def _by_measure(values: list[SessionValue]) -> dict[str, list[SessionValue]]:
    found: dict[str, list[SessionValue]] = defaultdict(list)
    for value in values:
        found[value.measure].append(value)
    return found


def main_measure(exercise: Exercise) -> str:
    """Return the key of an exercise's main measure: the range of its primary angle."""
    return f"range:{exercise.primary_angle}"


def _measure(
    patient: Patient,
    values: list[SessionValue],
    trend: ProgressTrend,
    others: Mapping[str, SessionValue],
    label: str | None = None,
) -> ProgressMeasure:
    pooled = pooled_spread(values)
    return ProgressMeasure(
        measure=values[0].measure,
        label=label or measure_label(values[0].measure),
        unit=values[0].unit,
        points=[_point(value, pooled) for value in values],
        trend=trend,
        bands=bands_of(patient, values[-1], others),
    )


def _point(value: SessionValue, pooled: float | None) -> ProgressPoint:
    low, high = band(value, pooled)
    return ProgressPoint(
        session_id=value.session_id,
        at=value.at,
        value=value.mean,
        low=low,
        high=high,
        count=value.count,
        orientation=f"{value.orientation} {value.orientation_version}",
        template_version_id=value.template_version_id or None,
    )


def band(value: SessionValue, pooled: float | None) -> tuple[float, float]:
    """Return value plus and minus one standard deviation between repetitions.

    Parameters
    ----------
    pooled : float or None
        Stands in for a session with a single repetition.
    """
    spread = value.spread if value.spread is not None else pooled or 0.0
    return value.mean - spread, value.mean + spread


def _events(
    session: Session, patient_id: str, exercise_id: str | None, values: list[SessionValue]
) -> list[ProgressEvent]:
    if exercise_id is None:
        return []
    events = [*_estimator_events(values), *_pain_events(session, values)]
    used = {value.template_version_id for value in values}
    versions = session.execute(
        select(TemplateVersion.id, TemplateVersion.created_at, TemplateVersion.number, Template)
        .join(Template, Template.id == TemplateVersion.template_id)
        .where(Template.exercise_id == exercise_id, TemplateVersion.is_published)
        .where(TemplateVersion.id.in_(used))
    )
    for _, at, number, template in versions:
        text = say("progress.template", name=template.name, number=number)
        events.append(ProgressEvent(at=at, kind="template", text=text))
    prescriptions = session.execute(
        select(Prescription, Exercise)
        .join(Exercise, Exercise.id == Prescription.exercise_id)
        .where(Prescription.patient_id == patient_id, Prescription.exercise_id == exercise_id)
    )
    rows = [(prescription, exercise.movement) for prescription, exercise in prescriptions]
    history = dose_histories(session, [prescription for prescription, _ in rows])
    for prescription, movement in rows:
        # Each dose where it began to hold: a later one says nothing of the days before it.
        for held in lasting(history[prescription.id]):
            text = say("progress.prescribed", dose=dose(held, movement))
            events.append(ProgressEvent(at=held.start, kind="prescription", text=text))
    return sorted(events, key=lambda event: event.at)


def _estimator_events(values: list[SessionValue]) -> list[ProgressEvent]:
    """Mark the sessions from which on another estimator made the numbers."""
    sessions = {value.session_id: value for value in values}
    events = []
    for before, after in pairwise(sessions.values()):
        old = (before.orientation, before.orientation_version, before.pipeline_version)
        new = (after.orientation, after.orientation_version, after.pipeline_version)
        if old != new:
            text = say("progress.estimator", estimator=new[0], version=new[1], pipeline=new[2])
            events.append(ProgressEvent(at=after.at, kind="estimator", text=text))
    return events


def _pain_events(session: Session, values: list[SessionValue]) -> list[ProgressEvent]:
    """Mark the sessions that were stopped because it hurt."""
    at = {value.session_id: value.at for value in values}
    hurt = session.scalars(
        select(SessionEvent.session_id).where(SessionEvent.session_id.in_(at), SessionEvent.kind == PAIN)
    )
    return [ProgressEvent(at=at[one], kind="pain", text=say("progress.pain")) for one in sorted(set(hurt))]


def dose(prescription: Prescription | DoseThen, movement: str) -> Sentence:
    """Return a prescription's dose in a few words.

    Parameters
    ----------
    prescription : Prescription or DoseThen
        The present dose, or one that held once.
    movement : str
        Of its exercise. A walk is walked once in a session, whatever number of repetitions is stored with it.
    """
    amount = say("dose.repetitions", count=prescription.repetitions)
    if movement in GUIDED_KINDS:
        amount = say("dose.walk")
    elif prescription.sets > 1:
        amount = say("dose.sets", sets=prescription.sets, amount=amount)
    return say("dose.weekly", amount=amount, count=prescription.times_per_week)
