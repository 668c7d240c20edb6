"""A recorded session as comparisons and templates see it."""

from dataclasses import dataclass

from sqlalchemy.orm import Session

from app.errors import InvalidInput
from app.recordings.models import MotionSession, Result
from app.recordings.signals.store import read_frames
from app.sentences import say
from estimators.comparison import Trajectory, trajectory
from estimators.pipelines import SessionSetup


@dataclass(frozen=True)
class Source:
    """A recorded session as comparisons see it.

    Attributes
    ----------
    reach_m : float
        Upper arm plus forearm of the person recorded, as the result was made with.
    """

    session_id: str
    result_id: str
    moved: Trajectory
    reach_m: float
    start_s: float | None
    end_s: float | None


def load_source(session: Session, found: MotionSession, result: Result) -> Source:
    """Read a result's frames as a trajectory; access was checked."""
    frames = read_frames(session, result.id)
    if not frames.tick_count:
        raise InvalidInput(say("result.no_frames"), field="result_id")
    body = SessionSetup.from_dict(result.setup).body
    return Source(
        found.id,
        result.id,
        trajectory(frames),
        body.upper_arm_m + body.forearm_m,
        found.recording_start_s,
        found.recording_end_s,
    )


__all__ = ["Source", "load_source"]
