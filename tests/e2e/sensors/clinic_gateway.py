"""A gateway in the clinic, for tests: sensors on somebody whom the therapist steers in the browser."""

import asyncio
import itertools
import math
import threading
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Final

from app.demo.people import PASSWORD, THERAPIST
from app.gateway import DeviceStream, GatewayClient, Milestone, ServiceClient, stream_of
from app.gateway.client import Delivery
from app.gateway.encoding import EPOCH_US
from app.network.packet import encode_packet
from estimators.simulation import ArmScenario, demonstration_scenario, simulate_arm
from tests.patience import PATIENCE_S

PACE: Final = 2.0
"""Times real time."""
POSE_S: Final = 16.0
HELD_S: Final = (2.0, 12.0)
"""The part of the pose that is sent again and again until recording begins."""
RESTED_S: Final = 10.0
"""After the last repetition the movement counts as over."""
PATIENT: Final = demonstration_scenario("moderate_stroke", "reaching", progress=0.9, repetitions=3, seed=5)


Hold = tuple[float, float, Callable[[], bool]]
"""A part of a recording, from and to, s, that is sent again and again until it may go on."""


def deliveries(device: DeviceStream, *holds: Hold) -> Iterator[tuple[float, Delivery]]:
    """Yield each packet with its time in the recording; repeat each hold until it may go on."""
    waiting = list(holds)
    behind = 0
    for sequence in itertools.count():
        if waiting:
            first, last = (round(at_s / device.packet_s) for at_s in waiting[0][:2])
            if sequence - behind == last:
                if waiting[0][2]():
                    waiting.pop(0)
                else:
                    behind += last - first
        number = sequence - behind
        if number == device.packet_count:
            return
        start, send_s = number * device.ticks_per_packet, sequence * device.packet_s
        data = encode_packet(
            device.counts[start : start + device.ticks_per_packet],
            sequence=sequence,
            device_time_us=EPOCH_US + round(1e6 * send_s),
            tick_interval_us=round(1e6 / device.rate_hz),
            channels=device.channels,
        )
        yield number * device.packet_s, Delivery(sequence, data, send_s)


class Gateway(threading.Thread):
    """Somebody with sensors on: streams a session that the therapist steers in the browser.

    The pose is held until recording begins. `has_moved` is set some time after the last repetition.

    Parameters
    ----------
    address : str
        Of the service.
    session_id : str
    placements : list of str
        In the order of the session.
    scenario : ArmScenario
        Who moves, and how.
    """

    def __init__(
        self, address: str, session_id: str, placements: list[str], scenario: ArmScenario = PATIENT
    ) -> None:
        super().__init__(daemon=True)
        self.address, self.session_id = address, session_id
        # Resting long after the last repetition, so that the link is still up when recording is stopped.
        schedule = replace(scenario.schedule, n_pose_s=POSE_S, settle_s=2.0 * RESTED_S)
        session = simulate_arm(replace(scenario, placements=tuple(placements), schedule=schedule))  # type: ignore[arg-type]
        self.device = stream_of(session.recording)
        self.moved_s = float(session.truth.repetitions_s[-1, 1]) + RESTED_S
        self.has_moved = threading.Event()
        self.error: BaseException | None = None

    def run(self) -> None:
        try:
            asyncio.run(self._stream())
        except BaseException as error:
            self.error = error

    async def _stream(self) -> None:
        async with ServiceClient(self.address) as service:
            await service.sign_in(THERAPIST, PASSWORD)
            recording = asyncio.create_task(
                service.wait_for_state(self.session_id, "recording", timeout_s=PATIENCE_S)
            )

            async def stopped() -> None:
                await service.wait_for_state(
                    self.session_id, "ready", "closing", "analysed", timeout_s=PATIENCE_S
                )

            client = GatewayClient(
                service.ingest_url, lambda: service.ticket(self.session_id), self.device.hello, pace=PACE
            )
            try:
                await client.run(
                    self._sent(recording.done), milestones=[Milestone(math.inf, stopped)], goodbye=False
                )
            finally:
                recording.cancel()

    def _sent(self, may_move: Callable[[], bool]) -> Iterator[Delivery]:
        for at_s, delivery in deliveries(self.device, (*HELD_S, may_move)):
            if at_s >= self.moved_s:
                self.has_moved.set()
            yield delivery
