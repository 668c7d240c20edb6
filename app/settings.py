"""Settings of the service, from environment variables `TELEMOTION_*` or a `.env` file.

Outside a demonstration the service refuses to start with settings that would put patients at risk; the
message names the variable and what to set. `Settings.model_fields` holds the documentation of each field; a
test fails on one without.
"""

import difflib
import hmac
import ipaddress
import math
import os
from collections.abc import Collection, Iterable
from pathlib import Path
from typing import Annotated, Literal, NamedTuple, Self
from urllib.parse import urlsplit

from pydantic import BeforeValidator, Field, SecretStr, field_validator, model_validator
from pydantic_settings import BaseSettings, NoDecode, SettingsConfigDict
from sqlalchemy import make_url
from sqlalchemy.exc import ArgumentError

from app.time_zones import is_time_zone

MINIMUM_SECRET_LENGTH = 32
PREFIX = "TELEMOTION_"
OF_COMMANDS = frozenset({"email", "password", "server", "service"})
"""Variables of commands that talk to a service; no settings of one."""
DEMO_SECRET = "demonstration only, never with real patients"  # noqa: S105 - refused outside the demonstration


class Allowance(NamedTuple):
    """How much of something may be held at once."""

    account: int
    clinic: int
    service: int


def _allowance(value: object) -> object:
    """Read `account/clinic/service`."""
    parts = value.split("/") if isinstance(value, str) else value
    try:
        numbers = Allowance(*(int(part) for part in parts))  # type: ignore[attr-defined]
    except (TypeError, ValueError) as error:
        raise ValueError("must look like 6/16/32: for one account, one clinic, the whole service") from error
    if min(numbers) < 1:
        raise ValueError("must be 1 or more each")
    return numbers


Allowed = Annotated[Allowance, NoDecode, BeforeValidator(_allowance)]


def misspelt(names: Iterable[str], known: Collection[str]) -> list[str]:
    """Return what is wrong with variables that look like settings and are none.

    Parameters
    ----------
    names : iterable of str
        Of environment variables.
    known : collection of str
        Names of settings, in lower case and without the prefix.
    """
    problems = []
    for name in sorted(names):
        short = name.removeprefix(PREFIX).lower()
        if not name.upper().startswith(PREFIX) or short in known or short in OF_COMMANDS:
            continue
        if not short.startswith("test_"):
            near = difflib.get_close_matches(short, known, 1)
            hint = f"; did you mean {PREFIX}{near[0].upper()}?" if near else ""
            problems.append(f"{name} is no setting{hint}")
    return problems


class Settings(BaseSettings):
    """How this service runs."""

    model_config = SettingsConfigDict(
        env_prefix=PREFIX, env_file=".env", extra="ignore", frozen=True, hide_input_in_errors=True
    )

    demo: bool = Field(
        default=False,
        description="Demonstration with invented patients: allows a known secret, on this machine's own address only.",
    )
    base_url: str = Field(
        default="http://127.0.0.1:8000",
        description="Address that browsers use; decides Origin checks and Secure cookies.",
    )
    allowed_hosts: str = Field(
        default="",
        description="Further names under which requests come in, separated by commas; others than these and that of"
        " TELEMOTION_BASE_URL are refused.",
    )
    secret_key: SecretStr = Field(
        default=SecretStr(""),
        description="At least 32 random characters; signs device tokens. Changing it ends all device tokens.",
    )
    database_url: str = Field(
        default="sqlite:///var/telemotion.db",
        description="sqlite:///path or postgresql://user:password@host/name.",
    )
    database_durability: Literal["process_death", "power_loss"] = Field(
        default="process_death",
        description="What a commit survives on SQLite: death of the process, or loss of power too.",
    )
    data_dir: Path = Field(
        default=Path("var"), description="Folder for files in passing, such as uploads being read."
    )
    upload_limit_bytes: int = Field(
        default=1 << 30, gt=0, description="Largest recording that may be uploaded, in bytes."
    )
    request_limit_bytes: int = Field(
        default=1 << 20, gt=0, description="Largest body of any other request, in bytes."
    )
    request_header_seconds: float = Field(
        default=10.0, gt=0, le=300, description="A connection whose request headers take longer is closed."
    )
    request_floor_bytes_per_s: float = Field(
        default=2048.0,
        gt=0,
        description="Slowest body of a request that is waited for to its end, in bytes a second.",
    )
    request_patience_seconds: float = Field(
        default=30.0,
        gt=0,
        le=3600,
        description="A body that stops, or is slower than the floor, for so long is refused with 408.",
    )
    sign_in_idle_minutes: int = Field(
        default=60,
        ge=1,
        le=1440,
        description="A browser session ends after this long without use of keyboard, mouse or touch.",
    )
    sign_in_hours: int = Field(
        default=12, ge=1, le=168, description="A browser session ends after this long in any case."
    )
    staff_second_factor: Literal["optional", "required"] = Field(
        default="optional",
        description="Whether therapists and administrators must use an authenticator app to sign in.",
    )
    hemisphere: Literal["north", "south", "unknown"] = Field(
        default="north",
        description="Of the place where sensors stream: the magnetic field points down in the north, up in the south.",
    )
    time_zone: str = Field(
        default="UTC",
        description="Where clinics are that have not set their own, e.g. Europe/Oslo; weeks of exercises begin there.",
    )
    implant_confirmation_hours: int = Field(
        default=12,
        ge=1,
        le=168,
        description="That nobody near a magnetic source has an implant is asked again after this long.",
    )
    job_workers: int = Field(
        default=2,
        ge=1,
        le=64,
        description="Analyses at once; one clinic takes at most all but one of them, so that no other has to wait.",
    )
    job_memory_bytes: int = Field(
        default=3 << 30,
        ge=1 << 30,
        description="Most memory that one analysis or export may take, in bytes; beyond it it fails with a message.",
    )
    limit_views: Allowed = Field(
        default=Allowance(6, 16, 32),
        description="3D views at once: of one account / of one clinic / of the whole service.",
    )
    limit_streams: Allowed = Field(
        default=Allowance(32, 64, 128),
        description="Body networks that stream at once: of one account or device token / clinic / service.",
    )
    limit_sockets: Allowed = Field(
        default=Allowance(40, 120, 400),
        description="Live views at once: of one account / of one clinic / of the whole service.",
    )
    limit_uploads: Allowed = Field(
        default=Allowance(3, 8, 16),
        description="Uploads that arrive at once: of one account or device token / clinic / service.",
    )
    limit_exports: Allowed = Field(
        default=Allowance(1, 2, 2),
        description="Exports that are made at once: of one account / of one clinic / of the whole service.",
    )
    stream_speed_limit: float = Field(
        default=3.0,
        gt=1.0,
        description="A body network is read at most so many times faster than real time; no limit in a demonstration.",
    )
    session_limit_hours: float = Field(
        default=24.0, gt=0.0, description="A live session is closed and analysed after this long."
    )
    clinic_disk_bytes: int = Field(
        default=200 << 30,
        gt=0,
        description="Signals and waiting files that one clinic may have, in bytes; then it can start no session."
        " Uploads may use nine tenths of it: the rest stays free for live sessions.",
    )
    disk_reserve_bytes: int = Field(
        default=1 << 30,
        ge=0,
        description="Free space on the disk of TELEMOTION_DATA_DIR that uploads leave to live packets, in bytes.",
    )
    nats_url: SecretStr = Field(
        default=SecretStr("nats://127.0.0.1:4222"),
        description="Of an edge or worker: addresses of NATS servers, separated by commas; tls:// for TLS.",
    )
    nats_edge_url: SecretStr = Field(
        default=SecretStr(""),
        description="Of `telemotion nats-config`: what each edge has as TELEMOTION_NATS_URL, separated by commas;"
        " a user of its own for each.",
    )
    nats_credentials: Path | None = Field(
        default=None,
        description="File for NATS: .creds, or the private NKEY of a user; none where the address has a password.",
    )
    nats_ca: Path | None = Field(
        default=None, description="Certificate authority of the NATS servers; by default those of the system."
    )
    mqtt: bool = Field(
        default=False,
        description="Of an edge or worker: take gateways by MQTT, through NATS servers of `telemotion nats-config`.",
    )
    partitions: int = Field(
        default=8,
        ge=1,
        le=1024,
        description="Parts into which live sessions are divided among workers; the same for all edges and workers.",
    )
    lease_seconds: float = Field(
        default=1.5,
        ge=0.5,
        le=60,
        description="A worker that is not heard of for so long loses its partitions.",
    )
    drain_seconds: float = Field(
        default=20.0,
        ge=0,
        le=3600,
        description="An edge that is stopped sends gateways and views to others within so long, one after the other.",
    )
    stream_replicas: int = Field(
        default=1,
        ge=1,
        le=5,
        description="On how many NATS servers a packet must be before it is acknowledged.",
    )
    stream_bytes: int = Field(
        default=4 << 30,
        ge=1 << 20,
        description="Most that waits in a partition's stream, in bytes; then gateways wait.",
    )
    client_dir: Path | None = Field(
        default=None, description="Built browser client; by default web/dist of the tree or the packaged one."
    )
    log_level: Literal["debug", "info", "warning", "error"] = Field(
        default="info", description="Least severe message that is logged."
    )
    trusted_proxies: str = Field(
        default="127.0.0.1,::1",
        description="Addresses or networks of the proxies whose X-Forwarded-For is believed, separated by commas.",
    )
    metrics_token: SecretStr = Field(
        default=SecretStr(""),
        description="Who sends it as `Authorization: Bearer` may read /metrics; at least 32 characters.",
    )
    log_format: Literal["text", "json"] = Field(
        default="text", description="Lines for people, or one JSON object a line for programs."
    )

    @field_validator("base_url")
    @classmethod
    def _check_base_url(cls, value: str) -> str:
        parts = urlsplit(value)
        if parts.scheme not in {"http", "https"} or not parts.hostname or parts.path not in {"", "/"}:
            raise ValueError("TELEMOTION_BASE_URL must look like https://motion.example.org, without a path")
        return value.rstrip("/")

    @field_validator("database_url")
    @classmethod
    def _check_database_url(cls, value: str) -> str:
        try:
            backend = make_url(value).get_backend_name()
        except ArgumentError as error:
            raise ValueError(
                "TELEMOTION_DATABASE_URL must look like sqlite:///var/telemotion.db or postgresql://user@host/name"
            ) from error
        if backend not in {"sqlite", "postgresql"}:
            raise ValueError("TELEMOTION_DATABASE_URL must name sqlite or postgresql")
        return value

    @field_validator("time_zone")
    @classmethod
    def _check_time_zone(cls, value: str) -> str:
        if not is_time_zone(value):
            raise ValueError("TELEMOTION_TIME_ZONE must be the name of a time zone, for instance Europe/Oslo")
        return value

    @field_validator("trusted_proxies")
    @classmethod
    def _check_trusted_proxies(cls, value: str) -> str:
        for part in filter(None, (part.strip() for part in value.split(","))):
            try:
                network = ipaddress.ip_network(part, strict=False)
            except ValueError as error:
                raise ValueError(
                    "TELEMOTION_TRUSTED_PROXIES must hold addresses or networks, e.g. 127.0.0.1,172.30.77.1"
                ) from error
            if network.prefixlen == 0:
                raise ValueError(
                    "TELEMOTION_TRUSTED_PROXIES would believe everybody, and anybody could forge the address that"
                    " limits on sign-ins count"
                )
        return value

    @model_validator(mode="after")
    def _refuse_unsafe(self) -> Self:
        problems = self._problems_everywhere()
        problems += self._problems_of_demo() if self.demo else self._problems_outside_demo()
        if problems:
            raise ValueError("refusing to start: " + "; ".join(problems))
        return self

    def _problems_everywhere(self) -> list[str]:
        problems = misspelt(os.environ, set(type(self).model_fields))
        token = self.metrics_token.get_secret_value()
        if token and len(token) < MINIMUM_SECRET_LENGTH:
            problems.append(f"TELEMOTION_METRICS_TOKEN must hold at least {MINIMUM_SECRET_LENGTH} characters")
        url = make_url(self.database_url)
        if url.get_backend_name() == "sqlite" and url.database in {None, "", ":memory:"}:
            problems.append(
                "TELEMOTION_DATABASE_URL is an in-memory database, which would forget every patient "
                "and cannot be shared between threads; name a file"
            )
        return problems

    def _problems_of_demo(self) -> list[str]:
        if self.is_loopback:
            return []
        return [
            "TELEMOTION_BASE_URL must name this machine, for instance http://127.0.0.1:8000, while TELEMOTION_DEMO is "
            "on: everybody knows the passwords and the secret of a demonstration"
        ]

    def _problems_outside_demo(self) -> list[str]:
        problems = []
        secret = self.secret_key.get_secret_value()
        if len(secret) < MINIMUM_SECRET_LENGTH or len(set(secret)) < 10:
            problems.append(
                f"TELEMOTION_SECRET_KEY must hold at least {MINIMUM_SECRET_LENGTH} random characters, "
                "e.g. from `python -c 'import secrets; print(secrets.token_urlsafe(48))'`"
            )
        if secret == DEMO_SECRET:
            problems.append("TELEMOTION_SECRET_KEY is the one of the demonstration, which everybody knows")
        if not self.is_https and not self.is_loopback:
            problems.append(
                "TELEMOTION_BASE_URL must begin with https://, because sign-in cookies and movement data "
                "would travel in clear; only this machine's own address may use http"
            )
        return problems

    @property
    def stream_speed(self) -> float:
        """How many seconds of signal are read from one body network in a second."""
        return math.inf if self.demo else self.stream_speed_limit

    @property
    def is_https(self) -> bool:
        """Whether browsers reach the service over TLS."""
        return self.base_url.startswith("https://")

    @property
    def is_loopback(self) -> bool:
        """Whether `base_url` names this machine only."""
        host = urlsplit(self.base_url).hostname or ""
        if host == "localhost":
            return True
        try:
            return ipaddress.ip_address(host).is_loopback
        except ValueError:
            return False

    @property
    def signing_secret(self) -> str:
        """The secret in force; the well-known one only in a demonstration without its own."""
        return self.secret_key.get_secret_value() or DEMO_SECRET

    def key_for(self, purpose: str) -> bytes:
        """Return a key for one purpose from the service's secret, so one leaked use does not open another.

        Parameters
        ----------
        purpose : str
            A fixed word, e.g. `device-token`.
        """
        secret = self.signing_secret.encode()
        return hmac.digest(secret, f"telemotion/{purpose}/1".encode(), "sha256")
