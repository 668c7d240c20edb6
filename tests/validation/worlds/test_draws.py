"""Random worlds are physically one, as drawn, and the same for the same seed."""

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from estimators import orientation, rotation
from estimators.conventions import GRAVITY_MPS2
from estimators.recording import SampleQuality
from validation.worlds import TUNING_SEEDS, Conditions, conditions_of, draw, world_seed
from validation.worlds.conditions import MOTIONS, ROWS, stream
from validation.worlds.motion import moved

IDEAL = Conditions(
    motion="hand",
    grade="ideal",
    field="clean",
    axes=9,
    rate_hz=200.0,
    duration_s=60.0,
    rest_s=2.0,
    dip_rad=np.radians(-35.0),
    strength_t=48e-6,
)
MOVING = [motion for motion in MOTIONS if motion != "none"]


def in_earth_axes(world, values):
    return rotation.rotate(world.q_earth_sensor, values[0])


def test_an_ideal_device_at_rest_reads_gravity_and_the_field_alone():
    world = draw(3, replace(IDEAL, motion="none"))
    assert np.abs(world.chunk.gyroscope_radps).max() < 1e-12
    force = in_earth_axes(world, world.chunk.accelerometer_mps2)
    np.testing.assert_allclose(force, np.tile([0.0, 0.0, GRAVITY_MPS2], (len(force), 1)), atol=1e-9)


@pytest.mark.parametrize("has_soft_tissue", [False, True])
@pytest.mark.parametrize("motion", MOVING)
def test_the_gyroscope_turns_through_the_truth(motion, has_soft_tissue):
    # Means of the rate know no coning: what they leave out shrinks with the square of the interval.
    world = draw(5, replace(IDEAL, motion=motion, has_soft_tissue=has_soft_tissue, rate_hz=400.0))
    turns = rotation.exp(world.chunk.gyroscope_radps[0, 1:] * world.chunk.time_step_s)
    found = rotation.multiply(world.q_earth_sensor[0], rotation.running_product(turns))
    apart = rotation.angle_between(found, world.q_earth_sensor[1:])
    assert np.degrees(apart.max()) < 0.1
    assert np.degrees(rotation.angle_between(world.q_earth_sensor, world.q_earth_sensor[0]).max()) > 5.0


@pytest.mark.parametrize("has_soft_tissue", [False, True])
@pytest.mark.parametrize("motion", MOVING)
def test_specific_force_is_that_of_the_path(motion, has_soft_tissue):
    drawn = replace(IDEAL, motion=motion, has_soft_tissue=has_soft_tissue, rate_hz=400.0, duration_s=12.0)
    world = draw(7, drawn)
    fine, step_s = 4, 1.0 / 1600.0
    time_s = step_s * (np.arange(4800 * fine + 1) - fine)
    q, place = moved(drawn, time_s, stream(7, "motion"))
    np.testing.assert_array_equal(q[fine::fine], world.q_earth_sensor)
    # A mean over an interval, turned by the attitude in its middle, is the change of velocity.
    force = rotation.rotate(q[fine // 2 :: fine], world.chunk.accelerometer_mps2[0])
    velocity = np.cumsum(force - [0.0, 0.0, GRAVITY_MPS2], axis=0) * world.chunk.time_step_s
    true = np.gradient(place, step_s, axis=0)[fine::fine]
    assert np.abs(velocity - (true - true[0])).max() < 0.02
    if motion != "turning" or has_soft_tissue:
        return
    assert np.abs(place).max() == 0.0


def test_a_pendulum_has_one_length():
    time_s = 0.002 * np.arange(15_000)
    _, place = moved(replace(IDEAL, motion="pendulum"), time_s, np.random.default_rng(2))
    length = np.linalg.norm(place, axis=1)
    assert np.ptp(length) < 1e-12
    assert 0.25 <= length[0] <= 0.9


def test_a_device_that_takes_single_samples_reads_the_end_of_the_interval():
    mean, single = (
        draw(4, replace(IDEAL, is_averaging=averages, rate_hz=50.0)) for averages in (True, False)
    )
    np.testing.assert_array_equal(mean.q_earth_sensor, single.q_earth_sensor)
    means, singles = mean.chunk.accelerometer_mps2[0], single.chunk.accelerometer_mps2[0]
    # To first order the mean is the value in the middle of two ends.
    middle = 0.5 * (singles[1:] + singles[:-1])
    assert np.abs(means[1:] - middle).mean() < 0.5 * np.abs(means[1:] - singles[1:]).mean()


def test_a_clean_room_has_one_field_of_the_drawn_dip_and_strength():
    world = draw(11, IDEAL)
    field = in_earth_axes(world, world.chunk.magnetometer_t)
    np.testing.assert_allclose(field, np.tile(field[0], (len(field), 1)), atol=1e-15)
    assert np.linalg.norm(field[0]) == pytest.approx(48e-6)
    # South of the equator the field points up, and north is y everywhere.
    assert np.arctan2(-field[0, 2], field[0, 1]) == pytest.approx(np.radians(-35.0))
    assert abs(field[0, 0]) < 1e-18


@pytest.mark.parametrize(
    "kind", ["room", "iron at the start", "magnets passing", "lift or bed", "turned all along"]
)
def test_foreign_fields_are_of_places_and_times(kind):
    world = draw(12, replace(IDEAL, field=kind))
    apart = in_earth_axes(world, world.chunk.magnetometer_t) - in_earth_axes(
        draw(12, IDEAL), draw(12, IDEAL).chunk.magnetometer_t
    )
    size = np.linalg.norm(apart, axis=1)
    if kind == "room":
        np.testing.assert_allclose(apart.mean(axis=0), 0.0, atol=1e-7)
        assert 1e-6 < np.sqrt((size**2).mean()) < 8.1e-6
    elif kind == "iron at the start":
        assert 8e-6 <= size[0] <= 40e-6
        assert size[-1] < 0.2 * size[0]
    elif kind == "magnets passing":
        assert size.max() >= 8e-6
        assert np.median(size) < 0.5 * size.max()
    elif kind == "lift or bed":
        assert size[0] == pytest.approx(0.0, abs=1e-15)
        assert size.max() > 5e-6
    else:
        assert np.ptp(size) < 1e-12
        assert 3.0 <= np.degrees(np.arcsin(size[0] / 2 / (48e-6 * np.cos(IDEAL.dip_rad)))) * 2 <= 15.0


@pytest.mark.parametrize("kind", ["iron worn", "iron put on", "iron taken off"])
def test_iron_on_the_wearer_goes_with_the_sensor(kind):
    worn, clean = draw(13, replace(IDEAL, field=kind)), draw(13, IDEAL)
    iron = worn.chunk.magnetometer_t[0] - clean.chunk.magnetometer_t[0]
    size = np.linalg.norm(iron, axis=1)
    is_worn = {"iron worn": (True, True), "iron put on": (False, True), "iron taken off": (True, False)}[kind]
    assert [bool(5e-6 <= size[end] <= 35e-6) for end in (0, -1)] == list(is_worn)
    assert [size[end] < 1e-15 for end in (0, -1)] == [not there for there in is_worn]


def test_the_magnetometer_is_late_by_the_drawn_delay():
    world = draw(6, replace(IDEAL, delay_s=0.01))
    seen = rotation.rotate(world.q_earth_sensor[:-2], world.chunk.magnetometer_t[0, 2:])
    np.testing.assert_allclose(seen, np.tile(seen[0], (len(seen), 1)), atol=1e-14)


@pytest.mark.parametrize("declared", [True, False])
def test_the_clip_level_is_the_edge_of_the_pile(declared):
    world = draw(8, replace(IDEAL, grade="consumer", clip="gyroscope", is_range_declared=declared))
    values = np.abs(world.chunk.gyroscope_radps[0])
    assert values.max() == world.gyroscope_clip_radps
    at_edge = (values >= 0.999 * world.gyroscope_clip_radps).any(axis=1)
    assert (values == values.max()).sum() > 3
    flagged = (world.chunk.quality[0] & SampleQuality.SATURATED) != 0
    np.testing.assert_array_equal(flagged, at_edge & declared)
    assert world.accelerometer_clip_mps2 is None


def test_a_calibration_spreads_the_pile():
    world = draw(8, replace(IDEAL, grade="laboratory", clip="gyroscope"))
    values = np.abs(world.chunk.gyroscope_radps[0])
    near = values[values > 0.96 * world.gyroscope_clip_radps]
    assert len(np.unique(near)) > 3
    assert values.max() != world.gyroscope_clip_radps


def test_lost_samples_are_flagged():
    world = draw(9, replace(IDEAL, loss="long", duration_s=100.0))
    quality = world.chunk.quality[0]
    missing = (quality & SampleQuality.MISSING) != 0
    assert missing.any()
    assert (quality & SampleQuality.BRIDGED).any()
    np.testing.assert_array_equal(np.isnan(world.chunk.gyroscope_radps[0]).any(axis=1), missing)
    np.testing.assert_array_equal(world.is_measured, ~missing)
    assert len(world.q_earth_sensor) == world.chunk.tick_count


@pytest.mark.parametrize("kind", ["gyroscope", "accelerometer", "magnetometer", "whole"])
def test_what_freezes_repeats_one_value(kind):
    frozen, sound = draw(10, replace(IDEAL, freeze=kind)), draw(10, IDEAL)
    for name in ("gyroscope_radps", "accelerometer_mps2", "magnetometer_t"):
        values, as_it_was = getattr(frozen.chunk, name)[0], getattr(sound.chunk, name)[0]
        changed = np.flatnonzero((values != as_it_was).any(axis=1))
        if kind != "whole" and not name.startswith(kind):
            assert not len(changed)
            continue
        assert 0.3 < len(changed) / 200.0 <= 5.0
        assert len(np.unique(values[changed], axis=0)) == 1
    assert frozen.is_measured.all() == (kind != "whole")


def test_errors_grow_with_the_grade():
    def sizes(grade):
        found = []
        for seed in range(12):
            chunk = draw(
                seed, replace(IDEAL, motion="none", grade=grade, duration_s=5.0, is_warming=True)
            ).chunk
            force = np.linalg.norm(chunk.accelerometer_mps2[0], axis=1)
            found.append((np.abs(chunk.gyroscope_radps).mean(), np.abs(force - GRAVITY_MPS2).mean()))
        return np.median(found, axis=0)

    ordered = [sizes(grade) for grade in ("laboratory", "usual", "consumer")]
    assert (ordered[0] < ordered[1]).all()
    assert (ordered[1] < ordered[2]).all()


def test_jitter_moves_stamps_and_not_the_grid():
    world = draw(14, replace(IDEAL, jitter=0.1))
    even = draw(14, IDEAL)
    assert world.chunk.first_tick == 0
    assert world.chunk.tick_count == even.chunk.tick_count
    apart = np.abs(world.chunk.accelerometer_mps2 - even.chunk.accelerometer_mps2)
    assert 0.0 < apart.mean() < 0.1 * np.abs(np.diff(even.chunk.accelerometer_mps2, axis=1)).max()


def test_the_same_seed_gives_the_same_bits():
    first, again, other = draw(21), draw(21), draw(22)
    for name in ("gyroscope_radps", "accelerometer_mps2", "quality"):
        np.testing.assert_array_equal(getattr(first.chunk, name), getattr(again.chunk, name))
    np.testing.assert_array_equal(first.q_earth_sensor, again.q_earth_sensor)
    assert first.conditions == again.conditions == conditions_of(21)
    assert other.conditions != first.conditions
    # A device of another grade in the same world is moved in the same way.
    np.testing.assert_array_equal(
        draw(21, replace(first.conditions, grade="ideal")).q_earth_sensor, first.q_earth_sensor
    )


def test_every_condition_is_drawn():
    drawn = [conditions_of(seed) for seed in range(200)]
    assert {row for one in drawn for row in one.rows()} == set(ROWS)
    for pack in range(0, 200, 20):
        assert Counter(one.motion for one in drawn[pack : pack + 20]) == MOTIONS
    assert {one.dip_rad > 0.0 for one in drawn} == {True, False}
    assert max(abs(one.dip_rad) for one in drawn) < np.radians(85.0)
    assert {25e-6 <= one.strength_t <= 65e-6 for one in drawn} == {True}
    assert {one.is_averaging for one in drawn} == {one.is_range_declared for one in drawn} == {True, False}
    assert {one.delay_s > 0.0 for one in drawn} == {one.jitter > 0.0 for one in drawn} == {True, False}
    assert all(one.rest_s == one.duration_s for one in drawn if one.motion == "none")


def test_nobody_tunes_on_the_worlds_that_judge(monkeypatch):
    before = [world_seed(seed) for seed in (0, TUNING_SEEDS - 1, TUNING_SEEDS, 123_456_789)]
    assert before[:2] == [0, TUNING_SEEDS - 1]
    assert min(before[2:]) >= TUNING_SEEDS
    monkeypatch.setattr(orientation.TelemotionEstimator, "version", "another")
    after = [world_seed(seed) for seed in (0, TUNING_SEEDS - 1, TUNING_SEEDS, 123_456_789)]
    assert after[:2] == before[:2]
    assert not set(after[2:]) & set(before[2:])
