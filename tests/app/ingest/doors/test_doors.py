"""One file, one judgement: by `telemotion process`, the upload page, and `telemotion upload`."""

from base64 import b64encode
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cache, partial
from io import BytesIO
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from zipfile import ZIP_DEFLATED, ZipFile

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from sqlalchemy import Engine
from typer.testing import CliRunner

from app import readers
from app.cli import cli
from app.commands.options.tables import UploadOptions
from app.commands.processing import estimate
from app.commands.upload import declaration_of
from app.errors import InvalidInput
from app.ingest import upload_task
from app.ingest.preview import previewed
from app.ingest.preview_schemas import PreviewIn
from app.recordings.analysis.jobs import run_job
from app.recordings.schemas import UploadIn
from app.settings import Settings
from estimators.pipelines import SessionSetup
from estimators.sentences import Sentence
from estimators.sentences import say as said
from tests.app.ingest.uploads import declare, session_of
from tests.app.readers.odd_fields import field_tables
from tests.app.readers.odd_tables import (
    ALL,
    FORCE,
    GYROSCOPE,
    PLAIN,
    TIME_S,
    G,
    odd_tables,
    refused_tables,
    rows_of,
    text,
)
from tests.said import codes


@dataclass
class Case:
    """A file, what a person says of it, and how the service is set."""

    content: bytes
    name: str = "table.csv"
    rate_hz: float | None = None
    hemisphere: str = ""
    place: str = "north"
    force: bool = False


@dataclass
class Verdict:
    """What came out; `refused` holds codes, or nothing of a file that was taken."""

    refused: tuple[str, ...] = ()
    rate_hz: float = 0.0
    sensors: tuple[str, ...] = ()
    pipeline: str = ""
    notes: frozenset[str] = field(default_factory=frozenset)
    corrected: tuple[str, ...] = ()


def table(*parts: np.ndarray, time_s: np.ndarray = TIME_S, head: str = PLAIN) -> bytes:
    return text([head], rows_of(*parts, time_s=time_s)).encode()


@cache
def turning() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A sensor that rests for 4 s and then turns slowly about all axes: rad/s, m/s^2, and uT north of the equator."""
    at_s = np.arange(2500) / 100.0
    waves = np.sin(np.outer(at_s, [1.1, 1.7, 2.3]) + np.array([0.3, 1.0, 2.0])) * [1.2, 1.0, 0.8]
    rate = waves * (at_s > 4.0)[:, None]
    turn, force, field = Rotation.identity(), [], []
    for step in rate / 100.0:
        force.append(turn.inv().apply([0.0, 0.0, G]))
        field.append(turn.inv().apply([0.0, 20.0, -44.0]))
        turn = turn * Rotation.from_rotvec(step)
    noise = np.random.default_rng(3).normal(size=(3, 2500, 3))
    return rate + 0.003 * noise[0], np.array(force) + 0.02 * noise[1], np.array(field) + 0.3 * noise[2]


def turned_case(
    change: Callable[[np.ndarray, np.ndarray, np.ndarray], tuple[np.ndarray, ...]], **said: Any
) -> Case:
    """A sensor that turns, as it is after a change of what it measured."""
    return Case(table(*change(*turning()), time_s=LONG_S), **said)


def southern(rate: np.ndarray, force: np.ndarray, field_ut: np.ndarray) -> tuple[np.ndarray, ...]:
    """The field as it is south of the equator: what lies along gravity points the other way."""
    return rate, force, field_ut + 88.0 * force / G


def gravity(rate: np.ndarray, force: np.ndarray, field_ut: np.ndarray) -> tuple[np.ndarray, ...]:
    return rate, -force, field_ut


def uncalibrated(rate: np.ndarray, force: np.ndarray, field_ut: np.ndarray) -> tuple[np.ndarray, ...]:
    return rate, force * [1.03, 0.97, 1.03] + [0.05 * G, -0.04 * G, 0.08 * G], field_ut


def exchanged(rate: np.ndarray, force: np.ndarray, field_ut: np.ndarray) -> tuple[np.ndarray, ...]:
    return rate[:, [1, 0, 2]], force, field_ut


LONG_S = np.arange(2500) / 100.0
PAUSED_S = np.where(np.arange(len(TIME_S)) < 700, TIME_S, TIME_S + 1200.0)
SIX = ",".join(PLAIN.split(",")[:7])
FAST_S = np.arange(len(TIME_S)) / 1125.0
FEW = (
    "one value a row",
    "two header lines",
    "feet by the names of columns",
    "a head that stands again",
    "rows of two devices",
    "a clock for each sensor",
    "rows of three kinds",
    "samples in bursts",
)


def counted() -> bytes:
    names = ",".join(["Packet number", *PLAIN.split(",")[1:]])
    return text([names], rows_of(*ALL, time_s=100.0 * TIME_S)).encode()


def phone() -> bytes:
    """A table a quantity, as an app for phones packs them."""
    packed = BytesIO()
    rate, force, _ = turning()
    with ZipFile(packed, "w", ZIP_DEFLATED) as archive:
        for name, values, late_s in (("Accelerometer", force, 0.0), ("Gyroscope", rate, 0.004)):
            head = "time," + ",".join(f"{name} {axis}" for axis in "xyz")
            archive.writestr(
                f"{name}.csv", text([head], rows_of(values[:1200], time_s=LONG_S[:1200] + late_s))
            )
    return packed.getvalue()


ACCEPTED: dict[str, Callable[[], Case]] = {
    "a zip of a phone": lambda: Case(phone(), "walk.zip"),
    **{
        name: partial(Case, odd.content, odd.name)
        for name, odd in (odd_tables() | field_tables()).items()
        if name in FEW
    },
    "a counter with its rate": lambda: Case(counted(), rate_hz=100.0),
    "southern, as the person says": lambda: turned_case(southern, hemisphere="south"),
    "southern, as the service is set": lambda: turned_case(southern, place="south"),
    "an accelerometer that gives gravity, as it is": lambda: turned_case(gravity, force=True),
    "an accelerometer as delivered": lambda: turned_case(uncalibrated),
    "a pause of twenty minutes": lambda: Case(table(*ALL, time_s=PAUSED_S)),
    "1125 Hz": lambda: Case(table(GYROSCOPE * 11.25, FORCE, time_s=FAST_S, head=SIX)),
}
REFUSED_FOR = {
    **{name: code for name, (_, code) in refused_tables().items()},
    "southern": "upload.implausible",
    "an accelerometer that gives gravity": "upload.implausible",
    "two axes exchanged": "upload.implausible",
    "a counter": "guess.counter_needs_rate",
    "counts of a converter": "guess.no_unit",
    "a workbook": "file.foreign",
    "a zip that was cut": "zip.damaged",
    "a workbook that is called a table": "file.foreign",
    "a PDF": "file.foreign",
    "nothing": "table.empty",
}
WORKBOOK = (
    b"PK\x03\x04\x14\0\x06\0\x08\0\0\0!\0"
    + bytes(12)
    + b"\x13\0\0\0[Content_Types].xml"
    + bytes(99)
    + b"xl/workbook.xml"
)
CASES: dict[str, Callable[[], Case]] = {
    **ACCEPTED,
    **{name: partial(Case, content) for name, (content, _) in refused_tables().items()},
    "southern": lambda: turned_case(southern),
    "an accelerometer that gives gravity": lambda: turned_case(gravity),
    "two axes exchanged": lambda: turned_case(exchanged),
    "a counter": lambda: Case(counted()),
    "counts of a converter": lambda: Case(table(GYROSCOPE, 20_000.0 * FORCE, head=SIX)),
    "a workbook": lambda: Case(WORKBOOK, "walk.xlsx"),
    "a zip that was cut": lambda: Case(phone()[:9000], "walk.zip"),
    "a workbook that is called a table": lambda: Case(WORKBOOK),
    "a PDF": lambda: Case(b"%PDF-1.7\n%\xe2\xe3\xcf\xd3\n" + bytes(range(256)) * 9, "report.pdf"),
    "nothing": lambda: Case(b""),
}


FIELD = {place: said(f"guess.hemisphere_{place}") for place in ("north", "south", "unknown")}


@pytest.fixture
def doors(
    engine: Engine,
    settings: Settings,
    world: Any,
    queue: Any,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> Any:
    monkeypatch.setattr(upload_task, "_analyse", lambda *_: SimpleNamespace(message=""))
    monkeypatch.setattr(upload_task, "_finish", lambda *_: None)

    def process(case: Case, path: Path) -> Verdict:
        found = Verdict()

        def run(*given: Any, **_: Any) -> None:
            setup = next(one for one in given if isinstance(one, SessionSetup))
            found.rate_hz, found.sensors, found.pipeline = setup.rate_hz, setup.placements, setup.pipeline
            found.corrected = tuple(setup.devices)
            raise _Estimated

        monkeypatch.setattr(estimate.pipelines, "run", run)
        monkeypatch.setattr(estimate, "analyse", run)
        done = CliRunner().invoke(
            cli,
            ["process", str(path), "--guess", "--out", str(tmp_path / "out")]
            + (["--rate", str(case.rate_hz)] if case.rate_hz else [])
            + (["--hemisphere", case.hemisphere] if case.hemisphere else [])
            + (["--force"] if case.force else []),
            env={"TELEMOTION_HEMISPHERE": case.place},
        )
        if isinstance(done.exception, _Estimated):
            lines = [line.partition(": ")[2] for line in done.stderr.splitlines()]
            return replace(found, notes=frozenset(lines))
        assert isinstance(done.exception, InvalidInput), done.exception
        return Verdict(_codes_of(done.exception))

    def upload(case: Case, path: Path, declaration: UploadIn, notes: list[str]) -> Verdict:
        at = settings.model_copy(update={"hemisphere": case.place})
        done = run_job(engine, at, queue(path, declaration), upload_task.upload)
        if done.status == "failed":
            return Verdict(_kinds(codes(done.message)))
        setup = session_of(engine, done.job_id).setup
        lines = [line for line in _lines(done.message) if getattr(line, "code", "") != "upload.day_unknown"]
        said = frozenset(map(str, [*notes, *lines]))
        corrected = tuple(setup["devices"])
        return Verdict((), setup["rate_hz"], tuple(setup["placements"]), setup["pipeline"], said, corrected)

    def page(case: Case) -> tuple[UploadIn, list[str]] | Verdict:
        asked = {"file_name": case.name, "rate_hz": case.rate_hz, "hemisphere": case.hemisphere or None}
        beginning = b64encode(case.content[: readers.HEAD_BYTES])
        at = settings.model_copy(update={"hemisphere": case.place})
        try:
            seen = previewed(PreviewIn.model_validate({**asked, "beginning": beginning}), at)
        except InvalidInput as error:
            return Verdict(_codes_of(error))
        if seen.missing:
            return Verdict(tuple(sorted({one.code for one in seen.sentences["missing"]})))
        declared = {
            "format": seen.format,
            "file_name": case.name,
            "csv": seen.mapping and seen.mapping.model_dump(),
            "pipeline": seen.pipeline,
            "hemisphere": case.hemisphere or None,
            "accept_implausible": case.force,
        }
        of_sensors = [one.sentence.partition(": ")[2] for one in seen.sensors]
        return declare(world, **declared), [*of_sensors, *seen.notes]

    def command(case: Case, path: Path, capsys: Any) -> tuple[UploadIn, list[str]] | Verdict:
        said = {"rate_hz": case.rate_hz, "force": case.force, "hemisphere": case.hemisphere}
        options = UploadOptions(recording=[path], patient=world.patient_id, guess=True, **said)
        capsys.readouterr()
        try:
            declaration = declaration_of(path, options)
        except InvalidInput as error:
            return Verdict(_codes_of(error))
        return declaration, [line.partition(": ")[2] for line in capsys.readouterr().err.splitlines()]

    return SimpleNamespace(process=process, page=page, command=command, upload=upload)


class _Estimated(Exception):
    pass


def _codes_of(error: InvalidInput) -> tuple[str, ...]:
    return (
        tuple(sorted(error.details["missing"]))
        if "missing" in error.details and not codes(error.message)
        else _kinds(codes(error.message))
    )


def _kinds(found: list[str]) -> tuple[str, ...]:
    """Return the codes of a refusal without the remedy, which is another at each door."""
    return tuple(
        sorted(
            {code for code in found if code not in ("upload.correct_or_accept", "process.correct_or_force")}
        )
    )


def _lines(message: Any) -> list[Any]:
    if isinstance(message, Sentence) and message.code == "text.lines":
        return list(message.parameters["lines"])
    return [message] if message else []


@pytest.mark.parametrize("name", CASES)
def test_all_doors_give_one_judgement(doors: Any, tmp_path: Path, capsys: Any, name: str) -> None:
    case = CASES[name]()
    path = tmp_path / case.name
    path.write_bytes(case.content)
    judged = doors.process(case, path)
    sent = doors.page(case)
    # What both declare to the service alike is judged there alike.
    by_command = doors.command(case, path, capsys)
    if isinstance(sent, Verdict):
        assert by_command == sent
    else:
        assert by_command[0] == sent[0]
        # Only the service knows where it stands, so the command says nothing of the field unless told.
        assert [one for one in sent[1] if one not in by_command[1]] in ([], [FIELD[case.place]])
    assert (sent if isinstance(sent, Verdict) else doors.upload(case, path, *sent)) == judged
    if name in ACCEPTED:
        assert judged.refused == ()
        assert bool(judged.corrected) == (name == "an accelerometer as delivered")
    if name in REFUSED_FOR:
        assert REFUSED_FOR[name] in judged.refused


def test_an_upload_that_names_no_kind_is_what_its_sensors_are_worn_for(doors: Any, tmp_path: Path) -> None:
    case = CASES["feet by the names of columns"]()
    path = tmp_path / case.name
    path.write_bytes(case.content)
    declaration, notes = doors.page(case)
    unsaid = doors.upload(case, path, declaration.model_copy(update={"pipeline": None}), notes)
    assert unsaid == doors.process(case, path)
    assert unsaid.pipeline == "gait"


def test_a_zip_needs_no_mapping(doors: Any, tmp_path: Path) -> None:
    case = CASES["a zip of a phone"]()
    path = tmp_path / case.name
    path.write_bytes(case.content)
    declaration, shown = doors.page(case)
    unsaid = declaration.model_copy(update={"csv": None, "pipeline": None, "format": None})
    uploaded, processed = doors.upload(case, path, unsaid, []), doors.process(case, path)
    # All that is assumed is said; what the sensor is taken for stands on the session's own page.
    assert uploaded == replace(processed, notes=processed.notes - {shown[0]})
