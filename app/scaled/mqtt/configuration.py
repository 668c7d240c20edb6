"""The configuration of a NATS server that takes gateways by MQTT: two accounts, and edges that say who may connect."""

import json
from typing import Final
from urllib.parse import urlsplit

from app.errors import InvalidInput
from app.network.mqtt import DOWN, UP, subject
from app.scaled.mqtt.issuer import Issuer
from app.sentences import say
from app.settings import Settings

GATEWAYS: Final = "GATEWAYS"
"""Account in which gateways are: of the service they see their own topics, of each other nothing."""
SERVICE: Final = "SERVICE"
"""Account of edges and workers."""
BOOKS_BYTES: Final = 256 << 20
"""Most that the listener's own books of its clients may take on the disk."""
CALLOUT_S: Final = 2.5


def issuer_of(settings: Settings) -> Issuer:
    """Return the issuer that all edges with the same secret are."""
    return Issuer(settings.key_for("mqtt-issuer"))


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
    """Return the text of a server's configuration; it holds the password of edges and workers.

    Parameters
    ----------
    settings : Settings
        `nats_url` with the user and the password that edges and workers connect with.
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
        The address names no user and password.
    """
    first = urlsplit(settings.nats_url.get_secret_value().split(",")[0])
    if not first.username or not first.password:
        raise InvalidInput(say("scaled.no_nats_password"))
    user, password = json.dumps(first.username), json.dumps(first.password)
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
        f"    users: [{{ user: {user}, password: {password} }}]",
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
        f"  auth_callout {{ issuer: {issuer_of(settings).public}, account: {SERVICE}, auth_users: [{user}] }}",
        "}",
    ]
    return "\n".join(lines) + "\n"


def _tls(files: str) -> list[str]:
    if not files:
        return []
    certificate, _, key = files.partition(",")
    return [f"tls {{ cert_file: {json.dumps(certificate)}, key_file: {json.dumps(key)} }}"]


__all__ = ["GATEWAYS", "SERVICE", "configuration", "issuer_of"]
