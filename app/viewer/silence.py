"""Why a live view has nothing new to show: the sensors are blamed only where no packet of theirs arrives."""

from typing import Final

from app.live.messages import HealthMessage, StateMessage
from app.schemas import SessionState
from estimators.sentences import Sentence, say

NO_DATA: Final = say("viewer.silent")
NO_PICTURE: Final = say("viewer.no_picture")


class SilenceWatch:
    """Hears what the service says of a session, and tells why no frames come.

    The number of packets stands in the health message of each second. Packets that came before the newest frame say
    nothing of now, so two messages after it are compared.
    """

    def __init__(self) -> None:
        self._state: SessionState | None = None
        self._counts: list[int] = []

    def hear(self, message: object) -> None:
        """Take a message of the session."""
        if isinstance(message, StateMessage):
            self._state = message.state
        elif isinstance(message, HealthMessage):
            self._counts = [*self._counts[-1:], message.packets_received]

    def frames_came(self) -> None:
        """Forget how many packets there were: what is shown is of now."""
        self._counts = []

    @property
    def words(self) -> Sentence | None:
        """What to say while no frames come; None while nobody knows why, and where the session has ended."""
        if self._state == "failed":
            return NO_PICTURE
        if self._state in {"closing", "analysed"}:
            return None
        if len(self._counts) > 1:
            return NO_DATA if self._counts[0] == self._counts[1] else NO_PICTURE
        return NO_DATA if self._state == "link_lost" else None
