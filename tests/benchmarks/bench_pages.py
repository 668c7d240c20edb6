"""What the patient's pages cost a slow phone: `make bench-pages`, or `python -m tests.benchmarks.bench_pages`.

A real service, a guided exercise of known truth, and Chromium on a page of 390 points.

Exercise page: script of the page itself for each block of frames that it shows (one a packet, twenty a second), while
repetitions are done, with Chromium's processor slowed four times. It is taken from Chromium's own trace: the processor
time of all outermost script that runs for the page's frame. The 3D view is a frame of its own and is drawn there; its
script does not count, and neither do style, layout and painting. A display that shows more pictures than blocks come
does less for each.

First page: from the request of the page to the moment at which the button that starts the exercise can be pressed, with
nothing in the browser's cache, in fresh contexts of a browser that runs already.

Ends with 1 when a limit is missed.
"""

import argparse
import platform
import statistics
import sys
import tempfile
import time
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, Final

from playwright.sync_api import Browser, CDPSession, Page, ViewportSize, expect, sync_playwright

from app.demo.people import PATIENTS
from tests.app.live.guided import SOUND, performed
from tests.benchmarks.machine import processor
from tests.e2e.conftest import CHROMIUM, FLAGS, Service, Visitor, serving
from tests.e2e.sensors.test_guided_exercise import Body, prescribed
from tests.patience import PATIENCE_MS, PATIENCE_S

SLOWER: Final = 4
SCRIPT_LIMIT_MS: Final = 8.0
FIRST_PAGE_LIMIT_S: Final = 1.5
REPETITIONS: Final = 6
VISITS: Final = 7
PATIENT: Final = PATIENTS[0]
PHONE: Final = ViewportSize(width=390, height=844)
SCRIPT: Final = frozenset(
    ("FunctionCall", "EvaluateScript", "TimerFire", "FireAnimationFrame", "EventDispatch", "RunMicrotasks")
)
"""Events of the trace in which script runs; they may lie in one another."""
CATEGORIES: Final = "devtools.timeline,disabled-by-default-devtools.timeline,v8.execute"


def traced(cdp: CDPSession, page: Page, seconds: float) -> list[dict[str, Any]]:
    """Return the events of Chromium's trace over some seconds."""
    events: list[dict[str, Any]] = []
    ended: list[object] = []
    cdp.on("Tracing.dataCollected", lambda part: events.extend(part["value"]))
    cdp.on("Tracing.tracingComplete", lambda said: ended.append(said))
    cdp.send("Tracing.start", {"transferMode": "ReportEvents", "categories": CATEGORIES})
    page.wait_for_timeout(1000.0 * seconds)
    cdp.send("Tracing.end")
    deadline_s = time.monotonic() + PATIENCE_S
    while not ended and time.monotonic() < deadline_s:
        page.wait_for_timeout(50)
    return events


def script_ms(events: Iterable[Mapping[str, Any]], frame: str) -> float:
    """Return the processor time of a frame's script.

    An outermost event without a frame of its own (microtasks) is of the frame that the events inside it name; where
    none does, and it runs in a thread of the frame, it counts as the frame's.
    """
    whole = sorted(
        (one for one in events if one.get("ph") == "X" and one["name"] in SCRIPT and "tdur" in one),
        key=lambda one: (one["pid"], one["tid"], one["ts"], -one["dur"]),
    )
    outermost: list[tuple[Mapping[str, Any], set[str]]] = []
    for one in whole:
        if not outermost or not _is_inside(one, outermost[-1][0]):
            outermost.append((one, set()))
        found = one.get("args", {}).get("data", {}).get("frame")
        if found:
            outermost[-1][1].add(found)
    threads = {(one["pid"], one["tid"]) for one, frames in outermost if frame in frames}
    spent_us: float = sum(
        one["tdur"]
        for one, frames in outermost
        if frame in frames or (not frames and (one["pid"], one["tid"]) in threads)
    )
    return spent_us / 1000.0


def _is_inside(one: Mapping[str, Any], outer: Mapping[str, Any]) -> bool:
    return (one["pid"], one["tid"]) == (outer["pid"], outer["tid"]) and one["ts"] < outer["ts"] + outer["dur"]


def exercise(browser: Browser, service: Service, seconds: float) -> dict[int, tuple[float, float]]:
    """Return script a block of frames on the exercise page, ms, and blocks a second, by how much it is slowed."""
    done = performed((SOUND,) * REPETITIONS, exercise=PATIENT.movement)
    context = browser.new_context(has_touch=True)
    patient = Visitor(context.new_page(), service.address)
    page, blocks = patient.page, [0]

    def take(message: str | bytes) -> None:
        blocks[0] += isinstance(message, bytes)

    page.on(
        "websocket", lambda socket: socket.on("framereceived", take) if "/ws/live/" in socket.url else None
    )
    patient.sign_in(PATIENT.email)
    page.set_viewport_size(PHONE)
    page.get_by_role("button", name="Start").first.click()
    expect(page.get_by_role("heading", name="Put on the sensors")).to_be_visible()
    body = Body(service.address, page.url.split("/")[-2], done)
    page.get_by_role("button", name="I am standing still").click()
    assert body.is_at_rest.wait(PATIENCE_S)
    page.get_by_role("button", name="Go", exact=True).click()
    expect(page.get_by_test_id("line")).to_be_visible()
    cdp = context.new_cdp_session(page)
    frame = cdp.send("Page.getFrameTree")["frameTree"]["frame"]["id"]
    body.may_move.set()
    expect(page.get_by_label("Counted")).to_contain_text("1of 10")
    found = {}
    for rate in (1, SLOWER):
        cdp.send("Emulation.setCPUThrottlingRate", {"rate": rate})
        before, began_s = blocks[0], time.monotonic()
        events = traced(cdp, page, seconds)
        shown = blocks[0] - before
        assert shown, "the page got no frames"
        found[rate] = script_ms(events, frame) / shown, shown / (time.monotonic() - began_s)
    cdp.send("Emulation.setCPUThrottlingRate", {"rate": 1})
    page.close()
    body.thread.join()
    context.close()
    return found


def first_pages(browser: Browser, service: Service, rate: int) -> list[float]:
    """Return how long the patient's first page took until it could be used, s."""
    signed_in = browser.new_context()
    Visitor(signed_in.new_page(), service.address).sign_in(PATIENT.email)
    state = signed_in.storage_state()
    signed_in.close()
    found = []
    for _ in range(VISITS):
        context = browser.new_context(viewport=PHONE, has_touch=True, storage_state=state)
        page = context.new_page()
        page.set_default_timeout(PATIENCE_MS)
        cdp = context.new_cdp_session(page)
        cdp.send("Emulation.setCPUThrottlingRate", {"rate": rate})
        began_s = time.monotonic()
        page.goto(service.address, wait_until="commit")
        page.get_by_role("button", name="Start").first.click(trial=True)
        found.append(time.monotonic() - began_s)
        context.close()
    return sorted(found)


def main() -> int:
    """Print the figures; 1 when a limit is missed."""
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    arguments.add_argument("--seconds", type=float, default=8.0, help="of the exercise that are traced")
    given = arguments.parse_args()
    print(f"{processor()}, Python {platform.python_version()}")
    assert CHROMIUM, "no Chromium here: `make browser`"
    expect.set_options(timeout=PATIENCE_MS)
    with (
        tempfile.TemporaryDirectory() as folder,
        serving(Path(folder)) as service,
        sync_playwright() as playwright,
    ):
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        prescribed(service)
        # Before the exercise: a session that is open is offered instead of a start.
        pages = {rate: first_pages(browser, service, rate) for rate in (1, SLOWER)}
        scripts = exercise(browser, service, given.seconds)
        browser.close()
    for rate, (each_ms, rate_hz) in scripts.items():
        asked = f" (limit {SCRIPT_LIMIT_MS:.0f} ms)" if rate == SLOWER else ""
        print(
            f"exercise page, processor slowed {rate} times: script a block of frames {each_ms:.1f} ms{asked},"
            f" {rate_hz:.0f} blocks a second"
        )
    for rate, times_s in pages.items():
        asked = f" (limit {FIRST_PAGE_LIMIT_S} s)" if rate == 1 else ""
        print(
            f"first page, processor slowed {rate} times: {statistics.median(times_s):.2f} s{asked},"
            f" at most {times_s[-1]:.2f} s of {VISITS}"
        )
    return int(scripts[SLOWER][0] > SCRIPT_LIMIT_MS or statistics.median(pages[1]) > FIRST_PAGE_LIMIT_S)


if __name__ == "__main__":
    sys.exit(main())
