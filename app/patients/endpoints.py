"""Patients, grants, device tokens, consents and the audit trail.

Errors of every route: `not_found` for a patient out of reach (existing or not), `not_allowed` when the right
does not cover the request, `invalid_input` with the fields.
"""

from fastapi import APIRouter, Request

from app.accounts.dependencies import CurrentAccount
from app.accounts.pairing import Offer, PairingBook
from app.accounts.schemas import (
    AuditOut,
    ConsentIn,
    ConsentOut,
    DeviceTokenIn,
    DeviceTokenOut,
    GrantIn,
    GrantOut,
    PairingCodeOut,
    PairingIn,
)
from app.database.dependencies import ReadSession, WriteSession
from app.pages import WantedPage
from app.patients import devices, service
from app.patients.repository import revoke_grant
from app.patients.schemas import NewPatientIn, PatientOut, PatientPatch
from app.services import services_of

router = APIRouter(prefix="/api", tags=["patients"])


@router.get("/patients")
def list_patients(
    subject: CurrentAccount, session: ReadSession, page: WantedPage, archived: bool | None = None
) -> list[PatientOut]:
    """Return the patients in reach, all or by whether they are archived; patients get their own record only."""
    return service.list_patients(session, subject, page, archived)


@router.post("/patients", status_code=201)
def create_patient(body: NewPatientIn, subject: CurrentAccount, session: WriteSession) -> PatientOut:
    """Create a patient; the therapist who does gets the right to treat."""
    return service.create_patient(session, subject, body)


@router.get("/patients/{patient_id}")
def read_patient(patient_id: str, subject: CurrentAccount, session: ReadSession) -> PatientOut:
    """Return a patient."""
    return service.get_patient(session, subject, patient_id)


@router.patch("/patients/{patient_id}")
def update_patient(
    patient_id: str, body: PatientPatch, subject: CurrentAccount, session: WriteSession
) -> PatientOut:
    """Change the fields that the body names."""
    return service.update_patient(session, subject, patient_id, body)


@router.get("/patients/{patient_id}/grants")
def list_grants(patient_id: str, subject: CurrentAccount, session: ReadSession) -> list[GrantOut]:
    """Return who may see this patient's data."""
    return service.list_grants(session, subject, patient_id)


@router.post("/patients/{patient_id}/grants", status_code=201)
def create_grant(patient_id: str, body: GrantIn, subject: CurrentAccount, session: WriteSession) -> GrantOut:
    """Give a colleague a right to this patient; an earlier one of the same colleague ends."""
    return service.create_grant(session, subject, patient_id, body)


@router.delete("/grants/{grant_id}", status_code=204)
def delete_grant(grant_id: str, subject: CurrentAccount, session: WriteSession) -> None:
    """End a right now."""
    revoke_grant(session, subject, grant_id)


@router.get("/patients/{patient_id}/audit")
def read_audit(
    patient_id: str, subject: CurrentAccount, session: ReadSession, page: WantedPage
) -> list[AuditOut]:
    """Return who did what with this patient's data, newest first."""
    return service.patient_audit(session, subject, patient_id, page)


@router.get("/patients/{patient_id}/device-tokens")
def list_device_tokens(
    patient_id: str, subject: CurrentAccount, session: ReadSession, page: WantedPage
) -> list[DeviceTokenOut]:
    """Return this patient's device tokens, newest first, without their secrets."""
    return devices.device_tokens(session, subject, patient_id, page)


@router.post("/patients/{patient_id}/device-tokens", status_code=201)
def create_device_token(
    patient_id: str, body: DeviceTokenIn, subject: CurrentAccount, request: Request, session: WriteSession
) -> DeviceTokenOut:
    """Make a device token; the answer is the only one that holds it."""
    return devices.add_device_token(session, services_of(request).settings, subject, patient_id, body)


@router.post("/patients/{patient_id}/pairing-codes", status_code=201)
def create_pairing_code(
    patient_id: str, body: DeviceTokenIn, subject: CurrentAccount, request: Request, session: WriteSession
) -> PairingCodeOut:
    """Make a code of eight characters that a gateway exchanges, once and within ten minutes, for a device token."""
    return devices.offer_pairing(
        session, services_of(request).get(PairingBook), Offer(subject, patient_id, body)
    )


@router.post("/devices/pair", responses={401: {}})
def pair_device(body: PairingIn, request: Request, session: WriteSession) -> DeviceTokenOut:
    """Exchange a pairing code for a device token; nobody need be signed in.

    Errors: `sign_in_required` for a code that is wrong, used or too old; `too_many_attempts` with Retry-After.
    """
    services = services_of(request)
    address = request.client.host if request.client else "unknown"
    offer = services.get(PairingBook).take(session, body.code, address)
    return devices.pair(session, services.settings, offer)


@router.delete("/device-tokens/{token_id}", status_code=204)
def delete_device_token(token_id: str, subject: CurrentAccount, session: WriteSession) -> None:
    """Revoke a device token now."""
    devices.revoke_device_token(session, subject, token_id)


@router.get("/patients/{patient_id}/consents")
def read_consents(patient_id: str, subject: CurrentAccount, session: ReadSession) -> list[ConsentOut]:
    """Return what the patient agreed to; a purpose that is absent was never asked."""
    return service.consents(session, subject, patient_id)


@router.put("/patients/{patient_id}/consents")
def write_consent(
    patient_id: str, body: ConsentIn, subject: CurrentAccount, session: WriteSession
) -> list[ConsentOut]:
    """Store the patient's answer for one purpose."""
    return service.put_consent(session, subject, patient_id, body)
