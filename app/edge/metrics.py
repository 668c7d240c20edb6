"""`GET /metrics`: the numbers of the service, for who watches over it."""

import hmac
import ipaddress

from fastapi import APIRouter, Request
from fastapi.responses import PlainTextResponse

from app.edge.registry import CONTENT_TYPE, Registry
from app.errors import NotAllowed
from app.services import services_of
from estimators.sentences import say

router = APIRouter(include_in_schema=False)


@router.get("/metrics", response_class=PlainTextResponse)
def metrics(request: Request) -> PlainTextResponse:
    """Return every metric; see `_require_watcher` for who may read them."""
    _require_watcher(request)
    return PlainTextResponse(
        services_of(request).get(Registry).text(), headers={"Content-Type": CONTENT_TYPE}
    )


def _require_watcher(request: Request) -> None:
    """Let in who knows the token; without one set, this machine while the service has no public address.

    Behind a proxy on the same machine every request seems to come from here, so an address alone says nothing there.
    """
    settings = services_of(request).settings
    token = settings.metrics_token.get_secret_value()
    if token:
        scheme, _, given = request.headers.get("authorization", "").partition(" ")
        allowed = scheme.lower() == "bearer" and hmac.compare_digest(given.strip().encode(), token.encode())
    else:
        allowed = settings.is_loopback and _is_here(request.client.host if request.client else "")
        allowed = allowed and "x-forwarded-for" not in request.headers and "origin" not in request.headers
    if not allowed:
        raise NotAllowed(say("edge.metrics"))


def _is_here(address: str) -> bool:
    try:
        return ipaddress.ip_address(address).is_loopback
    except ValueError:
        return False
