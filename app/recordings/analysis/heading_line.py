"""Headings set during a session, set again when the stored session is estimated.

A heading reset holds from the moment it was made: before it the calibration was another one, and with another
filter, or a smoother, the heading that it takes away is another too. So the resets are made again, each at its tick.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final

from sqlalchemy import select
from sqlalchemy.orm import Session

from app.recordings.models import SessionEvent
from estimators import pipelines
from estimators.calibration import Calibration
from estimators.conventions import Placement
from estimators.errors import CalibrationError
from estimators.pipelines import Frames, Pipeline, SessionSetup
from estimators.recording import ImuChunk
from estimators.sentences import say

MOUNTINGS: Final = ("n_pose", "t_pose", "functional", "passive")
"""Calibrations that set the mountings; headings set again and biases found later leave them in force."""


@dataclass(frozen=True)
class HeadingReset:
    """One reset: the half-open session time of its pose, the sensors, and the headings in force before."""

    start_s: float
    stop_s: float
    placements: tuple[Placement, ...]
    before: dict[str, Any]

    @staticmethod
    def details(placements: Sequence[Placement], before: Calibration | None) -> dict[str, Any]:
        """Return what an event must hold for the reset to be made again."""
        known = before or Calibration({}, {})
        return {
            "placements": list(placements),
            "before": {
                "facing_rad": known.facing_rad,
                "heading_offset_rad": dict(known.heading_offset_rad),
                "unknown_headings": list(known.unknown_headings),
            },
        }

    def undone(self, found: Calibration) -> Calibration:
        """Return the calibration with the headings that were in force before the reset."""
        return replace(
            found,
            facing_rad=self.before["facing_rad"],
            heading_offset_rad=dict(self.before["heading_offset_rad"]),
            unknown_headings=tuple(self.before["unknown_headings"]),
        )


def calibration_in_force(
    session: Session, session_id: str
) -> tuple[tuple[float, float] | None, tuple[HeadingReset, ...]]:
    """Return the calibration events that the analysis makes again.

    Returns
    -------
    pose_s : (float, float) or None
        Half-open session time of the standing pose in force; None where something else set the mounting. A T-pose or
        movements are not evaluated again: mountings do not depend on the filter, and with a compass the facing does not
        either.
    resets : tuple of HeadingReset
        Since the mounting in force was set, earliest first.
    """
    events = session.scalars(
        select(SessionEvent)
        .where(SessionEvent.session_id == session_id, SessionEvent.kind == "calibration")
        .where(SessionEvent.duration_s > 0)
        .order_by(SessionEvent.time_s.desc())
    )
    pose_s: tuple[float, float] | None = None
    found: list[HeadingReset] = []
    for event in events:
        details = event.details or {}
        kind = details.get("kind", "n_pose")
        if kind in MOUNTINGS:
            pose_s = (event.time_s, event.time_s + event.duration_s) if kind == "n_pose" else None
            break
        # Of sessions from before resets were made again it is not known what they set.
        if kind == "heading_reset" and "before" in details:
            stop_s = event.time_s + event.duration_s
            found.append(HeadingReset(event.time_s, stop_s, tuple(details["placements"]), details["before"]))
    return pose_s, tuple(reversed(found))


class HeadingLine:
    """Steps a pipeline over a stored session and sets headings again where that was done.

    Parameters
    ----------
    pipeline : Pipeline
        With the calibration in force before the first reset.
    resets : sequence of HeadingReset
        Earliest first.
    """

    def __init__(self, pipeline: Pipeline, resets: Sequence[HeadingReset]) -> None:
        self.pipeline = pipeline
        self.refused: list[str] = []
        """Resets that could not be made again, with why."""
        self._waiting = list(resets)
        self._before: ImuChunk | None = None

    def step(self, piece: ImuChunk) -> Iterator[Frames]:
        """Yield the frames of the next ticks, in as many parts as the resets make."""
        rate_hz = self.pipeline.setup.rate_hz
        start = 0
        while self._waiting:
            reset = self._waiting[0]
            first, stop = round(reset.start_s * rate_hz), round(reset.stop_s * rate_hz)
            cut = stop - piece.first_tick
            if cut > piece.tick_count:
                break
            self._waiting.pop(0)
            if cut > start:
                yield self.pipeline.step(piece.ticks(start, cut))
                start = cut
            try:
                self.pipeline.reset_heading(self._pose(piece, first, stop), reset.placements)
            except CalibrationError as error:
                self.refused.append(
                    say("session.headings_left_out", time_s=reset.stop_s, reason=error.message)
                )
        if start < piece.tick_count:
            yield self.pipeline.step(piece.ticks(start, piece.tick_count))
        self._before = piece

    @property
    def waiting(self) -> tuple[HeadingReset, ...]:
        """Resets not reached yet."""
        return tuple(self._waiting)

    def _pose(self, piece: ImuChunk, first: int, stop: int) -> ImuChunk:
        if first < piece.first_tick and self._before is not None:
            piece = ImuChunk.join([self._before, piece])
        begin = max(0, first - piece.first_tick)
        return piece.ticks(begin, max(begin + 1, stop - piece.first_tick))


def with_first_headings(
    setup: SessionSetup, resets: Sequence[HeadingReset], pieces: Iterable[ImuChunk]
) -> tuple[SessionSetup, tuple[HeadingReset, ...]]:
    """Let what the first resets tell hold from the beginning, where the mounting was remembered.

    Parameters
    ----------
    setup : SessionSetup
        Some headings are unknown.
    pieces : iterable of ImuChunk
        The session from tick 0 on.

    Returns
    -------
    setup : SessionSetup
        With all headings that a reset tells.
    resets : tuple of HeadingReset
        That follow later.
    """
    line = HeadingLine(pipelines.create(setup), resets)
    for piece in pieces:
        known = line.pipeline.setup.calibration
        if not line.waiting or known is None or not known.unknown_headings:
            break
        for _ in line.step(piece):
            pass
    return line.pipeline.setup, line.waiting
