"""The few words that stand in the picture itself, in the language of the page around it."""

from collections.abc import Callable
from typing import Final

from app.recordings.schemas import ViewLanguage
from estimators.sentences import CATALOGUE, Catalogue, Sentence
from messages import messages_in

Words = Callable[[Sentence], str]

_CATALOGUES: Final = {"en": CATALOGUE, "de": Catalogue(messages_in("de"))}


def words_in(language: ViewLanguage) -> Words:
    """Return what makes plain text of a sentence: viser's wire refuses what is only like text."""
    catalogue = _CATALOGUES[language]

    def words(sentence: Sentence) -> str:
        return str(catalogue.say(sentence.code, **sentence.parameters))

    return words


in_english: Final = words_in("en")
