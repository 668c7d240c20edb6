"""The instrumented shoe: identities of loads, centre of pressure and joint moments, and a whole walk."""

from dataclasses import replace

import numpy as np
import pytest

from estimators import rotation
from estimators.conventions import GRAVITY_MPS2, SIDES
from estimators.errors import ShapeError
from estimators.kinetics import (
    FootSegment,
    ShoeGeometry,
    ShoeLoads,
    ShoeParameters,
    ShoePose,
    analyse_shoe,
    ground_reaction,
)
from estimators.kinetics.published import (
    ankle_load,
    calibrate_load_cell,
    environment_power,
    hinge_load,
    is_inside_sole,
    pressure_point,
    shoe_contact,
    tare,
    unloaded,
    work_j,
)
from estimators.simulation import gait_preset, simulate_gait
from tests.said import refuses
from validation.shoes.ankle_shoe import score_shoe, stride_errors

SHOE = ShoeGeometry()


@pytest.fixture(scope="module")
def walk():
    return simulate_gait(replace(gait_preset("ankle", 2), errors="ideal"))


@pytest.fixture(scope="module")
def scene():
    """Random poses and loads: nothing of walking in them."""
    rng = np.random.default_rng(1)
    n = 50
    pose = ShoePose(
        rotation.exp(rng.normal(size=(n, 3))), rotation.exp(rng.normal(size=(n, 3))),
        rng.normal(size=(n, 3)), rng.normal(size=(n, 3)), rng.normal(size=(n, 3)), rng.normal(size=(n, 3)),
        rng.normal(size=(n, 3)), rng.normal(size=(n, 3)) + np.array([0.0, 0.0, 9.8]), np.ones(n, dtype=bool),
    )  # fmt: skip
    up = rng.normal(size=(2, n, 3)) * 20.0 + [0.0, 0.0, 400.0]
    back = rotation.conjugate(np.stack((pose.q_room_heel, pose.q_room_forefoot)))
    force, moment = rotation.rotate(back, up), rng.normal(size=(2, n, 3)) * 5.0
    return pose, ShoeLoads(force[0], moment[0], force[1], moment[1])


def test_the_compiled_reaction_equals_plain_numpy(scene):
    pose, loads = scene
    floor = np.linspace(-0.1, 0.1, 50)
    found = ground_reaction(loads, pose, floor_m=floor, least_n=400.0)
    force = rotation.rotate(pose.q_room_heel, loads.heel_force_n)
    moment = rotation.rotate(pose.q_room_heel, loads.heel_moment_nm) + np.cross(pose.heel_m, force)
    np.testing.assert_allclose(found.heel_cop_m, pressure_point(force, moment, floor, 400.0)[0], rtol=1e-10)
    fore = rotation.rotate(pose.q_room_forefoot, loads.forefoot_force_n)
    fore_moment = rotation.rotate(pose.q_room_forefoot, loads.forefoot_moment_nm)
    fore_moment += np.cross(pose.forefoot_m, fore)
    np.testing.assert_allclose(found.forefoot_moment_nm, fore_moment, rtol=1e-10, atol=1e-9)
    np.testing.assert_allclose(found.force_n, force + fore, rtol=1e-12, atol=1e-9)
    cop, free = pressure_point(force + fore, moment + fore_moment, floor, 400.0)
    np.testing.assert_allclose(found.cop_m, cop, rtol=1e-10)
    np.testing.assert_allclose(found.free_moment_nm, free, rtol=1e-8)
    assert 0 < np.isnan(found.heel_cop_m[:, 0]).sum() < 50
    np.testing.assert_allclose(found.forefoot_share, fore[:, 2] / (force + fore)[:, 2], rtol=1e-10)


def test_pressure_point_leaves_only_the_vertical_moment():
    rng = np.random.default_rng(2)
    force, moment = rng.normal(size=(40, 3)) * 50 + [0, 0, 600], rng.normal(size=(40, 3)) * 80
    floor = rng.normal(size=40) * 0.1
    point, free = pressure_point(force, moment, floor, 20.0)
    rest = moment - np.cross(point, force)
    np.testing.assert_allclose(rest[:, :2], 0.0, atol=1e-10)
    np.testing.assert_allclose(rest[:, 2], free, atol=1e-10)
    # E2: a floor taken 30 mm too high with shear of 0.15 body weight is exactly 4.5 mm.
    one = np.array([[0.15, 0.0, 1.0]]) * 667.0
    right = pressure_point(one, np.zeros((1, 3)), np.array([0.0]), 20.0)[0]
    wrong = pressure_point(one, np.zeros((1, 3)), np.array([0.03]), 20.0)[0]
    assert wrong[0, 0] - right[0, 0] == pytest.approx(0.0045, abs=1e-12)
    assert np.isnan(pressure_point(0.01 * one, np.zeros((1, 3)), np.array([0.0]), 20.0)[0]).all()


def test_turning_the_room_turns_vectors_and_keeps_powers(scene):
    pose, loads = scene
    turned = pose.moved(0.7, np.zeros(3))
    shank = np.random.default_rng(3).normal(size=(50, 3))
    turn = rotation.about_z(0.7)
    one, two = ground_reaction(loads, pose), ground_reaction(loads, turned)
    np.testing.assert_allclose(rotation.rotate(turn, one.force_n), two.force_n, atol=1e-9)
    np.testing.assert_allclose(rotation.rotate(turn, one.cop_m), two.cop_m, atol=1e-9)
    np.testing.assert_allclose(one.free_moment_nm, two.free_moment_nm, atol=1e-9)
    for foot in (None, FootSegment(1.2)):
        a = ankle_load(one, pose, shank, 100.0, SHOE, foot)
        b = ankle_load(two, turned, rotation.rotate(turn, shank), 100.0, SHOE, foot)
        np.testing.assert_allclose(rotation.rotate(turn, a.moment_nm), b.moment_nm, atol=1e-8)
        np.testing.assert_allclose(a.power_w, b.power_w, atol=1e-8)
    np.testing.assert_allclose(hinge_load(one, pose).power_w, hinge_load(two, turned).power_w, atol=1e-9)


def test_shifting_the_origin_moves_the_pressure_centre_and_no_joint_moment(scene):
    pose, loads = scene
    shank = np.zeros((50, 3))
    shift = np.array([3.0, -2.0, 0.0])
    one, two = ground_reaction(loads, pose), ground_reaction(loads, pose.moved(0.0, shift))
    np.testing.assert_allclose(two.cop_m - one.cop_m, np.broadcast_to(shift, (50, 3)), atol=1e-9)
    a = ankle_load(one, pose, shank, 100.0)
    b = ankle_load(two, pose.moved(0.0, shift), shank, 100.0)
    np.testing.assert_allclose(a.moment_nm, b.moment_nm, atol=1e-9)


def test_load_scales_and_a_split_between_the_cells_changes_nothing(scene):
    pose, loads = scene
    one, three = ground_reaction(loads, pose), ground_reaction(loads.scaled(3.0), pose)
    np.testing.assert_allclose(three.cop_m, one.cop_m, atol=1e-9)
    np.testing.assert_allclose(three.force_n, 3.0 * one.force_n, rtol=1e-12)
    # Move a part of the load from the heel to the forefoot cell, with the same resultant.
    part = np.random.default_rng(4).normal(size=(50, 3)) * 30.0
    moment = np.cross(pose.heel_m - pose.forefoot_m, part)
    to_heel, to_forefoot = rotation.conjugate(pose.q_room_heel), rotation.conjugate(pose.q_room_forefoot)
    moved = ShoeLoads(
        loads.heel_force_n - rotation.rotate(to_heel, part), loads.heel_moment_nm,
        loads.forefoot_force_n + rotation.rotate(to_forefoot, part),
        loads.forefoot_moment_nm + rotation.rotate(to_forefoot, moment),
    )  # fmt: skip
    two = ground_reaction(moved, pose)
    np.testing.assert_allclose(two.force_n, one.force_n, atol=1e-9)
    np.testing.assert_allclose(two.cop_m, one.cop_m, atol=1e-9)


def test_ankle_offset_error_is_its_cross_product_with_the_force(scene):
    pose, loads = scene
    reaction = ground_reaction(loads, pose)
    off = np.array([0.007, 0.0, 0.0])
    other = replace(SHOE, ankle_m=tuple(np.array(SHOE.ankle_m) + off))
    shank = np.zeros((50, 3))
    change = (
        ankle_load(reaction, pose, shank, 100.0, other).moment_nm
        - ankle_load(reaction, pose, shank, 100.0, SHOE).moment_nm
    )
    expected = np.cross(rotation.rotate(pose.q_room_heel, off), reaction.force_n)
    np.testing.assert_allclose(change, expected, atol=1e-9)
    massless = ankle_load(reaction, pose, shank, 100.0, SHOE, FootSegment(0.0, inertia_kgm2=(0.0, 0.0, 0.0)))
    np.testing.assert_allclose(
        massless.moment_nm, ankle_load(reaction, pose, shank, 100.0, SHOE).moment_nm, atol=1e-12
    )


def test_rate_of_angular_momentum_needs_the_gyroscopic_term():
    """E6: R (I w' + w x I w) is the rate of R I w for a body that tumbles about all axes."""
    rate_hz, inertia = 2000.0, np.array([0.001, 0.006, 0.004])
    time = np.arange(400) / rate_hz
    vector = np.column_stack((np.sin(9 * time), np.cos(7 * time), 2.0 * time))
    q = rotation.exp(vector)
    rate = np.gradient(q, 1.0 / rate_hz, axis=0)
    own = 2.0 * rotation.multiply(rotation.conjugate(q), rate)[:, 1:]
    room = rotation.rotate(q, own)
    zero = np.zeros((400, 3))
    pose = ShoePose(q, q, room, room, zero, zero, zero, zero, np.ones(400, dtype=bool))
    nothing = ShoeLoads(zero, zero, zero, zero)
    segment = FootSegment(0.0, (0.0, 0.0, 0.0), tuple(inertia))
    found = ankle_load(ground_reaction(nothing, pose), pose, zero, rate_hz, SHOE, segment).moment_nm
    momentum = rotation.rotate(q, inertia * own)
    expected = np.gradient(momentum, 1.0 / rate_hz, axis=0)
    inner = slice(100, 300)
    assert np.abs(found - expected)[inner].max() < 0.002 * np.abs(expected[inner]).max()
    without = rotation.rotate(q, inertia * np.gradient(own, 1.0 / rate_hz, axis=0))
    assert np.abs(without - expected)[inner].max() > 0.1 * np.abs(expected[inner]).max()


def test_calibration_matrix_comes_back_and_poor_loads_are_refused():
    rng = np.random.default_rng(5)
    matrix = np.diag([80.0, 80.0, 160.0, 3.0, 3.0, 2.0]) + rng.normal(size=(6, 6)) * 0.5
    offset = rng.normal(size=6) * 0.1
    output = rng.normal(size=(40, 6))
    load = (output - offset) @ matrix.T
    found = calibrate_load_cell(output, load)
    np.testing.assert_allclose(found.matrix, matrix, atol=1e-8)
    np.testing.assert_allclose(found.offset, offset, atol=1e-9)
    np.testing.assert_allclose(found.apply(output), load, atol=1e-8)
    assert found.residual.max() < 1e-9
    output[:, 4] = output[:, 3]
    with refuses("shoes.loads_alike"):
        calibrate_load_cell(output, load)
    with refuses("shoes.few_loads"):
        calibrate_load_cell(output[:5], load[:5])
    with pytest.raises(ShapeError):
        calibrate_load_cell(output[:, :5], load)


def test_taring_follows_a_drifting_zero():
    time = np.arange(1000) / 100.0
    load = np.zeros((1000, 6))
    stands = (time % 1.2) < 0.7
    load[stands, 2] = 700.0
    zero = np.array([2.0, -1.0, 3.0, 0.05, -0.02, 0.1]) + np.outer(time, [0.2, 0.0, -0.3, 0.0, 0.0, 0.0])
    found = tare(load + zero, unloaded((load + zero)[:, :3]), 100.0)
    # Linear between the middles of swings, so a linear drift is followed exactly there.
    inner = (time > 1.0) & (time < 9.0)
    np.testing.assert_allclose(found[inner], load[inner], atol=1e-9)
    np.testing.assert_array_equal(tare(load + 700.0, np.zeros(1000, dtype=bool), 100.0), load + 700.0)


def test_contact_has_hysteresis_and_no_flicker():
    force = np.concatenate((np.zeros(50), np.full(50, 300.0), np.zeros(50)))
    force[[20, 70]] = 100.0, 0.0
    force[99] = 15.0
    found = shoe_contact(force, np.roll(force, 10), 100.0)
    np.testing.assert_array_equal(found.heel_down, [50])
    np.testing.assert_array_equal(found.heel_off, [100])
    np.testing.assert_array_equal(found.land, [50])
    np.testing.assert_array_equal(found.lift, [110])
    np.testing.assert_array_equal(found.flat, [[60, 100]])
    assert found.core[0].tolist() == [70, 90]


def test_whole_walk_against_the_truth(walk):
    """Without sensor errors what is left is the 15 Hz filter; thresholds are three times the measured values."""
    for side in SIDES:
        scored = score_shoe(walk.recording, walk.truth, side, ShoeParameters())
        found = stride_errors(scored)
        assert found["force"] < 0.003
        assert found["pressure centre"] < 1.0
        assert found["ankle moment, share"] < 1.5
        assert found["ankle power, share"] < 2.0
        assert found["hinge power"] < 0.005
        shoe = scored.shoe
        assert is_inside_sole(shoe.reaction.cop_m, shoe.pose, SHOE)[scored.stance].all()
        # The ground does no work on a foot that rolls without slip.
        velocity = np.gradient(shoe.pose.forefoot_m, 1.0 / shoe.rate_hz, axis=0)
        power = environment_power(shoe.loads, shoe.pose, velocity)
        weight = walk.truth.mass_kg * GRAVITY_MPS2
        flat = np.zeros(power.size, dtype=bool)
        for a, b in shoe.contact.core[1:-1]:
            flat[a:b] = True
        assert np.abs(power[flat]).max() < 0.02 * weight
        generated, absorbed = work_j(shoe.ankle.power_w[scored.stance], shoe.rate_hz)
        assert generated > 5.0
        assert absorbed < 0.0


def test_a_foot_with_mass_is_closer_to_the_truth_than_a_massless_one(walk):
    found = {}
    for name, foot in (("massless", None), ("heavy", FootSegment(1.2))):
        parameters = ShoeParameters(foot=foot)
        scored = score_shoe(walk.recording, walk.truth, "left", parameters)
        found[name] = stride_errors(scored)["ankle moment"]
    assert found["heavy"] < 0.7 * found["massless"]


def test_mirrored_walk_gives_mirrored_results():
    scenario = replace(gait_preset("ankle", 7), errors="ideal")
    one, two = simulate_gait(scenario), simulate_gait(scenario.mirrored())
    results = []
    for recording, side in ((one.recording, "left"), (two.recording, "right")):
        s = recording.sensors
        results.append(analyse_shoe(s[f"heel_{side}"], s[f"forefoot_{side}"], s[f"shank_{side}"]))
    a, b = results
    flip = np.array([1.0, -1.0, 1.0])
    np.testing.assert_allclose(a.reaction.cop_m * flip, b.reaction.cop_m, atol=1e-8)
    np.testing.assert_allclose(a.ankle.moment_nm * -flip, b.ankle.moment_nm, atol=1e-6)
    np.testing.assert_allclose(a.ankle.power_w, b.ankle.power_w, atol=1e-6)


def test_unusable_shoes_are_refused_in_words(walk):
    sensors = walk.recording.sensors
    heel, forefoot = sensors["heel_left"], sensors["forefoot_left"]
    with refuses("shoes.no_cell"):
        analyse_shoe(sensors["shank_left"], forefoot)
    with refuses("shoes.time_bases"):
        analyse_shoe(heel, replace(forefoot, time_s=forefoot.time_s + 0.001))
    with refuses("shoes.no_stance"):
        analyse_shoe(replace(heel, force_n=np.zeros_like(heel.force_n)), forefoot)
