"""Whole turns of a sensor about its axes: which can be believed to have been whole."""

from collections.abc import Sequence
from dataclasses import dataclass

from estimators.errors import CalibrationError
from estimators.sentences import Sentence, say

AXES = "xyz"
_TURN_BELIEVED = 0.015
_TURN_REFUSED = 0.05
_TURNS_AGREE = 0.01
"""Of a turn against a whole one. Data sheets leave gyroscopes a few percent of scale; a hand that stops 5 degrees
early makes 1.4. What two turns agree about is the device."""


@dataclass(frozen=True)
class FullTurn:
    """One stretch `[start, stop)` of samples with whole turns about `axis`; `turns` is signed.

    `error` is what the gyroscope read too much, as a share: by its scale, or by a turn that was not whole.
    """

    start: int
    stop: int
    axis: str
    turns: int
    error: float = 0.0


def doubted_turns(turns: Sequence[FullTurn]) -> dict[str, float]:
    """Return the axes whose turns were hardly whole ones, with what the gyroscope read too much, as a share.

    More than 5 percent is a wrong turn rather than a wrong scale, unless two turns of that axis agree within
    1 percent.
    """
    doubted = {}
    for axis in sorted({turn.axis for turn in turns}):
        errors = [turn.error for turn in best_turns(turns) if turn.axis == axis]
        if not _agree(errors) and abs(errors[0]) > _TURN_REFUSED:
            doubted[axis] = errors[0]
    return doubted


def best_turns(turns: Sequence[FullTurn]) -> list[FullTurn]:
    """Leave out, of each axis, what was repeated because it was not whole."""
    retained: list[FullTurn] = []
    for axis in AXES:
        own = sorted((t for t in turns if t.axis == axis), key=lambda turn: abs(turn.error))
        whole = [t for t in own if abs(t.error) <= _TURN_REFUSED]
        agreed = [t for t in own if sum(abs(t.error - o.error) < _TURNS_AGREE for o in own) > 1]
        retained += whole or agreed or own[:1]
    return sorted(retained, key=lambda turn: turn.start)


def _agree(errors: Sequence[float]) -> bool:
    return len(errors) > 1 and max(errors) - min(errors) < _TURNS_AGREE


def refuse_doubted(turns: Sequence[FullTurn]) -> None:
    """Refuse turns that were hardly whole ones, by name."""
    doubted = doubted_turns(turns)
    if doubted:
        stated = [
            say("six_position.turn_over", axis=axis, error=error)
            if error > 0.0
            else say("six_position.turn_under", axis=axis, error=-error)
            for axis, error in doubted.items()
        ]
        raise CalibrationError(
            say("six_position.turn_again", turns=stated), redo=[f"turn_{axis}" for axis in doubted]
        )


def judge_turns(turns: Sequence[FullTurn]) -> tuple[float, list[Sentence]]:
    """Return a factor of the score and why: turns that may not have been quite whole."""
    factor, reasons = 1.0, []
    for axis in AXES:
        errors = [turn.error for turn in turns if turn.axis == axis]
        error = max(errors, key=abs)
        if abs(error) > _TURN_BELIEVED and not _agree(errors):
            factor = min(factor, _TURN_BELIEVED / abs(error))
            reasons.append(
                say("six_position.turn_doubt_over", axis=axis, error=error)
                if error > 0.0
                else say("six_position.turn_doubt_under", axis=axis, error=-error)
            )
    return factor, reasons
