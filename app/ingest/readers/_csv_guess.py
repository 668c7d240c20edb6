"""A mapping guessed from the names of the columns; a person corrects it. The same rules as `web/src/lib/csv.ts`."""

import re
from pathlib import Path
from typing import Any, Final

from app.ingest.readers._table_head import TableHead, head_of_file
from estimators.conventions import PLACEMENTS

_QUANTITIES: Final = (
    ("gyroscope", re.compile(r"gyr|omega|angular|ang_?vel", re.IGNORECASE)),
    ("accelerometer", re.compile(r"acc|specific_?force", re.IGNORECASE)),
    ("magnetometer", re.compile(r"mag|field", re.IGNORECASE)),
)
_UNIT_TAIL: Final = re.compile(
    r"[\s_(\[{,]+(rad/s|radps|deg/s|degps|°/s|dps|m/s\^?2|m/s²|m/s/s|mps2|gauss|g|[uµμ]?t|mt|s|ms|[uµμ]s)[\s)\]}]*$",
    re.IGNORECASE,
)
_AXIS: Final = re.compile(r"^(.*?)[\s_.\-\[(/]*([xyzXYZ])[\s\])]*(?:[(\[{].*)?$")
_REPEATED: Final = re.compile(r" \([0-9]+\)$")
"""As `_table_head` numbers repeated names."""
_TIME: Final = re.compile(r"^(time|t|timestamp|seconds?)([^a-z]|$)", re.IGNORECASE)
_MILLI: Final = re.compile(r"(^|[^a-z])(ms|milli[a-z]*)($|[^a-z])", re.IGNORECASE)
_MICRO: Final = re.compile(r"(^|[^a-z])([uµμ]s|micro[a-z]*)($|[^a-z])", re.IGNORECASE)
_RATE: Final = re.compile(r"(?:rate|frequency)[^0-9]{0,20}([0-9]+(?:\.[0-9]+)?)", re.IGNORECASE)
_OTHER_UNITS: Final = {
    "accelerometer": {"g": "g"},
    "magnetometer": {"t": "T", "mt": "mT", "g": "G", "gauss": "G"},
}
_UNIT: Final = {"gyroscope": "rad/s", "accelerometer": "m/s^2", "magnetometer": "uT"}


def guess_mapping(path: Path) -> dict[str, Any]:
    """Guess how to read a table.

    Parameters
    ----------
    path : Path

    Returns
    -------
    dict
        Fields of `CsvMapping`; the placement of a sensor whose columns do not name it is None.

    Raises
    ------
    RecordingFormatError
        The file is no text.
    """
    return guess_of_head(head_of_file(path))


def guess_of_head(head: TableHead) -> dict[str, Any]:
    """Guess the mapping of a table whose head is known; see `guess_mapping`."""
    time = _time_column(head)
    found = None if time else _RATE.search("\n".join(head.preamble))
    return {
        "time_column": time,
        "time_unit": "s" if time is None else _time_unit(time),
        "rate_hz": float(found[1]) if found else None,
        "delimiter": head.delimiter,
        "signals": _signals(head.columns),
    }


def _signals(columns: tuple[str, ...]) -> list[dict[str, Any]]:
    """Triples of columns whose names tell quantity and axes."""
    groups: dict[str, dict[str, str]] = {}
    for column in columns:
        repeated = _REPEATED.search(column)
        number = repeated[0] if repeated else ""
        if parts := _AXIS.match(_UNIT_TAIL.sub("", column.removesuffix(number))):
            groups.setdefault(parts[1].lower() + number, {}).setdefault(parts[2].lower(), column)
    found = []
    for stem, axes in groups.items():
        quantity = next((name for name, words in _QUANTITIES if words.search(stem)), None)
        if quantity is not None and len(axes) == 3:
            found.append(
                {
                    "placement": _placement(stem),
                    "quantity": quantity,
                    "columns": [axes[axis] for axis in "xyz"],
                    "unit": _unit(axes["x"], quantity),
                }
            )
    return found


def _unit(column: str, quantity: str) -> str:
    if quantity == "gyroscope":
        return "deg/s" if re.search(r"deg|dps|°", column, re.IGNORECASE) else "rad/s"
    tail = _UNIT_TAIL.search(column)
    return _OTHER_UNITS[quantity].get(tail[1].lower() if tail else "", _UNIT[quantity])


def _placement(stem: str) -> str | None:
    plain = re.sub(r"[^a-z]+", "_", stem.lower())
    for name in PLACEMENTS:
        if name in plain:
            return name
    for name in PLACEMENTS:
        place, _, side = name.rpartition("_")
        if place and place in plain and (side in plain or side[0] in plain.split("_")):
            return name
    return None


def _time_column(head: TableHead) -> str | None:
    first = head.rows[0] if head.rows else ()
    for name, value in zip(head.columns, first, strict=False):
        if _TIME.match(name) and re.match(r"[+\-.0-9]", value):
            return name
    return None


def _time_unit(name: str) -> str:
    if _MICRO.search(name):
        return "us"
    return "ms" if _MILLI.search(name) else "s"


__all__ = ["guess_mapping", "guess_of_head"]
