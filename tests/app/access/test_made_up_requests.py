"""Schemathesis with all its checks over every route: nothing answers what the description does not say."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from app.accounts.credentials.sign_in import create_sign_in
from app.database import migrate
from app.database.engine import create_from_url
from app.database.unit_of_work import unit_of_work
from app.edge.description import describe
from app.live import warmup
from app.main import create_app
from app.settings import Settings
from tests.app.serving import serving
from tests.ports import free_port

from .access_seed import build_seed

HERE = Path(__file__).parent
EXAMPLES_PER_ROUTE = 4
LEFT_OUT = ("/api/sign-out", "/api/me/password")
"""They end the sign-in that all other requests use; their own tests are in test_sign_in.py."""


@pytest.mark.slow("each of some two hundred routes gets made-up requests")
@pytest.mark.parametrize(
    ("database", "phases"),
    [
        ("sqlite", "examples,fuzzing"),
        # The stricter of the two gets the edges of every type: numbers that overflow, text with zero bytes.
        pytest.param("postgresql", "coverage", marks=pytest.mark.postgres),
    ],
)
def test_every_answer_is_described(database, phases, tmp_path, request, cheap_passwords, monkeypatch):
    url = f"sqlite:///{tmp_path / 'telemotion.db'}"
    if database == "postgresql":
        url = request.getfixturevalue("postgresql_database")()
    migrate.upgrade(url)
    port = free_port()
    settings = Settings(
        _env_file=None,
        base_url=f"http://127.0.0.1:{port}",
        secret_key="0123456789abcdefghijklmnopqrstuvwxyz-tests",
        database_url=url,
        data_dir=tmp_path / "var",
    )
    seed = build_seed(settings, cheap_passwords, tmp_path)
    engine = create_from_url(url)
    with unit_of_work(engine) as session:
        cookie, row = create_sign_in(session, settings, seed.world.accounts["therapist"], "tests")
        csrf_token = row.csrf_token
    engine.dispose()
    # Nothing is streamed here.
    monkeypatch.setattr(warmup, "load_or_compile", lambda kind: None)
    app = create_app(settings, passwords=cheap_passwords)
    (tmp_path / "openapi.json").write_text(json.dumps(describe(app)))
    (tmp_path / "known.json").write_text(json.dumps(seed.own))
    command = [
        *(sys.executable, "-m", "schemathesis.cli", "--config-file", HERE / "schemathesis.toml"),
        *("run", tmp_path / "openapi.json", "--url", settings.base_url),
        *("--checks", "all", "--phases", phases, "-n", str(EXAMPLES_PER_ROUTE)),
        *("--continue-on-failure", "--warnings", "off", "--no-color"),
        *(word for path in LEFT_OUT for word in ("--exclude-path", path)),
    ]
    environment = os.environ | {
        "TELEMOTION_TEST_ORIGIN": settings.base_url,
        "TELEMOTION_TEST_CSRF": csrf_token,
        "TELEMOTION_TEST_COOKIE": cookie,
        "TELEMOTION_TEST_KNOWN": str(tmp_path / "known.json"),
        "SCHEMATHESIS_HOOKS": "tests.app.access.made_up_requests",
        "PYTHONPATH": str(HERE.parents[2]),
    }
    with serving(app, port):
        done = subprocess.run(
            command, env=environment, cwd=tmp_path, capture_output=True, text=True, check=False
        )
    print(done.stdout[-20_000:], done.stderr[-5_000:])
    assert done.returncode == 0
