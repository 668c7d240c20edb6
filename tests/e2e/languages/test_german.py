"""The main pages read in German, in a browser that asks for it: no word of the English catalogue is left on them."""

import re
from collections.abc import Iterator
from functools import cache
from typing import Any

import pytest
from playwright.sync_api import Browser, Page

from app.demo.people import PATIENTS, THERAPIST
from estimators.sentences._message import Message, Place, parsed
from tests.e2e.conftest import ROOT, House, Visitor
from tests.e2e.test_pages import settle
from tests.words import ENGLISH, GERMAN, titles

KEY = re.compile(r"^\s+'[\w.]+':\s*(.+?)(?=^\s+'[\w.]+':|^\})", re.MULTILINE | re.DOTALL)
QUOTED = re.compile(r"'((?:[^'\\]|\\.)*)'")
PLACE = re.compile(r"\{[^}]*\}")
SHOWN = """() => {
  const found = [];
  const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  for (let node = walker.nextNode(); node; node = walker.nextNode())
    if (node.parentElement?.checkVisibility() && !/^(script|style|noscript)$/i.test(node.parentElement.tagName))
      found.push(node.textContent);
  for (const name of ['aria-label', 'title', 'placeholder', 'alt'])
    for (const one of document.querySelectorAll(`[${name}]`)) found.push(one.getAttribute(name));
  return found.map((one) => one.replace(/\\s+/g, ' ').trim()).filter(Boolean);
}"""
PAGES = (
    (PATIENTS[0].email, "today", "/"),
    (PATIENTS[0].email, "results", "/my/results"),
    (PATIENTS[0].email, "data", "/my/data"),
    (PATIENTS[0].email, "account", "/account"),
    (PATIENTS[0].email, "replay", "/my/sessions/{session_id}"),
    (THERAPIST, "caseload", "/"),
    (THERAPIST, "patient", "/patients/{patient_id}"),
    (THERAPIST, "new-session", "/patients/{patient_id}/sessions/new"),
    (THERAPIST, "session", "/sessions/{session_id}"),
    (THERAPIST, "report", "/sessions/{session_id}/report"),
    (THERAPIST, "course", "/patients/{patient_id}/report?exercise={exercise_id}"),
    (THERAPIST, "exercises", "/exercises"),
    (THERAPIST, "upload", "/upload"),
)


def catalogue(language: str) -> set[str]:
    """Every text of the pages and of the service's sentences in a language."""
    found = set()
    files = [
        *(ROOT / "web/src/i18n" / language).rglob("*.ts"),
        *ROOT.glob(f"web/src/kinds/*/words/{language}.ts"),
    ]
    for path in files:
        for entry in KEY.findall(path.read_text()):
            found |= {text.replace("\\'", "'") for text in QUOTED.findall(entry)}
    for message in GERMAN.values() if language == "de" else ENGLISH.values():
        found |= shown(parsed(message))
    return found if language == "de" else found | set(titles().values())


def shown(message: Message) -> set[str]:
    """Each way in which a message is written; its places are empty braces."""
    texts = {""}
    for part in message:
        if isinstance(part, str):
            ways = {part}
        else:
            ways = {"{}"} if isinstance(part, Place) else set().union(*map(shown, part.branches.values()))
        texts = {text + way for text in texts for way in ways}
    return texts


def patterns(texts: set[str]) -> list[re.Pattern[str]]:
    """What a text looks like on a page, whatever stands in its places; a text of hardly more than places is none."""
    return [
        re.compile(".+".join(re.escape(part) for part in PLACE.split(text)) + r"\.?", re.IGNORECASE)
        for text in texts
        if re.search(r"[a-z]{3}", PLACE.sub(" ", text))
    ]


@cache
def english_texts() -> list[re.Pattern[str]]:
    return patterns(catalogue("en") - catalogue("de"))


@cache
def german_texts() -> list[re.Pattern[str]]:
    return patterns(catalogue("de"))


STOP = re.compile(
    r"\b(the|and|of|with|your|you|is|are|this|that|to|for|from|not|by|on|it|or|be|has|have|when|which|than"
    r"|repetitions?|sessions?|week|times|elbow|shoulder|forearm|wrist|trunk|flexion|elevation|range|hand path)\b",
    re.IGNORECASE,
)
"""English words that no German text has, for what the service puts together."""


def left_in_english(page: Page, data: set[str]) -> list[str]:
    """What the page shows that is English, apart from what people wrote."""
    found = set()
    for shown in page.evaluate(SHOWN):
        text = shown
        for one in sorted(data, key=len, reverse=True):
            text = text.replace(one, " ")
        is_ours = any(one.fullmatch(shown) for one in english_texts())
        if (
            is_ours and not any(one.fullmatch(shown) for one in german_texts()) and text.strip()
        ) or STOP.search(text):
            found.add(shown)
    return sorted(found)


@pytest.fixture
def german(
    chromium: Browser, house: House, signed_in: dict[str, Any], request: pytest.FixtureRequest
) -> Iterator[Visitor]:
    """A visitor whose browser asks for German; signed in where the parameter has an address."""
    email, width = request.param
    context = chromium.new_context(
        viewport={"width": width, "height": 900 if width > 600 else 844},
        locale="de-DE",
        reduced_motion="reduce",
        storage_state=signed_in[email] if email else None,
    )
    yield Visitor(context.new_page(), house.address)
    context.close()


def written_by_people(page: Page, house: House) -> set[str]:
    """Names, descriptions and notes: data, in whatever language they were written."""
    found: set[str] = set()

    def collect(value: Any) -> None:
        if isinstance(value, list):
            for one in value:
                collect(one)
        elif isinstance(value, dict):
            found.update(str(value[key]) for key in ("name", "description", "notes") if value.get(key))
            for one in value.values():
                collect(one)

    for path in (
        "exercises",
        "templates",
        f"templates?patient_id={house.patient_id}",
        f"patients/{house.patient_id}",
        f"patients/{house.patient_id}/prescriptions",
    ):
        answer = page.request.get(f"{house.address}/api/{path}")
        if answer.ok:
            collect(answer.json())
    # As a page shows it: white space runs together.
    return {" ".join(one.split()) for one in found if len(one) > 3}


def fits(page: Page) -> bool:
    """Whether nothing is wider than the page: German words are longer."""
    return bool(page.evaluate("document.documentElement.scrollWidth <= window.innerWidth + 1"))


@pytest.mark.parametrize(
    ("german", "name", "path"),
    [((email, width), f"{name}-{width}", path) for email, name, path in PAGES for width in (390, 1440)],
    indirect=["german"],
    ids=[f"{name}-{width}" for _, name, _ in PAGES for width in (390, 1440)],
)
def test_a_page_is_german(german: Visitor, house: House, name: str, path: str) -> None:
    page = german.page
    page.goto(house.address + path.format(**vars(house)))
    page.wait_for_load_state("networkidle")
    settle(german)
    german.picture(f"de-{name}")
    assert page.evaluate("document.documentElement.lang") == "de"
    assert left_in_english(page, written_by_people(page, house)) == []
    assert fits(page)
    assert german.faults_outside_the_view() == []


@pytest.mark.parametrize("german", [(None, 390)], indirect=True)
def test_the_language_is_chosen_before_signing_in(german: Visitor, house: House) -> None:
    page = german.page
    page.goto(house.address + "/sign-in")
    page.get_by_role("heading", name="Anmelden").wait_for()
    german.picture("de-sign-in-390")
    assert left_in_english(page, set()) == []
    assert fits(page)
    page.get_by_label("Sprache").select_option("en")
    page.get_by_role("heading", name="Sign in").wait_for()
    assert page.evaluate("document.documentElement.lang") == "en"
    page.get_by_label("Language").select_option("")
    page.get_by_role("heading", name="Anmelden").wait_for()


def test_an_english_page_would_be_found() -> None:
    assert any(one.fullmatch("Find a patient") for one in english_texts())
    assert not any(one.fullmatch("Find a patient") for one in german_texts())
    assert any(one.fullmatch("3 patients shown") for one in english_texts())
