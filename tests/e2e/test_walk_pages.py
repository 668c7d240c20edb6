"""A real walk from its file to footprints, strides and conditions, in a real browser."""

from pathlib import Path

import numpy as np
import pytest
from playwright.sync_api import expect

from app.commands.upload import finished, send
from app.demo.people import PASSWORD, THERAPIST
from app.gateway import ServiceClient
from app.recordings.schemas import UploadIn
from tests.e2e.conftest import House, Visitor, apart
from tests.e2e.test_pages import serious, settle

FEET = Path(__file__).parents[1] / "data" / "feet"
SECONDS, RATE_HZ = 20.0, 204.8
SCROLLED_SIDEWAYS = """() => [...document.querySelectorAll('.table-scroll, .map-scroll')]
  .filter((e) => innerWidth < 500 || e.matches('.table-scroll'))
  .filter((e) => e.scrollWidth > e.clientWidth + 1).map((e) => `${e.textContent.slice(0, 30)}: ${e.scrollWidth}`)"""
"""Tables, and on a telephone the map, that are wider than their place."""


@pytest.fixture(scope="module")
def walk_ids(house: House, tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    """Upload the beginning of a real walk twice; return the sessions."""
    path = tmp_path_factory.mktemp("walk") / "walk.csv"
    content = np.load(FEET / "gaitmap_strides.npz")
    ticks = int(SECONDS * RATE_HZ)
    columns = [np.arange(ticks)[:, None]]
    for side in ("left", "right"):
        columns.append(content[f"accelerometer_{side}_mps2"][:ticks])
        columns.append(np.degrees(content[f"gyroscope_{side}_radps"][:ticks].astype(float)))
    axes = ("acc_x", "acc_y", "acc_z", "gyr_x", "gyr_y", "gyr_z")
    head = "," + ",".join(f"{side}_sensor" for side in ("left", "right") for _ in axes)
    head += "\n," + ",".join(axes * 2)
    np.savetxt(path, np.concatenate(columns, axis=1), delimiter=",", header=head, comments="", fmt="%.6g")

    async def upload() -> list[str]:
        async with ServiceClient(house.address) as service:
            await service.sign_in(THERAPIST, PASSWORD)
            found = []
            for _ in range(2):
                declaration = UploadIn(patient_id=house.patient_id, format="gaitmap")
                job = await send(service, path, declaration)
                await finished(service, job.session_id)
                found.append(job.session_id)
            return found

    made: list[str] = apart(upload())
    return made


@pytest.mark.parametrize("visitor", [(THERAPIST, 1440), (THERAPIST, 390)], indirect=True)
def test_a_walk_is_read_by_keyboard_and_laid_beside_another(
    visitor: Visitor, house: House, walk_ids: list[str]
) -> None:
    page = visitor.page
    width = page.viewport_size["width"]  # type: ignore[index]
    page.goto(f"{house.address}/sessions/{walk_ids[0]}/gait?before={walk_ids[1]}")
    settle(visitor)
    expect(page.get_by_role("heading", name="Footprints")).to_be_visible()
    assert page.locator(".print-left path").count() > 5
    expect(page.get_by_role("columnheader", name="Left, before")).to_be_visible()
    chosen = page.get_by_role("button", name="Left foot, stride 3: show in the map")
    chosen.focus()
    page.keyboard.press("Enter")
    expect(page.locator(".print[data-selected]")).to_have_count(2)
    assert serious(visitor) == []
    overflow = page.evaluate("() => document.documentElement.scrollWidth - window.innerWidth")
    assert overflow <= 0, "the page scrolls sideways"
    for narrower in {1440: (1440, 1024, 800), 390: (390,)}[width]:
        page.set_viewport_size({"width": narrower, "height": 900})
        page.wait_for_timeout(300)
        assert page.evaluate(SCROLLED_SIDEWAYS) == [], narrower
    visitor.picture(f"gait-{width}")
    page.goto(f"{house.address}/patients/{house.patient_id}/walks")
    settle(visitor)
    groups = page.get_by_role("radiogroup")
    groups.nth(0).get_by_text("Eyes open").click()
    groups.nth(1).get_by_text("Eyes closed").click()
    expect(page.get_by_text("no clear difference").first).to_be_visible()
    assert serious(visitor) == []
    visitor.picture(f"conditions-{width}")
    assert visitor.faults_outside_the_view() == []
