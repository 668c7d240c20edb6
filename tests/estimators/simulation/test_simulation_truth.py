"""The truth is exact: signals integrate to it, derivatives match, angles are those that were asked for."""

import numpy as np
import pytest
from scipy.signal import savgol_filter

from estimators import rotation
from estimators.conventions import GRAVITY_MPS2, PLACEMENTS
from estimators.simulation import (
    ArmScenario,
    EarthField,
    MovementStyle,
    Schedule,
    SensorErrors,
    TriadErrors,
    simulate_arm,
)
from estimators.simulation.arm.exercises import EXERCISES
from estimators.simulation.arm.movements import perform
from estimators.simulation.arm.timeline import minimum_jerk, submovements

LIVELY = MovementStyle(
    speed=1.4,
    tremor_rad=0.03,
    trunk_lean_rad=0.2,
    trunk_lateral_rad=0.1,
    trunk_rotation_rad=0.15,
    shoulder_hike_rad=0.2,
    submovements=3,
)


def session(**changes):
    defaults = {
        "style": LIVELY,
        "placements": PLACEMENTS,
        "errors": "ideal",
        "schedule": Schedule(n_pose_s=1.0, repetitions=None, duration_s=60.0),
        "seed": 50,
    }
    return simulate_arm(ArmScenario(**(defaults | changes)))


def test_mean_rate_gyroscope_integrates_to_the_true_orientation():
    """60 s of every sensor: the sum of turns is the truth to rounding (6000 steps of 1e-16, and log/exp)."""
    one = session()
    turn = rotation.exp(
        0.01 * np.stack([signals.gyroscope_radps[1:] for signals in one.recording.sensors.values()])
    )
    truth = one.truth.q_earth_sensor
    q = truth[:, 0]
    for step in np.moveaxis(turn, 1, 0):
        q = rotation.multiply(q, step)
    assert np.max(rotation.angle_between(q, truth[:, -1])) < 1e-10


@pytest.mark.slow
def test_instantaneous_gyroscope_integrates_to_the_true_orientation():
    """The analytic rate itself, by a fourth-order Magnus step over 400 Hz samples: < 1e-4 rad after 60 s.

    With Simpson's rule for the mean rate and the commutator term (Blanes et al. 2009) a step of h = 5 ms errs
    by about h^5 w'''' / 2880; the kinks of jerk at the ends of transitions lower the order to three there.
    """
    instant = SensorErrors(gyroscope_sampling="instant")
    one = session(errors=instant, rate_hz=400.0)
    truth = one.truth.q_earth_sensor
    w = np.stack([signals.gyroscope_radps for signals in one.recording.sensors.values()])
    h = 2.0 / 400.0
    first, middle, last = w[:, :-2:2], w[:, 1:-1:2], w[:, 2::2]
    turn = h / 6.0 * (first + 4.0 * middle + last) + h**2 / 12.0 * np.cross(first, last)
    q = truth[:, 0]
    for step in np.moveaxis(rotation.exp(turn), 1, 0):
        q = rotation.multiply(q, step)
    assert np.max(rotation.angle_between(q, truth[:, 2 * turn.shape[1]])) < 1e-4


def test_specific_force_is_the_second_derivative_of_position_plus_gravity():
    """Central differences at 1 kHz, error h^2/12 x''''.

    Tremor of 5.65 Hz and 0.03 rad over 0.6 m has a fourth derivative of 0.02 * 35^4 = 3e4: 2.4e-3 m/s^2.
    Where transitions meet the jerk jumps by some 300 m/s^3: h/6 of it, 5e-2.
    """
    one = session(rate_hz=1000.0, schedule=Schedule(n_pose_s=1.0, repetitions=2), exercise="drinking")
    up = np.array([0.0, 0.0, GRAVITY_MPS2])
    q_room_earth = rotation.about_z(-one.truth.facing_rad)
    for s, signals in enumerate(one.recording.sensors.values()):
        p = one.truth.sensor_room_m[s]
        numeric = (p[2:] - 2.0 * p[1:-1] + p[:-2]) * 1000.0**2
        q_room_sensor = rotation.multiply(q_room_earth, one.truth.q_earth_sensor[s][1:-1])
        felt = rotation.rotate(q_room_sensor, signals.accelerometer_mps2[1:-1]) - up
        error = np.abs(felt - numeric)
        assert np.sqrt(np.mean(error**2)) < 3e-3
        assert error.max() < 5e-2
        # and it is not all rest: the hand of the acting arm really accelerates
    hand = one.truth.sensor_acceleration_mps2[PLACEMENTS.index("hand_right")]
    assert np.abs(hand).max() > 3.0


def test_velocity_is_the_derivative_of_position():
    one = session(rate_hz=1000.0, schedule=Schedule(n_pose_s=1.0, repetitions=1))
    p, v = one.truth.sensor_room_m, one.truth.sensor_velocity_mps
    # h^2/6 x''': 0.02 * 35^3 / 6e6
    np.testing.assert_allclose((p[:, 2:] - p[:, :-2]) * 500.0, v[:, 1:-1], atol=1e-3)


def test_magnetometer_reads_the_field_of_the_earth():
    one = session(
        earth_field=EarthField(norm_t=52e-6, dip_rad=1.1), schedule=Schedule(n_pose_s=1.0, repetitions=1)
    )
    expected = 52e-6 * np.array([0.0, np.cos(1.1), -np.sin(1.1)])
    for s, signals in enumerate(one.recording.sensors.values()):
        seen = rotation.rotate(one.truth.q_earth_sensor[s], signals.magnetometer_t)
        np.testing.assert_allclose(seen, np.broadcast_to(expected, seen.shape), atol=1e-18)


def test_true_angles_are_the_coordinates_that_the_exercise_asked_for():
    """The truth's angles come from orientations through the arm model, the timeline never saw either."""
    scenario = ArmScenario(
        exercise="drinking", style=LIVELY, seed=51, schedule=Schedule(n_pose_s=1.0, repetitions=2)
    )
    one = simulate_arm(scenario)
    timeline = perform(
        EXERCISES["drinking"], LIVELY, scenario.schedule,
        both_arms=False, sway_rad=scenario.sway_rad, n_pose_error_rad=0.0, seed=51,
    ).timeline  # fmt: skip
    coordinate = timeline.at(one.truth.time_s)
    sound = one.truth.frames.angle_flags[:, one.truth.frames.layout.angles.index(
        "thorax_humerus_right_yxy_plane_of_elevation")] == 0  # fmt: skip
    assert sound.mean() > 0.7
    pairs = {
        0: "trunk_lean_forward_rad",
        1: "trunk_lean_lateral_rad",
        2: "trunk_axial_rotation_rad",
        4: "thorax_humerus_right_yxy_plane_of_elevation",
        5: "thorax_humerus_right_yxy_elevation",
        6: "thorax_humerus_right_yxy_axial_rotation",
        7: "humerus_forearm_right_zxy_flexion",
        8: "humerus_forearm_right_zxy_carrying",
        9: "humerus_forearm_right_zxy_pronation",
        10: "forearm_hand_right_zxy_flexion",
        11: "forearm_hand_right_zxy_deviation",
        12: "forearm_hand_right_zxy_rotation",
    }
    for column, name in pairs.items():
        np.testing.assert_allclose(
            one.truth.angle_rad(name)[sound], coordinate[column].value[sound], atol=1e-9
        )


def test_true_points_move_with_the_sensors_and_hand_speed_is_their_derivative():
    one = session(rate_hz=1000.0, schedule=Schedule(n_pose_s=1.0, repetitions=1))
    hand = one.truth.point_room_m("hand_right")
    numeric = np.linalg.norm((hand[2:] - hand[:-2]) * 500.0, axis=1)
    np.testing.assert_allclose(one.truth.angle_rad("hand_speed_right_mps")[1:-1], numeric, atol=2e-3)
    hike = one.truth.angle_rad("shoulder_hike_right_m")
    assert hike.max() == pytest.approx(0.18 * np.sin(0.2), abs=0.005)


def test_minimum_jerk_and_submovements_join_smoothly():
    phase = np.linspace(-0.2, 1.2, 14001)
    for count in (1, 2, 3, 5):
        step = submovements(phase, np.full(phase.shape, count))
        assert step.value[0] == 0.0
        assert step.value[-1] == pytest.approx(1.0, abs=1e-12)
        assert (np.diff(step.value) >= -1e-15).all()
        h = phase[1] - phase[0]
        np.testing.assert_allclose((step.value[2:] - step.value[:-2]) / (2 * h), step.rate[1:-1], atol=2e-4)
        np.testing.assert_allclose(
            (step.rate[2:] - step.rate[:-2]) / (2 * h), step.acceleration[1:-1], atol=0.2
        )
        peaks = np.flatnonzero((step.rate[1:-1] > step.rate[:-2]) & (step.rate[1:-1] >= step.rate[2:]))
        assert len(peaks) == count
    assert minimum_jerk(np.array([0.5])).rate[0] == pytest.approx(1.875)


def test_tremor_appears_at_its_frequency_only_after_the_n_pose():
    one = session(
        style=MovementStyle(tremor_rad=0.05, tremor_hz=6.0),
        schedule=Schedule(n_pose_s=10.0, repetitions=5),
        exercise="pronation",
    )
    angle = one.truth.angle_rad("humerus_forearm_right_zxy_pronation")
    rest = angle - savgol_filter(angle, 41, 3)
    assert rest[100:900].std() < 1e-4
    late = rest[1300:]
    spectrum = np.abs(np.fft.rfft(late * np.hanning(late.size)))
    assert np.fft.rfftfreq(late.size, 0.01)[spectrum.argmax()] == pytest.approx(6.0, abs=0.2)


def test_random_walk_and_noise_have_the_size_that_is_asked_for():
    walk = TriadErrors(noise_sd=(0.01, 0.02, 0.03), random_walk_per_root_s=0.002)
    rng = np.random.default_rng(52)
    time_s = np.arange(0, 100, 0.01)
    ends = np.array([walk.bias_over(time_s, rng)[-1] for _ in range(300)])
    # 900 draws: standard error of the SD 2.4 percent.
    assert ends.std() == pytest.approx(0.002 * np.sqrt(100.0), rel=0.1)
    noisy = walk.apply(np.zeros((10_000, 3)), np.zeros((10_000, 3)), rng)
    np.testing.assert_allclose(noisy.std(axis=0), [0.01, 0.02, 0.03], rtol=0.05)
    counts = TriadErrors(resolution=0.25, limit=1.0).apply(
        np.linspace(-3, 3, 30).reshape(10, 3), np.zeros(3), rng
    )
    np.testing.assert_array_equal(np.round(counts / 0.25), counts / 0.25)
    assert np.abs(counts).max() == 1.0
