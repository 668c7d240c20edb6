"""Parts that the managers of a process share; a service in one process has one manager."""

import asyncio
from collections.abc import Collection
from dataclasses import dataclass, field
from functools import partial
from typing import Final, Protocol
from weakref import WeakSet

from app.live.admission import Admission
from app.live.checks.plausibility import CheckProcess
from app.live.engine.turns import PooledEngine
from app.live.session.runner import LiveSession
from app.live.warmup import Readiness

REBUILT_TOGETHER: Final = 2
"""After a restart all sessions come back at once. Most of it holds the interpreter: more would hold up the event loop,
and the threads in which tickets are redeemed before they expire."""


class HasSessions(Protocol):
    """Has live sessions of this process."""

    @property
    def sessions(self) -> Collection[LiveSession]:
        """These, as of now."""


@dataclass
class Shared:
    """What the managers of a process have in common."""

    readiness: Readiness = field(default_factory=Readiness)
    pooled: PooledEngine = field(default_factory=PooledEngine)
    """Takes the packets of all sessions that it can take."""
    check: CheckProcess = field(default_factory=CheckProcess)
    admission: Admission = field(default_factory=Admission)
    rebuilding: asyncio.Semaphore = field(default_factory=partial(asyncio.Semaphore, REBUILT_TOGETHER))
    sides: WeakSet[HasSessions] = field(default_factory=WeakSet)
    """Whose sessions share the machine."""

    def __post_init__(self) -> None:
        self.pooled.is_being_prepared = lambda: self.readiness.is_preparing_engine

    @property
    def sessions(self) -> list[LiveSession]:
        """All live sessions of this process."""
        return [one for side in self.sides for one in side.sessions]
