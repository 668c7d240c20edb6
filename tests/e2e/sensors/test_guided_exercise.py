"""A patient's evening on a phone: three good repetitions and a short one, counted and said, and the questions after."""

import asyncio
import contextlib
import json
import re
import threading
import time
from collections.abc import AsyncIterator, Iterator
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from playwright.sync_api import Browser, expect
from sqlalchemy import select
from websockets.asyncio.client import ClientConnection, connect

from app.accounts.models import Account
from app.database.unit_of_work import read_only
from app.demo.people import PASSWORD, PATIENTS, THERAPIST
from app.exercises.models import Exercise
from app.gateway import DeviceStream, ServiceClient
from app.patients.models import Patient
from tests.app.live.guided import N_POSE_S, SHORT, SOUND, Performed, performed, prescribe
from tests.e2e.conftest import Service, Visitor, serving
from tests.e2e.sensors.clinic_gateway import deliveries
from tests.e2e.sensors.evenings import watch_lines
from tests.e2e.test_pages import serious, unreached_by_tab
from tests.patience import PATIENCE_S

pytestmark = pytest.mark.slow("sensors stream in real time")
PATIENT = PATIENTS[0]
POSE_S = (1.0, N_POSE_S - 1.0)
REST_S = (N_POSE_S + 1.8, N_POSE_S + 3.4)
"""The parts of the pose and of the rest after it that are sent again and again until the page has gone on."""


@pytest.fixture(scope="module")
def service(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Service]:
    with serving(tmp_path_factory.mktemp("guided")) as running:
        yield running


def prescribed(service: Service) -> str:
    """Prescribe the known template to the patient; returns her record."""
    with read_only(service.engine) as session:
        patient = session.scalars(select(Patient).where(Patient.given_name == PATIENT.given_name)).one()
        exercise = session.scalars(select(Exercise).where(Exercise.movement == PATIENT.movement)).one()
        therapist = session.scalars(select(Account).where(Account.email == THERAPIST)).one()
        world = SimpleNamespace(
            accounts={"therapist": therapist.id},
            clinic_id=patient.clinic_id,
            exercise_id=exercise.id,
            patient_id=patient.id,
        )
    prescribe(service.engine, world, repetitions=10, exercise=PATIENT.movement)
    return patient.id


class Body:
    """The sensors on the patient, in a thread of their own."""

    def __init__(self, address: str, session_id: str, done: Performed) -> None:
        self.is_ready, self.is_at_rest, self.may_move = (threading.Event() for _ in range(3))
        self.error: Exception | None = None
        self._address, self._session_id, self._done = address, session_id, done
        self.thread = threading.Thread(target=self._run, name="gateway", daemon=True)
        self.thread.start()

    def _run(self) -> None:
        try:
            asyncio.run(self._stream())
        except Exception as error:
            self.error = error

    async def _stream(self) -> None:
        stream = at_rest(self._done.stream)
        holds = (*POSE_S, self.is_ready.is_set), (*REST_S, self.may_move.is_set)
        async with ServiceClient(self._address) as client:
            await client.sign_in(THERAPIST, PASSWORD)
            async with taken(client, self._session_id, self._done) as socket:
                reading = asyncio.create_task(drain(socket))
                for at_s, delivery in deliveries(stream, *holds):
                    await socket.send(delivery.data)
                    if at_s >= REST_S[0]:
                        self.is_at_rest.set()
                    await asyncio.sleep(stream.packet_s)
                reading.cancel()


def at_rest(stream: DeviceStream) -> DeviceStream:
    """Let the rest turn nothing: repeated, its sway would turn the sensors further and further.

    Of the gyroscopes the same is left as in the pose, where they measure their bias.
    """
    counts = stream.counts.copy()
    pose, rest = (slice(*(round(at_s * stream.rate_hz) for at_s in part)) for part in (POSE_S, REST_S))
    turning = counts[rest, :, :3].mean(axis=0) - counts[pose, :, :3].mean(axis=0)
    counts[rest, :, :3] -= np.rint(turning).astype(np.int16)
    return replace(stream, counts=counts)


@contextlib.asynccontextmanager
async def taken(client: ServiceClient, session_id: str, done: Performed) -> AsyncIterator[ClientConnection]:
    """A connection as soon as the service takes sessions of this kind: its filters may have to be compiled first."""
    until_s = time.monotonic() + PATIENCE_S
    while time.monotonic() < until_s:
        async with connect(client.ingest_url, proxy=None) as socket:
            hello = done.stream.hello(await client.ticket(session_id))
            await socket.send(hello.model_dump_json(exclude_none=True))
            if json.loads(await socket.recv())["type"] == "acknowledge":
                yield socket
                return
        await asyncio.sleep(1.0)
    raise TimeoutError("the service takes no session")


async def drain(socket: object) -> None:
    async for _ in socket:  # type: ignore[attr-defined]
        pass


ZOOMED = ((640, 400), (320, 640))
"""A window of 1280 by 800 at 200 %, and one of 1280 at 400 % (WCAG 1.4.10), which is also the smallest phone."""
HIDDEN = """() => {
    const found = document.documentElement.scrollWidth > innerWidth + 1 ? ['the page moves sideways'] : [];
    for (const one of document.querySelectorAll('button, a[href]:not([href^="#"]), input, select, textarea')) {
        if (one.disabled || !one.checkVisibility({ visibilityProperty: true })) continue;
        one.scrollIntoView({ block: 'center' });
        const { left, right, top, width, height } = one.getBoundingClientRect();
        if (width < 2) continue;
        const above = document.elementFromPoint(left + width / 2, top + height / 2);
        const own = [one, ...(one.labels ?? [])];
        const cut = one.matches('button, a')
            && [one, ...one.querySelectorAll('*')].some((each) => each.scrollWidth > each.clientWidth + 1
                && getComputedStyle(each).overflowX !== 'visible');
        const shown = own.some((each) => each.contains(above) || above?.contains(each));
        if (left < -1 || right > innerWidth + 1 || !shown || cut)
            found.push(one.innerText || one.ariaLabel || one.name);
    }
    return found;
}"""
"""What a zoomed page does not show by moving up and down alone, or shows behind something else."""


def hidden_when_zoomed(patient: Visitor, name: str) -> list[str]:
    """Controls that cannot be pressed in a zoomed or small window, by its width."""
    found = []
    for width, height in ZOOMED:
        patient.page.set_viewport_size({"width": width, "height": height})
        patient.page.wait_for_timeout(150)
        found += [f"{width}: {one}" for one in patient.page.evaluate(HIDDEN)]
        patient.picture(f"{name}-{width}")
    patient.page.set_viewport_size({"width": 390, "height": 844})
    return found


def test_three_good_ones_and_a_short_one_on_a_phone(chromium: Browser, service: Service) -> None:
    prescribed(service)
    done = performed((SOUND, SOUND, SHORT, SOUND), exercise=PATIENT.movement)
    context = chromium.new_context(bypass_csp=True, reduced_motion="reduce", has_touch=True)
    patient = Visitor(context.new_page(), service.address)
    page = patient.page
    patient.sign_in(PATIENT.email)
    page.set_viewport_size({"width": 390, "height": 844})
    expect(page.get_by_text("Today: 1 exercise, about 3 minutes")).to_be_visible()
    patient.picture("guided-today-390")
    page.get_by_role("button", name="Start").first.click()
    expect(page.get_by_role("heading", name="Put on the sensors")).to_be_visible()
    expect(page.get_by_role("img", name=re.compile("^Where the sensors are worn"))).to_be_visible()
    patient.picture("guided-wear-390")
    assert serious(patient) == []
    assert hidden_when_zoomed(patient, "guided-wear") == []
    assert unreached_by_tab(page) == []
    body = Body(service.address, page.url.split("/")[-2], done)
    page.get_by_role("button", name="I am standing still").click()
    expect(page.get_by_role("heading", name="Ready")).to_be_visible()
    expect(page.get_by_text("Now sit down on a chair.")).to_be_visible()
    patient.picture("guided-ready-390")
    body.is_ready.set()
    assert body.is_at_rest.wait(PATIENCE_S)
    page.get_by_role("button", name="Go", exact=True).click()
    line = page.get_by_test_id("line")
    expect(line).to_be_visible()
    patient.picture("guided-waiting-390")
    assert hidden_when_zoomed(patient, "guided-waiting") == []
    assert unreached_by_tab(page) == []
    watch_lines(page)
    body.may_move.set()

    count = page.get_by_label("Counted")
    expect(count).to_contain_text(re.compile("[123]of 10"))
    patient.picture("guided-one-390")
    assert serious(patient) == []
    page.wait_for_function("window.lines.includes('A little further.')")
    patient.picture("guided-cue-390")
    for width, height in ((1024, 800), (1440, 900)):
        page.set_viewport_size({"width": width, "height": height})
        page.wait_for_timeout(400)
        patient.picture(f"guided-doing-{width}")
    page.set_viewport_size({"width": 390, "height": 844})
    expect(count).to_contain_text("1 not quite far enough")
    body.thread.join(PATIENCE_S)
    assert body.error is None, "the sensors were cut off"
    expect(count).to_contain_text("3of 10")
    patient.picture("guided-counted-390")

    page.keyboard.press("Escape")
    expect(page.get_by_role("heading", name="Take a break")).to_be_visible()
    patient.picture("guided-pause-390")
    assert serious(patient) == []
    assert hidden_when_zoomed(patient, "guided-pause") == []
    page.get_by_role("button", name="Go on").click()
    expect(page.get_by_role("heading", name="Take a break")).to_be_hidden()
    page.get_by_role("button", name="It hurts").click()
    expect(page.get_by_role("heading", name="Stop and rest")).to_be_visible()
    patient.picture("guided-pain-390")
    page.get_by_role("button", name="Finish for today").click()

    expect(page.get_by_role("heading", name="How was it?")).to_be_visible()
    # Nobody is praised for a count right after pain, nor asked again whether it hurt.
    expect(page.get_by_text("good movements")).to_have_count(0)
    page.get_by_role("group", name="How much did it hurt?").get_by_text("3", exact=True).click()
    page.get_by_role("group", name="How hard was it?").get_by_text("6", exact=True).click()
    patient.picture("guided-after-390")
    assert serious(patient) == []
    assert hidden_when_zoomed(patient, "guided-after") == []
    assert unreached_by_tab(page) == []
    page.get_by_role("button", name="Send to my therapist").click()
    expect(page.get_by_text("Thank you.")).to_be_visible()
    assert patient.faults_outside_the_view() == []
    context.close()
