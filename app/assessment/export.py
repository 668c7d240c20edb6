"""Everything the clinic holds about one patient, as one archive: theirs to take along, or the clinic's to hand on.

It is here and not in `patients` because it must know of recordings and comparisons. Who may read all of it one by
one may read it at once; the trail notes that it was taken, with the number of sessions, as one event.
"""

import json
import tempfile
import zipfile
from collections.abc import Iterator
from dataclasses import dataclass
from typing import IO, Any, Final

import pyarrow.parquet
from pydantic import BaseModel
from sqlalchemy import Engine, select
from sqlalchemy.orm import Session

from app.accounts import audit
from app.accounts.audit_reading import read_audit
from app.accounts.consents import list_consents
from app.accounts.subject import Subject
from app.assessment import comparisons
from app.assessment.models import Comparison
from app.assessment.practice import list_prescriptions
from app.database.unit_of_work import read_only
from app.exercises.models import Template, TemplateVersion
from app.ingest.upload import upload_folder
from app.patients.access import require_patient
from app.patients.models import Patient
from app.patients.repository import list_grants
from app.patients.service import patient_out
from app.recordings import service as recordings
from app.recordings.columns import frames_table
from app.recordings.models import MotionSession
from app.recordings.packet_log import write_log
from app.recordings.repository import results_of
from app.recordings.store import read_frames, read_packets
from app.settings import Settings

_MOST_EVENTS: Final = 100_000
_PIECE_BYTES: Final = 2**18
_GUIDE: Final = """Movement data of one patient, exported from Telemotion.

patient.json               master data, who may see it, consents, prescriptions
access.json                who did what with the data, newest first
sessions/<when>-<number>/
  session.json             what was recorded, with which sensors, calibration and estimators
  packets.tmlog            every packet as the sensors sent it; can be uploaded again
  movement-<number>.parquet  one estimate of the movement: a row a tick, units in the column names
  comparisons.json         the session beside the templates, by repetition

Times are UTC. Angles are in radians, lengths in metres. JSON and Parquet open in any analysis software.
"""


@dataclass(frozen=True)
class _Contents:
    """What the archive holds, without the signals."""

    patient: dict[str, Any]
    access: list[Any]
    sessions: list[tuple[str, str, dict[str, Any] | None, dict[str, Any], list[Any], list[str]]]
    """Folder, identifier, hello, detail, comparisons, complete results."""


def export(engine: Engine, settings: Settings, subject: Subject, patient_id: str) -> Iterator[bytes]:
    """Return an archive (ZIP) of everything held about a patient, piece by piece.

    Parameters
    ----------
    engine : Engine
    settings : Settings
        For a place on disk: an archive may be larger than the memory.
    subject : Subject
        With the level `read`: the patient, whoever has a grant, the clinic's administrators.
    patient_id : str

    Returns
    -------
    iterator of bytes
        Access was decided and audited before the first one.

    Raises
    ------
    NotFound, NotAllowed
        See `app.patients.access`.
    """
    with read_only(engine) as session:
        patient = require_patient(session, subject, patient_id, "read")
        contents = _contents(session, subject, patient)
        # What the reading itself noted, item by item, is said in one line.
        session.info.clear()
        audit.record(
            session, subject, "patient.export", patient_id, None, {"sessions": len(contents.sessions)}
        )
    file = tempfile.TemporaryFile(dir=upload_folder(settings))  # noqa: SIM115 - closed when it was sent
    try:
        _write(engine, contents, file)
    except BaseException:
        file.close()
        raise
    return _pieces(file)


def _contents(session: Session, subject: Subject, patient: Patient) -> _Contents:
    master = {
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
        "prescriptions": [_plain(one) for one in list_prescriptions(session, subject, patient.id)],
        "templates": [
            {"name": name, "version": number, "made_at": made.isoformat()}
            for name, number, made in session.execute(
                select(Template.name, TemplateVersion.number, TemplateVersion.created_at)
                .join(TemplateVersion, TemplateVersion.template_id == Template.id)
                .where(Template.patient_id == patient.id)
                .order_by(Template.name, TemplateVersion.number)
            )
        ],
    }
    access = [_plain(one) for one in read_audit(session, patient.clinic_id, patient.id, _MOST_EVENTS)]
    sessions = []
    for found in session.scalars(
        select(MotionSession).where(MotionSession.patient_id == patient.id).order_by(MotionSession.created_at)
    ):
        compared = session.scalars(select(Comparison.id).where(Comparison.session_id == found.id))
        sessions.append(
            (
                f"{(found.started_at or found.created_at):%Y-%m-%d-%H%M}-{found.id[:8]}",
                found.id,
                found.hello,
                _plain(recordings.describe(session, subject, found)),
                [_plain(comparisons.detail(session, subject, one)) for one in compared],
                [result.id for result in results_of(session, found.id) if result.status == "complete"],
            )
        )
    return _Contents(master, access, sessions)


def _plain(model: BaseModel) -> dict[str, Any]:
    plain: dict[str, Any] = model.model_dump(mode="json")
    return plain


def _write(engine: Engine, contents: _Contents, file: IO[bytes]) -> None:
    """Signals are read session by session, each in transactions of its own, so that nothing is held up."""
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive:
        archive.writestr("README.txt", _GUIDE)
        archive.writestr("patient.json", _json(contents.patient))
        archive.writestr("access.json", _json(contents.access))
        for folder, session_id, hello, detail, compared, results in contents.sessions:
            archive.writestr(f"sessions/{folder}/session.json", _json(detail))
            if compared:
                archive.writestr(f"sessions/{folder}/comparisons.json", _json(compared))
            if hello is not None:
                with archive.open(f"sessions/{folder}/packets.tmlog", "w", force_zip64=True) as target:
                    for piece in write_log(hello, read_packets(engine, session_id)):
                        target.write(piece)
            for result_id in results:
                with read_only(engine) as session:
                    frames = read_frames(session, result_id)
                # The columns are compressed in the file itself.
                name = zipfile.ZipInfo(f"sessions/{folder}/movement-{result_id[:8]}.parquet")
                with archive.open(name, "w", force_zip64=True) as target:
                    pyarrow.parquet.write_table(frames_table(frames), target, compression="zstd")


def _json(content: Any) -> str:
    return json.dumps(content, indent=1, ensure_ascii=False)


def _pieces(file: IO[bytes]) -> Iterator[bytes]:
    with file:
        file.seek(0)
        while piece := file.read(_PIECE_BYTES):
            yield piece


__all__ = ["export"]
