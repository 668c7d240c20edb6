"""English words of the library, by room. A code begins with its room, or with the kind of names it is one of."""

from typing import Final

from estimators.sentences.english import (
    calibration,
    comparison,
    compass,
    guidance,
    names,
    optical,
    readings,
    sessions,
    walking,
)

ROOMS: Final = (names, calibration, compass, readings, comparison, walking, optical, sessions, guidance)
ENGLISH: Final[dict[str, str | dict[str, str]]] = {
    code: words for room in ROOMS for code, words in room.ENGLISH.items()
}

__all__ = ["ENGLISH", "ROOMS"]
