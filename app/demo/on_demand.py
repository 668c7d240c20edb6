"""The demonstration's patient performs a calibration when somebody starts one in the browser.

What the device is about to send is exchanged for the movement of the present step, again and again until the person
in the browser goes on to the next step; afterwards the patient goes on with the exercise.
"""

import asyncio
from dataclasses import dataclass, replace
from typing import Final, Protocol

import numpy as np
from numpy.typing import NDArray

from app.errors import TelemotionError
from app.gateway.encoding import DeviceStream, stream_of
from app.gateway.rehearsal import POSE_S, rehearsal_of
from app.live.calibration.messages import CalibrationKind, CalibrationMessage
from app.live.messages import StateMessage
from estimators.simulation import ArmScenario, HandlingName, Schedule, calibration_ranges_s, simulate_handling

POLL_S: Final = 0.3
AHEAD_S: Final = 1.5
"""So much is exchanged ahead of what the server has seen: more than a poll and the way there."""


class Watched(Protocol):
    """What is asked of the service."""

    async def state(self, session_id: str) -> StateMessage:
        """Return the state of the session."""

    async def calibration_state(self, session_id: str) -> CalibrationMessage | None:
        """Return the newest message of a guided calibration."""


@dataclass(frozen=True)
class Script:
    """Counts of a performance and which ticks belong to each step, to be repeated while the step lasts."""

    counts: NDArray[np.int16]
    loops: tuple[tuple[int, int], ...]


def script_of(kind: CalibrationKind, scenario: ArmScenario) -> Script:
    """Return what the simulated patient does for one kind of calibration.

    Parameters
    ----------
    scenario : ArmScenario
        Person, sensors, errors and mounting.
    """
    shown = rehearsal_of(kind, scenario)
    recording = shown.recording
    if set(recording.sensors) != set(scenario.placements):
        # In the hand only two are shown elsewhere; here all are handled together, as in a box.
        done: HandlingName = "six_position" if kind == "six_position" else "turn_all_ways"
        recording = simulate_handling(done, scenario.placements, rate_hz=scenario.rate_hz, seed=scenario.seed)
    counts = stream_of(recording).counts
    rate_hz = scenario.rate_hz
    if kind in ("functional", "passive"):
        schedule = Schedule(n_pose_s=POSE_S, repetitions=1)
        schedule = replace(schedule, settle_s=6.0) if kind == "passive" else schedule
        ranges = calibration_ranges_s(schedule, passive=kind == "passive")
        names = ("rest", "elbow_flexion", "pronation", "raise_forward", "raise_sideways")
        return Script(
            counts, tuple((round(ranges[n][0] * rate_hz), round(ranges[n][1] * rate_hz)) for n in names)
        )
    if kind == "t_pose":
        start = round(shown.start_s * rate_hz)
        return Script(counts, ((start, start + round(6.0 * rate_hz)),))
    if kind in ("n_pose", "heading_reset"):
        return Script(counts, ((round(rate_hz), round((POSE_S - 0.5) * rate_hz)),))
    return Script(counts, ((0, counts.shape[0]),))


class OnDemand:
    """Watches one streamed session and exchanges what is sent next.

    Parameters
    ----------
    device : DeviceStream
        Its counts are written to, ahead of what was sent.
    """

    def __init__(self, device: DeviceStream, scenario: ArmScenario) -> None:
        self._device, self._scenario = device, scenario
        self._script: Script | None = None
        self._kind: CalibrationKind | None = None
        self._place = 0
        self._written = 0

    async def run(self, service: Watched, session_id: str, from_s: float) -> None:
        """Watch until cancelled; calibrations before the session time `from_s` are the stream's own."""
        while True:
            try:
                message = await service.calibration_state(session_id)
                state = await service.state(session_id)
            except TelemotionError:
                # Not connected yet, or closed: whoever streams notices.
                message = None
            else:
                if state.session_time_s > from_s:
                    await self.follow(message, state.session_time_s)
            await asyncio.sleep(POLL_S)

    async def follow(self, message: CalibrationMessage | None, now_s: float) -> None:
        """Exchange what is sent next for what the message asks."""
        if message is None or message.phase != "collecting":
            self._script = self._kind = None
            return
        if self._script is None or message.kind != self._kind:
            self._script = await asyncio.to_thread(script_of, message.kind, self._scenario)
            self._kind, self._place = message.kind, self._script.loops[0][0]
            self._written = 0
        rate_hz = self._device.rate_hz
        begin = max(self._written, round((now_s + 0.5) * rate_hz))
        end = min(round((now_s + AHEAD_S) * rate_hz), self._device.counts.shape[0])
        loop = self._script.loops[min(message.step, len(self._script.loops) - 1)]
        for tick in range(begin, end):
            if self._place >= loop[1]:
                # The next step's movement comes after this one's: what lies between is played once.
                self._place = loop[0]
            self._device.counts[tick] = self._script.counts[self._place]
            self._place += 1
        self._written = max(begin, end)
