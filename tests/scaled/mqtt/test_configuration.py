"""The configuration of a NATS server is one that the server takes, and what is secret in it stays so."""

import base64
import json
import stat
import subprocess
from pathlib import Path

import pytest
from cryptography.exceptions import InvalidSignature
from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PublicKey
from typer.testing import CliRunner

pytest.importorskip("nats", reason="the extra `scaled` is not installed")

from app.cli import cli
from app.errors import InvalidInput
from app.scaled.mqtt.issuer import Issuer, claims_of
from tests.scaled.cluster import SERVER

SECRET = "only-for-tests-0123456789-abcdefghijkl"


@pytest.fixture(autouse=True)
def settings(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TELEMOTION_SECRET_KEY", SECRET)
    monkeypatch.setenv("TELEMOTION_NATS_URL", "nats://worker:pass-word@127.0.0.1:4222")
    monkeypatch.setenv("TELEMOTION_NATS_EDGE_URL", "nats://edge-1:a-word@127.0.0.1:4222")


def test_the_command_writes_what_the_server_takes_and_only_its_owner_reads(tmp_path: Path) -> None:
    file = tmp_path / "nats.conf"
    file.write_text("of an earlier run")
    file.chmod(0o644)
    words = ["nats-config", str(file), "--store", str(tmp_path / "nats"), "--name", "first"]
    assert CliRunner().invoke(cli, words).exit_code == 0
    assert stat.S_IMODE(file.stat().st_mode) == 0o600
    assert SECRET not in file.read_text()
    checked = subprocess.run([SERVER, "-t", "-c", str(file)], capture_output=True, text=True)
    assert checked.returncode == 0, checked.stderr


def test_a_server_without_a_password_is_not_configured(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("TELEMOTION_NATS_URL", "nats://127.0.0.1:4222")
    failed = CliRunner().invoke(cli, ["nats-config", str(tmp_path / "nats.conf")])
    assert isinstance(failed.exception, InvalidInput)
    assert not (tmp_path / "nats.conf").exists()


def test_a_right_is_signed_by_the_key_that_is_named() -> None:
    issuer = Issuer(bytes(range(32)))
    token = issuer.sign({"sub": "somebody"})
    claims = claims_of(token.encode())
    assert (claims["iss"], claims["sub"]) == (issuer.public, "somebody")
    raw = base64.b32decode(issuer.public)
    assert issuer.public.startswith("A")
    key = Ed25519PublicKey.from_public_bytes(raw[1:33])
    signed, _, signature = token.rpartition(".")
    key.verify(base64.urlsafe_b64decode(signature + "=="), signed.encode())
    with pytest.raises(InvalidSignature):
        key.verify(base64.urlsafe_b64decode(signature + "=="), signed.encode() + b"x")
    assert json.loads(base64.urlsafe_b64decode(signed.split(".")[0] + "=="))["alg"] == "ed25519-nkey"
    with pytest.raises(ValueError, match="no JWT"):
        claims_of(b"x")
