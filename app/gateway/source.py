"""The source's side of the actuation messages: one pulse at a time, as asked; a fixed plan when nobody is heard.

This is the reference for makers of sources: the rules are in `docs/packet.md`. It knows nothing of coils and
amplifiers; it says for each tick which coil is to be on, with which current.
"""

from dataclasses import dataclass
from typing import Final

from app.errors import SafetyUnconfirmed
from app.network.messages import AcknowledgeMessage, ActuateMessage, ActuationPlanMessage, ErrorMessage

ENDED: Final = ("closing", "analysed", "failed")
"""States of a session in which no coil may be on."""
PLAN_LASTS_S: Final = 600.0
"""So long after the last word of the service a source goes on by itself; nobody may be there any more."""
LONGEST_PULSE_S: Final = 0.5


@dataclass(frozen=True)
class FixedBursts:
    """What a source that is never asked fires: one coil of the plan after the other, and then nothing until the next.

    The defaults are the three-coil tracker's (Roetenberg 2006, chapter 5).
    """

    pulse_s: float = 0.06
    slot_s: float = 0.0625
    cycle_s: float = 0.6
    current_a: float = 1.5


@dataclass
class SourceAccount:
    """What a source did: pulses asked for, of the plan, by itself, and what was not done."""

    asked: int = 0
    by_plan: int = 0
    by_itself: int = 0
    too_late: int = 0
    while_on: int = 0
    no_such_coil: int = 0


class SourceControl:
    """Decides for each tick what the coils do.

    Parameters
    ----------
    tick_us : float
        Tick interval.
    bursts : FixedBursts, optional
        Of a source that fires by itself for as long as it has a plan, and is deaf to what is asked.
    """

    def __init__(self, tick_us: float, bursts: FixedBursts | None = None) -> None:
        self._tick_us = tick_us
        self._bursts = bursts
        self._first_us: float | None = None
        self._plan: ActuationPlanMessage | None = None
        self._next: ActuateMessage | None = None
        self._last_number = 0
        self._was_heard = False
        self._heard_us: float | None = None
        self._coil, self._current_a, self._left = 0, 0.0, 0
        self._round_us: float | None = None
        self._to_fire: list[int] = []
        self._silent_until_us = 0.0
        self.account = SourceAccount()

    def hear(self, message: object) -> None:
        """Take any message of the service: that something came counts too."""
        self._was_heard = True
        is_refused = isinstance(message, ErrorMessage) and message.code == SafetyUnconfirmed.code
        if is_refused or (isinstance(message, AcknowledgeMessage) and message.state in ENDED):
            self._plan = self._next = None
            self._left = 0
        elif isinstance(message, ActuationPlanMessage):
            # Numbers begin again with a service that was restarted.
            self._plan, self._last_number = message, 0
            if not message.coils:
                # The safety confirmation was revoked: nothing goes on, not even the pulse that is on.
                self._next, self._left = None, 0
        elif isinstance(message, ActuateMessage) and message.number > self._last_number:
            self._last_number = message.number
            if self._left > 0:
                self.account.while_on += 1
            else:
                self._next = message

    def tick(self, now_us: float) -> tuple[int, float]:
        """Return coil (from 1, 0 for none) and current at this tick of the device's clock.

        Nothing is fired before a plan came: the service gives one only to sessions that are confirmed to be safe. The
        end of the session takes it back; without a word of the service it lasts `PLAN_LASTS_S`.
        """
        if self._was_heard:
            self._was_heard, self._heard_us = False, now_us
            self._round_us, self._to_fire = None, []
        plan = self._plan
        if plan is None:
            return 0, 0.0
        if self._bursts is not None:
            return self._by_itself(self._bursts, plan, now_us)
        if self._left == 0:
            self._begin(plan, now_us)
        if self._left == 0:
            return 0, 0.0
        self._left -= 1
        if self._left == 0:
            self._silent_until_us = now_us + (1 + plan.off_ticks) * self._tick_us
        return self._coil, self._current_a

    def _begin(self, plan: ActuationPlanMessage, now_us: float) -> None:
        wanted, self._next = self._next, None
        if wanted is not None:
            if now_us > wanted.not_after_us:
                self.account.too_late += 1
            elif now_us < wanted.not_before_us - 0.5 * self._tick_us:
                self._next = wanted
            elif wanted.coil not in plan.coils:
                self.account.no_such_coil += 1
            else:
                self._coil, self._left = wanted.coil, self._ticks_on(wanted.on_ticks)
                self._current_a = _within(wanted.current_a, plan.current_limit_a)
                self.account.asked += 1
            return
        silent_us = None if self._heard_us is None else now_us - self._heard_us
        if silent_us is None or not 1e6 * plan.after_s <= silent_us < 1e6 * PLAN_LASTS_S:
            return
        if self._round_us is None or now_us - self._round_us >= (plan.cycle_ticks - 0.5) * self._tick_us:
            self._round_us, self._to_fire = now_us, list(plan.coils)
        if self._to_fire and now_us >= self._silent_until_us - 0.5 * self._tick_us:
            self._coil, self._current_a = self._to_fire.pop(0), _within(plan.current_a, plan.current_limit_a)
            self._left = self._ticks_on(plan.on_ticks)
            self.account.by_plan += 1

    def _by_itself(self, bursts: FixedBursts, plan: ActuationPlanMessage, now_us: float) -> tuple[int, float]:
        """Return what is on in the cycle that began with the plan."""
        self._first_us = now_us if self._first_us is None else self._first_us
        if self._heard_us is not None and now_us - self._heard_us >= 1e6 * PLAN_LASTS_S:
            return 0, 0.0
        within_s = 1e-6 * (now_us - self._first_us + 1e-3) % bursts.cycle_s
        slot = int(within_s / bursts.slot_s)
        if slot >= len(plan.coils) or within_s - slot * bursts.slot_s >= bursts.pulse_s:
            self._coil = 0
            return 0, 0.0
        if self._coil != plan.coils[slot]:
            self._coil = plan.coils[slot]
            self.account.by_itself += 1
        return self._coil, _within(bursts.current_a, plan.current_limit_a)

    def _ticks_on(self, wanted: int) -> int:
        return min(wanted, max(1, int(1e6 * LONGEST_PULSE_S / self._tick_us)))


def _within(current_a: float, limit_a: float) -> float:
    return min(max(current_a, -limit_a), limit_a)
