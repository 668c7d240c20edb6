"""Sentences of the time line about a guided session."""

from typing import Final

from app.live.guidance.messages import GuidanceCause
from estimators.sentences import Sentence, say

HELD: Final[dict[GuidanceCause, Sentence]] = {
    "pain": say("guided.pain"),
    "limit": say("guided.limit"),
    "valid_count": say("guided.valid_count"),
    "set": say("guided.set"),
    "attempt_count": say("guided.attempt_count"),
    "time": say("guided.time"),
    "lost": say("guided.lost"),
    "unsure": say("guided.unsure"),
    "wrong_in_a_row": say("guided.wrong_in_a_row"),
}
"""Why it was paused or stopped, but for the person's own pause and end."""
PAUSED: Final = say("guided.paused")
STOPPED: Final = say("guided.stopped")
RESUMED: Final = say("guided.resumed")


def counted(kind: str, number: int) -> Sentence:
    """Return what is said of a finished repetition: `valid`, `partial` or `wrong`."""
    if kind == "valid":
        return say("guided.valid", number=number)
    if kind == "partial":
        return say("guided.partial", number=number)
    return say("guided.wrong", number=number)
