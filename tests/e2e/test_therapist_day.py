"""What the product is for, as a person does it: connect, calibrate, record, compare, replay, make a template."""

import re
import time
import zipfile

from playwright.sync_api import Locator, Page, expect

from app.demo.people import PASSWORD, THERAPIST
from app.gateway import ServiceClient
from tests.e2e.conftest import House, Visitor, apart
from tests.e2e.sensors.clinic_gateway import Gateway
from tests.e2e.test_pages import serious, settle
from tests.patience import PATIENCE_S


def test_a_session_from_the_sensors_to_the_comparison(visitor: Visitor, house: House) -> None:
    page = visitor.page
    page.get_by_role("link", name=re.compile("Amara")).first.click()
    page.get_by_role("heading", level=1, name="Amara Okafor").wait_for()
    page.get_by_role("link", name="New session").or_(
        page.get_by_role("button", name="New session")
    ).first.click()
    page.get_by_role("button", name="Continue to the sensors").wait_for()
    settle(visitor)
    remembered = page.get_by_role("switch", name=re.compile("remembered mounting"))
    if remembered.count():
        remembered.set_checked(False, force=True)
    page.get_by_role("button", name="Continue to the sensors").click()
    page.wait_for_url("**/live")
    session_id = page.url.split("/")[-2]
    page.get_by_text("Waiting for the sensors").wait_for()
    visitor.picture("live-waiting-1440")

    placements = placements_of(house, session_id)
    gateway = Gateway(house.address, session_id, placements)
    gateway.start()
    page.get_by_role("button", name="Calibrate", exact=True).click()
    expect(page.get_by_role("button", name="Start recording")).to_be_enabled()
    visitor.picture("live-ready-1440")
    page.get_by_role("button", name="Start recording").click()
    page.get_by_role("button", name="Stop recording").wait_for()
    page.get_by_label("Note on the timeline").fill("first reach")
    page.get_by_role("button", name="Mark", exact=True).click()
    expect(page.get_by_text("first reach").first).to_be_visible()
    expect(page.get_by_test_id("delay")).to_contain_text("ms")
    page.wait_for_timeout(4000)
    visitor.picture("live-1440")
    assert serious(visitor) == []
    assert gateway.has_moved.wait(PATIENCE_S)
    page.get_by_role("button", name="Stop recording").click()
    gateway.join(PATIENCE_S)
    assert gateway.error is None
    page.get_by_role("button", name="End session").click()
    page.get_by_role("dialog").get_by_role("button", name="End session").click()
    page.get_by_role("link", name="Replay and compare").first.click()

    page.wait_for_url(f"**/sessions/{session_id}")
    settle(visitor)
    expect(page.get_by_text("3 repetitions compared with")).to_be_visible()
    position = page.get_by_role("slider").first
    page.get_by_role("button", name="Show repetition 2").first.click()
    moved_to = wait_until_beyond(page, position, 1.0)
    page.get_by_role("button", name="Play", exact=True).click()
    wait_until_beyond(page, position, moved_to)
    page.get_by_role("button", name="Pause", exact=True).click()
    page.wait_for_timeout(6000)
    visitor.picture("replay-compared-1440")
    assert visitor.faults_outside_the_view() == []


def wait_until_beyond(page: Page, slider: Locator, value: float) -> float:
    """Wait until a slider is beyond a value; returns where it is."""
    until_s = time.monotonic() + PATIENCE_S
    while (found := float(slider.get_attribute("aria-valuenow") or slider.input_value())) <= value:
        assert time.monotonic() < until_s, f"the slider stays at {found}"
        page.wait_for_timeout(100)
    return found


def test_guided_calibration(visitor: Visitor, house: House) -> None:
    """Look at another way and leave it, hold the pose, read the score, set the heading of the arm anew."""
    page = visitor.page
    placements = ["sternum", "upper_arm_right", "forearm_right", "hand_right"]
    session_id = new_session(house, placements)
    Gateway(house.address, session_id, placements).start()
    page.goto(f"{house.address}/sessions/{session_id}/live")
    page.get_by_role("heading", name="Hold the pose").wait_for()
    page.get_by_text("The patient cannot stand like this").click()
    page.get_by_role("radio", name=re.compile("By movement")).check()
    visitor.picture("calibration-choice-1440")
    assert serious(visitor) == []
    page.get_by_role("button", name="Begin").first.click()
    # The rest ends by itself after three still seconds; then a person says when each movement is done.
    page.get_by_role("heading", name="Bend the elbow").wait_for()
    visitor.picture("calibration-movement-1440")
    assert serious(visitor) == []
    page.get_by_role("button", name="Cancel").click()
    page.get_by_role("button", name="Calibrate", exact=True).click()
    page.get_by_role("heading", name=re.compile(r"Pose held well \(\d+ of 100\)")).wait_for()
    visitor.picture("calibration-result-1440")
    page.get_by_role("button", name="Continue").click()
    page.get_by_role("button", name="Reset the direction: Right arm").click()
    page.get_by_role("heading", name="Let the arms hang").wait_for()
    page.get_by_role("button", name="Continue").click()
    expect(page.get_by_role("button", name="Start recording")).to_be_enabled()
    page.get_by_role("button", name="End session").click()
    page.get_by_role("dialog").get_by_role("button", name="End session").click()
    page.get_by_role("heading", name=re.compile("The session is")).wait_for()
    assert visitor.faults_outside_the_view() == []


def new_session(house: House, placements: list[str]) -> str:
    async def make() -> str:
        async with ServiceClient(house.address) as service:
            await service.sign_in(THERAPIST, PASSWORD)
            wanted = {"patient_id": house.patient_id, "placements": placements, "use_mounting": False}
            return str((await service.http.post("/api/sessions", json=wanted)).json()["id"])

    return apart(make())  # type: ignore[no-any-return]


def placements_of(house: House, session_id: str) -> list[str]:
    async def ask() -> list[str]:
        async with ServiceClient(house.address) as service:
            await service.sign_in(THERAPIST, PASSWORD)
            return [str(name) for name in (await service.session(session_id)).placements]

    return apart(ask())  # type: ignore[no-any-return]


def test_a_template_from_a_stored_recording(visitor: Visitor, house: House) -> None:
    page = visitor.page
    page.goto(f"{house.address}/sessions/{house.template_session_id}")
    settle(visitor)
    page.get_by_role("link", name="Make a template from this").click()
    page.get_by_role("heading", name="2. Choose the good repetitions").wait_for()
    expect(page.get_by_text(re.compile(r"\d of \d used"))).to_be_visible()
    width = page.get_by_role("slider", name=re.compile("Band width")).first
    before = width.get_attribute("aria-valuenow")
    width.focus()
    page.keyboard.press("ArrowRight")
    assert width.get_attribute("aria-valuenow") != before
    page.wait_for_timeout(1500)
    visitor.picture("template-1440")
    assert serious(visitor) == []
    page.get_by_label("Name", exact=True).fill("Reach, second take")
    page.get_by_role("button", name="Save template").click()
    expect(page.get_by_text("Reach, second take").first).to_be_visible()
    assert visitor.faults_outside_the_view() == []


def test_the_report_prints_on_three_sheets(visitor: Visitor, house: House) -> None:
    page = visitor.page
    page.goto(f"{house.address}/sessions/{house.session_id}/report")
    settle(visitor)
    page.get_by_role("heading", name="Method and quality").wait_for()
    page.emulate_media(media="print")
    expect(page.get_by_role("button", name="Print or save as PDF")).to_be_hidden()
    expect(page.get_by_role("navigation", name="Main")).to_be_hidden()
    sheets = page.pdf(prefer_css_page_size=True)
    assert len(re.findall(rb"/Type\s*/Page[^s]", sheets)) == 3


def test_everything_held_about_a_patient_is_downloaded(visitor: Visitor, house: House) -> None:
    page = visitor.page
    page.goto(f"{house.address}/patients/{house.patient_id}")
    settle(visitor)
    # The archive is packed while other tests compute.
    with page.expect_download(timeout=1000 * PATIENCE_S) as download:
        page.get_by_role("link", name="Download everything").click()
    with zipfile.ZipFile(download.value.path()) as archive:
        names = archive.namelist()
    assert "patient.json" in names
    assert sum(name.endswith("packets.tmlog") for name in names) >= 2
    assert sum(name.endswith(".parquet") for name in names) >= 2
