"""A walk as comparisons and templates see it: each stride a repetition, with the curves of its foot."""

from typing import Final

import numpy as np
from sqlalchemy.orm import Session

from app.accounts.subject import Subject
from app.errors import Conflict, InvalidInput
from app.kinds.walk.history import stored_walk
from app.kinds.walk.schemas import FootCurve, FootCurvesOut, FootOut, StrideOut, WalkContent
from app.recordings import repository
from app.recordings.compared import Cycles, Source, frames_of
from app.recordings.models import MotionSession, Result
from estimators.comparison import NamedPhase, Repetition, Stood, foot_channels, foot_trajectory
from estimators.conventions import Side
from estimators.gait import StrideFlag
from estimators.pipelines import Frames, SessionSetup
from estimators.recording import Float
from estimators.sentences import say

_REASONS: Final = (
    (StrideFlag.OUTSIDE, say("stride.outside")),
    (StrideFlag.MISSING, say("stride.missing")),
    (StrideFlag.ALOFT, say("stride.aloft")),
    (StrideFlag.LONG, say("stride.long")),
    (StrideFlag.SIDEWAYS, say("stride.sideways")),
)


def walk_source(session: Session, found: MotionSession, result: Result) -> Source:
    """Read a walk with its strides; access was checked.

    Raises
    ------
    InvalidInput
        The result has no strides or no frames.
    """
    content = stored_walk(session, found.id, result.id)
    if content is None:
        raise InvalidInput(say("walk.no_strides"), field="result_id")
    return _source(session, found, result, content)


def _source(session: Session, found: MotionSession, result: Result, content: WalkContent) -> Source:
    frames = frames_of(session, result)
    return source_of(frames, content, result, (found.recording_start_s, found.recording_end_s))


def foot_curves(
    session: Session, subject: Subject, session_id: str, result_id: str | None, max_points: int
) -> FootCurvesOut:
    """Return the channels of the feet over the whole walk, every n-th tick of them.

    Parameters
    ----------
    result_id : str, optional
        The main result by default.
    max_points : int
        Of every curve.

    Raises
    ------
    NotFound
        No such session or result.
    Conflict
        The result has no strides.
    """
    found = repository.get_session(
        session, subject, session_id, action="session.gait", details={"result": result_id or "main"}
    )
    result = repository.result_of(session, found, result_id)
    content = stored_walk(session, found.id, result.id)
    if content is None:
        raise Conflict(say("walk.no_strides"))
    moved = _source(session, found, result, content).moved
    thin = slice(None, None, max(1, -(-len(moved.time_s) // max_points)))
    values = np.where(moved.valid, moved.values, np.nan)[thin]
    return FootCurvesOut(
        result_id=result.id,
        time_s=[round(float(t), 4) for t in moved.time_s[thin]],
        curves=[
            FootCurve(channel=name, value=_plain(values[:, column]), sigma=_plain(moved.sigma[thin, column]))
            for column, name in enumerate(moved.channels)
        ],
    )


def _plain(values: Float) -> list[float | None]:
    return [round(float(value), 5) if np.isfinite(value) else None for value in values]


def source_of(
    frames: Frames, content: WalkContent, result: Result, recorded_s: tuple[float | None, float | None]
) -> Source:
    """Return the walk of a result as what is compared.

    Parameters
    ----------
    content : WalkContent
        Stored with them.
    recorded_s : (float or None, float or None)
        Half-open session time in which strides count.
    """
    stood: dict[Side, Stood] = {
        foot.side: Stood(
            np.array([one.start_s for one in foot.footholds]),
            np.array([one.stop_s for one in foot.footholds]),
            np.array([[one.x_m, one.y_m, one.z_m] for one in foot.footholds]).reshape(-1, 3),
        )
        for foot in content.feet
    }
    body = SessionSetup.from_dict(result.setup).body
    return Source(
        result.session_id,
        result.id,
        foot_trajectory(frames, stood),
        body.upper_arm_m + body.forearm_m,
        *recorded_s,
        cycles={foot.side: cycles_of(foot, *recorded_s) for foot in content.feet},
    )


def cycles_of(foot: FootOut, start_s: float | None, end_s: float | None) -> Cycles:
    """Return the strides of a foot, each from a contact with the floor to the next.

    Parameters
    ----------
    start_s, end_s : float or None
        Half-open session time in which strides count.

    Returns
    -------
    Cycles
        Numbered as the strides are. The first stride of a bout is none of them: no contact was before it. Its phases
        are stance and swing, at the median part of the cycle that the counted strides stand. The speed is only
        watched: somebody who walks at another pace has another speed, and that is no other shape.
    """
    begins_s, ends_s = start_s or 0.0, np.inf if end_s is None else end_s
    strides = [
        one
        for one in foot.strides
        if one.duration_s is not None
        and one.contact_s is not None
        and begins_s <= one.contact_s - one.duration_s
        and one.contact_s < ends_s
    ]
    shares = [
        one.stance_s / one.duration_s
        for one in strides
        if one.is_counted and one.stance_s and one.duration_s and one.stance_s < one.duration_s
    ]
    border = round(float(np.median(shares)), 3) if shares else None
    _, height, speed = foot_channels(foot.side)
    return Cycles(
        tuple(_repetition(one) for one in strides),
        height,
        () if border is None else (NamedPhase("Stance", 0.0, border), NamedPhase("Swing", border, 1.0)),
        (speed,),
        # Channels are of the way between footholds.
        "" if len(foot.footholds) >= 2 else say("walk.no_stride", side=foot.side),
    )


def _repetition(one: StrideOut) -> Repetition:
    end_s = one.contact_s or 0.0
    return Repetition(
        one.number,
        end_s - (one.duration_s or 0.0),
        end_s,
        one.is_counted,
        "" if one.is_counted else _reason(one),
    )


def _reason(one: StrideOut) -> str:
    for flag, reason in _REASONS:
        if (one.flags or 0) & flag:
            return reason
    if one.is_termination:
        return say("stride.last")
    return say("stride.unsteady") if one.flags is None else say("stride.turning")
