"""Names of what stands in registers of the library: by them the client says labels in another language."""

from collections.abc import Iterator
from typing import Final

from estimators.measures import MEASURES


def _names() -> Iterator[tuple[str, str]]:
    for one in MEASURES:
        kind = {"repetition": "repetition", "asymmetry": "uneven"}.get(one.part, "walk")
        if one.label:
            yield f"measure_name.{kind}.{one.name.removesuffix(':')}", one.label


ENGLISH: Final[dict[str, str | dict[str, str]]] = dict(_names())
