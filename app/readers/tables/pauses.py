"""Pauses that an app for phones cuts out of its time: where a list of events has them, they are put back."""

import csv
import io
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import PurePosixPath
from typing import Final

import numpy as np

from app.readers.members import Member
from estimators.recording import Float

_MOST_BYTES: Final = 1 << 18


@dataclass(frozen=True)
class Pauses:
    """Where time stood still, and for how long (s).

    Attributes
    ----------
    at_s, length_s : tuple of float
        By the time of the tables.
    """

    at_s: tuple[float, ...]
    length_s: tuple[float, ...]

    @property
    def count(self) -> int:
        """How many."""
        return len(self.at_s)

    def put_back(self, time_s: Float) -> Float:
        """Return stamps with the pauses between them, shape (N,)."""
        before = np.concatenate([[0.0], np.cumsum(self.length_s)])
        return np.asarray(time_s + before[np.searchsorted(self.at_s, time_s, side="right")])


def pauses_of(members: Sequence[Member]) -> Pauses | None:
    """Return the pauses that `meta/time.csv` lists, as phyphox writes it; None without such a list."""
    listed = next(
        (one for one in members if PurePosixPath(one.name).parts[-2:] == ("meta", "time.csv")), None
    )
    if listed is None:
        return None
    with listed.open() as file:
        text = file.read(_MOST_BYTES).decode("utf-8", errors="replace")
    at_s: list[float] = []
    length_s: list[float] = []
    paused: float | None = None
    for row in csv.DictReader(io.StringIO(text)):
        try:
            event, inside, outside = row["event"], float(row["experiment time"]), float(row["system time"])
        except (KeyError, TypeError, ValueError):
            return None
        if event == "PAUSE":
            paused = outside
        elif event == "START" and paused is not None:
            if outside > paused:
                at_s.append(inside)
                length_s.append(outside - paused)
            paused = None
    return Pauses(tuple(at_s), tuple(length_s))
