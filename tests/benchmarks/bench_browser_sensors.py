"""Ten minutes at home: `python -m tests.benchmarks.bench_browser_sensors`, after `make web browser`.

A real service, a real browser and one patient with two pages: on one an emulated phone, on the other two emulated
Movella DOT sensors by Bluetooth that speak the vendor's bytes. A simulated person stands, then lifts the arm until the
time is over; in the middle the link is broken for half a minute. Printed for each: ticks that were emitted and stored,
holes and repetitions, how far the stored values are from the emitted ones, and the angles beside those of the gateway
in Python and beside the truth. Ends with 1 when something is lost, stored twice or apart.
"""

import argparse
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import httpx
import numpy as np
from playwright.sync_api import Page, expect, sync_playwright

from app.demo.people import PATIENTS
from tests.e2e.conftest import CHROMIUM, FLAGS, Visitor, apart, serving
from tests.e2e.sensors import sensors_at_home as home
from tests.e2e.sensors.broken_link import Relay, relaying

ELEVATION = "thorax_humerus_right_yxy_elevation"
PATIENCE_MS = 60_000
STILL_S = 45.0
"""Stands so long: time for a page on a busy machine."""
LIMIT_DEG = {"phone": 0.3, "dots": 1.0}
"""Largest of a phone's ticks, which are the emitted samples; root mean square of sensors with clocks of their own."""
SETTLE_TICKS = 200
"""A sensor's clock is found in the first seconds."""


@dataclass(frozen=True)
class Worn:
    """What one page measures."""

    name: str
    wearer: home.Wearer
    session_id: str
    page: Page

    @property
    def first(self) -> int:
        """Number of the first emitted tick, counted from 1970."""
        return int(self.page.evaluate("emulated.first"))


def begin(address: str, client: httpx.Client, page: Page, name: str, seconds: float) -> Worn:
    """Open the page of a new session and let its sensors begin."""
    places = ("upper_arm_right",) if name == "phone" else ("upper_arm_right", "forearm_right")
    wearer = home.wearer(places, seconds - STILL_S, still_s=STILL_S)
    session_id = home.new_session(client, places)
    page.goto(f"{address}/my/sessions/{session_id}/live")
    samples = wearer.samples.round(7)
    if name == "phone":
        page.get_by_role("button", name="This phone").click()
        page.evaluate("samples => emulatePhone({rateHz: 60, samples})", samples[:, 0].tolist())
        page.get_by_role("button", name="Measure with this phone").click()
    else:
        page.evaluate("samples => emulateDots({rateHz: 60, samples})", samples.tolist())
        page.get_by_role("button", name="Bluetooth sensors").click()
        for place in ("Right upper arm", "Right forearm"):
            page.get_by_role("button", name=f"Connect: {place}").click()
    page.get_by_role("button", name="I am standing still").click(timeout=PATIENCE_MS)
    return Worn(name, wearer, session_id, page)


def stream(worn: list[Worn], relay: Relay, seconds: float, broken_s: float) -> None:
    """Let it run, with the link broken in the middle, to the end of the exercise."""
    for one in worn:
        one.page.get_by_role("button", name="Go", exact=True).click(timeout=PATIENCE_MS)
    worn[0].page.wait_for_timeout(1000 * (seconds - broken_s) / 2)
    relay.break_link()
    worn[0].page.wait_for_timeout(1000 * broken_s)
    for one in worn:
        print(
            f"{one.name}: {one.page.evaluate(home.WAITING)} packets wait on the device after {broken_s:.0f} s"
        )
    relay.mend()
    for one in worn:
        one.page.wait_for_function(
            "count => emulated.emitted === count", arg=len(one.wearer.samples), timeout=1000 * seconds
        )
        one.page.get_by_role("button", name="Stop", exact=True).click()
        one.page.get_by_role("button", name="Finish for today").click()
    for one in worn:
        ready = one.page.get_by_role("heading", name="Your result is ready")
        expect(ready).to_be_visible(timeout=600_000)


def judge(worn: Worn, address: str, client: httpx.Client) -> bool:
    """Print what became of the samples; return whether all is well."""
    numbers, values = home.stored_samples(client, worn.session_id)
    emitted = numbers - worn.first
    repeated = emitted.size - np.unique(emitted).size
    holes = int(emitted[-1] - emitted[0] + 1) - np.unique(emitted).size
    empty = int((values == 0.0).all(axis=2)[20:].sum())
    inside = np.flatnonzero((emitted >= 0) & (emitted < len(worn.wearer.samples)))[SETTLE_TICKS:]
    far = _far(worn.wearer.samples, emitted[inside], values[inside])
    offset = int(emitted[0])
    other = apart(home.stream_by_gateway(address, worn.wearer, offset, STILL_S - 15.0))
    mine, its = (
        dict(zip(*home.angles_of(client, one, ELEVATION), strict=True)) for one in (worn.session_id, other)
    )
    ticks = [tick for tick in mine if tick in its and tick + offset < len(worn.wearer.elevation_rad)]
    ours = np.array([mine[tick] for tick in ticks])
    by_gateway = np.rad2deg(np.abs(ours - np.array([its[tick] for tick in ticks])))
    truth = np.rad2deg(ours - worn.wearer.elevation_rad[np.array(ticks) + offset])
    rms_deg = float(np.sqrt(np.mean(by_gateway**2)))
    print(
        f"{worn.name}: {len(worn.wearer.samples)} ticks emitted, {emitted.size} stored from number {offset} to"
        f" {emitted[-1]}, {holes} holes, {repeated} twice, {empty} empty; values within {far:.4f} (99 %);"
        f" elevation from the gateway's {rms_deg:.3f} rms, {by_gateway.max():.3f} at most,"
        f" from the truth {np.sqrt(np.mean(truth**2)):.2f} deg rms"
    )
    far_deg = by_gateway.max() if worn.name == "phone" else rms_deg
    is_whole = emitted[-1] >= len(worn.wearer.samples) - 70
    return bool(is_whole and holes == repeated == empty == 0 and far_deg < LIMIT_DEG[worn.name])


def _far(samples: np.ndarray, emitted: np.ndarray, values: np.ndarray) -> float:
    """Return how far stored gyroscopes are from the lines between the samples, each sensor's delay taken off."""
    ticks = np.arange(len(samples))
    worst = 0.0
    for sensor in range(samples.shape[1]):
        errors = [
            np.abs(np.interp(emitted - delay, ticks, samples[:, sensor, 0]) - values[:, sensor, 0])
            for delay in np.arange(0.0, 3.0, 0.05)
        ]
        worst = max(worst, min(float(np.quantile(error, 0.99)) for error in errors))
    return worst


def run(names: list[str], minutes: float, broken_s: float) -> bool:
    """Run it all; return whether nothing was lost."""
    seconds = 60.0 * minutes
    with (
        relaying() as relay,
        tempfile.TemporaryDirectory() as folder,
        serving(Path(folder), base_url=relay.address) as service,
        sync_playwright() as playwright,
    ):
        relay.serve(service.address)
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        with home.therapist_at(relay.address) as client:
            worn = []
            for name in names:
                context = browser.new_context(reduced_motion="reduce")
                context.add_init_script(home.EMULATED)
                # Drawn without a graphics card, the figure would take the processor that is measured here.
                context.route("**/viewer/**", lambda route: route.abort())
                patient = Visitor(context.new_page(), relay.address)
                patient.sign_in(PATIENTS[0].email)
                worn.append(begin(relay.address, client, patient.page, name, seconds))
            stream(worn, relay, seconds, broken_s)
            sound = [judge(one, relay.address, client) for one in worn]
        browser.close()
    return all(sound)


def main() -> None:
    """Read the command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--minutes", type=float, default=10.0)
    parser.add_argument("--broken-s", type=float, default=30.0)
    parser.add_argument("--sensors", nargs="+", choices=("phone", "dots"), default=["phone", "dots"])
    options = parser.parse_args()
    sys.exit(0 if run(options.sensors, options.minutes, options.broken_s) else 1)


if __name__ == "__main__":
    main()
