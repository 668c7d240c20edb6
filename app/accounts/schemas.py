"""Wire types of sign-in, grants, devices, consent and audit."""

from datetime import datetime
from typing import Any, Literal

from pydantic import Field

from app.schemas import Flag, Moment, Schema

Role = Literal["administrator", "therapist", "patient", "integrator"]


class SignInRequest(Schema):
    """E-mail and password."""

    email: str = Field(max_length=254)
    password: str = Field(max_length=200)
    code: str | None = Field(default=None, max_length=40)
    """Of the authenticator app, or a recovery code; only for accounts with a second factor."""


Locale = Literal["", "en", "de"]
"""Languages of the client; empty while none is chosen and the browser's own holds."""


class Me(Schema):
    """Who is signed in; the CSRF token goes back in `X-CSRF-Token` with every change."""

    account_id: str
    display_name: str
    email: str
    role: Role
    clinic_id: str
    clinic_name: str
    patient_id: str | None
    locale: str
    """Language chosen for the account; empty while the browser's own holds."""
    csrf_token: str
    must: Literal["password", "second_factor"] | None = None
    """What has to be done before anything else is answered: change the password, or set up the second factor."""
    second_factor_removed_at: datetime | None = None
    """When an administrator turned two-step sign-in off; until the person has read it or set it up again."""
    second_factor_since: datetime | None = None
    """Since when an authenticator app is asked for: every browser of the person says so for some weeks."""
    store_key: str
    """Seals what this account leaves unsent in a browser, base64 of 32 bytes; forgotten with the sign-in, and the same
    at the next."""
    idle_minutes: int
    """The browser session ends after so long without use."""


class MePatch(Schema):
    """What people may change of their own account."""

    locale: Locale


class SecondFactorOut(Schema):
    """Whether an authenticator app is asked for at sign-in."""

    is_on: bool
    since: datetime | None
    recovery_codes_left: int


class SecondFactorSetup(Schema):
    """What an authenticator app needs; shown once."""

    secret: str
    uri: str
    """For a QR code."""


class SecondFactorConfirm(Schema):
    """A code of the app: proof that it has the secret."""

    code: str = Field(max_length=40)


class OwnPassword(Schema):
    """The own password, for what an open browser alone must not do."""

    password: str = Field(max_length=200)


class RecoveryCodes(Schema):
    """Each good once, in place of the app's code; shown this once."""

    codes: list[str]


class ClinicOut(Schema):
    """The clinic of who asks."""

    name: str
    time_zone: str
    """IANA name; weeks begin on Monday 00:00 there."""
    is_time_zone_set: bool
    """False while the service's setting stands in."""


class ClinicPatch(Schema):
    """What an administrator may change of the clinic."""

    time_zone: str = Field(max_length=64)
    """IANA name, for instance Europe/Oslo."""


class AccountOut(Schema):
    """An account as a colleague sees it."""

    id: str
    display_name: str
    email: str
    role: Role
    is_active: bool
    has_second_factor: bool | None = None
    """Whether a code is asked for at sign-in; only administrators see it."""


class AccountIn(Schema):
    """A new account; administrators only."""

    email: str = Field(max_length=254)
    display_name: str = Field(max_length=200)
    role: Role
    password: str = Field(min_length=10, max_length=200)
    patient_id: str | None = None


class AccountPatch(Schema):
    """Only the fields to change; administrators only."""

    display_name: str | None = Field(default=None, min_length=1, max_length=200)
    is_active: Flag | None = None
    """False switches the account off: it is signed out everywhere and cannot sign in."""
    password: str | None = Field(default=None, min_length=10, max_length=200)
    """For somebody who forgot theirs; they must change it when they sign in."""
    remove_second_factor: bool = False
    """For somebody who lost the telephone and the recovery codes."""


class PasswordIn(Schema):
    """Change the own password."""

    old_password: str = Field(max_length=200)
    new_password: str = Field(min_length=10, max_length=200)


class GrantIn(Schema):
    """Give a colleague a right to one patient."""

    account_id: str
    level: Literal["read", "treat"] = "treat"
    expires_at: Moment | None = None


class GrantOut(Schema):
    """A right to one patient."""

    id: str
    account_id: str
    display_name: str
    level: Literal["read", "treat"]
    expires_at: datetime | None
    created_at: datetime


class DeviceTokenIn(Schema):
    """A new gateway credential."""

    label: str = Field(max_length=100)
    days: int = Field(default=90, ge=1, le=366)


class PairingCodeOut(Schema):
    """A code that a gateway exchanges once for a device token; it is shown once."""

    code: str
    expires_at: datetime


class PairingIn(Schema):
    """A gateway's pairing code, as somebody typed or scanned it."""

    code: str = Field(max_length=40)


class DeviceTokenOut(Schema):
    """A gateway credential; `token` is shown once, when it is made."""

    id: str
    label: str
    created_at: datetime
    expires_at: datetime
    revoked_at: datetime | None
    token: str | None = None


class ConsentIn(Schema):
    """Yes or no to one purpose."""

    purpose: Literal["treatment", "research", "home_streaming"]
    granted: Flag


class ConsentOut(ConsentIn):
    """What the patient said, and when."""

    changed_at: datetime


class AuditOut(Schema):
    """Who did what with a patient's data."""

    at: datetime
    who: str
    role: str
    action: str
    resource_id: str | None
    details: dict[str, Any]


class TicketIn(Schema):
    """What the socket is for."""

    purpose: Literal["ingest", "live"]


class TicketOut(Schema):
    """A one-use right to open one socket within 30 seconds; it goes in the first message, never in a URL."""

    ticket: str
    expires_at: datetime
    path: str
