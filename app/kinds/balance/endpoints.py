"""HTTP of balance tests."""

from typing import Literal

from fastapi import APIRouter

from app.accounts.dependencies import CurrentSubject
from app.database.dependencies import ReadSession
from app.kinds.balance.schemas import BalanceTestOut
from app.kinds.balance.trials import balance_of

router = APIRouter(prefix="/api", tags=["sessions"])


@router.get("/sessions/{session_id}/balance")
def get_balance(
    session_id: str,
    session: ReadSession,
    subject: CurrentSubject,
    result_id: str | None = None,
    placement: Literal["pelvis", "sternum"] | None = None,
) -> BalanceTestOut:
    """Return a balance test: measures of sway and reach of each trial with uncertainty, and Romberg's ratio.

    Of the sensor on the pelvis where one was worn, unless `placement` says otherwise.
    """
    return balance_of(session, subject, session_id, result_id, placement)
