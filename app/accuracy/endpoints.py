"""HTTP of the accuracy page."""

from fastapi import APIRouter

from app.accounts.dependencies import CurrentSubject
from app.accuracy.schemas import AccuracyReport
from app.accuracy.store import stored_report

router = APIRouter(prefix="/api", tags=["accuracy"])


@router.get("/accuracy")
def get_accuracy(subject: CurrentSubject) -> AccuracyReport:
    """Return the published experiments as this version measured them: published, required and ours."""
    return stored_report()
