"""The words that the client must have in every language: sentences, and the titles that classes carry.

Apart from the catalogue, because it imports every estimator and every reader with their kernels.
"""

from typing import Any

from app.readers.registry import readers
from app.recordings.analysis.estimator_choice import estimators_out
from app.sentences import ENGLISH


def titles() -> dict[str, str]:
    """Return title and description of every estimator and file format, by code, as their classes have them."""
    named: dict[str, dict[str, Any]] = {
        "estimator": {one.name: one for one in estimators_out()},
        "format": dict(readers()),
    }
    return {
        f"{register}_{part}.{name}": words
        for register, ones in named.items()
        for name, one in ones.items()
        for part, words in (("title", one.title), ("text", one.description))
    }


def english() -> dict[str, Any]:
    """Return all of it in English, by code."""
    return {**ENGLISH, **titles()}
