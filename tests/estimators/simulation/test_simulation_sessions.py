"""Whole sessions: N-pose, repetitions, mirror and facing, seeds, patients, mounting, speed."""

import time
from dataclasses import replace

import numpy as np
import pytest

from estimators import rotation
from estimators.conventions import GRAVITY_MPS2, PLACEMENTS
from estimators.errors import SetupError
from estimators.simulation import (
    EXERCISES,
    SENSOR_PRESETS,
    ArmScenario,
    Magnet,
    Mounting,
    MovementStyle,
    Schedule,
    SensorClocks,
    demonstration_scenario,
    outward_mounting,
    simulate_arm,
    style_of_impairment,
)

SHORT = Schedule(n_pose_s=3.0, repetitions=2)
MIRRORED = np.array([1.0, -1.0, 1.0, -1.0])


def swapped(name):
    if "left" in name:
        return name.replace("left", "right")
    return name.replace("right", "left")


@pytest.mark.parametrize("exercise", EXERCISES)
def test_every_exercise_starts_in_the_n_pose_and_moves_only_within_repetitions(exercise):
    one = simulate_arm(
        ArmScenario(exercise=exercise, schedule=Schedule(repetitions=3), sway_rad=0.0, errors="ideal")
    )
    truth = one.truth
    still = truth.time_s < 10.0
    q = {name: truth.frames.q_room_segment[still, i] for i, name in enumerate(truth.frames.layout.segments)}
    for name, segment in q.items():
        turn = (
            {"r": np.pi / 2, "l": -np.pi / 2}[name.split("_")[1][0]]
            if name.startswith(("forearm", "hand"))
            else 0.0
        )
        assert rotation.angle_between(segment, rotation.about_z(turn)).max() < 1e-12
    assert len(truth.repetitions_s) == 3
    speed = truth.angle_rad("hand_speed_right_mps")
    inside = np.zeros(truth.time_s.size, dtype=bool)
    for start, end in truth.repetitions_s:
        inside |= (truth.time_s >= start) & (truth.time_s < end)
    after = truth.time_s > 11.6
    if exercise != "pronation":
        assert speed[inside].max() > 0.3
    # Repetitions are rounded to ticks: up to half a tick of motion lies outside.
    assert speed[after & ~inside].max() < 1e-3
    main = truth.angle_rad(EXERCISES[exercise].primary_channel.format(side="right"))
    assert np.ptp(main[inside]) > np.radians(40)
    assert speed[still].max() == 0.0
    other = truth.angle_rad("hand_speed_left_mps")
    # It hangs from a trunk that leans a little.
    assert other[after].max() < 0.2


def test_the_same_seed_gives_the_same_bits_and_another_seed_another_session():
    scenario = ArmScenario(schedule=SHORT, style=style_of_impairment(0.5), seed=7)
    one, again = simulate_arm(scenario), simulate_arm(scenario)
    other = simulate_arm(replace(scenario, seed=8))
    for name, signals in one.recording.sensors.items():
        same = again.recording.sensors[name]
        np.testing.assert_array_equal(signals.gyroscope_radps, same.gyroscope_radps)
        np.testing.assert_array_equal(signals.accelerometer_mps2, same.accelerometer_mps2)
        np.testing.assert_array_equal(signals.magnetometer_t, same.magnetometer_t)
        assert signals.gyroscope_radps.shape != other.recording.sensors[name].gyroscope_radps.shape or (
            not np.array_equal(signals.gyroscope_radps, other.recording.sensors[name].gyroscope_radps)
        )
    np.testing.assert_array_equal(one.truth.frames.angle_rad, again.truth.frames.angle_rad)


def test_a_sensor_reads_the_same_whoever_else_is_worn():
    few = simulate_arm(ArmScenario(schedule=SHORT, placements=("hand_right", "upper_arm_right")))
    many = simulate_arm(ArmScenario(schedule=SHORT, placements=PLACEMENTS))
    for name in few.recording.sensors:
        np.testing.assert_array_equal(
            few.recording.sensors[name].gyroscope_radps, many.recording.sensors[name].gyroscope_radps
        )


@pytest.mark.parametrize("exercise", ["drinking", "abduction"])
def test_a_mirrored_patient_gives_the_mirrored_truth(exercise):
    style = style_of_impairment(0.6)
    right = simulate_arm(ArmScenario(exercise=exercise, side="right", style=style, schedule=SHORT, seed=3))
    left = simulate_arm(ArmScenario(exercise=exercise, side="left", style=style, schedule=SHORT, seed=3))
    a, b = right.truth.frames, left.truth.frames
    for i, name in enumerate(a.layout.segments):
        other = b.q_room_segment[:, b.layout.segments.index(swapped(name))]
        assert rotation.angle_between(a.q_room_segment[:, i] * MIRRORED, other).max() < 1e-12
    for i, name in enumerate(a.layout.points):
        other = b.point_room_m[:, b.layout.points.index(swapped(name))]
        np.testing.assert_allclose(a.point_room_m[:, i] * [1, -1, 1], other, atol=1e-12)
    for name in a.layout.angles:
        np.testing.assert_allclose(
            right.truth.angle_rad(name), left.truth.angle_rad(swapped(name)), atol=1e-9
        )
    for name, sign in (
        ("trunk_lean_forward_rad", 1), ("trunk_lean_lateral_rad", -1), ("trunk_axial_rotation_rad", -1),
        ("shoulder_hike_right_m", 1), ("hand_speed_right_mps", 1),
    ):  # fmt: skip
        other = left.truth.angle_rad(swapped(name))
        np.testing.assert_allclose(sign * right.truth.angle_rad(name), other, atol=1e-12)
    np.testing.assert_array_equal(right.truth.repetitions_s, left.truth.repetitions_s)


def test_facing_elsewhere_turns_headings_and_nothing_else():
    one = simulate_arm(ArmScenario(schedule=SHORT, facing_rad=0.0))
    turned = simulate_arm(ArmScenario(schedule=SHORT, facing_rad=1.9))
    np.testing.assert_array_equal(one.truth.frames.q_room_segment, turned.truth.frames.q_room_segment)
    np.testing.assert_array_equal(one.truth.frames.angle_rad, turned.truth.frames.angle_rad)
    expected = rotation.multiply(rotation.about_z(1.9), one.truth.q_earth_sensor)
    assert rotation.angle_between(expected, turned.truth.q_earth_sensor).max() < 1e-12
    for name, signals in one.recording.sensors.items():
        other = turned.recording.sensors[name]
        np.testing.assert_array_equal(signals.gyroscope_radps, other.gyroscope_radps)
        np.testing.assert_array_equal(signals.accelerometer_mps2, other.accelerometer_mps2)
        assert np.abs(signals.magnetometer_t - other.magnetometer_t).max() > 1e-5


def test_both_arms_mirror_each_other_but_for_their_sway():
    one = simulate_arm(ArmScenario(exercise="flexion", both_arms=True, schedule=SHORT, sway_rad=0.0))
    for name in one.truth.frames.layout.angles:
        if "left" in name:
            np.testing.assert_allclose(
                one.truth.angle_rad(name), one.truth.angle_rad(swapped(name)), atol=1e-9, err_msg=name
            )


def test_recording_setup_and_truth_fit_together():
    one = simulate_arm(ArmScenario(schedule=SHORT, placements=PLACEMENTS, rate_hz=50.0))
    assert one.setup.placements == one.recording.placements == PLACEMENTS
    assert one.setup.calibration is None
    assert one.setup.rate_hz == one.recording.nominal_rate_hz == 50.0
    for s, (name, signals) in enumerate(one.recording.sensors.items()):
        np.testing.assert_allclose(signals.time_s, one.truth.time_s)
        q = rotation.multiply(one.truth.q_earth_sensor[s], one.truth.q_sensor_segment[name])
        q = rotation.multiply(rotation.about_z(-one.truth.facing_rad), q)
        g = one.truth.frames.layout.segments.index(name)
        assert rotation.angle_between(q, one.truth.frames.q_room_segment[:, g]).max() < 1e-7
    np.testing.assert_allclose(
        one.truth.repetitions_s * 50.0, np.round(one.truth.repetitions_s * 50.0), atol=1e-9
    )


def test_default_mounting_points_outward_in_the_n_pose():
    outward = {
        "sternum": (1, 0, 0), "head": (1, 0, 0), "pelvis": (1, 0, 0), "upper_arm_right": (0, -1, 0),
        "forearm_right": (0, -1, 0), "hand_right": (0, -1, 0), "upper_arm_left": (0, 1, 0),
        "forearm_left": (0, 1, 0), "hand_left": (0, 1, 0), "thigh_left": (0, 1, 0), "shank_right": (0, -1, 0),
        "foot_left": (0.6, 0, 0.8), "shoulder_right": (0, -1, 0),
    }  # fmt: skip
    one = simulate_arm(
        ArmScenario(placements=tuple(outward), schedule=SHORT, sway_rad=0.0, facing_rad=0.0,
                    mounting=Mounting(misalignment_sd_rad=0.0))
    )  # fmt: skip
    for s, direction in enumerate(outward.values()):
        z = rotation.rotate(one.truth.q_earth_sensor[s, 0], (0.0, 0.0, 1.0))
        np.testing.assert_allclose(z, direction, atol=1e-12)
    tilted = simulate_arm(ArmScenario(schedule=SHORT, seed=5))
    for name, q in tilted.truth.q_sensor_segment.items():
        off = np.degrees(rotation.angle_between(rotation.conjugate(q), outward_mounting(name)))
        # Three axes of 3 degrees: 5 on average, 20 is four standard deviations off.
        assert 0.1 < off < 20.0


def test_the_rule_is_the_one_that_the_n_pose_calibration_expects():
    from estimators.calibration._mounting import OUTWARD_HEADING_RAD

    one = simulate_arm(
        ArmScenario(
            placements=PLACEMENTS,
            schedule=SHORT,
            sway_rad=0.0,
            facing_rad=0.0,
            mounting=Mounting(misalignment_sd_rad=0.0),
        )
    )
    for s, name in enumerate(PLACEMENTS):
        z = rotation.rotate(one.truth.q_earth_sensor[s, 0], (0.0, 0.0, 1.0))
        assert np.arctan2(z[1], z[0]) == pytest.approx(OUTWARD_HEADING_RAD[name], abs=1e-9)


def test_arbitrary_mounting_and_lever_arm_are_taken_as_given():
    q = tuple(rotation.normalize(np.array([0.2, -0.5, 0.7, 0.4])))
    mounting = Mounting(q_segment_sensor={"hand_right": q}, offset_m={"hand_right": (0.0, 0.0, 0.0)})
    one = simulate_arm(ArmScenario(schedule=SHORT, mounting=mounting))
    np.testing.assert_allclose(rotation.conjugate(one.truth.q_sensor_segment["hand_right"]), q, atol=1e-12)
    s = one.setup.placements.index("hand_right")
    np.testing.assert_allclose(one.truth.sensor_room_m[s], one.truth.point_room_m("wrist_right"), atol=1e-12)


def test_marzouk_preset_reproduces_the_printed_statistics():
    """Still sensor, mean and SD against T2.1, T2.2, T2.4. 6000 samples: SE of the SD 1 %."""
    assert SENSOR_PRESETS["marzouk_2009"].gyroscope.noise_sd[0] == pytest.approx(np.radians(0.4960))
    scenario = ArmScenario(
        errors="marzouk_2009", schedule=Schedule(n_pose_s=60.0, repetitions=1), sway_rad=0.0,
        placements=("sternum",), mounting=Mounting(misalignment_sd_rad=0.0),
    )  # fmt: skip
    one = simulate_arm(scenario)
    signals = one.recording.sensors["sternum"]
    still = signals.time_s < 60.0
    gyroscope = np.degrees(signals.gyroscope_radps[still])
    np.testing.assert_allclose(gyroscope.mean(axis=0), [-0.8229, 0.7879, 0.5597], atol=0.03)
    np.testing.assert_allclose(gyroscope.std(axis=0), [0.4960, 0.6001, 0.5181], rtol=0.05)
    force = signals.accelerometer_mps2[still] / GRAVITY_MPS2
    # The printed means are gravity positive and contain gravity on z; here x points down: -1 on x.
    np.testing.assert_allclose(force.mean(axis=0), [0.0158 - 1.0, -0.0068, -0.0176], atol=1e-3)
    np.testing.assert_allclose(force.std(axis=0), [0.0169, 0.0134, 0.01469], rtol=0.05)
    field = signals.magnetometer_t[still] / 49e-6
    np.testing.assert_allclose(field.std(axis=0), [0.0031, 0.0131, 0.0302], rtol=0.05)


def test_a_magnet_bends_the_field_of_the_nearest_sensor_while_it_is_near():
    base = ArmScenario(errors="ideal", schedule=SHORT, sway_rad=0.0)
    clean = simulate_arm(base)
    hand = clean.truth.sensor_room_m[base.placements.index("hand_right"), 0]
    magnet = Magnet(
        (0.5, 0.0, 0.5), near_m=tuple(np.add(hand, (0.10, -0.05, 0.0))), arrive_s=0.5, leave_s=2.0, move_s=0.3
    )
    bent = simulate_arm(replace(base, magnets=(magnet,)))
    change = {
        name: np.linalg.norm(bent.recording.sensors[name].magnetometer_t - s.magnetometer_t, axis=1)
        for name, s in clean.recording.sensors.items()
    }
    near = (clean.truth.time_s > 0.9) & (clean.truth.time_s < 1.9)
    assert change["hand_right"][near].min() > 20e-6
    # r^-3: the hand is 11 cm away, every other sensor at least twice as far.
    assert (
        max(change[name][near].max() for name in change if name != "hand_right")
        < change["hand_right"][near].min()
    )
    assert change["hand_right"][clean.truth.time_s < 0.5].max() < 1e-8
    assert change["hand_right"][clean.truth.time_s > 2.5].max() < 1e-8


def test_sensors_with_their_own_clocks_sample_at_other_instants():
    common = simulate_arm(ArmScenario(errors="ideal", schedule=SHORT))
    own = simulate_arm(
        ArmScenario(errors="ideal", schedule=SHORT, clocks=SensorClocks(skew_sd=1e-4, offset_sd_s=0.005))
    )
    name = "forearm_right"
    a, b = common.recording.sensors[name], own.recording.sensors[name]
    np.testing.assert_array_equal(a.time_s, b.time_s)
    difference = np.abs(a.gyroscope_radps - b.gyroscope_radps).max()
    # A few ms of offset at angular accelerations of some 10 rad/s^2.
    assert 1e-3 < difference < 1.0
    np.testing.assert_array_equal(common.truth.frames.angle_rad, own.truth.frames.angle_rad)


@pytest.mark.slow
def test_impairment_shows_in_range_speed_trunk_and_progress_takes_it_back():
    def measures(patient, progress, seed):
        one = simulate_arm(demonstration_scenario(patient, "reaching", progress=progress, seed=seed))
        truth = one.truth
        start, end = truth.repetitions_s[0]
        inside = (truth.time_s >= start) & (truth.time_s < end)
        return (
            np.ptp(truth.angle_rad("humerus_forearm_right_zxy_flexion")[inside]),
            end - start,
            truth.angle_rad("trunk_lean_forward_rad")[inside].max(),
        )

    people = [("moderate_stroke", 0.0), ("mild_stroke", 0.0), ("therapist_template", 0.0)]
    ranges, durations, leans = np.array([measures(*person, seed=1) for person in people]).T
    assert (np.diff(ranges) > 0).all()
    assert (np.diff(leans) < 0).all()
    assert durations[0] > durations[1]
    recovery = np.array(
        [[measures("moderate_stroke", p, seed) for p in (0.0, 0.5, 1.0)] for seed in range(4)]
    )
    ranges, _, leans = np.moveaxis(recovery.mean(axis=0), -1, 0)
    assert (np.diff(ranges) > np.radians(2)).all()
    assert (np.diff(leans) < -np.radians(2)).all()


def test_fatigue_takes_range_from_the_later_repetitions():
    style = MovementStyle(
        fatigue_amplitude=0.4, fatigue_speed=0.3, amplitude_sd=0.0, duration_sd=0.0, posture_sd_rad=0.0
    )
    truth = simulate_arm(
        ArmScenario(exercise="abduction", style=style, schedule=Schedule(n_pose_s=1, repetitions=4))
    ).truth
    elevation = truth.angle_rad("thorax_humerus_right_yxy_elevation")
    peaks = [elevation[(truth.time_s >= a) & (truth.time_s < b)].max() for a, b in truth.repetitions_s]
    assert (np.diff(peaks) < -np.radians(5)).all()
    rest = np.radians(8)
    assert (peaks[-1] - rest) / (peaks[0] - rest) == pytest.approx(0.6, abs=0.02)
    assert (np.diff(np.diff(truth.repetitions_s)[:, 0]) > 0).all()


def test_contradictions_are_refused_in_words():
    for scenario, words in (
        (ArmScenario(schedule=Schedule(repetitions=3, duration_s=20.0)), "just one of"),
        (ArmScenario(schedule=Schedule(repetitions=None, duration_s=12.0)), "fits"),
        (ArmScenario(exercise="juggling"), "juggling"),
        (ArmScenario(errors="perfect"), "perfect"),
        (ArmScenario(placements=("hand_right", "hand_right")), "different"),
        (ArmScenario(rate_hz=0.0), "rate_hz"),
        (ArmScenario(seed=-1), "seed"),
    ):
        with pytest.raises(SetupError, match=words):
            simulate_arm(scenario)
    with pytest.raises(SetupError, match="amplitude"):
        MovementStyle(amplitude=0.0)
    with pytest.raises(SetupError, match="impairment"):
        style_of_impairment(2.0)
    with pytest.raises(SetupError, match="nobody"):
        demonstration_scenario("superman", "reaching")
    with pytest.raises(SetupError, match="progress"):
        demonstration_scenario("mild_stroke", "reaching", progress=2.0)


@pytest.mark.slow
def test_ten_minutes_of_two_arms_take_less_than_twenty_seconds():
    start = time.perf_counter()
    one = simulate_arm(ArmScenario(both_arms=True, schedule=Schedule(repetitions=None, duration_s=600.0)))
    assert one.recording.duration_s == pytest.approx(600.0, abs=0.02)
    assert time.perf_counter() - start < 20.0
