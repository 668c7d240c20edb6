"""What is logged: a line for each change that operations.md promises, in one form, and never what people typed."""

import io
import json
import logging
import os
import re
import signal
import subprocess
import sys
import threading
import warnings
from pathlib import Path

import httpx
import pytest
from sqlalchemy import text
from sqlalchemy.exc import IntegrityError

from app import logs
from app.accounts.models import Account
from app.database.base import new_id
from app.database.unit_of_work import unit_of_work
from app.errors import Conflict
from app.recordings.analysis.jobs import run_job
from app.recordings.models import Job, MotionSession
from tests.app.database.test_writer_lock import wait_until_up
from tests.patience import PATIENCE_S
from tests.ports import free_port

ROOT = Path(__file__).resolve().parents[2]
SECRETS = ("Ada", "Lindqvist", "therapist@", "stranger@", "a long enough password", "wrong-horse")


@pytest.fixture
def lines(settings):
    """Configure the service's logging and return a function that gives what was written, each line parsed."""
    hooks = sys.excepthook, threading.excepthook
    root = logging.getLogger()
    before = root.handlers[:], root.level
    levels = {name: logging.getLogger(name).level for name in logs.OURS}
    logs.configure(settings.model_copy(update={"log_format": "json"}))
    (handler,) = root.handlers
    written = io.StringIO()
    handler.setStream(written)
    yield lambda: [json.loads(line) for line in written.getvalue().splitlines()]
    logging.captureWarnings(False)
    root.handlers[:], root.level = before
    for name, level in levels.items():
        logging.getLogger(name).setLevel(level)
    sys.excepthook, threading.excepthook = hooks


def said(found, logger, pattern):
    return [line for line in found if line["logger"] == logger and re.search(pattern, line["message"])]


def test_a_request_is_one_line_with_the_identifier_of_its_answer(therapist, world, lines):
    answer = therapist.get(f"/api/patients/{world.patient_id}/progress?exercise_id={world.exercise_id}")
    missing = therapist.get(f"/api/patients/{new_id()}")
    identifier = answer.headers["x-request-id"]
    (line,) = said(lines(), "telemotion.access", r"GET /api/patients/\{patient_id\}/progress 200 .* ms")
    assert line["request_id"] == identifier
    assert line["level"] == "info"
    assert re.fullmatch(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d\.\d{3}Z", line["time"])
    assert missing.json()["request_id"] == missing.headers["x-request-id"] != identifier
    written = json.dumps(lines())
    assert world.patient_id not in written
    assert world.exercise_id not in written


def test_a_client_cannot_choose_the_identifier(therapist, lines):
    therapist.get("/api/me", headers={"X-Request-ID": "Ada Lindqvist"})
    assert "Ada" not in json.dumps(lines())


def test_a_session_that_loses_its_link_and_a_socket_are_told(therapist, world, services, engine, lines):
    from app.gateway import stream_of
    from estimators.simulation import ArmScenario, Schedule, simulate_arm
    from tests.app.live.streams.test_live_failures import hello, new_session, receive_until

    stream = stream_of(
        simulate_arm(ArmScenario(schedule=Schedule(n_pose_s=3.0, repetitions=1), seed=6)).recording
    )
    session_id = new_session(therapist, world.patient_id, stream)
    with therapist.websocket_connect("/ws/ingest") as socket:
        socket.send_text(hello(therapist, session_id, stream))
        receive_until(socket, lambda message: message["type"] == "acknowledge")
    deadline = threading.Event()
    for _ in range(200):
        if said(lines(), "app.live.session.session_log", f"session {session_id} is link_lost"):
            break
        deadline.wait(0.05)
    else:
        pytest.fail("not told")
    assert said(lines(), "telemotion.access", "WEBSOCKET /ws/ingest opened")
    assert said(lines(), "telemotion.access", "WEBSOCKET /ws/ingest closed after")


@pytest.mark.parametrize(
    ("error", "level"),
    [(Conflict("the session is closed"), "warning"), (ValueError("Ada Lindqvist"), "error")],
)
def test_a_failed_task_is_one_line(engine, world, settings, lines, error, level):
    with unit_of_work(engine) as session:
        motion = MotionSession(
            id=new_id(),
            clinic_id=world.clinic_id,
            patient_id=world.patient_id,
            setup={},
            state="analysed",
            created_by=world.accounts["therapist"],
        )
        session.add(motion)
        session.flush()
        job = Job(id=new_id(), session_id=motion.id, kind="reprocess", created_by=motion.created_by)
        session.add(job)
        session.flush()
        job_id = job.id

    def handler(context):
        raise error

    run_job(engine, settings, job_id, handler)
    (line,) = said(lines(), "app.recordings.analysis.jobs", f"task {job_id} \\(reprocess\\) failed")
    assert line["level"] == level
    assert "Ada" not in json.dumps(lines())


def test_exceptions_keep_their_place_and_lose_what_was_typed(engine, world, lines):
    log = logging.getLogger("app.tests")
    try:
        raise ValueError("Ada Lindqvist")
    except ValueError:
        log.exception("one")
    try:
        with unit_of_work(engine) as session:
            email = session.get(Account, world.accounts["therapist"]).email
            session.execute(text("UPDATE account SET email = :email"), {"email": email})
    except IntegrityError:
        log.exception("two")
    first, second = lines()
    assert first["exception"].endswith("builtins.ValueError")
    assert "test_logs.py" in first["exception"]
    assert "UNIQUE constraint failed: account.email" in second["exception"]
    written = json.dumps(lines())
    assert "Ada Lindqvist" not in written.replace('raise ValueError(\\"Ada Lindqvist\\")', "")
    assert email not in written


def test_libraries_below_warnings_are_not_heard_at_any_level(settings, engine, lines):
    logs.configure(settings.model_copy(update={"log_level": "debug"}))
    for name in ("sqlalchemy.engine", "websockets.server", "httpx", "numba", "asyncio"):
        assert not logging.getLogger(name).isEnabledFor(logging.INFO), name
    assert logging.getLogger("app.live.manager").isEnabledFor(logging.DEBUG)


def test_warnings_and_what_nobody_handled_are_lines_too(lines):
    with warnings.catch_warnings():
        warnings.simplefilter("always")
        warnings.warn("odd", UserWarning, stacklevel=1)
    thread = threading.Thread(target=lambda: 1 / 0)
    thread.start()
    thread.join()
    logging.getLogger("asyncio").error("Task exception was never retrieved\nfuture: ValueError('Ada')")
    found = lines()
    assert said(found, "py.warnings", "odd")
    assert "ZeroDivisionError" in said(found, "telemotion.service", "ended a thread")[0]["exception"]
    assert "Ada" not in json.dumps(found)


def test_text_is_one_line_whatever_is_in_it():
    record = logging.LogRecord("app.x", logging.WARNING, "x.py", 1, "a\nb %s", ("c\r\nd",), None)
    line = logs.TextLines().format(record)
    assert re.fullmatch(r"\S+Z warning app\.x a\\nb c\\r\\nd", line)


@pytest.mark.slow
def test_a_real_service_writes_nothing_but_lines_and_no_names(settings, world, tmp_path):
    port = free_port()
    environment = {
        **os.environ,
        "TELEMOTION_SECRET_KEY": settings.secret_key.get_secret_value(),
        "TELEMOTION_BASE_URL": f"http://127.0.0.1:{port}",
        "TELEMOTION_DATABASE_URL": settings.database_url,
        "TELEMOTION_DATA_DIR": str(settings.data_dir),
        "TELEMOTION_LOG_FORMAT": "json",
    }
    running = subprocess.Popen(
        [sys.executable, "-m", "app.cli", "serve", "--port", str(port)],
        cwd=ROOT,
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )
    try:
        wait_until_up(port, running)
        base = f"http://127.0.0.1:{port}"
        with httpx.Client(base_url=base, headers={"Origin": base}, trust_env=False) as client:
            for email, word in (
                (f"therapist@{world.clinic_id[:6]}.example", "wrong-horse"),
                ("stranger@nowhere.example", "wrong-horse"),
                (f"therapist@{world.clinic_id[:6]}.example", "a long enough password"),
            ):
                client.post("/api/sign-in", json={"email": email, "password": word})
            assert client.get(f"/api/patients/{world.patient_id}?name=Lindqvist").is_success
            assert client.get(f"/ws/live/{world.patient_id}?ticket=Lindqvist").status_code == 404
    finally:
        running.send_signal(signal.SIGTERM)
        written, _ = running.communicate(timeout=PATIENCE_S)
    found = [json.loads(line) for line in written.splitlines()]
    assert said(found, "telemotion.service", "is open at")
    assert said(found, "telemotion.service", "service is closed")
    assert said(found, "telemotion.access", "POST /api/sign-in 401")
    assert said(found, "telemotion.sign_in", "unknown address")
    assert said(found, "uvicorn.error", "Started server process")
    for secret in (*SECRETS, world.patient_id):
        assert secret not in written, secret
