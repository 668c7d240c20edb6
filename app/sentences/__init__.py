"""Sentences of the service for people: each is written once, here or in `estimators.sentences`, under its code.

Programs and logs read the English words; the client writes the same code and parameters in the language of the reader
(`web/src/i18n/sentence.ts`, from a catalogue that `npm run api` makes of this one).
"""

from typing import Final

from app.sentences import (
    accounts,
    clinical,
    files,
    foreign,
    general,
    guides,
    live,
    previews,
    recordings,
    registers,
    tables,
    tasks,
    wire,
)
from estimators import sentences as of_estimators
from estimators.sentences import Catalogue, Entry, Sentence

ENGLISH: Final[dict[str, Entry]] = {
    **of_estimators.ENGLISH,
    **general.ENGLISH,
    **accounts.ENGLISH,
    **clinical.ENGLISH,
    **recordings.ENGLISH,
    **files.ENGLISH,
    **foreign.ENGLISH,
    **tables.ENGLISH,
    **previews.ENGLISH,
    **guides.ENGLISH,
    **live.ENGLISH,
    **registers.ENGLISH,
    **tasks.ENGLISH,
    **wire.ENGLISH,
}
CATALOGUE: Final = Catalogue(ENGLISH)
say = CATALOGUE.say

__all__ = ["CATALOGUE", "ENGLISH", "Sentence", "say"]
