"""Limits live: one that rest itself breaks is told and set aside, all others hold from the first frame on."""

from typing import Any

import numpy as np
import pytest

from estimators.guidance import StopRule
from estimators.guidance.live import GuidanceRunner, _following
from tests.estimators.guidance.test_cues import ready

TICK_S = 0.01


@pytest.fixture
def following(monkeypatch: pytest.MonkeyPatch) -> Any:
    """Return a function that makes a `GuidanceRunner` fed with values instead of frames."""

    class Straight:
        def __init__(self, _: Any) -> None: ...

        def pick(self, frames: Any) -> Any:
            return frames.values, np.full_like(frames.values, 0.01)

    monkeypatch.setattr(_following, "ChannelSelector", Straight)

    def make(*stops: StopRule) -> Any:
        return GuidanceRunner(ready(), TICK_S, stops=stops)

    return make


class Given:
    def __init__(self, values: np.ndarray, first_tick: int) -> None:
        self.values, self.first_tick = values, first_tick


def fed(follows: Any, main: np.ndarray) -> tuple[list[Any], list[Any]]:
    """Feed a course of the main channel in packets of five ticks; return stops, and what was set aside."""
    made = ready()
    column = made.channels.index(made.main)
    stops, aside = [], []
    for first in range(0, len(main), 5):
        values = np.tile(made.mean[0], (len(main[first : first + 5]), 1))
        values[:, column] = main[first : first + 5]
        chunk, _ = follows.feed(Given(values, first))
        stops += chunk.stops
        aside += follows.take_set_aside()
    return stops, aside


def course(rest: float, most: float) -> np.ndarray:
    """Two and a half seconds of rest, two out and back."""
    out = np.sin(np.linspace(0.0, np.pi, 200)) ** 2
    return np.concatenate([np.full(250, rest), rest + (most - rest) * out, np.full(100, rest)])


def test_a_limit_that_rest_breaks_does_not_stop_and_is_told_once(following: Any) -> None:
    made = ready()
    rest = float(made.mean[0, made.channels.index(made.main)])
    rule = StopRule("limit", rest - 0.5, made.main, "above", 0.05)
    follows = following(rule)
    stops, aside = fed(follows, course(rest, rest - 1.0))
    assert stops == []
    assert [one for one, _ in aside] == [rule]
    assert aside[0][1] == pytest.approx(rest)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_limit_that_rest_keeps_stops_as_before(following: Any, sign: float) -> None:
    made = ready()
    rest = float(made.mean[0, made.channels.index(made.main)])
    rule = StopRule("limit", rest + sign * 0.5, made.main, "above" if sign > 0 else "below", 0.05)
    stops, aside = fed(following(rule), course(rest, rest + sign * 1.0))
    assert [one.kind for one in stops] == ["limit"]
    assert aside == []


def test_a_limit_holds_before_the_first_rest_too(following: Any) -> None:
    made = ready()
    rest = float(made.mean[0, made.channels.index(made.main)])
    rule = StopRule("limit", rest + 0.5, made.main, "above", 0.05)
    moving = rest + np.concatenate([np.linspace(0.0, 1.0, 60), np.full(40, 1.0)])
    stops, aside = fed(following(rule), moving)
    assert [one.kind for one in stops] == ["limit"]
    assert aside == []


def test_after_a_restart_every_limit_holds_at_once(following: Any) -> None:
    made = ready()
    rest = float(made.mean[0, made.channels.index(made.main)])
    rule = StopRule("limit", rest - 0.5, made.main, "above", 0.05)
    follows = following(rule)
    follows.watch_all()
    stops, _ = fed(follows, np.full(100, rest))
    assert [one.kind for one in stops] == ["limit"]
