"""A template as an instrument, as a therapist uses it: phases and a band by keys, saved, prescribed for three days."""

import re

import pytest
from playwright.sync_api import expect

from app.demo.people import THERAPIST

from .conftest import House, Visitor
from .test_pages import serious, settle


@pytest.mark.parametrize("visitor", [(THERAPIST, 1440)], indirect=True)
def test_a_band_is_drawn_on_one_phase_and_prescribed(visitor: Visitor, house: House) -> None:
    page = visitor.page
    page.goto(f"{house.address}/exercises/{house.exercise_id}?patient={house.patient_id}")
    settle(visitor)
    page.get_by_role("link", name="Edit the template").first.click()
    page.get_by_role("button", name="Suggest phases").click()
    page.get_by_role("button", name=re.compile("^Trunk forward lean")).click()
    upper = page.get_by_role("slider", name="Way out: upper limit")
    before = float(upper.get_attribute("aria-valuenow") or "nan")
    upper.press("ArrowDown")
    upper.press("ArrowDown")
    assert float(upper.get_attribute("aria-valuenow") or "nan") == pytest.approx(before - 2.0, abs=0.11)
    page.get_by_role("button", name="Add a limit").click()
    visitor.picture("template-editor-1440")
    assert serious(visitor) == []
    for width in (1024, 390):
        page.set_viewport_size({"width": width, "height": 900})
        page.wait_for_timeout(300)
        visitor.picture(f"template-editor-{width}")
        assert page.evaluate("document.documentElement.scrollWidth <= window.innerWidth"), width
    page.set_viewport_size({"width": 1440, "height": 900})
    page.get_by_label("Why this version?").fill("Leans early")
    page.get_by_role("button", name=re.compile("Save as version")).click()
    page.get_by_text("History: 2 versions").click()
    expect(page.get_by_role("listitem").filter(has_text="Leans early")).to_be_visible()
    visitor.picture("template-card-1440")

    page.goto(f"{house.address}/patients/{house.patient_id}")
    settle(visitor)
    page.get_by_role("button", name="Prescribe").click()
    dialog = page.get_by_role("dialog")
    dialog.get_by_role("combobox", name="Exercise").click()
    page.get_by_role("option").first.click()
    for day in ("Mon", "Wed", "Fri"):
        dialog.get_by_text(day, exact=True).click()
    dialog.get_by_role("button", name="Add a time").click()
    visitor.picture("prescribe-1440")
    assert serious(visitor) == []
    dialog.get_by_role("button", name="Prescribe").click()
    expect(page.get_by_text("Mon, Wed and Fri at 09:00")).to_be_visible()
    assert visitor.faults_outside_the_view() == []
