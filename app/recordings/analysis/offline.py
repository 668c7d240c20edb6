"""The general way through a stored session: its packets on common ticks, its pose, its frames as a new result.

The result depends on the packets and the setup alone, not on the order in which the packets arrived: they are read by
rising sequence.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from typing import Any, Final

from sqlalchemy import func, select

from app.database.base import utc_now
from app.database.unit_of_work import read_only, unit_of_work
from app.errors import InvalidInput, NotFound
from app.network.alignment import align_chunks
from app.network.packet import Packet
from app.network.raw_packet import RawPacket
from app.readers.judged import PIECE_TICKS
from app.recordings.analysis.heading_line import HeadingLine
from app.recordings.analysis.jobs import JobContext
from app.recordings.analysis.result_rows import CHUNKS_A_COMMIT, new_result, write_frames
from app.recordings.analysis.smoothing import SmoothedSession
from app.recordings.analysis.stamped import stored_recording, ticks_of
from app.recordings.models import MotionSession, Result, SignalChunk
from app.recordings.signals.chunks import (
    RAW_STREAM,
    EncodedChunk,
    encode_frames,
)
from app.recordings.signals.store import Source, read_packets_in_order
from estimators import pipelines
from estimators.conventions import Placement
from estimators.errors import CalibrationError
from estimators.orientation import DeviceConstants
from estimators.pipelines import SessionSetup
from estimators.recording import ImuChunk
from estimators.sentences import CATALOGUE, say

_POSE_SEARCH_S: Final = 120.0


@dataclass(frozen=True)
class Analysis:
    """What one run over a session gave."""

    result_id: str
    ticks: int
    setup: SessionSetup
    """With the calibration used."""
    pose_s: tuple[float, float] | None
    """Where in the session that calibration was found, when it was found here."""
    message: str
    learnt: dict[Placement, DeviceConstants] = field(default_factory=dict)
    """What a smoother found about the sensors."""


def decoded(packet: RawPacket) -> Packet:
    """Return a stored packet as the decoder of the wire format gives it, without its message."""
    values = packet.table().reshape(packet.tick_count, packet.sensor_count, -1)
    return Packet(
        data=b"",
        sequence=packet.sequence % 2**32,
        device_time_us=packet.device_time_us,
        tick_interval_us=packet.tick_interval_us,
        sensor_count=packet.sensor_count,
        tick_count=packet.tick_count,
        channels=packet.channel_mask,
        encoding=packet.encoding,
        flags=packet.flags,
        values=values,
    )


def aligned(
    source: Source,
    session_id: str,
    hello: dict[str, Any] | None,
    placements: tuple[str, ...] | None = None,
    piece_ticks: int = PIECE_TICKS,
) -> Iterator[ImuChunk]:
    """Yield a stored session on its common ticks, from tick 0 on, piece by piece.

    `placements` picks sensors of the network, in that order; by default all.
    """
    if hello is None:
        raise NotFound(say("session.no_packets"))
    packets = (decoded(packet) for packet in read_packets_in_order(source, session_id))
    sent = list(hello["placements"])
    placements = tuple(sent) if placements is None else placements
    missing = [name for name in placements if name not in sent]
    if missing:
        raise InvalidInput(say("session.no_sensor", places=missing), field="placements")
    recording = stored_recording(source, session_id, hello, placements)
    rows = [sent.index(name) for name in placements]
    if recording is not None:
        yield from ticks_of(recording, piece_ticks)
    elif list(placements) == sent:
        yield from align_chunks(packets, hello, piece_ticks)
    else:
        yield from (piece.sensors(rows) for piece in align_chunks(packets, hello, piece_ticks))


def estimated(
    context: JobContext,
    line: HeadingLine,
    pieces: Iterable[ImuChunk],
    *,
    smoothed: bool = False,
    message: str = "",
    progress_from: float = 0.0,
) -> Analysis:
    """Run a pipeline over a session and store its frames as a new result.

    Parameters
    ----------
    line : HeadingLine
        The pipeline, and the headings set again on the way.
    pieces : iterable of ImuChunk
        The whole session from its first tick on.
    smoothed : bool
        Whether a filter of the pipeline's own was smoothed before: the result says so in its name.
    message : str
        What is to be said of the result from before.
    progress_from : float
        Where on the task's scale of 0 to 1 this work begins.
    """
    setup = line.pipeline.setup
    result_id = new_result(context, setup, line.pipeline, smoothed=smoothed)
    with read_only(context.engine) as session:
        total = session.scalar(
            select(func.sum(SignalChunk.ticks)).where(
                SignalChunk.session_id == context.session_id, SignalChunk.stream == RAW_STREAM
            )
        )
    ticks = 0
    waiting: list[EncodedChunk] = []
    for piece in pieces:
        waiting += [encode_frames(frames) for frames in line.step(piece)]
        ticks = piece.first_tick + piece.tick_count
        if len(waiting) >= CHUNKS_A_COMMIT:
            write_frames(context, result_id, waiting)
            waiting = []
        done = min(1.0, ticks / max(1, total or 1))
        context.progress(progress_from + (1 - progress_from) * done, say("progress.estimating"))
    write_frames(context, result_id, waiting)
    if not ticks:
        message = say("session.nothing_to_estimate")
    message = CATALOGUE.together([message, *line.refused])
    with unit_of_work(context.engine) as session:
        result = session.get_one(Result, result_id)
        result.status, result.progress, result.message = "complete", 1.0, message
        result.completed_at = utc_now()
    return Analysis(result_id, ticks, setup, None, message)


class StoredSession:
    """A whole stored session with the sensors of a setup, from its first tick on, as often as it is gone through."""

    def __init__(self, context: JobContext, setup: SessionSetup) -> None:
        self._context, self._placements = context, setup.placements
        self.learnt: dict[Placement, DeviceConstants] = {}
        """Only a smoother teaches something about the sensors."""

    def __iter__(self) -> Iterator[ImuChunk]:
        """Read it, piece by piece."""
        with read_only(self._context.engine) as session:
            hello = session.get_one(MotionSession, self._context.session_id).hello
        yield from aligned(self._context.engine, self._context.session_id, hello, self._placements)


def smoothed(context: JobContext, setup: SessionSetup) -> StoredSession | SmoothedSession:
    """Return the whole session, smoothed where the setup names a smoother."""
    stored: StoredSession | SmoothedSession = StoredSession(context, setup)
    if pipelines.is_offline(setup):
        context.progress(0.0, say("progress.smoothing"))
        stored = SmoothedSession(stored, setup)
    return stored


def calibrated(
    setup: SessionSetup, pose_s: tuple[float, float] | None, pieces: Iterable[ImuChunk]
) -> tuple[SessionSetup, tuple[float, float]]:
    """Run up to the end of the pose and evaluate it there; return the calibrated setup and the pose.

    `pieces` are the whole session, as its result will be estimated.

    Raises
    ------
    CalibrationError
        No usable pose, with what to do.
    """
    limit_s = _POSE_SEARCH_S if pose_s is None else pose_s[1]
    chunk = beginning(pieces, round(limit_s * setup.rate_hz))
    if pose_s is None:
        first, stop = pipelines.find_pose(chunk)
    else:
        first, stop = round(pose_s[0] * setup.rate_hz), chunk.tick_count
        if stop - first < 0.5 * setup.rate_hz:
            raise CalibrationError(say("session.pose_outside", start_s=pose_s[0], end_s=pose_s[1]))
    pipeline = pipelines.create(setup)
    pipelines.step_through(pipeline, chunk.ticks(0, stop))
    pipeline.calibrate(chunk.ticks(first, stop))
    return pipeline.setup, (first / setup.rate_hz, stop / setup.rate_hz)


def posed(
    setup: SessionSetup,
    pose_s: tuple[float, float] | None,
    pieces: Iterable[ImuChunk],
    *,
    search: bool = False,
) -> tuple[SessionSetup, tuple[float, float] | None, str]:
    """Calibrate a setup that has no calibration where there is a pose, or one is to be searched for.

    Returns
    -------
    setup : SessionSetup
        With its calibration, or as it was.
    pose_s : (float, float) or None
        Where the pose was found.
    message : str
        Why there is no calibration; empty where there is one.
    """
    message = ""
    if setup.calibration is None and pose_s is None and not search:
        message = say("session.no_pose")
    elif setup.calibration is None:
        try:
            setup, pose_s = calibrated(setup, pose_s, pieces)
        except CalibrationError as error:
            pose_s, message = None, say("session.not_calibrated_because", reason=error.message)
    return setup, pose_s, message


def beginning(pieces: Iterable[ImuChunk], tick_count: int) -> ImuChunk:
    """Return the first ticks of a session as one chunk.

    Raises
    ------
    CalibrationError
        It has none.
    """
    taken: list[ImuChunk] = []
    for piece in pieces:
        taken.append(piece)
        if piece.first_tick + piece.tick_count >= tick_count:
            break
    if not taken:
        raise CalibrationError(say("session.no_packets"))
    return ImuChunk.join(taken).ticks(0, tick_count)
