"""Sensors that turned in their strap during a stored session: found first, then flagged in its result and reported."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Final

from sqlalchemy import func, select

from app.database.unit_of_work import read_only, unit_of_work
from app.recordings.analysis.heading_line import MOUNTINGS, HeadingLine, HeadingReset
from app.recordings.analysis.jobs import JobContext
from app.recordings.models import MotionSession, SessionEvent
from app.recordings.repository import replace_events
from estimators import pipelines
from estimators.pipelines import Frames, Pipeline, SessionSetup, Slip, SlipSearch
from estimators.recording import ImuChunk
from estimators.sentences import Sentence, say

EVENT: Final = "sensor_slipped"
_JOINTS: Final[Mapping[str, tuple[str, ...]]] = {
    "sternum": ("trunk", "shoulder"),
    "upper_arm": ("shoulder", "elbow"),
    "forearm": ("elbow", "wrist"),
    "hand": ("wrist",),
}
"""Whose angles a sensor is needed for."""


class SlippedLine(HeadingLine):
    """A pipeline over a stored session, with the slips that were found in it."""

    def __init__(self, pipeline: Pipeline, resets: Sequence[HeadingReset], slips: Sequence[Slip]) -> None:
        super().__init__(pipeline, resets)
        self._slips = slips

    def step(self, piece: ImuChunk) -> Iterator[Frames]:
        """Yield the frames of the next ticks, flagged from each slip on."""
        for frames in super().step(piece):
            yield pipelines.with_slips(frames, self.pipeline.setup, self._slips)


def slips_of(
    setup: SessionSetup, resets: Sequence[HeadingReset], pieces: Iterable[ImuChunk], from_s: float
) -> tuple[tuple[Slip, ...], Frames | None]:
    """Go through a session once and return its slips, earliest first, and its postures.

    Parameters
    ----------
    pieces : iterable of ImuChunk
        The whole session, as its result will be estimated.
    from_s : float
        Session time from which the sensors are worn as they were calibrated.

    Returns
    -------
    slips : tuple of Slip
    postures : Frames or None
        As `estimators.pipelines.elbow_poses` thins them; None without a calibration or samples.
    """
    if setup.calibration is None or not setup.calibration.q_sensor_segment:
        return (), None
    line, search = HeadingLine(pipelines.create(setup), resets), SlipSearch(setup, from_s)
    thinned: list[Frames] = []
    for piece in pieces:
        for frames in line.step(piece):
            first = frames.first_tick - piece.first_tick
            search.add(frames, piece.ticks(first, first + frames.tick_count))
            if (poses := pipelines.elbow_poses(frames)).tick_count:
                thinned.append(poses)
    return search.finish(), pipelines.concatenate(thinned) if thinned else None


def mounted_since_s(context: JobContext, resets: Sequence[HeadingReset]) -> float:
    """Return from when on the sensors are worn as the calibration in force says.

    Parameters
    ----------
    resets : sequence of HeadingReset
        Since the mounting in force was set, earliest first.

    Returns
    -------
    float
        Session time of the end of the last calibration that tells how sensors sit. Of a mounting remembered from an
        earlier session nobody knows when the straps were put right: the first heading was set after that, and Record
        pressed.
    """
    end_s = SessionEvent.time_s + SessionEvent.duration_s
    with read_only(context.engine) as session:
        found = session.scalar(
            select(func.max(end_s)).where(
                SessionEvent.session_id == context.session_id,
                SessionEvent.kind == "calibration",
                SessionEvent.duration_s > 0,
                SessionEvent.details["kind"].as_string().in_(MOUNTINGS),
            )
        )
        if found is not None:
            return float(found)
        record_s = session.get_one(MotionSession, context.session_id).recording_start_s
    return max(record_s or 0.0, resets[0].stop_s if resets else 0.0)


def report_slips(context: JobContext, slips: Sequence[Slip]) -> None:
    """Put slips on the time line in place of those that an earlier analysis found."""
    events = [
        SessionEvent(
            session_id=context.session_id,
            kind=EVENT,
            time_s=rivals[0].time_s,
            placement=rivals[0].placement if len(rivals) == 1 else None,
            text=in_words(rivals),
            details={
                "placements": [one.placement for one in rivals],
                "turn_rad": rivals[0].angle_rad,
            },
        )
        for rivals in pipelines.in_doubt(slips)
    ]
    with unit_of_work(context.engine) as session:
        replace_events(session, context.session_id, EVENT, events)


def in_words(rivals: Sequence[Slip]) -> Sentence:
    """Return a slip as a sentence; of several slips only one is meant, and nobody knows which."""
    time_s = int(rivals[0].time_s)
    joints = [joint for one in rivals for joint in _joints_of(one)]
    return say(
        "slip.turned",
        where=[one.placement for one in rivals],
        at=f"{time_s // 60}:{time_s % 60:02d}",
        angle_rad=rivals[0].angle_rad,
        joints=list(dict.fromkeys(joints)),
    )


def _joints_of(slip: Slip) -> tuple[str, ...]:
    part = slip.placement.removesuffix("_left").removesuffix("_right")
    return _JOINTS[part]
