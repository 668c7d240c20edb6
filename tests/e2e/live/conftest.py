"""For each file of tests: a service behind a relay that a test may break, and sensors that stream for some minutes."""

import os
import subprocess
import sys
from collections.abc import Iterator

import pytest
from playwright.sync_api import Browser

from app.demo.people import PASSWORD, THERAPIST
from tests.e2e.conftest import ROOT, Service, Visitor, serving
from tests.e2e.sensors.broken_link import Relay, relaying
from tests.e2e.test_live_truth import patient_of


@pytest.fixture(scope="module")
def relay() -> Iterator[Relay]:
    with relaying() as one:
        yield one


@pytest.fixture(scope="module")
def service(relay: Relay, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Service]:
    with serving(tmp_path_factory.mktemp("live"), base_url=relay.address) as one:
        relay.serve(one.address)
        yield one


@pytest.fixture(scope="module")
def gateway(service: Service) -> Iterator[None]:
    """Sensors that stream for some minutes, and not through the relay: they stand beside the service."""
    words = ["-m", "app.cli", "simulate", "--movement", "drinking", "--repetitions", "120"]
    process = subprocess.Popen(
        [sys.executable, *words, "--server", service.address, "--patient", patient_of(service)],
        cwd=ROOT,
        env={**os.environ, "TELEMOTION_EMAIL": THERAPIST, "TELEMOTION_PASSWORD": PASSWORD},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    yield
    process.kill()
    process.wait()


def opened(browser: Browser, address: str, email: str, path: str, width: int) -> Visitor:
    """Sign in on a wide page, whose menu is open, and go to a path at a width of a screen, px."""
    context = browser.new_context(viewport={"width": 1440, "height": 900})
    visitor = Visitor(context.new_page(), address)
    visitor.sign_in(email)
    visitor.page.set_viewport_size({"width": width, "height": 900 if width > 600 else 844})
    visitor.page.goto(f"{address}{path}")
    return visitor
