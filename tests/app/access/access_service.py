"""The running service over a copy of the seeded database, and a client for everybody in the access table."""

import json
import re
import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import httpx
import pytest
from sqlalchemy import Engine, select

from app.accounts.credentials.passwords import Passwords
from app.accounts.credentials.sign_in import COOKIE, create_sign_in
from app.accounts.credentials.tokens import new_token
from app.database.base import new_id
from app.database.engine import create_from_url
from app.database.unit_of_work import unit_of_work
from app.live import warmup
from app.main import create_app
from app.recordings.analysis.jobs import JobRunner
from app.settings import Settings
from app.tables import metadata
from tests.app.conftest import BASE_URL, ServiceClient

from .access_seed import Seed
from .access_table import Line

UNCHECKED_TABLES = {"audit_event", "sign_in", "ticket", "job", "alembic_version"}
"""Refusals are audited, cookies are touched; jobs run by themselves."""


def make_settings(folder: Path, database: Path) -> Settings:
    return Settings(
        _env_file=None,
        base_url=BASE_URL,
        secret_key="0123456789abcdefghijklmnopqrstuvwxyz-tests",
        database_url=f"sqlite:///{database}",
        data_dir=folder / "var",
    )


class AccessService:
    """A running service in which everybody of the seed can make the requests of the table."""

    def __init__(
        self, seed: Seed, settings: Settings, engine: Engine, nobody: ServiceClient, log: bytes
    ) -> None:
        self.seed, self.settings, self.engine = seed, settings, engine
        self._log = log
        self._people = {"nobody": nobody}
        self._view = ""

    @property
    def routes(self) -> Any:
        return self._people["nobody"].app.routes

    def person(self, name: str) -> ServiceClient:
        """Return the client of somebody; each is made once."""
        if name not in self._people:
            self._people[name] = self._make(name)
        return self._people[name]

    def _make(self, name: str) -> ServiceClient:
        nobody = self._people["nobody"]
        client = ServiceClient(nobody.app, base_url=BASE_URL, raise_server_exceptions=False)
        client.portal = nobody.portal
        if name in self.seed.tokens:
            client.headers["Authorization"] = f"Bearer {self.seed.tokens[name]}"
            return client
        cookie = csrf_token = new_token()
        if name != "forged_cookie":
            with unit_of_work(self.engine) as session:
                account_id = self.seed.world.accounts[name]
                cookie, row = create_sign_in(session, self.settings, account_id, "tests")
                csrf_token = row.csrf_token
        client.cookies.set(COOKIE, cookie)
        client.headers.update({"Origin": BASE_URL, "X-CSRF-Token": csrf_token})
        return client

    def view(self) -> str:
        """Return a view of Ada's session that the therapist has opened, the same as long as the service runs."""
        if not self._view:
            path = f"/api/sessions/{self.seed.own['session_id']}/views"
            answer = self.person("therapist").post(path, json={"mode": "replay"})
            assert answer.status_code == 201, answer.text
            self._view = answer.json()["id"]
        return self._view

    def prepare(self, line: Line) -> None:
        """Bring about what a line's request needs to succeed."""
        if line.prepare == "view":
            self.send("therapist", line)
        if line.prepare == "archive":
            path = f"/api/patients/{self.seed.own['patient_id']}"
            assert self.person("therapist").patch(path, json={"is_archived": True}).status_code == 200

    def send(self, name: str, line: Line, exists: bool = True) -> httpx.Response:
        """Send a line's request as somebody, with Ada's identifiers or with ones that do not exist."""
        names = self.names(line)
        if not exists:
            names = {key: value if key == "exercise_id" else new_id() for key, value in names.items()}
        fill = self.filler(names)
        arguments: dict[str, Any] = {"params": {key: fill(value) for key, value in line.query.items()}}
        body = json.loads(fill(json.dumps(line.body)))
        if line.files:
            arguments["files"] = [
                ("declaration", (None, json.dumps(body), "application/json")),
                ("file", ("movement.tmlog", self._log, "application/octet-stream")),
            ]
        elif line.body is not None:
            arguments["json"] = body
        return self.person(name).request(line.method, fill(line.path), **arguments)

    def names(self, line: Line) -> dict[str, str]:
        names = dict(self.seed.own)
        if line.prepare == "view":
            names["view_id"] = self.view()
        return names

    def filler(self, names: dict[str, str]) -> Callable[[str], str]:
        def value(match: re.Match[str]) -> str:
            kind, _, name = match[1].rpartition(":")
            if kind == "foreign":
                return self.seed.foreign[name]
            if kind == "account":
                return self.seed.world.accounts[name]
            return names[name]

        return lambda text: re.sub(r"\{((?:foreign:|account:)?[a-z_]+)\}", value, text)

    def stored(self) -> dict[str, Any]:
        """Return everything in the database that a stranger must not change."""
        with self.engine.connect() as connection:
            return {
                table.name: connection.execute(select(table).order_by(*table.primary_key.columns)).all()
                for table in metadata.sorted_tables
                if table.name not in UNCHECKED_TABLES
            }


@contextmanager
def running(
    seed: Seed, folder: Path, log: bytes, passwords: Passwords, warm_up: Callable[[warmup.Kind], None]
) -> Iterator[AccessService]:
    """Run a service over a fresh copy of the seeded database.

    Its queue of long tasks stands still: that they begin is a matter of other tests, and each would start a worker
    process of its own.
    """
    shutil.copy(seed.file, folder / "telemotion.db")
    settings = make_settings(folder, folder / "telemotion.db")
    engine = create_from_url(settings.database_url)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(warmup, "load_or_compile", warm_up)
        patch.setattr(warmup, "PATIENCE_S", 600.0)
        app = create_app(settings, passwords=passwords)
        with ServiceClient(app, base_url=BASE_URL, raise_server_exceptions=False) as nobody:
            app.state.services.get(JobRunner).stop()
            yield AccessService(seed, settings, engine, nobody, log)
    engine.dispose()
