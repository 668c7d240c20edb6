"""HTTP of what is drawn together about a patient: the caseload, progress, prescriptions with what was done, and
taking it all along or erasing it.

The paths are those of patients; the code is here because it reads recordings and comparisons, which the room
`patients` does not know.
"""

from fastapi import APIRouter, Request
from fastapi.responses import StreamingResponse

from app.accounts.dependencies import CurrentAccount
from app.assessment import practice
from app.assessment.caseload import caseload
from app.assessment.design import prescribing
from app.assessment.exports.patient import export
from app.assessment.progress import progress
from app.assessment.records.erasure import erase
from app.assessment.schemas import CaseloadRow, Progress
from app.database.dependencies import ReadSession, WriteSession
from app.exercises.schemas import PrescriptionChangeIn, PrescriptionIn, PrescriptionOut
from app.pages import WantedPage
from app.patients.schemas import ErasureIn
from app.services import services_of

router = APIRouter(prefix="/api")


@router.get("/caseload", tags=["patients"])
def read_caseload(
    subject: CurrentAccount, session: ReadSession, request: Request, page: WantedPage
) -> list[CaseloadRow]:
    """Return one line per patient in reach, those with a reason to look first."""
    return caseload(session, subject, services_of(request).settings.time_zone, page)


@router.get("/patients/{patient_id}/progress", tags=["patients"])
def read_progress(
    patient_id: str,
    subject: CurrentAccount,
    session: ReadSession,
    request: Request,
    exercise_id: str | None = None,
    until: str | None = None,
) -> Progress:
    """Return progress in one exercise; without `exercise_id` in the one practised last.

    With `until`, a session, as it was known with that one.
    """
    zone = services_of(request).settings.time_zone
    return progress(session, subject, patient_id, exercise_id, zone, until)


@router.get("/patients/{patient_id}/prescriptions", tags=["exercises"])
def list_prescriptions(
    patient_id: str, subject: CurrentAccount, session: ReadSession, request: Request
) -> list[PrescriptionOut]:
    """Return what is prescribed now or soon, with what was done of it this week (from Monday by the clinic's clocks).

    A session counts when something valid was done in it, and for one prescription only.
    """
    return practice.list_prescriptions(session, subject, patient_id, services_of(request).settings.time_zone)


@router.post("/patients/{patient_id}/prescriptions", status_code=201, tags=["exercises"])
def create_prescription(
    patient_id: str, body: PrescriptionIn, subject: CurrentAccount, session: WriteSession, request: Request
) -> PrescriptionOut:
    """Prescribe an exercise; `is_twice` says that it is prescribed already."""
    return prescribing.prescribe(session, subject, patient_id, body, services_of(request).settings.time_zone)


@router.patch("/prescriptions/{prescription_id}", tags=["exercises"])
def change_prescription(
    prescription_id: str,
    body: PrescriptionChangeIn,
    subject: CurrentAccount,
    session: WriteSession,
    request: Request,
) -> PrescriptionOut:
    """Change dose, times, template or limits of a prescription; `changes` say what it was, who changed it and when.

    Errors: `conflict` when somebody changed it since it was read, with who and when.
    """
    return prescribing.change(
        session, subject, prescription_id, body, services_of(request).settings.time_zone
    )


@router.get(
    "/patients/{patient_id}/export",
    tags=["patients"],
    response_class=StreamingResponse,
    responses={429: {}},
)
def export_patient(patient_id: str, subject: CurrentAccount, request: Request) -> StreamingResponse:
    """Return everything held about a patient as one archive: the record, sessions, packets, movement, comparisons.

    The trail notes it as one event, `patient.export`. Errors: `limit_reached` or `unavailable` with Retry-After while
    too many exports are being made.
    """
    services = services_of(request)
    return StreamingResponse(
        export(services.engine, services.settings, services.limits, subject, patient_id),
        media_type="application/zip",
        headers={
            "Content-Disposition": f'attachment; filename="patient-{patient_id[:8]}.zip"',
            "Cache-Control": "no-store",
        },
    )


@router.delete("/patients/{patient_id}", status_code=204, tags=["patients"])
def erase_patient(patient_id: str, body: ErasureIn, subject: CurrentAccount, request: Request) -> None:
    """Erase an archived patient for good, with signals, results, comparisons and accounts; administrators only.

    The audit trail keeps that it happened. Errors: `conflict` when the patient is not archived, streams, or a
    recording is being analysed.
    """
    services = services_of(request)
    erase(services.engine, services.settings, subject, patient_id)
