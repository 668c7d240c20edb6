"""Rules and a template turned into what the compiled cues and stops read."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from estimators.comparison import PHASES
from estimators.errors import SetupError
from estimators.guidance._contract import GuidanceTemplate
from estimators.guidance._cue_records import (
    CUE_SETTINGS,
    CUE_STATE,
    RULE,
    RULE_STATE,
    STOP,
    STOP_STATE,
    Orders,
    Said,
)
from estimators.guidance._rules import QUANTITIES, STOP_KINDS, CueRule, StopRule
from estimators.guidance._template import WHOLE_PACE
from estimators.kernels import filled

_MOVES: Final = 0.02
"""Share of the template's mean squared speed from which on somebody moves."""
UNKNOWN_RAD: Final = float(np.radians(1.5))
UNKNOWN_M: Final = 0.006
"""Taken where a channel states no sigma: leans of the trunk, hikes and places."""
Z: Final = 1.28
"""Of (10); not the therapist's to change: nine in ten of what is said is then so."""


@dataclass(frozen=True)
class CuePace:
    """How often something is said.

    Attributes
    ----------
    silence_s : float
        After anything said.
    praise_every : int
        Of silent valid repetitions each so-manieth is praised (bandwidth feedback); 0 never.
    cue_every : int
        Cues only in each so-manieth repetition, the first among them (faded feedback).
    """

    silence_s: float = 1.5
    praise_every: int = 3
    cue_every: int = 1

    def __post_init__(self) -> None:
        if not (0.0 <= self.silence_s <= 60.0 and self.praise_every >= 0 and self.cue_every >= 1):
            raise SetupError(f"{self}: silence is 0 to 60 s, praise_every 0 or more, cue_every 1 or more")


def make_orders(
    ready: GuidanceTemplate, tick_s: float, rules: Sequence[CueRule], stops: Sequence[StopRule], pace: CuePace
) -> Orders:
    """Return the records of rules and stops; raises `SetupError` for a channel that the template has not."""
    model, origin = ready.model, np.where(ready.model.absolute == 1, 0.0, ready.mean[0])
    middle = np.rint((np.arange(len(model.whole)) + 0.5) / len(model.whole) * (PHASES - 1)).astype(int)
    speed = (model.weight[:, None] * model.slope[WHOLE_PACE] ** 2 / model.variance[:, :1]).sum(axis=0)
    speed /= model.weight.sum() * ready.duration_s**2
    moving_speed = _MOVES * float(speed.mean())
    settings = filled(
        CUE_SETTINGS,
        {
            "z": Z,
            "silence_ticks": round(pace.silence_s / tick_s),
            "praise_every": pace.praise_every,
            "cue_every": pace.cue_every,
            "template_moves_s": ready.duration_s * float((speed > moving_speed).mean()),
            "moving_speed": moving_speed,
        },
    )
    return Orders(
        rules=_rows(RULE, [_rule(one, ready) for one in rules]),
        stops=_rows(STOP, [_stop(one, ready) for one in stops]),
        settings=settings,
        below=np.ascontiguousarray(ready.below[middle]),
        above=np.ascontiguousarray(ready.above[middle]),
        origin=origin,
        unknown_sigma=np.where(model.turns == 1, UNKNOWN_RAD, UNKNOWN_M),
    )


def make_said(orders: Orders) -> Said:
    """Return what is remembered before the first tick."""
    state = np.zeros(1, dtype=CUE_STATE)
    state["last_tick"] = state["left_tick"] = -1
    return Said(
        rules=np.zeros(len(orders.rules), dtype=RULE_STATE),
        stops=np.zeros(len(orders.stops), dtype=STOP_STATE),
        state=state,
    )


def _rows(kind: np.dtype[Any], values: list[dict[str, float]]) -> NDArray[Any]:
    return np.concatenate([np.zeros(0, dtype=kind), *(filled(kind, one) for one in values)])


def _column(channel: str, ready: GuidanceTemplate) -> int:
    if channel not in ready.channels:
        raise SetupError(f"a rule looks at {channel!r}; the template has {ready.channels}")
    return ready.channels.index(channel)


def _rule(one: CueRule, ready: GuidanceTemplate) -> dict[str, float]:
    looks = one.quantity in ("deviation", "at_equal")
    return {
        "quantity": QUANTITIES.index(one.quantity),
        "channel": _column(one.channel, ready) if looks else -1,
        "against": _column(one.against, ready) if one.quantity == "at_equal" else -1,
        "least": one.least,
        "side": one.side_sign,
        "first": one.phases[0],
        "last": one.phases[1],
        "tolerance": np.nan if one.tolerance is None else one.tolerance,
        "hold_s": one.hold_s,
        "priority": one.priority,
        "is_on": one.is_on,
    }


def _stop(one: StopRule, ready: GuidanceTemplate) -> dict[str, float]:
    return {
        "kind": STOP_KINDS.index(one.kind),
        "channel": _column(one.channel, ready) if one.kind == "limit" else -1,
        "side": 1 if one.side == "above" else -1,
        "limit": one.limit,
        "hold_s": one.hold_s,
    }
