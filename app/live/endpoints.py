"""Steering a live session over HTTP: tickets, calibration, recording, marks and closing."""

import asyncio
from typing import Literal

from fastapi import APIRouter, Request

from app.accounts.dependencies import CurrentSubject
from app.accounts.schemas import TicketIn, TicketOut
from app.accounts.subject import Subject
from app.kinds.magnetic.schemas import MagneticSafetyOut
from app.live import repository
from app.live.calibration.endpoints import router as calibration_router
from app.live.calibration.messages import CalibrationIn
from app.live.guidance.endpoints import router as guidance_router
from app.live.messages import StateMessage
from app.live.next_session import router as device_router
from app.live.service import SteeredLiveService
from app.recordings.schemas import MarkIn
from app.services import services_of
from estimators.sentences import say

steering_router = APIRouter(prefix="/api/sessions", tags=["live"])


@steering_router.post("/{session_id}/ticket")
def give_ticket(session_id: str, body: TicketIn, request: Request, subject: CurrentSubject) -> TicketOut:
    """Get a one-use right to open a socket of this session within 30 seconds.

    `ingest` needs the right to record, `live` the right to read. The ticket goes into the socket's first
    message, never into a URL.
    """
    services = services_of(request)
    token, expires_at = repository.give_ticket(
        services.engine, subject, session_id, body.purpose, services.settings.implant_confirmation_hours
    )
    path = "/ws/ingest" if body.purpose == "ingest" else f"/ws/live/{session_id}"
    return TicketOut(ticket=token, expires_at=expires_at, path=path)


@steering_router.post("/{session_id}/calibrate")
async def calibrate(session_id: str, request: Request, subject: CurrentSubject) -> StateMessage:
    """Look for three still seconds in the N-pose and calibrate; progress comes over the live socket."""
    live = await _live(request, subject, session_id, "calibrate")
    session = live.live(session_id)
    session.start_calibration(CalibrationIn(kind="n_pose"))
    return session.state_message()


@steering_router.post("/{session_id}/record")
async def begin_recording(session_id: str, request: Request, subject: CurrentSubject) -> StateMessage:
    """Begin the interval in which repetitions count; the session must be calibrated."""
    live = await _live(request, subject, session_id, "record")
    session = live.live(session_id)
    session.record()
    await session.saved()
    return session.state_message()


@steering_router.post("/{session_id}/stop")
async def stop_recording(session_id: str, request: Request, subject: CurrentSubject) -> StateMessage:
    """End the interval in which repetitions count; the sensors go on streaming."""
    live = await _live(request, subject, session_id, "stop")
    session = live.live(session_id)
    session.stop()
    await session.saved()
    return session.state_message()


@steering_router.post("/{session_id}/mark")
async def mark(session_id: str, body: MarkIn, request: Request, subject: CurrentSubject) -> StateMessage:
    """Put a note on the time line at the present session time."""
    live = await _live(request, subject, session_id, "mark")
    session = live.live(session_id)
    session.mark(body.text, body.label)
    return session.state_message()


@steering_router.post("/{session_id}/close")
async def close(session_id: str, request: Request, subject: CurrentSubject) -> StateMessage:
    """End the session: everything is stored, analysed off-line and compared with the prescribed template."""
    live = await _live(request, subject, session_id, "close")
    return await live.close(session_id, say("live.closed_by_person"))


@steering_router.post("/{session_id}/reopen")
async def reopen(session_id: str, request: Request, subject: CurrentSubject) -> StateMessage:
    """Let a session that has ended take what its gateway still has: connect then, send it, and close the session again.

    Needs the right to record; a session that is open stays as it is. What was found of it stays until it is analysed
    again. One that was uploaded is refused (409), one that is being analysed at this moment too (503 with a time).
    """
    live = await _live(request, subject, session_id, "reopen")
    return await live.reopen(session_id)


@steering_router.delete("/{session_id}/magnetic-safety")
async def withdraw_safety(session_id: str, request: Request, subject: CurrentSubject) -> MagneticSafetyOut:
    """Withdraw the confirmation that nobody has an implant: the source stops at once until it is confirmed again.

    Needs the right to treat. Audited. The sensors go on streaming, without the source.
    """
    services = services_of(request)
    hours = services.settings.implant_confirmation_hours
    live: SteeredLiveService = services.get(SteeredLiveService)
    try:
        return await asyncio.to_thread(
            repository.withdraw_safety, services.engine, subject, session_id, hours
        )
    finally:
        # Also when there was nothing left to withdraw: whoever presses again wants the source off.
        await live.check_source(session_id)


@steering_router.get("/{session_id}/state")
async def state(session_id: str, request: Request, subject: CurrentSubject) -> StateMessage:
    """Get the state of a session, live or not."""
    services = services_of(request)
    await asyncio.to_thread(repository.authorise, services.engine, subject, session_id, "status")
    live: SteeredLiveService = services.get(SteeredLiveService)
    return await live.state(session_id)


Action = Literal["calibrate", "record", "stop", "mark", "close", "reopen"]


async def _live(request: Request, subject: Subject, session_id: str, action: Action) -> SteeredLiveService:
    """Return the live side after the access check, with the action in the audit trail."""
    services = services_of(request)
    await asyncio.to_thread(
        repository.authorise, services.engine, subject, session_id, "record", f"session.{action}"
    )
    live: SteeredLiveService = services.get(SteeredLiveService)
    return live


router = APIRouter()
router.include_router(steering_router)
router.include_router(calibration_router)
router.include_router(guidance_router)
router.include_router(device_router)
