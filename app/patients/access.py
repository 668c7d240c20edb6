"""The one access check: what a subject may do with a patient's data.

Recordings, exercises, assessment, viewer and live all call `require_patient`; no other code decides.

=========  ==============================================  ==================================================
level      covers                                          who has it
=========  ==============================================  ==================================================
`status`   state and progress of sessions and jobs         everybody below, and the patient's device tokens
`read`     all data of the patient                         the patient; grants `read` and `treat`;
                                                           administrators
`record`   start, stream, steer and upload exercise        the patient and its device tokens (with the
           sessions                                        consent `home_streaming`); grant `treat`
`treat`    record templates, prescribe, compare,           grant `treat`
           reprocess, delete sessions
`manage`   grants, consents, device tokens, master data,   grant `treat`; administrators of the clinic
           archive
`erase`    erase the patient for good                      administrators of the clinic
=========  ==============================================  ==================================================

`record` and `treat` need the patient's consent to `treatment`: a yes that somebody wrote down, not a question that
was never asked. Of an archived patient everything can still be read; `record` and `treat` are refused until the
patient is taken out of the archive.

The service itself (`Subject.system`) has every level inside its clinic. Who has no level at all gets
`NotFound`, so the patient's existence does not leak; who has another level gets `NotAllowed`.

Open sockets are asked for many at a time (`refusals`); a question by itself is a set of one. What is decided reads
nothing: the facts of all questions are read before, in one statement of each kind.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import Literal, NamedTuple, Protocol

from sqlalchemy import BindParameter, ColumnElement, Select, bindparam, or_, select, tuple_
from sqlalchemy.orm import Session

from app.accounts.consents import answered
from app.accounts.subject import Subject
from app.database.base import utc_now
from app.errors import NotAllowed, NotFound
from app.patients.models import Grant, Patient
from estimators.sentences import say

Level = Literal["status", "read", "record", "treat", "manage", "erase"]

_GRANT_LEVELS: dict[str, frozenset[Level]] = {
    "read": frozenset({"status", "read"}),
    "treat": frozenset({"status", "read", "record", "treat", "manage"}),
}
_ALL: frozenset[Level] = frozenset({"status", "read", "record", "treat", "manage", "erase"})
_ADMINISTRATOR: frozenset[Level] = frozenset({"status", "read", "manage", "erase"})
_OWN: frozenset[Level] = frozenset({"status", "read", "record"})
_DEVICE: frozenset[Level] = frozenset({"status", "record"})

_WITH_CONSENT: frozenset[Level] = frozenset({"record", "treat"})
_CONSENTS = ("treatment", "home_streaming")

NO_SUCH_PATIENT = say("patient.not_found")


class Asked(NamedTuple):
    """Who wants to do what with whose data."""

    subject: Subject
    patient_id: str
    level: Level


class _Treated(Protocol):
    """What a decision needs of a patient: the object, or a row of these columns."""

    @property
    def id(self) -> str: ...
    @property
    def clinic_id(self) -> str: ...
    @property
    def archived_at(self) -> datetime | None: ...


@dataclass(frozen=True)
class _Facts:
    """Levels granted by patient and account, and answers by patient and purpose."""

    granted: Mapping[tuple[str, str], frozenset[Level]]
    consents: Mapping[tuple[str, str], bool]


def require_patient(session: Session, subject: Subject, patient_id: str, level: Level = "read") -> Patient:
    """Return the patient when the subject has the level; the caller writes the audit event.

    Parameters
    ----------
    subject : Subject
        Who asks.
    patient_id : str
        Whose data.
    level : {"status", "read", "record", "treat", "manage", "erase"}
        What is to be done; see the module text.

    Raises
    ------
    NotFound
        The patient does not exist, or the subject has no right at all.
    NotAllowed
        The subject may see the patient but not do this, the patient has not consented to it, or is archived.
    """
    asked = Asked(subject, patient_id, level)
    patient = session.get(Patient, patient_id)
    if patient is None:
        raise NotFound(NO_SUCH_PATIENT)
    refusal = _refusal(asked, patient, _facts(session, [asked]))
    if refusal is not None:
        raise refusal
    return patient


def refusals(session: Session, questions: Sequence[Asked]) -> list[NotFound | NotAllowed | None]:
    """Return what `require_patient` would raise for each question, None where it would not; in at most 3 statements."""
    if not questions:
        return []
    rows = session.execute(_PATIENTS, {"ids": list({asked.patient_id for asked in questions})})
    patients = {row.id: row for row in rows}
    known = [asked for asked in questions if asked.patient_id in patients]
    facts = _facts(session, known)
    return [
        _refusal(asked, patients[asked.patient_id], facts)
        if asked.patient_id in patients
        else NotFound(NO_SUCH_PATIENT)
        for asked in questions
    ]


def require_own_or_manage(session: Session, subject: Subject, patient_id: str) -> Patient:
    """Return the patient to who may manage its data, and to the patient: for own devices and own consents.

    Raises
    ------
    NotFound, NotAllowed
        As of `require_patient`.
    """
    patient = require_patient(session, subject, patient_id, "status")
    is_own = subject.role == "patient" and subject.patient_id == patient_id
    if not is_own and "manage" not in levels(session, subject, patient):
        raise NotAllowed(say("patient.level", level="manage"), level="manage")
    return patient


def levels(session: Session, subject: Subject, patient: Patient) -> frozenset[Level]:
    """Return every level that the subject has for the patient, consent left aside."""
    return _held(subject, patient, _granted(session, [Asked(subject, patient.id, "status")]))


def visible_patients(subject: Subject) -> Select[Patient]:
    """Return the query of all patients whose data the subject may read, for lists.

    Parameters
    ----------
    subject : Subject
        A device sees none: it may not read.
    """
    query = select(Patient).where(Patient.clinic_id == subject.clinic_id)
    if subject.role in {"administrator", "system"}:
        return query
    if subject.role == "patient":
        return query.where(Patient.id == (subject.patient_id or ""))
    return query.where(
        Patient.id.in_(
            select(Grant.patient_id).where(Grant.account_id == (subject.account_id or ""), is_in_force())
        )
    )


def is_in_force(at: datetime | BindParameter[datetime] | None = None) -> ColumnElement[bool]:
    """Return the SQL condition of a grant that is neither revoked nor expired.

    Parameters
    ----------
    at : datetime or bound parameter, optional
        Now when absent.
    """
    moment = utc_now() if at is None else at
    return Grant.revoked_at.is_(None) & or_(Grant.expires_at.is_(None), Grant.expires_at > moment)


# Asked for every open socket again and again. A statement that is built for each question leaves cycles of objects
# behind that only the garbage collector frees, and it rarely runs (`app.live.warmup`).
_PATIENTS = select(Patient.id, Patient.clinic_id, Patient.archived_at).where(
    Patient.id.in_(bindparam("ids", expanding=True))
)
_GRANTS = select(Grant.patient_id, Grant.account_id, Grant.level).where(
    tuple_(Grant.patient_id, Grant.account_id).in_(bindparam("pairs", expanding=True)),
    is_in_force(bindparam("now", type_=Grant.expires_at.type)),
)


def _facts(session: Session, questions: Sequence[Asked]) -> _Facts:
    """Read what the answers depend on; what none of them depends on is not asked for."""
    with_consent = {asked.patient_id for asked in questions if _needs_consent(asked)}
    return _Facts(
        granted=_granted(session, questions),
        consents=answered(session, with_consent, _CONSENTS) if with_consent else {},
    )


def _granted(session: Session, questions: Iterable[Asked]) -> dict[tuple[str, str], frozenset[Level]]:
    pairs = {
        (asked.patient_id, asked.subject.account_id)
        for asked in questions
        if asked.subject.account_id is not None and asked.subject.role not in {"system", "device", "patient"}
    }
    if not pairs:
        return {}
    rows = session.execute(_GRANTS, {"pairs": list(pairs), "now": utc_now()})
    held: dict[tuple[str, str], frozenset[Level]] = {}
    for patient_id, account_id, level in rows:
        pair = patient_id, account_id
        held[pair] = held.get(pair, frozenset()) | _GRANT_LEVELS.get(level, frozenset())
    return held


def _refusal(asked: Asked, patient: _Treated, facts: _Facts) -> NotFound | NotAllowed | None:
    """Decide: every rule of the module text is here and in `_held`."""
    held = _held(asked.subject, patient, facts.granted)
    if not held:
        return NotFound(NO_SUCH_PATIENT)
    if asked.level not in held:
        return NotAllowed(say("patient.level", level=asked.level), level=asked.level)
    if not _needs_consent(asked):
        return None
    if patient.archived_at is not None:
        return NotAllowed(say("patient.archived"), archived=True)
    treatment = facts.consents.get((patient.id, "treatment"))
    if treatment is not True:
        never_asked = treatment is None
        reason = say("patient.no_consent") if never_asked else say("patient.consent_withdrawn")
        return NotAllowed(reason, purpose="treatment")
    at_home = asked.subject.role in {"patient", "device"}
    if asked.level == "record" and at_home and facts.consents.get((patient.id, "home_streaming")) is not True:
        return NotAllowed(
            say("patient.no_home_consent"),
            purpose="home_streaming",
        )
    return None


def _needs_consent(asked: Asked) -> bool:
    return asked.level in _WITH_CONSENT and asked.subject.role != "system"


def _held(
    subject: Subject, patient: _Treated, granted: Mapping[tuple[str, str], frozenset[Level]]
) -> frozenset[Level]:
    if subject.clinic_id != patient.clinic_id:
        return frozenset()
    by_grant = granted.get((patient.id, subject.account_id or ""), frozenset())
    match subject.role:
        case "system":
            return _ALL
        case "device":
            return _DEVICE if subject.patient_id == patient.id else frozenset()
        case "patient":
            return _OWN if subject.patient_id == patient.id else frozenset()
        case "administrator":
            return _ADMINISTRATOR | by_grant
        case _:
            return by_grant
