"""Settings: documented, and unsafe ones refuse to start."""

import asyncio
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from pydantic import ValidationError

from app.settings import DEMO_SECRET, Settings

SECRET = "0123456789abcdefghijklmnopqrstuvwxyz-tests"


def make(**fields):
    return Settings(_env_file=None, **({"secret_key": SECRET} | fields))


def test_every_setting_is_documented():
    for name, field in Settings.model_fields.items():
        assert field.description, f"{name} has no description"
        assert field.description.endswith("."), name


@pytest.mark.parametrize(
    ("fields", "names"),
    [
        ({"secret_key": ""}, "TELEMOTION_SECRET_KEY"),
        ({"secret_key": "short"}, "TELEMOTION_SECRET_KEY"),
        ({"secret_key": "a" * 64}, "TELEMOTION_SECRET_KEY"),
        ({"secret_key": DEMO_SECRET}, "TELEMOTION_SECRET_KEY"),
    ],
)
def test_unsafe_settings_start_in_a_demonstration_only(fields, names):
    with pytest.raises(ValidationError, match=names):
        make(**fields)
    assert make(demo=True, **fields).demo


@pytest.mark.parametrize("demo", [False, True])
@pytest.mark.parametrize(
    ("fields", "names"),
    [
        ({"database_url": "sqlite://"}, "TELEMOTION_DATABASE_URL"),
        ({"database_url": "sqlite:///:memory:"}, "TELEMOTION_DATABASE_URL"),
        ({"database_url": "mysql://root@localhost/x"}, "TELEMOTION_DATABASE_URL"),
        ({"database_url": "rubbish"}, "TELEMOTION_DATABASE_URL"),
        ({"base_url": "https://clinic.example.org/app"}, "TELEMOTION_BASE_URL"),
        ({"base_url": "clinic.example.org"}, "TELEMOTION_BASE_URL"),
        ({"base_url": "http://clinic.example.org"}, "TELEMOTION_BASE_URL"),
        ({"base_url": "http://192.168.1.4:8000"}, "TELEMOTION_BASE_URL"),
    ],
)
def test_what_cannot_work_never_starts(fields, names, demo):
    with pytest.raises(ValidationError, match=names):
        make(demo=demo, **fields)


@pytest.mark.parametrize("secret", ["", SECRET])
def test_a_demonstration_is_open_on_this_machine_only(secret):
    with pytest.raises(ValidationError, match=r"TELEMOTION_BASE_URL must name this machine.*TELEMOTION_DEMO"):
        make(demo=True, secret_key=secret, base_url="https://clinic.example.org")
    for address in ("https://localhost:8443", "http://127.0.0.1:8000", "http://[::1]:8000"):
        assert make(demo=True, secret_key=secret, base_url=address).demo


def test_safe_settings_start():
    assert make(base_url="https://clinic.example.org/").base_url == "https://clinic.example.org"
    assert make(base_url="http://localhost:8000").is_loopback
    assert make(base_url="http://[::1]:8000").is_loopback


def test_the_secret_does_not_show_itself():
    settings = make()
    assert SECRET not in repr(settings)
    assert SECRET not in settings.model_dump_json()


def test_a_refusal_does_not_print_the_secret(tmp_path):
    environment = {"PATH": os.environ["PATH"], "TELEMOTION_SECRET_KEY": "short-but-secret"}
    done = subprocess.run(
        [sys.executable, "-c", "from app.settings import Settings; Settings(_env_file=None)"],
        env=environment | {"PYTHONPATH": os.getcwd()},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode != 0
    assert "refusing to start" in done.stderr
    assert "short-but-secret" not in done.stderr


def test_a_misspelt_setting_refuses_to_start_with_the_nearest_name(monkeypatch):
    monkeypatch.setenv("TELEMOTION_DATABSE_URL", "sqlite:///elsewhere.db")
    with pytest.raises(
        ValidationError, match="TELEMOTION_DATABSE_URL is no setting; did you mean TELEMOTION_DATABASE_URL"
    ):
        make()
    monkeypatch.delenv("TELEMOTION_DATABSE_URL")
    monkeypatch.setenv("TELEMOTION_PASSWORD", "of a command")
    make()


@pytest.mark.parametrize("value", ["*", "0.0.0.0/0", "::/0", "proxy", "127.0.0.1,*"])
def test_no_setting_believes_every_proxy(value):
    with pytest.raises(ValidationError, match="TELEMOTION_TRUSTED_PROXIES"):
        make(trusted_proxies=value)


def test_compose_believes_its_own_gateway_only():
    compose = (Path(__file__).resolve().parents[2] / "docker" / "compose.yaml").read_text()
    assert "FORWARDED_ALLOW_IPS" not in compose
    (trusted,) = re.findall(r'TELEMOTION_TRUSTED_PROXIES: "(.*)"', compose)
    assert make(trusted_proxies=trusted).trusted_proxies == re.findall(r"gateway: (.*)", compose)[0]


@pytest.mark.parametrize(("peer", "seen"), [("172.30.77.1", "203.0.113.9"), ("198.51.100.4", "198.51.100.4")])
def test_a_forged_client_address_is_not_believed(peer, seen):
    """The proxy appends whom it saw; what stands before it was written by the client."""
    from uvicorn.middleware.proxy_headers import ProxyHeadersMiddleware

    found = []

    async def application(scope, receive, send):
        found.append(scope["client"][0])

    scope = {
        "type": "http",
        "client": (peer, 4711),
        "headers": [(b"x-forwarded-for", b"10.0.0.1, 127.0.0.1, 203.0.113.9")],
    }
    settings = make(trusted_proxies="172.30.77.1")
    asyncio.run(ProxyHeadersMiddleware(application, settings.trusted_proxies)(scope, None, None))
    assert found == [seen]
