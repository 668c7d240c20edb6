"""Guidance for a session that has just been opened."""

import logging
from functools import partial
from typing import TYPE_CHECKING

from sqlalchemy import Engine

from app.assessment.design.prescribed import NotGuided
from app.live.bus import Bus, topic
from app.live.guidance.controller import GuidanceController
from app.live.guidance.resume_state import read_guidance, taken_up
from estimators.errors import EstimationError
from estimators.guidance.live import GuidanceRunner
from estimators.sentences import say

if TYPE_CHECKING:
    from app.live.session.runner import LiveSession
    from app.live.session.streamed import Streamed

logger = logging.getLogger(__name__)


def is_to_be_guided(engine: Engine, session_id: str, default_zone: str) -> bool:
    """Say whether a session is of a prescription that guides it; blocks.

    Parameters
    ----------
    default_zone : str
        As of `guide_session`.
    """
    try:
        return read_guidance(engine, session_id, default_zone) is not None
    except (NotGuided, EstimationError):
        return False


def guide_session(
    session: "LiveSession", engine: Engine, bus: Bus, default_zone: str, streamed: "Streamed | None" = None
) -> None:
    """Give a session its guidance; blocks, so call it in a thread, before the session has frames.

    A template that cannot be followed leaves a word on the time line, and a session that goes on without it. So does
    one of a kind of session that is compared with its template afterwards only; that is no failure.

    Parameters
    ----------
    session : LiveSession
        Not yet given to anybody.
    default_zone : str
        In which a day begins where a clinic has not said so.
    streamed : Streamed, optional
        What was read already.
    """
    before = taken_up(engine, session.id) if streamed is None else streamed.guided
    is_prescribed = streamed is None or streamed.is_prescribed
    prescribed = None
    trouble = notice = ""
    try:
        prescribed = read_guidance(engine, session.id, default_zone) if is_prescribed else None
        if prescribed is not None:
            GuidanceRunner.prepare()
    except NotGuided as refused:
        # It is said once, not again whenever the service restarts.
        notice = "" if len(session.ledger.durable) else refused.message
    except EstimationError as error:
        logger.warning("session %s cannot be guided: %s", session.id, error)
        trouble = say("guided.cannot")
    session.guidance = GuidanceController(
        prescribed,
        session.declaration.time_step_s,
        before,
        session.add_event,
        partial(bus.publish, topic(session.id, "guidance")),
        trouble=trouble,
        notice=notice,
    )
