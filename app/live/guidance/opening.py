"""Guidance for a session that has just been opened."""

import logging
from functools import partial
from typing import TYPE_CHECKING

from sqlalchemy import Engine

from app.live.bus import Bus, topic
from app.live.guidance.desk import GuidanceDesk
from app.live.guidance.taken_up import read_guidance, taken_up
from app.sentences import say
from estimators.errors import EstimationError
from estimators.guidance import Guide

if TYPE_CHECKING:
    from app.live.session.runner import LiveSession

logger = logging.getLogger(__name__)


def guide_session(session: "LiveSession", engine: Engine, bus: Bus, default_zone: str) -> None:
    """Give a session its guidance; blocks, so call it in a thread, before the session has frames.

    A template that cannot be followed leaves a word on the time line, and a session that goes on without it.

    Parameters
    ----------
    session : LiveSession
        Not yet given to anybody.
    engine : Engine
    bus : Bus
    default_zone : str
        In which a day begins where a clinic has not said so.
    """
    before = taken_up(engine, session.id)
    prescribed = None
    trouble = ""
    try:
        prescribed = read_guidance(engine, session.id, default_zone)
        if prescribed is not None:
            Guide.prepare()
    except EstimationError as error:
        logger.warning("session %s cannot be guided: %s", session.id, error)
        trouble = say("guided.cannot")
    session.guidance = GuidanceDesk(
        prescribed,
        session.declaration.time_step_s,
        before,
        session.add_event,
        partial(bus.publish, topic(session.id, "guidance")),
        trouble=trouble,
    )
