"""A patient's requests to the guidance over HTTP: pause, go on, "it hurts", stop."""

import asyncio

from fastapi import APIRouter, Request

from app.accounts.dependencies import CurrentSubject
from app.live import repository
from app.live.guidance.messages import GuidanceCommandIn, GuidanceMessage
from app.live.service import SteeredLiveService
from app.services import services_of

router = APIRouter(prefix="/api/sessions", tags=["live"])


@router.post("/{session_id}/guidance")
async def command_guidance(
    session_id: str, body: GuidanceCommandIn, request: Request, subject: CurrentSubject
) -> GuidanceMessage:
    """Pause, resume, stop, or stop because it hurts, at once; the answer says how it stands then.

    A stop ends what is counted and said; the session is ended by `close`.
    """
    services = services_of(request)
    await asyncio.to_thread(
        repository.authorise,
        services.engine,
        subject,
        session_id,
        "record",
        f"session.{body.command}_exercise",
    )
    live: SteeredLiveService = services.get(SteeredLiveService)
    return live.guidance(session_id).obey(body.command)


@router.get("/{session_id}/guidance")
async def get_guidance(session_id: str, request: Request, subject: CurrentSubject) -> GuidanceMessage:
    """Return how the guidance of a live session stands."""
    services = services_of(request)
    await asyncio.to_thread(repository.authorise, services.engine, subject, session_id, "read")
    live: SteeredLiveService = services.get(SteeredLiveService)
    return live.guidance(session_id).message
