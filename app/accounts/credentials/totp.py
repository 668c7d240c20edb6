"""Codes of an authenticator program: time-based one-time passwords (RFC 6238, SHA-1, 30 s, six digits)."""

import base64
import hashlib
import hmac
import secrets
import struct
from urllib.parse import quote

STEP_S = 30
DIGITS = 6


def new_secret() -> str:
    """Return 160 random bits in base32, as authenticator programs take them."""
    return base64.b32encode(secrets.token_bytes(20)).decode()


def code_at(secret: str, step: int) -> str:
    """Return the code of a step (RFC 4226, section 5.3).

    Parameters
    ----------
    secret : str
        Base32.
    step : int
        Seconds since 1970 divided by 30.
    """
    digest = hmac.new(base64.b32decode(secret), struct.pack(">Q", step), hashlib.sha1).digest()
    offset = digest[-1] & 15
    number = struct.unpack(">I", digest[offset : offset + 4])[0] & 0x7FFFFFFF
    return f"{number % 10**DIGITS:0{DIGITS}d}"


def step_of(secret: str, code: str, at_s: float) -> int | None:
    """Return the step that a code belongs to, the present one or a neighbour (clocks differ); None when it is wrong.

    Parameters
    ----------
    secret : str
        Base32.
    code : str
        As typed; spaces do not matter.
    at_s : float
        Seconds since 1970.
    """
    typed = "".join(code.split())
    present = int(at_s) // STEP_S
    for step in (present, present - 1, present + 1):
        if hmac.compare_digest(code_at(secret, step).encode(), typed.encode()):
            return step
    return None


def uri(secret: str, email: str) -> str:
    """Return what a QR code for authenticator programs holds.

    Parameters
    ----------
    secret : str
        Base32.
    """
    label = quote(f"Telemotion:{email}")
    return f"otpauth://totp/{label}?secret={secret}&issuer=Telemotion&digits={DIGITS}&period={STEP_S}"
