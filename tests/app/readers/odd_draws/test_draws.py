"""Odd tables drawn at random are read right or refused, and never wrong in silence."""

import numpy as np
import pytest

from tests.app.readers.odd_draws.drawn import draw
from tests.app.readers.odd_draws.judged import REFUSED, RIGHT, WRONG, judge

PER_TEST = 12


@pytest.mark.parametrize("first", range(0, 96, PER_TEST))
def test_drawn_tables_are_not_read_wrong_in_silence(first):
    """More of them: `python -m tests.app.readers.odd_draws --draws 2000`."""
    verdicts = {seed: judge(draw(seed)) for seed in range(first, first + PER_TEST)}
    assert {seed: one for seed, one in verdicts.items() if one.kind == WRONG} == {}
    refused = {seed: one for seed, one in verdicts.items() if one.kind == REFUSED}
    assert len(refused) <= 1, refused


FAULTS = {
    "a rate that is off": lambda one: setattr(one, "rate_hz", 1.02 * one.rate_hz),
    "a sensor too many": lambda one: one.sensors.append(draw(one.seed + 1).sensors[0]),
    "another unit": lambda one: _scaled(one, "gyroscope", 57.3),
    "another sign": lambda one: _scaled(one, "accelerometer", -1.0),
    "a time that is off by three steps": lambda one: _later(one, 3.0),
    "samples that are lost": lambda one: _longer(one),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_the_judge_sees_what_is_wrong(fault):
    """Each draw that is read right is judged wrong where its truth is another one."""
    found = [one for one in map(draw, range(8)) if judge(one).kind == RIGHT]
    assert len(found) > 4
    for one in found:
        FAULTS[fault](one)
    assert {judge(one).kind for one in found} == {WRONG}


def _scaled(one, quantity, factor):
    for sensor in one.sensors:
        sensor.signals[quantity].values *= factor


def _later(one, steps):
    """Move the second half of all samples."""
    for sensor in one.sensors:
        for signals in sensor.signals.values():
            signals.time_s[signals.time_s.size // 2 :] += steps / one.rate_hz


def _longer(one):
    """Pretend that the table holds a tenth more than it does."""
    for sensor in one.sensors:
        for signals in sensor.signals.values():
            count = signals.time_s.size // 10
            more = signals.time_s[-1] + (1.0 + np.arange(count)) / one.rate_hz
            signals.time_s = np.append(signals.time_s, more)
            signals.values = np.concatenate([signals.values, signals.values[:count]])
            signals.there = np.append(signals.there, np.ones(count, dtype=bool))
