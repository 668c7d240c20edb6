"""Base of the wire types: strict names, no unknown fields."""

from pydantic import BaseModel, ConfigDict


class Schema(BaseModel):
    """A message to or from a client; unknown fields are refused so a typing error is seen."""

    model_config = ConfigDict(extra="forbid", from_attributes=True)
