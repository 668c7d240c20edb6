"""Sentences for people: a stable code with named parameters, its English words written once in a catalogue.

A `Sentence` is a `str`, so it goes wherever a message goes; whoever can translate reads its code and parameters.
"""

from estimators.sentences._catalogue import Catalogue, Entry
from estimators.sentences._sentence import Sentence, for_json
from estimators.sentences.english import ENGLISH

CATALOGUE = Catalogue(ENGLISH)
say = CATALOGUE.say

__all__ = ["CATALOGUE", "ENGLISH", "Catalogue", "Entry", "Sentence", "for_json", "say"]
