"""The demonstration on many parts waits for their first start as long as it lasts, and for none that has ended."""

import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import psutil
import pytest

from app.commands import demo_scaled
from app.errors import Unavailable
from tests.patience import PATIENCE_S

ROOT = Path(__file__).parents[3]


class Process:
    def __init__(self, status: int | None) -> None:
        self._status = status

    def poll(self) -> int | None:
        return self._status


def waited(monkeypatch: pytest.MonkeyPatch, answers: dict[int, int], *status: int | None) -> int:
    """How often was looked, where each port answers from that look on."""
    looks = 0

    def look(_: float) -> None:
        nonlocal looks
        looks += 1

    monkeypatch.setattr(demo_scaled.time, "sleep", look)
    monkeypatch.setattr(demo_scaled, "answers", lambda port: looks >= answers[port])
    running: Any = dict(zip(answers, map(Process, status), strict=True))
    demo_scaled._until_ready(running)
    return looks


def test_it_waits_until_all_answer(monkeypatch: pytest.MonkeyPatch) -> None:
    assert waited(monkeypatch, {8000: 3, 8001: 2000}, None, None) == 2000


def test_it_waits_for_none_that_has_ended(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(Unavailable, match="see what they wrote above"):
        waited(monkeypatch, {8000: 3, 8001: 2000}, None, 1)


STARTED = """
import sys, time
from app.commands import demo_scaled

demo_scaled._interrupted_by_signals()
with demo_scaled._running([sys.executable, "-c", "import time; time.sleep(600)"], {}, None) as process:
    print(process.pid, flush=True)
    time.sleep(600)
"""


@pytest.mark.parametrize("by", [signal.SIGTERM, signal.SIGHUP, signal.SIGINT])
def test_whoever_stops_it_stops_all_that_it_started(by: signal.Signals) -> None:
    def ignoring() -> None:
        # As a shell starts what runs in the background.
        signal.signal(signal.SIGINT, signal.SIG_IGN)

    with subprocess.Popen(
        [sys.executable, "-c", STARTED],
        cwd=ROOT,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        preexec_fn=ignoring,
    ) as command:
        assert command.stdout is not None
        started = psutil.Process(int(command.stdout.readline()))
        command.send_signal(by)
        command.wait(PATIENCE_S)
        assert not started.is_running() or started.status() == psutil.STATUS_ZOMBIE
