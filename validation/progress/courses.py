"""Courses of therapy in numbers: sessions of many patients, with levels and a scatter that only the simulator knows."""

from dataclasses import dataclass
from typing import Final, Literal

import numpy as np

from estimators.progress import NO_PRIOR, Scatter, learn_scatter, second_differences
from estimators.recording import Float

Row = Literal[
    "flat",
    "wander",
    "weekly rhythm",
    "missing weeks",
    "few repetitions",
    "step that is known",
    "linear",
    "slow",
    "decline",
    "plateau",
    "plateau later",
    "step",
    "linear, missing weeks",
]
NOTHING_CHANGES: Final[tuple[Row, ...]] = (
    "flat",
    "wander",
    "weekly rhythm",
    "missing weeks",
    "few repetitions",
    "step that is known",
)
ROWS: Final[tuple[Row, ...]] = (
    *NOTHING_CHANGES,
    "linear",
    "slow",
    "decline",
    "plateau",
    "plateau later",
    "step",
    "linear, missing weeks",
)
SESSIONS: Final = (4, 6, 8, 10, 15, 20, 40, 60)
PEOPLE: Final = 30
"""Of whom the clinic knows the scatter of a measure before the patients who are judged."""
_LEARNT: Final[tuple[Row, ...]] = ("flat", "linear", "slow", "decline", "plateau", "wander")
_WITHIN: Final = 1.5
"""Standard deviation between repetitions of a session, in S, where there are few."""
_FREEDOM: Final = 8.0
"""How alike people are in their scatter: chi-square degrees of freedom."""
_ABSENT_DAYS: Final = 21.0


@dataclass(frozen=True)
class Course:
    """The sessions of M patients at the same days.

    Attributes
    ----------
    days : ndarray, shape (N,)
    values, level, errors : ndarray, shape (M, N)
        As measured, without the deviations of days, and what the repetitions say of the values.
    segments : ndarray, shape (N,)
    """

    days: Float
    values: Float
    level: Float
    errors: Float
    segments: Float

    def until(self, count: int) -> "Course":
        """Return the first sessions alone."""
        return Course(
            self.days[:count],
            self.values[:, :count],
            self.level[:, :count],
            self.errors[:, :count],
            self.segments[:count],
        )


def scale_of(rng: np.random.Generator) -> float:
    """Return the scatter of some measure: of degrees, seconds or shares, nobody knows which."""
    return float(np.exp(rng.uniform(np.log(0.02), np.log(20.0))))


def course(row: Row, count: int, patients: int, scale: float, rng: np.random.Generator) -> Course:
    """Return courses of one kind: three sessions a week; of a weekly rhythm two days of three.

    Parameters
    ----------
    count : int
        Sessions.
    scale : float
        Of the measure; each patient has another S about it, and levels are in the own S.
    """
    own = scale * np.sqrt(_FREEDOM / rng.chisquare(_FREEDOM, patients))[:, None]
    number = np.arange(count)
    days = 7.0 * (number // 3) + np.array([0.0, 2.0, 4.0])[number % 3]
    if row == "weekly rhythm":
        days = 3.0 * (number // 2) + number % 2
    elif row.endswith("missing weeks"):
        days = days + _ABSENT_DAYS * (number >= count // 2)
    level = own * _level(row, number.astype(np.float64))
    values = level + own * _days(0.5 if row == "wander" else 0.0, patients, count, rng)
    errors = np.broadcast_to(own / 4.0, values.shape)
    segments = np.zeros(count)
    if row == "weekly rhythm":
        phase = rng.uniform(0.0, 2.0 * np.pi, (patients, 1))
        values = values + 0.7 * own * np.sin(2.0 * np.pi * days / 7.0 + phase)
    elif row == "few repetitions":
        errors = _WITHIN * own / np.sqrt(rng.integers(1, 11, count))
        values = values + errors * rng.normal(size=values.shape)
    elif row == "step that is known":
        segments = (number >= count // 2).astype(np.float64)
        values = values + 3.0 * own * segments
    return Course(days, values, level, np.asarray(errors), segments)


def _level(row: Row, number: Float) -> Float:
    half = max(len(number) // 2, 3)
    if row in ("linear", "linear, missing weeks"):
        return number / 2.0
    if row == "slow":
        return number / 4.0
    if row == "decline":
        return -number / 2.0
    if row == "plateau":
        return np.minimum(number, min(half, 8)) / 2.0
    if row == "plateau later":
        return np.minimum(number, len(number) / 3.0) / 2.0
    if row == "step":
        return np.where(number >= len(number) // 2, 3.0, 0.0)
    return np.zeros(len(number))


def _days(correlation: float, patients: int, count: int, rng: np.random.Generator) -> Float:
    found = rng.normal(size=(patients, count))
    for k in range(1, count):
        found[:, k] = correlation * found[:, k - 1] + np.sqrt(1.0 - correlation**2) * found[:, k]
    return found


def learnt(scale: float, rng: np.random.Generator) -> Scatter:
    """Return what thirty patients of a clinic say of a measure, whatever became of them."""
    found = []
    for number in range(PEOPLE):
        one = course(_LEARNT[number % len(_LEARNT)], int(rng.integers(4, 25)), 1, scale, rng)
        variance, freedom = second_differences(one.days, one.values)
        found.append((float(variance[0]), freedom))
    prior = learn_scatter(*(np.array(column) for column in zip(*found, strict=True)))
    assert prior != NO_PRIOR
    return prior
