"""A patient's window is gone in mid-exercise, and the link with it: what it measured is sent when she comes back."""

import time
from collections.abc import Callable
from dataclasses import dataclass

import httpx
import numpy as np
import pytest
from playwright.sync_api import BrowserContext, Error, Page, expect

from app.demo.people import PASSWORD, PATIENTS
from tests.e2e.conftest import Service, Visitor
from tests.e2e.sensors import sensors_at_home as home
from tests.e2e.sensors.broken_link import Relay
from tests.e2e.sensors.evenings import go_on
from tests.patience import PATIENCE_S

pytestmark = pytest.mark.slow("sensors stream in real time")
PLACEMENTS = ("upper_arm_right", "forearm_right")
MOVING_S = 4.0
BROKEN_S = 4.0
LOST_TICKS = 12
"""What may be in hand when a window goes: the packet that is being filled, and the radio's delay."""


def close(page: Page) -> None:
    page.close()


def crash(page: Page) -> None:
    with page.expect_event("crash"), pytest.raises(Error):
        page.goto("chrome://crash")
    page.close()


def begin(page: Page, worn: home.Wearer) -> int:
    """Put the sensors on and begin to move; returns by how many ticks that is later than in the recording."""
    page.evaluate(
        "one => emulateDots({rateHz: 60, ...one})",
        {"samples": worn.samples.round(7).tolist(), "rests": [home.STANDING]},
    )
    page.get_by_role("button", name="Bluetooth sensors").click()
    for place in ("Right upper arm", "Right forearm"):
        page.get_by_role("button", name=f"Connect: {place}").click()
    page.get_by_role("button", name="I am standing still").click()
    page.get_by_role("button", name="Go", exact=True).click()
    expect(page.get_by_test_id("line")).to_be_visible()
    return go_on(page)


@dataclass(frozen=True)
class Left:
    """A session whose window is gone in the middle of it, and the link before."""

    session_id: str
    worn: home.Wearer
    first: int
    emitted: int
    behind: int
    context: BrowserContext


def leave(patient: Visitor, relay: Relay, therapist: httpx.Client, go: Callable[[Page], None]) -> Left:
    worn = home.wearer(PLACEMENTS, 40.0)
    session_id = home.new_session(therapist, worn.placements)
    page = patient.page
    page.goto(f"{relay.address}/my/sessions/{session_id}/live")
    behind = begin(page, worn)
    page.wait_for_timeout(1000 * MOVING_S)
    relay.break_link()
    expect(page.locator(".sensor-status")).to_contain_text("will be sent later")
    page.wait_for_timeout(1000 * BROKEN_S)
    first, emitted = page.evaluate("[emulated.first, emulated.emitted]")
    context = page.context
    go(page)
    return Left(session_id, worn, int(first), int(emitted), behind, context)


def open_again(left: Left, relay: Relay) -> Visitor:
    again = Visitor(left.context.new_page(), relay.address)
    again.page.set_viewport_size({"width": 390, "height": 844})
    again.page.goto(relay.address)
    return again


def analysed_s(therapist: httpx.Client, session_id: str, longer_than_s: float) -> float:
    """Wait until a session is analysed and longer than that; returns how long it is."""
    deadline = time.monotonic() + PATIENCE_S
    while time.monotonic() < deadline:
        found = therapist.get(f"/api/sessions/{session_id}").json()
        if found["state"] == "analysed" and found["duration_s"] > longer_than_s:
            return float(found["duration_s"])
        time.sleep(0.5)
    raise TimeoutError(f"{found['state']}, {found['duration_s']} s")


def assert_is_sent(again: Visitor) -> None:
    expect(again.page.get_by_text("has been sent to your clinic")).to_be_visible()
    expect(again.page.locator(".sensor-unsent")).to_have_count(0)
    home.wait_until_sent(again.page)


def assert_all_is_stored(therapist: httpx.Client, left: Left) -> None:
    """Every tick once, none left out, up to the moment in which the window went; and it is the movement."""
    numbers, values = home.stored_samples(therapist, left.session_id)
    assert np.array_equal(numbers, np.arange(numbers[0], numbers[0] + numbers.size))
    assert numbers[-1] >= left.first + left.emitted - LOST_TICKS
    # Each sensor's values as they were, later by the quickest message of its radio.
    moved = numbers - left.first - left.behind
    shown = moved > home.STILL_S * home.RATE_HZ
    assert shown.sum() > BROKEN_S * home.RATE_HZ
    for sensor in range(len(PLACEMENTS)):
        stored, felt = values[shown, sensor, 0], left.worn.samples[:, sensor, 0]
        error = home.best_error(moved[shown], stored, felt)
        print(f"sensor {sensor}: 99 % within {np.quantile(error, 0.99):.4f} of {np.ptp(stored):.2f} rad/s")
        assert np.quantile(error, 0.99) < 0.05 < 0.1 * np.ptp(stored)


def test_what_a_window_left_is_sent_when_the_page_is_opened_again(
    patient: Visitor, service: Service, relay: Relay, therapist: httpx.Client
) -> None:
    # A crash tells the page nothing; the other tests close it.
    left = leave(patient, relay, therapist, crash)
    # The pages come through again, measurements do not yet.
    relay.mend()
    relay.refuse(b"GET /ws/ingest")
    again = open_again(left, relay)
    card = again.page.locator(".sensor-unsent")
    expect(card).to_contain_text("sent as soon as there is a connection")
    waiting = int(card.get_attribute("data-waiting") or 0)
    assert waiting * 6 >= BROKEN_S * home.RATE_HZ
    assert again.page.evaluate(home.WAITING) == waiting
    again.picture("left-on-the-device-390")

    relay.mend()
    assert_is_sent(again)
    again.picture("left-was-sent-390")

    again.page.get_by_role("link", name="Continue").click()
    again.page.get_by_role("button", name="Stop", exact=True).click()
    again.page.get_by_role("button", name="Finish for today").click()
    expect(again.page.get_by_role("heading", name="Your result is ready")).to_be_visible()
    assert_all_is_stored(therapist, left)
    assert again.faults_outside_the_view() == []


def test_what_a_window_left_is_sent_the_next_day_too(
    patient: Visitor, service: Service, relay: Relay, therapist: httpx.Client
) -> None:
    left = leave(patient, relay, therapist, close)
    relay.mend()
    # Nothing came for so long that the session has ended, and what had come of it was analysed.
    therapist.post(f"/api/sessions/{left.session_id}/close").raise_for_status()
    before_s = analysed_s(therapist, left.session_id, longer_than_s=0.0)
    again = open_again(left, relay)
    assert_is_sent(again)
    analysed_s(therapist, left.session_id, longer_than_s=before_s + 0.9 * BROKEN_S)
    assert_all_is_stored(therapist, left)
    # It is over: nothing asks her to go on with it.
    expect(again.page.locator(f"a[href*='{left.session_id}/live']")).to_have_count(0)


SEALED = """async () => {
  const database = await new Promise((give) => {
    const request = indexedDB.open("telemotion-sensors");
    request.onsuccess = () => give(request.result);
  });
  const all = (name) => new Promise((give) => {
    const request = database.transaction(name).objectStore(name).getAll();
    request.onsuccess = () => give(request.result);
  });
  const rows = [...(await all("packets")), ...(await all("sessions"))];
  database.close();
  return {rows: rows.length, keys: [...new Set(rows.flatMap(Object.keys))].sort()};
}"""


def sign_in(page: Page, email: str) -> None:
    page.get_by_label("E-mail").fill(email)
    page.get_by_label("Password", exact=True).fill(PASSWORD)
    page.keyboard.press("Enter")
    expect(page.get_by_role("button", name="Menu")).to_be_visible()


def sign_out(page: Page) -> None:
    page.get_by_role("button", name="Menu").click()
    page.get_by_role("menuitem", name="Sign out").click()


def test_what_waits_is_sealed_for_its_account_and_sent_after_its_next_sign_in(
    patient: Visitor, service: Service, relay: Relay, therapist: httpx.Client
) -> None:
    left = leave(patient, relay, therapist, close)
    relay.mend()
    relay.refuse(b"GET /ws/ingest")
    again = open_again(left, relay)
    page = again.page
    expect(page.locator(".sensor-unsent")).to_contain_text("sent as soon as there is a connection")
    waiting = page.evaluate(home.WAITING)
    sealed = page.evaluate(SEALED)
    assert sealed["rows"] > waiting > 0
    assert sealed["keys"] == ["accountId", "iv", "next", "sealed", "sequence", "sessionId", "usedMs"]

    sign_out(page)
    question = page.get_by_role("dialog")
    expect(question).to_contain_text("of movement. Nobody else can read it here.")
    again.picture("left-at-sign-out-390")
    question.get_by_role("button", name="Sign out").click()
    expect(page.get_by_role("heading", name="Sign in")).to_be_visible()

    relay.mend()
    sign_in(page, PATIENTS[1].email)
    page.wait_for_timeout(1500)
    expect(page.locator(".sensor-unsent")).to_have_count(0)
    assert page.evaluate(home.WAITING) == waiting
    sign_out(page)
    expect(page.get_by_role("heading", name="Sign in")).to_be_visible()

    sign_in(page, PATIENTS[0].email)
    assert_is_sent(again)
    therapist.post(f"/api/sessions/{left.session_id}/close")
    assert_all_is_stored(therapist, left)
