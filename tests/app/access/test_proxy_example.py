"""The example of a proxy fits the service: its settings exist, its names are let in, its paths carry all sockets."""

import re
import secrets
from pathlib import Path

import pytest
from starlette.routing import WebSocketRoute

from app.edge.hosts import KnownHosts
from app.ingest.upload import MULTIPART_SLACK_BYTES
from app.main import all_routers
from app.settings import Settings

ROOT = Path(__file__).resolve().parents[3]
TEXT = (ROOT / "docker" / "nginx.conf").read_text()
CONFIGURATION = re.sub(r"^\s*#.*$", "", TEXT, flags=re.M)
GIVEN = dict(re.findall(r"^#\s+(TELEMOTION_\w+)=(\S+)$", TEXT, flags=re.M))
SIZES = {"k": 1 << 10, "m": 1 << 20, "g": 1 << 30}
UPGRADE = ("proxy_http_version 1.1;", "Upgrade $http_upgrade;", "Connection $connection_upgrade;")


@pytest.fixture
def settings(monkeypatch: pytest.MonkeyPatch) -> Settings:
    """As the service reads what the example says it must have."""
    for name, value in GIVEN.items():
        monkeypatch.setenv(name, value)
    monkeypatch.setenv("TELEMOTION_SECRET_KEY", secrets.token_urlsafe(48))
    return Settings(_env_file=None)


def names() -> set[str]:
    return {name for line in re.findall(r"server_name ([^;]+);", CONFIGURATION) for name in line.split()}


@pytest.mark.parametrize("page", ["docker/nginx.conf", "docs/operations.md", "docker/compose.yaml"])
def test_every_setting_that_is_named_exists(page: str) -> None:
    # `TELEMOTION_PASSWORD` is read by a command, never by the service.
    known = {f"TELEMOTION_{name.upper()}" for name in Settings.model_fields} | {"TELEMOTION_PASSWORD"}
    assert set(re.findall(r"\bTELEMOTION_[A-Z0-9_]*[A-Z0-9]\b", (ROOT / page).read_text())) <= known


def test_the_service_starts_with_what_the_example_gives(settings: Settings) -> None:
    assert set(GIVEN) == {
        "TELEMOTION_BASE_URL",
        "TELEMOTION_ALLOWED_HOSTS",
        "TELEMOTION_TRUSTED_PROXIES",
    }
    assert settings.base_url.startswith("https://")


def test_the_service_answers_to_each_name_of_the_proxy_and_to_no_other(settings: Settings) -> None:
    async def nothing(*_: object) -> None: ...

    hosts = KnownHosts(nothing, settings)
    assert len(names()) == 2
    assert all(hosts._is_known(name, "/") for name in names())
    assert not hosts._is_known("evil.example", "/")
    assert "proxy_set_header Host $host;" in CONFIGURATION


def test_every_socket_of_the_service_is_upgraded_and_waits() -> None:
    sockets = [
        route.path for router in all_routers() for route in router.routes if isinstance(route, WebSocketRoute)
    ]
    assert len(sockets) >= 4
    (place,) = re.findall(r"location ~ (\S+) \{([^}]*)\}", CONFIGURATION)
    for path in sockets:
        assert re.match(place[0], path), path
    assert "proxy_read_timeout 1h;" in place[1]
    assert all(line in CONFIGURATION for line in UPGRADE)
    # A place with headers of its own would have none of those above.
    assert "proxy_set_header" not in "".join(re.findall(r"location [^{]*\{([^}]*)\}", CONFIGURATION))


def test_the_largest_upload_passes_and_arrives_as_it_is_sent(settings: Settings) -> None:
    ((number, unit),) = re.findall(r"client_max_body_size (\d+)([kmg]);", CONFIGURATION)
    assert int(number) * SIZES[unit] >= settings.upload_limit_bytes + MULTIPART_SLACK_BYTES
    assert "proxy_request_buffering off;" in CONFIGURATION
    assert "proxy_buffering off;" in CONFIGURATION


def test_a_sender_cannot_say_another_address() -> None:
    assert "proxy_set_header X-Forwarded-For $remote_addr;" in CONFIGURATION
