"""Random tokens and what is stored of them.

Session cookies and tickets are 256 random bits; only their SHA-256 is stored. A slow hash would add nothing:
there is no dictionary of random tokens to try.
"""

import hashlib
import secrets


def new_token() -> str:
    """Return 256 random bits, safe in URLs and headers."""
    return secrets.token_urlsafe(32)


def hash_token(token: str) -> str:
    """Return what is stored of a token: SHA-256 in hexadecimal."""
    return hashlib.sha256(token.encode()).hexdigest()
