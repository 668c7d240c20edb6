"""A session's dose and its portions: a prescription's goal and a template's sets."""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Literal

from estimators.guidance import StopRule

Reached = Literal["", "valid_count", "set", "attempt_count"]


@dataclass(frozen=True)
class Dose:
    """Numbers of repetitions at which an exercise is held up.

    The prescription says what must be done today; the rules of a template say how much of it at a time. Only the
    first is the end of the exercise.

    Attributes
    ----------
    goal : int
        Valid repetitions that are prescribed for one time: of all sets.
    set_valid : int
        Valid repetitions of a set.
    set_attempts : int or None
        Attempts of a set, valid or not; None: as many as it takes.
    before : int
        Valid repetitions of this goal that earlier sessions of the same day have brought.
    """

    goal: int
    set_valid: int
    set_attempts: int | None = None
    before: int = 0

    @property
    def is_done_before(self) -> bool:
        """Whether all of the day was done before this session began: what comes is of the patient's own accord."""
        return self.before >= self.goal

    def times_done(self, done_today: int) -> int:
        """Return how often the goal is reached with so many valid repetitions of one day."""
        return done_today // self.goal

    def after(self, done_today: int, times: int) -> "Dose":
        """Return the dose of a session that begins after valid repetitions of the same day.

        Parameters
        ----------
        times : int
            How often a day the dose is prescribed: each time is a goal of its own, one after the other.
        """
        full = min(self.times_done(done_today), max(1, times) - 1)
        return replace(self, before=done_today - full * self.goal)

    def reached(self, valid: int, set_valid: int, set_attempts: int, *, is_done: bool) -> Reached:
        """Say what a finished repetition has brought to its end.

        Parameters
        ----------
        valid : int
            Of the whole session, without those before it.
        set_valid, set_attempts : int
            Since the last set ended.
        is_done : bool
            The goal was reached before: what the patient adds of her own has no sets.

        Returns
        -------
        {"", "valid_count", "set", "attempt_count"}
            The goal, a set, or the attempts of a set; empty while it goes on.
        """
        if self.before + valid >= self.goal and not is_done:
            return "valid_count"
        if set_valid >= self.set_valid and not is_done:
            return "set"
        if self.set_attempts is not None and set_attempts >= self.set_attempts:
            return "attempt_count"
        return ""


def dose_of(repetitions: int, sets: int, stops: Iterable[StopRule]) -> Dose:
    """Return the dose of a prescription with the stop rules that hold for it.

    Parameters
    ----------
    repetitions, sets : int
        Of the prescription.
    stops : iterable of StopRule
        Of the prescription and its template; the smallest number of each kind holds.
    """
    least: dict[str, int] = {}
    for rule in stops:
        if rule.kind in ("valid_count", "attempt_count"):
            least[rule.kind] = min(max(1, round(rule.limit)), least.get(rule.kind, 10**6))
    return Dose(
        goal=repetitions * sets,
        set_valid=min(repetitions, least.get("valid_count", repetitions)),
        set_attempts=least.get("attempt_count"),
    )
