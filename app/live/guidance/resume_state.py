"""The state of a guided session from its stored time line: a restart of the service loses no repetition."""

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any, Final

from sqlalchemy import Engine, Row, select
from sqlalchemy.orm import Session

from app.assessment.design.prescribed import PrescribedGuidance, prescribed_guidance
from app.database.unit_of_work import read_only
from app.live.guidance.messages import GuidanceCause, GuidanceCounts
from app.recordings.models import SessionEvent

ENDS_A_SET: Final = ("valid_count", "set", "attempt_count")
"""Causes after which a set begins again."""
_HELD = ("pain", "guidance_stop", "guidance_pause", "guidance_resume")


@dataclass(frozen=True)
class ResumeState:
    """Where the guidance of a session stood.

    Attributes
    ----------
    in_set : GuidanceCounts
        Of `counts`, those since the last set ended.
    is_done : bool
        The prescribed number was reached.
    cause : str
        Why it was paused or stopped; empty while it went on.
    time_s : float
        Session time of the last entry.
    has_set_aside : bool
        Limits that rest itself breaks were found and reported.
    """

    counts: GuidanceCounts = field(default_factory=GuidanceCounts)
    in_set: GuidanceCounts = field(default_factory=GuidanceCounts)
    has_ended_a_set: bool = False
    is_done: bool = False
    cause: GuidanceCause = ""
    is_stopped: bool = False
    time_s: float = 0.0
    has_set_aside: bool = False


def read_guidance(engine: Engine, session_id: str, default_zone: str) -> PrescribedGuidance | None:
    """Return what a session is guided by, for the service's own work; blocks.

    Raises
    ------
    SetupError
        If the template cannot be followed.
    """
    with read_only(engine) as session:
        return prescribed_guidance(session, session_id, default_zone)


def taken_up(engine: Engine, session_id: str) -> ResumeState:
    """Read where the guidance of a session stood; blocks."""
    with read_only(engine) as session:
        return stood(session, [session_id])[session_id]


def stood(session: Session, session_ids: Sequence[str]) -> dict[str, ResumeState]:
    """Return where the guidance of each session stood."""
    of_session: dict[str, list[Row[Any]]] = {one: [] for one in session_ids}
    for row in session.execute(
        select(SessionEvent.session_id, SessionEvent.kind, SessionEvent.time_s, SessionEvent.details)
        .where(
            SessionEvent.session_id.in_(session_ids),
            SessionEvent.kind.in_(("repetition", "limit_at_rest", *_HELD)),
        )
        .order_by(SessionEvent.created_at, SessionEvent.id)
    ):
        of_session[row.session_id].append(row)
    return {one: _stood(events) for one, events in of_session.items()}


def _stood(events: Sequence[Row[Any]]) -> ResumeState:
    ends = [place for place, one in enumerate(events) if one.details.get("cause") in ENDS_A_SET]
    held = next((one for one in reversed(events) if one.kind in _HELD), None)
    is_held = held is not None and held.kind != "guidance_resume"
    return ResumeState(
        counts=_counted(one.details.get("kind") for one in events if one.kind == "repetition"),
        in_set=_counted(
            one.details.get("kind")
            for one in events[ends[-1] + 1 if ends else 0 :]
            if one.kind == "repetition"
        ),
        has_ended_a_set=bool(ends),
        is_done=any(one.details.get("cause") == "valid_count" for one in events),
        cause=held.details.get("cause", "person") if held is not None and is_held else "",
        is_stopped=is_held and held is not None and held.kind != "guidance_pause",
        has_set_aside=any(one.kind == "limit_at_rest" for one in events),
        time_s=max((one.time_s for one in events), default=0.0),
    )


def _counted(kinds: Iterable[str]) -> GuidanceCounts:
    counted = Counter(kinds)
    return GuidanceCounts(**{kind: counted[kind] for kind in ("valid", "partial", "wrong")})
