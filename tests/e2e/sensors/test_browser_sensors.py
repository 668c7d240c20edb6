"""A patient measures without a gateway: a simulated arm goes through the real page into the real service."""

import httpx
import numpy as np
import pytest
from numpy.typing import NDArray
from playwright.sync_api import Page, expect

from tests.e2e.conftest import Service, Visitor, apart
from tests.e2e.sensors import sensors_at_home as home
from tests.e2e.sensors.broken_link import Relay
from tests.e2e.sensors.evenings import go_on

pytestmark = pytest.mark.slow("sensors stream in real time")
ELEVATION = "thorax_humerus_right_yxy_elevation"
MOVEMENT_S = 14.0
BROKEN_S = 5.0


def emulate(page: Page, function: str, samples: NDArray[np.float64]) -> None:
    """Begin to emit samples, shape (ticks, ...): who wears the sensors stands still until the page has been pressed."""
    what = {"rateHz": home.RATE_HZ, "samples": samples.round(7).tolist(), "rests": [home.STANDING]}
    page.evaluate(f"what => {function}(what)", what)


def exercise(page: Page, relay: Relay, moves_s: float, broken_s: float) -> None:
    """Press what the page offers, as the patient does; break the link in the middle of the movement."""
    page.get_by_role("button", name="I am standing still").click()
    page.get_by_role("button", name="Go", exact=True).click()
    expect(page.get_by_test_id("line")).to_be_visible()
    go_on(page)
    status = page.locator(".sensor-status")
    page.wait_for_timeout(1000 * (moves_s - broken_s) / 2)
    relay.break_link()
    expect(status).to_contain_text("will be sent later")
    page.wait_for_timeout(1000 * broken_s)
    assert int(status.get_attribute("data-waiting") or 0) > 5 * broken_s
    relay.mend()
    expect(status).to_contain_text("Nothing waits on this device")


def test_the_phone_stores_every_sample_once_over_a_broken_link(
    patient: Visitor, service: Service, relay: Relay, therapist: httpx.Client
) -> None:
    worn = home.wearer(("upper_arm_right",), MOVEMENT_S)
    session_id = home.new_session(therapist, worn.placements)
    page = patient.page
    page.goto(f"{relay.address}/my/sessions/{session_id}/live")
    page.get_by_role("button", name="This phone").click()
    patient.picture("phone-how-390")
    emulate(page, "emulatePhone", worn.samples[:, 0])
    page.get_by_role("button", name="Measure with this phone").click()
    exercise(page, relay, MOVEMENT_S, BROKEN_S)
    patient.picture("phone-measuring-390")
    page.wait_for_function("count => emulated.sample === count", arg=len(worn.samples))
    worn = home.as_emitted(page, worn)
    page.get_by_role("button", name="Stop", exact=True).click()
    page.get_by_role("button", name="Finish for today").click()
    expect(page.get_by_role("heading", name="Your result is ready")).to_be_visible()

    first = int(page.evaluate("emulated.first"))
    numbers, values = home.stored_samples(therapist, session_id)
    emitted = numbers - first
    # Each tick once and none left out, from when the phone's rate was known to the last but one event.
    assert np.array_equal(emitted, np.arange(emitted[0], emitted[0] + emitted.size))
    assert 55 <= emitted[0] <= 120
    assert emitted[-1] >= len(worn.samples) - 2
    np.testing.assert_allclose(values, worn.samples[emitted], atol=2e-4)

    other = apart(home.stream_by_gateway(relay.address, worn, int(emitted[0]), home.STILL_S - 2.0))
    by_phone, phone_rad = home.angles_of(therapist, session_id, ELEVATION)
    by_gateway, gateway_rad = home.angles_of(therapist, other, ELEVATION)
    _, mine, its = np.intersect1d(by_phone, by_gateway, return_indices=True)
    difference_deg = np.rad2deg(np.abs(phone_rad[mine] - gateway_rad[its]))
    truth_rad = worn.elevation_rad[emitted[0] + by_phone]
    error_deg = np.rad2deg(np.sqrt(np.mean((phone_rad - truth_rad) ** 2)))
    print(f"largest difference {difference_deg.max():.3f} deg, against truth {error_deg:.2f} deg rms")
    assert difference_deg.max() < 0.3
    assert error_deg < 3.0
    assert patient.faults_outside_the_view() == []


def test_bluetooth_sensors_store_every_sample_and_come_back(
    patient: Visitor, service: Service, relay: Relay, therapist: httpx.Client
) -> None:
    # Time for a broken link, and for a sensor that is lost and found again, on a busy machine too.
    worn = home.wearer(("upper_arm_right", "forearm_right"), MOVEMENT_S + 60.0)
    session_id = home.new_session(therapist, worn.placements)
    page = patient.page
    page.goto(f"{relay.address}/my/sessions/{session_id}/live")
    emulate(page, "emulateDots", worn.samples)
    page.get_by_role("button", name="Bluetooth sensors").click()
    for place in ("Right upper arm", "Right forearm"):
        page.get_by_role("button", name=f"Connect: {place}").click()
    status = page.locator(".sensor-status")
    expect(status).to_contain_text("battery 83 %")
    exercise(page, relay, MOVEMENT_S - 5.0, 3.0)
    patient.picture("dots-measuring-390")
    page.evaluate("emulated.dots[1].isAway = true; emulated.dots[1].leave()")
    expect(status).to_contain_text("lost, is being looked for")
    patient.picture("dots-lost-390")
    page.evaluate("emulated.dots[1].isAway = false")
    expect(status).not_to_contain_text("lost")
    page.wait_for_timeout(3000)
    page.get_by_role("button", name="Stop", exact=True).click()
    page.get_by_role("button", name="Finish for today").click()
    expect(page.get_by_role("heading", name="Your result is ready")).to_be_visible()
    worn = home.as_emitted(page, worn)

    first = int(page.evaluate("emulated.first"))
    numbers, values = home.stored_samples(therapist, session_id)
    assert np.array_equal(numbers, np.arange(numbers[0], numbers[0] + numbers.size))
    is_missing = (values == 0.0).all(axis=2)
    assert not is_missing[20:, 0].any()
    # Gone at most as long as it took to be found again, and nothing else is missing.
    lost = np.flatnonzero(is_missing[20:, 1])
    assert 0 < lost.size < 8.0 * home.RATE_HZ
    assert lost[-1] - lost[0] + 1 == lost.size
    # What is stored lies on the lines between the samples, later by the quickest message of each sensor.
    for sensor in range(2):
        shown = np.flatnonzero(~is_missing[:, sensor])[200:]
        best = home.best_error(numbers[shown] - first, values[shown, sensor, 0], worn.samples[:, sensor, 0])
        print(
            f"sensor {sensor}: median error {np.median(best):.4f} rad/s, 99 % {np.quantile(best, 0.99):.4f}"
        )
        assert np.quantile(best, 0.99) < 0.05

    offset = int(numbers[0] - first)
    other = apart(home.stream_by_gateway(relay.address, worn, offset, home.STILL_S - 4.0))
    by_page, page_rad = home.angles_of(therapist, session_id, ELEVATION)
    by_gateway, gateway_rad = home.angles_of(therapist, other, ELEVATION)
    _, mine, its = np.intersect1d(by_page, by_gateway, return_indices=True)
    difference_deg = np.rad2deg(np.sqrt(np.mean((page_rad[mine] - gateway_rad[its]) ** 2)))
    print(f"{ELEVATION}: {difference_deg:.2f} deg rms from the gateway's")
    assert difference_deg < 0.5


def test_a_page_that_is_loaded_again_without_a_link_has_lost_nothing(
    patient: Visitor, service: Service, relay: Relay, therapist: httpx.Client
) -> None:
    worn = home.wearer(("upper_arm_right",), 60.0)
    session_id = home.new_session(therapist, worn.placements)
    page = patient.page
    assert page.evaluate("navigator.serviceWorker.ready.then(() => true)")
    page.goto(f"{relay.address}/my/sessions/{session_id}/live")
    page.get_by_role("button", name="This phone").click()
    page.evaluate("samples => emulatePhone({rateHz: 60, samples})", worn.samples[:, 0].round(7).tolist())
    page.get_by_role("button", name="Measure with this phone").click()
    expect(page.get_by_role("button", name="I am standing still")).to_be_visible()
    relay.break_link()
    expect(page.locator(".sensor-status")).to_contain_text("will be sent later")
    page.wait_for_timeout(3000)
    first, emitted = page.evaluate("[emulated.first, emulated.emitted]")
    page.goto(relay.address)
    # The client itself is there without a link; nothing of the patient is.
    expect(page.locator("#root")).not_to_be_empty()
    kept = page.evaluate(
        "caches.keys().then(async names => (await Promise.all(names.map(async name =>"
        " (await (await caches.open(name)).keys()).map(one => new URL(one.url).pathname)))).flat())"
    )
    assert kept
    assert all(
        path in {"/", "/mark.svg", "/manifest.webmanifest"} or path.startswith("/assets/") for path in kept
    )
    patient.picture("without-link-390")
    relay.mend()
    page.goto(relay.address)
    expect(page.get_by_role("heading", level=1, name="Hello")).to_be_visible()
    home.wait_until_sent(page)
    expect(page.locator(".sensor-unsent")).to_have_count(0)
    numbers, values = home.stored_samples(therapist, session_id)
    sent = numbers - int(first)
    assert np.array_equal(sent, np.arange(sent[0], sent[0] + sent.size))
    # The packet that was being filled when the page went holds a tenth of a second at most.
    assert sent[-1] >= int(emitted) - 8
    np.testing.assert_allclose(values, worn.samples[sent], atol=2e-4)


def test_a_second_window_ends_the_session_when_the_first_has_sent_all(
    patient: Visitor, service: Service, relay: Relay, therapist: httpx.Client
) -> None:
    worn = home.wearer(("upper_arm_right",), 60.0)
    session_id = home.new_session(therapist, worn.placements)
    page = patient.page
    page.goto(f"{relay.address}/my/sessions/{session_id}/live")
    page.get_by_role("button", name="This phone").click()
    page.evaluate("samples => emulatePhone({rateHz: 60, samples})", worn.samples[:, 0].round(7).tolist())
    page.get_by_role("button", name="Measure with this phone").click()
    page.get_by_role("button", name="I am standing still").click()
    page.get_by_role("button", name="Go", exact=True).click()
    expect(page.get_by_test_id("line")).to_be_visible()
    page.wait_for_timeout(3000)
    second = page.context.new_page()
    second.set_viewport_size({"width": 390, "height": 844})
    second.goto(page.url)
    second.get_by_role("button", name="Stop", exact=True).click()
    first, emitted = page.evaluate("[emulated.first, emulated.emitted]")
    second.get_by_role("button", name="Finish for today").click()
    expect(second.get_by_role("heading", name="Your result is ready")).to_be_visible()
    expect(page.get_by_role("heading", name="Your result is ready")).to_be_visible()
    # What the first window had measured when the end was pressed is stored, without a gap.
    numbers, values = home.stored_samples(therapist, session_id)
    sent = numbers - int(first)
    assert np.array_equal(sent, np.arange(sent[0], sent[0] + sent.size))
    assert sent[-1] >= int(emitted) - 2
    np.testing.assert_allclose(values, worn.samples[sent], atol=2e-4)
    home.wait_until_sent(second)
