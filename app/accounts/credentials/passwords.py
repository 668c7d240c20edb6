"""Password hashing with argon2id, two at a time.

One hash takes tens of milliseconds of a core and 64 MiB of memory by design. A flood of sign-ins must not
take both cores from the live sessions, so hashing has its own limiter and a bounded queue; who comes later is
asked to try again.
"""

from anyio import CapacityLimiter, to_thread
from argon2 import PasswordHasher
from argon2.exceptions import InvalidHashError, VerificationError

from app.errors import Unavailable
from estimators.sentences import say

HASHING_THREADS = 2
MAXIMUM_WAITING = 40


class Passwords:
    """Hashes and verifies passwords.

    Parameters
    ----------
    hasher : PasswordHasher, optional
        The cost; by default the library's (RFC 9106 low-memory profile). Tests use a cheap one.
    """

    def __init__(self, hasher: PasswordHasher | None = None) -> None:
        self._hasher = hasher or PasswordHasher()
        self._limiter: CapacityLimiter | None = None
        # Verified in place of an unknown account's hash, so that both answers take the same time.
        self._nobody = self._hasher.hash("nobody has this password")

    def hash(self, password: str) -> str:
        """Return the argon2id hash; blocks for tens of milliseconds."""
        return self._hasher.hash(password)

    def verify(self, password_hash: str | None, password: str) -> bool:
        """Return whether the password fits; takes as long without a hash as with one.

        Parameters
        ----------
        password_hash : str or None
            None for an account that does not exist or cannot sign in with a password.
        """
        try:
            self._hasher.verify(password_hash or self._nobody, password)
        except (VerificationError, InvalidHashError):
            return False
        return password_hash is not None

    def needs_rehash(self, password_hash: str) -> bool:
        """Return whether the cost has been raised since this hash was made."""
        return self._hasher.check_needs_rehash(password_hash)

    async def verify_in_turn(self, password_hash: str | None, password: str) -> bool:
        """Verify in one of two threads.

        Raises
        ------
        Unavailable
            Too many are waiting already.
        """
        limiter = self._limiter = self._limiter or CapacityLimiter(HASHING_THREADS)
        if limiter.statistics().tasks_waiting >= MAXIMUM_WAITING:
            raise Unavailable(say("sign_in.busy"), retry_after_s=5)
        return await to_thread.run_sync(self.verify, password_hash, password, limiter=limiter)

    async def hash_in_turn(self, password: str) -> str:
        """Hash in one of two threads."""
        limiter = self._limiter = self._limiter or CapacityLimiter(HASHING_THREADS)
        return await to_thread.run_sync(self.hash, password, limiter=limiter)
