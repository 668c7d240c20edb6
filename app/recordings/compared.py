"""The part of a stored result that is compared with a template: channels, and the movement that is repeated."""

from collections.abc import Mapping
from dataclasses import dataclass

from sqlalchemy.orm import Session

from app.errors import InvalidInput
from app.recordings.models import MotionSession, Result
from app.recordings.signals.store import read_frames
from estimators.comparison import (
    NamedPhase,
    Repetition,
    Trajectory,
    find_repetitions,
    judge_repetitions,
    trajectory,
)
from estimators.conventions import Side
from estimators.errors import ComparisonError
from estimators.pipelines import Frames, SessionSetup
from estimators.sentences import say


@dataclass(frozen=True)
class Cycles:
    """What one side did over and over where the analysis itself has cut it, as the strides of a walk.

    Attributes
    ----------
    repetitions : tuple of Repetition
        What the analysis does not count is left out, with its reason.
    main_channel : str
        Whose range is the main measure.
    phases : tuple of NamedPhase
        That a template begins with; their names are English words, which the client has in its languages.
    watched : tuple of str
        Channels that a template shows and does not judge, unless a therapist says so.
    absent : str
        Why nothing of this side can be compared; empty where something can.
    """

    repetitions: tuple[Repetition, ...]
    main_channel: str
    phases: tuple[NamedPhase, ...] = ()
    watched: tuple[str, ...] = ()
    absent: str = ""


@dataclass(frozen=True)
class Source:
    """A recorded session as comparisons and templates see it.

    Attributes
    ----------
    reach_m : float
        Upper arm plus forearm of the person recorded, as the result was made with.
    start_s, end_s : float or None
        Half-open stretch of the session in which repetitions are looked for.
    cycles : mapping of Side to Cycles, or None
        Of the sides that were measured; None where nobody has cut the movement yet.
    """

    session_id: str
    result_id: str
    moved: Trajectory
    reach_m: float
    start_s: float | None
    end_s: float | None
    cycles: Mapping[Side, Cycles] | None = None

    def judged(self, side: str) -> list[Repetition]:
        """Return the repetitions of a side, those left out with their reason.

        Raises
        ------
        ComparisonError
            If nothing of that side was measured.
        """
        if self.cycles is None:
            found = find_repetitions(self.moved, side, self.start_s, self.end_s)
            return judge_repetitions(self.moved, found, side)
        cut = self.cycles.get("left" if side == "left" else "right")
        if cut is not None and cut.absent:
            raise ComparisonError(cut.absent)
        return [] if cut is None else list(cut.repetitions)

    def acting_side(self, named: str, affected: str | None, template: str | None = None) -> str:
        """Return which side counts.

        Parameters
        ----------
        named : str
            By the exercise: it decides, unless the exercise is one of both sides as a walk is.
        affected : str or None
            Side of the patient that is affected; it counts in a walk.
        template : str, optional
            Side of the template, where the patient has no affected one.
        """
        if self.cycles is None:
            return named
        sides: list[str] = [one for one in (affected, template, named, *self.cycles) if one is not None]
        return next((one for one in sides if one in self.cycles), named)


def frames_of(session: Session, result: Result) -> Frames:
    """Return a result's frames; raises `InvalidInput` where it has none."""
    frames = read_frames(session, result.id)
    if not frames.tick_count:
        raise InvalidInput(say("result.no_frames"), field="result_id")
    return frames


def body_source(session: Session, found: MotionSession, result: Result) -> Source:
    """Read a result's frames as the trajectory of a body, in which repetitions are looked for; access was checked."""
    body = SessionSetup.from_dict(result.setup).body
    return Source(
        found.id,
        result.id,
        trajectory(frames_of(session, result)),
        body.upper_arm_m + body.forearm_m,
        found.recording_start_s,
        found.recording_end_s,
    )
