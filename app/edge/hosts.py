"""Which names the service answers to: a page of another site must not reach it under the name of that site.

A browser that is led to this address by a name of the attacker's (DNS rebinding) counts the service as part of the
attacker's site: pages there could read what needs no sign-in, and their Origin would be the Host. Such a request always
carries the name in `Host`; an address in figures cannot be led elsewhere.
"""

import ipaddress
from typing import Final
from urllib.parse import urlsplit

from starlette.types import ASGIApp, Receive, Scope, Send

from app.edge.error_answers import answer
from app.settings import Settings
from estimators.sentences import say

BY_ADDRESS: Final = frozenset({"/api/health", "/api/ready", "/metrics"})
"""Asked by programs that watch over the service, which know a machine by its address in figures."""


class KnownHosts:
    """Refuses requests under names that are not the service's.

    Parameters
    ----------
    settings : Settings
        `base_url` and `allowed_hosts` name the service; where `base_url` is this machine's own, so do all of its names.
    """

    def __init__(self, app: ASGIApp, settings: Settings) -> None:
        self.app = app
        own = [urlsplit(settings.base_url).hostname or "", *settings.allowed_hosts.split(",")]
        self._names = {name.strip().lower() for name in own if name.strip()}
        self._is_loopback = settings.is_loopback

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on, or answer 421."""
        if scope["type"] not in {"http", "websocket"}:
            await self.app(scope, receive, send)
            return
        hosts = [value.decode("latin-1") for name, value in scope["headers"] if name == b"host"]
        if len(hosts) == 1 and self._is_known(name_of(hosts[0]), scope["path"]):
            await self.app(scope, receive, send)
        elif scope["type"] == "websocket":
            await send({"type": "websocket.close", "code": 4421, "reason": "misdirected"})
        else:
            await answer(421, "misdirected", say("edge.host"), {})(scope, receive, send)

    def _is_known(self, name: str, path: str) -> bool:
        if name in self._names:
            return True
        try:
            address = ipaddress.ip_address(name)
        except ValueError:
            return self._is_loopback and (name == "localhost" or name.endswith(".localhost"))
        return path in BY_ADDRESS or (self._is_loopback and address.is_loopback)


def name_of(host: str) -> str:
    """Return the name in a `Host`, in lower case and without port.

    Parameters
    ----------
    host : str
        Anything that a client sends.
    """
    name, closing, _ = host.strip().lower().partition("]")
    if closing:
        return name.removeprefix("[")
    return name.partition(":")[0].removesuffix(".")
