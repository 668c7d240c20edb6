"""Requests of a live session to its magnetic source, and its reports of trouble with it.

The pipeline says at which tick which coil is worth its energy; here that becomes a message to the network, in the time
of its own clock, and a change for the worse or better becomes an entry of the time line.
"""

import asyncio
from collections.abc import Callable
from functools import reduce
from operator import or_
from typing import Final

from app.network.declaration import Declaration
from app.network.messages import ActuateMessage, ActuationPlanMessage
from estimators.magnetic import RelativeFlag
from estimators.pipelines import Frames, Pipeline, RelativePosePipeline
from estimators.sentences import CATALOGUE, say

Order = ActuateMessage | ActuationPlanMessage
Tell = Callable[[str, float, str, str], None]
"""Kind, session time, placement and words of an event."""

VALID_S: Final = 0.4
"""A pulse that has not begun by then is asked for again by the filter."""
SILENCE_S: Final = 1.0
CYCLE_S: Final = 3.0
_SOUND_AFTER_S: Final = 1.0
_WAITING: Final = 8

_TROUBLE: Final = {
    RelativeFlag.MISSING_PULSE: say("source_trouble.missing"),
    RelativeFlag.FAULT: say("source_trouble.fault"),
    RelativeFlag.DISTURBED: say("source_trouble.disturbed"),
    RelativeFlag.SATURATED: say("source_trouble.saturated"),
    RelativeFlag.INERTIAL_ONLY: say("source_trouble.alone"),
}
_WIRING: Final = say("source_trouble.wiring")
_ANY: Final = int(sum(_TROUBLE))
_STARTING: Final = int(RelativeFlag.CALIBRATING)
_FAULT, _MISSING, _ALONE = (
    int(flag) for flag in (RelativeFlag.FAULT, RelativeFlag.MISSING_PULSE, RelativeFlag.INERTIAL_ONLY)
)


class Actuation:
    """The orders to the network of one live session.

    Parameters
    ----------
    tell : callable
        Takes events of the time line.
    """

    def __init__(self, pipeline: RelativePosePipeline, tell: Tell) -> None:
        self._pipeline, self._tell = pipeline, tell
        self._orders: asyncio.Queue[Order] | None = None
        self._number = 0
        self._is_allowed = True
        names, columns = pipeline.layout.scalars, pipeline.layout.segments[1:]
        self._asked = [names.index(f"source_ask_{name}") for name in ("coil", "current_a", "ticks")]
        self._states = {name: names.index(f"{name}_state") for name in columns}
        self._trouble = dict.fromkeys(columns, 0)
        self._sound_since: dict[str, float] = {}

    @classmethod
    def of(cls, pipeline: Pipeline, tell: Tell) -> "Actuation | None":
        """Return the orders of a session, None when it has no source."""
        return cls(pipeline, tell) if isinstance(pipeline, RelativePosePipeline) else None

    def connect(self) -> asyncio.Queue[Order]:
        """Return the orders of a new connection, the plan for a lost link first; they take the place of the last."""
        self._orders = asyncio.Queue(_WAITING)
        self._orders.put_nowait(self.plan())
        return self._orders

    def allow(self, is_allowed: bool) -> bool:
        """Let the source fire or stop it at once; return whether that is news."""
        if is_allowed == self._is_allowed:
            return False
        self._is_allowed = is_allowed
        if self._orders is not None:
            while not self._orders.empty():
                self._orders.get_nowait()
            # Without coils it fires nothing, nor when the link is lost.
            self._orders.put_nowait(self.plan())
        return True

    @property
    def is_allowed(self) -> bool:
        """Whether the source may fire."""
        return self._is_allowed

    def plan(self) -> ActuationPlanMessage:
        """Return what the source is to do while nothing is heard from here; no coils while it may not fire."""
        one = next(iter(self._pipeline.filters.values())).parameters
        rate_hz = self._pipeline.setup.rate_hz
        limit = self._pipeline.source.current_limit_a
        return ActuationPlanMessage(
            coils=[1, 2, 3] if self._is_allowed else [],
            current_a=min(float(one["current_a"]), limit),
            # Long enough to start from, should the service have been restarted meanwhile.
            on_ticks=max(1, round(float(one["start_pulse_s"]) * rate_hz)),
            off_ticks=int(one["start_baseline_samples"]) + 2,
            cycle_ticks=round(CYCLE_S * rate_hz),
            after_s=SILENCE_S,
            current_limit_a=limit,
        )

    def take(self, frames: Frames, declaration: Declaration, *, is_live: bool) -> None:
        """Take frames as they are found: order what they ask for when they are of now, and tell trouble."""
        coils = frames.scalar[:, self._asked[0]].tolist()
        asked = [k for k, coil in enumerate(coils) if coil > 0.0]
        if (
            self._is_allowed
            and is_live
            and len(asked)
            and self._orders is not None
            and not self._orders.full()
        ):
            coil, current, ticks = frames.scalar[asked[-1], self._asked]
            # The tick after the one that asked.
            time_us = round(1e6 * frames.time_step_s * (frames.first_tick + asked[-1] + 1))
            epoch = declaration.clock_epochs[-1]
            device_us = max(0, epoch.device_start_us + time_us - epoch.session_start_us)
            self._number += 1
            self._orders.put_nowait(
                ActuateMessage(
                    number=self._number,
                    coil=int(coil),
                    current_a=round(float(current), 4),
                    on_ticks=int(ticks),
                    not_before_us=device_us,
                    not_after_us=device_us + round(1e6 * VALID_S),
                )
            )
        self._watch(frames)

    def _watch(self, frames: Frames) -> None:
        if not frames.tick_count:
            return
        now_s = (frames.first_tick + frames.tick_count) * frames.time_step_s
        for name, column in self._states.items():
            states = {int(bits) for bits in frames.scalar[:, column].tolist()}
            seen = reduce(or_, states)
            if seen & _FAULT and self._is_wired_wrong(states) and not self._trouble[name] & _FAULT:
                self._tell("source_trouble", now_s, name, _WIRING)
                self._trouble[name] |= RelativeFlag.FAULT
                self._sound_since.pop(name, None)
            if seen & _STARTING:
                continue
            present = seen & _ANY
            if not self._is_allowed:
                # That no pulse comes is as it should be.
                present &= ~int(RelativeFlag.MISSING_PULSE)
            if present & _MISSING:
                # What a filter says of pulses that fit nothing is no news of a source that is off.
                present &= ~_FAULT
            if not present:
                since = self._sound_since.setdefault(name, now_s)
                if self._trouble[name] and now_s - since >= _SOUND_AFTER_S:
                    self._trouble[name] = 0
                    self._tell("source_sound", now_s, name, say("source_trouble.over"))
                continue
            self._sound_since.pop(name, None)
            # One missing pulse is asked for again; several put the source aside, which is a flag of its own.
            new = present & ~self._trouble[name]
            if new and present != _MISSING:
                words = [text for flag, text in _TROUBLE.items() if present & flag]
                self._tell("source_trouble", now_s, name, CATALOGUE.together(words))
                self._trouble[name] |= present

    @staticmethod
    def _is_wired_wrong(states: set[int]) -> bool:
        """Whether coils fire that the source does not have.

        The filter says FAULT only while it waits after a burst that fits nothing; at any other time it is the
        pipeline's word about the coil states.
        """
        return any(bits & _FAULT and (not bits & _ALONE or bits & _STARTING) for bits in states)
