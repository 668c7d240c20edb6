"""A live page is right again by itself, and stays so: after a restart, a pause, a cut connection.

Within 10 s of the first answer is promised; `make bench-returns` holds it to that, three times each. Here it may take
as long as any page that shares two cores with other browsers.
"""

import os
import re
import signal
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Locator, Page, expect

from app.demo.people import THERAPIST
from tests.e2e.conftest import CHROMIUM, FLAGS, Service, Visitor
from tests.e2e.sensors.broken_link import Relay
from tests.e2e.test_live_truth import patient_of, recording_of
from tests.patience import PATIENCE_MS

WITHIN_MS = 1000 * float(os.environ.get("WITHIN_S", PATIENCE_MS / 1000))
TIMES = int(os.environ.get("RETURNS", "1"))
PAUSE_S = float(os.environ.get("PAUSE_S", "12"))
"""Longer than a page waits before it opens another socket; a minute is the same to it."""
MEASURED = re.compile(r"[0-9]°")

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def page(chromium: Browser, relay: Relay, service: Service, gateway: None) -> Iterator[Page]:
    """The live page of a recording, in a browser of its own that a test may stop."""
    session_id = recording_of(service, patient_of(service))
    # Of the same driver: two drivers cannot run in one process.
    browser = chromium.browser_type.launch(executable_path=CHROMIUM, args=FLAGS)
    opened = browser.new_page(viewport={"width": 1440, "height": 900}, reduced_motion="reduce")
    Visitor(opened, relay.address).sign_in(THERAPIST)
    opened.goto(f"{relay.address}/sessions/{session_id}/live")
    expect(elbow(opened)).to_contain_text(MEASURED)
    drawn(opened, PATIENCE_MS)
    yield opened
    browser.close()


def elbow(page: Page) -> Locator:
    return page.locator(".trace").filter(has_text="Elbow flexion").locator(".trace-value")


# How much of the 3D view differs from its sky: an empty scene, or none, has nothing in the middle.
FIGURE = """() => {
  const canvas = document.querySelector('canvas[data-engine]');
  if (!canvas) return 0;
  const small = document.createElement('canvas');
  small.width = small.height = 60;
  const context = small.getContext('2d');
  context.drawImage(canvas, 0, 0, 60, 60);
  const pixels = context.getImageData(0, 0, 60, 60).data;
  let drawn = 0;
  for (let at = 3; at < pixels.length; at += 4) if (pixels[at] > 250) drawn += 1;
  return drawn / 3600;
}"""


def drawn(page: Page, within_ms: float) -> None:
    """Wait until a figure stands in the 3D view, and no banner over it."""
    until = time.monotonic() + within_ms / 1000
    share = 0.0
    while time.monotonic() < until:
        for frame in page.frames[1:]:
            try:
                share = frame.evaluate(FIGURE)
            except Exception:
                share = 0.0
            if share > 0.02 and page.locator(".viewer-banner").count() == 0:
                return
        page.wait_for_timeout(250)
    raise AssertionError(f"no figure in the 3D view ({share})")


def right_again(page: Page) -> float:
    """Return after how many seconds numbers, words and figure are right."""
    began = time.monotonic()

    def left() -> float:
        return max(1.0, WITHIN_MS - 1000 * (time.monotonic() - began))

    expect(elbow(page)).to_contain_text(MEASURED, timeout=left())
    expect(page.locator(".banner-alert")).to_have_count(0, timeout=left())
    drawn(page, left())
    took_s = time.monotonic() - began
    # And stays so: a page that judges by what it kept flips every few seconds.
    for _ in range(6):
        page.wait_for_timeout(1000)
        assert page.locator(".banner-alert").count() == 0
    expect(elbow(page)).to_contain_text(MEASURED, timeout=1000)
    return took_s


def test_after_a_restart_of_the_service(page: Page, service: Service) -> None:
    for _ in range(TIMES):
        service.process.terminate()
        expect(page.locator(".banner-alert")).to_contain_text("Connection to the service lost")
        service.restart(pause_s=PAUSE_S / 2)
        print("restart", right_again(page))


def test_after_a_pause_of_the_browser(page: Page) -> None:
    for _ in range(TIMES):
        with stopped(browsers_of(os.getpid())):
            time.sleep(PAUSE_S)
        print("pause", right_again(page))
        delay = page.get_by_test_id("delay").inner_text()
        assert int(re.sub(r"\D", "", delay)) < 5000, "frames that waited are shown as of now"


@pytest.mark.parametrize("way", ["cut", "swallowed"])
def test_after_a_network_that_went_away(page: Page, relay: Relay, way: str) -> None:
    for _ in range(TIMES):
        if way == "cut":
            relay.break_link()
        else:
            relay.swallow()
        expect(page.locator(".banner-alert")).to_contain_text("Connection to the service lost")
        page.wait_for_timeout(1000 * PAUSE_S)
        relay.mend()
        print(way, right_again(page))


class stopped:  # noqa: N801 - reads as a word of the test
    """Processes that stand still within the context, as on a laptop that sleeps."""

    def __init__(self, pids: list[int]) -> None:
        assert pids
        self._pids = pids

    def __enter__(self) -> None:
        for pid in self._pids:
            os.kill(pid, signal.SIGSTOP)

    def __exit__(self, *_: object) -> None:
        for pid in self._pids:
            os.kill(pid, signal.SIGCONT)


def browsers_of(parent: int) -> list[int]:
    """Return the processes of Chromium that descend from a process."""
    children: dict[int, list[tuple[int, str]]] = {}
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                name, rest = (entry / "stat").read_text().split("(", 1)[1].rsplit(")", 1)
            except OSError:
                continue
            children.setdefault(int(rest.split()[1]), []).append((int(entry.name), name))
    found, waiting = [], [parent]
    while waiting:
        for pid, name in children.get(waiting.pop(), []):
            waiting.append(pid)
            if "chrom" in name:
                found.append(pid)
    return found
