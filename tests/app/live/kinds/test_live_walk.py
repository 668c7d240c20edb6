"""A walk over the real socket: feet followed while it is walked, and off-line when the gateway is done."""

import asyncio
from collections.abc import Awaitable, Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from sqlalchemy import Engine

from app.gateway import GatewayClient, Milestone, ServiceClient, stream_of
from app.recordings.schemas import SessionIn
from estimators.comparison import template_to_bytes
from estimators.pipelines import SessionSetup, analyse_walk
from estimators.recording import Recording, SensorSignals
from tests.app.assessment.templates.walked import source, template_of, walked
from tests.app.live.guided import prescribe
from tests.patience import PATIENCE_S

FEET = Path(__file__).parents[3] / "data" / "feet"
RATE_HZ, SECONDS = 204.8, 20.0

SignedIn = Callable[..., Awaitable[ServiceClient]]


@pytest.mark.slow
def test_feet_are_followed_live_and_again_when_all_has_come(signed_in: SignedIn, world: Any) -> None:
    content = np.load(FEET / "gaitmap_strides.npz")
    ticks = int(SECONDS * RATE_HZ)
    sensors = {
        f"foot_{side}": SensorSignals(
            np.arange(ticks) / RATE_HZ,
            content[f"gyroscope_{side}_radps"][:ticks].astype(float),
            content[f"accelerometer_{side}_mps2"][:ticks].astype(float),
        )
        for side in ("left", "right")
    }
    recording = Recording(sensors, RATE_HZ)
    device = stream_of(recording)

    async def run() -> None:
        async with await signed_in() as service:
            created = await service.create_session(
                SessionIn(
                    patient_id=world.patient_id,
                    pipeline="gait",
                    placements=["foot_left", "foot_right"],
                    rate_hz=RATE_HZ,
                )
            )

            async def record() -> None:
                # Nothing is to be calibrated: connected means ready.
                await service.wait_for_state(created.id, "ready", timeout_s=PATIENCE_S)
                await service.steer(created.id, "record")

            gateway = GatewayClient(
                service.ingest_url, partial(service.ticket, created.id), device.hello, pace=None
            )
            await gateway.run(device.deliveries(device.plan()), milestones=[Milestone(0.5, record)])
            await service.wait_for_state(created.id, "analysed", timeout_s=PATIENCE_S)
            found = await service.session(created.id)
            assert {result.kind for result in found.results} == {"live", "offline"}
            walk = (await service.http.get(f"/api/sessions/{created.id}/gait")).json()
            setup = SessionSetup("gait", ("foot_left", "foot_right"), RATE_HZ)
            direct = analyse_walk(recording, setup)
            for foot in walk["feet"]:
                lengths = [stride["length_m"] for stride in foot["strides"]]
                np.testing.assert_allclose(lengths, direct.strides[foot["side"]].length_m, atol=5e-3)
            live = next(result.id for result in found.results if result.kind == "live")
            none = await service.http.get(f"/api/sessions/{created.id}/gait", params={"result_id": live})
            assert none.status_code == 409
            frames = await service.http.get(
                f"/api/sessions/{created.id}/frames", params={"result_id": live, "start_s": 0, "end_s": 20}
            )
            assert frames.is_success

    asyncio.run(run())


@pytest.mark.slow
def test_a_walk_with_a_template_counts_nothing_live_and_is_compared_afterwards(
    signed_in: SignedIn, engine: Engine, world: Any
) -> None:
    prescription_id = prescribe(engine, world, content=template_to_bytes(template_of(source(seed=1))))
    device = stream_of(walked(seed=2).recording)

    async def run() -> None:
        async with await signed_in() as service:
            created = await service.create_session(
                SessionIn(
                    patient_id=world.patient_id,
                    exercise_id=world.exercise_id,
                    prescription_id=prescription_id,
                    pipeline="gait",
                    placements=["foot_left", "foot_right"],
                    rate_hz=100.0,
                )
            )

            async def record() -> None:
                await service.wait_for_state(created.id, "ready", timeout_s=PATIENCE_S)
                await service.steer(created.id, "record")

            gateway = GatewayClient(
                service.ingest_url, partial(service.ticket, created.id), device.hello, pace=None
            )
            await gateway.run(device.deliveries(device.plan()), milestones=[Milestone(0.1, record)])
            await service.wait_for_state(created.id, "analysed", timeout_s=PATIENCE_S)
            events = (await service.session(created.id)).events
            said = [str(one.text) for one in events if one.kind == "guidance_off"]
            assert said == [
                "A walk is compared with its template afterwards: nothing is counted while it goes on."
            ]
            assert not [one for one in events if one.kind in ("repetition", "cue", "guidance_failed")]
            (compared,) = (await service.http.get(f"/api/sessions/{created.id}/comparisons")).json()
            found = (await service.http.get(f"/api/comparisons/{compared['id']}")).json()
            assert found["findings"] == ["The movement matched the template within what can be measured."]

    asyncio.run(run())
