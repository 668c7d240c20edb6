"""Guided calibration over HTTP; its progress comes over the live socket."""

import asyncio

from fastapi import APIRouter, Request

from app.accounts.dependencies import CurrentSubject
from app.accounts.subject import Subject
from app.live import repository
from app.live.calibration.guides import GUIDES
from app.live.calibration.messages import CalibrationGuide, CalibrationIn, CalibrationMessage
from app.live.service import SteeredLiveService
from app.live.session.runner import LiveSession
from app.services import services_of

router = APIRouter(prefix="/api", tags=["calibration"])


@router.get("/calibrations")
def list_guides(subject: CurrentSubject) -> list[CalibrationGuide]:
    """Return the kinds of calibration with their steps, for the choice and the guide."""
    return list(GUIDES.values())


@router.post("/sessions/{session_id}/calibration/start")
async def start_calibration(
    session_id: str, wanted: CalibrationIn, request: Request, subject: CurrentSubject
) -> CalibrationMessage:
    """Begin a guided calibration, or begin it again; what is in force stays until the new one is done."""
    session = await _session(request, subject, session_id, f"calibration_{wanted.kind}")
    return session.start_calibration(wanted)


@router.post("/sessions/{session_id}/calibration/next")
async def next_step(session_id: str, request: Request, subject: CurrentSubject) -> CalibrationMessage:
    """End the present step of a guided calibration; after the last one it is evaluated.

    Steps of sensors in the hand (`magnetometer`) may be ended early: what was seen so far is evaluated.
    """
    session = await _session(request, subject, session_id, None)
    return session.next_calibration_step()


@router.post("/sessions/{session_id}/calibration/cancel")
async def cancel_calibration(
    session_id: str, request: Request, subject: CurrentSubject
) -> CalibrationMessage:
    """End a guided calibration without a result; what was in force stays in force."""
    session = await _session(request, subject, session_id, None)
    return session.cancel_calibration()


@router.get("/sessions/{session_id}/calibration")
async def get_calibration(
    session_id: str, request: Request, subject: CurrentSubject
) -> CalibrationMessage | None:
    """Return how far the present or last guided calibration of a live session is; null before the first."""
    services = services_of(request)
    await asyncio.to_thread(repository.authorise, services.engine, subject, session_id, "read")
    session: LiveSession = services.get(SteeredLiveService).live(session_id)
    return session.calibration_message


async def _session(request: Request, subject: Subject, session_id: str, action: str | None) -> LiveSession:
    """Return the live session after the access check."""
    services = services_of(request)
    await asyncio.to_thread(
        repository.authorise,
        services.engine,
        subject,
        session_id,
        "record",
        None if action is None else f"session.{action}",
    )
    found: LiveSession = services.get(SteeredLiveService).live(session_id)
    return found
