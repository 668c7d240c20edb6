"""A NATS server whose users come with credentials that an operator's account has signed, or with an NKEY."""

import base64
import binascii
import json
import os
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey

from app.scaled.credentials import Kind, public_text
from app.scaled.mqtt.issuer import Issuer
from tests.patience import PATIENCE_S
from tests.scaled.cluster import SERVER

ALL = -1
MESSAGES = ("subs", "data", "payload", "imports", "exports", "conn", "leaf")
EVERYTHING = (*MESSAGES, "mem_storage", "disk_storage", "streams", "consumer")


class User:
    """A pair of keys, its private one as NATS writes it."""

    def __init__(self) -> None:
        self.key = Ed25519PrivateKey.generate()
        self.public = public_text(Kind.USER, self.key)
        # S and U, five bits each: written down here by hand, against the reader of the service.
        raw = bytes([0b10010_101, 0b00000_000]) + self.key.private_bytes_raw()
        raw += binascii.crc_hqx(raw, 0).to_bytes(2, "little")
        self.seed = base64.b32encode(raw).decode().rstrip("=")


class Operator:
    """An operator with one account, in which everything is allowed, and that of its servers themselves."""

    def __init__(self) -> None:
        self._signer = Issuer(os.urandom(32), Kind.OPERATOR)
        self.account, self._system = Issuer(os.urandom(32)), Issuer(os.urandom(32))

    def lines(self) -> list[str]:
        """Return what the configuration of its servers has."""
        signer = self._signer
        operator = {"sub": signer.public, "nats": {"type": "operator", "version": 2}}
        limits = {self.account: dict.fromkeys(EVERYTHING, ALL), self._system: dict.fromkeys(MESSAGES, ALL)}
        accounts = [
            signer.sign({"sub": one.public, "nats": {"type": "account", "version": 2, "limits": found}})
            for one, found in limits.items()
        ]
        return [
            f"operator: {signer.sign(operator)}",
            f"system_account: {self._system.public}",
            "resolver: MEMORY",
            f"resolver_preload {{ {self.account.public}: {accounts[0]}, {self._system.public}: {accounts[1]} }}",
        ]

    def token(self, user: User, lasts_s: float = 3600.0, **rights: Any) -> str:
        """Return the JWT of a user, signed by the account."""
        may = {"type": "user", "version": 2, "subs": ALL, "data": ALL, "payload": ALL} | rights
        return self.account.sign({"sub": user.public, "exp": int(time.time() + lasts_s), "nats": may})


def write_credentials(file: Path, token: str, seed: str) -> Path:
    """Write a `.creds` file as `nsc` does."""
    text = (
        f"-----BEGIN NATS USER JWT-----\n{token}\n------END NATS USER JWT------\n\n"
        "************************* IMPORTANT *************************\n"
        "NKEY Seed printed below can be used to sign and prove identity.\n\n"
        f"-----BEGIN USER NKEY SEED-----\n{seed}\n------END USER NKEY SEED------\n\n"
        "*************************************************************\n"
    )
    # At once: a process that connects meanwhile reads the old one or the new one.
    new = file.with_suffix(".new")
    new.write_text(text)
    return new.rename(file)


def launch(folder: Path, port: int, lines: list[str]) -> subprocess.Popen[bytes]:
    """Start a server with JetStream and some lines of configuration."""
    file = folder / "nats.conf"
    own = [f'listen: "127.0.0.1:{port}"', f"jetstream {{ store_dir: {json.dumps(str(folder / 'nats'))} }}"]
    file.write_text("\n".join([*own, *lines]) + "\n")
    with (folder / "nats.log").open("ab") as log:
        return subprocess.Popen([SERVER, "-c", str(file)], stdout=log, stderr=log)


@contextmanager
def serving(folder: Path, port: int, lines: list[str]) -> Iterator[None]:
    """Run a server."""
    process = launch(folder, port, lines)
    try:
        yield
    finally:
        process.terminate()
        process.wait(PATIENCE_S)
