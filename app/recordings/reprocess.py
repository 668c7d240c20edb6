"""Estimating a stored session again, from all its packets, with the same or another estimator.

The result depends on the packets and the setup alone, not on the order in which the packets arrived: they
are read by rising sequence. Earlier results stay; the new one names the versions and parameters it was made
with.
"""

import logging
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Final

from sqlalchemy import func, select
from sqlalchemy.orm import Session

from app.database.base import utc_now
from app.database.unit_of_work import read_only, unit_of_work
from app.errors import InvalidInput, NotFound
from app.ingest.alignment import align_chunks, joined_chunks
from app.ingest.packet import Packet
from app.recordings.chunks import (
    RAW_STREAM,
    EncodedChunk,
    encode_frames,
)
from app.recordings.elbows import with_elbows
from app.recordings.heading_line import HeadingLine, HeadingReset, resets_in_force, with_first_headings
from app.recordings.jobs import JobContext
from app.recordings.magnetic import PIPELINE as MAGNETIC
from app.recordings.models import Job, MotionSession, Result, SessionEvent, SignalChunk
from app.recordings.raw_packet import RawPacket
from app.recordings.result_rows import CHUNKS_A_COMMIT, new_result, write_frames
from app.recordings.smoothing import SmoothedModules, SmoothedSession, remember, smoother_for
from app.recordings.stamped import stored_recording, ticks_of
from app.recordings.store import Source, read_packets_in_order, stored_ranges
from app.recordings.walk_analysis import follow_feet
from app.recordings.walks import PIPELINE as WALKING
from app.sentences import CATALOGUE, say
from estimators import pipelines
from estimators.conventions import Placement
from estimators.errors import CalibrationError, EstimationError
from estimators.orientation import DeviceConstants
from estimators.pipelines import FEET, SessionSetup, relative_feet
from estimators.recording import ImuChunk

logger = logging.getLogger(__name__)

PIECE_TICKS: Final = 1000
SINGLE_SENSORS: Final = pipelines.OrientationPipeline.name
_POSE_SEARCH_S: Final = 120.0
_TELL_MOUNTING: Final = ("t_pose", "functional", "passive")


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
    if recording is not None:
        yield from ticks_of(recording, piece_ticks)
        return
    if list(placements) == sent:
        yield from align_chunks(packets, hello, piece_ticks)
        return
    rows = [sent.index(name) for name in placements]
    for piece in align_chunks(packets, hello, piece_ticks):
        yield _picked(piece, rows)


def _picked(chunk: ImuChunk, rows: list[int]) -> ImuChunk:
    magnetometer = None if chunk.magnetometer_t is None else chunk.magnetometer_t[rows]
    return replace(
        chunk,
        gyroscope_radps=chunk.gyroscope_radps[rows],
        accelerometer_mps2=chunk.accelerometer_mps2[rows],
        magnetometer_t=magnetometer,
        quality=chunk.quality[rows],
        coil_state=None if chunk.coil_state is None else chunk.coil_state[rows],
        force_n=None if chunk.force_n is None else chunk.force_n[rows],
        moment_nm=None if chunk.moment_nm is None else chunk.moment_nm[rows],
    )


def reprocess(context: JobContext) -> str:
    """Task `reprocess`: estimate again; on closing a session also count, name the main result and compare.

    Arguments: `orientation`, `orientation_parameters` (absent: as in the session's setup), `close`. On closing
    the smoother of the session's filter takes its place, where there is one; the live result stays beside.
    """
    closing = bool(context.arguments.get("close"))
    with read_only(context.engine) as session:
        found = session.get_one(MotionSession, context.session_id)
        setup = SessionSetup.from_dict(found.setup)
        pose_s = _last_pose(session, found.id)
        resets = resets_in_force(session, found.id)
    if resets and setup.calibration is not None:
        # Each holds from its own moment on; `analyse` makes them again.
        setup = replace(setup, calibration=resets[0].undone(setup.calibration))
    own = setup.pipeline in (WALKING, MAGNETIC)
    follower = None if own else smoother_for(setup.orientation)
    wanted = context.arguments.get("orientation") or (closing and follower) or setup.orientation
    parameters = context.arguments.get("orientation_parameters", setup.orientation_parameters)
    is_other = wanted != setup.orientation or parameters != setup.orientation_parameters
    setup = replace(setup, orientation=wanted, orientation_parameters=dict(parameters))
    method = "" if setup.calibration is None else setup.calibration.method
    # A mounting found by movement holds for the smoother too: both face north, and there is no pose to repeat.
    is_kept = wanted == follower and method != "" and "pose" not in method
    if is_other and pose_s is not None and not is_kept:
        # Another filter has another heading to begin with: the pose is evaluated with its own orientation.
        setup = replace(setup, calibration=None)
    analysis = analyse(context, setup, pose_s, resets=resets)
    if closing and setup.pipeline == MAGNETIC and set(setup.placements) == set(FEET):
        _walk_too(context, setup)
    with unit_of_work(context.engine) as session:
        found = session.get_one(MotionSession, context.session_id)
        if closing or found.main_result_id is None:
            found.main_result_id = analysis.result_id
        if closing:
            count_session(session, found, analysis)
            remember(session, found, analysis.learnt)
            enqueue_comparison(session, found)
    return analysis.message


def _walk_too(context: JobContext, setup: SessionSetup) -> None:
    """Analyse a session with a source on one shoe as a walk as well; the message of that result says what failed."""
    with read_only(context.engine) as session:
        hello = session.get_one(MotionSession, context.session_id).hello
    pieces = list(aligned(context.engine, context.session_id, hello, setup.placements))
    if not pieces:
        return
    try:
        relative = relative_feet(joined_chunks(pieces), setup)
        walking = replace(setup, pipeline=WALKING, orientation_parameters={})
        follow_feet(context, walking, pieces, hello, 0.8, relative)
    except (EstimationError, InvalidInput):
        # Not a walk: nobody asked for one.
        logger.info("session %s holds no walk", context.session_id)


def enqueue_comparison(session: Session, found: MotionSession) -> None:
    """Queue what follows the analysis of a closed session: comparison, where a template is prescribed."""
    session.add(
        Job(session_id=found.id, kind="compare", arguments={"close": True}, created_by=found.created_by)
    )


def count_session(session: Session, found: MotionSession, analysis: Analysis) -> None:
    """Write how long the session was and what is missing of it."""
    stored = stored_ranges(session, found.id)
    found.packets_stored = len(stored)
    found.packets_missing = stored.missing_count
    found.duration_s = analysis.ticks / float(found.setup["rate_hz"])


def analyse(
    context: JobContext,
    setup: SessionSetup,
    pose_s: tuple[float, float] | None = None,
    *,
    search_pose: bool = False,
    progress_from: float = 0.0,
    resets: Sequence[HeadingReset] = (),
) -> Analysis:
    """Run the pipeline over the stored packets and keep the frames as a new result.

    Parameters
    ----------
    context : JobContext
    setup : SessionSetup
        With its calibration, or without: then the pose is evaluated first and applied to the whole session.
    pose_s : (float, float), optional
        Half-open session time of the N-pose.
    search_pose : bool
        Without `pose_s`, take the first stillness of the first two minutes.
    progress_from : float
        Where on the task's scale of 0 to 1 this work begins.
    resets : sequence of HeadingReset
        Made again at their ticks.
    """
    if setup.pipeline == WALKING:
        with read_only(context.engine) as session:
            hello = session.get_one(MotionSession, context.session_id).hello
        context.progress(progress_from, say("progress.reading_walk"))
        pieces = aligned(context.engine, context.session_id, hello, setup.placements)
        return Analysis(*follow_feet(context, setup, pieces, hello, progress_from), setup, None, "")
    message = ""
    known = _smoothed(context, setup) if pipelines.is_offline(setup) else None
    if setup.pipeline == SINGLE_SENSORS:
        # Nothing is worn: there is no pose, and the filters find what they need.
        search_pose, pose_s = False, None
    if setup.calibration is None and (pose_s is not None or search_pose):
        try:
            setup, pose_s = calibrated(context, setup, pose_s, known)
        except CalibrationError as error:
            message = say("session.not_calibrated_because", reason=error.message)
    elif setup.calibration is None and setup.pipeline not in (MAGNETIC, SINGLE_SENSORS):
        message = say("session.no_pose")
    if setup.calibration is not None and pose_s is not None:
        setup = with_elbows(setup, pose_s, _pieces(context, setup, known))
    if setup.calibration is not None and setup.calibration.unknown_headings:
        setup, resets = with_first_headings(setup, resets, _pieces(context, setup, known))
    line = HeadingLine(pipelines.create(setup), resets if setup.calibration is not None else ())
    result_id = new_result(context, setup, line.pipeline)
    with read_only(context.engine) as session:
        total = session.scalar(
            select(func.sum(SignalChunk.ticks)).where(
                SignalChunk.session_id == context.session_id, SignalChunk.stream == RAW_STREAM
            )
        )
    ticks = 0
    waiting: list[EncodedChunk] = []
    for piece in _modules(context, setup) if setup.pipeline == MAGNETIC else _pieces(context, setup, known):
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
    learnt = known.learnt if known is not None else {}
    return Analysis(
        result_id, ticks, setup, pose_s if setup.calibration is not None else None, message, learnt
    )


def _smoothed(context: JobContext, setup: SessionSetup) -> SmoothedSession:
    """Read the whole session and smooth it."""
    pieces = _pieces(context, setup, None)
    context.progress(0.0, say("progress.smoothing"))
    return SmoothedSession(pieces, setup)


def _modules(context: JobContext, setup: SessionSetup) -> SmoothedModules:
    """Read a whole session with a magnetic source and smooth it."""
    context.progress(0.0, say("progress.smoothing"))
    return SmoothedModules(_pieces(context, setup, None), setup)


def _pieces(context: JobContext, setup: SessionSetup, known: SmoothedSession | None) -> Iterable[ImuChunk]:
    """Return the whole session from its first tick on, smoothed where that was done."""
    if known is not None:
        return known
    with read_only(context.engine) as session:
        hello = session.get_one(MotionSession, context.session_id).hello
    return aligned(context.engine, context.session_id, hello, setup.placements)


def calibrated(
    context: JobContext,
    setup: SessionSetup,
    pose_s: tuple[float, float] | None,
    known: SmoothedSession | None = None,
) -> tuple[SessionSetup, tuple[float, float]]:
    """Run up to the end of the pose and evaluate it there; return the calibrated setup and the pose.

    `known` is the session smoothed, where the setup names a smoother.

    Raises
    ------
    CalibrationError
        No usable pose, with what to do.
    """
    limit_s = _POSE_SEARCH_S if pose_s is None else pose_s[1]
    limit = round(limit_s * setup.rate_hz)
    chunk = beginning(context, setup, limit) if known is None else known.until(limit)
    if chunk is None:
        raise CalibrationError(say("session.no_packets"))
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


def beginning(context: JobContext, setup: SessionSetup, tick_count: int) -> ImuChunk | None:
    """Return the first ticks of the session as one chunk; None if there are none.

    Parameters
    ----------
    context : JobContext
    setup : SessionSetup
        Names the sensors wanted.
    tick_count : int
    """
    pieces: list[ImuChunk] = []
    with read_only(context.engine) as session:
        hello = session.get_one(MotionSession, context.session_id).hello
    for piece in aligned(context.engine, context.session_id, hello, setup.placements):
        pieces.append(piece)
        if piece.first_tick + piece.tick_count >= tick_count:
            break
    if not pieces:
        return None
    chunk = joined_chunks(pieces)
    return chunk.ticks(0, min(tick_count, chunk.tick_count))


def stretches(context: JobContext, setup: SessionSetup, length_s: float) -> Iterator[ImuChunk]:
    """Yield the session in chunks of about a length, one at a time.

    Parameters
    ----------
    context : JobContext
    setup : SessionSetup
        Names the sensors wanted.
    length_s : float
    """
    with read_only(context.engine) as session:
        hello = session.get_one(MotionSession, context.session_id).hello
    pieces: list[ImuChunk] = []
    for piece in aligned(context.engine, context.session_id, hello, setup.placements):
        pieces.append(piece)
        if sum(one.tick_count for one in pieces) * piece.time_step_s >= length_s:
            yield joined_chunks(pieces)
            pieces = []
    if pieces:
        yield joined_chunks(pieces)


def _last_pose(session: Session, session_id: str) -> tuple[float, float] | None:
    """Return the stretch of the standing pose in force; None where something else set the mounting.

    A T-pose or movements are not evaluated anew: mountings do not depend on the filter, and with a compass the
    facing does not either. Headings set anew and biases found later leave the pose in force.
    """
    events = session.scalars(
        select(SessionEvent)
        .where(SessionEvent.session_id == session_id, SessionEvent.kind == "calibration")
        .where(SessionEvent.duration_s > 0)
        .order_by(SessionEvent.time_s.desc())
    )
    for event in events:
        kind = (event.details or {}).get("kind", "n_pose")
        if kind == "n_pose":
            return event.time_s, event.time_s + event.duration_s
        if kind in _TELL_MOUNTING:
            return None
    return None


__all__ = [
    "Analysis",
    "aligned",
    "analyse",
    "beginning",
    "calibrated",
    "count_session",
    "decoded",
    "enqueue_comparison",
    "reprocess",
    "stretches",
]
