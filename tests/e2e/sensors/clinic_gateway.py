"""A gateway in the clinic, for tests: sensors on somebody whom the therapist steers in the browser."""

import asyncio
import threading
import time
from dataclasses import replace
from typing import Final

from app.demo.people import PASSWORD, THERAPIST
from app.gateway import GatewayClient, Milestone, ServiceClient, stream_of
from estimators.simulation import ArmScenario, demonstration_scenario, simulate_arm
from tests.patience import PATIENCE_S

PACE: Final = 2.0
"""Times real time."""
POSE_S: Final = 50.0
"""Long enough for a person on a busy machine to calibrate and press record while the sensors go on sending."""
PATIENT: Final = demonstration_scenario("moderate_stroke", "reaching", progress=0.9, repetitions=3, seed=5)


class Gateway(threading.Thread):
    """Somebody with sensors on: streams a session that the therapist steers in the browser.

    Parameters
    ----------
    address : str
        Of the service.
    session_id : str
    placements : list of str
        In the order of the session.
    scenario : ArmScenario
        Who moves, and how.
    pose_s : float
        How long the pose is held at least.
    """

    def __init__(
        self,
        address: str,
        session_id: str,
        placements: list[str],
        scenario: ArmScenario = PATIENT,
        pose_s: float = POSE_S,
    ) -> None:
        super().__init__(daemon=True)
        self.address, self.session_id = address, session_id
        # Resting long after the last repetition, so that the link is still up when recording is stopped.
        schedule = replace(scenario.schedule, n_pose_s=pose_s, settle_s=20.0)
        self.session = simulate_arm(replace(scenario, placements=tuple(placements), schedule=schedule))  # type: ignore[arg-type]
        self.pose_s = pose_s
        self.done_s = float(self.session.truth.repetitions_s[-1, 1])
        self.began = time.monotonic()
        self.error: BaseException | None = None

    def run(self) -> None:
        try:
            asyncio.run(self._stream())
        except BaseException as error:
            self.error = error

    async def _stream(self) -> None:
        async with ServiceClient(self.address) as service:
            await service.sign_in(THERAPIST, PASSWORD)

            async def moving() -> None:
                # The patient stands in the pose until the therapist has calibrated and pressed record.
                await service.wait_for_state(self.session_id, "recording", timeout_s=PATIENCE_S)

            async def stopped() -> None:
                await service.wait_for_state(
                    self.session_id, "ready", "closing", "analysed", timeout_s=PATIENCE_S
                )

            device = stream_of(self.session.recording)
            end_s = device.packet_count * device.packet_s
            client = GatewayClient(
                service.ingest_url, lambda: service.ticket(self.session_id), device.hello, pace=PACE
            )
            await client.run(
                device.deliveries(device.plan()),
                milestones=[Milestone(self.pose_s, moving), Milestone(end_s + 1.0, stopped)],
                goodbye=False,
            )
