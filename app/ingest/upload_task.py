"""The task of an upload: read the file, store it as packets, estimate, and go on as after a live session."""

import time
from collections.abc import Callable, Iterable
from dataclasses import replace
from datetime import datetime, timedelta
from pathlib import Path
from typing import Final

from sqlalchemy import delete

from app import readers
from app.database.base import utc_now
from app.database.unit_of_work import read_only, unit_of_work
from app.errors import ImplausibleReadings, RecordingFormatError
from app.ingest.upload import pipeline_of
from app.network.declaration import Declaration
from app.network.raw_packet import RawPacket
from app.readers.judged import judged
from app.readers.moments import RECORDED_AT
from app.recordings.analysis.jobs import JobContext
from app.recordings.analysis.kinds import Wanted, kind_of, kinds
from app.recordings.analysis.offline import Analysis, StoredSession
from app.recordings.analysis.reprocess import count_session, enqueue_comparison
from app.recordings.files_in_passing import file_of
from app.recordings.models import MotionSession, SessionEvent, SignalChunk
from app.recordings.repository import prescribed_at
from app.recordings.schemas import UploadIn
from app.recordings.signals.chunks import RAW_STREAM, EncodedChunk, encode_packets
from app.recordings.signals.rows import insert_chunk
from estimators.pipelines import SessionSetup
from estimators.sentences import CATALOGUE, say

_CHUNK_TICKS: Final = 100
_CHUNKS_A_COMMIT: Final = 16
_STORED_AT: Final = 0.4
"""Share of the task's progress when the packets are stored and estimation begins."""


def upload(context: JobContext) -> str:
    """Do the task `upload`; its arguments are the name of the file and the declaration.

    Raises
    ------
    RecordingFormatError
        The file is not what it was declared to be.

    Notes
    -----
    The runner of the task removes the file when the task has ended for good.
    """
    declaration = UploadIn.model_validate(context.arguments["declaration"])
    path = file_of(context.settings, context.arguments)
    if path is None or not path.exists():
        raise RecordingFormatError(say("upload.gone"))
    if declaration.format is None:
        declaration = _recognised(declaration, path)
    try:
        with readers.accepting(declaration.accept_implausible) as doubts:
            notes = _store(context, declaration, path)
        notes += [*doubts, *_check(context, declaration)]
    except ImplausibleReadings as error:
        found = error.details.get("codes") or [str(error.details.get("quantity"))]
        context.remember(implausible=found)
        raise
    analysis = _analyse(context, declaration)
    _finish(context, analysis)
    return CATALOGUE.together([analysis.message, *notes])


def _recognised(declaration: UploadIn, path: Path) -> UploadIn:
    """Find what a file is that was sent without its format.

    In the task, because a file from outside is opened in no process that serves others.
    """
    format = readers.guess(path, declaration.file_name)
    if readers.reader_of(format).needs_mapping and declaration.csv is None:
        raise RecordingFormatError(say("upload.csv_needs_mapping"))
    return declaration.model_copy(update={"format": format})


def _store(context: JobContext, declaration: UploadIn, path: Path) -> list[str]:
    """Store the file as packets with the hello that a gateway would have sent; return notes for people."""
    context.progress(0.01, say("progress.reading_file"))
    _forget_raw(context)
    notes: list[str] = []
    if readers.reader_of(str(declaration.format)).holds_packets:
        log = readers.LogReader(path)
        pipeline = pipeline_of(declaration, log.declaration.placements)
        size = path.stat().st_size
        stored_ticks = _write_packets(
            context, (raw for raw, _ in log.packets()), lambda packet: (len(packet.payload) + 44) / size
        )
        network = log.declaration
        recorded_at = log.recorded_at
        if log.damaged:
            notes.append(say("upload.damaged_packets", count=log.damaged))
    else:
        recording = readers.read(path, str(declaration.format), declaration.csv, declaration.file_name)
        notes += recording.notes
        recorded_at = _moment(recording.metadata.get(RECORDED_AT))
        pipeline = pipeline_of(declaration, recording.placements)
        kind = kinds()[pipeline]
        with unit_of_work(context.engine) as session:
            recording = kind.store_auxiliary(session, context.session_id, recording)
        prepared = readers.packets_of(recording, any_name=not kind.pipeline.is_worn)
        network = prepared.declaration
        total = prepared.tick_count
        stored_ticks = _write_packets(
            context, prepared.packets(time.time_ns()), lambda packet: packet.tick_count / total
        )
        if prepared.left_out:
            notes.append(say("file.left_out", names=list(prepared.left_out)))
    if not stored_ticks:
        raise RecordingFormatError(say("log.no_packet"))
    if not _declare(context, network, pipeline, recorded_at, with_legs=declaration.with_legs):
        notes.append(say("upload.day_unknown"))
    return notes


def _moment(written: str | None) -> datetime | None:
    return None if written is None else datetime.fromisoformat(written)


def _forget_raw(context: JobContext) -> None:
    """Remove what an interrupted attempt stored."""
    with unit_of_work(context.engine) as session:
        session.execute(
            delete(SignalChunk).where(
                SignalChunk.session_id == context.session_id, SignalChunk.stream == RAW_STREAM
            )
        )


def _write_packets(
    context: JobContext, packets: Iterable[RawPacket], share: Callable[[RawPacket], float]
) -> int:
    """Write packets in chunks of about a second; return how many ticks."""
    done = 0.0
    ticks = number = 0
    group: list[RawPacket] = []
    group_ticks = 0
    chunks: list[tuple[int, EncodedChunk]] = []
    for packet in packets:
        if group and (group_ticks >= _CHUNK_TICKS or packet.shape_key != group[0].shape_key):
            chunks.append((number, encode_packets(group)))
            number, group, group_ticks = number + 1, [], 0
        if len(chunks) >= _CHUNKS_A_COMMIT:
            _write_chunks(context, chunks)
            chunks = []
            context.progress(0.1 + (_STORED_AT - 0.1) * min(1.0, done), say("progress.storing"))
        group.append(packet)
        group_ticks += packet.tick_count
        ticks += packet.tick_count
        done += share(packet)
    if group:
        chunks.append((number, encode_packets(group)))
    _write_chunks(context, chunks)
    return ticks


def _write_chunks(context: JobContext, chunks: list[tuple[int, EncodedChunk]]) -> None:
    with unit_of_work(context.engine) as session:
        for number, chunk in chunks:
            insert_chunk(session, context.session_id, RAW_STREAM, number, chunk)


def _declare(
    context: JobContext, network: Declaration, pipeline: str, recorded_at: datetime | None, *, with_legs: bool
) -> bool:
    """Write to the session what its gateway would have declared; return whether it is known when it was recorded."""
    with unit_of_work(context.engine) as session:
        found = session.get_one(MotionSession, context.session_id)
        found.hello = network.to_dict()
        found.setup = replace(
            SessionSetup.from_dict(found.setup),
            pipeline=pipeline,
            placements=kinds()[pipeline].pipeline.used(network.placements, with_legs=with_legs),
            rate_hz=network.rate_hz,
        ).to_dict()
        found.started_at = found.started_at or recorded_at
        is_known = found.started_at is not None
        found.started_at = found.started_at or utc_now()
        # Of an unknown day nobody can say what was prescribed then.
        if is_known and found.prescription_id is None and found.purpose == "exercise":
            found.prescription_id = prescribed_at(session, found, found.started_at)
        if not is_known:
            # Also on the time line, where it is read when the message of the task is long gone.
            session.add(
                SessionEvent(session_id=found.id, kind="state", time_s=0.0, text=say("upload.day_unknown"))
            )
        return is_known


def _check(context: JobContext, declaration: UploadIn) -> tuple[str, ...]:
    """Look whether units, axes and signs can be right, see `app.readers.judged`; store what corrects the readings."""
    context.progress(_STORED_AT, say("progress.checking"))
    with read_only(context.engine) as session:
        setup = SessionSetup.from_dict(session.get_one(MotionSession, context.session_id).setup)
    found = judged(
        StoredSession(context, setup),
        setup.placements,
        declaration.hemisphere or context.settings.hemisphere,
        is_accepted=declaration.accept_implausible,
        remedy=say("upload.correct_or_accept"),
    )
    if found.devices:
        with unit_of_work(context.engine) as session:
            stored = session.get_one(MotionSession, context.session_id)
            stored.setup = setup.with_devices(found.devices).to_dict()
    return (*found.doubts, *found.notes)


def _analyse(context: JobContext, declaration: UploadIn) -> Analysis:
    with unit_of_work(context.engine) as session:
        setup = SessionSetup.from_dict(session.get_one(MotionSession, context.session_id).setup)
    wanted = Wanted(
        context, setup, declaration.calibration_pose_s, search_pose=True, progress_from=_STORED_AT
    )
    return kind_of(setup).analyse(wanted)


def _finish(context: JobContext, analysis: Analysis) -> None:
    """Write what the analysis found about the session and queue the comparison."""
    with unit_of_work(context.engine) as session:
        found = session.get_one(MotionSession, context.session_id)
        found.setup = analysis.setup.to_dict()
        found.main_result_id = analysis.result_id
        found.state_reason = analysis.message
        count_session(session, found, analysis)
        begun = found.started_at or utc_now()
        found.ended_at = begun + timedelta(seconds=found.duration_s)
        if analysis.pose_s is not None:
            start_s, end_s = analysis.pose_s
            session.add(
                SessionEvent(
                    session_id=found.id,
                    kind="calibration",
                    time_s=start_s,
                    duration_s=end_s - start_s,
                    text=say("session.pose_found"),
                )
            )
        enqueue_comparison(session, found)
