"""On a computer that draws nothing in 3D: a sentence, a flat figure that moves with the measurement, and the curves."""

import re
from collections.abc import Iterator

import pytest
from playwright.sync_api import Browser, Page, expect

from app.demo.people import PATIENTS, THERAPIST
from tests.e2e.conftest import CHROMIUM, FLAGS, House, Service, Visitor
from tests.e2e.live.conftest import opened
from tests.e2e.live.test_live_returns import elbow
from tests.e2e.sensors.broken_link import Relay
from tests.e2e.test_live_truth import patient_of, recording_of

WITHOUT_3D = [flag for flag in FLAGS if "gl" not in flag] + ["--disable-gpu", "--disable-3d-apis"]
LARGEST_M = 0.1
"""The wrist of a person who drinks, or reaches forward, moves further than this within a repetition."""


@pytest.fixture
def browser(chromium: Browser) -> Iterator[Browser]:
    """Another browser of the same driver: two drivers cannot run in one process."""
    other = chromium.browser_type.launch(executable_path=CHROMIUM, args=WITHOUT_3D)
    yield other
    other.close()


def flat(browser: Browser, address: str, email: str, path: str, width: int) -> Visitor:
    """Open a page that says why it draws flat, and asks for no 3D view."""
    visitor = opened(browser, address, email, path, width)
    expect(visitor.page.get_by_test_id("flat")).to_contain_text("cannot show 3D")
    assert visitor.page.locator("iframe").count() == 0
    return visitor


def wrist(page: Page) -> list[float]:
    """Return where the wrist stands in both pictures, m."""
    ends = page.locator("[data-bone^=wrist_].flat-measured")
    expect(ends.first).to_be_attached()
    return [
        float(ends.nth(index).get_attribute(axis) or "nan")
        for index in range(ends.count())
        for axis in ("x2", "y2")
    ]


def moved(page: Page, seconds: float) -> float:
    """Return how far the wrist goes in a picture within some seconds, m."""
    seen = [wrist(page)]
    for _ in range(int(5 * seconds)):
        page.wait_for_timeout(200)
        seen.append(wrist(page))
    return max(max(column) - min(column) for column in zip(*seen, strict=True))


def test_a_live_session_is_drawn_flat(
    browser: Browser, relay: Relay, service: Service, gateway: None
) -> None:
    session_id = recording_of(service, patient_of(service))
    therapist = flat(browser, relay.address, THERAPIST, f"/sessions/{session_id}/live", 1440)
    page = therapist.page
    expect(elbow(page)).to_contain_text(re.compile(r"[0-9]°"))
    expect(page.get_by_text("From the front")).to_be_visible()
    expect(page.get_by_text(re.compile("From the (left|right)"))).to_be_visible()
    assert moved(page, 8) > LARGEST_M
    therapist.picture("live-without-webgl-1440")
    assert therapist.faults == []
    page.context.close()

    patient = flat(browser, relay.address, PATIENTS[0].email, f"/my/sessions/{session_id}/live", 390)
    assert moved(patient.page, 8) > LARGEST_M
    patient.picture("mine-without-webgl-390")
    assert patient.page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    assert patient.faults == []


def test_a_replay_is_drawn_flat(browser: Browser, house: House) -> None:
    visitor = flat(browser, house.address, THERAPIST, f"/sessions/{house.session_id}?show=angles", 1440)
    page = visitor.page
    wrist(page)
    page.get_by_role("button", name="Play", exact=True).click()
    assert moved(page, 8) > LARGEST_M
    expect(elbow(page)).to_be_visible()
    visitor.picture("replay-without-webgl-1440")
    assert visitor.faults == []
    page.context.close()

    path = f"/my/sessions/{house.session_id}"
    patient = flat(browser, house.address, PATIENTS[0].email, path, 390)
    patient.page.get_by_role("button", name="Play", exact=True).click()
    assert moved(patient.page, 8) > LARGEST_M
    patient.picture("mine-replay-without-webgl-390")
