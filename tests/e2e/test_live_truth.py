"""What the live page says when the gateway dies, and when the service stands still or ends, is true within 3 s."""

import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import httpx
import pytest
from playwright.sync_api import Browser, expect

from app.demo.people import PASSWORD, PATIENTS, THERAPIST
from tests.e2e.conftest import ROOT, Service, Visitor, serving
from tests.patience import PATIENCE_S

SOON_MS = 3000


@pytest.fixture
def service(tmp_path: Path) -> Iterator[Service]:
    with serving(tmp_path) as one:
        yield one


@pytest.fixture
def gateway(service: Service) -> Iterator["subprocess.Popen[bytes]"]:
    """A gateway as a process of its own, for about two minutes."""
    words = ["-m", "app.cli", "simulate", "--movement", "drinking", "--repetitions", "20"]
    process = subprocess.Popen(
        [sys.executable, *words, "--server", service.address, "--patient", patient_of(service)],
        cwd=ROOT,
        env={**os.environ, "TELEMOTION_EMAIL": THERAPIST, "TELEMOTION_PASSWORD": PASSWORD},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    yield process
    process.kill()
    process.wait()


@contextmanager
def signed_in(service: Service) -> Iterator[httpx.Client]:
    with httpx.Client(
        base_url=service.address, headers={"Origin": service.address}, trust_env=False
    ) as client:
        client.post("/api/sign-in", json={"email": THERAPIST, "password": PASSWORD}).raise_for_status()
        yield client


def patient_of(service: Service) -> str:
    with signed_in(service) as client:
        rows = client.get("/api/patients").json()
    return str(next(row["id"] for row in rows if row["given_name"] == PATIENTS[0].given_name))


def recording_of(service: Service, patient_id: str) -> str:
    """Wait until the session records; return it."""
    deadline = time.monotonic() + PATIENCE_S
    with signed_in(service) as client:
        while time.monotonic() < deadline:
            for one in client.get(f"/api/patients/{patient_id}/sessions").json():
                if one["state"] == "recording":
                    return str(one["id"])
            time.sleep(0.5)
    raise TimeoutError("the simulated patient does not record")


@pytest.mark.slow("a service of its own is stopped, and a session is simulated in a process beside it")
def test_what_the_live_page_says_is_true(
    chromium: Browser, service: Service, gateway: "subprocess.Popen[bytes]"
) -> None:
    context = chromium.new_context(viewport={"width": 1440, "height": 900}, reduced_motion="reduce")
    page = context.new_page()
    visitor = Visitor(page, service.address)
    visitor.sign_in(THERAPIST)
    page.goto(f"{service.address}/sessions/{recording_of(service, patient_of(service))}/live")
    elbow = page.locator(".trace").filter(has_text="Elbow flexion").locator(".trace-value")
    measured = re.compile(r"[0-9]°")
    expect(elbow).to_contain_text(measured)
    banner = page.locator(".banner-alert")
    expect(banner).to_have_count(0)

    service.process.send_signal(signal.SIGSTOP)
    expect(banner).to_contain_text("Connection to the service lost", timeout=SOON_MS)
    expect(banner).to_contain_text("does not know whether the session is being stored")
    expect(elbow).not_to_contain_text(measured, timeout=SOON_MS)
    visitor.picture("live-service-frozen-1440")
    service.process.send_signal(signal.SIGCONT)
    expect(elbow).to_contain_text(measured)
    expect(banner).to_have_count(0)

    gateway.kill()
    expect(banner).to_contain_text("No data from the sensors", timeout=SOON_MS)
    expect(elbow).not_to_contain_text(measured, timeout=SOON_MS)
    visitor.picture("live-gateway-killed-1440")
    silence = re.search(r"Silent for\D*([0-9]+)", banner.inner_text())
    assert silence
    page.wait_for_timeout(3500)
    grown = re.search(r"Silent for\D*([0-9]+)", banner.inner_text())
    assert grown
    assert int(grown[1]) >= int(silence[1]) + 2

    service.process.terminate()
    expect(banner).to_contain_text("Connection to the service lost", timeout=SOON_MS)
    expect(banner).to_have_count(1)
    expect(page.get_by_text(re.compile("everything is stored"))).to_have_count(0)
    visitor.picture("live-service-stopped-1440")
    context.close()
