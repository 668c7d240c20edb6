"""The files of a patient's archive."""

import json
import zipfile
from collections.abc import Iterable
from typing import Any, Final

from pydantic import BaseModel
from sqlalchemy import Engine, or_, select
from sqlalchemy.orm import Session

from app.accounts.audit_reading import read_audit
from app.accounts.consents import list_consents
from app.accounts.device_tokens import list_device_tokens
from app.accounts.models import Account
from app.accounts.subject import Subject
from app.assessment import comparisons
from app.assessment.course.report import notes_of
from app.assessment.design import shown
from app.assessment.exports.movement import reading, write_movement
from app.assessment.exports.spreadsheet import (
    Sheet,
    files_of,
    has_decimal_comma,
    measures_sheet,
    strides_sheet,
)
from app.assessment.models import Comparison
from app.assessment.practice import list_prescriptions
from app.assessment.progress import progress
from app.errors import Conflict, NotFound
from app.exercises.models import Template, TemplateVersion
from app.kinds.magnetic.safety import EVENT, WITHDRAWN
from app.kinds.walk.schemas import FootStride
from app.kinds.walk.stored import strides_page
from app.network.packet_log import write_log
from app.pages import Page
from app.patients.access import require_patient
from app.patients.models import Patient
from app.patients.repository import list_grants
from app.patients.service import patient_out
from app.recordings import service as recordings
from app.recordings.answers.service import stored_answers
from app.recordings.markers import file_pieces, markers_of
from app.recordings.models import MotionSession, SessionEvent
from app.recordings.repository import results_of
from app.recordings.signals.codecs import DamagedChunkError
from app.recordings.signals.store import read_packets

_MOST_EVENTS: Final = 100_000
_GUIDE: Final = """Movement data of one patient, exported from Telemotion.

patient.json               master data, who may see it, consents, prescriptions, devices
progress.json              by exercise: each measure over the sessions, and what may be said of its change
access.json                who did what with the data, newest first
templates/<name>-<number>.json  a template made for or from the patient: its curves, band and repetitions
sessions/<when>-<number>/
  session.json             what was recorded, with which sensors, calibration and estimators
  packets.tmlog            every packet as the sensors sent it; can be uploaded again
  movement-<number>.parquet  one estimate of the movement: a row a tick, a column a number
  movement-<number>.csv    the same as text
  movement-<number>.json   what each column means (unit, frame, sequence, flags), and how the estimate was made
  comparisons.json         the session beside the templates, by repetition
  measures.csv             the same measures as a table for a spreadsheet: a row a repetition
  measures-columns.csv     name, unit and meaning of its columns
  strides.csv              of a walk: a row a stride; strides-columns.csv says what its columns mean
  safety.json              who confirmed or withdrew that nobody near a magnetic source has an implant, and when
  markers-<number>.json    an optical recording that was uploaded, and what fusing it with a sensor gave
  markers-<number>.<format>  its file as it was uploaded

Times are UTC. Angles are in radians, lengths in metres; measures have the unit that their column names. JSON and
Parquet open in any analysis software. Open measures.csv and strides.csv in a spreadsheet: they have a byte order mark,
and decimal commas with semicolons between cells where the account that exported reads German, else decimal points
and commas.
"""


def write_archive(
    archive: zipfile.ZipFile, engine: Engine, subject: Subject, patient_id: str, default_zone: str
) -> None:
    """Write everything, each part read in a short transaction of its own so that nothing is held up.

    Parameters
    ----------
    archive : zipfile.ZipFile
        Open for writing; need not be able to go back.
    subject : Subject
        Whose access was decided and noted.
    default_zone : str
        Setting `time_zone`: where the week of what was practised begins, if the clinic has not said so.
    """
    archive.writestr("README.txt", _GUIDE)
    with reading(engine) as session:
        patient = require_patient(session, subject, patient_id, "read")
        _json(archive, "patient.json", _master(session, subject, patient, default_zone))
        access = [
            _plain(one) for one in read_audit(session, patient.clinic_id, patient.id, Page(_MOST_EVENTS))
        ]
        sessions = session.scalars(
            select(MotionSession.id)
            .where(MotionSession.patient_id == patient_id)
            .order_by(MotionSession.created_at)
        ).all()
        versions = session.scalars(_templates_of(patient_id)).all()
        account = session.get(Account, subject.id)
        decimal_comma = has_decimal_comma(account.locale if account else "")
        followed = session.scalars(
            select(MotionSession.exercise_id)
            .where(MotionSession.patient_id == patient_id, MotionSession.exercise_id.is_not(None))
            .distinct()
            .order_by(MotionSession.exercise_id)
        ).all()
    _json(archive, "access.json", access)
    _json(
        archive,
        "progress.json",
        [_progress(engine, subject, patient_id, one, default_zone) for one in followed],
    )
    for version_id in versions:
        with reading(engine) as session:
            found = shown.detail(session, subject, version_id)
        name = "".join(letter if letter.isalnum() else "-" for letter in found.name)[:60]
        _json(archive, f"templates/{name}-{found.number}-{found.id[:8]}.json", _plain(found))
    for session_id in sessions:
        _write_session(archive, engine, subject, session_id, decimal_comma=decimal_comma)


def _progress(
    engine: Engine, subject: Subject, patient_id: str, exercise_id: str | None, default_zone: str
) -> dict[str, Any]:
    with reading(engine) as session:
        return _plain(progress(session, subject, patient_id, exercise_id, default_zone))


def _templates_of(patient_id: str) -> Any:
    """Return the query of template versions that were made for the patient, or from a recording of the patient."""
    own = select(MotionSession.id).where(MotionSession.patient_id == patient_id)
    return (
        select(TemplateVersion.id)
        .join(Template, Template.id == TemplateVersion.template_id)
        .where(or_(Template.patient_id == patient_id, TemplateVersion.source_session_id.in_(own)))
        .order_by(Template.name, TemplateVersion.number)
    )


def _master(session: Session, subject: Subject, patient: Patient, default_zone: str) -> dict[str, Any]:
    return {
        "patient": _plain(patient_out(session, subject, patient)),
        "grants": [
            {
                "who": name,
                "level": grant.level,
                "from": grant.created_at.isoformat(),
                "until": grant.expires_at.isoformat() if grant.expires_at else None,
            }
            for grant, name in list_grants(session, subject, patient.id)
        ],
        "consents": [
            {"purpose": row.purpose, "granted": row.granted, "changed_at": row.changed_at.isoformat()}
            for row in list_consents(session, patient.id)
        ],
        "prescriptions": [
            _plain(one) for one in list_prescriptions(session, subject, patient.id, default_zone)
        ],
        "course_notes": [_plain(one) for one in notes_of(session, patient.id)],
        "templates": [
            {"name": name, "version": number, "made_at": made.isoformat()}
            for name, number, made in session.execute(
                select(Template.name, TemplateVersion.number, TemplateVersion.created_at)
                .join(TemplateVersion, TemplateVersion.template_id == Template.id)
                .where(TemplateVersion.id.in_(_templates_of(patient.id).order_by(None)))
                .order_by(Template.name, TemplateVersion.number)
            )
        ],
        # What a token is made of is nowhere stored.
        "devices": [
            {
                "label": row.label,
                "from": row.created_at.isoformat(),
                "until": row.expires_at.isoformat(),
                "revoked_at": row.revoked_at.isoformat() if row.revoked_at else None,
            }
            for row in list_device_tokens(session, patient.id, Page())
        ],
    }


def _write_session(
    archive: zipfile.ZipFile, engine: Engine, subject: Subject, session_id: str, *, decimal_comma: bool
) -> None:
    with reading(engine) as session:
        found = session.get(MotionSession, session_id)
        if found is None:
            return
        folder = f"sessions/{(found.started_at or found.created_at):%Y-%m-%d-%H%M}-{found.id[:8]}"
        hello = found.hello
        described = recordings.describe(session, subject, found)
        _json(archive, f"{folder}/session.json", _plain(described))
        answers = stored_answers(session, session_id)
        if answers is not None:
            _json(archive, f"{folder}/answers.json", _plain(answers))
        compared = session.scalars(select(Comparison.id).where(Comparison.session_id == session_id)).all()
        if compared:
            details = [comparisons.detail(session, subject, one) for one in compared]
            _json(archive, f"{folder}/comparisons.json", [_plain(one) for one in details])
            sheet = measures_sheet(details, found.started_at, described.exercise_name or "")
            _sheet(archive, f"{folder}/measures", sheet, decimal_comma=decimal_comma)
        try:
            if strides := _strides(session, subject, session_id):
                _sheet(archive, f"{folder}/strides", strides_sheet(strides), decimal_comma=decimal_comma)
        except DamagedChunkError as error:
            # The rest is of use without them.
            _json(archive, f"{folder}/strides-unreadable.json", {"reason": str(error.message)})
        said = session.scalars(
            select(SessionEvent)
            .where(SessionEvent.session_id == session_id, SessionEvent.kind.in_((EVENT, WITHDRAWN)))
            .order_by(SessionEvent.created_at)
        ).all()
        if said:
            _json(archive, f"{folder}/safety.json", [{"text": one.text, **one.details} for one in said])
        markers = markers_of(session, subject, session_id, Page())
        results = [result.id for result in results_of(session, session_id) if result.status == "complete"]
    for one in markers:
        _json(archive, f"{folder}/markers-{one.id[:8]}.json", _plain(one))
        _stream(
            archive, f"{folder}/markers-{one.id[:8]}.{one.format}", file_pieces(engine, session_id, one.id)
        )
    if hello is not None:
        _stream(archive, f"{folder}/packets.tmlog", write_log(hello, read_packets(engine, session_id)))
    for result_id in results:
        write_movement(archive, f"{folder}/movement-{result_id[:8]}", engine, result_id)


def _strides(session: Session, subject: Subject, session_id: str) -> list[FootStride]:
    """Return the strides of a walk; none of what is no walk."""
    try:
        return strides_page(session, subject, session_id, None, Page())
    except (Conflict, NotFound):
        return []


def _sheet(archive: zipfile.ZipFile, name: str, sheet: Sheet, *, decimal_comma: bool) -> None:
    for file, content in files_of(name, sheet, decimal_comma=decimal_comma).items():
        archive.writestr(file, content)


def _plain(model: BaseModel) -> dict[str, Any]:
    plain: dict[str, Any] = model.model_dump(mode="json")
    return plain


def _json(archive: zipfile.ZipFile, name: str, content: Any) -> None:
    archive.writestr(name, json.dumps(content, indent=1, ensure_ascii=False))


def _stream(archive: zipfile.ZipFile, name: str, pieces: Iterable[bytes]) -> None:
    with archive.open(name, "w", force_zip64=True) as target:
        for piece in pieces:
            target.write(piece)
