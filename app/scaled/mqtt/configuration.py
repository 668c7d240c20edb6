"""The configuration of a NATS server that takes gateways by MQTT: two accounts, and workers that say who may connect.

Edges face the internet. Each has a user of its own with the few rights that it needs (`rights_of_edge`): it puts
packets into the streams and cannot read them, it hears what workers send to it and not what they send to another, and
it changes no stream, no lease and no view. Workers have the account to themselves.
"""

import hmac
import json
import re
from typing import Final
from urllib.parse import urlsplit

from app.errors import InvalidInput
from app.network.mqtt import DOWN, UP, subject
from app.scaled.broker import inbox_of
from app.scaled.mqtt.issuer import Issuer
from app.scaled.wire import subject as wire_subject
from app.settings import Settings
from estimators.sentences import say

GATEWAYS: Final = "GATEWAYS"
"""Account in which gateways are: of the service they see their own topics, of each other nothing."""
SERVICE: Final = "SERVICE"
"""Account of edges and workers."""
EDGE_PUBLISHES: Final = ("in", "ask", "here")
"""Names of subjects (`app.scaled.wire`) on which an edge speaks."""
_USER: Final = re.compile(r"[A-Za-z0-9_-]{1,40}")
"""Part of the subjects that are an edge's alone."""
BOOKS_BYTES: Final = 256 << 20
"""Most that the listener's own books of its clients may take on the disk."""
CALLOUT_S: Final = 2.5


def issuer_of(settings: Settings) -> Issuer:
    """Return the issuer that all workers with the same secret and the same password for NATS are.

    Edges have the secret and not the password: who answers for gateways may let anybody in, also as a worker.
    """
    _, password = _shown(settings.nats_url.get_secret_value())
    return Issuer(hmac.digest(settings.key_for("mqtt-issuer"), password.encode(), "sha256"))


def rights_of_edge(user: str) -> dict[str, dict[str, list[str]]]:
    """Return what the user of an edge may publish and hear, as a NATS server reads it.

    Parameters
    ----------
    user : str
        Its name; also of a user by `.creds` or NKEY, which is then called `edge` (`app.scaled.broker.user_of`).
    """
    publish = [*(wire_subject(name, "*") for name in EDGE_PUBLISHES), subject("*", DOWN)]
    hear = [wire_subject("to", f"{user}.>"), wire_subject("taken", "*"), f"{inbox_of(user)}.>"]
    return {
        "publish": {"allow": publish},
        "subscribe": {"allow": [*hear, *(subject("*", kind) for kind in UP)]},
    }


def _shown(address: str) -> tuple[str, str]:
    """Return user and password of an address.

    Raises
    ------
    InvalidInput
        It has none, or a user whose name cannot be part of a subject.
    """
    parts = urlsplit(address)
    if not parts.username or not parts.password:
        raise InvalidInput(say("scaled.no_nats_password"))
    if not _USER.fullmatch(parts.username):
        raise InvalidInput(say("scaled.nats_user_name"))
    return parts.username, parts.password


def configuration(
    settings: Settings,
    *,
    listen: str,
    mqtt: str,
    store: str,
    name: str = "telemotion",
    tls: str = "",
    listen_tls: str = "",
) -> str:
    """Return the text of a server's configuration; it holds the passwords of edges and workers.

    Parameters
    ----------
    settings : Settings
        `nats_url` with the user and the password that workers connect with, `nats_edge_url` with those of edges.
    listen, mqtt : str
        `address:port` for edges and workers, and for gateways.
    store : str
        Folder of the server.
    name : str
        Of the server.
    tls : str
        Files of certificate and key for gateways, separated by a comma; empty without TLS.
    listen_tls : str
        The same for edges and workers.

    Raises
    ------
    InvalidInput
        An address names no user and password, or two parts have the same user.
    """
    worker, password = _shown(settings.nats_url.get_secret_value())
    edges = dict(_shown(one) for one in settings.nats_edge_url.get_secret_value().split(","))
    if worker in edges or password in edges.values():
        raise InvalidInput(say("scaled.one_nats_user"))
    users: list[dict[str, object]] = [{"user": worker, "password": password}]
    users += [
        {"user": name, "password": word, "permissions": rights_of_edge(name)} for name, word in edges.items()
    ]
    up = [subject("*", kind) for kind in UP]
    down = subject("*", DOWN)
    lines = [
        f"server_name: {json.dumps(name)}",
        f"listen: {json.dumps(listen)}",
        *_tls(listen_tls),
        f"jetstream {{ store_dir: {json.dumps(store)} }}",
        "mqtt {",
        f"  listen: {json.dumps(mqtt)}",
        *_tls(tls),
        "}",
        "accounts {",
        f"  {SERVICE} {{",
        "    jetstream: enabled",
        f"    users: {json.dumps(users)}",
        f"    exports: [{{ stream: {json.dumps(down)}, accounts: [{GATEWAYS}] }}]",
        "    imports: [",
        *(f"      {{ stream: {{ account: {GATEWAYS}, subject: {json.dumps(one)} }} }}" for one in up),
        "    ]",
        "  }",
        f"  {GATEWAYS} {{",
        f"    jetstream {{ max_mem: 0, max_file: {BOOKS_BYTES} }}",
        "    exports: [",
        *(f"      {{ stream: {json.dumps(one)}, accounts: [{SERVICE}] }}" for one in up),
        "    ]",
        f"    imports: [{{ stream: {{ account: {SERVICE}, subject: {json.dumps(down)} }} }}]",
        "  }",
        "}",
        "authorization {",
        f"  timeout: {CALLOUT_S:g}",
        f"  auth_callout {{ issuer: {issuer_of(settings).public}, account: {SERVICE},"
        f" auth_users: {json.dumps([worker, *edges])} }}",
        "}",
    ]
    return "\n".join(lines) + "\n"


def _tls(files: str) -> list[str]:
    if not files:
        return []
    certificate, _, key = files.partition(",")
    return [f"tls {{ cert_file: {json.dumps(certificate)}, key_file: {json.dumps(key)} }}"]
