"""What stands in a patient's record, as a browser in any zone shows and prints it, and how she is found."""

import re
from collections.abc import Iterator

import httpx
import pytest
from playwright.sync_api import Browser, Page, expect

from app.demo.people import PASSWORD, PATIENTS, THERAPIST
from tests.e2e.conftest import Service, serving
from tests.patience import PATIENCE_S

ASSESSMENT = ("The patient reaches with less help of the trunk. " * 90)[:3900]
SHEETS = re.compile(rb"/Type\s*/Page[^s]")


@pytest.fixture(scope="module")
def service(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Service]:
    with serving(tmp_path_factory.mktemp("records")) as running:
        yield running


@pytest.fixture(scope="module")
def client(service: Service) -> Iterator[httpx.Client]:
    with httpx.Client(
        base_url=service.address, headers={"Origin": service.address}, timeout=PATIENCE_S
    ) as one:
        answer = one.post("/api/sign-in", json={"email": THERAPIST, "password": PASSWORD})
        one.headers["X-CSRF-Token"] = answer.raise_for_status().json()["csrf_token"]
        yield one


@pytest.fixture
def open_page(chromium: Browser, service: Service) -> Iterator[object]:
    contexts = []

    def opened(path: str, **context: object) -> Page:
        contexts.append(chromium.new_context(**{"locale": "en-GB"} | context))  # type: ignore[arg-type]
        asked = contexts[-1].request.post(
            f"{service.address}/api/sign-in",
            data={"email": THERAPIST, "password": PASSWORD},
            headers={"Origin": service.address},
        )
        assert asked.ok
        page = contexts[-1].new_page()
        page.goto(service.address + path)
        return page

    yield opened
    for one in contexts:
        one.close()


@pytest.fixture(scope="module")
def patient_id(client: httpx.Client) -> str:
    found = client.get("/api/patients").json()
    return str(next(one["id"] for one in found if one["given_name"] == PATIENTS[0].given_name))


@pytest.fixture(scope="module")
def exercise_id(client: httpx.Client) -> str:
    found = client.get("/api/exercises").json()
    return str(next(one["id"] for one in found if one["name"].startswith("Reach forward")))


@pytest.mark.parametrize(
    "zone", ["America/New_York", "America/Los_Angeles", "Europe/Oslo", "Pacific/Auckland"]
)
def test_a_day_of_birth_is_the_same_everywhere_and_on_paper(
    open_page, patient_id: str, exercise_id: str, zone: str
) -> None:
    page = open_page(f"/patients/{patient_id}", timezone_id=zone)
    expect(page.get_by_text("14 Mar 1957")).to_be_visible()
    page.goto(f"{page.url}/report?exercise={exercise_id}")
    head = page.locator(".paper-head").first
    expect(head).to_contain_text("born 14 Mar 1957")
    page.emulate_media(media="print")
    expect(head).to_contain_text("born 14 Mar 1957")


def test_each_sheet_of_a_long_report_has_name_and_number(
    open_page, client: httpx.Client, patient_id: str, exercise_id: str
) -> None:
    """Four thousand characters on A4: the words go on overleaf, and nothing of them is lost."""
    # A person writes in paragraphs and without.
    for words, least in ((ASSESSMENT, 1), (f"{ASSESSMENT[:1900]}\n\n" + "Line.\n" * 110, 2)):
        note = {"exercise_id": exercise_id, "text": words}
        client.post(f"/api/patients/{patient_id}/course-notes", json=note).raise_for_status()
        page = open_page(f"/patients/{patient_id}/report?exercise={exercise_id}")
        expect(page.get_by_text("The patient reaches").first).to_be_visible()
        # Laid out after the last change.
        page.wait_for_timeout(800)
        page.emulate_media(media="print")
        seen = page.inner_text("body")
        sheets = SHEETS.findall(page.pdf(format="A4", print_background=True))
        assert len(sheets) >= least
        assert re.findall(r"page (\d+)", seen) == [str(number + 1) for number in range(len(sheets))]
        assert seen.count("Amara Okafor") == len(sheets)
        assert seen.count("reaches with less help") == words.count("reaches with less help")
        assert seen.count("Line.") == words.count("Line.")


def test_a_long_name_is_found_as_it_is_typed_and_leaves_the_caseload_its_width(
    open_page, client: httpx.Client, exercise_id: str
) -> None:
    made = client.post(
        "/api/patients",
        json={
            "given_name": "O\u2019Brien",
            "family_name": "van der Berg-\u0141ukasiewicz",
            "agrees_to_treatment": True,
        },
    )
    person = made.raise_for_status().json()["id"]
    for one in client.get("/api/exercises").json()[:3]:
        dose = {"exercise_id": one["id"], "repetitions": 10, "times_per_week": 3}
        client.post(f"/api/patients/{person}/prescriptions", json=dose).raise_for_status()
    for language, width in (
        ("de-DE", 1440),
        ("de-DE", 1280),
        ("en-GB", 1280),
        ("de-DE", 1160),
        ("en-GB", 1024),
    ):
        page = open_page("/", viewport={"width": width, "height": 800}, locale=language)
        name = page.get_by_role("row").filter(has_text="ukasiewicz")
        expect(name).to_be_visible()
        table = page.locator("table").first
        assert page.evaluate("document.documentElement.scrollWidth - innerWidth") <= 0, (language, width)
        assert table.evaluate("one => one.scrollWidth - one.parentElement.clientWidth") <= 1, (
            language,
            width,
        )
        for words in ("O'Brien", "OBrien", "lukasiewicz", "o\u2019brien"):
            page.locator(".search input").fill(words)
            expect(page.locator("table tbody tr")).to_have_count(1)
            expect(name).to_be_visible()
