"""The error tree of the service; one handler in `app.main` turns it into a response.

::

    TelemotionError                500  internal
    ├── NotFound                   404  also for what the subject may not know exists
    │   └── NoOpenSession          nobody has begun a session that a gateway could join
    ├── NotAllowed                 403
    │   ├── PasswordChangeRequired   an administrator knows the present one
    │   └── SecondFactorRequired     the staff of this service must have one
    ├── SignInRequired             401
    │   └── CodeRequired             the password was right, the account has a second factor
    ├── TooManyAttempts            429  with Retry-After
    ├── LimitReached               429  an account or clinic uses as much as it may at once; with Retry-After
    ├── Conflict                   409  wrong state, or already there
    │   └── SafetyUnconfirmed      a magnetic source, and nobody has said that it is safe
    ├── InvalidInput               422  with the field and what to do
    │   ├── PacketError            the wire format; see app.network.packet
    │   ├── RecordingFormatError   an uploaded file that cannot be read as declared
    │   │   └── ImplausibleReadings  it can be read, but its values cannot be right; may be accepted as they are
    │   └── CalibrationFailed      with the reason and what to redo
    ├── TooLarge                   413
    │   └── QuotaReached           a clinic has stored as much as it may
    └── Unavailable                503  with Retry-After
"""

from typing import Any, ClassVar

from estimators.sentences import Sentence


class TelemotionError(Exception):
    """Base of all expected failures.

    Parameters
    ----------
    message : Sentence or str
        What was wrong and what to do, without patient data. A sentence (`say` of `estimators.sentences`) where people
        read it, so that it can be translated; plain text on the command line.
    details : dict, optional
        Machine-readable facts: field names, limits, positions.
    """

    status: ClassVar[int] = 500
    code: ClassVar[str] = "internal"

    def __init__(self, message: str, **details: Any) -> None:
        super().__init__(message)
        self.message = message
        self.details = details

    @property
    def sentence(self) -> Sentence | None:
        """Code and parameters of the message; None of plain text."""
        return self.message if isinstance(self.message, Sentence) else None


class NotFound(TelemotionError):
    """No such thing, or nothing that this subject may see."""

    status, code = 404, "not_found"


class NoOpenSession(NotFound):
    """A gateway asks which session to join, and there is none."""

    code = "no_open_session"


class NotAllowed(TelemotionError):
    """The subject is known and may see it, but may not do this."""

    status, code = 403, "not_allowed"


class SignInRequired(TelemotionError):
    """No valid session, ticket or token."""

    status, code = 401, "sign_in_required"


class CodeRequired(SignInRequired):
    """The password was right; the code of the second factor is missing."""

    code = "code_required"


class PasswordChangeRequired(NotAllowed):
    """An administrator knows the password; nothing else can be done before it is changed."""

    code = "password_change_required"


class SecondFactorRequired(NotAllowed):
    """The staff must have a second factor; nothing else can be done before it is set up."""

    code = "second_factor_required"


class TooManyAttempts(TelemotionError):
    """Rate limit; `retry_after_s` in the details."""

    status, code = 429, "too_many_attempts"


class LimitReached(TelemotionError):
    """An account or clinic uses as much of something as it may at once; `retry_after_s` in the details."""

    status, code = 429, "limit_reached"


class Conflict(TelemotionError):
    """The thing is in another state than the request needs."""

    status, code = 409, "conflict"


class SafetyUnconfirmed(Conflict):
    """A session with a magnetic source was not confirmed to be safe for people with implants."""

    code = "safety_unconfirmed"


class InvalidInput(TelemotionError):
    """The request cannot be understood; the message says what to change."""

    status, code = 422, "invalid_input"


class PacketError(InvalidInput):
    """A body-network message that breaks the wire format; `reason` in the details is a fixed word."""

    code = "packet"


class RecordingFormatError(InvalidInput):
    """An uploaded file that cannot be read as what it was declared to be."""

    code = "recording_format"


class ImplausibleReadings(RecordingFormatError):
    """Values that cannot be right in the unit declared; who knows why may accept them (`--force`)."""

    code = "implausible_readings"


class CalibrationFailed(InvalidInput):
    """A calibration that cannot be used; the message says what to redo."""

    code = "calibration_failed"


class TooLarge(TelemotionError):
    """More than the configured limit."""

    status, code = 413, "too_large"


class QuotaReached(TooLarge):
    """A clinic has stored as much as it may."""

    code = "quota_reached"


class Unavailable(TelemotionError):
    """Busy or shutting down; try again."""

    status, code = 503, "unavailable"
