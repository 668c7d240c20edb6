"""Forces of two shoes over the real socket: live against the simulator's truth, and again from the store."""

import asyncio
import struct
from collections.abc import Awaitable, Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from app.commands.simulation.walk import WalkOptions, stream, walk_of
from app.gateway import ServiceClient

SignedIn = Callable[..., Awaitable[ServiceClient]]
LOST = slice(1200, 1260)


async def table_of(service: ServiceClient, session_id: str, result_id: str) -> dict[str, np.ndarray]:
    """Return the columns of a result by name."""
    wanted = {"result_id": result_id}
    layout = (await service.http.get(f"/api/sessions/{session_id}/layout", params=wanted)).json()
    block = (await service.http.get(f"/api/sessions/{session_id}/frames", params=wanted)).content
    magic, ticks, columns, *_ = struct.unpack_from("<4sIIIddd", block)
    assert magic == b"TMF1"
    rows = np.frombuffer(block, "<f4", offset=struct.calcsize("<4sIIIddd")).reshape(ticks, columns)
    return dict(zip(layout["columns"], rows.T.astype(float), strict=True)) | {
        "delay_s": np.array(layout["delay_s"])
    }


@pytest.mark.slow
def test_mass_and_pressure_live_over_the_socket(signed_in: SignedIn, world: Any) -> None:
    options = WalkOptions(patient_id=world.patient_id, steps=18, seed=2, speed=None)
    walked, measured, _ = walk_of(options)
    heel = measured.sensors["heel_right"]
    force = heel.force_n.copy()
    force[LOST] = np.nan
    sent = replace(measured, sensors=measured.sensors | {"heel_right": replace(heel, force_n=force)})

    async def run() -> tuple[dict[str, np.ndarray], dict[str, np.ndarray], dict[str, Any], list[Any]]:
        async with await signed_in() as service:
            session_id, report = await stream(service, options, lambda text: None, sent)
            assert report.unacknowledged == 0
            found = await service.session(session_id)
            kinds = {result.kind: result.id for result in found.results}
            live = await table_of(service, session_id, kinds["live"])
            after = await table_of(service, session_id, kinds["offline"])
            walk = (await service.http.get(f"/api/sessions/{session_id}/gait")).json()
            return live, after, walk, list(found.events)

    live, after, walk, events = asyncio.run(run())
    delay = round(float(live["delay_s"]) * 100.0)
    assert 50 < delay < 100
    truth = walked.truth
    count = len(live["centre_of_mass.x"]) - delay
    state = live["foot_right_force_state"][delay:]
    assert (state[LOST] == 2.0).all()
    assert any(event.kind == "forces_lost" and event.placement == "foot_right" for event in events)
    for name, true in (
        ("centre_of_mass", truth.com.position[:count]),
        ("centre_of_pressure", truth.cop_m[:count]),
    ):
        given = np.stack([live[f"{name}.{axis}"][delay:] for axis in "xyz"], axis=1)
        known = np.isfinite(given).all(axis=1)
        assert known.mean() > 0.5
        assert not known[1240:1260].any()
        apart = (given - true)[known]
        # The live room has its origin below the heels and faces the course: so does the simulated one.
        assert np.sqrt(np.mean(apart[:, :2] ** 2)) < 0.05, name
        assert np.sqrt(np.mean((apart - apart.mean(axis=0))[:, :2] ** 2)) < 0.03, name
    # The store has the forces: what is analysed afterwards knows balance, and says which stretch.
    assert np.isfinite(after["centre_of_mass.x"]).mean() > 0.4
    assert walk["balance"] is not None
    assert any("right heel" in reason for reason in walk["reasons"])
