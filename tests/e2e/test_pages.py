"""Every page, at three widths: no serious accessibility violation, no error, all of it reachable by keyboard."""

from typing import Any

import pytest
from playwright.sync_api import Browser, Page

from app.demo.people import ADMINISTRATOR, PATIENTS, THERAPIST
from tests.e2e.conftest import ROOT, House, Visitor

PATIENT = PATIENTS[0].email
TABLET = 1024
AXE = ROOT / "web" / "node_modules" / "axe-core" / "axe.min.js"

THERAPIST_PAGES = {
    "caseload": "/",
    "patient": "/patients/{patient_id}",
    "patient-new": "/patients/new",
    "session-new": "/patients/{patient_id}/sessions/new",
    "session": "/sessions/{session_id}",
    "report": "/sessions/{session_id}/report",
    "estimators": "/sessions/{session_id}/estimators",
    "template-record": "/templates/record?patient={patient_id}",
    "exercises": "/exercises",
    "exercise": "/exercises/{exercise_id}",
    "upload": "/upload",
    "accuracy": "/accuracy",
    "account": "/account",
    "not-found": "/nothing-here",
}
ADMINISTRATOR_PAGES = {"clinic": "/clinic", "patient-managed": "/patients/{patient_id}"}
PATIENT_PAGES = {"my-today": "/", "my-results": "/my/results", "my-data": "/my/data"}

PAGES_OF = {THERAPIST: THERAPIST_PAGES, ADMINISTRATOR: ADMINISTRATOR_PAGES, PATIENT: PATIENT_PAGES}
WITHOUT_KEYBOARD = {"not-found", "patient-managed"}
"""Pages without anything of their own to reach."""
CASES = [
    pytest.param((email, width), name, path, id=f"{name}-{width}")
    for email, pages in PAGES_OF.items()
    for name, path in pages.items()
    for width in (1440, 390)
]


def serious(visitor: Visitor) -> list[str]:
    """Serious and critical violations of WCAG 2.2 A and AA on what is shown now."""
    visitor.page.evaluate(AXE.read_text())
    result: dict[str, Any] = visitor.page.evaluate(
        """() => axe.run(document, {
            runOnly: ['wcag2a', 'wcag2aa', 'wcag21a', 'wcag21aa', 'wcag22aa'], iframes: false })"""
    )
    return [
        f"{violation['id']}: {violation['nodes'][0]['html'][:160]}"
        for violation in result["violations"]
        if violation["impact"] in ("serious", "critical")
    ]


def settle(visitor: Visitor) -> None:
    """Wait until the page has its heading and no placeholder is left."""
    visitor.page.get_by_role("heading", level=1).first.wait_for()
    visitor.page.wait_for_function("() => !document.querySelector('.mantine-Skeleton-root')")
    visitor.page.wait_for_timeout(300)


@pytest.mark.parametrize(("visitor", "name", "path"), CASES, indirect=["visitor"])
def test_page(visitor: Visitor, house: House, name: str, path: str) -> None:
    visitor.page.goto(house.address + path.format(**vars(house)))
    settle(visitor)
    assert "sign-in" not in visitor.page.url
    width = visitor.page.viewport_size["width"]  # type: ignore[index]
    visitor.picture(f"{name}-{width}")
    assert visitor.faults_outside_the_view() == []
    assert serious(visitor) == []
    assert overflow(visitor) <= 0, "the page scrolls sideways"
    if width > TABLET:
        assert name in WITHOUT_KEYBOARD or unreached_by_tab(visitor.page) == []
        visitor.page.set_viewport_size({"width": TABLET, "height": 768})
        visitor.page.wait_for_timeout(200)
        visitor.picture(f"{name}-{TABLET}")
        assert overflow(visitor) <= 0, "the page scrolls sideways on a tablet"


def overflow(visitor: Visitor) -> int:
    """Pixels by which the page is wider than its window."""
    return int(visitor.page.evaluate("() => document.documentElement.scrollWidth - window.innerWidth"))


@pytest.mark.parametrize("visitor", [(THERAPIST, 390)], indirect=True)
def test_sign_in_page(visitor: Visitor, house: House) -> None:
    visitor.page.context.clear_cookies()
    visitor.page.goto(house.address + "/sign-in")
    settle(visitor)
    visitor.picture("sign-in-390")
    assert serious(visitor) == []


def test_what_turns_the_3d_view_is_as_large_as_a_thumb(
    chromium: Browser, house: House, signed_in: dict[str, Any]
) -> None:
    context = chromium.new_context(
        viewport={"width": 390, "height": 844},
        has_touch=True,
        is_mobile=True,
        reduced_motion="reduce",
        storage_state=signed_in[THERAPIST],
    )
    visitor = Visitor(context.new_page(), house.address)
    visitor.page.goto(f"{house.address}/sessions/{house.session_id}")
    visitor.page.locator(".camera-bar button").first.wait_for()
    settle(visitor)
    visitor.picture("session-touch-390")
    small = visitor.page.evaluate(
        """() => [...document.querySelectorAll('.camera-bar :is(button, label), .repetition-row button')]
            .map((e) => [e.getAttribute('aria-label') ?? e.textContent, e.getBoundingClientRect()])
            .filter(([, box]) => box.height < 44 || box.width < 44)
            .map(([name, box]) => [name, box.width, box.height])"""
    )
    assert small == []
    assert overflow(visitor) <= 0
    context.close()


MOST_TABS, TABS_AT_ONCE = 220, 20

REACHED = """() => {
  const wanted = 'a[href], button, input, select, textarea, summary, [tabindex="0"]';
  const shown = (e) => !e.disabled && e.checkVisibility({ visibilityProperty: true }) && !e.closest('[inert]')
    && e.tabIndex >= 0 && !(e.type === 'radio' && !e.checked);
  return [...document.querySelectorAll(wanted)].filter(shown).filter((e) => !e.dataset.reached)
    .map((e) => e.outerHTML.slice(0, 140));
}"""


def unreached_by_tab(page: Page) -> list[str]:
    """What a keyboard alone does not come to."""
    page.evaluate(
        """() => document.addEventListener('focusin', (event) => {
            event.target.dataset.reached = '1';
            const group = event.target.type === 'radio' && event.target.name;
            if (group) document.getElementsByName(group).forEach((one) => { one.dataset.reached = '1'; });
        })"""
    )
    unreached = ["not looked at yet"]
    for _ in range(MOST_TABS // TABS_AT_ONCE):
        for _ in range(TABS_AT_ONCE):
            page.keyboard.press("Tab")
        unreached = page.evaluate(REACHED)
        if not unreached:
            break
    return unreached


def test_focus_is_visible(visitor: Visitor, house: House) -> None:
    page = visitor.page
    page.goto(house.address + "/")
    settle(visitor)
    for _ in range(6):
        page.keyboard.press("Tab")
        outlined = page.evaluate(
            """() => { const s = getComputedStyle(document.activeElement);
                return s.outlineStyle !== 'none' && parseFloat(s.outlineWidth) >= 2 || s.boxShadow !== 'none'; }"""
        )
        assert outlined, page.evaluate("document.activeElement.outerHTML.slice(0, 200)")
