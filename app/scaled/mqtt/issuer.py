"""Signs who may connect, in the form that NATS reads: JWT with Ed25519, see `app.scaled.credentials`."""

import base64
import json
import time
from hashlib import sha256
from typing import Any

from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey

from app.scaled.credentials import Kind, public_text


class Issuer:
    """Whoever the NATS servers believe about gateways.

    Parameters
    ----------
    seed : bytes, shape (32,)
        The same in all edges, and a secret.
    kind : Kind
        An account signs for users, an operator for accounts.
    """

    def __init__(self, seed: bytes, kind: Kind = Kind.ACCOUNT) -> None:
        self._key = Ed25519PrivateKey.from_private_bytes(seed)
        self.public = public_text(kind, self._key)
        """What the configuration of the servers names."""

    def sign(self, claims: dict[str, Any]) -> str:
        """Return a JWT of the claims, with issuer, time and number.

        Parameters
        ----------
        claims : dict
            JSON.
        """
        named = claims | {"iss": self.public, "iat": int(time.time())}
        named["jti"] = sha256(json.dumps(named, sort_keys=True).encode()).hexdigest()
        parts = [_encoded({"typ": "JWT", "alg": "ed25519-nkey"}), _encoded(named)]
        signature = self._key.sign(".".join(parts).encode())
        return ".".join([*parts, _text(signature)])


def claims_of(token: bytes) -> dict[str, Any]:
    """Return the claims of a JWT that came from the server itself; its signature proves nothing more.

    Raises
    ------
    ValueError
        It is none.
    """
    parts = token.split(b".")
    if len(parts) != 3:
        raise ValueError("no JWT")
    claims = json.loads(base64.urlsafe_b64decode(parts[1] + b"=" * (-len(parts[1]) % 4)))
    if not isinstance(claims, dict):
        raise ValueError("no claims")
    return claims


def _encoded(content: dict[str, Any]) -> str:
    return _text(json.dumps(content).encode())


def _text(data: bytes) -> str:
    return base64.urlsafe_b64encode(data).rstrip(b"=").decode()
