"""A text column that remembers the code and the parameters of a sentence."""

import json

from sqlalchemy import String
from sqlalchemy.engine import Dialect
from sqlalchemy.types import TypeDecorator

from estimators.sentences import CATALOGUE, Sentence

_MARK = '{"code": '
LONGEST_PLAIN = 500


class Words(TypeDecorator[str]):
    """Words for people: a `Sentence` is stored as JSON and comes back as one, with the words of today's catalogue.

    Plain text (all rows of older versions, notes of people) stays plain text, cut after 500 characters.
    """

    impl = String
    cache_ok = True

    def process_bind_param(self, value: str | None, dialect: Dialect) -> str | None:
        """Store code, parameters and today's words."""
        if isinstance(value, Sentence):
            return json.dumps(value.to_dict())
        if value is not None and value.startswith(_MARK):
            # A person's note must not come back as our words.
            return " " + value[: LONGEST_PLAIN - 1]
        return None if value is None else value[:LONGEST_PLAIN]

    def process_result_value(self, value: str | None, dialect: Dialect) -> str | None:
        """Return the sentence again; the words of its time when its code is gone."""
        if value is None or not value.startswith(_MARK):
            return value
        text: str = CATALOGUE.restored(json.loads(value))
        return text
