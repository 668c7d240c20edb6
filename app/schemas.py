"""Base of the wire types: strict names, no unknown fields."""

from datetime import date, datetime
from typing import Annotated, Any

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, StrictBool


class Schema(BaseModel):
    """A message to or from a client; unknown fields are refused so a typing error is seen."""

    model_config = ConfigDict(extra="forbid", from_attributes=True)


def may_be_absent(**limits: Any) -> Any:
    """Return a field of a change that may be left out, but not cleared with null.

    Parameters
    ----------
    limits
        As of `pydantic.Field`.
    """
    return Field(default=None, json_schema_extra=_without_default, **limits)


def _without_default(schema: dict[str, Any]) -> None:
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
