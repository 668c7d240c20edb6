"""What a running service says of itself, and what it holds: metrics, memory, and what it has stored."""

import contextlib
import re
import sqlite3
import threading
import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import httpx
import numpy as np
import psutil

MB = 1e6
LOOK_EVERY_S = 0.5
_LINE = re.compile(r"^telemotion_(\w+)(?:\{\w+=\"(\w+)\"\})? (\S+)$", re.MULTILINE)


def metrics(port: int) -> dict[str, float]:
    """Return the metrics of a service by name, or name and label with a dot between."""
    text = httpx.get(f"http://127.0.0.1:{port}/metrics", trust_env=False, timeout=60.0).text
    return {f"{name}.{label}" if label else name: float(value) for name, label, value in _LINE.findall(text)}


def rare_share(before: dict[str, float], after: dict[str, float]) -> float:
    """Return the share of packets that took the general way between two readings of the metrics."""
    pooled, general = (
        after.get(name, 0.0) - before.get(name, 0.0)
        for name in ("live_packets_total.pooled", "live_packets_total.general")
    )
    return general / max(pooled + general, 1.0)


def resident_mb(process: psutil.Process) -> float:
    """Return the memory of the service itself; processes for checks and analyses come beside it."""
    return float(process.memory_info().rss) / MB


def idle_mb(process: psutil.Process, patience_s: float = 60.0) -> float:
    """Return the memory of a service that nobody uses, when all that it prepares at its start is there."""
    deadline, before = time.monotonic() + patience_s, 0.0
    while (now := resident_mb(process)) - before > 1.0 and time.monotonic() < deadline:
        before = now
        time.sleep(4.0)
    return now


@dataclass
class Memory:
    """Memory of the service over a load, MB.

    Attributes
    ----------
    idle_mb : float
        Before the first session.
    minutes : list of (minute, MB)
        From the start of measured time on.
    least : list of (minute, MB)
        The least that was held in the minute before: what it needs for a moment comes and goes by some megabytes, and
        is no growth.
    """

    process: psutil.Process
    idle_mb: float
    minutes: list[tuple[float, float]] = field(default_factory=list)
    least: list[tuple[float, float]] = field(default_factory=list)
    _looked: list[float] = field(default_factory=list)

    def __post_init__(self) -> None:
        threading.Thread(target=self._look, daemon=True).start()

    def _look(self) -> None:
        with contextlib.suppress(psutil.NoSuchProcess):
            while True:
                self._looked.append(resident_mb(self.process))
                time.sleep(LOOK_EVERY_S)

    def note(self, minute: float) -> None:
        """Take the memory of now, and the least since it was noted before."""
        looked, self._looked = self._looked, []
        now = resident_mb(self.process)
        self.minutes.append((minute, now))
        self.least.append((minute, min([now, *looked])))
        print(f"memory    minute {minute:4.1f}: {now:7.1f} MB, least {self.least[-1][1]:7.1f} MB", flush=True)

    def a_session_mb(self, sessions: int) -> float:
        """Return the most that a session took."""
        return (max(mb for _, mb in self.minutes) - self.idle_mb) / sessions

    def growth_mb(self, settled_minutes: float) -> float:
        """Return the growth in a minute from then on, by the line through the least; NaN with fewer than three."""
        found = np.array([one for one in self.least if one[0] >= settled_minutes])
        return float(np.polyfit(*found.T, 1)[0]) if len(found) >= 3 else np.nan


def stored(folder: Path, sessions: Sequence[str] = ()) -> dict[str, tuple[int, int, int]]:
    """Return chunks, ticks and bytes by stream kind, of all sessions or some."""
    some = f" WHERE session_id IN ({', '.join('?' * len(sessions))})" if sessions else ""
    with sqlite3.connect(folder / "bench.db") as connection:
        rows = connection.execute(
            "SELECT CASE WHEN stream = 'raw' THEN 'raw' ELSE 'frames' END, COUNT(*), SUM(ticks), SUM(LENGTH(data))"
            f" FROM signal_chunk{some} GROUP BY 1",
            tuple(sessions),
        ).fetchall()
    return {kind: (chunks, ticks, size) for kind, chunks, ticks, size in rows}
