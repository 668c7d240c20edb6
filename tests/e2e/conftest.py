"""A whole service with a small clinic, made by the real chain, and a real browser."""

import asyncio
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Coroutine, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import httpx
import pytest
from playwright.sync_api import Browser, BrowserContext, Page, expect, sync_playwright

from app.commands.simulation.arm import Options, stream
from app.database import engine as engines
from app.database import migrate
from app.demo import history
from app.demo.dating import date_back
from app.demo.people import ADMINISTRATOR, PASSWORD, PATIENTS, THERAPIST, seed_people
from app.gateway import ServiceClient
from tests.patience import PATIENCE_MS, PATIENCE_S
from tests.ports import free_port

ROOT = Path(__file__).resolve().parents[2]
PICTURES = ROOT / "var" / "pictures"
"""Every page as it was seen, for people to look at; not tracked."""

CHROMIUM = os.environ.get("CHROMIUM") or next(
    (path for path in ("/usr/bin/chromium", "/usr/bin/chromium-browser") if Path(path).exists()), None
)
FLAGS = [
    "--headless=new",
    "--no-sandbox",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--disable-accelerated-2d-canvas",
    "--disable-gpu-rasterization",
]

SLOW_VIEW = """
if (location.pathname.includes('/viewer')) {
  const draws = window.requestAnimationFrame.bind(window);
  window.requestAnimationFrame = (draw) => setTimeout(() => draws(draw), 1000);
  window.cancelAnimationFrame = clearTimeout;
  Object.defineProperty(window, 'devicePixelRatio', { get: () => 0.5 });
}
"""
"""The 3D view draws as often as it can while a session is live. Without a graphics card one drawing takes a third of a
second of a core, from all other tests: here it draws once a second, and coarser, also in the pictures."""


@dataclass(frozen=True)
class House:
    """A running service and what is in it."""

    address: str
    patient_id: str
    exercise_id: str
    prescription_id: str
    template_session_id: str
    session_id: str
    """An analysed exercise session with a comparison."""


@dataclass
class Service:
    """A process of `telemotion serve` with the people of the demonstration and nothing else."""

    address: str
    process: "subprocess.Popen[bytes]"
    engine: engines.Engine
    begin: Callable[[], "subprocess.Popen[bytes]"]

    def restart(self, pause_s: float = 0.0) -> None:
        """End the process, begin another at the same address, and wait for its first answer."""
        self.process.terminate()
        self.process.wait(PATIENCE_S)
        time.sleep(pause_s)
        self.process = self.begin()
        wait_until_up(self.address, self.process)


@contextmanager
def serving(folder: Path, base_url: str | None = None) -> Iterator[Service]:
    """Start a service on a database in this folder; stop it in the end, whatever became of it.

    `base_url` is the address that browsers use where that is not its own.
    """
    assert (ROOT / "web" / "dist" / "index.html").exists(), "build the browser client first: make web"
    port = free_port()
    address = f"http://127.0.0.1:{port}"
    url = f"sqlite:///{folder / 'telemotion.db'}"
    migrate.upgrade(url)
    engine = engines.create_from_url(url)
    seed_people(engine)
    environment = {
        **os.environ,
        "TELEMOTION_DEMO": "true",
        "TELEMOTION_BASE_URL": base_url or address,
        "TELEMOTION_DATABASE_URL": url,
        "TELEMOTION_DATA_DIR": str(folder),
        "TELEMOTION_LOG_LEVEL": "warning",
    }

    def begin() -> "subprocess.Popen[bytes]":
        return subprocess.Popen(
            [sys.executable, "-m", "app.cli", "serve", "--port", str(port)], cwd=ROOT, env=environment
        )

    service = Service(address, begin(), engine, begin)
    try:
        wait_until_up(address, service.process)
        yield service
    finally:
        service.process.send_signal(signal.SIGCONT)
        service.process.terminate()
        service.process.wait(PATIENCE_S)
        engine.dispose()


@pytest.fixture(scope="session")
def house(tmp_path_factory: pytest.TempPathFactory) -> Iterator[House]:
    """Start `telemotion serve` as its own process and let a therapist and a patient work with it."""
    with serving(tmp_path_factory.mktemp("house")) as service:
        yield apart(furnish(service.address, service.engine))


def apart(work: Coroutine[Any, Any, Any]) -> Any:
    """Run a coroutine in a thread of its own: the browser's driver keeps a loop running in this one."""
    with ThreadPoolExecutor(1) as pool:
        return pool.submit(asyncio.run, work).result()


def wait_until_up(address: str, server: "subprocess.Popen[bytes]") -> None:
    deadline = time.monotonic() + PATIENCE_S
    while True:
        assert server.poll() is None, "the service ended"
        assert time.monotonic() < deadline, "the service does not answer"
        try:
            if httpx.get(f"{address}/api/health", trust_env=False).is_success:
                return
        except httpx.TransportError:
            time.sleep(0.2)


async def furnish(address: str, engine: engines.Engine) -> House:
    person = PATIENTS[0]
    async with ServiceClient(address) as service:
        await service.sign_in(THERAPIST, PASSWORD)
        patients = await service.every("/api/patients")
        patient_id = next(row["id"] for row in patients if row["given_name"] == person.given_name)
        exercises = (await service.http.get("/api/exercises")).json()
        exercise_id = next(row["id"] for row in exercises if row["movement"] == person.movement)
        prescription_id, _ = await history.record_template(service, engine, person, patient_id, exercise_id)
        sessions = await service.every(f"/api/patients/{patient_id}/sessions")
        options = Options(
            patient_id=patient_id,
            exercise_id=exercise_id,
            prescription_id=prescription_id,
            movement=person.movement,
            arms=person.affected_side,
            repetitions=4,
            patient_kind="moderate_stroke",
            speed=None,
            seed=3,
        )
        for days_ago, progress in ((9.0, 0.0), (2.0, 0.8)):
            session_id, _ = await stream(
                service, replace(options, progress=progress, seed=int(days_ago)), lambda text: None
            )
            date_back(engine, session_id, days_ago)
        return House(address, patient_id, exercise_id, prescription_id, sessions[0]["id"], session_id)


@pytest.fixture(scope="session")
def chromium() -> Iterator[Browser]:
    assert CHROMIUM, "no Chromium here; `make test` installs it, or set CHROMIUM to its path"
    expect.set_options(timeout=PATIENCE_MS)
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        begun = browser.new_context

        def new_context(**options: Any) -> BrowserContext:
            context = begun(**options)
            context.add_init_script(SLOW_VIEW)
            return context

        browser.new_context = new_context  # type: ignore[method-assign]
        yield browser
        browser.close()


class Visitor:
    """A browser page of somebody who is signed in, with what went wrong on it."""

    def __init__(self, page: Page, address: str) -> None:
        self.page = page
        self.address = address
        self.faults: list[str] = []
        page.set_default_timeout(PATIENCE_MS)
        page.on("pageerror", lambda error: self.faults.append(str(error)))

    def sign_in(self, email: str) -> None:
        """Sign in by keyboard alone."""
        self.page.goto(self.address)
        self.page.get_by_label("E-mail").fill(email)
        self.page.get_by_label("Password", exact=True).fill(PASSWORD)
        self.page.keyboard.press("Enter")
        self.page.get_by_role("navigation", name="Main").wait_for()

    def faults_outside_the_view(self) -> list[str]:
        """Script errors of our own pages; viser's client tries an `eval` that its policy refuses, and goes on."""
        return [fault for fault in self.faults if "unsafe-eval" not in fault]

    def picture(self, name: str) -> None:
        """Keep what is seen."""
        PICTURES.mkdir(parents=True, exist_ok=True)
        self.page.screenshot(path=PICTURES / f"{name}.png")


@pytest.fixture(scope="session")
def signed_in(chromium: Browser, house: House) -> dict[str, Any]:
    """The cookies of everybody who visits, from one real sign-in each."""
    states = {}
    for email in (THERAPIST, ADMINISTRATOR, PATIENTS[0].email):
        context = chromium.new_context()
        Visitor(context.new_page(), house.address).sign_in(email)
        states[email] = context.storage_state()
        context.close()
    return states


@pytest.fixture
def visitor(
    chromium: Browser, house: House, signed_in: dict[str, Any], request: pytest.FixtureRequest
) -> Iterator[Visitor]:
    """A signed-in visitor; by default a therapist on a desktop, at home.

    The parameter is (e-mail, width), for a test that goes to an address of its own.
    """
    email, width = getattr(request, "param", (THERAPIST, 1440))
    # axe is put into the page from outside, which the page's own policy rightly forbids.
    context = chromium.new_context(
        viewport={"width": width, "height": 900 if width > 600 else 844},
        bypass_csp=True,
        reduced_motion="reduce",
        storage_state=signed_in[email],
    )
    someone = Visitor(context.new_page(), house.address)
    if not hasattr(request, "param"):
        someone.page.goto(house.address)
        someone.page.get_by_role("main").get_by_role("heading", level=1).wait_for()
    yield someone
    context.close()
