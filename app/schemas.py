"""Base of the wire types: strict names, no unknown fields; and what their words for people say."""

import re
from collections.abc import Mapping
from datetime import date, datetime
from typing import Annotated, Any, Final, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, StrictBool, model_validator

from estimators.sentences import CATALOGUE, Sentence, for_json

SessionState = Literal[
    "created", "calibrating", "ready", "recording", "link_lost", "closing", "analysed", "failed"
]
"""Of a session, in the order in which it usually goes through them."""


_BROKEN: Final = re.compile("[\0\ud800-\udfff]")


class Schema(BaseModel):
    """A message to or from a client; unknown fields are refused so a typing error is seen."""

    model_config = ConfigDict(extra="forbid", from_attributes=True)

    @model_validator(mode="before")
    @classmethod
    def _refuse_broken_text(cls, data: Any) -> Any:
        """Refuse text that PostgreSQL cannot store, on every database."""
        if isinstance(data, dict):
            if not all(map(is_whole_text, data)):
                raise ValueError("names must not hold a NUL or half a character; remove it")
            for name, value in data.items():
                if not is_whole_text(value):
                    raise ValueError(f"{name}: text must not hold a NUL or half a character; remove it")
        return data


def is_whole_text(value: Any) -> bool:
    """Return whether no text in a value of JSON holds a NUL or a lone surrogate.

    Parameters
    ----------
    value : object
        Lists are taken to hold one kind of thing: one that begins with a number is not looked through.
    """
    if isinstance(value, str):
        return _BROKEN.search(value) is None
    if isinstance(value, dict):
        return all(is_whole_text(name) and is_whole_text(part) for name, part in value.items())
    if isinstance(value, list | tuple) and value and not isinstance(value[0], int | float):
        return all(is_whole_text(part) for part in value)
    return True


def may_be_absent(**limits: Any) -> Any:
    """Return a field of a change that may be left out, but not cleared with null.

    Parameters
    ----------
    limits
        As of `pydantic.Field`.
    """
    return Field(default=None, json_schema_extra=without_default, **limits)


def without_default(schema: dict[str, Any]) -> None:
    """Leave the default out of what clients read: absent is not null."""
    del schema["default"]


def _written(value: Any) -> Any:
    if isinstance(value, int | float):
        raise ValueError("write it as text, for instance 2026-11-22T09:30:00Z or 2026-11-22")
    return value


Moment = Annotated[datetime, BeforeValidator(_written)]
"""A moment in what clients send: ISO 8601 text. A bare number is refused, for it may be seconds or milliseconds."""

Day = Annotated[date, BeforeValidator(_written)]
"""A date in what clients send: ISO 8601 text."""

Flag = StrictBool
"""A yes or no in what clients send; 0 and "false" are refused."""

SessionTime = Annotated[float, Field(ge=0, le=1e7)]
"""Seconds since the beginning of a session, as clients ask for them; bounded, which leaves infinity out."""


class SentenceOut(Schema):
    """A sentence for people, for whoever says it in another language: see `messages/en.json`."""

    code: str
    """Stable name of the sentence."""
    params: dict[str, Any]
    """By name: numbers in SI units, strings, sentences of the same form, or lists of them."""
    text: str
    """In English."""


class Spoken(Schema):
    """A message with words for people: each text that is a `Sentence` also goes out as code and parameters."""

    sentences: dict[str, SentenceOut | list[SentenceOut | str]] = Field(default_factory=dict)
    """What the texts of this object say, by the name of their field; plain text has none."""

    @model_validator(mode="before")
    @classmethod
    def _remember(cls, given: Any) -> Any:
        is_mapping = isinstance(given, Mapping)
        names = [name for name in cls.model_fields if not is_mapping or name in given]
        values = {name: given[name] if is_mapping else getattr(given, name, None) for name in names}
        said = {name: for_json(value) for name, value in values.items() if _is_said(value)}
        if not said:
            return given
        return {**(given if is_mapping else values), "sentences": said}

    def said(self, name: str) -> str:
        """Return a text with the code that the field itself has lost, for telling it elsewhere.

        Parameters
        ----------
        name : str
            Of a field with one text; plain text comes back as it is.
        """
        sentence = self.sentences.get(name)
        text: str = (
            CATALOGUE.restored(sentence.model_dump())
            if isinstance(sentence, SentenceOut)
            else getattr(self, name)
        )
        return text


def _is_said(value: Any) -> bool:
    if isinstance(value, list | tuple):
        return bool(value) and isinstance(value[0], str) and any(isinstance(one, Sentence) for one in value)
    return isinstance(value, Sentence)
