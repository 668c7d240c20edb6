"""A patient at home behind a link that breaks, and her therapist: for each file of tests a service of its own."""

from collections.abc import Iterator

import httpx
import pytest
from playwright.sync_api import Browser

from app.demo.people import PATIENTS
from tests.e2e.conftest import Service, Visitor, serving
from tests.e2e.sensors import sensors_at_home as home
from tests.e2e.sensors.broken_link import Relay, relaying


@pytest.fixture(scope="module")
def relay() -> Iterator[Relay]:
    with relaying() as one:
        yield one


@pytest.fixture(scope="module")
def service(relay: Relay, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Service]:
    with serving(tmp_path_factory.mktemp("home"), base_url=relay.address) as one:
        relay.serve(one.address)
        yield one


@pytest.fixture(scope="module")
def therapist(service: Service, relay: Relay) -> Iterator[httpx.Client]:
    with home.therapist_at(relay.address) as client:
        yield client


@pytest.fixture
def patient(chromium: Browser, relay: Relay, service: Service) -> Iterator[Visitor]:
    context = chromium.new_context(reduced_motion="reduce")
    context.add_init_script(home.EMULATED)
    someone = Visitor(context.new_page(), relay.address)
    someone.sign_in(PATIENTS[0].email)
    someone.page.set_viewport_size({"width": 390, "height": 844})
    yield someone
    context.close()
