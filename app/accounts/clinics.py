"""The clinic itself: its name, and the time zone in which its weeks begin."""

from sqlalchemy.orm import Session

from app.accounts import audit
from app.accounts.models import Clinic
from app.accounts.schemas import ClinicOut, ClinicPatch
from app.accounts.subject import Subject
from app.errors import InvalidInput, NotAllowed
from app.time_zones import is_time_zone
from estimators.sentences import say


def read_clinic(session: Session, subject: Subject, default_zone: str) -> ClinicOut:
    """Return the subject's clinic.

    Parameters
    ----------
    default_zone : str
        Setting `time_zone`, in force while the clinic has not set its own.
    """
    return _out(session.get_one(Clinic, subject.clinic_id), default_zone)


def change_clinic(session: Session, subject: Subject, body: ClinicPatch, default_zone: str) -> ClinicOut:
    """Set the time zone of the subject's clinic.

    Parameters
    ----------
    session : Session
        Writing.
    subject : Subject
        An administrator.
    default_zone : str
        Setting `time_zone`.

    Raises
    ------
    NotAllowed
        Not an administrator.
    InvalidInput
        There is no such time zone.
    """
    if subject.role != "administrator":
        raise NotAllowed(say("clinic.change_not_allowed"))
    if not is_time_zone(body.time_zone):
        raise InvalidInput(say("clinic.no_such_zone"), field="time_zone")
    clinic = session.get_one(Clinic, subject.clinic_id)
    if clinic.time_zone != body.time_zone:
        before, clinic.time_zone = clinic.time_zone, body.time_zone
        details = {"from": before, "to": body.time_zone}
        audit.record(session, subject, "clinic.time_zone", None, clinic.id, details)
    return _out(clinic, default_zone)


def _out(clinic: Clinic, default_zone: str) -> ClinicOut:
    return ClinicOut(
        name=clinic.name,
        time_zone=clinic.time_zone or default_zone,
        is_time_zone_set=clinic.time_zone is not None,
    )
