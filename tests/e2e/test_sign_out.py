"""Signing out on a telephone whose link is gone: said, and done before the page shows anything again."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Page, expect

from app.demo.people import PASSWORD, PATIENTS

from .conftest import PICTURES, Service, serving

WORDS = {
    "en-GB": (
        "E-mail",
        "Password",
        "Menu",
        "Sign out",
        "You are still signed in on this device",
        "Try again",
        "Sign in",
    ),
    "de-DE": (
        "E-Mail-Adresse",
        "Passwort",
        "Menü",
        "Abmelden",
        "Sie sind auf diesem Gerät noch angemeldet",
        "Erneut versuchen",
        "Anmelden",
    ),
}


@pytest.fixture(scope="module")
def service(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Service]:
    with serving(tmp_path_factory.mktemp("signing-out")) as running:
        yield running


@contextmanager
def phone(chromium: Browser, language: str) -> Iterator[Page]:
    context = chromium.new_context(viewport={"width": 390, "height": 844}, locale=language)
    yield context.new_page()
    context.close()


@pytest.mark.parametrize("language", WORDS)
def test_a_sign_out_without_a_link_is_said_and_done_when_the_link_is_back(
    chromium: Browser, service: Service, language: str
) -> None:
    email, password, menu, sign_out, still, again, sign_in = WORDS[language]
    with phone(chromium, language) as page:
        page.goto(service.address)
        page.get_by_label(email).fill(PATIENTS[0].email)
        page.get_by_label(password, exact=True).fill(PASSWORD)
        page.keyboard.press("Enter")
        page.get_by_role("button", name=menu).click()
        page.context.set_offline(True)
        page.get_by_role("menuitem", name=sign_out).click()
        expect(page.get_by_role("heading", name=still)).to_be_visible()
        expect(page.get_by_role("button", name=again)).to_be_visible()
        keep(page, f"signing-out-{language}")
        assert page.get_by_role("navigation").count() == 0
        page.get_by_role("button", name=again).click()
        expect(page.get_by_role("heading", name=still)).to_be_visible()
        # The next person opens the page when the link is back: nothing is asked or shown before the sign-out is done.
        page.close()
        page.context.set_offline(False)
        page = page.context.new_page()
        asked: list[str] = []
        page.on("request", lambda one: "/api/" in one.url and asked.append(one.url.rpartition("/api/")[2]))
        page.goto(service.address)
        expect(page.get_by_role("heading", name=sign_in)).to_be_visible()
        assert asked[:2] == ["me", "sign-out"]
        assert set(asked) == {"me", "sign-out"}
        assert page.evaluate("fetch('/api/me').then((answer) => answer.status)") == 401
        assert page.evaluate("localStorage.getItem('telemotion.signOut')") is None
        keep(page, f"signed-out-{language}")


def keep(page: Page, name: str) -> None:
    Path(PICTURES).mkdir(parents=True, exist_ok=True)
    page.screenshot(path=PICTURES / f"{name}.png")
