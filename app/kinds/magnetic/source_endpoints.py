"""HTTP of magnetic sources whose coils were measured."""

from fastapi import APIRouter, Request

from app.accounts.dependencies import CurrentAccount, CurrentSubject
from app.database.dependencies import ReadSession, WriteSession
from app.kinds.magnetic import sources as magnetic_sources
from app.kinds.magnetic.source_schemas import (
    MagneticSourceIn,
    MagneticSourceOut,
    SourceCalibrationIn,
    SourceStopsOut,
)
from app.services import services_of
from estimators.conventions import Placement

router = APIRouter(prefix="/api", tags=["magnetic sources"])


@router.get("/magnetic-sources")
def list_sources(session: ReadSession, subject: CurrentAccount) -> list[MagneticSourceOut]:
    """Return the clinic's magnetic sources, for those who work there."""
    return magnetic_sources.list_sources(session, subject)


@router.post("/magnetic-sources", status_code=201)
def keep_source(
    wanted: MagneticSourceIn, session: WriteSession, subject: CurrentAccount
) -> MagneticSourceOut:
    """Keep a source with typed coils, or those that `telemotion calibrate-source` wrote.

    The same serial number replaces. Audited.
    """
    return magnetic_sources.keep(session, subject, wanted)


@router.delete("/magnetic-sources/{source_id}", status_code=204)
def retire_source(source_id: str, session: WriteSession, subject: CurrentAccount) -> None:
    """Offer a source no longer; sessions keep the coils that they were recorded with."""
    magnetic_sources.retire(session, subject, source_id)


@router.get("/sessions/{session_id}/source-stops")
def find_stops(
    session_id: str, session: ReadSession, subject: CurrentSubject, sensor: Placement | None = None
) -> SourceStopsOut:
    """Return where the sensor lay still in a magnetic session, for a calibration; needs the right to treat."""
    return magnetic_sources.stops(session, subject, session_id, sensor)


@router.post("/sessions/{session_id}/source-calibration", status_code=201)
def calibrate_source(
    session_id: str, wanted: SourceCalibrationIn, request: Request, subject: CurrentAccount
) -> MagneticSourceOut:
    """Find the coils of a source from a session in which the sensor was laid at measured places, and keep them."""
    return magnetic_sources.calibrate(services_of(request).engine, subject, session_id, wanted)
