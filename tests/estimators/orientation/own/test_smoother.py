"""Our own smoother: what it learns, what it does with silence, and a real recording."""

from pathlib import Path

import numpy as np
import pytest
import vqf
from scipy.stats import chi2

from estimators import orientation, rotation
from estimators.conventions import GRAVITY_MPS2
from estimators.errors import SetupError, ShapeError
from estimators.orientation import DeviceConstants, OrientationFlag
from estimators.orientation.smoother._estimator import SmootherParameters
from estimators.orientation.smoother._kernel import FACTS
from estimators.orientation.smoother._rest import Rests
from estimators.orientation.telemotion._parameters import settings_of
from estimators.recording import ImuChunk, SampleQuality
from validation.orientation.honesty_scenes import scene

NAME = "telemotion_smoother"
INVALID = int(OrientationFlag.INVALID)
NO_HEADING = int(OrientationFlag.HEADING_NOT_TRUSTED)
DATA = Path(__file__).parents[3] / "data" / "broad" / "fast_combined_15s.npz"
NO_GAIN, NO_IRON_T = np.zeros((3, 3)), np.zeros(3)
FIELD_T = np.array([0.0, 18e-6, -45e-6])


def moving(
    seconds=40.0,
    rate_hz=100.0,
    seed=0,
    *,
    gain=NO_GAIN,
    bias_radps=(0.01, -0.02, 0.015),
    delay_s=0.0,
    iron_t=NO_IRON_T,
    field=True,
    rest_s=3.0,
    first_tick=0,
):
    """One sensor that turns about all axes at one place; returns the chunk and its true orientation (K, 4)."""
    rng = np.random.default_rng(seed)
    ticks = round(seconds * rate_hz)
    time_s = np.arange(ticks) / rate_hz
    phase = rng.uniform(0.0, 2.0 * np.pi, 3)
    amplitude = np.where(time_s[:, None] > rest_s, [1.5, 2.0, 1.2], 0.0)
    omega = amplitude * np.sin(2.0 * np.pi * np.array([0.31, 0.43, 0.23]) * time_s[:, None] + phase)
    steps = rotation.exp(omega / rate_hz)
    q = np.empty((ticks, 4))
    q[0] = rotation.exp(np.array([0.1, 0.4, 2.0]))
    for k in range(1, ticks):
        q[k] = rotation.normalize(rotation.multiply(q[k - 1], steps[k]))
    # A sample is the mean over its interval: force and field as they were half a step earlier, field late.
    gyroscope = np.linalg.solve(np.eye(3) + gain, (omega + bias_radps).T).T
    half = rotation.multiply(q, rotation.exp(-0.5 * omega / rate_hz))
    late = rotation.multiply(q, rotation.exp(-delay_s * omega))
    force = rotation.rotate(rotation.conjugate(half), np.array([0.0, 0.0, GRAVITY_MPS2]))
    magnetic = rotation.rotate(rotation.conjugate(late), FIELD_T) + iron_t
    chunk = ImuChunk(
        first_tick,
        1.0 / rate_hz,
        (gyroscope + rng.normal(scale=0.002, size=q[:, 1:].shape))[None],
        (force + rng.normal(scale=0.02, size=q[:, 1:].shape))[None],
        (magnetic + rng.normal(scale=0.3e-6, size=q[:, 1:].shape))[None] if field else None,
        np.zeros((1, ticks), dtype=np.uint8),
    )
    return chunk, q


def error_deg(result, q):
    return np.degrees(rotation.angle_between(result.orientation.q_earth_sensor[0], q))


def test_learns_the_device_and_says_how_well():
    gain = np.array([[0.006, -0.002, 0.001], [0.003, -0.005, 0.002], [-0.001, 0.002, 0.004]])
    iron_t = np.array([1.5e-6, -2.0e-6, 1.0e-6])
    chunk, q = moving(90.0, gain=gain, delay_s=0.015, iron_t=iron_t)
    found = orientation.smooth(NAME, chunk)
    known = found.constants[0]
    # The filter takes fields for distorted, so a minute and a half teaches it most of delay and iron, not all.
    assert known.magnetometer_delay_s == pytest.approx(0.015, abs=0.004)
    np.testing.assert_allclose(known.array("hard_iron_t"), iron_t, atol=0.5e-6)
    np.testing.assert_allclose(known.array("gyroscope_gain"), gain, atol=0.0015)
    for name, truth in (("magnetometer_delay", 0.015), ("hard_iron", iron_t), ("gyroscope_gain", gain)):
        unit = {"magnetometer_delay": "_s", "hard_iron": "_t", "gyroscope_gain": ""}[name]
        sigma = known.array(f"{name}_sigma{unit}")
        assert (np.abs(known.array(f"{name}{unit}") - truth) < 3.0 * sigma).all(), name
    assert np.sqrt(np.mean(error_deg(found, q) ** 2)) < 0.5


def test_constants_of_an_earlier_session_help_a_short_one():
    gain = np.diag([0.008, -0.008, 0.008])
    known = orientation.smooth(NAME, moving(90.0, gain=gain, delay_s=0.02)[0]).constants
    short, q = moving(8.0, seed=1, gain=gain, delay_s=0.02, rest_s=1.0)
    without, with_them = (
        np.sqrt(np.mean(error_deg(orientation.smooth(NAME, short, None, constants), q) ** 2))
        for constants in (None, known)
    )
    assert with_them < without


def test_a_magnet_on_the_sensor_from_the_start_is_found():
    iron_t = np.array([20e-6, -25e-6, 15e-6])
    chunk, q = moving(60.0, iron_t=iron_t, rest_s=0.0)
    found = orientation.smooth(NAME, chunk)
    np.testing.assert_allclose(found.constants[0].array("hard_iron_t"), iron_t, atol=1.5e-6)
    assert np.sqrt(np.mean(error_deg(found, q) ** 2)) < 1.5


def test_a_belief_of_the_filter_that_the_whole_session_refutes_is_overruled():
    """A magnet near the sensor during the first rest only; then one that stays on it."""
    near_t = np.array([6e-6, -8e-6, 4e-6])
    chunk, q = moving(60.0, rest_s=6.0)
    chunk.magnetometer_t[0, :600] += near_t
    found = orientation.smooth(NAME, chunk)
    assert np.abs(found.constants[0].array("hard_iron_t")).max() < 1e-6
    assert np.sqrt(np.mean(error_deg(found, q)[700:] ** 2)) < 1.0
    # The rest looks clean then too, for any constant field points north somewhere.
    chunk, q = moving(60.0, rest_s=6.0, iron_t=near_t)
    found = orientation.smooth(NAME, chunk)
    np.testing.assert_allclose(found.constants[0].array("hard_iron_t"), near_t, atol=1e-6)
    assert np.sqrt(np.mean(error_deg(found, q) ** 2)) < 1.0


@pytest.mark.slow
def test_the_covariance_is_honest_where_the_model_is_true():
    """Noise as the parameters say, constants of the device drawn from their priors: NEES inside its 95 % band."""
    rate_noise_deg = float(np.degrees(0.002 * 0.1))  # 0.002 rad/s a sample at 100 Hz
    white = {
        "tilt_sigma_scale": 1.0,
        "heading_sigma_scale": 1.0,
        "tilt_sigma_floor_deg": 1e-4,
        "tilt_sigma_per_offset": 0.0,
        "wander_share": 0.0,
        "heading_sigma_floor_deg": 1e-4,
        "field_noise_moving_ut_sqrt_s": 0.03,
        "field_noise_rest_ut_sqrt_s": 0.03,
        "field_noise_start_ut_sqrt_s": 0.03,
        "quiet_least": 1.0,
        "start_narrow_ut": 0.001,
        "rate_noise_deg_per_sqrt_s": rate_noise_deg,
        "rate_noise_per_rate_sqrt_s": 0.0,
        "rest_bias_sigma_degps_sqrt_s": rate_noise_deg,
        "rest_sway_s": 0.0,
        "bias_drift_degps_per_sqrt_s": 1e-5,
        "speed_noise_mps_per_sqrt_s": 0.002,
        "position_noise_m_per_sqrt_s": 1e-6,
        "position_prior_m_sqrt_s": 5e-4,
    }
    runs, squares = 40, []
    for seed in range(runs):
        rng = np.random.default_rng(1000 + seed)
        chunk, q = moving(
            12.0,
            seed=seed,
            rest_s=2.0,
            gain=0.01 * rng.normal(size=(3, 3)),
            bias_radps=np.radians(2.0) * rng.normal(size=3),
            delay_s=0.02 * rng.normal(),
            iron_t=0.3e-6 * rng.normal(size=3),
        )
        chunk.accelerometer_mps2[:] = (
            1.0 + 0.02 * rng.normal()
        ) * chunk.accelerometer_mps2 + 0.5 * rng.normal(size=3)
        found = orientation.smooth(NAME, chunk, white).orientation
        error = rotation.log(rotation.multiply(found.q_earth_sensor[0], rotation.conjugate(q)))
        squares.append(((error / found.sigma_rad[0]) ** 2).sum(axis=1)[[600, 1000]])
    low, high = chi2.ppf([0.025, 0.975], 3 * runs) / runs
    mean = np.mean(squares, axis=0)
    assert ((mean > low) & (mean < high)).all(), mean


@pytest.mark.parametrize(
    ("seconds", "rate_hz"), [(0.05, 100.0), (0.19, 100.0), (1.5, 100.0), (30.0, 20.0), (10.0, 400.0)]
)
def test_any_length_and_rate(seconds, rate_hz):
    chunk, q = moving(seconds, rate_hz, rest_s=0.0, first_tick=12345)
    found = orientation.smooth(NAME, chunk)
    assert np.isfinite(found.orientation.q_earth_sensor).all()
    assert np.isfinite(found.orientation.sigma_rad).all()
    assert (found.orientation.sigma_rad > 0.0).all()
    sigma_deg = np.degrees(np.linalg.norm(found.orientation.sigma_rad[0], axis=1))
    assert (error_deg(found, q) < 2.0 * sigma_deg).all()
    assert sigma_deg.max() < 30.0


def test_without_magnetometer_tilt_is_right_and_heading_is_not_trusted():
    chunk, q = moving(30.0, field=False)
    found = orientation.smooth(NAME, chunk).orientation
    apart = rotation.multiply(found.q_earth_sensor[0], rotation.conjugate(q))
    tilt = 2.0 * np.arcsin(np.clip(np.hypot(apart[:, 1], apart[:, 2]), 0.0, 1.0))
    assert np.degrees(tilt).max() < 0.5
    assert ((found.flags & NO_HEADING) != 0).all()


@pytest.mark.parametrize("stretch", [(1500, 2300), (1500, 1530), (0, 700), (3300, 4000)])
def test_silence_is_marked_and_does_no_harm_elsewhere(stretch):
    chunk, q = moving(40.0)
    start, stop = stretch
    for values in (chunk.gyroscope_radps, chunk.accelerometer_mps2, chunk.magnetometer_t):
        values[0, start:stop] = np.nan
    chunk.quality[0, start:stop] = int(SampleQuality.MISSING)
    found = orientation.smooth(NAME, chunk)
    flags, sigma = found.orientation.flags[0], found.orientation.sigma_rad[0]
    assert (flags[start:stop] & INVALID).all()
    assert not (flags[:start] & INVALID).any()
    assert not (flags[stop + 1 :] & INVALID).any()
    assert np.isfinite(found.orientation.q_earth_sensor).all()
    assert np.isfinite(sigma).all()
    seen = np.ones(len(q), dtype=bool)
    seen[max(start - 20, 0) : stop + 20] = False  # the blocks at its edges hold samples of both
    assert error_deg(found, q)[seen].max() < 1.5


def test_a_sensor_that_never_spoke_leaves_the_other_alone():
    chunk, _ = moving(20.0)
    alone = orientation.smooth(NAME, chunk).orientation
    pair = ImuChunk(
        0,
        chunk.time_step_s,
        np.concatenate([np.full_like(chunk.gyroscope_radps, np.nan), chunk.gyroscope_radps]),
        np.concatenate([np.full_like(chunk.accelerometer_mps2, np.nan), chunk.accelerometer_mps2]),
        np.concatenate([np.full_like(chunk.magnetometer_t, np.nan), chunk.magnetometer_t]),
        np.concatenate([np.full_like(chunk.quality, int(SampleQuality.MISSING)), chunk.quality]),
    )
    both = orientation.smooth(NAME, pair)
    assert (both.orientation.flags[0] & INVALID).all()
    assert np.isfinite(both.orientation.q_earth_sensor).all()
    assert both.constants[0].gyroscope_gain == DeviceConstants().gyroscope_gain
    np.testing.assert_array_equal(both.orientation.q_earth_sensor[1], alone.q_earth_sensor[0])
    np.testing.assert_array_equal(both.orientation.sigma_rad[1], alone.sigma_rad[0])


def test_lost_bursts_cost_little():
    chunk, q = moving(60.0)
    rng = np.random.default_rng(5)
    for start in rng.integers(400, 5900, size=60):
        chunk.gyroscope_radps[0, start : start + 5] = np.nan
        chunk.accelerometer_mps2[0, start : start + 5] = np.nan
        chunk.magnetometer_t[0, start : start + 5] = np.nan
        chunk.quality[0, start : start + 5] = int(SampleQuality.MISSING)
    found = orientation.smooth(NAME, chunk)
    assert np.sqrt(np.mean(error_deg(found, q) ** 2)) < 0.5
    assert not (found.orientation.flags[0, 10:] & INVALID).any()


def test_output_lead_is_off_unless_asked_for():
    chunk, _ = moving(20.0)
    plain, led = (orientation.smooth(NAME, chunk, given) for given in (None, {"output_lead_s": 0.02}))
    turned = rotation.multiply(
        rotation.conjugate(plain.orientation.q_earth_sensor[0]), led.orientation.q_earth_sensor[0]
    )
    rate = chunk.gyroscope_radps[0] - plain.orientation.gyroscope_bias_radps[0]
    np.testing.assert_allclose(rotation.log(turned), 0.02 * rate, atol=1e-9)


def test_refuses_what_it_cannot_use():
    chunk, _ = moving(2.0)
    with pytest.raises(ShapeError, match="no ticks"):
        orientation.smooth(NAME, chunk.ticks(0, 0))
    with pytest.raises(SetupError, match="known are telemotion_smoother"):
        orientation.smooth("telemotion", chunk)
    with pytest.raises(SetupError, match="unknown parameter pases"):
        orientation.smooth(NAME, chunk, {"pases": 3})
    with pytest.raises(SetupError, match="passes must be at least 1"):
        orientation.smooth(NAME, chunk, {"passes": 0})
    with pytest.raises(ShapeError, match="constants of 2 sensors for 1"):
        orientation.smooth(NAME, chunk, None, [None, None])


def test_real_fast_movement_is_nearer_the_optical_reference_than_vqf_off_line():
    data = np.load(DATA)
    rate_hz = float(data["sampling_rate_hz"])
    chunk = ImuChunk(
        0,
        1.0 / rate_hz,
        data["gyroscope_radps"][None],
        data["accelerometer_mps2"][None],
        1e-6 * data["magnetometer_ut"][None],
        np.zeros((1, len(data["gyroscope_radps"])), dtype=np.uint8),
    )
    package = vqf.offlineVQF(
        *(
            np.ascontiguousarray(data[n])
            for n in ("gyroscope_radps", "accelerometer_mps2", "magnetometer_ut")
        ),
        1.0 / rate_hz,
    )["quat9D"]
    truth, movement = data["q_earth_sensor_optical"], data["movement"].astype(bool)
    ours = orientation.smooth(NAME, chunk).orientation.q_earth_sensor[0]
    found, reference = (orientation.orientation_errors(q, truth, movement) for q in (ours, package))
    assert found.total_rad < 0.6 * reference.total_rad
    assert found.inclination_rad < reference.inclination_rad


def test_a_smoothed_session_plays_like_a_live_one():
    chunk, _ = moving(10.0, first_tick=300)
    found = orientation.smooth(NAME, chunk)
    whole = orientation.with_orientation(chunk, found.orientation, found.constants)
    player = orientation.create(NAME, 1, chunk.time_step_s)
    first = player.update(whole.ticks(0, 333))
    assert player.device_constants == found.constants
    resumed = orientation.create(NAME, 1, chunk.time_step_s)
    resumed.restore(player.state())
    rest = [resumed.update(whole.ticks(a, b)) for a, b in ((333, 334), (334, 1000))]
    for name in ("q_earth_sensor", "gyroscope_bias_radps", "sigma_rad", "flags"):
        parts = [getattr(part, name) for part in (first, *rest)]
        np.testing.assert_array_equal(np.concatenate(parts, axis=1), getattr(found.orientation, name))
    with pytest.raises(ShapeError, match="tick 1300 is next"):
        resumed.update(whole.ticks(0, 5))
    with pytest.raises(SetupError, match="needs the whole session; use telemotion"):
        orientation.create(NAME, 1, chunk.time_step_s).update(chunk)


def test_the_smoother_is_listed_as_off_line_only():
    assert NAME not in orientation.available()
    listed = orientation.available(with_offline=True)
    assert listed[NAME].is_offline
    assert not any(kind.is_offline for name, kind in listed.items() if name != NAME)
    assert orientation.smoothers()[NAME].follows in orientation.available()
    parameters = orientation.create(NAME, 1, 0.01).parameters
    assert parameters["output_lead_s"] == 0.0


def _rest_weight(rate_radps: np.ndarray, bias_sigma_radps: float) -> np.ndarray:
    """Variance that 20 s of rest give the mean rate of each block; the bias is zero."""
    settings = settings_of(SmootherParameters(), 0.01)
    facts = np.zeros(len(rate_radps), FACTS)
    facts["is_at_rest"], facts["rate"] = 1, rate_radps
    known = np.full(len(facts), bias_sigma_radps**2)
    return Rests(facts, settings).variance(np.zeros((len(facts), 3)), known)


def test_a_rest_tells_less_the_more_it_sways_and_contradicts_what_the_session_shows():
    still = np.zeros((100, 3))
    table = _rest_weight(still, 0.0)
    np.testing.assert_allclose(table, np.deg2rad(0.1) ** 2 / 0.2, rtol=0.5)
    swaying = _rest_weight(np.deg2rad(0.7) * np.sin(2.0 * np.pi * np.arange(100) / 7.0)[:, None] + still, 0.0)
    assert 3.0 < np.median(swaying) / table[0] < 200.0
    sinking = _rest_weight(still + np.deg2rad(0.5), 0.0)
    assert (sinking > 20.0 * table).all()
    np.testing.assert_allclose(_rest_weight(still + np.deg2rad(0.5), np.inf), table)


def test_the_heading_is_as_sure_as_the_field_along_the_way_is_the_same():
    clean, foreign = (
        orientation.smooth("telemotion_smoother", scene(title, [5, 6])[0]).orientation.sigma_rad
        for title in ("arm swings", "foreign field for a time")
    )
    # The floor of a degree stands for a room whose field varies; 0.1 is the least share of it.
    assert np.degrees(np.median(clean[..., 2])) < 0.8
    assert np.degrees(foreign[:, 1000:, 2]).min() > 1.0
