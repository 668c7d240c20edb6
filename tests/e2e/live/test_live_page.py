"""The live page on a desktop: figure and curves side by side above the fold, and one way to calibrate again."""

from playwright.sync_api import Browser, expect

from app.demo.people import THERAPIST
from tests.e2e.conftest import Service
from tests.e2e.live.conftest import opened
from tests.e2e.sensors.sensors_at_home import therapist_at
from tests.e2e.test_live_truth import patient_of, recording_of

FOLD_PX = 900


def test_curves_stand_beside_the_figure(chromium: Browser, service: Service, gateway: None) -> None:
    session_id = recording_of(service, patient_of(service))
    visitor = opened(chromium, service.address, THERAPIST, f"/sessions/{session_id}/live", 1440)
    page = visitor.page
    plots = page.locator(".trace-plot")
    expect(plots.nth(1)).to_be_visible()
    viewer = page.get_by_test_id("viewer").bounding_box()
    assert viewer
    for index in range(2):
        plot = plots.nth(index).bounding_box()
        assert plot
        assert plot["x"] > viewer["x"] + viewer["width"]
        assert plot["y"] + plot["height"] < FOLD_PX
    expect(page.get_by_text("sensors good")).to_be_visible()
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    visitor.picture("live-beside-1440")

    with therapist_at(service.address) as client:
        client.post(f"/api/sessions/{session_id}/stop").raise_for_status()
    expect(page.get_by_role("button", name="Calibrate again")).to_have_count(1)
    expect(page.get_by_text("not checked by a movement")).to_have_count(1)
    visitor.picture("live-ready-1440")
    page.context.close()
