"""What of a guided session is known from its stored time line, so that a restart of the service loses no repetition."""

from collections import Counter
from dataclasses import dataclass, field

from sqlalchemy import Engine, select

from app.assessment.design.prescribed import PrescribedGuidance, prescribed_guidance
from app.database.unit_of_work import read_only
from app.live.guidance.messages import GuidanceCause, GuidanceCounts
from app.recordings.models import SessionEvent

_HELD = ("pain", "guidance_stop", "guidance_pause", "guidance_resume")


@dataclass(frozen=True)
class TakenUp:
    """Where the guidance of a session stood.

    Attributes
    ----------
    counts : GuidanceCounts
    cause : str
        Why it was paused or stopped; empty while it went on.
    is_stopped : bool
    time_s : float
        Session time of the last entry.
    """

    counts: GuidanceCounts = field(default_factory=GuidanceCounts)
    cause: GuidanceCause = ""
    is_stopped: bool = False
    time_s: float = 0.0


def read_guidance(engine: Engine, session_id: str) -> PrescribedGuidance | None:
    """Return what a session is guided by, for the service's own work; blocks.

    Raises
    ------
    SetupError
        If the template cannot be followed.
    """
    with read_only(engine) as session:
        return prescribed_guidance(session, session_id)


def taken_up(engine: Engine, session_id: str) -> TakenUp:
    """Read where the guidance of a session stood; blocks."""
    with read_only(engine) as session:
        events = session.execute(
            select(SessionEvent.kind, SessionEvent.time_s, SessionEvent.details)
            .where(SessionEvent.session_id == session_id, SessionEvent.kind.in_(("repetition", *_HELD)))
            .order_by(SessionEvent.created_at, SessionEvent.id)
        ).all()
    counted = Counter(one.details.get("kind") for one in events if one.kind == "repetition")
    held = next((one for one in reversed(events) if one.kind in _HELD), None)
    is_held = held is not None and held.kind != "guidance_resume"
    return TakenUp(
        counts=GuidanceCounts(**{kind: counted[kind] for kind in ("valid", "partial", "wrong")}),
        cause=held.details.get("cause", "person") if held is not None and is_held else "",
        is_stopped=is_held and held is not None and held.kind != "guidance_pause",
        time_s=max((one.time_s for one in events), default=0.0),
    )


__all__ = ["TakenUp", "read_guidance", "taken_up"]
