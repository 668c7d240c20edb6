"""A patient who measures without a gateway: what is emulated, what is stored, what our own gateway makes of it."""

import io
import struct
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import httpx
import numpy as np
from numpy.typing import NDArray
from playwright.sync_api import Page

from app.demo.people import PASSWORD, PATIENTS, THERAPIST
from app.gateway import DeviceStream, GatewayClient, Milestone, ServiceClient
from app.gateway.encoding import FULL_SCALES
from app.network.packet import decode_packet
from app.network.packet_log import read_entries, read_head
from app.recordings.schemas import SessionIn
from estimators.channels import Channel
from estimators.simulation import ArmScenario, Schedule, simulate_arm
from tests.patience import PATIENCE_S

RATE_HZ = 60.0
STILL_S = 14.0
"""The simulated person stands so long before the movement."""
STANDING = (round((STILL_S - 4.0) * RATE_HZ), round((STILL_S - 1.0) * RATE_HZ))
"""Ticks, first and one past the last, that come again until the page has been pressed, on a busy machine too."""
EMULATED = Path(__file__).with_name("emulated.js").read_text()

WAITING = """new Promise(done => {
    const asked = indexedDB.open('telemotion-sensors');
    asked.onsuccess = () => {
        const count = asked.result.transaction('packets').objectStore('packets').count();
        count.onsuccess = () => { asked.result.close(); done(count.result); };
    };
})"""
"""How many packets are on the device."""


def wait_until_sent(page: Page) -> None:
    """Wait until no packet is on the device."""
    until_s = time.monotonic() + PATIENCE_S
    while page.evaluate(WAITING) > 0:
        assert time.monotonic() < until_s, "packets are still on the device"
        page.wait_for_timeout(250)


@dataclass(frozen=True)
class Wearer:
    """Somebody who moves, as sensors feel it.

    Attributes
    ----------
    placements : tuple of str
    samples : ndarray, shape (ticks, sensors, 6)
        Gyroscope, rad/s, then accelerometer, m/s^2.
    elevation_rad : ndarray, shape (ticks,)
        True elevation of the upper arm against the trunk.
    """

    placements: tuple[str, ...]
    samples: NDArray[np.float64]
    elevation_rad: NDArray[np.float64]


def wearer(placements: tuple[str, ...], movement_s: float, seed: int = 5, still_s: float = STILL_S) -> Wearer:
    """Simulate a person who stands still and then abducts the right arm."""
    scenario = ArmScenario(
        exercise="abduction",
        side="right",
        rate_hz=RATE_HZ,
        errors="nominal",
        schedule=Schedule(n_pose_s=still_s, repetitions=None, duration_s=still_s + movement_s),
        seed=seed,
    )
    simulated = simulate_arm(scenario)
    sensors = [simulated.recording.sensors[place] for place in placements]  # type: ignore[index]
    values = [np.concatenate([one.gyroscope_radps, one.accelerometer_mps2], axis=1) for one in sensors]
    truth = simulated.truth.angle_rad("thorax_humerus_right_yxy_elevation")
    return Wearer(placements, np.stack(values, axis=1), truth)


def as_emitted(page: Page, worn: Wearer) -> Wearer:
    """Return what came out of the emulation, tick by tick, where a rest came again until it was left."""
    order = np.array(page.evaluate("emulated.order"), dtype=int)
    return replace(worn, samples=worn.samples[order], elevation_rad=worn.elevation_rad[order])


@contextmanager
def therapist_at(address: str) -> Iterator[httpx.Client]:
    """Yield a client that is signed in as the therapist; the patient is on a page."""
    with httpx.Client(base_url=address, headers={"Origin": address}, trust_env=False, timeout=60) as client:
        answer = client.post("/api/sign-in", json={"email": THERAPIST, "password": PASSWORD})
        client.headers["X-CSRF-Token"] = answer.raise_for_status().json()["csrf_token"]
        yield client


def patient_of(client: httpx.Client) -> str:
    rows = client.get("/api/patients").raise_for_status().json()
    return str(next(row["id"] for row in rows if row["given_name"] == PATIENTS[0].given_name))


def stored_samples(client: httpx.Client, session_id: str) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Return the ticks that the service has, by number since 1970, and their values, shape (ticks, sensors, 6).

    A tick that is stored twice would stand twice.
    """
    raw = client.get(f"/api/sessions/{session_id}/raw").raise_for_status().content
    log = io.BytesIO(raw)
    read_head(log)
    packets = [decode_packet(data) for _, data in read_entries(log)]
    packets.sort(key=lambda packet: packet.sequence)
    assert [packet.sequence for packet in packets] == list(range(len(packets)))
    numbers = [
        round(packet.device_time_us * 1e-6 * RATE_HZ) + tick
        for packet in packets
        for tick in range(packet.tick_count)
    ]
    return np.array(numbers), np.concatenate([packet.values for packet in packets]).astype(float)


def best_error(
    ticks: NDArray[np.int64], stored: NDArray[np.float64], samples: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return how far what is stored lies off the lines between the samples, with the delay that fits it best.

    Parameters
    ----------
    ticks : ndarray, shape (n,)
        At which it is stored, from the first sample on.
    stored : ndarray, shape (n,)
    samples : ndarray, shape (N,)
        As they were emitted, one a tick. A radio brings them up to three ticks late.
    """
    at = np.arange(len(samples))
    errors = [
        np.abs(np.interp(ticks - delay_ticks, at, samples) - stored)
        for delay_ticks in np.arange(0.0, 3.0, 0.05)
    ]
    return errors[int(np.argmin([np.median(one) for one in errors]))]


def new_session(client: httpx.Client, placements: tuple[str, ...]) -> str:
    """Begin a session for the patient, as her page does when an exercise is started."""
    wanted = {"patient_id": patient_of(client), "placements": list(placements), "use_mounting": False}
    return str(client.post("/api/sessions", json=wanted).raise_for_status().json()["id"])


async def stream_by_gateway(
    address: str, worn: Wearer, first: int, record_s: float, ticks_per_packet: int = 6
) -> str:
    """Stream the same samples, from this one on, by the gateway in Python; return the session."""
    scales = np.repeat([FULL_SCALES["gyroscope"], FULL_SCALES["accelerometer"]], 3) / 32767.0
    counts = np.rint(worn.samples[first:] / scales).astype(np.int16)
    device = DeviceStream(
        worn.placements,
        RATE_HZ,
        counts,
        ticks_per_packet=ticks_per_packet,
        channels=Channel.GYROSCOPE | Channel.ACCELEROMETER,
    )
    async with ServiceClient(address) as service:
        await service.sign_in(THERAPIST, PASSWORD)
        patient_id = next(
            row["id"]
            for row in await service.every("/api/patients")
            if row["given_name"] == PATIENTS[0].given_name
        )
        made = await service.create_session(
            SessionIn(patient_id=patient_id, placements=list(worn.placements), use_mounting=False)  # type: ignore[arg-type]
        )

        async def calibrate() -> None:
            await service.steer(made.id, "calibrate")

        async def record() -> None:
            await service.wait_for_state(made.id, "ready", timeout_s=PATIENCE_S)
            await service.steer(made.id, "record")

        gateway = GatewayClient(service.ingest_url, partial(service.ticket, made.id), device.hello, pace=None)
        await gateway.run(
            device.deliveries(device.plan()),
            milestones=[Milestone(0.5, calibrate), Milestone(record_s, record)],
        )
        await service.wait_for_state(made.id, "analysed", timeout_s=PATIENCE_S)
        return made.id


def angles_of(
    client: httpx.Client, session_id: str, angle: str
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Return an analysed session's ticks and one of its angles there, rad."""
    found = client.get(f"/api/sessions/{session_id}").raise_for_status().json()
    query = {"result_id": found["main_result_id"]}
    layout = client.get(f"/api/sessions/{session_id}/layout", params=query).raise_for_status().json()
    block = client.get(f"/api/sessions/{session_id}/frames", params=query).raise_for_status().content
    _, ticks, columns, _, start_s, step_s, _ = struct.unpack("<4sIIIddd", block[:40])
    rows = np.frombuffer(block[40:], "<f4").reshape(ticks, columns)
    numbers = np.rint((start_s + step_s * np.arange(ticks)) * RATE_HZ).astype(int)
    return numbers, rows[:, layout["columns"].index(angle)].astype(float)
