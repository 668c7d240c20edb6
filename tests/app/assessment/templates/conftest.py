"""What therapist and patient performed, stored and analysed: fixtures of tests of templates and comparisons."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from sqlalchemy import Engine, select

from app import readers
from app.assessment.comparisons import compare_task
from app.database.unit_of_work import read_only
from app.ingest.upload import register
from app.ingest.upload_task import upload
from app.network.packet_log import write_log
from app.recordings.analysis.jobs import JobRunner, run_job
from app.recordings.analysis.reprocess import reprocess
from app.recordings.files_in_passing import upload_folder
from app.recordings.models import Job
from app.recordings.schemas import UploadIn
from app.settings import Settings
from estimators.simulation import ArmScenario, MovementStyle, Schedule, SimulatedSession, simulate_arm

ARM = ("sternum", "upper_arm_right", "forearm_right", "hand_right")
HANDLERS = {"upload": upload, "reprocess": reprocess, "compare": compare_task}
MAIN = "range:thorax_humerus_right_yxy_elevation"


def perform(style: MovementStyle, repetitions: int, seed: int) -> SimulatedSession:
    return simulate_arm(
        ArmScenario(
            exercise="reaching",
            placements=ARM,
            style=style,
            schedule=Schedule(n_pose_s=7.0, repetitions=repetitions, pause_s=1.5),
            seed=seed,
        )
    )


@pytest.fixture(scope="session")
def therapists() -> SimulatedSession:
    return perform(MovementStyle(), 5, 21)


@pytest.fixture(scope="session")
def patients() -> SimulatedSession:
    """Slower, smaller, and with the trunk: what a comparison must find."""
    style = replace(MovementStyle(), speed=0.6, amplitude=0.7, trunk_lean_rad=np.radians(12))
    return perform(style, 4, 22)


@pytest.fixture
def run_queue(engine: Engine, settings: Settings) -> Callable[[], list[str]]:
    """Do every queued task in this process, in order; returns how each ended."""

    def run() -> list[str]:
        ended = []
        while True:
            with read_only(engine) as session:
                job = session.scalars(
                    select(Job).where(Job.status == "queued").order_by(Job.created_at).limit(1)
                ).first()
            if job is None:
                return ended
            done = run_job(engine, settings, job.id, HANDLERS[job.kind])
            ended.append(f"{job.kind} {done.status}: {done.message}")

    return run


@pytest.fixture
def store(
    engine: Engine, settings: Settings, world: Any, run_queue: Callable[[], list[str]]
) -> Callable[..., str]:
    """Upload a simulated session, without the packets of an interval, and analyse it; returns its id."""

    def make(
        simulated: SimulatedSession,
        name: str = "therapist",
        lost_s: tuple[float, float] = (0.0, 0.0),
        **declared: Any,
    ) -> str:
        prepared = readers.packets_of(simulated.recording)
        first_us = next(iter(prepared.packets(1))).device_time_us
        kept = (
            packet
            for packet in prepared.packets(1)
            if not lost_s[0] <= (packet.device_time_us - first_us) * 1e-6 < lost_s[1]
        )
        path: Path = upload_folder(settings) / f"{name}-{len(declared)}.upload"
        path.write_bytes(b"".join(write_log(prepared.declaration.to_dict(), kept)))
        declaration = UploadIn(
            **{
                "patient_id": world.patient_id,
                "format": "packet_log",
                "exercise_id": world.exercise_id,
                **declared,
            }
        )
        job = register(engine, settings, world.subjects[name], declaration, path)
        ended = run_queue()
        assert all(" complete" in line for line in ended), ended
        return job.session_id

    return make


@pytest.fixture
def template_version(therapist: Any, store: Any, world: Any, therapists: SimulatedSession) -> dict[str, Any]:
    source = store(therapists, purpose="template")
    answer = therapist.post(
        "/api/templates",
        json={"session_id": source, "exercise_id": world.exercise_id, "name": "Reach, my way"},
    )
    assert answer.status_code == 201, answer.text
    return answer.json()


@pytest.fixture
def quiet_queue(services: Any) -> None:
    """The tests do the tasks themselves."""
    services.get(JobRunner).stop()
