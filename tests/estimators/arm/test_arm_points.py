"""Position covariance against sampled spread and NEES; velocities and accelerations against exact truth."""

from dataclasses import fields, replace

import numpy as np
import pytest

from estimators import rotation
from estimators.arm import (
    ArmModel,
    BodyDimensions,
    LengthSigma,
    arm_points,
    point_covariance,
    point_motion,
    segments_from_angles,
)
from estimators.arm.published import angular_velocity, joint_centres, point_chain
from estimators.conventions import PLACEMENTS
from estimators.errors import SetupError, ShapeError
from estimators.simulation import ArmScenario, MovementStyle, Schedule, simulate_arm
from estimators.simulation.arm.body import MovingBody
from estimators.simulation.arm.exercises import EXERCISES
from estimators.simulation.arm.movements import perform

SEVEN = (
    "sternum",
    "upper_arm_left",
    "forearm_left",
    "hand_left",
    "upper_arm_right",
    "forearm_right",
    "hand_right",
)
BODY = BodyDimensions()
DRAWS = 20_000


def posture():
    angles = {
        "thorax_humerus_right_yxy_plane_of_elevation": 1.0,
        "thorax_humerus_right_yxy_elevation": 1.1,
        "thorax_humerus_right_yxy_axial_rotation": -0.6,
        "humerus_forearm_right_zxy_flexion": 0.9,
        "humerus_forearm_right_zxy_pronation": 1.2,
        "forearm_hand_right_zxy_flexion": 0.3,
        "thorax_humerus_left_yxy_elevation": 0.4,
        "humerus_forearm_left_zxy_flexion": 0.5,
        "trunk_lean_forward_rad": 0.3,
    }
    return segments_from_angles(angles)


def drawn(worn, covariance, length_sigma, rng):
    """Truth as the filter's error model has it: turned and lengthened from the estimate; positions per draw."""
    truth = posture()
    turned = {}
    for g, name in enumerate(worn):
        error = rng.multivariate_normal(np.zeros(3), covariance[g], DRAWS)
        turned[name] = rotation.multiply(rotation.exp(error), truth[name])
    points = {}
    # Positions are linear in the lengths: one evaluation a length gives the direction to go.
    base = joint_centres(turned, BODY)
    steps = {}
    for f in fields(LengthSigma):
        if f.name == "head_m":
            continue
        longer = joint_centres(turned, replace(BODY, **{f.name: getattr(BODY, f.name) + 0.01}))
        steps[f.name] = (longer, rng.normal(size=(DRAWS, 1)) * getattr(length_sigma, f.name))
    for name, position in base.items():
        moved = position.copy()
        for longer, amount in steps.values():
            moved = moved + (longer[name] - position) / 0.01 * amount
        points[name] = moved
    return {name: truth[name] for name in worn}, points


def nees(worn, covariance, length_sigma, rng, **options):
    estimate, truth = drawn(worn, covariance, length_sigma, rng)
    q = np.stack([estimate[name] for name in worn])[None]
    found = point_covariance(q, worn, BODY, covariance[None], length_sigma, **options)
    result = {}
    for p, name in enumerate(found.points):
        error = truth[name] - found.position_m[0, p]
        if options.get("origin") == "shoulder":
            error -= truth[f"shoulder_{name.rpartition('_')[2]}"]
        matrix = found.covariance_m2[0, p]
        result[name] = (
            np.einsum("ni,ij,nj->n", error, np.linalg.inv(matrix), error),
            error.T @ error / DRAWS,
            matrix,
        )
    return result


@pytest.mark.parametrize("origin", ["room", "shoulder"])
@pytest.mark.parametrize("worn", [SEVEN, ("sternum", "upper_arm_right", "forearm_right")], ids=len)
def test_covariance_is_the_sampled_spread(worn, origin):
    """20,000 draws of every orientation and length: covariance to 4 percent of its size, NEES 3 to 2 percent.

    Orientation errors of 2 to 4 degrees with correlated axes; a standard error of a variance is 1 percent here.
    """
    rng = np.random.default_rng(70)
    roots = np.radians(2.0) * rng.normal(size=(len(worn), 3, 3))
    covariance = roots @ np.swapaxes(roots, -1, -2)
    found = nees(worn, covariance, LengthSigma(), rng, origin=origin)
    assert set(found) == set(arm_points(worn))
    for name, (squares, spread, matrix) in found.items():
        np.testing.assert_allclose(spread, matrix, atol=0.04 * np.trace(matrix), err_msg=name)
        assert squares.mean() == pytest.approx(3.0, rel=0.03), name
        # 95 % of chi-square with 3 degrees of freedom.
        assert (squares < 7.815).mean() == pytest.approx(0.95, abs=0.01), name


def test_a_heading_error_of_fifteen_degrees_stays_honest():
    """To first order the reach would be known to its length alone, 1 cm; 15 degrees take 2 cm off it."""
    worn = ("upper_arm_right", "forearm_right")
    covariance = np.zeros((2, 3, 3))
    covariance[:, 2, 2] = np.radians(15.0) ** 2
    covariance[:, 0, 0] = covariance[:, 1, 1] = np.radians(1.0) ** 2
    found = nees(worn, covariance, LengthSigma(), np.random.default_rng(71))
    for name, (squares, _, _) in found.items():
        assert 2.0 < squares.mean() < 3.5, (name, squares.mean())
        assert 0.92 < (squares < 7.815).mean() < 1.0, name


def test_what_is_unknown_is_as_large_as_the_arm_and_no_larger():
    worn = ("upper_arm_right", "forearm_right")
    q = np.stack([posture()[name] for name in worn])[None]
    found = point_covariance(
        q, worn, BODY, np.full((1, 2, 3), np.pi), LengthSigma(0, 0, 0, 0, 0, 0), origin="shoulder"
    )
    reach = np.sqrt(2.0) * np.array([BODY.upper_arm_m, np.hypot(BODY.upper_arm_m, BODY.forearm_m)])
    np.testing.assert_allclose(found.sigma_m[0, :2], reach, rtol=1e-9)
    assert (np.linalg.eigvalsh(found.covariance_m2) > -1e-12).all()


def test_without_errors_there_is_no_covariance_and_lengths_act_along_the_bone():
    worn = ("upper_arm_right", "forearm_right")
    q = np.stack([posture()[name] for name in worn])[None]
    exact = LengthSigma(0, 0, 0, 0, 0, 0)
    assert not point_covariance(q, worn, BODY, np.zeros((1, 2, 3)), exact).covariance_m2.any()
    still = np.zeros((1, 2, 3))
    width = LengthSigma(trunk_m=0, shoulder_width_m=0.03, upper_arm_m=0, forearm_m=0, hand_m=0)
    assert not point_covariance(q, worn, BODY, still, width, origin="shoulder").covariance_m2.any()
    from_hips = point_covariance(q, worn, BODY, still, width).covariance_m2[0, 0]
    np.testing.assert_allclose(from_hips, np.diag([0, 0.015**2, 0]), atol=1e-15)
    along = rotation.rotate(q[0, 0], (0.0, 0.0, -1.0))
    bone = LengthSigma(trunk_m=0, shoulder_width_m=0, upper_arm_m=0.02, forearm_m=0, hand_m=0)
    matrix = point_covariance(q, worn, BODY, still, bone, origin="shoulder").covariance_m2[0, 0]
    np.testing.assert_allclose(matrix, 0.02**2 * np.outer(along, along), atol=1e-15)


def test_positions_are_those_of_the_model_for_every_set_of_sensors():
    rng = np.random.default_rng(72)
    for worn in (
        SEVEN,
        PLACEMENTS,
        ("upper_arm_left", "forearm_left"),
        ("shoulder_right", "upper_arm_right"),
    ):
        q = rotation.normalize(rng.normal(size=(20, len(worn), 4)))
        model = ArmModel(BODY, worn, 0.01)
        truth = model.evaluate(q)
        found = point_covariance(q, worn, BODY, np.zeros((20, len(worn), 3)), points=model.points)
        np.testing.assert_allclose(found.position_m, truth.point_room_m, atol=1e-12)
        moving = point_motion(q, worn, BODY, 0.01, points=model.points)
        np.testing.assert_allclose(moving.position_m, truth.point_room_m, atol=1e-12)


def test_a_gap_is_a_gap():
    q = np.broadcast_to(rotation.identity(), (60, 2, 4)).copy()
    q[20:30, 1] = np.nan
    worn = ("upper_arm_right", "forearm_right")
    found = point_covariance(q, worn, BODY, np.full((60, 2, 3), 0.02))
    assert np.isnan(found.covariance_m2[20:30, 1:]).all()
    assert np.isfinite(found.covariance_m2[:, 0]).all()
    moving = point_motion(q, worn, BODY, 0.01)
    assert np.isnan(moving.acceleration_mps2[20:30, 1:]).all()
    assert np.isfinite(moving.acceleration_mps2[30:]).all()
    q[0:3] = np.nan
    q[7:10] = np.nan
    assert np.isnan(point_motion(q, worn, BODY, 0.01).velocity_mps[3:7]).all(), "four ticks are too few"


def exact_paths(scenario):
    """Joint centres of the simulated person with exact velocity and acceleration: the next segment's origin."""
    performance = perform(
        EXERCISES[scenario.exercise], scenario.style, scenario.schedule,
        both_arms=False, sway_rad=scenario.sway_rad, n_pose_error_rad=0.0, seed=scenario.seed,
    )  # fmt: skip
    person = MovingBody(scenario.body, performance.timeline, "right", scenario.sway_rad, scenario.seed)
    ticks = round(performance.end_s * scenario.rate_hz)
    motions = person.at(np.arange(ticks) / scenario.rate_hz)
    omega = np.stack([motions[name].turn.rate for name in PLACEMENTS], axis=1)
    return {
        "elbow_right": motions["forearm_right"].origin,
        "wrist_right": motions["hand_right"].origin,
    }, omega


@pytest.mark.parametrize("exercise", ["reaching", "drinking"])
def test_motion_of_elbow_and_wrist_is_that_of_the_simulated_person(exercise):
    scenario = ArmScenario(
        exercise=exercise, schedule=Schedule(n_pose_s=2.0, repetitions=3), errors="ideal", seed=4
    )
    truth = simulate_arm(scenario).truth.frames
    paths, omega = exact_paths(scenario)
    names = tuple(paths)
    given = (truth.q_room_segment, truth.layout.segments, scenario.body, truth.time_step_s)
    from_rates = point_motion(*given, omega, points=names)
    from_frames = point_motion(*given, points=names)
    quick = point_motion(*given, omega, points=names, acceleration_window_s=0.15)
    for p, path in enumerate(paths.values()):
        np.testing.assert_allclose(from_rates.position_m[:, p], path.position, atol=1e-12)
        np.testing.assert_allclose(from_rates.velocity_mps[:, p], path.velocity, atol=1e-9)
        speed = np.linalg.norm(path.velocity, axis=-1).max()
        assert speed > 0.3
        # Local cubics over 0.11 s of a movement of about a second.
        assert np.abs(from_frames.velocity_mps[:, p] - path.velocity).max() < 0.02 * speed
        peak = np.linalg.norm(path.acceleration, axis=-1).max()
        inside = slice(30, -30)
        error = np.linalg.norm(from_rates.acceleration_mps2[:, p] - path.acceleration, axis=-1)[inside]
        assert np.sqrt(np.mean(error**2)) < 0.06 * peak
        sharper = np.linalg.norm(quick.acceleration_mps2[:, p] - path.acceleration, axis=-1)[inside]
        assert sharper.max() < 0.1 * peak
        assert sharper.max() < error.max()


def test_speed_of_the_hand_is_the_pipelines_scalar():
    scenario = ArmScenario(
        schedule=Schedule(n_pose_s=2.0, repetitions=2), style=MovementStyle(tremor_rad=0.02), seed=5
    )
    truth = simulate_arm(scenario).truth.frames
    _, omega = exact_paths(scenario)
    found = point_motion(
        truth.q_room_segment,
        truth.layout.segments,
        scenario.body,
        truth.time_step_s,
        omega,
        points=("hand_right",),
    )
    scalar = truth.scalar[:, truth.layout.scalars.index("hand_speed_right_mps")]
    np.testing.assert_allclose(np.linalg.norm(found.velocity_mps[:, 0], axis=-1), scalar, atol=1e-9)


def test_rates_from_orientations_alone():
    rate = np.array([0.4, -1.2, 2.0])
    time_s = np.arange(200) * 0.01
    q = rotation.multiply(rotation.exp(time_s[:, None] * rate), rotation.exp(np.array([0.3, 0.4, 0.5])))
    q[::2] *= -1.0
    # A cubic over 0.11 s of a turn at 2.4 rad/s, half angle: (1.2 * 0.055)^4 / 24, relative.
    np.testing.assert_allclose(angular_velocity(q, 0.01), np.broadcast_to(rate, (200, 3)), atol=1e-4)


def test_what_does_not_fit_is_refused_in_words():
    q = rotation.identity((4, 2))
    worn = ("upper_arm_right", "forearm_right")
    with pytest.raises(SetupError, match="no point"):
        point_chain("knee_left", worn)
    with pytest.raises(SetupError, match="wrist_left needs a sensor"):
        point_chain("wrist_left", ("upper_arm_left",))
    with pytest.raises(ShapeError, match="need"):
        point_covariance(q[:, :1], worn, BODY, np.zeros((4, 2, 3)))
    with pytest.raises(ShapeError, match="sigma"):
        point_covariance(q, worn, BODY, np.zeros((4, 3)))
    with pytest.raises(ShapeError, match="turning rates"):
        point_motion(q, worn, BODY, 0.01, np.zeros((4, 3)))
    with pytest.raises(SetupError, match="metres"):
        LengthSigma(upper_arm_m=10.0)
