"""The demonstration's own route: how far its past sessions are."""

from fastapi import APIRouter, Request

from app.accounts.dependencies import CurrentSubject
from app.demo.progress import HistoryProgress
from app.schemas import Schema
from app.services import services_of

router = APIRouter(prefix="/api", tags=["service"])


class HistoryOut(Schema):
    """Past sessions of the demonstration that are there, of those that will be."""

    prepared: int
    total: int


@router.get("/demonstration")
def demonstration(request: Request, subject: CurrentSubject) -> HistoryOut | None:
    """Return how far the past sessions of a demonstration are; null elsewhere and when all are there."""
    settings = services_of(request).settings
    history = HistoryProgress.of(settings.data_dir) if settings.demo else None
    if history is None or history.is_complete:
        return None
    return HistoryOut(prepared=len(history.done), total=history.total)
