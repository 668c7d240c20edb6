"""Who a process is for NATS: keys as NATS writes them, and files of credentials.

A key is 32 bytes behind a byte that says whose it is, with a check sum, in base 32: a public one begins with O (an
operator's), A (an account's) or U (a user's), a private one with S and that letter. Such a file is read again for each
connection, because credentials that expire are replaced in it.
"""

import base64
import binascii
import re
from dataclasses import dataclass
from enum import IntEnum
from pathlib import Path
from typing import Final

from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey

from app.errors import InvalidInput
from estimators.sentences import say

_SEED: Final = 18 << 3
_MOST_BYTES: Final = 64 << 10


class Kind(IntEnum):
    """Whose a key is, as its first five bits."""

    ACCOUNT = 0
    OPERATOR = 14 << 3
    USER = 20 << 3


def public_text(kind: Kind, key: Ed25519PrivateKey) -> str:
    """Return the public key that belongs to a private one."""
    return _text(bytes([kind]) + key.public_key().public_bytes_raw())


@dataclass(frozen=True)
class Credentials:
    """What a file of credentials holds."""

    key: Ed25519PrivateKey
    token: str
    """JWT of the user; empty where the server knows the key itself."""

    @property
    def public(self) -> str:
        """The user's public key."""
        return public_text(Kind.USER, self.key)

    def sign(self, nonce: str) -> bytes:
        """Return the signature of what the server gave, in base 64."""
        return base64.b64encode(self.key.sign(nonce.encode()))


def read_credentials(path: Path) -> Credentials:
    """Read a `.creds` file (JWT and private key of a user) or one with the private key alone.

    Raises
    ------
    InvalidInput
        It cannot be read, or is no such file; its content is not in the message.
    """
    try:
        with path.open(encoding="ascii") as file:
            text = file.read(_MOST_BYTES)
        token, seed = _block(text, "USER JWT"), _block(text, "USER NKEY SEED")
        return Credentials(_user_key(seed or text.strip()), token)
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else str(error)
        if isinstance(error, UnicodeError):
            reason = "it is no text"
        raise InvalidInput(say("scaled.no_credentials", path=str(path), reason=reason)) from error


def _user_key(seed: str) -> Ed25519PrivateKey:
    """Return the private key of a user; raises `ValueError` for what is none."""
    try:
        raw = base64.b32decode(seed + "=" * (-len(seed) % 8))
    except binascii.Error as error:
        raise ValueError("a key is not written in base 32") from error
    data, check = raw[:-2], raw[-2:]
    if len(raw) != 36 or _check(data) != check:
        raise ValueError("the check sum of a key is wrong")
    if data[0] & 0xF8 != _SEED or (data[0] & 7) << 5 | data[1] >> 3 != Kind.USER:
        raise ValueError("a key is not the private one of a user")
    return Ed25519PrivateKey.from_private_bytes(data[2:])


def _block(text: str, title: str) -> str:
    found = re.search(rf"-+BEGIN (?:NATS )?{title}-+\s+(\S+)\s+-+END (?:NATS )?{title}-+", text)
    return "" if found is None else found[1]


def _text(data: bytes) -> str:
    return base64.b32encode(data + _check(data)).decode().rstrip("=")


def _check(data: bytes) -> bytes:
    """Return the check sum that NATS adds to its keys: the CRC of XMODEM."""
    return binascii.crc_hqx(data, 0).to_bytes(2, "little")
