"""The live view's clock: the template is an example for the exercise, not for the calibration pose."""

import asyncio
from typing import Any

import numpy as np
import pytest

from app.live.blocks import PublishedFrames
from app.live.bus import MemoryBus, topic
from app.live.messages import StateMessage
from app.schemas import SessionState
from app.viewer.player import LivePlayer
from estimators.body import BodyDimensions


class Scene:
    """Takes note of what it is told to draw."""

    measured_mask = np.zeros(1, dtype=bool)
    exercise_posture = "seated"
    posture = "seated"

    def __init__(self) -> None:
        self.ghosts: list[float | None] = []
        self.seats: list[bool] = []
        self.has_drawn = asyncio.Event()

    def sit(self, on: bool) -> None:
        self.seats.append(on)
        self.posture = "seated" if on else "standing"

    def show_measured(self, measured: frozenset[str]) -> None:
        pass

    def draw(self, *_: Any) -> None:
        pass

    def draw_ghost(self, phase: float | None, *, with_path: bool) -> None:
        assert with_path == (phase is not None)
        self.ghosts.append(phase)
        self.has_drawn.set()


def told(state: SessionState) -> StateMessage:
    return StateMessage(
        state=state,
        reason="",
        session_time_s=0.0,
        recording_start_s=None,
        calibration=None,
        calibration_progress=None,
    )


async def ghosts_of(frames: Any, messages: list[tuple[str, Any]], *, is_calibrating: bool) -> Scene:
    scene, bus = Scene(), MemoryBus()
    player = LivePlayer(scene, bus, "s", BodyDimensions(), 2.0, is_calibrating)  # type: ignore[arg-type]
    task = asyncio.create_task(player.run())
    await asyncio.sleep(0)
    for name, message in messages:
        bus.publish(topic("s", name), message)
    await asyncio.wait_for(scene.has_drawn.wait(), 5.0)
    task.cancel()
    return scene


@pytest.mark.parametrize(
    ("at_first", "then", "is_shown"),
    [(True, None, False), (False, None, True), (False, "calibrating", False), (True, "ready", True)],
)
def test_the_ghost_waits_while_the_pose_is_held(
    reaches: Any, at_first: bool, then: SessionState | None, is_shown: bool
) -> None:
    frames, _, _ = reaches
    few = type(frames)(
        **{
            name: value[:2] if isinstance(value, np.ndarray) else value
            for name, value in vars(frames).items()
        }
    )
    messages: list[tuple[str, Any]] = [("state", told(then))] if then else []
    # More frames than are kept: a word on the state must not be lost among them.
    messages += 20 * [("frames", PublishedFrames(few, 0.0))]
    shown = asyncio.run(ghosts_of(few, messages, is_calibrating=at_first))
    assert shown.ghosts
    assert all((phase is not None) == is_shown for phase in shown.ghosts)
    # The pose is held standing, so who sits for the exercise stands up for it.
    assert all(on == is_shown for on in shown.seats)


def test_the_ghost_waits_for_the_first_calibration(reaches: Any) -> None:
    frames, _, _ = reaches
    few = {
        name: value[:2] if isinstance(value, np.ndarray) else value for name, value in vars(frames).items()
    }
    few["point_room_m"] = np.full_like(few["point_room_m"], np.nan)
    messages = [("frames", PublishedFrames(type(frames)(**few), 0.0))]
    shown = asyncio.run(ghosts_of(None, messages, is_calibrating=False))
    assert shown.ghosts
    assert all(phase is None for phase in shown.ghosts)
    assert not any(shown.seats)
