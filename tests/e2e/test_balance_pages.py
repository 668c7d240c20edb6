"""A balance test from the choice of a session to its report, in a real browser."""

import asyncio
import threading
from collections.abc import Iterator
from typing import Any

import pytest
from playwright.sync_api import Browser, expect

from app.demo.people import PASSWORD, THERAPIST
from app.gateway import ServiceClient
from tests.app.live.standing import new_balance_test, stream_balance_test
from tests.e2e.conftest import Service, Visitor, apart, serving
from tests.e2e.test_pages import serious, settle

pytestmark = [pytest.mark.e2e, pytest.mark.slow]


@pytest.fixture(scope="module")
def service(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Service]:
    with serving(tmp_path_factory.mktemp("standing")) as running:
        yield running


async def begun(address: str) -> str:
    async with ServiceClient(address) as client:
        await client.sign_in(THERAPIST, PASSWORD)
        patients = await client.every("/api/patients")
        return await new_balance_test(client, patients[0]["id"])


async def streamed(address: str, session_id: str) -> None:
    async with ServiceClient(address) as client:
        await client.sign_in(THERAPIST, PASSWORD)
        await stream_balance_test(client, session_id, pace=3.0)


def visit(chromium: Browser, service: Service, width: int) -> tuple[Visitor, Any]:
    context = chromium.new_context(
        viewport={"width": width, "height": 900 if width > 600 else 844},
        bypass_csp=True,
        reduced_motion="reduce",
    )
    someone = Visitor(context.new_page(), service.address)
    someone.sign_in(THERAPIST)
    return someone, context


def test_a_balance_test_is_seen_live_and_read_afterwards(chromium: Browser, service: Service) -> None:
    session_id = apart(begun(service.address))
    wide, wide_context = visit(chromium, service, 1440)
    narrow, narrow_context = visit(chromium, service, 390)
    streaming = threading.Thread(
        target=lambda: asyncio.run(streamed(service.address, session_id)), name="gateway"
    )
    streaming.start()
    wide.page.goto(f"{service.address}/sessions/{session_id}/live")
    expect(wide.page.get_by_role("button", name="Eyes closed, firm ground")).to_be_enabled(timeout=60_000)
    expect(wide.page.get_by_test_id("sway-now")).to_contain_text("m/s²", timeout=30_000)
    wide.page.wait_for_timeout(4000)
    wide.picture("balance-live-1440")
    assert serious(wide) == []
    streaming.join()
    for someone in (wide, narrow):
        someone.page.goto(f"{service.address}/sessions/{session_id}")
        settle(someone)
        panel = someone.page.get_by_role("tabpanel")
        expect(panel.get_by_text("Eyes closed compared with open, firm ground")).to_be_visible()
        expect(panel.get_by_role("row", name="Mean speed of sway")).to_contain_text("mm/s")
        expect(panel.get_by_role("img", name="Eyes open, firm ground")).to_be_visible()
        width = someone.page.viewport_size["width"]  # type: ignore[index]
        someone.picture(f"balance-{width}")
        overflow = someone.page.evaluate("document.documentElement.scrollWidth - window.innerWidth")
        assert overflow <= 0, width
        assert serious(someone) == []
        assert someone.faults_outside_the_view() == []
    wide_context.close()
    narrow_context.close()
