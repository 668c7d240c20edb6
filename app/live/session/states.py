"""The states of a session and which may follow which.

::

    created --hello--> calibrating --pose--> ready <--stop/record--> recording
       |  (walks: to ready)                    any of the three <----> link_lost
       +--(upload)--> closing ----------------------------------------> analysed
                      (from every open state, and from failed: what is stored can still be analysed)
    every state but analysed --> failed
"""

from typing import Final

from app.errors import Conflict
from app.schemas import SessionState
from estimators.sentences import say

TRANSITIONS: Final[dict[SessionState, frozenset[SessionState]]] = {
    "created": frozenset({"calibrating", "ready", "closing", "failed"}),
    "calibrating": frozenset({"ready", "link_lost", "closing", "failed"}),
    "ready": frozenset({"calibrating", "recording", "link_lost", "closing", "failed"}),
    "recording": frozenset({"ready", "link_lost", "closing", "failed"}),
    "link_lost": frozenset({"calibrating", "ready", "recording", "closing", "failed"}),
    "closing": frozenset({"analysed", "failed"}),
    "analysed": frozenset({"closing"}),
    "failed": frozenset({"closing"}),
}

STREAMING: Final[frozenset[SessionState]] = frozenset({"calibrating", "ready", "recording"})
"""States in which packets are expected; a broken link is reported."""
OPEN: Final[frozenset[SessionState]] = STREAMING | {"created", "link_lost", "failed"}
"""States in which packets are taken."""


class StateMachine:
    """The present state of one session; refuses what may not follow.

    Parameters
    ----------
    state : SessionState
        As stored.
    """

    def __init__(self, state: SessionState = "created", reason: str = "") -> None:
        self.state: SessionState = state
        self.reason = reason

    def may(self, following: SessionState) -> bool:
        """Whether the state may follow the present one."""
        return following in TRANSITIONS[self.state]

    def to(self, following: SessionState, reason: str = "") -> bool:
        """Change the state; True when it is another one.

        Raises
        ------
        Conflict
            The state may not follow the present one.
        """
        if following == self.state:
            self.reason = reason or self.reason
            return False
        if not self.may(following):
            raise Conflict(
                say("live.state", state=self.state, following=following),
                state=self.state,
                wanted=following,
            )
        self.state, self.reason = following, reason
        return True


def streaming_state(*, is_calibrated: bool, is_recording: bool) -> SessionState:
    """Return the state of a session whose packets come, from what is stored about it."""
    if is_recording:
        return "recording"
    return "ready" if is_calibrated else "calibrating"
