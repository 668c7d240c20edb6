"""Sentences for people: a stable code with named parameters, its words written once in `messages`.

A `Sentence` is a `str`, so it goes wherever a message goes; whoever can translate reads its code and parameters.
"""

from estimators.sentences._catalogue import Catalogue
from estimators.sentences._sentence import Sentence, for_json
from messages import messages_in

CATALOGUE = Catalogue(messages_in("en"))
say = CATALOGUE.say

__all__ = ["CATALOGUE", "Catalogue", "Sentence", "for_json", "say"]
