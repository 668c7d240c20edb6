import numpy as np
import pytest
from foot_twin import back, there
from foot_walk import foot_walk
from scipy.spatial.transform import Rotation

from estimators import rotation
from estimators.errors import SetupError, ShapeError
from estimators.gait import FootFlag, FootParameters, find_stance, foot_parameters, smooth
from estimators.gait._stance import gravity_scale, noise, resting_bias
from estimators.gait._stance_kernel import local_minimum, moving_percentile, stance_statistic
from estimators.gait.foot.filter import level, start_covariance
from estimators.recording import SensorSignals
from tests.said import refuses

RATE = 100.0


def heading_free(trajectory, walk):
    """Largest distance after the one turn about z that the start leaves open."""
    turn = rotation.multiply(walk.q_world_sensor[0], rotation.conjugate(trajectory.q_world_sensor[0]))
    moved = rotation.rotate(turn, trajectory.position_m - trajectory.position_m[0])
    return np.linalg.norm(moved - walk.position_m, axis=1)


def test_statistic_and_percentile_equal_plain_numpy():
    random = np.random.default_rng(1)
    gyroscope, force = random.standard_normal((2, 300, 3))
    force[:, 2] += 9.8
    statistic, reference = np.empty(300), np.empty(300)
    stance_statistic(gyroscope, force, 0, 300, 6, 0.3, 0.5, statistic)
    for k in (0, 3, 150, 299):
        window = slice(max(0, k - 6), k + 7)
        f, mean = force[window], force[window].mean(axis=0)
        turning = (gyroscope[window] ** 2).sum(axis=1).mean()
        unsteady = (f**2).sum(axis=1).mean() - mean @ mean + (np.linalg.norm(mean) - 9.80665) ** 2
        assert statistic[k] == pytest.approx(np.sqrt(turning / 0.09 + unsteady / 0.25), rel=1e-12)
    moving_percentile(statistic, 0, 0, 300, 2, 30, 30, 0.05, reference)
    for k in (0, 1, 77, 150, 299):
        centre = k // 2
        grid = np.arange(max(0, centre - 30), min(149, centre + 30) + 1) * 2
        assert reference[k] == pytest.approx(np.percentile(statistic[grid], 5.0), rel=1e-12)


def test_percentile_of_a_buffer_is_that_of_the_whole_record():
    statistic = np.random.default_rng(2).random(400)
    whole, part = np.empty(400), np.empty(400)
    moving_percentile(statistic, 0, 150, 200, 4, 15, 15, 0.05, whole)
    buffer = statistic[85:265].copy()
    moving_percentile(buffer, 85, 150, 200, 4, 15, 15, 0.05, part[85:265])
    np.testing.assert_array_equal(part[150:200], whole[150:200])


def test_noise_and_decision_equal_plain_numpy():
    c = FootParameters(gyroscope_clip_radps=2.0, shock_mps2=11.5)
    random = np.random.default_rng(3)
    gyroscope, force = random.standard_normal((2, 200, 3))
    force[:, 2] += 9.8
    gap_s = np.where(np.arange(200) % 40 < 5, 0.05, 0.0)
    force_variance, rate_variance = noise(gyroscope, force, gap_s, c)
    near = np.clip(np.arange(200)[:, None] + [-1, 0, 1], 0, 199)
    filled = np.sqrt(gap_s / c.gap_scale_s)
    clipped = np.abs(gyroscope[near]).max(axis=1) > 0.99 * 2.0
    shock = np.abs(force[near]).max(axis=(1, 2)) > 11.5
    assert 0.1 < clipped.mean() < 0.9
    assert 0.1 < shock.mean() < 0.9
    rate = np.maximum(np.where(clipped, c.clip_density, c.gyroscope_density), 0.3 * filled[:, None])
    jerk = 0.03 * 0.5 * (gyroscope[near[:, 2]] - gyroscope[near[:, 0]])
    np.testing.assert_allclose(rate_variance, rate**2 + jerk**2, rtol=1e-12)
    density = np.maximum(np.where(shock, c.shock_density, c.accelerometer_density), 5.0 * filled)
    jerk = 0.03 * 0.5 * (force[near[:, 2]] - force[near[:, 0]])
    np.testing.assert_allclose(force_variance, density**2 + (jerk**2).sum(axis=1), rtol=1e-12)

    share = np.linspace(0.0, 0.3, 200)[:, None] ** 2
    stance = find_stance(share * gyroscope, [0.0, 0.0, 9.8] + share * (force - [0.0, 0.0, 9.8]), RATE, c)
    t = stance.statistic
    np.testing.assert_array_equal(stance.is_stance, t < 1.5 * stance.reference)
    np.testing.assert_array_equal(stance.is_standstill, stance.is_stance & (t < c.standstill_limit))
    assert 0.1 < stance.is_standstill.mean() < stance.is_stance.mean() < 0.99
    np.testing.assert_allclose(stance.sigma_mps, (0.003 + 0.015 * t**1.5) * np.sqrt(0.5), rtol=1e-12)


def test_filter_and_smoother_equal_the_plain_numpy_of_the_method_page():
    walk = foot_walk(
        strides=3,
        rise_m=0.02,
        turn_rad=0.4,
        mounting=[0.3, -0.4, 0.9],
        noise=1.0,
        bias_radps=(0.01, -0.02, 0.005),
    )
    c = FootParameters(shock_mps2=14.0, gyroscope_clip_radps=1.0)
    signals = walk.signals
    found = smooth(signals, c, passes=1)
    stance = found.stance
    # The same start and the same gravity scale as the product's.
    force = signals.accelerometer_mps2 * gravity_scale(
        signals.gyroscope_radps, signals.accelerometer_mps2, RATE
    )
    variances = noise(signals.gyroscope_radps, force, np.zeros(len(force)), c)
    assert len(np.unique(variances[0] > 50)) == 2  # impacts and clipping are in it
    assert (variances[1] > 0.9).any()
    bias = resting_bias(signals.gyroscope_radps, stance.statistic, RATE, c.standstill_limit)
    q = Rotation.from_quat(level(force[:10].mean(axis=0)), scalar_first=True)
    start = (np.zeros(3), np.zeros(3), q, bias, np.zeros(3), np.zeros(3))
    log = there(
        start,
        start_covariance(float(stance.statistic[:10].mean()), c),
        np.diff(signals.time_s, prepend=0.0),
        signals.gyroscope_radps,
        force,
        stance.sigma_mps,
        stance.is_stance,
        stance.is_standstill,
        stance.is_height,
        *variances,
        c,
    )
    expected = back(log)
    assert stance.is_standstill.any()
    assert stance.is_height.sum() >= 4
    # Rounding of covariances that span 1e-8 to 9 and of the inverse in the twin; the path is 3.6 m long. The twin
    # composes corrections of attitude one after another where the adjoint adds them: second order in corrections
    # that reach 0.03 rad while the gyroscope is taken for clipped.
    np.testing.assert_allclose(found.position_m, [x[0] for x in expected], atol=2e-4)
    np.testing.assert_allclose(found.velocity_mps, [x[1] for x in expected], atol=5e-4)
    q = np.array([x[2].as_quat(scalar_first=True) for x in expected])
    assert rotation.angle_between(found.q_world_sensor, q).max() < 1e-3
    np.testing.assert_allclose(found.pivot_m, [x[5] for x in expected], atol=5e-4)
    np.testing.assert_allclose(
        found.position_sigma_m**2, [np.diag(e[3])[:3] for e in log], rtol=1e-6, atol=1e-12
    )


def test_exact_samples_give_the_exact_walk():
    for changes in (
        {},
        {"heading_rad": 1.0, "mounting": [1.0, 2.0, -0.5]},
        {"turn_rad": 0.3, "roll_rad": 0.9},
    ):
        walk = foot_walk(**changes)
        # 100 Hz trapezoids of curves whose third derivative reaches 600 m/s^3: millimetres a stride.
        assert heading_free(smooth(walk.signals), walk).max() < 0.02, changes
        fine = foot_walk(rate_hz=400.0, **changes)
        assert heading_free(smooth(fine.signals), fine).max() < 0.004, changes


def test_noise_and_bias_are_borne_and_the_uncertainty_says_so():
    errors, ratios = [], []
    for seed in range(5):
        walk = foot_walk(strides=10, noise=1.0, bias_radps=(0.01, 0.005, -0.01), seed=seed)
        found = smooth(walk.signals)
        far = heading_free(found, walk)
        errors.append(far[-1])
        ratios.append(far[-1] / np.linalg.norm(found.position_sigma_m[-1]))
    assert np.max(errors) < 0.15  # 1.2 % of 12 m
    assert 0.05 < np.sqrt(np.mean(np.square(ratios))) < 2.0


def test_stairs_are_not_flattened_and_small_steps_are():
    stairs = foot_walk(strides=8, rise_m=0.30, noise=1.0)
    assert smooth(stairs.signals).position_m[-1, 2] == pytest.approx(2.4, rel=0.03)
    level_floor = foot_walk(strides=8, noise=1.0)
    assert abs(smooth(level_floor.signals).position_m[-1, 2]) < 0.02
    told = smooth(stairs.signals, FootParameters(is_floor_flat=True))
    assert abs(told.position_m[-1, 2]) < 1.0


def test_the_compass_direction_and_the_mounting_change_nothing_but_the_heading():
    one = foot_walk(noise=1.0, seed=3)
    turned = rotation.exp([0.0, 0.0, 2.2])
    other = smooth(
        SensorSignals(
            one.signals.time_s,
            rotation.rotate(turned, one.signals.gyroscope_radps),
            rotation.rotate(turned, one.signals.accelerometer_mps2),
        )
    )
    first = smooth(one.signals)
    # Noise of the gyroscope is judged axis by axis, so the mounting shows in micrometres a sample.
    np.testing.assert_allclose(
        np.linalg.norm(np.diff(first.position_m, axis=0), axis=1),
        np.linalg.norm(np.diff(other.position_m, axis=0), axis=1),
        atol=1e-5,
    )


def test_a_long_record_is_smoothed_in_pieces_that_do_not_show(monkeypatch):
    walk = foot_walk(strides=5, noise=1.0)
    whole = smooth(walk.signals)
    monkeypatch.setattr("estimators.gait.foot.trajectory._SEGMENT", 97)
    pieces = smooth(walk.signals)
    np.testing.assert_array_equal(whole.position_m, pieces.position_m)
    np.testing.assert_array_equal(whole.position_sigma_m, pieces.position_sigma_m)


def test_a_magnetometer_holds_the_heading_and_steel_does_not_bend_it():
    drift = (0.0, 0.0, 0.03)
    walk = foot_walk(strides=20, rest_s=0.3, noise=1.0, bias_radps=drift, mounting=[0.0, 0.3, 0.0])
    field = rotation.rotate(rotation.conjugate(walk.q_world_sensor), [0.0, 20e-6, -44e-6])
    near_steel = slice(900, 1300)
    bent = field.copy()
    bent[near_steel] += [20e-6, 0.0, 10e-6]

    def error(magnetometer):
        signals = SensorSignals(
            walk.signals.time_s, walk.signals.gyroscope_radps, walk.signals.accelerometer_mps2, magnetometer
        )
        return heading_free(smooth(signals), walk)[-1]

    without, with_field, with_steel = error(None), error(field), error(bent)
    assert with_field < 0.5 * without
    assert with_steel < 0.7 * without


def test_no_stance_is_said():
    time = np.arange(600) / RATE
    shaken = 30.0 * np.sin(40.0 * time)[:, None] * [1.0, 0.5, 0.2]
    found = smooth(SensorSignals(time, shaken, 3.0 * shaken + [0, 0, 9.8]))
    assert not found.has_stance
    assert (found.flags & FootFlag.NO_STANCE).all()
    walk = foot_walk()
    assert smooth(walk.signals).has_stance
    assert not (smooth(walk.signals).flags & FootFlag.NO_STANCE).any()


def test_stances_are_found_at_any_speed_without_a_setting():
    for length, period in ((0.4, 2.0), (0.8, 1.6), (1.3, 1.1), (2.0, 0.8)):
        walk = foot_walk(
            strides=8,
            length_m=length,
            period_s=period,
            lift_m=0.05 * length,
            roll_rad=max(0.4, 0.5 * length),
            noise=1.0,
        )
        stance = find_stance(
            walk.signals.gyroscope_radps, walk.signals.accelerometer_mps2, RATE, FootParameters()
        )
        starts = np.flatnonzero(np.diff(stance.is_stance.astype(int)) == 1)
        middles = 1.0 + np.arange(8) * period + 0.3 * period  # of the swings
        assert not stance.is_stance[np.round(middles * RATE).astype(int)].any(), length
        assert len(starts) == 8, length


def test_each_stance_has_one_lowest_sample():
    statistic = np.array([9, 3, 2, 4, 9, 9, 5, 4, 3, 2, 3, 4, 5, 4, 3, 1, 3, 1], dtype=float)
    found = np.empty(18, dtype=bool)
    for half, expected in ((100, [15]), (5, [2, 9, 15])):
        local_minimum(statistic, statistic < 9, 0, 18, half, found)
        assert np.flatnonzero(found).tolist() == expected


def test_level_brings_any_force_upright():
    for force in ([0, 0, 9.8], [0, 0, -9.8], [9.8, 0, 0], [3.0, -4.0, 1.0]):
        np.testing.assert_allclose(
            rotation.rotate(level(np.array(force, dtype=float)), force),
            [0, 0, np.linalg.norm(force)],
            atol=1e-12,
        )


def test_holes_are_filled_with_noise_that_says_so():
    walk = foot_walk(strides=6, noise=1.0)
    signals = walk.signals
    keep = np.ones(len(signals.time_s), dtype=bool)
    keep[200:208] = False  # 80 ms in a swing
    late = signals.gyroscope_radps.copy()
    late[450:500] = np.nan  # half a second
    found = smooth(SensorSignals(signals.time_s[keep], late[keep], signals.accelerometer_mps2[keep]))
    np.testing.assert_allclose(found.time_s, signals.time_s, atol=1e-6)
    assert (found.flags[200:208] & FootFlag.BRIDGED).all()
    assert (found.flags[450:500] & FootFlag.INVALID).all()
    assert not (found.flags[510:] & (FootFlag.BRIDGED | FootFlag.INVALID)).any()
    assert not found.stance.is_stance[446:504].any()
    sound = smooth(signals)
    before = np.linalg.norm(found.position_m[430] - found.position_m[0])
    assert before == pytest.approx(
        np.linalg.norm(sound.position_m[430]), abs=0.12
    )  # the swing with the short hole
    after = np.linalg.norm(found.position_m[-1] - found.position_m[560])
    assert after == pytest.approx(np.linalg.norm(sound.position_m[-1] - sound.position_m[560]), abs=0.03)
    assert found.position_sigma_m[-1, 0] > 3.0 * sound.position_sigma_m[-1, 0]


def test_wrong_input_is_refused():
    walk = foot_walk(strides=1)
    signals = walk.signals
    with refuses("walk.too_short", error=ShapeError):
        smooth(
            SensorSignals(signals.time_s[:30], signals.gyroscope_radps[:30], signals.accelerometer_mps2[:30])
        )
    with refuses("walk.rate", error=ShapeError):
        smooth(SensorSignals(signals.time_s * 10, signals.gyroscope_radps, signals.accelerometer_mps2))
    broken = np.full_like(signals.gyroscope_radps, np.nan)
    with refuses("walk.too_short", error=ShapeError):
        smooth(SensorSignals(signals.time_s, broken, signals.accelerometer_mps2))
    with pytest.raises(SetupError, match="no_such"):
        foot_parameters({"no_such": 1.0})
    with pytest.raises(SetupError, match="lag_s"):
        foot_parameters({"lag_s": 0.0})
