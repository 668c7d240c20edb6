import itertools
from functools import cache

import numpy as np
import pytest
from foot_walk import foot_walk

from estimators import rotation
from estimators.errors import SetupError, ShapeError
from estimators.gait import FootFlag, FootTracker, LiveStepTracker, smooth
from estimators.recording import ImuChunk, SampleQuality

STEP_S = 0.01
FIELDS = (
    "position_m",
    "velocity_mps",
    "q_world_sensor",
    "pivot_m",
    "position_sigma_m",
    "attitude_sigma_rad",
    "statistic",
    "is_stance",
    "flags",
)


@cache
def walks():
    return [
        foot_walk(strides=6, noise=1.0, seed=s, length_m=length, mounting=mounting)
        for s, (length, mounting) in enumerate(((1.2, None), (0.8, (0.5, 1.0, 2.0))))
    ]


def chunk(trouble=True, first_tick=40):
    gyroscope = np.stack([walk.signals.gyroscope_radps for walk in walks()])
    force = np.stack([walk.signals.accelerometer_mps2 for walk in walks()])
    field = np.stack(
        [rotation.rotate(rotation.conjugate(walk.q_world_sensor), [0, 20e-6, -40e-6]) for walk in walks()]
    )
    quality = np.zeros(gyroscope.shape[:2], dtype=np.uint8)
    field[1, 200:230] = np.nan
    if trouble:
        gyroscope[0, :13] = np.nan
        quality[0, :13] |= np.uint8(SampleQuality.MISSING)
        quality[1, 300:312] |= np.uint8(SampleQuality.BRIDGED)
        gyroscope[1, 500:560] = np.nan
        force[1, 500:560] = np.nan
        quality[1, 500:560] |= np.uint8(SampleQuality.MISSING)
        quality[0, 333] |= np.uint8(SampleQuality.SATURATED)
    return ImuChunk(first_tick, STEP_S, gyroscope, force, field, quality)


def gather(parts):
    first = parts[0].first_tick
    for part in parts:
        assert part.first_tick == first
        first += part.tick_count
    return {name: np.concatenate([getattr(part, name) for part in parts], axis=1) for name in FIELDS}


def run(whole, sizes, stop_at=None):
    tracker, parts, start = FootTracker(2, STEP_S), [], 0
    for size in sizes:
        if start >= whole.tick_count:
            break
        stop = min(start + size, whole.tick_count)
        parts.append(tracker.update(whole.ticks(start, stop)))
        start = stop
        if stop_at is not None and start >= stop_at:
            stored = {name: np.array(values) for name, values in tracker.state().items()}
            tracker, stop_at = FootTracker(2, STEP_S), None
            tracker.restore(stored)
    return gather([*parts, tracker.finish()])


def assert_same_bits(one, two):
    for name in FIELDS:
        assert one[name].tobytes() == two[name].tobytes(), name


@pytest.fixture(scope="module")
def batch():
    return run(chunk(), [10**6])


def test_one_by_one_uneven_and_batch_are_equal(batch):
    assert_same_bits(batch, run(chunk(), itertools.cycle((5, 1, 17, 64, 3))))
    assert_same_bits(batch, run(chunk(), itertools.cycle((1, 1, 1, 1, 12))))


@pytest.mark.parametrize("tick", [5, 60, 120, 333, 530, 700, 858])
def test_restored_goes_on_alike(batch, tick):
    assert_same_bits(batch, run(chunk(), itertools.repeat(7), stop_at=tick))


def test_readings_of_half_the_width_are_taken_as_they_are():
    given = chunk()
    assert given.magnetometer_t is not None
    halves = [
        values.astype(np.float32)
        for values in (given.gyroscope_radps, given.accelerometer_mps2, given.magnetometer_t)
    ]
    quality = given.quality.astype(np.int64)
    narrow = ImuChunk(given.first_tick, STEP_S, *halves, quality)
    wide = ImuChunk(given.first_tick, STEP_S, *(half.astype(np.float64) for half in halves), given.quality)
    found, expected = (gather([FootTracker(2, STEP_S).update(one)]) for one in (narrow, wide))
    for name in FIELDS:
        np.testing.assert_array_equal(found[name], expected[name], err_msg=name)


def test_every_tick_is_released_once_and_in_time():
    whole, tracker = chunk(), FootTracker(2, STEP_S)
    assert tracker.delay_ticks * STEP_S < 1.0
    released = 0
    for tick in range(whole.tick_count):
        released += tracker.update(whole.ticks(tick, tick + 1)).tick_count
        assert released >= tick + 1 - tracker.delay_ticks
    last = tracker.finish()
    assert last.first_tick == whole.first_tick + released
    assert released + last.tick_count == whole.tick_count


def test_flags_follow_the_samples(batch):
    flags = batch["flags"]
    assert (flags[0, :13] & FootFlag.INVALID).all()
    assert not (flags[0, 13:] & FootFlag.INVALID).any()
    assert (flags[1, 500:560] & FootFlag.INVALID).all()
    assert not batch["is_stance"][1, 494:566].any()
    assert (flags[1, 300:312] & FootFlag.BRIDGED).all()
    assert flags[0, 333] & FootFlag.SATURATED
    assert np.isfinite(batch["position_m"]).all()


@pytest.mark.parametrize("begin", [155, 165, 170, 300])
def test_steps_come_from_no_stance_that_the_flags_disown(begin):
    """A record begun at heel rise, in mid-swing or before contact of a stride of 0.8 m."""
    whole, steps = chunk(trouble=False), LiveStepTracker(("left", "right"), STEP_S)
    tracker = FootTracker(2, STEP_S)
    parts = [tracker.update(whole.ticks(begin, whole.tick_count)), tracker.finish()]
    lengths = np.concatenate([steps.update(part).stride_length_m for part in parts])
    live = gather(parts)
    assert not (live["is_stance"] & ((live["flags"] & FootFlag.NO_STANCE) != 0)).any()
    for foot, true_m in enumerate((1.2, 0.8)):
        found = np.unique(lengths[np.isfinite(lengths[:, foot]), foot])
        assert len(found) >= 2
        assert found == pytest.approx(true_m, abs=0.03)


def cut_off_at(triad, level=np.inf, *, is_declared=False, is_marked=False):
    """Return what is released of a quick foot whose gyroscope (0) or accelerometer (1) ends at `level`."""
    walk = foot_walk(strides=6, noise=1.0, period_s=0.7, roll_rad=1.5)
    triads = [walk.signals.gyroscope_radps[None], walk.signals.accelerometer_mps2[None]]
    triads[triad] = np.clip(triads[triad], -level, level)
    # What counts as at a declared level.
    is_cut = (np.abs(triads[triad]) > (0.99, 0.97)[triad] * level).any(axis=2)
    quality = np.where(is_cut & is_marked, SampleQuality.SATURATED, 0).astype(np.uint8)
    name = ("gyroscope_clip_radps", "accelerometer_clip_mps2")[triad]
    tracker = FootTracker(1, STEP_S, {name: level} if is_declared else None)
    return gather([tracker.update(ImuChunk(0, STEP_S, *triads, None, quality)), tracker.finish()])


@pytest.mark.parametrize(
    ("triad", "level", "sigma"), [(0, 5.0, "attitude_sigma_rad"), (1, 25.0, "position_sigma_m")]
)
def test_a_clip_that_is_marked_widens_sigma_as_one_that_is_declared(triad, level, sigma):
    declared = cut_off_at(triad, level, is_declared=True)
    marked = cut_off_at(triad, level, is_marked=True)
    sound = cut_off_at(triad)
    # The gyroscope turns its fastest when this accelerometer is cut off: it may be cut off as well.
    np.testing.assert_allclose(marked[sigma], declared[sigma], rtol=(1e-9, 0.1)[triad])
    assert marked[sigma].max() > 2.0 * sound[sigma].max()


def test_a_mark_where_no_axis_is_at_its_end_widens_nothing():
    whole = chunk(trouble=False)
    marked = ImuChunk(
        whole.first_tick,
        STEP_S,
        whole.gyroscope_radps,
        whole.accelerometer_mps2,
        whole.magnetometer_t,
        np.where(np.arange(whole.tick_count) % 2, SampleQuality.SATURATED, 0).astype(np.uint8)
        * np.ones((2, 1), dtype=np.uint8),
    )
    one, two = run(whole, [10**6]), run(marked, [7] * 200)
    assert one["position_sigma_m"][1].tobytes() == two["position_sigma_m"][1].tobytes()


def test_live_is_nearly_as_good_as_off_line():
    live = run(chunk(trouble=False), [100] * 20)
    for s, walk in enumerate(walks()):
        turn = rotation.multiply(walk.q_world_sensor[0], rotation.conjugate(live["q_world_sensor"][s, 0]))
        ends = rotation.rotate(turn, live["position_m"][s]) - walk.position_m
        assert np.linalg.norm(ends[-1] - ends[0]) < 0.08
        off_line = smooth(walk.signals).position_m
        stride = np.linalg.norm(live["position_m"][s, 640] - live["position_m"][s, 530])
        assert stride == pytest.approx(np.linalg.norm(off_line[640] - off_line[530]), abs=0.02)


def test_a_foot_whose_link_was_lost_walks_on():
    live = run(chunk(), [100] * 20)
    walk = walks()[1]
    # The stride after the hole of 0.6 s, which lies in the fourth, is right again.
    last = slice(-80, None)
    found = live["position_m"][1, 760] - live["position_m"][1, 650]
    assert np.linalg.norm(found) == pytest.approx(
        np.linalg.norm(walk.position_m[760] - walk.position_m[650]), abs=0.08
    )
    assert np.isfinite(live["position_sigma_m"][1, last]).all()
    assert np.linalg.norm(live["velocity_mps"][1, -20:], axis=1).max() < 0.05


def test_wrong_arguments_are_refused():
    with pytest.raises(SetupError, match="no_such"):
        FootTracker(2, STEP_S, {"no_such": 1.0})
    with pytest.raises(ShapeError, match="Hz"):
        FootTracker(2, 0.1)
    tracker = FootTracker(2, STEP_S)
    tracker.update(chunk().ticks(0, 5))
    with pytest.raises(ShapeError, match="tick 45 is next"):
        tracker.update(chunk().ticks(6, 9))
    with pytest.raises(ShapeError, match="as many feet"):
        FootTracker(1, STEP_S).restore(tracker.state())
    assert FootTracker(2, STEP_S, tracker.parameters).parameters == tracker.parameters
