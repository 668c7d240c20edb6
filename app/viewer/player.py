"""The clocks of the scene: a replay that is steered, and a live view that shows the newest.

Both run on the event loop, draw at most 60 times a second, and nothing at all while nobody watches.
"""

import asyncio
import contextlib
import logging
import time
from collections import deque
from dataclasses import replace
from typing import Final

import numpy as np

from app.live.bus import Bus, Subscription, topic
from app.live.guidance.messages import GuidanceMessage
from app.live.messages import PlayerCommand, PlayerState, StateMessage
from app.viewer.figure.ghost import GhostClock
from app.viewer.layers.feet_live import LiveCourse
from app.viewer.pose import PoseTrack, is_posed, measured_segments, track_from_frames
from app.viewer.scene import BodyScene
from app.viewer.silence import SilenceWatch
from estimators.body import BodyDimensions
from estimators.pipelines import Frames

logger = logging.getLogger(__name__)

PICTURE_S: Final = 1.0 / 60.0
TRAIL_S: Final = 2.0
TRAIL_RATE_HZ: Final = 30.0
LIVE_TRAIL_RATE_HZ: Final = 20.0
"""Frames come in chunks of about 50 ms; the trail takes the last tick of each."""
_PICTURES_A_TRAIL: Final = 5
_TOGETHER_S: Final = 0.12
"""A command whose time differs by less is not a jump; the two clocks are just not the same."""
_FOLLOWS: Final = 0.25
"""Share of the way to the patient's phase that the example goes with each picture."""
_NEW_REPETITION: Final = 50.0
SILENCE_S: Final = 1.0
"""Without frames for so long, everything measured is shown as lost: nothing freezes silently."""


class ReplayPlayer:
    """Plays a stored track."""

    def __init__(self, scene: BodyScene, track: PoseTrack, ghost_clock: GhostClock | None) -> None:
        self._scene = scene
        self._track = track
        self._ghost_clock = ghost_clock
        self._start_s, self._end_s = float(track.time_s[0]), float(track.time_s[-1])
        self._anchor_s, self._anchor_at = self._start_s, time.monotonic()
        self._speed, self._is_playing, self._warp = 1.0, False, True
        self._changed = asyncio.Event()
        self._stride = max(1, round(len(track) / max(self._end_s - self._start_s, 1e-3) / TRAIL_RATE_HZ))
        self._pictures = 0

    def now_s(self) -> float:
        """Return the session time that is shown."""
        elapsed = (time.monotonic() - self._anchor_at) * self._speed if self._is_playing else 0.0
        return min(max(self._anchor_s + elapsed, self._start_s), self._end_s)

    def command(self, command: PlayerCommand) -> None:
        """Obey: play, stop, jump, change speed or the ghost's timing."""
        shown = self.now_s()
        jump = not command.playing or abs(command.time_s - shown) > _TOGETHER_S * max(command.speed, 1.0)
        self._anchor_s, self._anchor_at = command.time_s if jump else shown, time.monotonic()
        self._speed, self._is_playing, self._warp = command.speed, command.playing, command.warp
        self._changed.set()

    def state(self) -> PlayerState:
        """Return what the page may want to know."""
        return PlayerState(
            mode="replay",
            time_s=self.now_s(),
            start_s=self._start_s,
            end_s=self._end_s,
            playing=self._is_playing,
            speed=self._speed,
            has_ghost=self._ghost_clock is not None,
            has_warp=bool(self._ghost_clock and self._ghost_clock.repetitions),
        )

    async def run(self) -> None:
        """Draw until cancelled."""
        while True:
            self._changed.clear()
            self._draw(self.now_s(), with_trail=True)
            if not self._is_playing:
                await self._changed.wait()
                continue
            while self._is_playing and not self._changed.is_set():
                started = time.monotonic()
                now_s = self.now_s()
                self._pictures += 1
                self._draw(now_s, with_trail=self._pictures % _PICTURES_A_TRAIL == 0)
                if now_s >= self._end_s:
                    self._anchor_s, self._is_playing = self._end_s, False
                await asyncio.sleep(max(PICTURE_S - (time.monotonic() - started), 0.001))

    def _draw(self, time_s: float, with_trail: bool) -> None:
        tick = int(np.searchsorted(self._track.time_s, time_s, side="right")) - 1
        tick = min(max(tick, 0), len(self._track) - 1)
        trail = None
        if with_trail:
            first = int(np.searchsorted(self._track.time_s, time_s - TRAIL_S))
            trail = self._track.hand_m[first : tick + 1 : self._stride]
        self._scene.draw(self._track, tick, trail)
        if self._ghost_clock is not None:
            # Who still stands before a seated exercise has nothing to compare yet.
            is_at_it = self._scene.posture == self._scene.exercise_posture
            phase = self._ghost_clock.phase(time_s, self._warp) if is_at_it else None
            self._scene.draw_ghost(phase, with_path=is_at_it)


class LivePlayer:
    """Shows the newest frames of a live session, spread evenly over the time until the next ones come.

    Parameters
    ----------
    ghost_duration_s : float or None
        Of the template, which is shown over and over as the example to follow; not while the patient holds the
        calibration pose, where it would be the wrong example.
    is_calibrating : bool
        Whether the session waits for the pose now; later changes come over the bus.
    """

    def __init__(
        self,
        scene: BodyScene,
        bus: Bus,
        session_id: str,
        body: BodyDimensions,
        ghost_duration_s: float | None,
        is_calibrating: bool = False,
    ) -> None:
        self._scene = scene
        self._bus = bus
        self._session_id = session_id
        self._body = body
        self._ghost_clock = GhostClock(ghost_duration_s) if ghost_duration_s is not None else None
        self._is_calibrating = is_calibrating
        self._trail: deque[np.ndarray] = deque(maxlen=int(TRAIL_S * LIVE_TRAIL_RATE_HZ))
        self._last: PoseTrack | None = None
        self._course = LiveCourse()
        self._is_posed = False
        self._chunks = 0
        self._guided: GuidanceMessage | None = None
        self._shown_phase = 0.0
        self._silence = SilenceWatch()

    def command(self, command: PlayerCommand) -> None:
        """Live views have nothing to steer; the ghost is switched by the view itself."""

    def state(self) -> PlayerState:
        """Return what the page may want to know."""
        return PlayerState(
            mode="live",
            time_s=None,
            start_s=None,
            end_s=None,
            playing=True,
            speed=1.0,
            has_ghost=self._ghost_clock is not None,
            has_warp=False,
        )

    async def run(self) -> None:
        """Draw until cancelled."""
        words = [topic(self._session_id, name) for name in ("state", "guidance", "health")]
        # States have a queue of their own: on a busy machine frames would push the few of them out.
        with (
            self._bus.subscribe(topic(self._session_id, "frames"), size=8) as subscription,
            self._bus.subscribe(*words) as states,
        ):
            while True:
                items = []
                with contextlib.suppress(TimeoutError):
                    items = await asyncio.wait_for(subscription.wait(), SILENCE_S)
                for _, message in states.take():
                    self._silence.hear(message)
                    if isinstance(message, StateMessage):
                        self._follow(message)
                    elif isinstance(message, GuidanceMessage):
                        self._guided = message
                if items:
                    self._silence.frames_came()
                    await self._show(items[-1][1].frames, subscription)
                else:
                    self._show_silence()

    async def _show(self, frames: Frames, following: Subscription) -> None:
        if not frames.tick_count:
            return
        self._scene.show_measured(measured_segments(frames))
        self._is_posed = bool(is_posed(frames)[-1])
        # The pose that calibrates is held standing.
        posture = self._scene.exercise_posture if self._is_posed and not self._is_calibrating else "standing"
        track = track_from_frames(frames, self._body, posture)
        if track.stands is None:
            self._scene.sit(posture == "seated")
        if track.feet is not None:
            track = replace(track, feet=self._course.turned(track.feet))
        self._last = track
        step = max(1, round(PICTURE_S / frames.time_step_s))
        # The last tick is always among those shown; a little less than real time, so that no delay piles up.
        ticks = range((len(track) - 1) % step, len(track), step)
        pause_s = 0.9 * step * frames.time_step_s
        for tick in ticks[:-1]:
            if following.has_more:
                # What fills a gap is as long as the gap was: it is not played while newer frames wait.
                break
            started = time.monotonic()
            self._draw(track, tick, is_last=False)
            await asyncio.sleep(max(pause_s - (time.monotonic() - started), 0.0))
        self._draw(track, ticks[-1], is_last=True)

    def _draw(self, track: PoseTrack, tick: int, is_last: bool) -> None:
        trail = None
        if is_last:
            self._trail.append(track.hand_m[tick])
            self._chunks += 1
            trail = np.stack(self._trail) if self._chunks % 2 == 0 else None
        self._scene.draw(track, tick, trail)
        if self._ghost_clock is not None:
            is_at_it = self._scene.posture == self._scene.exercise_posture
            is_example = self._is_posed and not self._is_calibrating and is_at_it
            time_s = float(track.time_s[tick])
            phase = self._ghost_phase(self._ghost_clock, time_s) if is_example else None
            self._scene.draw_ghost(phase, with_path=is_example)

    def _ghost_phase(self, clock: GhostClock, time_s: float) -> float:
        """Return where the example stands, 0 to 100: with the patient while it is followed, else by its own clock."""
        wanted = None if self._guided is None else self._guided.ghost_phase
        if wanted is None:
            self._shown_phase = clock.phase(time_s, warp=False)
        else:
            ahead = 100.0 * wanted - self._shown_phase
            # A new repetition begins at the start again; everything else is a way to go, not a jump.
            self._shown_phase += ahead if ahead < -_NEW_REPETITION else _FOLLOWS * ahead
        return self._shown_phase

    def _show_silence(self) -> None:
        # Modules, feet and single sensors say themselves that they go on without news; there is no figure to grey.
        if self._last is None:
            return
        others = self._last.modules, self._last.feet, self._last.sensors
        if any(one is not None for one in others):
            return
        lost = np.ones_like(self._last.lost[-1:])
        silent = PoseTrack(
            time_s=self._last.time_s[-1:],
            wxyz=self._last.wxyz[-1:],
            shoulder_m=self._last.shoulder_m[-1:],
            hand_m=self._last.hand_m[-1:],
            halo_m=np.zeros_like(self._last.halo_m[-1:]),
            lost=lost & self._scene.measured_mask,
        )
        self._scene.draw(silent, 0, silence=self._silence.words)

    def _follow(self, message: StateMessage) -> None:
        self._is_calibrating = message.state == "calibrating"
        if self._ghost_clock is not None and message.recording_start_s is not None:
            self._ghost_clock = GhostClock(self._ghost_clock.duration_s, begin_s=message.recording_start_s)


Player = ReplayPlayer | LivePlayer
