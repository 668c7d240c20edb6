"""A service behind a proxy may have a path of its own: every request and the socket go there."""

import asyncio

import httpx
import pytest

from app.errors import InvalidInput
from app.gateway import ServiceClient


@pytest.mark.parametrize(
    ("server", "base"),
    [
        ("https://clinic.example/telemotion", "https://clinic.example/telemotion"),
        ("https://clinic.example/a/b/", "https://clinic.example/a/b"),
        ("http://127.0.0.1:8000", "http://127.0.0.1:8000"),
    ],
)
def test_the_path_of_a_server_is_in_every_address(server: str, base: str) -> None:
    asked: list[httpx.Request] = []

    def answer(request: httpx.Request) -> httpx.Response:
        asked.append(request)
        more = {"Link": '</api/things?after=1>; rel="next"'} if len(asked) == 1 else {}
        return httpx.Response(200, json=[{}], headers=more)

    async def ask() -> str:
        async with ServiceClient(server) as service:
            service.http._transport = httpx.MockTransport(answer)
            service.http._mounts = {}
            await service.every("/api/things")
            return service.ingest_url

    assert asyncio.run(ask()) == base.replace("http", "ws", 1) + "/ws/ingest"
    assert [str(one.url) for one in asked] == [f"{base}/api/things", f"{base}/api/things?after=1"]
    # A browser's origin has no path.
    assert asked[0].headers["Origin"] == "/".join(server.split("/")[:3])


def test_an_address_without_a_host_is_refused() -> None:
    with pytest.raises(InvalidInput, match="https://"):
        ServiceClient("clinic.example/telemotion")
