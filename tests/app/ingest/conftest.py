"""A simulated session, its packet log, and files queued as received uploads."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from sqlalchemy import Engine

from app import readers
from app.ingest.upload import register
from app.network.packet_log import write_log
from app.recordings.files_in_passing import upload_folder
from app.recordings.schemas import UploadIn
from app.settings import Settings
from estimators.simulation import ArmScenario, Schedule, SimulatedSession, simulate_arm
from tests.app.ingest.uploads import ARM


@pytest.fixture(scope="module")
def simulated() -> SimulatedSession:
    return simulate_arm(
        ArmScenario(
            exercise="reaching",
            placements=ARM,
            schedule=Schedule(n_pose_s=6.0, repetitions=3, pause_s=1.0),
            seed=11,
        )
    )


@pytest.fixture
def log(tmp_path: Path, simulated: SimulatedSession) -> Path:
    prepared = readers.packets_of(simulated.recording)
    path = tmp_path / "session.tmlog"
    path.write_bytes(b"".join(write_log(prepared.declaration.to_dict(), prepared.packets(5))))
    return path


@pytest.fixture
def queue(engine: Engine, settings: Settings, world: Any) -> Callable[[Path, UploadIn], str]:
    """Put a file where a received upload lies and queue its task."""

    def place(source: Path, declaration: UploadIn) -> str:
        path = upload_folder(settings) / f"{source.stem}.upload"
        path.write_bytes(source.read_bytes())
        return register(engine, settings, world.subjects["therapist"], declaration, path).id

    return place
