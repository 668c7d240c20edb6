"""English sentences of exercises, prescriptions, templates and comparisons."""

from typing import Final

ENGLISH: Final[dict[str, str | dict[str, str]]] = {}

__all__ = ["ENGLISH"]
