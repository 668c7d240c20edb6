"""English sentences of live sessions and the 3D view."""

from typing import Final

ENGLISH: Final[dict[str, str | dict[str, str]]] = {}

__all__ = ["ENGLISH"]
