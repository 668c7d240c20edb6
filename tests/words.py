"""All words of the service by language: its messages, and in English what classes and registers carry besides."""

from collections.abc import Mapping
from typing import Any, Final

from app.readers.registry import readers
from app.recordings.analysis.estimator_choice import estimators_out
from estimators.measures import MEASURES
from messages import messages_in

ENGLISH: Final = messages_in("en")
GERMAN: Final = messages_in("de")


def titles() -> dict[str, str]:
    """Return titles and descriptions of filters and file formats, and names of measures, by code."""
    named: dict[str, Mapping[str, Any]] = {
        "estimator": {one.name: one for one in estimators_out()},
        "format": readers(),
    }
    of_classes = {
        f"{register}_{part}.{name}": words
        for register, ones in named.items()
        for name, one in ones.items()
        for part, words in (("title", one.title), ("text", one.description))
    }
    kinds = {"repetition": "repetition", "asymmetry": "uneven"}
    of_measures = {
        f"measure_name.{kinds.get(one.part, 'walk')}.{one.name.removesuffix(':')}": one.label
        for one in MEASURES
        if one.label
    }
    return of_classes | of_measures
