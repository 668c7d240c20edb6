"""Practice against prescription: the sessions done this week, and adherence over four weeks.

Prescriptions themselves are the room `exercises`; what of a session is valid is measured once, when it is analysed
(`app.assessment.practised`). Here they meet. Each session counts once:

1. for the prescription that it was begun from, when that is one of those given and had begun;
2. else for the oldest prescription of its exercise whose week is not full yet;
3. else, when all are full, for the oldest.
"""

from collections import Counter, defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta, tzinfo

from sqlalchemy import ColumnElement, and_, func, or_, select
from sqlalchemy.orm import Session

from app.accounts.models import Clinic
from app.accounts.subject import Subject
from app.assessment.design.compiled import design_of, effective_template
from app.assessment.design.day import valid_of_the_day
from app.assessment.design.dose import dose_of
from app.assessment.design.limits import Reached, resting_pose, troubles_of
from app.assessment.repository import newest_version
from app.assessment.worries.stopped import stopped_for_pain
from app.database.base import utc_now
from app.exercises import repository as exercises
from app.exercises.design import StopDesign
from app.exercises.doses import DoseHistory, DoseThen, dose_on, doses_of
from app.exercises.models import Prescription, TemplateVersion
from app.exercises.schemas import PrescriptionChangeOut, PrescriptionOut
from app.recordings.models import MotionSession
from app.time_zones import time_zone, week_start
from estimators.errors import EstimationError
from estimators.sentences import say

ADHERENCE_WINDOW = timedelta(days=28)
WHEN = func.coalesce(MotionSession.started_at, MotionSession.created_at)


@dataclass(frozen=True)
class Done:
    """One session that counts.

    Attributes
    ----------
    at : datetime
        When it began.
    prescription_id : str or None
        What it was begun from.
    repetitions : int
        Valid ones.
    active_s : float
        Time in them, in steady strides or in movement.
    """

    at: datetime
    exercise_id: str | None
    prescription_id: str | None = None
    repetitions: int = 0
    active_s: float = 0.0
    session_id: str = ""


def zone_of(session: Session, clinic_id: str, default_zone: str) -> tzinfo:
    """Return the time zone in which the weeks of a clinic begin.

    Parameters
    ----------
    default_zone : str
        Setting `time_zone`, for clinics that have not set theirs.
    """
    own = session.scalar(select(Clinic.time_zone).where(Clinic.id == clinic_id))
    return time_zone(own or default_zone)


def list_prescriptions(
    session: Session, subject: Subject, patient_id: str, default_zone: str
) -> list[PrescriptionOut]:
    """Return a patient's present and coming prescriptions with what was done of them this week.

    Parameters
    ----------
    subject : Subject
        With the level `read`.
    default_zone : str
        Setting `time_zone`.
    """
    rows = exercises.list_prescriptions(session, subject, patient_id)
    zone = zone_of(session, subject.clinic_id, default_zone)
    return _with_practice(session, patient_id, rows, zone)


def with_practice_of(
    session: Session, subject: Subject, one: tuple[Prescription, str, str | None], default_zone: str
) -> PrescriptionOut:
    """Return a prescription beside the patient's others, as a list would have it; access was checked.

    Parameters
    ----------
    one : tuple
        The prescription with the names of exercise and template.
    default_zone : str
        Setting `time_zone`.
    """
    patient_id = one[0].patient_id
    others = [row for row in exercises.present_prescriptions(session, patient_id) if row[0].id != one[0].id]
    zone = zone_of(session, subject.clinic_id, default_zone)
    return _with_practice(session, patient_id, [*others, one], zone)[-1]


def counts() -> ColumnElement[bool]:
    """Return the condition that a session counts as practice: something valid was done in it.

    Sessions that were analysed before this was measured count when they recorded anything.
    """
    end_s = func.coalesce(MotionSession.recording_end_s, MotionSession.duration_s)
    recorded = end_s > func.coalesce(MotionSession.recording_start_s, 0.0)
    unknown = and_(MotionSession.valid_repetitions.is_(None), MotionSession.active_s.is_(None))
    return and_(
        MotionSession.purpose == "exercise",
        MotionSession.state == "analysed",
        or_(MotionSession.valid_repetitions > 0, MotionSession.active_s > 0.0, and_(unknown, recorded)),
    )


def done_since(session: Session, patient_ids: Iterable[str], start: datetime) -> dict[str, list[Done]]:
    """Return the sessions that count since a time, by patient, oldest first; access was checked."""
    found: dict[str, list[Done]] = defaultdict(list)
    rows = session.execute(
        select(
            MotionSession.patient_id,
            MotionSession.started_at,
            MotionSession.created_at,
            MotionSession.exercise_id,
            MotionSession.prescription_id,
            MotionSession.valid_repetitions,
            MotionSession.active_s,
            MotionSession.id,
        )
        .where(MotionSession.patient_id.in_(patient_ids), counts(), start <= WHEN)
        .order_by(WHEN, MotionSession.id)
    )
    for (
        patient_id,
        started_at,
        created_at,
        exercise_id,
        prescribed,
        repetitions,
        active_s,
        session_id,
    ) in rows:
        began = started_at or created_at
        found[patient_id].append(
            Done(began, exercise_id, prescribed, repetitions or 0, active_s or 0.0, session_id)
        )
    return found


def last_done(session: Session, patient_ids: Iterable[str], start: datetime) -> dict[str, datetime]:
    """Return when each patient began the newest session that counts, where one did since a time; access was checked."""
    newest = (
        select(MotionSession.patient_id, func.max(WHEN))
        .where(MotionSession.patient_id.in_(patient_ids), counts(), start <= WHEN)
        .group_by(MotionSession.patient_id)
    )
    return {patient_id: began for patient_id, began in session.execute(newest) if began is not None}


def share_out(
    prescriptions: Sequence[Prescription],
    done: Iterable[Done],
    zone: tzinfo,
    *,
    from_monday: bool = False,
    history: DoseHistory | None = None,
) -> dict[str, list[Done]]:
    """Give each session to the one prescription that it counts for.

    Parameters
    ----------
    prescriptions : sequence of Prescription
        Of one patient.
    done : iterable of Done
        Oldest first.
    zone : tzinfo
        In which weeks begin.
    from_monday : bool
        Whether a prescription also takes what was done in its first week before it began.
    history : mapping of str to sequence of DoseThen, optional
        Doses over time: a week is full by the dose that held in it. Without it, by the present one.

    Returns
    -------
    dict of str to list of Done
        By prescription; a session of an exercise that nobody prescribed is in none.
    """
    oldest_first = sorted(prescriptions, key=lambda one: (one.starts_at, one.id))
    shared: dict[str, list[Done]] = {one.id: [] for one in oldest_first}
    taken: Counter[tuple[str, datetime]] = Counter()
    doses = {one.id: _doses(one, history) for one in oldest_first}
    for each in done:
        week = week_start(each.at, zone)
        fitting = [
            one
            for one in oldest_first
            if one.exercise_id == each.exercise_id
            and (week_start(one.starts_at, zone) if from_monday else one.starts_at) <= each.at
            and (one.ends_at is None or each.at <= one.ends_at)
        ]
        if not fitting:
            continue
        named = [one for one in fitting if one.id == each.prescription_id]
        open_yet = [
            one for one in fitting if taken[one.id, week] < dose_on(doses[one.id], each.at).times_per_week
        ]
        chosen = (named or open_yet or fitting)[0]
        taken[chosen.id, week] += 1
        shared[chosen.id].append(each)
    return shared


def adherence(
    prescriptions: Sequence[Prescription],
    done: Iterable[Done],
    now: datetime,
    zone: tzinfo,
    history: DoseHistory | None = None,
) -> float | None:
    """Return sessions done in percent of sessions prescribed, over the last four weeks; None before the first
    is due.

    Parameters
    ----------
    prescriptions : sequence of Prescription
        Of one patient.
    done : iterable of Done
        Oldest first.
    zone : tzinfo
        In which weeks begin.
    history : mapping of str to sequence of DoseThen, optional
        Doses over time (`dose_histories`): each day is judged by the dose that held on it, so that a changed dose makes
        no past week better or worse. Without it the present dose holds for all of it.

    Notes
    -----
    More than prescribed in one exercise does not make up for none in another: each counts at most in full. Where days
    are named, a session is due on each of them that is over; otherwise they are due evenly over the week.
    """
    shared = share_out(prescriptions, done, zone, history=history)
    expected_total, done_total = 0.0, 0.0
    for prescription in prescriptions:
        start = max(prescription.starts_at, now - ADHERENCE_WINDOW)
        end = min(prescription.ends_at or now, now)
        expected = sum(
            _expected(one, max(start, one.start), min(end, one.end or end), zone)
            for one in _doses(prescription, history)
        )
        count = sum(1 for one in shared[prescription.id] if start <= one.at <= end)
        expected_total += expected
        done_total += min(float(count), expected)
    return round(100.0 * done_total / expected_total, 1) if expected_total >= 1.0 else None


def _doses(prescription: Prescription, history: DoseHistory | None) -> Sequence[DoseThen]:
    return (history or {}).get(prescription.id) or doses_of(prescription)


def _expected(dose: DoseThen, start: datetime, end: datetime, zone: tzinfo) -> float:
    """Return how many sessions of a dose were due between two moments."""
    if not dose.days:
        return dose.times_per_week * max(0.0, (end - start) / timedelta(weeks=1))
    first, last = start.astimezone(zone).date(), end.astimezone(zone).date()
    dates = (first + timedelta(days=number) for number in range(max(0, (last - first).days)))
    return float(max(1, len(dose.times)) * sum(1 for day in dates if day.isoweekday() in dose.days))


def _pain_stops(
    session: Session,
    patient_id: str,
    prescriptions: Sequence[Prescription],
    shared: dict[str, list[Done]],
    start: datetime,
    zone: tzinfo,
) -> Counter[str]:
    """Return how many sessions since a time ended because it hurt, by prescription, whether they count or not."""
    hurt = stopped_for_pain(session, [patient_id], start)[patient_id]
    ids = {one.session_id for one in hurt}
    counted = {one.session_id for rows in shared.values() for one in rows}
    others = [
        Done(one.at, one.exercise_id, one.prescription_id) for one in hurt if one.session_id not in counted
    ]
    uncounted = share_out(prescriptions, others, zone, from_monday=True)
    return Counter(
        {
            one.id: sum(each.session_id in ids for each in shared[one.id]) + len(uncounted[one.id])
            for one in prescriptions
        }
    )


def _with_practice(
    session: Session, patient_id: str, rows: list[tuple[Prescription, str, str | None]], zone: tzinfo
) -> list[PrescriptionOut]:
    now = utc_now()
    today = now.astimezone(zone).date()
    start = week_start(now, zone)
    done = done_since(session, [patient_id], start)[patient_id]
    shared = share_out([row[0] for row in rows], done, zone, from_monday=True)
    hurt = _pain_stops(session, patient_id, [row[0] for row in rows], shared, start, zone)
    valid = valid_of_the_day(session, patient_id, [row[0].id for row in rows], now, zone)
    counted = set(
        session.scalars(
            select(TemplateVersion.template_id).where(
                TemplateVersion.template_id.in_([row[0].template_id for row in rows]),
                TemplateVersion.is_published,
            )
        )
    )
    changes = exercises.changes_of(session, [row[0].id for row in rows])
    answers = []
    for row, exercise, template in rows:
        dose = dose_of(row.repetitions, row.sets, ())
        is_counted = row.template_id in counted
        sessions = sum(one.at.astimezone(zone).date() == today for one in shared[row.id])
        answers.append(
            PrescriptionOut(
                id=row.id,
                exercise_id=row.exercise_id,
                exercise_name=exercise,
                template_id=row.template_id,
                template_name=template,
                repetitions=row.repetitions,
                sets=row.sets,
                times_per_week=row.times_per_week,
                days=row.days,
                times=row.times,
                tolerance_scale=row.tolerance_scale,
                stops=[StopDesign.model_validate(one) for one in row.stops],
                question=row.question,
                is_due_today=row.starts_at <= now and (not row.days or today.isoweekday() in row.days),
                goal=dose.goal if is_counted else 0,
                goal_done=dose.after(valid[row.id], len(row.times)).before if is_counted else 0,
                done_today=dose.times_done(valid[row.id]) if is_counted else sessions,
                starts_at=row.starts_at,
                ends_at=row.ends_at,
                done_this_week=len(shared[row.id]),
                pain_stops_this_week=hurt[row.id],
                repetitions_this_week=sum(one.repetitions for one in shared[row.id]),
                active_s_this_week=sum(one.active_s for one in shared[row.id]),
                number=1 + len(changes[row.id]),
                changes=[
                    PrescriptionChangeOut(changed_at=one.created_at, changed_by=name, before=one.before)
                    for one, name in changes[row.id]
                ],
                troubles=_troubles(session, row),
                is_twice=any(_run_together(row, other) for other, _, _ in rows),
            )
        )
    return answers


def _troubles(session: Session, row: Prescription) -> list[str]:
    """Return which stored limits cannot hold: after an upgrade, with a newer template, or at this patient's rest.

    A template of the clinic knows no patient when it is drawn: its own rules are held against who it is prescribed to.
    """
    version = None if row.template_id is None else newest_version(session, row.template_id)
    if version is None:
        return []
    of_template = design_of(version).stops or []
    if not of_template and not row.stops:
        return []
    try:
        drawn = effective_template(version)
    except EstimationError:
        # It says so itself where it is shown.
        return []
    rest = resting_pose(session, row.patient_id, row.exercise_id)
    stops = [StopDesign.model_validate(one) for one in row.stops]
    reached = Reached(drawn, rest=rest)
    return [
        *(say("prescription.of_template", trouble=text) for _, text in troubles_of(of_template, reached)),
        *(text for _, text in troubles_of(stops, reached)),
    ]


def _run_together(one: Prescription, other: Prescription) -> bool:
    return (
        one.id != other.id
        and one.exercise_id == other.exercise_id
        and (one.ends_at is None or other.starts_at < one.ends_at)
        and (other.ends_at is None or one.starts_at < other.ends_at)
    )
