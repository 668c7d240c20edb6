"""Uploaded marker trajectories: the file as it came, and what fusing it with a sensor gave.

Stored as rows of the signal table, erased with their session: stream `markers/<id>` holds the file in pieces,
`optical/<id>` the fused motion at full rate, and `optical_report/<id>` the report.
"""

import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from sqlalchemy import Engine, delete, func, select
from sqlalchemy.orm import Session

from app.accounts.subject import Subject
from app.database.base import new_id, utc_now
from app.database.unit_of_work import read_only
from app.errors import Conflict, NotFound
from app.pages import Page, rows_of
from app.readers.markers.schemas import MarkerReport, MarkersOut, MarkerUploadIn
from app.recordings import repository
from app.recordings.files_in_passing import open_private
from app.recordings.models import Job, MotionSession, SignalChunk
from app.recordings.signals import codecs
from app.recordings.signals.chunks import EncodedChunk
from app.recordings.signals.rows import insert_chunk
from estimators.sentences import say

KIND: Final = "markers"
_PIECE_BYTES: Final = 4 << 20
_PIECE_TICKS: Final = 6000
MOTION_STREAM: Final = "optical/"
_FILE, _REPORT = "markers/", "optical_report/"
COLUMNS: Final = (
    *(f"position_{axis}_m" for axis in "xyz"),
    *(f"velocity_{axis}_mps" for axis in "xyz"),
    *(f"acceleration_{axis}_mps2" for axis in "xyz"),
    *(f"q_room_sensor_{part}" for part in "wxyz"),
    *(f"marker_{axis}_m" for axis in "xyz"),
    *(f"position_sigma_{axis}_m" for axis in "xyz"),
    "provenance",
    "is_gap",
    *(f"measured_{axis}_m" for axis in "xyz"),
)
"""Of the fused motion: of the accelerometer, but `marker` of the marker; laboratory, z up. `measured` is the frame of
the cameras nearest to the tick."""


def session_for(session: Session, subject: Subject, session_id: str, segment: str) -> MotionSession:
    """Return an analysed session whose network had a sensor.

    Raises
    ------
    NotFound
        No such session.
    NotAllowed
        The subject may not analyse it.
    Conflict
        It is still live, or had no such sensor.
    """
    found = repository.get_session(session, subject, session_id, "treat", action="session.markers.upload")
    if found.state != "analysed":
        raise Conflict(say("markers.not_closed"), state=found.state)
    sent = list((found.hello or {}).get("placements", []))
    if segment not in sent:
        raise Conflict(
            say("markers.no_such_sensor", place=segment, sent=list(sent)),
            field="segment",
        )
    return found


def store_file(
    session: Session, found: MotionSession, declared: MarkerUploadIn, path: Path, subject: Subject
) -> Job:
    """Keep an uploaded file whole and queue its fusion."""
    markers_id = new_id()
    size = path.stat().st_size
    described = {
        "declaration": declared.model_dump(mode="json"),
        "bytes": size,
        "uploaded_at": utc_now().isoformat(),
    }
    with path.open("rb") as file:
        for sequence, raw in enumerate(iter(lambda: file.read(_PIECE_BYTES), b"")):
            data = zlib.compress(raw, 6)
            chunk = EncodedChunk(0, 0, "file.zlib", described, codecs.checksum(data), data)
            insert_chunk(session, found.id, _FILE + markers_id, sequence, chunk)
    return repository.add_job(session, found, KIND, {"markers_id": markers_id}, subject)


def write_file(session: Session, session_id: str, markers_id: str, path: Path) -> MarkerUploadIn:
    """Write an uploaded file out again; return what was declared of it."""
    rows = _rows(session, session_id, _FILE + markers_id)
    declared = None
    with open_private(path) as file:
        for row in rows:
            declared = row.scale["declaration"]
            file.write(zlib.decompress(sound(row)))
    if declared is None:
        raise NotFound(say("markers.gone"))
    return MarkerUploadIn.model_validate(declared)


def file_pieces(engine: Engine, session_id: str, markers_id: str) -> Iterator[bytes]:
    """Yield an uploaded file as it came, piece by piece, each read in a transaction of its own."""
    key = (SignalChunk.session_id == session_id, SignalChunk.stream == _FILE + markers_id)
    with read_only(engine) as session:
        numbers = session.scalars(
            select(SignalChunk.sequence).where(*key).order_by(SignalChunk.sequence)
        ).all()
    for number in numbers:
        with read_only(engine) as session:
            row = session.get_one(SignalChunk, (session_id, _FILE + markers_id, number))
            data = sound(row)
        yield zlib.decompress(data)


def store_fusion(
    session: Session,
    session_id: str,
    markers_id: str,
    report: MarkerReport,
    first_tick: int,
    time_step_s: float,
    motion: NDArray[np.float32],
) -> None:
    """Keep report and motion, shape (K, len(COLUMNS)); an earlier attempt's are replaced."""
    for stream in (MOTION_STREAM, _REPORT):
        session.execute(
            delete(SignalChunk).where(
                SignalChunk.session_id == session_id, SignalChunk.stream == stream + markers_id
            )
        )
    for start in range(0, len(motion), _PIECE_TICKS):
        part = motion[start : start + _PIECE_TICKS]
        data = codecs.encode_floats(part)
        scale = {"first_tick": first_tick + start, "time_step_s": time_step_s, "columns": list(COLUMNS)}
        at_ns = round((first_tick + start) * time_step_s * 1e9)
        chunk = EncodedChunk(at_ns, len(part), codecs.FLOATS_CODEC, scale, codecs.checksum(data), data)
        insert_chunk(session, session_id, MOTION_STREAM + markers_id, first_tick + start, chunk)
    data = zlib.compress(report.model_dump_json().encode(), 6)
    chunk = EncodedChunk(0, 0, "json.zlib", {"version": 1}, codecs.checksum(data), data)
    insert_chunk(session, session_id, _REPORT + markers_id, 0, chunk)


def markers_of(session: Session, subject: Subject, session_id: str, page: Page) -> list[MarkersOut]:
    """Return a page of the uploaded markers with their reports, newest first."""
    repository.get_session(session, subject, session_id, action="session.markers")
    query = select(Job).where(Job.session_id == session_id, Job.kind == KIND)
    rows = rows_of(session, query, (Job.created_at, Job.id), page, newest_first=True)
    jobs = {str(job.arguments["markers_id"]): job for (job,) in rows}
    streams = [kind + markers_id for markers_id in jobs for kind in (_FILE, _REPORT)]
    # The first piece of a file says how it was declared; its bytes are not needed, those of a report are.
    first = (SignalChunk.session_id == session_id, SignalChunk.stream.in_(streams), SignalChunk.sequence == 0)
    declared_as = session.execute(select(SignalChunk.stream, SignalChunk.scale).where(*first))
    scales: dict[str, Any] = {row.stream: row.scale for row in declared_as}
    is_report = SignalChunk.stream.startswith(_REPORT)
    reports = {row.stream: row for row in session.scalars(select(SignalChunk).where(*first, is_report))}
    found = []
    for markers_id, job in jobs.items():
        described: dict[str, Any] = scales.get(_FILE + markers_id, {})
        declared = described.get("declaration", {})
        row = reports.get(_REPORT + markers_id)
        found.append(
            MarkersOut(
                id=markers_id,
                session_id=session_id,
                segment=declared.get("segment", ""),
                format=declared.get("format", "csv"),
                file_bytes=described.get("bytes", 0),
                uploaded_at=described.get("uploaded_at"),
                status=job.status,
                message=job.message,
                report=None if row is None else MarkerReport.model_validate_json(zlib.decompress(sound(row))),
            )
        )
    return found


def stored_bytes(session: Session, session_id: str) -> int:
    """Return how much room the uploaded marker files of a session take."""
    total = session.scalar(
        select(func.sum(func.length(SignalChunk.data))).where(
            SignalChunk.session_id == session_id, SignalChunk.stream.startswith(_FILE)
        )
    )
    return int(total or 0)


def _rows(session: Session, session_id: str, stream: str) -> list[SignalChunk]:
    return list(
        session.scalars(
            select(SignalChunk)
            .where(SignalChunk.session_id == session_id, SignalChunk.stream == stream)
            .order_by(SignalChunk.sequence)
        )
    )


def sound(row: SignalChunk) -> bytes:
    """Return the data of a row whose checksum is right."""
    if codecs.checksum(row.data) != row.crc:
        raise codecs.DamagedChunkError(say("stored.checksum"))
    return row.data
