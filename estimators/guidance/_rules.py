"""Cue rules and stop rules as data, and what they give when they hold."""

from dataclasses import dataclass
from typing import Final, Literal, get_args

import numpy as np

from estimators.errors import SetupError

Quantity = Literal["deviation", "at_equal", "range", "fast", "slow"]
QUANTITIES: Final = get_args(Quantity)
CueSide = Literal["below", "both", "above"]
_SIDES: Final = {"below": -1, "both": 0, "above": 1}
StopKind = Literal[
    "limit", "valid_count", "attempt_count", "time", "lost", "unsure", "wrong_in_a_row", "pain"
]
STOP_KINDS: Final = get_args(StopKind)
STOPS: Final = ("limit", "valid_count", "attempt_count", "time", "pain")
"""Kinds that end the exercise until somebody resumes by hand; the others pause it."""


@dataclass(frozen=True)
class CueRule:
    """One rule of the cue grammar; all of it is the therapist's to edit.

    Attributes
    ----------
    quantity : {"deviation", "at_equal", "range", "fast", "slow"}
        `deviation`: d of (10). `at_equal`: the same against the template where the channel `against` has the same
        value, from `least` on. `range`: q_k of (9), after the turn. `fast`: time from 10 % to 75 % of the first target
        over the template's, below 1 / tolerance. `slow`: moving time over the template's, at the end.
    sentence : str
        Code of what is said.
    channel, against : str
        Of `deviation` and `at_equal`.
    least : float
        rad or m, of `against`.
    phases : tuple of float
        First and last phase, 0 to 1, at which the rule looks; of `range` those of the targets.
    tolerance : float, or None
        rad, m or a ratio; None is the therapist's band (`deviation` only).
    hold_s : float
        How long it must be so without a break.
    priority : int
        1 is the most urgent.
    """

    quantity: Quantity
    sentence: str
    channel: str = ""
    against: str = ""
    least: float = 0.0
    side: CueSide = "both"
    phases: tuple[float, float] = (0.0, 1.0)
    tolerance: float | None = None
    hold_s: float = 0.25
    priority: int = 1
    is_on: bool = True

    def __post_init__(self) -> None:
        if self.quantity not in QUANTITIES or self.side not in _SIDES:
            raise SetupError(f"{self}: quantity is one of {QUANTITIES}, side one of {tuple(_SIDES)}")
        if not (0.0 <= self.phases[0] <= self.phases[1] <= 1.0 and 0.0 <= self.hold_s <= 10.0):
            raise SetupError(f"{self}: phases go from 0 to 1, the hold lasts at most 10 s")
        if self.tolerance is None and self.quantity != "deviation":
            raise SetupError(f"{self}: only a deviation has the therapist's band for its tolerance")
        if self.tolerance is not None and not self.tolerance > 0.0:
            raise SetupError(f"{self}: the tolerance must be positive")

    @property
    def side_sign(self) -> int:
        """-1, 0 or 1."""
        return _SIDES[self.side]


@dataclass(frozen=True)
class StopRule:
    """What stops or pauses an exercise, looked at on every tick before any cue.

    Attributes
    ----------
    kind : str
        `limit`: a channel plus two sigma beyond `limit`, on the side named. `valid_count`, `attempt_count`,
        `wrong_in_a_row`: so many repetitions. `time`: s since the prompted rest. `lost`: no channel that tells the
        phase. `unsure`: the sigma of one beyond `limit`, rad.
    limit : float
        rad, m, a number or s; of `lost` not used.
    channel : str
        Of `limit`.
    hold_s : float
        How long before it stops.
    """

    kind: StopKind
    limit: float = 0.0
    channel: str = ""
    side: Literal["below", "above"] = "above"
    hold_s: float = 0.0

    def __post_init__(self) -> None:
        if self.kind not in STOP_KINDS or self.kind == "pain":
            raise SetupError(f"{self}: kind is one of {STOP_KINDS[:-1]}; pain has its own button")
        if (
            self.side not in ("below", "above")
            or not 0.0 <= self.hold_s <= 60.0
            or not np.isfinite(self.limit)
        ):
            raise SetupError(f"{self}: side is below or above, the hold at most 60 s, the limit a number")
        if self.kind not in ("limit", "lost") and not self.limit > 0.0:
            raise SetupError(f"{self}: the limit must be positive")


@dataclass(frozen=True)
class Cue:
    """One thing said.

    Attributes
    ----------
    sentence : str
        Code.
    rule : CueRule, or None
        None is praise.
    attempt : int
        Number of the attempt, from 1.
    phase : float
        0 to 1.
    value, limit : float
        What was measured, and the tolerance it left; NaN of praise.
    """

    tick: int
    sentence: str
    rule: CueRule | None
    attempt: int
    phase: float
    value: float
    limit: float


@dataclass(frozen=True)
class Stopped:
    """The exercise was stopped or paused; nothing is counted or said until `Guide.resume`.

    Attributes
    ----------
    kind : str
        Of `StopRule`, or `pain`.
    rule : StopRule, or None
        None is the pain button.
    value, limit : float
        In the units of the rule; NaN of pain.
    """

    tick: int
    kind: StopKind
    rule: StopRule | None
    value: float
    limit: float

    @property
    def is_pause(self) -> bool:
        """Whether the exercise goes on once its cause is over; otherwise it has ended."""
        return self.kind not in STOPS
