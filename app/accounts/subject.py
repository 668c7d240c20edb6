"""The acting subject: who asks. Every repository call that touches patient data takes one."""

from dataclasses import dataclass, field
from typing import Literal

SubjectKind = Literal["account", "device", "system"]
SubjectRole = Literal["administrator", "therapist", "patient", "integrator", "device", "system"]


@dataclass(frozen=True)
class Subject:
    """Who acts.

    Attributes
    ----------
    kind : {"account", "device", "system"}
        A person or integrator that signed in, a gateway with a device token, or the service itself finishing
        work that somebody with the right asked for.
    id : str
        Account, device token, or a fixed word for the service; written to the audit trail.
    account_id : str or None
        The account, where there is one.
    clinic_id : str
        The tenant; nothing outside it exists for this subject.
    role : str
        The role of the account, or `device` or `system`.
    patient_id : str or None
        The patient's own record, or the one patient a device is bound to.
    sign_in_id : str or None
        The browser session by which an account asks; what stays open ends with it. The same account by another one is
        the same subject.
    """

    kind: SubjectKind
    id: str
    account_id: str | None
    clinic_id: str
    role: SubjectRole
    patient_id: str | None
    sign_in_id: str | None = field(default=None, compare=False)

    @classmethod
    def system(cls, clinic_id: str) -> "Subject":
        """Return the service itself, acting inside one clinic.

        Parameters
        ----------
        clinic_id : str
            The clinic of the session or job that is being worked on.
        """
        return cls("system", "service", None, clinic_id, "system", None)
