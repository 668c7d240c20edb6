"""Clip levels found while a session runs are in force after a restart as if there had been none."""

import asyncio
import time
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pytest
from sqlalchemy import Engine

from app.live import repository
from app.live.bus import MemoryBus
from app.live.checks.plausibility import check
from app.live.session.opening import Opener, Place
from app.live.session.runner import LiveSession
from app.network.declaration import Declaration
from app.network.packet import Packet, decode_packet, encode_packet
from app.recordings.signals.group_commit import GroupCommitWriter
from estimators.channels import Channel
from estimators.pipelines import Frames, SessionSetup
from estimators.recording import Float, ImuChunk, SampleQuality
from validation.orientation.honesty_scenes import STEP_S, scene

SENSORS = ("upper_arm_right", "forearm_right")
NETWORK = Declaration(SENSORS, 1.0 / STEP_S)
TICKS = 5


@pytest.fixture(scope="module")
def packets() -> list[Packet]:
    """One device whose gyroscope is cut off, one that is not; no magnetometer, so all of it is replayed."""
    made = [scene(title, [4])[0] for title in ("gyroscope clipped", "arm swings")]
    rate, force = (
        np.concatenate([getattr(one, name) for one in made])
        for name in ("gyroscope_radps", "accelerometer_mps2")
    )
    # Calibration leaves no two values at the limit alike.
    rate = rate * (1.0 + 5e-4 * np.random.default_rng(3).uniform(-1.0, 1.0, rate.shape))
    values = np.concatenate([rate, force], axis=2).transpose(1, 0, 2).astype(np.float32)
    return [
        decode_packet(
            encode_packet(
                np.ascontiguousarray(values[TICKS * number : TICKS * (number + 1)]),
                sequence=number,
                device_time_us=5_000_000_000 + 50_000 * number,
                tick_interval_us=10_000,
                channels=Channel.GYROSCOPE | Channel.ACCELEROMETER,
            )
        )
        for number in range(len(values) // TICKS)
    ]


@dataclass
class Service:
    """One run of the service, and what the session in it estimated."""

    engine: Engine
    session_id: str
    session: LiveSession = field(init=False)
    chunks: list[ImuChunk] = field(default_factory=list)
    frames: list[Frames] = field(default_factory=list)

    async def __aenter__(self) -> "Service":
        async def prepared(setup: SessionSetup) -> None: ...

        self._writer = GroupCommitWriter(self.engine)
        self._writer.start()
        opener = Opener(self.engine, self._writer, MemoryBus(), Place("north"), check)  # type: ignore[arg-type]
        self.session = await opener.open(self.session_id, NETWORK, prepared)
        # Every check that is due comes, whatever other sessions of this process cost.
        self.session._first_seconds._turns = None
        after = self.session.line._after

        def noted(chunk: ImuChunk, frames: Frames, arrival_s: float | None) -> None:
            self.chunks.append(chunk)
            self.frames.append(frames)
            after(chunk, frames, arrival_s)

        self.session.line._after = noted
        self.session.connected()
        return self

    async def __aexit__(self, *_: object) -> None:
        """Stop without closing the session, when what came is stored."""
        await self.session._saver.saved()
        self._writer.close()

    async def send(self, packets: list[Packet]) -> None:
        for packet in packets:
            self.session.receive(packet, time.monotonic(), time.time_ns())
            if (checking := self.session._first_seconds._checking) is not None:
                await checking

    @property
    def levels(self) -> Float:
        return self.session.aligner.clip_levels.copy()


def new_session(client: Any, patient_id: str) -> str:
    answer = client.post("/api/sessions", json={"patient_id": patient_id, "placements": list(SENSORS)})
    assert answer.is_success, answer.text
    return str(answer.json()["id"])


def test_levels_found_are_as_before_after_a_restart(
    therapist: Any, world: Any, engine: Engine, packets: list[Packet]
) -> None:
    async def run() -> None:
        async with Service(engine, new_session(therapist, world.patient_id)) as undisturbed:
            await undisturbed.send(packets)
        found = undisturbed.session.declaration.found_clips
        assert {clips.sensor for clips in found} == {0}
        # Until its next check, after three seconds, a session knows no more than before.
        cut_off = [bool((chunk.quality & SampleQuality.SATURATED).any()) for chunk in undisturbed.chunks]
        at = next(
            number
            for number in range(found[0].first_sequence + 20, len(packets) - 600)
            if sum(cut_off[number : number + 50]) > 5
            and not [clips for clips in found if number <= clips.first_sequence < number + 50]
        )
        stop = at + 50

        session_id = new_session(therapist, world.other_patient_id)
        async with Service(engine, session_id) as before:
            await before.send(packets[:at])
        assert np.isfinite(before.levels[0, 0]).any()
        async with Service(engine, session_id) as again:
            np.testing.assert_array_equal(again.levels, before.levels)
            await again.send(packets[at:stop])
            np.testing.assert_array_equal(again.levels, before.levels)
            await again.send(packets[stop : stop + 500])
            # Checks since have found the same, but for the largest value of new samples.
            np.testing.assert_allclose(again.levels, before.levels, rtol=1e-4)
        for one, other in zip(again.chunks[: stop - at], undisturbed.chunks[at:stop], strict=True):
            np.testing.assert_array_equal(one.quality, other.quality)
        for frames, others in zip(again.frames[: stop - at], undisturbed.frames[at:stop], strict=True):
            for name in ("q_room_segment", "segment_sigma_rad", "segment_flags", "angle_rad"):
                np.testing.assert_array_equal(getattr(frames, name), getattr(others, name))

    asyncio.run(run())


def test_what_a_check_finds_is_in_force_stored_and_revoked_with_the_sensor(
    therapist: Any, world: Any, engine: Engine, packets: list[Packet]
) -> None:
    async def run() -> None:
        levels = np.full((2, 2, 2, 3), np.inf)
        levels[1, 1, 0, 2] = 17.0
        session_id = new_session(therapist, world.patient_id)
        async with Service(engine, session_id) as service:
            await service.send(packets[:3])
            service.session._cut_off(levels)
            service.session._cut_off(levels)
            np.testing.assert_array_equal(service.levels, levels)
            (found,) = service.session.declaration.found_clips
            assert (found.first_sequence, found.sensor) == (3, 1)
        hello = repository.load(engine, session_id).hello
        assert hello is not None
        np.testing.assert_array_equal(Declaration.from_dict(hello).clip_levels, levels)
        async with Service(engine, session_id) as service:
            np.testing.assert_array_equal(service.levels, levels)
            service.session._cut_off(np.full_like(levels, np.inf))
        async with Service(engine, session_id) as service:
            assert np.isinf(service.levels).all()

    asyncio.run(run())
