"""False alarms, power and coverage of what is said of a patient's progress."""

from collections.abc import Sequence
from typing import Final

import numpy as np

from estimators.progress import Scatter, Trends, trends
from validation.progress.courses import NOTHING_CHANGES, ROWS, SESSIONS, Course, Row, course, learnt, scale_of
from validation.protocol import Data, Figure, Protocol, Values

_PATIENTS: Final = 12
"""Of each row and number of sessions, a seed: patients of one clinic and one measure."""
_FEW: Final = 2
_COURSE: Final = 20
_RAISED: Final = 0.95
"""From this probability on a decline is raised in the caseload."""
_SOURCE: Final = "House page on progress, section 4"


def _judged(one: Course, prior: Scatter) -> Trends:
    return trends(one.days, one.values, one.errors, one.segments, [prior] * len(one.values))


def _said(found: Trends) -> np.ndarray:
    """Return for each patient whether a change of the main measure is said."""
    said: np.ndarray = (np.minimum(found.probability, 1.0 - found.probability) <= 0.025) & found.lasts
    return said


def _patients(row: Row) -> int:
    """Return how many patients of a row are judged: each of few repetitions has models of the own."""
    return _FEW if row == "few repetitions" else _PATIENTS


def _share(which: np.ndarray) -> float:
    return float(np.mean(which))


def _alarm(row: Row) -> str:
    return f"a look, {row}"


def _false_alarms(seeds: Sequence[int], data: Data) -> Values:
    found: dict[str, list[float]] = {name.name: [] for name in PROGRESS_FALSE_ALARMS.figures}
    for seed in seeds:
        rng = np.random.default_rng(seed)
        scale = scale_of(rng)
        prior = learnt(scale, rng)
        for row in NOTHING_CHANGES:
            counts = [count for count in SESSIONS if row != "wander" or count <= _COURSE]
            said = [_said(_judged(course(row, count, _patients(row), scale, rng), prior)) for count in counts]
            found[_alarm(row)].append(_share(np.array(said)))
        for row, name in (("flat", _OVER_COURSE), ("wander", _OVER_WANDER)):
            whole = course(row, _COURSE, 2 * _PATIENTS, scale, rng)
            looks = [_said(_judged(whole.until(count), prior)) for count in range(4, _COURSE + 1)]
            found[name].append(_share(np.any(looks, axis=0)))
    return {name: np.array(values) for name, values in found.items()}


_OVER_COURSE: Final = "ever in a course of 20 sessions, flat"
_OVER_WANDER: Final = "ever in a course of 20 sessions, wander"

PROGRESS_FALSE_ALARMS = Protocol(
    name="progress_false_alarms",
    title="Changes said where nothing changed",
    source=_SOURCE,
    what="Patients in whom nothing changes, 4 to 60 sessions, three a week, each with a scatter S of the own; the "
    "clinic has learnt that of the measure from thirty others. Wander: days correlate with 0.5, up to 20 sessions. "
    "Few repetitions: 1 to 10 a session, which scatter by 1.5 S. Step that is known: 3 S where another estimator "
    "begins. Said as of the main measure of a page.",
    figures=(
        *(
            Figure(_alarm(row), "1", 0.10 if row == "wander" else 0.07, judged_by="mean")
            for row in NOTHING_CHANGES
        ),
        Figure(_OVER_COURSE, "1", 0.20, judged_by="mean"),
        Figure(_OVER_WANDER, "1", judged_by="mean"),
    ),
    measure=_false_alarms,
)


def _power(seeds: Sequence[int], data: Data) -> Values:
    found: dict[str, list[float]] = {one.name: [] for one in PROGRESS_POWER.figures}
    for seed in seeds:
        rng = np.random.default_rng(seed)
        scale = scale_of(rng)
        prior = learnt(scale, rng)
        rising: tuple[tuple[Row, str], ...] = (("linear", _POWER), ("slow", _SLOW))
        for row, name in rising:
            found[name].append(_share(_said(_judged(course(row, 10, 2 * _PATIENTS, scale, rng), prior))))
        falling = course("decline", 8, 2 * _PATIENTS, scale, rng)
        raised = [_judged(falling.until(count), prior).probability <= 1.0 - _RAISED for count in range(4, 9)]
        found[_DECLINE].append(_share(np.any(raised, axis=0)))
        called, lifted = [], []
        flat: tuple[Row, ...] = ("plateau", "plateau later")
        for row in flat:
            for count in SESSIONS:
                one = _judged(course(row, count, _PATIENTS, scale, rng), prior)
                called.append(_said(one) & (one.change < 0.0))
                lifted.append(one.probability <= 1.0 - _RAISED)
        found[_PLATEAU].append(_share(np.array(called)))
        found[_PLATEAU_RAISED].append(_share(np.array(lifted)))
    return {name: np.array(values) for name, values in found.items()}


_POWER: Final = "said after 10 sessions, S/2 a session"
_SLOW: Final = "said after 10 sessions, S/4 a session"
_DECLINE: Final = "decline of S/2 a session raised by the eighth"
_PLATEAU: Final = "plateau said to be a decline, a look"
_PLATEAU_RAISED: Final = "plateau raised as a decline, a look"

PROGRESS_POWER = Protocol(
    name="progress_power",
    title="Changes found",
    source=_SOURCE,
    what="Patients whose level rises or falls by a share of their own S each session. A decline is raised in the "
    "caseload from a probability of 0.95. A plateau rises for up to eight sessions, or for a third of them, and stays.",
    figures=(
        Figure(_POWER, "1", 0.9, at_most=False, judged_by="mean"),
        Figure(_SLOW, "1", judged_by="mean"),
        Figure(_DECLINE, "1", 0.9, at_most=False, judged_by="mean"),
        Figure(_PLATEAU, "1", 0.025, judged_by="mean"),
        Figure(_PLATEAU_RAISED, "1", 0.05, judged_by="mean"),
    ),
    measure=_power,
)


def _interval(seeds: Sequence[int], data: Data) -> Values:
    held: dict[str, list[np.ndarray]] = {row: [] for row in ROWS}
    for seed in seeds:
        rng = np.random.default_rng(seed)
        scale = scale_of(rng)
        prior = learnt(scale, rng)
        for row in ROWS:
            for count in SESSIONS:
                one = course(row, count, _patients(row), scale, rng)
                found = _judged(one, prior)
                truth = one.level[:, -1] - one.level[:, found.first]
                # An unusual last day is left out: what is said is then of the day before it.
                truth = np.where(found.unusual, one.level[:, -2] - one.level[:, found.first], truth)
                held[row].append(np.abs(found.change - truth) <= found.half_width)
    rows = [_share(np.array(one)) for one in held.values()]
    whole = float(np.mean(rows))
    return {
        _WHOLE: np.array([whole]),
        _WHOLE_MOST: np.array([whole]),
        _LEAST: np.array([min(rows)]),
        _MOST: np.array([max(rows)]),
    }


_WHOLE: Final = "interval of 95 % holds the change, all rows"
_WHOLE_MOST: Final = "the same, not too wide"
_LEAST: Final = "least row"
_MOST: Final = "largest row"

PROGRESS_INTERVAL = Protocol(
    name="progress_interval",
    title="Interval of a change",
    source=_SOURCE,
    what="Flat, wandering, weekly, absent for three weeks, few repetitions, a known and an unknown step of 3 S, "
    "S/2 and S/4 a session, decline and two plateaus, each with 4 to 60 sessions: how often the 95 % interval holds "
    "the true change since the baseline, and in which row least and most.",
    figures=(
        Figure(_WHOLE, "1", 0.93, at_most=False, judged_by="mean"),
        Figure(_WHOLE_MOST, "1", 0.97, judged_by="mean"),
        Figure(_LEAST, "1", 0.90, at_most=False, judged_by="mean"),
        Figure(_MOST, "1", 0.995, judged_by="mean"),
    ),
    measure=_interval,
)
