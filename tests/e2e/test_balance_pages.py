"""A balance test from the choice of a session to its report, in a real browser."""

import asyncio
import threading
from collections.abc import Iterator

import pytest
from playwright.sync_api import Browser, expect

from app.demo.people import PASSWORD, THERAPIST
from app.gateway import ServiceClient
from tests.app.live.standing import new_balance_test, stream_balance_test
from tests.e2e.conftest import Service, Visitor, apart, serving
from tests.e2e.test_pages import serious, settle


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


def test_a_balance_test_is_seen_live_and_read_afterwards(chromium: Browser, service: Service) -> None:
    session_id = apart(begun(service.address))
    context = chromium.new_context(
        viewport={"width": 1440, "height": 900}, bypass_csp=True, reduced_motion="reduce"
    )
    someone = Visitor(context.new_page(), service.address)
    someone.sign_in(THERAPIST)
    streaming = threading.Thread(
        target=lambda: asyncio.run(streamed(service.address, session_id)), name="gateway"
    )
    streaming.start()
    someone.page.goto(f"{service.address}/sessions/{session_id}/live")
    expect(someone.page.get_by_role("button", name="Eyes closed, firm ground")).to_be_enabled()
    expect(someone.page.get_by_test_id("sway-now")).to_contain_text("m/s²")
    someone.page.wait_for_timeout(4000)
    someone.picture("balance-live-1440")
    assert serious(someone) == []
    streaming.join()
    for width, height in ((1440, 900), (390, 844)):
        someone.page.set_viewport_size({"width": width, "height": height})
        someone.page.goto(f"{service.address}/sessions/{session_id}")
        settle(someone)
        panel = someone.page.get_by_role("tabpanel")
        expect(panel.get_by_text("Eyes closed compared with open, firm ground")).to_be_visible()
        expect(panel.get_by_role("row", name="Mean speed of sway")).to_contain_text("mm/s")
        expect(panel.get_by_role("img", name="Eyes open, firm ground")).to_be_visible()
        someone.picture(f"balance-{width}")
        overflow = someone.page.evaluate("document.documentElement.scrollWidth - window.innerWidth")
        assert overflow <= 0, width
        assert serious(someone) == []
        assert someone.faults_outside_the_view() == []
    context.close()
