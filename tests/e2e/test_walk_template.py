"""The template of a walk in a real browser: recorded, drawn on, prescribed, found again in comparison and report."""

import re
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import expect

from app import readers
from app.commands.upload import finished, send
from app.demo.people import PASSWORD, THERAPIST
from app.gateway import ServiceClient
from app.network.packet_log import write_log
from app.recordings.schemas import UploadIn
from estimators.simulation import SimulatedWalk, WalkStyle
from tests.app.assessment.templates.walked import both, walked
from tests.e2e.conftest import House, Visitor, apart
from tests.e2e.languages.test_german import fits, german, left_in_english, written_by_people
from tests.e2e.test_pages import serious, settle

__all__ = ["german"]

WIDTHS = (390, 1024, 1440)


def written(made: SimulatedWalk, path: Path) -> Path:
    prepared = readers.packets_of(made.recording)
    path.write_bytes(b"".join(write_log(prepared.declaration.to_dict(), prepared.packets(1))))
    return path


@pytest.fixture(scope="module")
def walks(house: House, tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """Upload the therapist's walk, and later one whose feet are lifted less; return exercise and sessions."""
    folder = tmp_path_factory.mktemp("walks")

    async def upload() -> dict[str, str]:
        async with ServiceClient(house.address) as service:
            await service.sign_in(THERAPIST, PASSWORD)
            body = {"name": "High feet", "movement": "walk"}
            made: dict[str, Any] = (await service.http.post("/api/exercises", json=body)).json()
            found = {"exercise": str(made["id"])}
            styles = (("shown", WalkStyle(), "template"), ("low", both(clearance_m=0.02), "exercise"))
            for seed, (name, style, purpose) in enumerate(styles, start=1):
                declaration = UploadIn(
                    patient_id=house.patient_id,
                    exercise_id=found["exercise"],
                    format="packet_log",
                    pipeline="gait",
                    purpose="template" if purpose == "template" else "exercise",
                )
                job = await send(service, written(walked(style, seed), folder / f"{name}.bnp"), declaration)
                await finished(service, job.session_id)
                found[name] = job.session_id
            return found

    made: dict[str, str] = apart(upload())
    return made


def seen(visitor: Visitor, name: str) -> None:
    """Keep pictures of three widths; none scrolls sideways."""
    page = visitor.page
    for width in WIDTHS:
        page.set_viewport_size({"width": width, "height": 900})
        page.wait_for_timeout(400)
        visitor.picture(f"{name}-{width}")
        assert page.evaluate("document.documentElement.scrollWidth <= window.innerWidth"), (name, width)


@pytest.mark.parametrize("visitor", [(THERAPIST, 1440)], indirect=True)
def test_the_template_of_a_walk_goes_the_way_of_all_templates(
    visitor: Visitor, house: House, walks: dict[str, str]
) -> None:
    page = visitor.page
    page.goto(f"{house.address}/templates/record?session={walks['shown']}&exercise={walks['exercise']}")
    settle(visitor)
    expect(page.get_by_text("Stride 2", exact=True)).to_be_visible()
    expect(page.get_by_text("The last stride before standing still.")).to_be_visible()
    page.get_by_role("radio", name="Right foot").check(force=True)
    settle(visitor)
    for curve in ("Foot height", "Foot pitch", "Forward speed of the foot"):
        expect(page.get_by_role("heading", name=curve)).to_be_visible()
    assert serious(visitor) == []
    seen(visitor, "walk-template-record")
    page.get_by_role("button", name="Save template").click()

    page.get_by_role("link", name="Edit the template").click()
    settle(visitor)
    expect(page.get_by_label("Name of phase 1")).to_have_value("Stance")
    expect(page.get_by_label("Name of phase 2")).to_have_value("Swing")
    expect(page.get_by_role("heading", name="What stops the exercise")).to_have_count(0)
    lower = page.get_by_role("slider", name="Swing: lower limit")
    lower.press("ArrowDown")
    assert serious(visitor) == []
    seen(visitor, "walk-template-editor")
    page.get_by_label("Why this version?").fill("A little lower is fine")
    page.get_by_role("button", name=re.compile("Save as version")).click()
    expect(page.get_by_text("History: 2 versions")).to_be_visible()
    seen(visitor, "walk-template-card")

    page.goto(f"{house.address}/patients/{house.patient_id}")
    settle(visitor)
    page.set_viewport_size({"width": 1440, "height": 900})
    page.get_by_role("button", name="Prescribe").click()
    dialog = page.get_by_role("dialog")
    dialog.get_by_role("combobox", name="Exercise").click()
    page.get_by_role("option", name="High feet").click()
    expect(dialog.get_by_text("nothing is counted during the walk")).to_be_visible()
    assert serious(visitor) == []
    seen(visitor, "walk-template-prescribe")
    page.keyboard.press("Escape")

    page.goto(f"{house.address}/sessions/{walks['low']}?show=compare")
    settle(visitor)
    page.get_by_role("button", name="Compare now").click()
    expect(page.get_by_text("The foot was lifted less than in the template").first).to_be_visible()
    expect(page.get_by_text("Mostly in: Swing.").first).to_be_visible()
    settle(visitor)
    assert serious(visitor) == []
    seen(visitor, "walk-template-compare")

    page.get_by_role("tab", name="Curves").click()
    expect(page.get_by_text("Every stride with the template and its band")).to_be_visible()
    page.get_by_role("button", name=re.compile("^Stride 4")).first.click()
    page.wait_for_timeout(1500)
    assert serious(visitor) == []
    seen(visitor, "walk-template-curves")

    page.goto(f"{house.address}/sessions/{walks['low']}/report")
    settle(visitor)
    expect(page.get_by_text("The foot was lifted less than in the template").first).to_be_visible()
    assert serious(visitor) == []
    seen(visitor, "walk-template-report")
    assert visitor.faults_outside_the_view() == []


@pytest.mark.parametrize("german", [(THERAPIST, 1440)], indirect=True)
def test_the_pages_of_a_walks_template_are_german(
    german: Visitor, house: House, walks: dict[str, str]
) -> None:
    page = german.page

    async def compare() -> str:
        async with ServiceClient(house.address) as service:
            await service.sign_in(THERAPIST, PASSWORD)
            body = {
                "session_id": walks["shown"],
                "exercise_id": walks["exercise"],
                "name": "Walk, drawn",
                "phases": [
                    {"name": "Stand", "start": 0.0, "end": 0.62},
                    {"name": "Schwung", "start": 0.62, "end": 1.0},
                ],
            }
            made = (await service.http.post("/api/templates", json=body)).json()
            answer = await service.http.post(
                f"/api/sessions/{walks['low']}/comparisons", json={"template_version_id": made["id"]}
            )
            assert answer.is_success, answer.text
            return str(made["id"])

    version_id = apart(compare())
    for name, path in (
        ("record", f"/templates/record?session={walks['shown']}&exercise={walks['exercise']}"),
        ("editor", f"/templates/versions/{version_id}"),
        ("compare", f"/sessions/{walks['low']}?show=compare"),
        ("curves", f"/sessions/{walks['low']}?show=angles"),
        ("report", f"/sessions/{walks['low']}/report"),
    ):
        page.goto(house.address + path)
        settle(german)
        page.wait_for_load_state("networkidle")
        page.wait_for_timeout(500)
        german.picture(f"de-walk-template-{name}")
        assert left_in_english(page, written_by_people(page, house)) == [], name
        assert fits(page), name
    assert german.faults_outside_the_view() == []
