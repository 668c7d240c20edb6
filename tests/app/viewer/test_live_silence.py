"""What a live 3D view says while it has nothing new to show, and that it says nothing of the kind while it has."""

import asyncio
from collections.abc import AsyncIterator, Callable, Iterator
from contextlib import asynccontextmanager
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from app.live.blocks import PublishedFrames
from app.live.bus import MemoryBus, topic
from app.live.messages import HealthMessage, StateMessage
from app.schemas import SessionState
from app.viewer import player as players
from app.viewer.player import LivePlayer
from app.viewer.pose import measured_segments
from app.viewer.scene import BodyScene
from app.viewer.stage import LoopbackServer
from estimators.body import BodyDimensions
from estimators.orientation import OrientationFlag
from estimators.pipelines import Frames
from tests.patience import PATIENCE_S

SILENCE_S = 0.4
A_PIECE = 200
"""Ticks of what fills a long gap that are estimated together."""


@pytest.fixture
def server() -> Iterator[LoopbackServer]:
    one = LoopbackServer()
    yield one
    one.stop()


def seen(server: LoopbackServer) -> str | None:
    """What is said of all sensors together."""
    handle = server.scene._handle_from_node_name["/patient/sternum/silent"]
    return str(handle.text) if handle.visible else None


def is_grey(scene: BodyScene) -> bool:
    return bool(scene._lost[scene.measured_mask].all())


async def until(condition: Callable[[], bool]) -> None:
    for _ in range(int(PATIENCE_S / 0.01)):
        if condition():
            return
        await asyncio.sleep(0.01)
    raise TimeoutError("what is waited for does not come")


class Session:
    """Publishes what a live session would."""

    def __init__(self, bus: MemoryBus, scene: BodyScene, frames: Frames) -> None:
        self.bus, self.scene, self.frames = bus, scene, frames
        self.packets = 100

    def show(self, frames: Frames) -> None:
        self.bus.publish(topic("s", "frames"), PublishedFrames(frames, 0.0))

    def health(self, new_packets: int) -> None:
        self.packets += new_packets
        message = HealthMessage.model_construct(packets_received=self.packets)
        self.bus.publish(topic("s", "health"), message)

    def state(self, state: SessionState) -> None:
        self.bus.publish(
            topic("s", "state"), StateMessage.model_construct(state=state, recording_start_s=None)
        )

    async def fall_silent(self) -> None:
        """Give one packet's frames, then nothing, until the figure says that it is not of now."""
        self.show(self.frames.ticks(0, 5))
        await until(lambda: is_grey(self.scene))


@asynccontextmanager
async def live(server: LoopbackServer, frames: Frames) -> AsyncIterator[Session]:
    scene = BodyScene(server, BodyDimensions(), measured_segments(frames))
    bus = MemoryBus()
    task = asyncio.create_task(LivePlayer(scene, bus, "s", BodyDimensions(), None).run())
    await asyncio.sleep(0)
    yield Session(bus, scene, frames)
    task.cancel()


@pytest.fixture
def frames(reaches: Any, monkeypatch: pytest.MonkeyPatch) -> Frames:
    monkeypatch.setattr(players, "SILENCE_S", SILENCE_S)
    found: Frames = reaches[0]
    return found


@pytest.mark.parametrize(
    ("new_packets", "said"), [(0, "No data from the sensors"), (20, "No live picture at the moment")]
)
def test_sensors_are_blamed_only_where_no_packet_arrives(
    server: LoopbackServer, frames: Frames, new_packets: int, said: str
) -> None:
    async def watch() -> None:
        async with live(server, frames) as session:
            session.health(20)
            await session.fall_silent()
            session.health(20)
            await asyncio.sleep(3 * SILENCE_S)
            assert seen(server) is None, "some of these packets came with the last frame"
            session.health(new_packets)
            await until(lambda: seen(server) is not None)
            assert seen(server) == said
            session.show(frames.ticks(5, 10))
            await until(lambda: seen(server) is None)
            assert not is_grey(session.scene)

    asyncio.run(watch())


@pytest.mark.parametrize(
    ("state", "said"),
    [
        ("link_lost", "No data from the sensors"),
        ("failed", "No live picture at the moment"),
        ("closing", None),
        ("recording", None),
    ],
)
def test_the_state_of_the_session_says_why(
    server: LoopbackServer, frames: Frames, state: SessionState, said: str | None
) -> None:
    async def watch() -> None:
        async with live(server, frames) as session:
            await session.fall_silent()
            session.state(state)
            await asyncio.sleep(3 * SILENCE_S)
            assert seen(server) == said
            assert is_grey(session.scene)

    asyncio.run(watch())


def test_a_gap_is_not_played_when_packets_arrive_again(server: LoopbackServer, frames: Frames) -> None:
    lost = frames.segment_flags | np.uint8(OrientationFlag.INVALID)
    gap = replace(frames, segment_flags=lost).ticks(0, A_PIECE)

    async def watch() -> None:
        async with live(server, frames) as session:
            await session.fall_silent()
            session.state("link_lost")
            await until(lambda: seen(server) == "No data from the sensors")
            session.state("recording")
            for _ in range(3):
                session.show(gap)
                await asyncio.sleep(0.02)
            packet_s = 5 * frames.time_step_s
            for start in range(A_PIECE, A_PIECE + 100, 5):
                session.show(frames.ticks(start, start + 5))
                await asyncio.sleep(packet_s)
                if start >= A_PIECE + 50:
                    assert seen(server) is None, "half a second after the first packet"
                    assert not is_grey(session.scene)

    asyncio.run(watch())


def test_nothing_is_said_while_somebody_rests(server: LoopbackServer, frames: Frames) -> None:
    async def watch() -> None:
        async with live(server, frames) as session:
            for number in range(30):
                session.show(frames.ticks(0, 5))
                session.health(1)
                await asyncio.sleep(0.1 * SILENCE_S)
                if number:
                    assert not is_grey(session.scene)
                    assert seen(server) is None

    asyncio.run(watch())
