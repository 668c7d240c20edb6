"""Valid practice in one session: accepted repetitions, and how long the exercise was really done."""

from collections.abc import Iterable
from typing import Final, NamedTuple

from sqlalchemy.orm import Session

from app.assessment.sources import load_source
from app.errors import InvalidInput, NotFound
from app.exercises.models import Exercise
from app.kinds.walk.history import any_walk
from app.kinds.walk.schemas import WalkContent
from app.recordings import repository as recordings
from app.recordings.models import MotionSession
from app.recordings.signals.store import read_frames
from estimators.comparison import Repetition, moving_time
from estimators.errors import EstimationError
from estimators.gait import GUIDED_KINDS

WITHOUT_REPETITIONS: Final = frozenset({"other"})
"""Kinds of exercises that need not repeat anything: balance, holding, stretching."""
LEAST_MOVING_S: Final = 10.0
"""Putting the sensors on and off moves them too; less than this is no exercise."""


class Practised(NamedTuple):
    """What was valid in one session.

    Attributes
    ----------
    repetitions : int
        Accepted, and valid where they were counted live; 0 for walks.
    active_s : float
        Time inside the accepted repetitions, also those that did not go far enough, in the strides that count, or in
        movement; 0 when nothing was practised.
    """

    repetitions: int
    active_s: float


NOTHING: Final = Practised(0, 0.0)


def practised(
    session: Session, found: MotionSession, repetitions: Iterable[Repetition] | None = None
) -> Practised:
    """Measure what was valid in an analysed session; see `practised_or_why`."""
    return practised_or_why(session, found, repetitions)[0]


def practised_or_why(
    session: Session,
    found: MotionSession,
    repetitions: Iterable[Repetition] | None = None,
    refused: str = "",
) -> tuple[Practised, str]:
    """Measure what was valid in an analysed session, in its main result.

    Parameters
    ----------
    repetitions : iterable of Repetition, optional
        Judged, where a comparison has found them already.
    refused : str
        Why the comparison with the template was refused: what it cannot be held against is not what was prescribed,
        and does not count. A walk, and an exercise that need not repeat anything, count by themselves.

    Returns
    -------
    str
        Why it does not count though something was recorded; empty otherwise.

    Notes
    -----
    Walks, also those of no exercise, count by the strides that are steady, walking tests by the time of the test,
    everything else by repetitions that were accepted. Exercises that need not repeat anything count by movement where
    nothing repeats.
    """
    exercise = session.get(Exercise, found.exercise_id) if found.exercise_id else None
    if exercise is None or exercise.movement in GUIDED_KINDS:
        content = any_walk(session, found)
        if content is not None:
            return Practised(0, walked_s(content)), ""
        if exercise is not None:
            return NOTHING, ""
    needs_nothing = exercise is not None and exercise.movement in WITHOUT_REPETITIONS
    if refused and not needs_nothing:
        return NOTHING, refused
    try:
        accepted = [one for one in repetitions or () if one.is_kept]
        if repetitions is None:
            side = exercise.side if exercise is not None else "right"
            accepted = [one for one in _found(session, found, side) if one.is_kept]
    except NotFound:
        return NOTHING, ""
    except (EstimationError, InvalidInput) as error:
        if not needs_nothing:
            return NOTHING, error.message
        accepted = []
    if not accepted and needs_nothing:
        try:
            return Practised(0, _moving_s(session, found)), ""
        except (EstimationError, InvalidInput, NotFound):
            return NOTHING, ""
    valid = sum(one.counted in ("", "valid") for one in accepted)
    return Practised(valid, sum(one.end_s - one.start_s for one in accepted)), ""


def walked_s(content: WalkContent) -> float:
    """Return how long somebody walked steadily, or how long a walking test took, in seconds.

    Notes
    -----
    Of the foot with more of it: the strides of both feet overlap. In a test that starts, turns and sits down on a few
    metres hardly a stride is steady, and the test itself is what was to be done.
    """
    if content.test is not None and content.test.kind != "walk":
        return content.test.time_s
    return max(
        (sum(one.duration_s or 0.0 for one in foot.strides if one.is_counted) for foot in content.feet),
        default=0.0,
    )


def _found(session: Session, found: MotionSession, side: str) -> list[Repetition]:
    source = load_source(session, found, recordings.result_of(session, found, None))
    # Steps taken in another exercise, as of balance, are no repetitions of it.
    return source.judged(side) if source.cycles is None else []


def _moving_s(session: Session, found: MotionSession) -> float:
    result = recordings.result_of(session, found, None)
    moved_s = moving_time(read_frames(session, result.id), found.recording_start_s, found.recording_end_s)
    return moved_s if moved_s >= LEAST_MOVING_S else 0.0
