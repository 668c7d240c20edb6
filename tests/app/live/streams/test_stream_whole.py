"""The main promise over the real socket: ten minutes of two arms over a bad link, and a server that is killed."""

import asyncio
import sqlite3
import struct
from collections.abc import Awaitable, Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from sqlalchemy import Engine

from app.gateway import DeviceStream, GatewayClient, GatewayReport, Milestone, ServiceClient, stream_of
from app.recordings.schemas import SessionDetail, SessionIn
from app.recordings.signals.store import read_packets
from estimators.simulation import ArmScenario, Schedule, SimulatedSession, simulate_arm
from estimators.simulation.faults import DeliveryPlan, LinkFaults
from tests.patience import PATIENCE_S

SEED = 3
LINK = LinkFaults(
    loss_fraction=0.05, duplicate_fraction=0.05, reorder_fraction=0.05, break_count=2, break_s=3.0
)

N_POSE_S = 20.0
"""Long enough for six seconds without a gap of more than 200 ms somewhere in it, also on the bad link."""
INVALID, BRIDGED = 1, 2
SignedIn = Callable[..., Awaitable[ServiceClient]]


@pytest.fixture(scope="module")
def ten_minutes() -> SimulatedSession:
    """Both arms drink for ten minutes; sensor noise of the method page, no magnet."""
    schedule = Schedule(n_pose_s=N_POSE_S, repetitions=None, duration_s=600.0)
    return simulate_arm(
        ArmScenario(exercise="drinking", both_arms=True, errors="marzouk_2009", schedule=schedule, seed=SEED)
    )


async def stream_through(
    client: ServiceClient, patient_id: str, stream: DeviceStream, plan: DeliveryPlan
) -> tuple[SessionDetail, GatewayReport]:
    """Create a session, stream it as fast as the server takes it, calibrate, record, and wait for the analysis."""
    made = await client.create_session(SessionIn(patient_id=patient_id, placements=list(stream.placements)))  # type: ignore[arg-type]

    async def calibrate() -> None:
        await client.steer(made.id, "calibrate")

    async def record() -> None:
        await client.wait_for_state(made.id, "ready", timeout_s=PATIENCE_S)
        await client.steer(made.id, "record")

    gateway = GatewayClient(client.ingest_url, partial(client.ticket, made.id), stream.hello, pace=None)
    report = await gateway.run(
        stream.deliveries(plan),
        breaks_s=[(float(start), float(end)) for start, end in plan.breaks_s],
        milestones=[Milestone(0.0, calibrate), Milestone(N_POSE_S - 1.0, record)],
    )
    await client.wait_for_state(made.id, "analysed", timeout_s=PATIENCE_S)
    return await client.session(made.id), report


async def frames_of(
    client: ServiceClient, session_id: str, result_id: str
) -> tuple[dict[str, Any], np.ndarray]:
    """Return the columns by name, at every tick that is shown, and the ticks."""
    query = {"result_id": result_id}
    layout = (await client.http.get(f"/api/sessions/{session_id}/layout", params=query)).json()
    block = (await client.http.get(f"/api/sessions/{session_id}/frames", params=query)).content
    _, ticks, columns, _, start_s, step_s, _ = struct.unpack("<4sIIIddd", block[:40])
    rows = np.frombuffer(block[40:], "<f4").reshape(ticks, columns)
    tick = np.rint((start_s + step_s * np.arange(ticks)) * 100.0).astype(int)
    return {name: rows[:, number] for number, name in enumerate(layout["columns"])}, tick


def rms_deg(
    columns: dict[str, Any], tick: np.ndarray, truth: Any, angle: str, excluded: int
) -> tuple[float, float]:
    """Return the RMS error of an angle over the ticks without the excluded flags, and their share."""
    flags = columns[f"{angle}.flags"].astype(int)
    sound = (flags & excluded) == 0
    error = columns[angle] - truth.angle_rad(angle)[tick]
    error = np.angle(np.exp(1j * error[sound]))
    return float(np.rad2deg(np.sqrt(np.mean(error**2)))), float(sound.mean())


@pytest.mark.slow
@pytest.mark.parametrize(("faults", "limit_deg"), [(None, 2.0), (LINK, 3.0)], ids=["sound link", "bad link"])
def test_ten_minutes_of_two_arms(
    ten_minutes: SimulatedSession,
    faults: LinkFaults | None,
    limit_deg: float,
    signed_in: SignedIn,
    world: Any,
    engine: Engine,
) -> None:
    stream = stream_of(ten_minutes.recording)
    plan = stream.plan(faults, seed=SEED)

    async def run() -> None:
        async with await signed_in() as client:
            session, report = await stream_through(client, world.patient_id, stream, plan)
            assert report.unacknowledged == 0
            assert report.connections == (1 if faults is None else 3)
            # Every packet sent is stored exactly once, bit for bit.
            stored = sorted((p.sequence, p.payload) for p in read_packets(engine, session.id))
            kept = np.flatnonzero(~plan.is_lost).tolist()
            assert [sequence for sequence, _ in stored] == kept
            assert all(payload == stream.packet(number)[32:] for number, payload in stored)
            assert session.packets_stored == len(kept)
            # The last packets of the plan may be among the lost ones: nobody can know of those.
            assert session.packets_missing == int(plan.is_lost[: kept[-1] + 1].sum())
            assert {result.kind for result in session.results} == {"live", "offline"}
            for result in session.results:
                columns, tick = await frames_of(client, session.id, result.id)
                check_gaps(columns, tick, plan, stream)
                check_angles(columns, tick, result.kind)

    def check_gaps(
        columns: dict[str, Any], tick: np.ndarray, plan: DeliveryPlan, stream: DeviceStream
    ) -> None:
        """Ticks of lost packets are flagged bridged or invalid, all others are not, but for the restart."""
        flags = columns["sternum.flags"].astype(int)
        lost = plan.is_lost[np.minimum(tick // stream.ticks_per_packet, plan.is_lost.size - 1)]
        assert ((flags[lost] & (BRIDGED | INVALID)) != 0).all()
        if faults is None:
            assert not (flags & BRIDGED).any()

    def check_angles(columns: dict[str, Any], tick: np.ndarray, kind: str) -> None:
        for side in ("left", "right"):
            for angle in (f"thorax_humerus_{side}_yxy_elevation", f"humerus_forearm_{side}_zxy_flexion"):
                error, share = rms_deg(columns, tick, ten_minutes.truth, angle, INVALID)
                print(f"{kind} {angle}: {error:.2f} deg over {100 * share:.0f} % of the ticks")
                assert error < limit_deg, angle
                assert share > (0.95 if faults is None else 0.6)

    asyncio.run(run())


@pytest.mark.slow
def test_a_killed_server_loses_nothing_acknowledged(
    server: Any, signed_in: SignedIn, world: Any, engine: Engine
) -> None:
    """SIGKILL in the middle, twice; the gateway resumes and the session ends whole."""
    simulated = simulate_arm(ArmScenario(schedule=Schedule(n_pose_s=10.0, repetitions=4), seed=SEED))
    stream = stream_of(simulated.recording)
    plan = stream.plan()
    acknowledged_at_kill: list[tuple[int, set[int]]] = []

    async def run() -> None:
        async with await signed_in() as client:
            made = await client.create_session(
                SessionIn(patient_id=world.patient_id, placements=list(stream.placements))  # type: ignore[arg-type]
            )
            gateway = GatewayClient(
                client.ingest_url, partial(client.ticket, made.id), stream.hello, pace=4.0
            )

            async def calibrate() -> None:
                await client.steer(made.id, "calibrate")

            async def record() -> None:
                await client.wait_for_state(made.id, "ready", timeout_s=PATIENCE_S)
                await client.steer(made.id, "record")

            async def kill() -> None:
                server.kill()
                # What the gateway was told to forget must be in the file that a dead process left.
                stored = {packet.sequence for packet in read_packets(engine, made.id)}
                acknowledged_at_kill.append((gateway.report.acknowledged, stored))
                await asyncio.to_thread(server.start)

            report = await gateway.run(
                stream.deliveries(plan),
                milestones=[
                    Milestone(0.0, calibrate),
                    Milestone(9.5, record),
                    Milestone(13.0, kill),
                    Milestone(18.0, kill),
                ],
            )
            assert report.connections == 3
            assert report.unacknowledged == 0
            await client.wait_for_state(made.id, "analysed", timeout_s=PATIENCE_S)
            session = await client.session(made.id)
            stored = [packet.sequence for packet in read_packets(engine, made.id)]
            assert sorted(stored) == list(range(stream.packet_count)), "each exactly once"
            assert session.packets_missing == 0
            assert session.calibration is not None
            assert session.recording_start_s is not None
            assert session.recording_start_s == pytest.approx(9.5, abs=0.6)
            kinds = [event.text for event in session.events if event.kind == "state"]
            assert "recording" in kinds
            for result in session.results:
                _, tick = await frames_of(client, made.id, result.id)
                # Of what was shown live, every fourth tick is stored; across both restarts none is missing.
                stride = 4 if result.kind == "live" else 1
                assert np.array_equal(tick, np.arange(0, simulated.truth.frames.tick_count, stride))

    asyncio.run(run())
    for acknowledged, stored in acknowledged_at_kill:
        assert acknowledged > 0
        assert set(range(acknowledged + 1)) <= stored
    assert len(acknowledged_at_kill) == 2


@pytest.mark.slow
def test_the_database_of_a_running_server_is_consistent(server: Any, settings: Any) -> None:
    path = Path(settings.database_url.removeprefix("sqlite:///"))
    with sqlite3.connect(path) as connection:
        assert connection.execute("PRAGMA integrity_check").fetchone() == ("ok",)
