"""Samples of every kind: a cut, a join and a thinning reach each field, also one that is added tomorrow."""

from dataclasses import dataclass, fields, replace

import numpy as np
import pytest

from estimators.magnetic import RelativeResult
from estimators.magnetic.relative.pose import RelativeChunk
from estimators.magnetic.tracker.fusion import TrackerFusionChunk
from estimators.optical._contract import OpticalChunk
from estimators.optical.alignment._mounting import Accelerations
from estimators.orientation import DeviceConstants, OrientationFlag, OrientationResult, SmoothedChunk
from estimators.pipelines import FrameLayout, Frames, ModulesChunk
from estimators.recording import ImuChunk, SampleQuality
from estimators.samples import Samples
from published._strapdown_estimator import StrapdownResult

TICKS = 12
SENSORS = 3
NESTED = {"orientation": OrientationResult, "modules": RelativeResult}
WHOLE = {
    "time_step_s": 0.01,
    "first_tick": 7,
    "layout": FrameLayout(("a",), ("b",), ("c",), ("d",)),
    "constants": (DeviceConstants(),) * SENSORS,
}
KINDS = [
    ImuChunk,
    SmoothedChunk,
    ModulesChunk,
    OrientationResult,
    RelativeResult,
    RelativeChunk,
    TrackerFusionChunk,
    OpticalChunk,
    Accelerations,
    Frames,
    StrapdownResult,
]


def made(kind):
    """Every field filled, each number another one."""
    rng = np.random.default_rng(len(fields(kind)))
    found = {}
    for one in fields(kind):
        if one.name in WHOLE:
            found[one.name] = WHOLE[one.name]
        elif one.name in NESTED:
            inner = made(NESTED[one.name])
            found[one.name] = (inner, made(NESTED[one.name])) if "tuple" in str(one.type) else inner
        else:
            shape = (SENSORS, TICKS, 3) if kind.TICK_AXIS else (TICKS, 3)
            array = rng.integers(0, 200, shape)
            found[one.name] = array.astype(np.uint8 if "uint" in str(one.type) else float)
    return kind(**found)


def same(a, b):
    assert type(a) is type(b)
    for one in fields(a):
        first, second = getattr(a, one.name), getattr(b, one.name)
        if isinstance(first, Samples):
            same(first, second)
        elif isinstance(first, tuple) and isinstance(first[0], Samples):
            for k in range(len(first)):
                same(first[k], second[k])
        else:
            np.testing.assert_array_equal(first, second, err_msg=one.name)


def every_array(samples):
    for one in fields(samples):
        value = getattr(samples, one.name)
        for part in value if isinstance(value, tuple) else (value,):
            if isinstance(part, Samples):
                yield from every_array(part)
            elif isinstance(part, np.ndarray):
                yield one.name, part, samples.TICK_AXIS


def test_every_kind_of_samples_is_tried():
    def below(kind):
        return {kind}.union(*(below(one) for one in kind.__subclasses__()))

    assert {
        kind
        for kind in below(Samples) - {Samples}
        if kind.__module__.startswith(("estimators.", "published."))
    } == set(KINDS)


@pytest.mark.parametrize("kind", KINDS)
def test_what_is_cut_and_joined_is_what_it_was(kind):
    whole = made(kind)
    assert whole.tick_count == TICKS
    parts = [whole.ticks(0, 1), whole.ticks(1, 1), whole.ticks(1, 9), whole.ticks(9, 40)]
    assert [part.tick_count for part in parts] == [1, 0, 8, 3]
    same(kind.join(parts), whole)
    if hasattr(whole, "first_tick"):
        assert parts[2].first_tick == whole.first_tick + 1
        same(kind.merge([parts[3], parts[0], parts[2]]), whole)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("step", [1, 4, 5])
def test_thinning_reaches_each_field_and_says_the_time(kind, step):
    whole = made(kind)
    thin = whole.every(step)
    skip = -getattr(whole, "first_tick", 0) % step
    for (name, found, axis), (_, given, _) in zip(every_array(thin), every_array(whole), strict=True):
        starts = np.arange(skip, TICKS, step)
        if given.dtype.kind == "u":
            joined = [
                np.bitwise_or.reduce(given.take(range(k, min(k + step, TICKS)), axis), axis) for k in starts
            ]
            np.testing.assert_array_equal(found, np.stack(joined, axis), err_msg=name)
        else:
            np.testing.assert_array_equal(found, given.take(starts, axis), err_msg=name)
    if hasattr(whole, "time_s") and hasattr(whole, "first_tick"):
        np.testing.assert_allclose(thin.time_s, whole.time_s[skip::step], atol=1e-12)


def test_what_no_part_holds_is_unknown():
    whole = made(Frames)
    gap = Frames.merge([whole.ticks(0, 4), replace(whole.ticks(9, 12), point_sigma_m=None)])
    assert gap.tick_count == TICKS
    assert np.isnan(gap.q_room_segment[4:9]).all()
    assert (gap.segment_flags[4:9] == OrientationFlag.INVALID).all()
    np.testing.assert_array_equal(gap.point_sigma_m[:4], whole.point_sigma_m[:4])
    assert np.isnan(gap.point_sigma_m[4:]).all()
    chunk = made(ImuChunk)
    lost = ImuChunk.merge([chunk.ticks(0, 2), chunk.ticks(5, 12)])
    assert (lost.quality[:, 2:5] == SampleQuality.MISSING).all()
    assert ImuChunk.join([replace(chunk, force_n=None), replace(chunk, force_n=None)]).force_n is None


def test_sensors_are_picked_in_the_order_asked_for():
    chunk = made(ImuChunk)
    picked = chunk.sensors([2, 0])
    for (name, found, _), (_, given, _) in zip(every_array(picked), every_array(chunk), strict=True):
        np.testing.assert_array_equal(found, given[[2, 0]], err_msg=name)
    assert (picked.first_tick, picked.time_step_s) == (chunk.first_tick, chunk.time_step_s)


def test_a_field_that_is_added_is_cut_with_the_others():
    @dataclass(frozen=True)
    class Warmer(ImuChunk):
        temperature_degc: np.ndarray | None = None

    warm = made(Warmer)
    assert warm.ticks(3, 7).temperature_degc.shape[1] == 4
    assert Warmer.join([warm.ticks(0, 3), warm.ticks(3, TICKS)]).temperature_degc.shape[1] == TICKS
