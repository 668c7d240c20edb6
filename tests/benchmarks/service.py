"""The real service for benchmarks: a database with therapists and patients, and a process that serves it."""

import functools
import os
import subprocess
import sys
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import httpx
from sqlalchemy.orm import Session

from app import tables as tables
from app.accounts.consents import set_consent
from app.accounts.credentials.passwords import Passwords
from app.accounts.models import Account, Clinic
from app.database import migrate
from app.database.base import new_id
from app.database.engine import create_from_url
from app.database.unit_of_work import unit_of_work
from app.gateway import DeviceStream, ServiceClient
from app.patients.models import Grant, Mounting, Patient
from app.recordings.schemas import SessionIn

ROOT = Path(__file__).resolve().parents[2]
SECRET = "bench-only-0123456789-abcdefghijklmnopq"
EMAIL, PASSWORD = "therapist@bench.example", "a long enough password"
ROOMY = {
    "TELEMOTION_LIMIT_STREAMS": "1000/1000/1000",
    "TELEMOTION_LIMIT_SOCKETS": "1000/1000/1000",
}
"""Settings of a service all of whose sessions are those of one account."""


def make_patient(folder: Path, calibration: dict[str, Any] | None = None) -> tuple[str, str]:
    """Make the database with one patient who may be streamed; return its URL and the patient."""
    url = f"sqlite:///{folder / 'bench.db'}"
    migrate.upgrade(url)
    engine = create_from_url(url)
    with unit_of_work(engine) as session:
        patient_id = add_patient(session, add_clinic(session), EMAIL, calibration)
    engine.dispose()
    return url, patient_id


def add_clinic(session: Session) -> str:
    """Add a clinic and return its id."""
    clinic = Clinic(id=new_id(), name="Bench")
    session.add(clinic)
    session.flush()
    return clinic.id


def add_patient(
    session: Session, clinic_id: str, email: str, calibration: dict[str, Any] | None = None
) -> str:
    """Add a therapist with a patient who has agreed to everything; return the patient."""
    patient = Patient(id=new_id(), clinic_id=clinic_id, given_name="B", family_name="B", body_dimensions={})
    account = Account(
        id=new_id(),
        clinic_id=clinic_id,
        role="therapist",
        email=email,
        display_name="Bench",
        password_hash=Passwords().hash(PASSWORD),
    )
    session.add_all([patient, account])
    session.flush()
    session.add(Grant(patient_id=patient.id, account_id=account.id, level="treat", granted_by=account.id))
    if calibration is not None:
        session.add(Mounting(patient_id=patient.id, calibration=calibration, session_id=new_id()))
    for purpose in ("treatment", "home_streaming"):
        set_consent(session, patient.id, purpose, True, account.id)
    return patient.id


def environment_of(url: str, folder: Path, port: int, settings: Mapping[str, str] = ROOMY) -> dict[str, str]:
    """Return the environment of a service that serves this database at this port."""
    return os.environ | {
        "TELEMOTION_DATABASE_URL": url,
        "TELEMOTION_SECRET_KEY": SECRET,
        "TELEMOTION_BASE_URL": f"http://127.0.0.1:{port}",
        "TELEMOTION_DATA_DIR": str(folder),
        "TELEMOTION_LOG_LEVEL": "warning",
        "PYTHONPATH": str(ROOT),
        "OPENBLAS_NUM_THREADS": "1",
        **settings,
    }


@functools.cache
def compile_usual() -> None:
    """Compile what live sessions need, so that a service finds it in the cache; once a process of tests is enough."""
    code = "from app.live.warmup import usual, warm_up\nfor kind in usual():\n    warm_up(kind)"
    subprocess.run([sys.executable, "-c", code], cwd=ROOT, check=True)


def launch(environment: Mapping[str, str], before: str = "") -> subprocess.Popen[bytes]:
    """Start the process of a service; `before` is code that it runs first."""
    port = int(environment["TELEMOTION_BASE_URL"].rsplit(":", 1)[1])
    code = f"{before}\nfrom app.commands.serve import serve; serve('127.0.0.1', {port})"
    return subprocess.Popen([sys.executable, "-c", code], env=environment, cwd=ROOT)


def wait_until(
    process: subprocess.Popen[bytes], address: str, path: str = "/api/health", patience_s: float = 120.0
) -> None:
    """Return when a service answers a path with success."""
    deadline = time.monotonic() + patience_s
    while time.monotonic() < deadline:
        try:
            if httpx.get(f"{address}{path}", trust_env=False, timeout=patience_s).is_success:
                return
        except httpx.TransportError:
            pass
        time.sleep(0.05)
        if process.poll() is not None:
            raise RuntimeError("the service did not start")
    process.kill()
    raise TimeoutError("the service did not answer")


def start_server(
    url: str, folder: Path, port: int, before: str = "", settings: Mapping[str, str] = ROOMY
) -> subprocess.Popen[bytes]:
    """Start the service; `before` is code that it runs first. What live sessions need is compiled before that."""
    environment = environment_of(url, folder, port, settings)
    compile_usual()
    process = launch(environment, before)
    wait_until(process, environment["TELEMOTION_BASE_URL"])
    return process


async def open_sessions(
    port: int, patient_id: str, stream: DeviceStream, count: int, email: str = EMAIL
) -> list[dict[str, str]]:
    """Create the sessions and get their tickets."""
    async with ServiceClient(f"http://127.0.0.1:{port}") as client:
        await client.sign_in(email, PASSWORD)
        wanted = SessionIn(patient_id=patient_id, placements=list(stream.placements))  # type: ignore[arg-type]
        sessions = []
        for _ in range(count):
            made = await client.create_session(wanted)
            assert made.calibration is not None, "the sessions must be calibrated, else little is estimated"
            sessions.append({"id": made.id})
            sessions[-1]["ingest"] = await client.ticket(made.id, "ingest")
            sessions[-1]["live"] = await client.ticket(made.id, "live")
        return sessions


async def new_ticket(port: int, session_id: str) -> str:
    """Get a gateway's ticket once more."""
    async with ServiceClient(f"http://127.0.0.1:{port}") as client:
        await client.sign_in(EMAIL, PASSWORD)
        return await client.ticket(session_id, "ingest")
