"""A patient measures without a gateway: a simulated arm goes through the real page into the real service."""

from collections.abc import Iterator

import httpx
import numpy as np
import pytest
from playwright.sync_api import Browser, Page, expect

from app.demo.people import PATIENTS
from tests.e2e import sensors_at_home as home
from tests.e2e.broken_link import Relay, relaying
from tests.e2e.conftest import Service, Visitor, apart, serving

pytestmark = [pytest.mark.e2e, pytest.mark.slow]

ELEVATION = "thorax_humerus_right_yxy_elevation"
MOVEMENT_S = 14.0
BROKEN_S = 5.0


@pytest.fixture(scope="module")
def relay() -> Iterator[Relay]:
    with relaying() as one:
        yield one


@pytest.fixture(scope="module")
def service(relay: Relay, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Service]:
    with serving(tmp_path_factory.mktemp("home"), base_url=relay.address) as one:
        relay.serve(one.address)
        yield one


@pytest.fixture(scope="module")
def therapist(service: Service, relay: Relay) -> Iterator[httpx.Client]:
    with home.therapist_at(relay.address) as client:
        yield client


@pytest.fixture
def patient(chromium: Browser, relay: Relay, service: Service) -> Iterator[Visitor]:
    context = chromium.new_context(reduced_motion="reduce")
    context.add_init_script(home.EMULATED)
    someone = Visitor(context.new_page(), relay.address)
    someone.sign_in(PATIENTS[0].email)
    someone.page.set_viewport_size({"width": 390, "height": 844})
    yield someone
    context.close()


def exercise(page: Page, relay: Relay, moves_s: float, broken_s: float) -> None:
    """Press what the page offers, as the patient does; break the link in the middle of the movement."""
    page.get_by_role("button", name="I am standing still").click()
    page.get_by_role("button", name="Go", exact=True).click()
    expect(page.get_by_role("heading", name="Go!")).to_be_visible()
    status = page.locator(".sensor-status")
    page.wait_for_timeout(1000 * (moves_s - broken_s) / 2)
    relay.break_link()
    expect(status).to_contain_text("will be sent later", timeout=8000)
    page.wait_for_timeout(1000 * broken_s)
    assert int(status.get_attribute("data-waiting") or 0) > 5 * broken_s
    relay.mend()
    expect(status).to_contain_text("Nothing waits on this device", timeout=20_000)


def test_the_phone_stores_every_sample_once_over_a_broken_link(
    patient: Visitor, service: Service, relay: Relay, therapist: httpx.Client
) -> None:
    worn = home.wearer(("upper_arm_right",), MOVEMENT_S)
    session_id = home.new_session(therapist, worn.placements)
    page = patient.page
    page.goto(f"{relay.address}/my/sessions/{session_id}/live")
    page.get_by_role("button", name="This phone").click()
    patient.picture("phone-how-390")
    page.evaluate("samples => emulatePhone({rateHz: 60, samples})", worn.samples[:, 0].round(7).tolist())
    page.get_by_role("button", name="Measure with this phone").click()
    exercise(page, relay, MOVEMENT_S, BROKEN_S)
    patient.picture("phone-measuring-390")
    page.wait_for_function("count => emulated.emitted === count", arg=len(worn.samples), timeout=60_000)
    page.get_by_role("button", name="I have finished").click()
    expect(page.get_by_role("heading", name="Your result is ready")).to_be_visible(timeout=60_000)

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
