"""How far the past sessions of a demonstration are: written by who makes them, read by the page and the next start."""

import json
import os
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

from fastapi import APIRouter, Request

from app.accounts.dependencies import CurrentSubject
from app.schemas import Schema
from app.services import services_of

NAME: Final = "history.json"
STEPS: Final = 15
"""Of the whole history: a test counts them, so that starting need not load what makes them."""
_OLD_MARK: Final = "history-complete"
"""What an earlier version left beside the database when all was made."""


@dataclass
class HistoryProgress:
    """What of the history is there.

    Attributes
    ----------
    total : int
        Steps of the whole.
    done : dict of str to str
        By step: what later steps need of it, such as an identifier.
    kept_sessions : list of str
        Those that are finished; what else an interrupted start recorded is thrown away.
    """

    path: Path
    total: int
    done: dict[str, str] = field(default_factory=dict)
    kept_sessions: list[str] = field(default_factory=list)

    @classmethod
    def of(cls, folder: Path) -> "HistoryProgress | None":
        """Read the progress of the demonstration in a folder; None where none was begun."""
        path = folder / NAME
        if path.exists():
            return cls(path, **json.loads(path.read_text()))
        if (folder / _OLD_MARK).exists():
            return cls(path, 0)
        return None

    @property
    def is_complete(self) -> bool:
        """Whether nothing is left to be made."""
        return len(self.done) >= self.total

    def add(self, step: str, result: str = "", *sessions: str) -> None:
        """Note that a step is done, at once and for good."""
        self.done[step] = result
        self.kept_sessions += sessions
        self.save()

    def save(self) -> None:
        """Write the file so that a reader sees the old or the new one, never half of it."""
        content = {"total": self.total, "done": self.done, "kept_sessions": self.kept_sessions}
        waiting = self.path.with_suffix(".part")
        waiting.write_text(json.dumps(content))
        os.replace(waiting, self.path)


def new_progress(folder: Path) -> HistoryProgress:
    """Return the progress of a history of which nothing is there."""
    return HistoryProgress(folder / NAME, STEPS)


def complete(folder: Path) -> HistoryProgress:
    """Return the progress of a history of which nothing is to be made."""
    return HistoryProgress(folder / NAME, 0)


router = APIRouter(prefix="/api", tags=["service"])


class HistoryOut(Schema):
    """Past sessions of the demonstration that are there, of those that will be."""

    prepared: int
    total: int


@router.get("/demonstration")
def demonstration(request: Request, subject: CurrentSubject) -> HistoryOut | None:
    """Return how far the past sessions of a demonstration are; null elsewhere and when all are there."""
    settings = services_of(request).settings
    history = HistoryProgress.of(settings.data_dir) if settings.demo else None
    if history is None or history.is_complete:
        return None
    return HistoryOut(prepared=len(history.done), total=history.total)
