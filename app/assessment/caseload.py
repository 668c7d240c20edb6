"""The caseload: one line a patient, with its worries and at most one reason to look, sorted by the most urgent.

Worries (`app.assessment.worries`) happened in a session and stay until a therapist has marked them as seen: `pain`,
`stop`, `link_lost`, `compensation`. The line has the gravest of them, the newest of its kind, and how many there are.
Reasons besides are states of today, and go when they are over: `link_lost` (a session is open and nothing comes from
its sensors), `declining` (the main measure falls with a probability of 0.95 or more), `few_repetitions` (fewer
than half of the prescribed ones were valid), `not_practising`, `rarely_practised` (fewer than half of the sessions that
were due in four weeks), `bad_data` (the last session failed or lost more than a tenth of its packets), `no_template`.
The reason of a line is the most urgent of both. That somebody streams is no worry: it stands beside the reason in
`live_state` and ranks nobody. Each line offers one next action, which follows from these.
"""

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta, tzinfo
from typing import Any, Final, Literal, get_args

from sqlalchemy import func, or_, select
from sqlalchemy.orm import Session

from app.accounts.subject import Subject
from app.assessment.course.attention import too_few
from app.assessment.course.judgement import Decline, decline_of
from app.assessment.course.scatter import scatters_of
from app.assessment.course.trend import by_day
from app.assessment.measures import SessionValue, by_patient, pooled_spread, session_values
from app.assessment.practice import ADHERENCE_WINDOW, WHEN, adherence, done_since, last_done, zone_of
from app.assessment.progress import band, dose, main_measure
from app.assessment.schemas import CaseloadRow
from app.assessment.worries.found import unseen, worries_of
from app.assessment.worries.schemas import WorryOut
from app.assessment.worries.stopped import stopped_for_pain
from app.database.base import utc_now
from app.exercises.doses import DoseHistory, dose_histories
from app.exercises.models import Exercise, Prescription, TemplateVersion
from app.pages import Page
from app.patients.access import visible_patients
from app.patients.models import Patient
from app.patients.repository import note_once_an_hour, treated_patients
from app.recordings.models import MotionSession
from estimators.comparison import measure_label
from estimators.sentences import say

Reason = Literal[
    "pain",
    "stop",
    "declining",
    "link_lost",
    "compensation",
    "few_repetitions",
    "not_practising",
    "rarely_practised",
    "bad_data",
    "no_template",
    "",
]
ORDER: Final[tuple[Reason, ...]] = get_args(Reason)
Action = Literal[
    "watch", "open_live", "replay", "progress", "contact", "record_template", "prescribe", "open"
]
_ACTIONS: Final[dict[Reason, Action]] = {
    "pain": "replay",
    "stop": "replay",
    "declining": "progress",
    "link_lost": "open_live",
    "compensation": "replay",
    "few_repetitions": "replay",
    "not_practising": "contact",
    "rarely_practised": "contact",
    "bad_data": "replay",
    "no_template": "record_template",
}
LiveState = Literal["streaming", "link_lost"]

LIVE_STATES = ("calibrating", "ready", "recording", "link_lost")
QUIET = timedelta(days=7)
"""Without a session for this long, somebody with a prescription is not practising; rarer prescriptions get
longer."""
LOSS_LIMIT = 0.10
LEAST_ADHERENCE_PERCENT = 50.0
"""Of the sessions that were due; asked after a week, before which one missed is no habit."""
PRACTICE_WINDOW = 4 * ADHERENCE_WINDOW
"""What was done before it is not looked at."""


@dataclass
class _Sessions:
    """What a line needs to know about a patient's sessions."""

    last: MotionSession | None = None
    live_id: str | None = None
    live_state: LiveState | None = None
    lost_id: str | None = None
    """An open session from whose sensors nothing comes, also where another one streams."""
    practised_at: datetime | None = None


@dataclass
class _Line:
    """Where a patient stands in the order, and what that was worked out from."""

    patient: Patient
    prescriptions: list[tuple[Prescription, Exercise]]
    sessions: _Sessions
    values: list[SessionValue]
    exercise: Exercise | None
    adherence_percent: float | None
    worries: list[WorryOut]
    """Those that nobody has marked as seen, the gravest first."""
    state: tuple[Reason, str]
    """A reason to look that is no worry, and its words."""
    pain_stops: int

    @property
    def worry(self) -> WorryOut | None:
        """The gravest worry, where it is no less urgent than what else there is."""
        first = next(iter(self.worries), None)
        if first is None or ORDER.index(first.kind) > ORDER.index(self.state[0]):
            return None
        return first

    @property
    def reason(self) -> Reason:
        return self.state[0] if self.worry is None else self.worry.kind

    @property
    def place(self) -> list[Any]:
        return [
            ORDER.index(self.reason),
            self.patient.family_name,
            self.patient.given_name,
            self.patient.id,
        ]


def caseload(session: Session, subject: Subject, default_zone: str, page: Page) -> list[CaseloadRow]:
    """Return a page of the lines of the patients in reach.

    Parameters
    ----------
    default_zone : str
        Setting `time_zone`, for clinics that have not set theirs.
    page : Page
        The order is worked out from everybody's newest sessions and how often they practised: who rises between two
        pages is seen in both. What the order does not ask for is worked out for the patients of the page alone.
    """
    now = utc_now()
    zone = zone_of(session, subject.clinic_id, default_zone)
    patients = list(session.scalars(visible_patients(subject).where(Patient.archived_at.is_(None))))
    ids = [patient.id for patient in patients]
    note_once_an_hour(session, subject, "caseload.read", ids)
    prescriptions = _prescriptions(session, ids, now)
    sessions = _sessions(session, ids, now)
    with_version = set(session.scalars(select(TemplateVersion.template_id).distinct()))
    mains = _main_exercises(session, ids, prescriptions, sessions)
    values = by_patient(
        session_values(session, ids, measures=sorted({main_measure(e) for e in mains.values()}))
    )
    worries = worries_of(session, ids)
    hurt = stopped_for_pain(session, ids, now - ADHERENCE_WINDOW)
    doses = dose_histories(session, [one for given in prescriptions.values() for one, _ in given])
    done = done_since(session, [one for one in ids if prescriptions[one]], now - PRACTICE_WINDOW)
    lines = []
    for patient in patients:
        exercise = mains.get(patient.id)
        own = [
            value
            for value in values.get(patient.id, [])
            if exercise is not None
            and value.exercise_id == exercise.id
            and value.measure == main_measure(exercise)
        ]
        given, found = prescriptions[patient.id], sessions[patient.id]
        practised = adherence([one for one, _ in given], done[patient.id], now, zone, doses)
        decline = decline_of(own, scatters_of(session, subject.clinic_id, exercise, zone), zone)
        state = _state(given, found, decline, with_version, now, practised, doses)
        waiting = unseen(worries[patient.id])
        stops = len(hurt[patient.id])
        lines.append(_Line(patient, given, found, own, exercise, practised, waiting, state, stops))
    lines.sort(key=lambda line: line.place)
    shown = page.cut(lines, lambda line: line.place)
    treated = treated_patients(session, subject, [line.patient.id for line in shown])
    return [_row(line, zone, may_treat=line.patient.id in treated) for line in shown]


def _due(prescriptions: Sequence[tuple[Prescription, Exercise]]) -> str:
    """Return what is prescribed, exercise by exercise; empty for nothing."""
    text = ""
    for prescription, exercise in prescriptions:
        amount = dose(prescription, exercise.movement)
        if text:
            text = say("caseload.due_also", before=text, name=exercise.name, dose=amount)
        else:
            text = say("caseload.due", name=exercise.name, dose=amount)
    return text


def _row(line: _Line, zone: tzinfo, *, may_treat: bool) -> CaseloadRow:
    patient, sessions, values, exercise = line.patient, line.sessions, line.values, line.exercise
    shown = by_day(values, zone)
    pooled = pooled_spread(values)
    bands = [band(value, pooled) for value in shown]
    last = sessions.last
    return CaseloadRow(
        patient_id=patient.id,
        given_name=patient.given_name,
        family_name=patient.family_name,
        affected_side=patient.affected_side,
        due=_due(line.prescriptions),
        last_session_at=(last.started_at or last.created_at) if last else None,
        live_session_id=sessions.live_id,
        live_state=sessions.live_state,
        main_measure=measure_label(main_measure(exercise)) if exercise and values else None,
        main_measure_name=main_measure(exercise) if exercise and values else None,
        main_unit=values[-1].unit if values else None,
        trend=[value.mean for value in shown],
        trend_days=[value.at.astimezone(zone).date() for value in shown],
        trend_low=[low for low, _ in bands],
        trend_high=[high for _, high in bands],
        adherence_percent=line.adherence_percent,
        pain_stops=line.pain_stops,
        reason=line.reason,
        reason_text=line.state[1] if line.worry is None else line.worry.said("text"),
        worry=next(iter(line.worries), None),
        worry_count=len(line.worries),
        may_treat=may_treat,
        action=_action(line),
        action_session_id=_action_session(line),
    )


def _action(line: _Line) -> Action:
    """Return the one thing to do next: with whom moves now, with what the reason is, or with what is lacking."""
    if line.sessions.live_state == "streaming":
        return "watch"
    if line.reason == "bad_data" and line.sessions.last is not None and line.sessions.last.state == "failed":
        return "contact"
    return _ACTIONS.get(line.reason) or ("open" if line.prescriptions else "prescribe")


def _action_session(line: _Line) -> str | None:
    action = _action(line)
    if action == "watch":
        return line.sessions.live_id
    if line.worry is not None and action in {"replay", "open_live"}:
        return line.worry.session_id
    if action == "open_live":
        return line.sessions.lost_id
    return line.sessions.last.id if action == "replay" and line.sessions.last is not None else None


def _state(
    given: list[tuple[Prescription, Exercise]],
    sessions: _Sessions,
    decline: Decline | None,
    with_version: set[str],
    now: datetime,
    practised_percent: float | None,
    doses: DoseHistory,
) -> tuple[Reason, str]:
    """Return the most urgent reason to look that is no worry."""
    prescriptions = [prescription for prescription, _ in given]
    if decline is not None:
        return "declining", decline.text
    if sessions.lost_id is not None:
        return "link_lost", say("caseload.link_lost")
    if sessions.last is not None and (text := too_few(sessions.last, given, doses)):
        return "few_repetitions", text
    quiet = _quiet_for(prescriptions, sessions, now)
    if quiet is not None:
        return "not_practising", say("caseload.not_practising", count=quiet.days)
    if _is_rare(prescriptions, practised_percent, now):
        return "rarely_practised", say("caseload.rarely_practised", share=(practised_percent or 0.0) / 100.0)
    text = _bad_data(sessions.last)
    if text:
        return "bad_data", text
    if any(p.template_id is None or p.template_id not in with_version for p in prescriptions):
        return "no_template", say("caseload.no_template")
    return "", ""


def _quiet_for(prescriptions: list[Prescription], sessions: _Sessions, now: datetime) -> timedelta | None:
    if not prescriptions:
        return None
    often = max(prescription.times_per_week for prescription in prescriptions)
    allowed = max(QUIET, 2 * timedelta(weeks=1) / often)
    begun = min(prescription.starts_at for prescription in prescriptions)
    quiet = now - max(sessions.practised_at or begun, begun)
    return quiet if quiet > allowed else None


def _is_rare(prescriptions: list[Prescription], practised_percent: float | None, now: datetime) -> bool:
    if practised_percent is None or practised_percent >= LEAST_ADHERENCE_PERCENT:
        return False
    return now - min(prescription.starts_at for prescription in prescriptions) >= QUIET


def _bad_data(last: MotionSession | None) -> str:
    if last is None:
        return ""
    if last.state == "failed":
        return say("caseload.failed")
    total = last.packets_stored + last.packets_missing
    if total and last.packets_missing / total > LOSS_LIMIT:
        return say("caseload.lost", share=last.packets_missing / total)
    return ""


def _prescriptions(
    session: Session, ids: list[str], now: datetime
) -> dict[str, list[tuple[Prescription, Exercise]]]:
    found: dict[str, list[tuple[Prescription, Exercise]]] = defaultdict(list)
    rows = session.execute(
        select(Prescription, Exercise)
        .join(Exercise, Exercise.id == Prescription.exercise_id)
        .where(
            Prescription.patient_id.in_(ids),
            Prescription.starts_at <= now,
            or_(Prescription.ends_at.is_(None), Prescription.ends_at > now),
        )
        .order_by(Prescription.starts_at, Prescription.id)
    )
    for prescription, exercise in rows:
        found[prescription.patient_id].append((prescription, exercise))
    return found


def _sessions(session: Session, ids: list[str], now: datetime) -> dict[str, _Sessions]:
    found: dict[str, _Sessions] = defaultdict(_Sessions)
    ranked = (
        select(
            MotionSession.id,
            func.row_number().over(partition_by=MotionSession.patient_id, order_by=WHEN.desc()).label("rank"),
        )
        .where(
            MotionSession.patient_id.in_(ids),
            MotionSession.purpose == "exercise",
            MotionSession.state != "created",
        )
        .subquery()
    )
    last = select(MotionSession).join(ranked, (ranked.c.id == MotionSession.id) & (ranked.c.rank == 1))
    for row in session.scalars(last):
        found[row.patient_id].last = row
    live = select(MotionSession.patient_id, MotionSession.id, MotionSession.state).where(
        MotionSession.patient_id.in_(ids), MotionSession.state.in_(LIVE_STATES)
    )
    # The last one wins: a session that streams before one whose link is lost, then the newest.
    streaming_last = (MotionSession.state != "link_lost", MotionSession.created_at)
    for patient_id, session_id, state in session.execute(live.order_by(*streaming_last)):
        found[patient_id].live_id = session_id
        found[patient_id].live_state = "link_lost" if state == "link_lost" else "streaming"
        if state == "link_lost":
            found[patient_id].lost_id = session_id
    for patient_id, at in last_done(session, ids, now - PRACTICE_WINDOW).items():
        found[patient_id].practised_at = at
    return found


def _main_exercises(
    session: Session,
    ids: list[str],
    prescriptions: dict[str, list[tuple[Prescription, Exercise]]],
    sessions: dict[str, _Sessions],
) -> dict[str, Exercise]:
    """Return the exercise of each patient's trend: the first prescribed, else the one practised last."""
    found = {patient_id: rows[0][1] for patient_id, rows in prescriptions.items() if rows}
    for patient_id in ids:
        last = sessions[patient_id].last
        if patient_id not in found and last is not None and last.exercise_id is not None:
            exercise = session.get(Exercise, last.exercise_id)
            if exercise is not None:
                found[patient_id] = exercise
    return found
