"""Uploads of every kind of file: analysed like a stream, or refused for what is wrong in them."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.io
from sqlalchemy import Engine

from app.database.unit_of_work import read_only
from app.ingest.upload_task import upload
from app.recordings.analysis.jobs import JobDone, run_job
from app.recordings.models import Job
from app.recordings.schemas import JobOut
from app.recordings.service import job_out
from app.recordings.signals.store import read_frames
from app.settings import Settings
from estimators.sentences import say
from estimators.simulation import SimulatedSession
from tests.app.ingest.uploads import ARM, declare, session_of
from tests.app.readers.recording_files import as_csv, as_whole_body, broad_content


@pytest.mark.parametrize("write", [as_csv, as_whole_body])
def test_every_format_is_analysed_like_a_stream(
    engine: Engine,
    settings: Settings,
    world: Any,
    queue: Any,
    tmp_path: Path,
    simulated: SimulatedSession,
    write: Callable[[SimulatedSession, Path], dict[str, Any]],
) -> None:
    path = tmp_path / "session.file"
    job_id = queue(path, declare(world, **write(simulated, path)))
    done = run_job(engine, settings, job_id, upload)
    # Where a file does not say when it was recorded, that is said, and nothing else.
    assert done.status == "complete"
    assert done.message in {"", say("upload.day_unknown")}
    found = session_of(engine, job_id)
    assert set(found.setup["placements"]) == set(ARM)
    assert found.setup["rate_hz"] == 100.0
    assert found.setup["calibration"] is not None
    with read_only(engine) as session:
        frames = read_frames(session, found.main_result_id)
    name = "humerus_forearm_right_zxy_flexion"
    error = frames.angle_rad[:, frames.layout.angles.index(name)] - simulated.truth.angle_rad(name)
    # Without a magnetometer the heading of each sensor drifts; the bound of the issue holds with one.
    assert np.degrees(np.sqrt(np.nanmean(error**2))) < (2.0 if write is as_csv else 6.0)


@pytest.mark.parametrize(
    ("name", "write", "pipeline"),
    [
        ("body.mat", lambda simulated, path: as_whole_body(simulated, path), "arm"),
        (
            "trial.mat",
            lambda _, path: scipy.io.savemat(path, broad_content(), appendmat=False),
            "orientation",
        ),
    ],
)
def test_a_file_without_a_format_is_recognised_as_process_does(
    engine: Engine,
    settings: Settings,
    world: Any,
    queue: Any,
    tmp_path: Path,
    simulated: SimulatedSession,
    name: str,
    write: Callable[[SimulatedSession, Path], object],
    pipeline: str,
) -> None:
    path = tmp_path / "received.upload"
    write(simulated, path)
    job_id = queue(path, declare(world, format=None, file_name=name))
    done = run_job(engine, settings, job_id, upload)
    assert done.status == "complete", done.message
    assert session_of(engine, job_id).setup["pipeline"] == pipeline


@pytest.mark.parametrize(
    ("name", "content", "code"),
    [
        ("notes.docx", b"PK nothing", "file.format_not_recognised"),
        ("a.csv", b"t,x\n0,1\n", "upload.csv_needs_mapping"),
    ],
)
def test_a_file_that_nothing_recognises_is_refused_in_words(
    engine: Engine,
    settings: Settings,
    world: Any,
    queue: Any,
    tmp_path: Path,
    name: str,
    content: bytes,
    code: str,
) -> None:
    path = tmp_path / "received.upload"
    path.write_bytes(content)
    job_id = queue(path, declare(world, format=None, file_name=name))
    done = run_job(engine, settings, job_id, upload)
    assert shown(engine, done).sentences["message"].code == code
    assert session_of(engine, job_id).state == "failed"


def shown(engine: Engine, done: JobDone) -> JobOut:
    with read_only(engine) as session:
        return job_out(session.get_one(Job, done.job_id))


def test_a_csv_with_a_missing_column_fails_in_words(
    engine: Engine, settings: Settings, world: Any, queue: Any, tmp_path: Path, simulated: SimulatedSession
) -> None:
    path = tmp_path / "session.csv"
    declared = as_csv(simulated, path)
    declared["csv"]["signals"][1]["columns"][0] = "not there"
    job_id = queue(path, declare(world, **declared))
    done = run_job(engine, settings, job_id, upload)
    assert done.status == "failed"
    assert "no column not there" in done.message
    assert not shown(engine, done).is_implausible
    assert shown(engine, done).sentences["message"].code == "table.no_column"
    assert session_of(engine, job_id).state == "failed"


def test_wrong_axes_fail_in_words_until_they_are_declared_or_accepted(
    engine: Engine, settings: Settings, world: Any, queue: Any, tmp_path: Path, simulated: SimulatedSession
) -> None:
    path = tmp_path / "session.csv"
    declared = as_csv(simulated, path)
    columns = next(
        s
        for s in declared["csv"]["signals"]
        if (s["placement"], s["quantity"]) == ("forearm_right", "gyroscope")
    )["columns"]
    columns[0], columns[1] = columns[1], columns[0]
    done = run_job(engine, settings, queue(path, declare(world, **declared)), upload)
    assert done.status == "failed"
    assert "Right forearm: the axes of the gyroscope do not fit" in done.message
    assert shown(engine, done).is_implausible
    assert shown(engine, done).sentences["message"].code == "upload.implausible"
    accepted = run_job(
        engine, settings, queue(path, declare(world, **declared, accept_implausible=True)), upload
    )
    assert not shown(engine, accepted).is_implausible
    assert accepted.status == "complete"
    assert "Right forearm: the axes of the gyroscope do not fit" in accepted.message
