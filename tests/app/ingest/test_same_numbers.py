"""A file gives the same numbers by upload and on the command line, whatever its format."""

from collections.abc import Callable
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet
import pytest
import scipy.io
from sqlalchemy import Engine
from typer.testing import CliRunner

from app import readers
from app.cli import cli
from app.commands.options.tables import UploadOptions
from app.commands.upload import declaration_of
from app.database.unit_of_work import read_only
from app.ingest.upload_task import upload
from app.network.packet_log import write_log
from app.recordings.analysis.jobs import run_job
from app.recordings.columns import frames_table
from app.recordings.schemas import UploadIn
from app.recordings.signals.store import read_frames
from app.settings import Settings
from estimators.pipelines import Frames
from estimators.simulation import Bout, Leg, SimulatedSession, gait_preset, simulate_gait
from tests.app.ingest.uploads import session_of
from tests.app.readers.odd_tables import odd_tables
from tests.app.readers.recording_files import as_whole_body, broad_content, gaitmap, pyshoe, xio


def a_stream(folder: Path, simulated: SimulatedSession) -> Path:
    """A log as a device sends it, every twentieth packet lost."""
    prepared = readers.packets_of(simulated.recording)
    hello = prepared.declaration.to_dict() | {"is_stamped": False}
    packets = (packet for packet in prepared.packets(5) if packet.sequence % 20 != 7)
    path = folder / "session.tmlog"
    path.write_bytes(b"".join(write_log(hello, packets)))
    return path


def a_whole_body(folder: Path, simulated: SimulatedSession) -> Path:
    path = folder / "body.mat"
    as_whole_body(simulated, path)
    content = scipy.io.loadmat(path, simplify_cells=True)
    # Neither on ticks nor even.
    stamps = content["t"] + 0.004 * np.sin(np.arange(content["t"].size))
    names = set(readers.PLACEMENT_OF) & set(content)
    scipy.io.savemat(path, {"t": stamps} | {name: content[name] for name in names})
    return path


def a_broad_trial(folder: Path, _: SimulatedSession) -> Path:
    scipy.io.savemat(folder / "trial.mat", broad_content())
    return folder / "trial.mat"


def a_walk_with_repeated_stamps(folder: Path, _: SimulatedSession) -> Path:
    def repeat(table: Any) -> None:
        table[150:1500:300, 0] = table[149:1499:300, 0]
        table[2000:, 0] += 0.3

    return xio(folder / "walk.csv", repeat)


def instrumented_shoes(folder: Path, _: SimulatedSession) -> Path:
    path = folder / "shoes.csv"
    preset = replace(gait_preset("stroke", 3), rate_hz=100.0, course=(Bout((Leg(6),), 3.0),))
    walk = simulate_gait(preset)
    readers.write_instrumented_shoe(walk.recording, path)
    return path


def an_odd_table(name: str) -> Callable[[Path, SimulatedSession], Path]:
    def write(folder: Path, _: SimulatedSession) -> Path:
        odd = odd_tables()[name]
        (folder / odd.name).write_bytes(odd.content)
        return folder / odd.name

    return write


CASES: dict[str, Callable[[Path, SimulatedSession], Path]] = {
    "packet_log": a_stream,
    "qmt_mat": a_whole_body,
    "broad": a_broad_trial,
    "pyshoe": lambda folder, _: pyshoe(folder / "walk.mat"),
    "gait_tracking": a_walk_with_repeated_stamps,
    "gaitmap": lambda folder, _: gaitmap(folder, truth=False),
    "instrumented_shoe": instrumented_shoes,
    **{
        f"csv: {name}": an_odd_table(name)
        for name in (
            "letters",
            "utf-16",
            "a clock that starts again",
            "rows that came late",
            "stamps that repeat",
            "feet by the names of columns",
        )
    },
}


# The test of any other reader brings its own file, so that a new reader changes nothing here.
for _name in sorted(set(readers.readers()) - {name.partition(":")[0] for name in CASES}):
    CASES[_name] = import_module(f"tests.app.readers.test_{_name}").example


def stored(
    engine: Engine, settings: Settings, queue: Callable[[Path, UploadIn], str], wanted: UploadOptions
) -> tuple[Frames, str]:
    """Upload a file; return the frames of the session and its pipeline."""
    (path,) = wanted.recording
    job_id = queue(path, declaration_of(path, wanted))
    done = run_job(engine, settings, job_id, upload)
    assert done.status == "complete", done.message
    found = session_of(engine, job_id)
    with read_only(engine) as session:
        return read_frames(session, found.main_result_id), str(found.setup["pipeline"])


def resolution(column: str, values: np.ndarray) -> np.ndarray:
    """Half a step in which a session stores each number of a column; see `app.recordings.signals.frame_codec`."""
    if "_sigma_" in column:
        return np.abs(values) / 1000.0
    known = np.abs(values[np.isfinite(values)])
    step = 2.0**-22 * float(known.max(initial=0.0))
    if "_q_" in column:
        step = 2.0**-15
    elif column.endswith(("_rad", "_m", "_mps")):
        step = 2.0**-14
    return np.full(values.shape, 0.5 * step)


@pytest.mark.parametrize("name", CASES)
def test_an_upload_and_the_command_line_give_the_same_numbers(
    engine: Engine,
    settings: Settings,
    world: Any,
    queue: Any,
    tmp_path: Path,
    simulated: SimulatedSession,
    name: str,
) -> None:
    path = CASES[name](tmp_path, simulated)
    is_table = name.startswith(("csv", "zipped"))
    wanted = UploadOptions(recording=[path], patient=world.patient_id, guess=is_table, force=is_table)
    frames, pipeline = stored(engine, settings, queue, wanted)
    options = ["--guess", "--force"] if is_table else []
    said = CliRunner().invoke(cli, ["process", str(path), *options, "--out", str(tmp_path / "out")])
    assert said.exit_code == 0, said.output
    table = pyarrow.parquet.read_table(tmp_path / "out" / "frames.parquet")
    uploaded = frames_table(frames, pipeline=pipeline)
    assert set(uploaded.column_names) <= set(table.column_names)
    assert uploaded.num_rows == table.num_rows
    apart = {}
    for column in uploaded.column_names:
        ours, theirs = (np.asarray(one[column], dtype=np.float64) for one in (uploaded, table))
        np.testing.assert_array_equal(np.isnan(ours), np.isnan(theirs), err_msg=column)
        beyond = np.abs(ours - theirs) > 1.01 * resolution(column, theirs) + 1e-9
        if beyond.any():
            apart[column] = float(np.max(np.abs(ours - theirs)[beyond]))
    assert not apart
