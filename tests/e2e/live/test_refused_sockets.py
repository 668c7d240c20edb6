"""Behind a proxy that refuses WebSockets: one moment, the cause, whom to ask, and the state that HTTP tells."""

import re
import time
from collections.abc import Iterator

import pytest
from playwright.sync_api import Browser, Page, expect

from app.demo.people import PATIENTS, THERAPIST
from tests.e2e.conftest import Service
from tests.e2e.live.conftest import opened
from tests.e2e.live.test_live_returns import elbow
from tests.e2e.sensors.broken_link import Relay
from tests.e2e.sensors.sensors_at_home import therapist_at
from tests.e2e.test_live_truth import patient_of, recording_of

TRIES_S = 20.0
"""Long enough for several tries to connect, each of which once moved the moment on."""
MOMENT = re.compile(r"lost since (\d\d:\d\d:\d\d)")


@pytest.fixture(scope="module")
def session_id(service: Service, gateway: None) -> str:
    return recording_of(service, patient_of(service))


@pytest.fixture
def refusing(relay: Relay, session_id: str) -> Iterator[Relay]:
    relay.refuse_sockets()
    yield relay
    relay.mend()


def moments_of(page: Page) -> set[str]:
    """Return each moment the page names within several tries."""
    until, found = time.monotonic() + TRIES_S, set()
    while time.monotonic() < until:
        found |= set(MOMENT.findall(page.locator(".banner-alert").inner_text()))
        page.wait_for_timeout(500)
    return found


def test_a_patient_reads_whom_to_ask(chromium: Browser, refusing: Relay, session_id: str) -> None:
    visitor = opened(chromium, refusing.address, PATIENTS[0].email, f"/my/sessions/{session_id}/live", 390)
    page = visitor.page
    expect(page.get_by_role("heading", name="No live picture here")).to_be_visible()
    expect(page.get_by_text("Your clinic says: Recording.")).to_be_visible()
    visitor.picture("mine-sockets-refused-390")
    page.context.close()


def test_a_therapist_reads_the_cause_and_what_is_known(
    chromium: Browser, refusing: Relay, service: Service, session_id: str
) -> None:
    visitor = opened(chromium, refusing.address, THERAPIST, f"/sessions/{session_id}/live", 1440)
    page = visitor.page
    banner = page.locator(".banner-alert")
    expect(banner).to_contain_text("WebSocket")
    expect(banner).to_contain_text("Ask whoever runs the network")
    expect(banner).to_contain_text("Recording")
    assert len(moments_of(page)) == 1
    visitor.picture("live-sockets-refused-1440")

    # This test is the last one, for it ends the recording. What goes on meanwhile is told over HTTP;
    # nothing on the page stands for a value of now.
    with therapist_at(service.address) as client:
        client.post(f"/api/sessions/{session_id}/stop").raise_for_status()
    expect(banner).to_contain_text("It says: Ready")
    assert page.locator(".trace-value").filter(has_text=re.compile("[0-9]")).count() == 0

    refusing.mend()
    expect(banner).to_have_count(0)
    expect(elbow(page)).to_contain_text(re.compile(r"[0-9]°"))
    page.context.close()
