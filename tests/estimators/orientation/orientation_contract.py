"""What every orientation estimator must keep; each one's test class inherits these tests."""

import itertools

import numpy as np
import pytest

from estimators import orientation, rotation
from estimators.conventions import GRAVITY_MPS2
from estimators.errors import SetupError, ShapeError
from estimators.orientation import OrientationFlag
from estimators.recording import ImuChunk, SampleQuality

STEP_S = 0.01
INVALID, BRIDGED, CONVERGING, NO_HEADING, SATURATED = (
    int(flag)
    for flag in (
        OrientationFlag.INVALID,
        OrientationFlag.BRIDGED,
        OrientationFlag.CONVERGING,
        OrientationFlag.HEADING_NOT_TRUSTED,
        OrientationFlag.SATURATED,
    )
)
MISSING = int(SampleQuality.MISSING)


def moving_network(sensors=3, ticks=900, seed=11, field=True, noise=1.0):
    """Sensors that rest for two seconds and then turn smoothly, with exact truth, shapes (S, K, ...)."""
    rng = np.random.default_rng(seed)
    time = np.arange(ticks) * STEP_S
    fade = np.clip((time - 2.0) / 0.5, 0.0, 1.0) ** 2
    rate = np.stack(
        [
            np.stack([np.sin(2 * np.pi * f * time + p) * a for f, p, a in zip(*draw, strict=True)], axis=-1)
            for draw in zip(
                rng.uniform(0.2, 0.7, (sensors, 3)),
                rng.uniform(0, 6, (sensors, 3)),
                rng.uniform(0.5, 1.5, (sensors, 3)),
                strict=True,
            )
        ]
    )
    rate *= fade[:, None]
    q = np.empty((sensors, ticks, 4))
    q[:, 0] = rotation.normalize(rng.standard_normal((sensors, 4)))
    for k in range(1, ticks):
        q[:, k] = rotation.multiply(q[:, k - 1], rotation.exp(0.5 * (rate[:, k - 1] + rate[:, k]) * STEP_S))
    back = rotation.conjugate(q)
    force = rotation.rotate(back, np.array([0.0, 0.0, GRAVITY_MPS2]))
    magnet = rotation.rotate(back, np.array([0.0, 20e-6, -45e-6]))
    bias = rng.uniform(-0.01, 0.01, (sensors, 1, 3))
    chunk = ImuChunk(
        0,
        STEP_S,
        rate + bias + noise * 0.005 * rng.standard_normal(rate.shape),
        force + noise * 0.05 * rng.standard_normal(rate.shape),
        magnet + noise * 0.3e-6 * rng.standard_normal(rate.shape) if field else None,
        np.zeros((sensors, ticks), dtype=np.uint8),
    )
    return chunk, q


def with_trouble(chunk: ImuChunk) -> ImuChunk:
    """Gaps of every kind, a sensor without magnetometer, a late start, clipping and a lost field."""
    gyroscope, accelerometer = chunk.gyroscope_radps.copy(), chunk.accelerometer_mps2.copy()
    field, quality = chunk.magnetometer_t.copy(), chunk.quality.copy()
    lost = np.zeros(quality.shape, dtype=bool)
    lost[0, 300:315] = lost[0, 500:560] = lost[1, :7] = lost[1, 400:401] = lost[2, 700:760] = True
    lost[0, 330] = lost[0, 332] = True
    gyroscope[lost], accelerometer[lost], field[lost] = np.nan, np.nan, np.nan
    quality[lost] = MISSING
    quality[1, 200:220] = int(SampleQuality.BRIDGED)
    quality[2, 250:260] = int(SampleQuality.SATURATED)
    field[2] = np.nan
    field[1, 600:650] = np.nan
    return ImuChunk(0, chunk.time_step_s, gyroscope, accelerometer, field, quality)


def joined(results):
    return [
        np.concatenate([getattr(r, name) for r in results], axis=1)
        for name in ("q_earth_sensor", "gyroscope_bias_radps", "sigma_rad", "flags")
    ]


def assert_same_bits(first, second):
    for a, b in zip(first, second, strict=True):
        np.testing.assert_array_equal(a, b)


class OrientationContract:
    """Inherit, and set `name`."""

    name: str
    gap_hold_after_ticks = 0
    """Ticks that the estimator coasts through a gap before it holds."""

    @classmethod
    def create(cls, sensors=3, parameters=None):
        return orientation.create(cls.name, sensors, STEP_S, parameters)

    @classmethod
    def run(cls, chunk, cuts=(), estimator=None):
        estimator = estimator or cls.create(chunk.sensor_count)
        edges = [0, *cuts, chunk.tick_count]
        return joined([estimator.update(chunk.ticks(a, b)) for a, b in itertools.pairwise(edges)])

    @pytest.fixture(scope="class")
    @classmethod
    def troubled(cls):
        return with_trouble(moving_network()[0])

    @pytest.fixture(scope="class")
    @classmethod
    def whole(cls, troubled):
        return cls.run(troubled)

    def test_sample_by_sample_is_one_batch(self, troubled, whole):
        assert_same_bits(self.run(troubled, range(1, troubled.tick_count)), whole)

    def test_uneven_chunks_are_one_batch(self, troubled, whole):
        rng = np.random.default_rng(4)
        for _ in range(3):
            cuts = np.sort(rng.integers(0, troubled.tick_count, 40))  # repeats make empty chunks
            assert_same_bits(self.run(troubled, cuts.tolist()), whole)

    @pytest.mark.parametrize("cut", [0, 4, 5, 308, 331, 520, 561, 730, 899])
    def test_saved_and_restored_is_one_batch(self, troubled, whole, cut):
        first = self.create()
        results = [first.update(troubled.ticks(0, cut))]
        stored = {
            name: np.frombuffer(v.tobytes(), v.dtype).reshape(v.shape) for name, v in first.state().items()
        }
        second = self.create()
        second.restore(stored)
        results.append(second.update(troubled.ticks(cut, troubled.tick_count)))
        assert_same_bits(joined(results), whole)
        for name, values in first.state().items():
            assert values.tobytes() == stored[name].tobytes(), name  # nothing shared with the second

    def test_restored_bias_calibration_is_one_batch(self, troubled):
        def calibrated():
            estimator = self.create()
            estimator.set_gyroscope_bias(np.full((3, 3), 0.004), 0.001)
            return estimator

        copy = self.create()
        copy.restore(calibrated().state())
        assert_same_bits(self.run(troubled, estimator=copy), self.run(troubled, estimator=calibrated()))

    def test_sensors_do_not_touch_each_other(self, troubled, whole):
        for s in range(3):
            alone = ImuChunk(
                0,
                STEP_S,
                *(
                    v[s : s + 1]
                    for v in (
                        troubled.gyroscope_radps,
                        troubled.accelerometer_mps2,
                        troubled.magnetometer_t,
                        troubled.quality,
                    )
                ),
            )
            assert_same_bits(self.run(alone), [values[s : s + 1] for values in whole])

    def test_shapes_types_and_unit_norm(self, troubled, whole):
        q, bias, sigma, flags = whole
        shape = troubled.quality.shape
        assert (q.shape, bias.shape, sigma.shape, flags.shape) == (
            (*shape, 4),
            (*shape, 3),
            (*shape, 3),
            shape,
        )
        assert flags.dtype == np.uint8
        np.testing.assert_allclose(np.linalg.norm(q, axis=-1), 1.0, atol=1e-12)
        for values in (q, bias, sigma):
            assert np.isfinite(values).all()
        assert (sigma > 0.0).all()
        assert (sigma <= np.pi).all()

    def test_input_is_left_alone(self):
        chunk = with_trouble(moving_network(ticks=800)[0])
        before = [v.copy() for v in (chunk.gyroscope_radps, chunk.accelerometer_mps2, chunk.magnetometer_t)]
        self.run(chunk)
        for old, new in zip(
            before, (chunk.gyroscope_radps, chunk.accelerometer_mps2, chunk.magnetometer_t), strict=True
        ):
            np.testing.assert_array_equal(old, new)

    def test_follows_the_truth(self):
        chunk, truth = moving_network(sensors=6)
        q, _, sigma, flags = self.run(chunk)
        error = rotation.angle_between(q, truth)
        # Noise of 0.3 degrees in gravity and 0.9 in field; bias of up to 0.6 deg/s is found.
        assert np.sqrt(np.mean(error[:, 300:] ** 2)) < np.deg2rad(1.0)
        assert not (flags[:, 500:] & (INVALID | CONVERGING | NO_HEADING)).any()
        np.testing.assert_array_less(sigma[:, -1], np.deg2rad(6.0))

    def test_flags_follow_the_samples(self, troubled, whole):
        flags = whole[3]
        assert (flags[1, 200:220] & BRIDGED).all()
        assert (flags[2, 250:260] & SATURATED).all()
        assert not (flags[:, 100:190] & (BRIDGED | SATURATED)).any()

    def test_before_the_first_sample_all_is_invalid(self, whole):
        assert (whole[3][1, :7] & INVALID).all()
        np.testing.assert_allclose(whole[0][1, :7], np.broadcast_to(rotation.identity(), (7, 4)), atol=1e-15)
        assert not (whole[3][1, 7:390] & INVALID).any()
        assert (whole[3][1, 7:100] & CONVERGING).all()

    def test_long_gap_holds_then_converges_again(self, troubled, whole):
        q, bias, sigma, flags = whole
        hold = 500 + self.gap_hold_after_ticks
        assert (flags[0, hold:560] & INVALID).all()
        assert not (flags[0, 500:hold] & INVALID).any()
        assert not (flags[0, 560:] & INVALID).any()
        np.testing.assert_array_equal(q[0, hold:560], np.broadcast_to(q[0, hold], (560 - hold, 4)))
        assert (flags[0, 560:640] & CONVERGING).all()
        np.testing.assert_allclose(bias[0, 560], bias[0, 499], atol=np.deg2rad(0.2))  # kept, not forgotten
        assert (sigma[0, hold:560] == np.pi).all()

    def test_accurate_again_after_a_long_gap(self):
        chunk, truth = moving_network()
        gap = np.s_[:, 400:460]
        for values in (chunk.gyroscope_radps, chunk.accelerometer_mps2, chunk.magnetometer_t):
            values[gap] = np.nan
        chunk.quality[gap] = MISSING
        q = self.run(chunk)[0]
        error = rotation.angle_between(q, truth)
        lost = rotation.angle_between(truth[:, 399], truth[:, 460])
        assert (error[:, 460] < lost + np.deg2rad(10.0)).all()
        assert (error[:, 660:].max(axis=1) < np.maximum(0.3 * lost, np.deg2rad(5.0))).all()

    def test_missing_quality_counts_even_where_values_are_finite(self):
        chunk, _ = moving_network(ticks=400)
        chunk.quality[0, 300:360] = MISSING
        flags = self.run(chunk)[3]
        assert (flags[0, 300 + self.gap_hold_after_ticks : 360] & INVALID).all()

    def test_not_a_number_counts_as_missing(self):
        chunk, _ = moving_network(ticks=400)
        chunk.gyroscope_radps[1, 300:360, 2] = np.nan
        chunk.accelerometer_mps2[2, 300:360, 0] = np.inf
        q, bias, sigma, flags = self.run(chunk)
        assert (flags[1:, 300 + self.gap_hold_after_ticks : 360] & INVALID).all()
        assert all(np.isfinite(values).all() for values in (q, bias, sigma))

    def test_without_magnetometer_inclination_holds_and_heading_is_not_trusted(self):
        chunk, truth = moving_network(field=False)
        q, _, _, flags = self.run(chunk)
        assert (flags & NO_HEADING).all()
        up = np.array([0.0, 0.0, 1.0])
        in_sensor = rotation.rotate(rotation.conjugate(q), up)
        true_in_sensor = rotation.rotate(rotation.conjugate(truth), up)
        cosine = np.clip(np.sum(in_sensor * true_in_sensor, axis=-1), -1, 1)
        assert np.rad2deg(np.arccos(cosine))[:, 300:].max() < 2.0

    def test_absent_and_not_finite_magnetometer_are_the_same(self):
        chunk, _ = moving_network(field=False)
        lost = ImuChunk(
            0,
            STEP_S,
            chunk.gyroscope_radps,
            chunk.accelerometer_mps2,
            np.full_like(chunk.gyroscope_radps, np.nan),
            chunk.quality,
        )
        assert_same_bits(self.run(lost), self.run(chunk))

    def test_known_bias_is_used_from_the_first_turn(self):
        chunk, _ = moving_network(noise=0.0)
        chunk.gyroscope_radps[:] += 0.02
        bias = chunk.gyroscope_radps[:, 0]  # at rest
        estimator = self.create()
        estimator.set_gyroscope_bias(bias, 1e-4)
        result = estimator.update(chunk.ticks(0, 50))
        np.testing.assert_allclose(result.gyroscope_bias_radps[:, -1], bias, atol=np.deg2rad(0.05))

    def test_wrong_arguments_are_refused(self):
        with pytest.raises(SetupError, match="no_such_parameter"):
            self.create(parameters={"no_such_parameter": 1.0})
        known = next(iter(self.create().parameters))
        for wrong in ("fast", float("nan"), None):
            with pytest.raises(SetupError, match=known):
                self.create(parameters={known: wrong})
        for sensors, step_s in ((0, STEP_S), (3, 0.0), (100000, STEP_S)):
            with pytest.raises(SetupError):
                orientation.create(self.name, sensors, step_s)

    def test_wrong_chunks_are_refused(self):
        chunk, _ = moving_network(ticks=20)
        estimator = self.create()
        estimator.update(chunk.ticks(0, 5))
        with pytest.raises(ShapeError, match="tick 5 is next"):
            estimator.update(chunk.ticks(6, 9))
        with pytest.raises(ShapeError, match="tick 5 is next"):
            estimator.update(chunk.ticks(4, 9))
        with pytest.raises(ShapeError, match="shape"):
            self.create(2).update(chunk)
        with pytest.raises(ShapeError, match="per tick"):
            orientation.create(self.name, 3, 0.02).update(chunk)
        estimator.update(chunk.ticks(5, 20))

    def test_wrong_states_and_biases_are_refused(self):
        estimator = self.create()
        with pytest.raises(ShapeError):
            self.create(2).restore(estimator.state())
        with pytest.raises(ShapeError):
            estimator.restore({"next_tick": np.array(0)})
        with pytest.raises(ShapeError):
            estimator.set_gyroscope_bias(np.zeros((2, 3)), 0.1)
        with pytest.raises(ShapeError):
            estimator.set_gyroscope_bias(np.zeros((3, 3)), 0.0)

    def test_parameters_make_an_equal_estimator(self, troubled, whole):
        again = self.create(parameters=self.create().parameters)
        assert_same_bits(self.run(troubled, estimator=again), whole)

    def test_people_can_read_what_it_is(self):
        kind = orientation.available()[self.name]
        assert kind.name == self.name
        assert 2 <= len(kind.title) <= 40
        assert kind.description.endswith(".")
        assert kind.version
