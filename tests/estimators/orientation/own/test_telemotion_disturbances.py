"""Our own filter beside magnets, through gaps and without a magnetometer: bounded, honest, never a jump."""

from dataclasses import replace

import numpy as np
import pytest

from estimators import orientation, rotation
from estimators.conventions import GRAVITY_MPS2
from estimators.kernels import filled
from estimators.orientation import OrientationFlag
from estimators.orientation.telemotion import _records as at
from estimators.orientation.telemotion._parameters import TelemotionParameters, settings_of
from estimators.orientation.telemotion._samples import rest_variance
from estimators.recording import ImuChunk, SampleQuality

STEP_S = 0.01
FIELD_UT = np.array([0.0, 19.0, -45.0])
DISTURBED, NO_HEADING, CONVERGING, INVALID, BRIDGED = (
    int(flag)
    for flag in (
        OrientationFlag.MAGNETIC_DISTURBANCE,
        OrientationFlag.HEADING_NOT_TRUSTED,
        OrientationFlag.CONVERGING,
        OrientationFlag.INVALID,
        OrientationFlag.BRIDGED,
    )
)


def scene(seconds, disturbance_ut=None, sensors=6, seed=5, turning=1.0, still_s=6.0):
    """Sensors with errors of gain, bias and accelerometer; rest, then turns. Returns chunk and true q (S, K, 4)."""
    rng = np.random.default_rng(seed)
    ticks = round(seconds / STEP_S)
    time = np.arange(ticks) * STEP_S
    fade = turning * np.clip((time - still_s) / 0.5, 0.0, 1.0) ** 2
    shape = (sensors, ticks, 3)
    rate = np.zeros(shape)
    for _ in range(3):
        phase = 2 * np.pi * rng.uniform(0.15, 0.6, (sensors, 1, 3)) * time[:, None]
        rate += rng.uniform(0.3, 0.8, (sensors, 1, 3)) * np.sin(phase + rng.uniform(0, 6, (sensors, 1, 3)))
    rate *= fade[:, None]
    q = np.empty((sensors, ticks, 4))
    q[:, 0] = rotation.normalize(rng.standard_normal((sensors, 4)))
    steps = rotation.exp(rate * STEP_S)
    for k in range(1, ticks):
        q[:, k] = rotation.multiply(q[:, k - 1], steps[:, k])
    back = rotation.conjugate(q)
    disturbance = np.zeros(shape) if disturbance_ut is None else disturbance_ut(time)
    gain = np.eye(3) + 0.002 * rng.standard_normal((sensors, 3, 3))
    bias = np.deg2rad(0.3) * rng.standard_normal((sensors, 1, 3))
    chunk = ImuChunk(
        0,
        STEP_S,
        np.einsum("sij,skj->ski", gain, rate) + bias + 0.004 * rng.standard_normal(shape),
        rotation.rotate(back, np.array([0.0, 0.0, GRAVITY_MPS2]))
        + 0.03 * rng.standard_normal((sensors, 1, 3))
        + 0.05 * rng.standard_normal(shape),
        1e-6 * (rotation.rotate(back, FIELD_UT + disturbance) + 0.3 * rng.standard_normal(shape)),
        np.zeros(shape[:2], dtype=np.uint8),
    )
    return chunk, q


def run(chunk, parameters=None):
    return orientation.create("telemotion", chunk.sensor_count, STEP_S, parameters).update(chunk)


def errors(result, truth):
    return rotation.log(rotation.multiply(result.q_earth_sensor, rotation.conjugate(truth)))


def magnet_from(start_s, stop_s, size_ut):
    """A field to the east that comes within half a second and goes again."""

    def disturbance(time):
        strength = np.clip((time - start_s) / 0.5, 0.0, 1.0) - np.clip((time - stop_s) / 0.5, 0.0, 1.0)
        return strength[:, None] * np.array([size_ut, 0.0, 0.0])

    return disturbance


@pytest.fixture(scope="module")
def clean():
    chunk, truth = scene(60.0)
    return chunk, truth, run(chunk)


def test_stated_uncertainty_holds_in_simulation(clean):
    """Of three normal errors 95 % lie within 2.80 sigma; correlated errors make that a band, not a number.

    Sigma stands for devices as they are delivered, whose accelerometers have an offset.
    """
    chunk, truth, _ = clean
    offset = np.random.default_rng(9).normal(scale=0.3, size=(chunk.sensor_count, 1, 3))
    result = run(replace(chunk, accelerometer_mps2=chunk.accelerometer_mps2 + offset))
    normalized = errors(result, truth)[:, 300:] / result.sigma_rad[:, 300:]
    squares = (normalized**2).sum(axis=-1)
    assert 0.90 <= np.mean(squares < 7.815) <= 1.0
    assert 0.1 < squares.mean() / 3.0 < 1.3  # neither careless nor useless


def test_magnet_in_passing_turns_nothing_for_long_and_returns_softly(clean):
    """15 uT to the east turn magnetic north by 38 degrees for eight seconds."""
    chunk, truth = scene(60.0, magnet_from(25.0, 33.0, 15.0))
    result = run(chunk)
    error = np.abs(errors(result, truth)[..., 2])
    assert error[:, 2500:].max() < np.deg2rad(6.0)
    assert error[:, -500:].max() < np.deg2rad(3.0)
    assert (result.flags[:, 2600:3250] & DISTURBED != 0).mean() > 0.9
    assert (result.flags[:, 1500:2400] & DISTURBED == 0).mean() > 0.99
    # Never a jump: each step differs from the truth's by the return rate and the gyroscope's noise at most.
    inside = np.s_[:, 300:]
    found, true = result.q_earth_sensor[inside], truth[inside]
    step = rotation.multiply(rotation.conjugate(found[:, :-1]), found[:, 1:])
    true_step = rotation.multiply(rotation.conjugate(true[:, :-1]), true[:, 1:])
    largest = rotation.angle_between(step, true_step).max()
    assert largest < np.deg2rad(30.0) * STEP_S + 0.03 * STEP_S + 6 * 0.004 * STEP_S * np.sqrt(3)


def test_heading_is_less_sure_beside_a_magnet(clean):
    chunk, _ = scene(60.0, magnet_from(25.0, 55.0, 15.0))
    beside = run(chunk).sigma_rad[:, 2700:5400, 2]
    assert (beside.mean(axis=1) > 1.2 * clean[2].sigma_rad[:, 2700:5400, 2].mean(axis=1)).all()
    assert beside.max() < np.deg2rad(15.0)  # and bounded


def test_iron_laid_beside_a_resting_sensor_is_not_followed():
    """In 100 s the sensor never moves: the first field stands, whatever comes later (12 uT turn it by 32 degrees)."""
    chunk, truth = scene(100.0, magnet_from(10.0, 1e3, 12.0), turning=0.0)
    error = np.abs(errors(run(chunk), truth)[:, 1000:, 2])
    assert np.rad2deg(error.max()) < 5.0
    assert np.rad2deg(error.mean()) < 3.6  # the compensated figure of Roetenberg (2006), 3.3


def test_iron_carried_from_the_start_is_found_by_turning():
    """Hard iron of 8 uT, as of a watch: north is off by up to 24 degrees until the sensor has turned."""
    chunk, truth = scene(90.0)
    iron = 8e-6 * np.array([0.6, -0.5, 0.62])
    carried = ImuChunk(
        0, STEP_S, chunk.gyroscope_radps, chunk.accelerometer_mps2, chunk.magnetometer_t + iron, chunk.quality
    )
    estimator = orientation.create("telemotion", chunk.sensor_count, STEP_S)
    result = estimator.update(carried)
    # The first 45 s may be wrong: they show it.
    error = np.abs(errors(result, truth)[:, -2000:, 2])
    assert np.rad2deg(np.sqrt(np.mean(error**2))) < 4.0
    found = np.array([known.hard_iron_t for known in estimator.device_constants])
    np.testing.assert_allclose(found, np.broadcast_to(iron, found.shape), atol=2.5e-6)


def test_without_magnetometer_heading_grows_unsure_and_tilt_stays():
    chunk, truth = scene(60.0)
    lost = ImuChunk(
        0,
        STEP_S,
        chunk.gyroscope_radps,
        chunk.accelerometer_mps2,
        np.full_like(chunk.magnetometer_t, np.nan),
        chunk.quality,
    )
    result = run(lost)
    assert (result.flags & NO_HEADING).all()
    tilt = np.linalg.norm(errors(result, truth)[:, 300:, :2], axis=-1)
    assert np.sqrt(np.mean(tilt**2)) < np.deg2rad(1.0)
    sigma = result.sigma_rad[..., 2]
    assert (sigma[:, -1] > sigma[:, 1000]).all()


def with_gaps(chunk, gaps, quality, garbage=np.nan):
    arrays = [v.copy() for v in (chunk.gyroscope_radps, chunk.accelerometer_mps2, chunk.magnetometer_t)]
    flags = chunk.quality.copy()
    for start, stop in gaps:
        flags[:, start:stop] = quality
        for values in arrays:
            values[:, start:stop] = garbage
    return ImuChunk(0, STEP_S, *arrays, flags)


SHORT = [(start, start + 5) for start in range(1500, 5800, 100)]


def test_short_gaps_are_filled_anew_from_both_sides(clean):
    """5 % lost in bursts of 50 ms: what was interpolated on the way (here: nonsense) is not taken for measured."""
    chunk, truth, whole = clean
    missing = run(with_gaps(chunk, SHORT, int(SampleQuality.MISSING)))
    bridged = run(with_gaps(chunk, SHORT, int(SampleQuality.BRIDGED), 0.1))
    between = np.ones(chunk.tick_count, dtype=bool)
    for start, stop in SHORT:
        between[start : stop + 2] = False
    np.testing.assert_array_equal(missing.q_earth_sensor[:, between], bridged.q_earth_sensor[:, between])
    total = [
        np.sqrt(np.mean(rotation.angle_between(r.q_earth_sensor, truth)[:, 1500:] ** 2))
        for r in (whole, missing)
    ]
    assert total[1] < total[0] + np.deg2rad(0.5)
    inside = ~between
    inside[1:] &= ~between[:-1]
    assert not (missing.flags & INVALID).any()


def test_long_gap_at_rest_keeps_the_heading_and_says_when_it_is_sure():
    chunk, truth = scene(30.0, turning=0.0)
    result = run(with_gaps(chunk, [(1500, 1600)], int(SampleQuality.MISSING)))
    after = np.s_[:, 1600:]
    assert np.abs(errors(result, truth)[after][..., 2]).max() < np.deg2rad(3.0)
    converging = (result.flags[after] & CONVERGING) != 0
    assert converging[:, :50].all()
    assert not converging[:, 310:].any()
    unsure = result.sigma_rad[after].max(axis=-1) > np.deg2rad(5.0)
    late = np.s_[:, 100:300]
    np.testing.assert_array_equal(converging[late], unsure[late])


def test_nonsense_of_one_sensor_stays_with_it(clean):
    chunk, _, whole = clean
    broken = with_gaps(chunk, [], 0)
    broken.gyroscope_radps[2, 2000:2300] = 1e200
    broken.magnetometer_t[3, 2000:2300] = np.inf
    broken.accelerometer_mps2[4, 2000:] = 0.0
    result = run(broken)
    for s in (0, 1, 5):
        np.testing.assert_array_equal(result.q_earth_sensor[s], whole.q_earth_sensor[s])
    for values in (result.q_earth_sensor, result.sigma_rad, result.gyroscope_bias_radps):
        assert np.isfinite(values[[0, 1, 3, 4, 5]]).all()


def _rest_weight(deviation_radps: float, sway_radps: float) -> float:
    """Variance that a rest of 20 s gives its mean rate, when the bias is known to 0.02 deg/s."""
    settings = filled(at.SETTINGS, settings_of(TelemotionParameters(), 0.01))
    memory, p = np.zeros(1, at.STATE), np.zeros(at.STATES**2)
    p[(at.STATES + 1) * at.BIAS :: at.STATES + 1][:3] = np.deg2rad(0.02) ** 2
    variance = np.nan
    for block in range(100):
        memory["rest_s"] = 0.76 + 0.2 * block
        memory["mean_rate"][0, 0] = deviation_radps + sway_radps * np.sin(2.0 * np.pi * block / 7.0)
        variance = rest_variance(p, memory[0], settings[0], 0.2)
    return float(variance)


def test_a_rest_tells_less_the_more_it_sways_and_contradicts_a_known_bias() -> None:
    table = _rest_weight(0.0, 0.0)
    assert table == pytest.approx(np.deg2rad(0.1) ** 2 / 0.2, rel=0.01)
    swaying = _rest_weight(0.0, np.deg2rad(0.7))
    assert 3.0 < swaying / table < 100.0
    sinking = _rest_weight(np.deg2rad(0.5), 0.0)
    assert sinking > 20.0 * table
