"""Sentences of the service for people: the catalogue of the library, which has those of the service too."""

from estimators.sentences import CATALOGUE, Sentence, say

__all__ = ["CATALOGUE", "Sentence", "say"]
