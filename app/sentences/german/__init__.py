"""German words of the service and of the library, by room: every code of the English catalogue."""

from typing import Final

from app.sentences.german import (
    accounts,
    files,
    guides,
    live,
    mapping,
    packets,
    readings,
    recordings,
    shoes,
    stored,
    tasks,
    uploads,
    walking,
    wire,
)

ROOMS: Final = (
    accounts,
    files,
    guides,
    live,
    mapping,
    packets,
    readings,
    recordings,
    shoes,
    stored,
    tasks,
    uploads,
    walking,
    wire,
)
GERMAN: Final[dict[str, str | dict[str, str]]] = {
    code: words for room in ROOMS for code, words in room.GERMAN.items()
}

__all__ = ["GERMAN"]
