"""Two instrumented shoes live, against the simulator's truth."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from pipeline_contract import PipelineContract

from estimators import pipelines
from estimators.balance import _live_balance_kernel as balance
from estimators.balance import base_of_support
from estimators.balance.published import margin_to_edge
from estimators.conventions import SIDES
from estimators.orientation import OrientationFlag
from estimators.pipelines import BodyDimensions, SessionSetup
from estimators.recording import ImuChunk, SampleQuality
from estimators.simulation import Bout, Leg, gait_preset, simulate_gait

SHOES = ("heel_left", "forefoot_left", "heel_right", "forefoot_right")
RATE_HZ = 100.0
NOT_TARED, MISSING, IMPLAUSIBLE = 1.0, 2.0, 3.0


@cache
def walk(preset="centre_of_mass", seed=0, steps=18):
    scenario = replace(gait_preset(preset, seed), rate_hz=RATE_HZ, course=(Bout((Leg(steps),), 3.0),))
    return simulate_gait(scenario)


def chunk_of(simulated, names=SHOES):
    worn = [simulated.recording.sensors[name] for name in names]
    gyroscope = np.stack([sensor.gyroscope_radps for sensor in worn])
    return ImuChunk(
        0,
        1.0 / RATE_HZ,
        gyroscope,
        np.stack([sensor.accelerometer_mps2 for sensor in worn]),
        None,
        np.zeros(gyroscope.shape[:2], dtype=np.uint8),
        force_n=np.stack([sensor.force_n for sensor in worn]),
        moment_nm=np.stack([sensor.moment_nm for sensor in worn]),
    )


def setup_of(**changes):
    body = BodyDimensions(stature_m=1.8)
    return SessionSetup("gait", SHOES, RATE_HZ, body=body, feet_apart_m=0.18, **changes)


def seen(chunk):
    """Return the live frames as if they were not late, by name, and the pipeline's delay."""
    pipeline = pipelines.create(setup_of())
    frames, late = pipeline.step(chunk), pipeline.delay_ticks
    columns = {name: frames.point_room_m[late:, i] for i, name in enumerate(frames.layout.points)}
    return columns | {name: frames.scalar[late:, i] for i, name in enumerate(frames.layout.scalars)}


class TestShoePipeline(PipelineContract):
    @pytest.fixture
    def setup(self):
        return setup_of()

    @pytest.fixture
    def chunk(self):
        # From the last of standing to the fifth second of walking, with a gap of the link and one of a cell.
        whole = chunk_of(walk()).ticks(150, 850)
        whole = replace(whole, first_tick=0)
        gyroscope, quality, force = whole.gyroscope_radps.copy(), whole.quality.copy(), whole.force_n.copy()
        gyroscope[0, 520:530], force[:, 520:530] = np.nan, np.nan
        quality[0, 520:530] = SampleQuality.MISSING
        force[2, 600:606] = np.nan
        return replace(whole, gyroscope_radps=gyroscope, quality=quality, force_n=force)

    def test_state_is_small_arrays(self, setup, chunk):
        pipeline = pipelines.create(setup)
        pipeline.step(chunk)
        assert sum(values.nbytes for values in pipeline.state().values()) < 4 * 30_000


def test_mass_and_pressure_follow_the_truth():
    simulated = walk()
    found, truth = seen(chunk_of(simulated)), simulated.truth
    count = len(found["body_mass_kg"])
    known = np.isfinite(found["centre_of_mass"][:, 0])
    # From the first strides of both feet to the end, in the room of the simulation up to half a degree.
    first = int(np.flatnonzero(known)[0])
    assert first / RATE_HZ < truth.step_land_s[2] + 1.0
    assert known[first:].all()
    mass, pressure = truth.com.position[:count], truth.cop_m[:count]
    turned = _course_of(found["centre_of_mass"][known], mass[known])
    assert abs(turned) < np.radians(1.5)
    for name, true in (("centre_of_mass", mass), ("centre_of_pressure", pressure)):
        apart = found[name][known] - true[known]
        assert np.sqrt(np.mean((apart - apart.mean(axis=0))[:, :2] ** 2)) < 0.03, name
    # Relative to each other they do not depend on how the room is turned.
    lean = (found["centre_of_mass"] - found["centre_of_pressure"] - mass + pressure)[known]
    assert np.sqrt(np.mean(lean[:, :2] ** 2)) < 0.015
    assert np.nanmax(np.abs(found["centre_of_mass_sigma_m"][first + 100 :])) < 0.02
    assert found["body_mass_kg"][-1] == pytest.approx(truth.mass_kg, rel=0.02)
    for side in SIDES:
        felt, true = found[f"foot_{side}_force_z_n"], truth.feet[side].force_n[:count, 2]
        assert np.sqrt(np.nanmean((felt - true) ** 2)) < 0.02 * 9.81 * truth.mass_kg
        toe_out = found[f"foot_{side}_toe_out_rad"]
        assert np.isnan(toe_out[0])
        assert np.degrees(toe_out[-1]) == pytest.approx(10.0, abs=3.0)


def _course_of(found, true):
    a, b = found[:, :2] - found[:, :2].mean(axis=0), true[:, :2] - true[:, :2].mean(axis=0)
    return float(np.arctan2(np.sum(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]), np.sum(a * b)))


def test_a_large_zero_is_found_in_the_first_swing():
    chunk = chunk_of(walk())
    force = chunk.force_n + np.array([5.0, -4.0, 40.0])
    plain, offset = seen(chunk), seen(replace(chunk, force_n=force))
    state = offset["foot_left_force_state"]
    tared = np.flatnonzero(state == 0.0)
    assert (state[: tared[0]] == NOT_TARED).all()
    assert np.isnan(offset["centre_of_mass"][: tared[0]]).all()
    later = slice(tared[0] + 1, None)
    np.testing.assert_allclose(
        offset["foot_left_force_z_n"][later], plain["foot_left_force_z_n"][later], atol=0.5
    )
    assert offset["body_mass_kg"][-1] == pytest.approx(plain["body_mass_kg"][-1], rel=0.01)


def test_a_missing_cell_is_said_and_not_guessed():
    chunk = chunk_of(walk())
    force = chunk.force_n.copy()
    force[3, 1000:1300] = np.nan
    found = seen(replace(chunk, force_n=force))
    lost = slice(1000, 1300)
    assert (found["foot_right_force_state"][lost] == MISSING).all()
    assert np.isnan(found["foot_right_force_z_n"][lost]).all()
    assert np.isnan(found["pressure_right"][lost]).all()
    assert np.isfinite(found["foot_left_force_z_n"][lost]).all()
    assert np.isnan(found["centre_of_pressure"][lost]).all()
    # The centre of mass goes on for three tenths of a second, and comes back with the forces.
    assert np.isnan(found["centre_of_mass"][1040:1300]).all()
    back = found["centre_of_mass"][1400:]
    assert np.isfinite(back).all()
    # The feet are followed all the same.
    assert np.isfinite(found["foot_right"][lost]).all()


@pytest.mark.slow
@pytest.mark.parametrize("lost", [(0, 1, 2, 3), (2,)])
def test_a_long_gap_loses_the_place_until_the_feet_go_together_again(lost):
    simulated, rows, gap = walk(steps=30), list(lost), slice(900, 1080)
    whole = chunk_of(simulated)
    gyroscope, quality, force = whole.gyroscope_radps.copy(), whole.quality.copy(), whole.force_n.copy()
    gyroscope[rows, gap], force[rows, gap] = np.nan, np.nan
    quality[rows, gap] = SampleQuality.MISSING
    cut = replace(whole, gyroscope_radps=gyroscope, quality=quality, force_n=force)
    found, unharmed = seen(cut), seen(whole)
    pipeline = pipelines.create(setup_of())
    frames, late = pipeline.step(cut), pipeline.delay_ticks
    unsure = (frames.segment_flags[late:] & OrientationFlag.HEADING_NOT_TRUSTED) != 0
    assert not unsure[: gap.start].any()
    assert unsure[gap.stop : gap.stop + 100, 1].all()
    # Beside a foot that was not lost the other is found again; if both were, the room of before stays lost.
    assert unsure[-1].tolist() == [len(lost) == 4] * 2
    # Strides are those of a walk without a gap, and balance comes back with the second of each foot.
    for side in SIDES:
        strides, wanted = (
            np.unique(one[f"foot_{side}_stride_length_m"][gap.stop + 300 :].round(6))
            for one in (found, unharmed)
        )
        np.testing.assert_allclose(strides, wanted, atol=0.01)
    truth, count = simulated.truth, len(found["body_mass_kg"])
    lean = found["centre_of_mass"] - found["centre_of_pressure"]
    error = (lean - truth.com.position[:count] + truth.cop_m[:count])[gap.stop + 330 :, :2]
    assert np.isfinite(error).all()
    assert np.sqrt(np.mean(error**2, axis=0)).max() < 0.015
    apart = (found["foot_left"] - found["foot_right"])[-1]
    assert apart[1] == pytest.approx((unharmed["foot_left"] - unharmed["foot_right"])[-1, 1], abs=0.05)


def test_without_forces_the_feet_are_followed():
    chunk = chunk_of(walk())
    found = seen(replace(chunk, force_n=None, moment_nm=None))
    with_forces = seen(chunk)
    assert (found["foot_left_force_state"] == MISSING).all()
    assert np.isnan(found["centre_of_mass"]).all()
    np.testing.assert_array_equal(found["foot_left"], with_forces["foot_left"])
    np.testing.assert_array_equal(found["foot_left_toe_out_rad"], with_forces["foot_left_toe_out_rad"])


@pytest.mark.parametrize("factor", [0.1, 8.0])
def test_forces_that_carry_nobody_are_implausible(factor):
    chunk = chunk_of(walk())
    force = chunk.force_n.copy()
    force[2:4] *= factor
    found = seen(replace(chunk, force_n=force))
    assert (found["foot_right_force_state"][-300:] == IMPLAUSIBLE).all()
    assert (found["foot_left_force_state"][-300:] == 0.0).all()
    assert np.isnan(found["centre_of_mass"][-300:]).all()


def test_the_margin_is_that_of_the_hull():
    rng = np.random.default_rng(4)
    corners = rng.normal(size=(2, 40, 8, 2))
    corners[1, ::3] = np.nan
    corners[0, :10, 4:] = np.nan
    corners[:, -1] = np.nan
    points = 1.5 * rng.normal(size=(40, 2))
    shift, hull = np.array([0.3, -0.2]), np.empty((18, 2))
    for k in range(40):
        ours = balance._margin(corners, k, *shift, *points[k], hull)
        wanted = margin_to_edge(points[k], base_of_support([corners[0, k], corners[1, k] + shift]))
        np.testing.assert_allclose(ours, wanted, rtol=1e-9)


def test_one_foot_alone_is_followed_as_before():
    names = ("heel_left", "forefoot_left")
    pipeline = pipelines.create(SessionSetup("gait", names, RATE_HZ))
    frames = pipeline.step(chunk_of(walk(), names))
    assert frames.layout.points == ("foot_left",)
    toe_out = frames.scalar[:, frames.layout.scalars.index("foot_left_toe_out_rad")]
    assert np.degrees(toe_out[-1]) == pytest.approx(10.0, abs=4.0)


def test_the_filter_equals_its_dense_form():
    rng = np.random.default_rng(3)
    h = 0.01
    settings = np.zeros(balance.SETTINGS)
    settings[balance.S_STEP] = h
    noise = {"S_FORCE2": 0.02, "S_BIAS2": 0.003, "S_WANDER2": 0.01}
    for name, value in noise.items():
        settings[getattr(balance, name)] = value
    root = rng.normal(size=(4, 4))
    p, x = root @ root.T, rng.normal(size=(2, 4))
    transition = np.eye(4)
    transition[0, 1], transition[0, 2], transition[1, 2] = h, -0.5 * h * h, -h
    process = np.zeros((4, 4))
    process[:2, :2] = 0.02 * np.array([[h**3 / 3, h**2 / 2], [h**2 / 2, h]])
    process[2, 2], process[3, 3] = 0.003 * h, 0.01 * h
    wanted = transition @ p @ transition.T + process
    balance._predict(settings, x, p, 0.0, 0.0, True)
    np.testing.assert_allclose(p, wanted, rtol=1e-12)
    row, values, variance = np.array([1.0, 0.0, 0.0, -0.4]), np.array([0.3, -0.2]), 0.05
    gain = p @ row / (row @ p @ row + variance)
    wanted_x, wanted_p = x + np.outer(values - x @ row, gain), p - np.outer(gain, row @ p)
    balance._measure(x, p, row, *values, variance)
    np.testing.assert_allclose(x, wanted_x, rtol=1e-12)
    np.testing.assert_allclose(p, wanted_p, rtol=1e-10, atol=1e-12)
