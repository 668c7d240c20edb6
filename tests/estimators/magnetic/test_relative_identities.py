"""Identities of dead reckoning and of the updates of the relative-pose filter (method pages C6 4.4 and S 7.7)."""

from itertools import pairwise

import numpy as np
import pytest

from estimators import rotation
from estimators.conventions import GRAVITY_MPS2
from estimators.magnetic import RelativePoseFilter
from estimators.magnetic.relative import layout as at
from estimators.magnetic.relative import motion
from estimators.magnetic.relative import pulse as pulses
from estimators.magnetic.relative.parameters import read, to_settings
from estimators.magnetic.relative.update import update_inclination, update_pulse
from estimators.optical import _kernel as optical
from estimators.optical import _layout as marked
from estimators.optical.published import OpticalInertialFilter
from estimators.simulation.coils import ModuleErrors, relative_motion, relative_scene
from tests.estimators.magnetic.relative_scenes import SOURCE, as_chunk, closed_loop

QUIET = ModuleErrors(0.0, 0.0, 1e-12, 0.0, 0.0)
MOVEMENTS = ("random", "flexion", "rotation", "hip", "shoulder", "walk_back", "walk_leg")
SETTINGS = to_settings(read({}), 0.01, 3)


def begin(scene):
    nominal = np.zeros(at.NOMINAL)
    nominal[:3], nominal[3:6] = scene.position_m[0], scene.velocity_mps[0]
    nominal[at.ATTITUDE : at.ATTITUDE + 4] = scene.q_source_sensor[0]
    return nominal


def signals_of(scene):
    return np.hstack(
        [
            scene.gyroscope_radps,
            scene.accelerometer_mps2,
            scene.source_gyroscope_radps,
            scene.source_accelerometer_mps2,
        ]
    )


def reckon(nominal, table, published=False):
    path = [nominal[:3].copy()]
    for before, now in pairwise(table):
        motion.mechanise(nominal, 0.5 * (before + now), 0.01, published)
        path.append(nominal[:3].copy())
    return np.array(path)


@pytest.mark.parametrize("movement", MOVEMENTS)
def test_dead_reckoning_without_noise_is_within_a_centimetre_after_five_seconds(movement):
    scene = relative_scene(SOURCE, relative_motion(movement, 9.1, 3), 9.0, errors=QUIET)
    path = reckon(begin(scene), signals_of(scene))
    assert np.linalg.norm(path - scene.position_m, axis=1).max() < 0.010


def test_the_published_integral_is_right_while_the_source_does_not_turn():
    scene = relative_scene(SOURCE, relative_motion("random", 9.1, 3), 9.0, errors=QUIET)
    table = signals_of(scene)
    right, published = (reckon(begin(scene), table, kind) for kind in (False, True))
    np.testing.assert_allclose(published, right, atol=1e-9)


def test_kinematics_of_the_state():
    """Check 7.7.5: p' = u - w_c x p and u' = R f_s - f_c - w_c x u on a turning source."""
    scene = relative_scene(SOURCE, relative_motion("walk_leg", 9.0, 1), 9.0, 1000.0, errors=QUIET)
    step, inner = 1e-3, slice(1, -1)

    def slope(values):
        return (values[2:] - values[:-2]) / (2 * step)

    turn = np.cross(scene.source_gyroscope_radps, scene.position_m)
    assert np.abs(slope(scene.position_m) - (scene.velocity_mps - turn)[inner]).max() < 1e-4
    force = rotation.rotate(scene.q_source_sensor, scene.accelerometer_mps2)
    force -= scene.source_accelerometer_mps2 + np.cross(scene.source_gyroscope_radps, scene.velocity_mps)
    jolt = np.abs(slope(scene.velocity_mps) - force[inner])
    # The numeric slope of u has an error of step^2/6 of its third derivative, here up to 1e3 m/s^4.
    assert jolt.max() < 1e-3


def test_an_acceleration_of_both_modules_is_none_between_them():
    scene = relative_scene(SOURCE, relative_motion("random", 9.1, 3), 9.0, errors=QUIET)
    table = signals_of(scene)
    path = reckon(begin(scene), table)
    rng = np.random.default_rng(2)
    # In halves of a step, so that both samples of each mean have the attitude that it is turned by.
    added = rng.normal(0.0, 3.0, 3)
    still = np.tile(table[0], (900, 1))
    one = reckon(begin(scene), still)
    still[:, 3:6] += rotation.rotate(rotation.conjugate(scene.q_source_sensor[0]), added)
    still[:, 9:12] += added
    np.testing.assert_allclose(reckon(begin(scene), still), one, atol=1e-9)
    assert np.isfinite(path).all()


def test_a_source_at_rest_leaves_the_strapdown_of_the_optical_filter():
    """C6 4.4.4: R_GM = I and f_m = -g. The same samples, integrated by the other filter's own step."""
    scene = relative_scene(SOURCE, relative_motion("random", 9.1, 3), 9.0, errors=QUIET)
    path = reckon(begin(scene), signals_of(scene))
    np.testing.assert_allclose(scene.source_accelerometer_mps2[:, 2], GRAVITY_MPS2, atol=1e-9)
    settings = OpticalInertialFilter(0.01).settings
    nominal, phi = np.zeros(marked.NOMINAL), np.empty((marked.ERRORS, marked.ERRORS))
    nominal[:3] = scene.position_m[0]
    nominal[marked.ATTITUDE : marked.ATTITUDE + 4] = scene.q_source_sensor[0]
    sample = np.zeros((900, marked.SAMPLE))
    sample[:, 0:3], sample[:, 3:6] = scene.gyroscope_radps, scene.accelerometer_mps2
    other = [nominal[:3].copy()]
    for before, now in pairwise(sample):
        optical.predict_state(nominal, before, now, settings, phi)
        other.append(nominal[:3].copy())
    np.testing.assert_allclose(path, other, atol=1e-3)


def test_source_and_sensor_exchanged():
    """C6 4.4.5: q' = -R_SM q, as dead reckoning says it from either side."""
    scene = relative_scene(SOURCE, relative_motion("shoulder", 9.1, 3), 9.0, errors=QUIET)
    table = signals_of(scene)
    here = begin(scene)
    path = reckon(here, table)
    back = rotation.conjugate(scene.q_source_sensor[0])
    there = np.zeros(at.NOMINAL)
    there[:3] = rotation.rotate(back, -scene.position_m[0])
    there[at.ATTITUDE : at.ATTITUDE + 4] = back
    swapped = reckon(there, np.hstack([table[:, 6:], table[:, :6]]))
    q_end = rotation.conjugate(here[at.ATTITUDE : at.ATTITUDE + 4])
    np.testing.assert_allclose(swapped[-1], rotation.rotate(q_end, -path[-1]), atol=2e-3)


def pulse_at(nominal, current=1.3):
    value, h = np.empty(3), np.zeros((3, at.ERRORS))
    pulses.predict_pulse(SOURCE.loops, 1.0, current, 0.0, nominal, np.zeros(6), value, h)
    return value


def random_filter(seed):
    rng = np.random.default_rng(seed)
    nominal = np.zeros(at.NOMINAL)
    nominal[:3] = rng.uniform(0.15, 0.35, 3)
    nominal[at.ATTITUDE : at.ATTITUDE + 4] = rotation.normalize(rng.normal(size=4))
    root = rng.normal(0.0, 0.003, (at.ERRORS, at.ERRORS))
    return nominal, root @ root.T + 1e-8 * np.eye(at.ERRORS), rng


def updated(nominal, p, field, inflation=1.0):
    pulse = np.zeros(12)
    pulse[:3], pulse[3], pulse[4], pulse[6] = field, 2e-16, 1.3, 1.0
    path = np.zeros((at.PATH, at.PATH_COLUMNS))
    path[0, :3] = nominal[:3]
    path[0, 3:] = rotation.conjugate(nominal[at.ATTITUDE : at.ATTITUDE + 4])
    after, spread, work = nominal.copy(), p.copy(), np.empty_like(p)
    memory = np.zeros(at.MEMORY)
    update_pulse(
        SOURCE.loops, 1.0, pulse, path, np.zeros(6), SETTINGS, inflation, after, spread, memory, work
    )
    return after, spread


@pytest.mark.parametrize("seed", range(8))
def test_a_pulse_never_adds_uncertainty_and_endless_noise_tells_nothing(seed):
    nominal, p, rng = random_filter(seed)
    field = pulse_at(nominal) + rng.normal(0.0, 3e-8, 3)
    _, less = updated(nominal, p, field)
    gain = p - less
    assert np.linalg.eigvalsh(gain).min() > -1e-9 * np.trace(p)
    assert np.trace(gain) > 0.0
    assert np.linalg.eigvalsh(less).min() > 0.0
    np.testing.assert_array_equal(less, less.T)
    same, all_of_it = updated(nominal, p, field, 1e16)
    np.testing.assert_allclose(same, nominal, atol=1e-9)
    np.testing.assert_allclose(all_of_it, p, atol=1e-9 * np.abs(p).max())


@pytest.mark.parametrize("seed", range(4))
def test_both_signs_of_a_quaternion(seed):
    nominal, p, rng = random_filter(seed)
    field = pulse_at(nominal) + rng.normal(0.0, 3e-8, 3)
    other = nominal.copy()
    other[at.ATTITUDE : at.ATTITUDE + 4] *= -1.0
    (one, spread), (two, alike) = updated(nominal, p, field), updated(other, p, field)
    two[at.ATTITUDE : at.ATTITUDE + 4] *= np.sign(
        two[at.ATTITUDE : at.ATTITUDE + 4] @ one[at.ATTITUDE : at.ATTITUDE + 4]
    )
    np.testing.assert_allclose(two, one, atol=1e-12)
    np.testing.assert_allclose(alike, spread, atol=1e-15)


@pytest.mark.parametrize("seed", range(4))
def test_gravity_that_fits_corrects_nothing_and_a_tilt_is_taken_out(seed):
    """Check 7.7.3, in the relative form: both modules read +9.81 up at rest, and R^T f_c = f_s."""
    nominal, _, rng = random_filter(seed)
    q = nominal[at.ATTITUDE : at.ATTITUDE + 4].copy()
    up = GRAVITY_MPS2 * np.array([0.6, 0.0, 0.8])
    signals = np.concatenate([np.zeros(3), rotation.rotate(rotation.conjugate(q), up), np.zeros(3), up])
    p, work = np.zeros((at.ERRORS, at.ERRORS)), np.empty((at.ERRORS, at.ERRORS))
    tilts = slice(at.E_ATTITUDE, at.E_ATTITUDE + 3)
    p[tilts, tilts] = np.eye(3)
    at_truth = nominal.copy()
    update_inclination(at_truth, signals, SETTINGS, 1e-8, p.copy(), np.zeros(at.MEMORY), work)
    np.testing.assert_allclose(at_truth, nominal, atol=1e-12)
    off = rng.normal(0.0, 1e-4, 3)
    tilted = nominal.copy()
    tilted[at.ATTITUDE : at.ATTITUDE + 4] = rotation.multiply(q, rotation.exp(off))
    update_inclination(tilted, signals, SETTINGS, 1e-8, p.copy(), np.zeros(at.MEMORY), work)
    left = rotation.log(rotation.multiply(rotation.conjugate(q), tilted[at.ATTITUDE : at.ATTITUDE + 4]))
    # A turn about the vertical is not seen.
    vertical = signals[3:6] / GRAVITY_MPS2
    np.testing.assert_allclose(left, (off @ vertical) * vertical, atol=1e-7)
    # The other sign of the accelerometer would be two g off.
    wrong = np.linalg.norm(rotation.rotate(rotation.conjugate(q), up) + signals[3:6])
    assert wrong == pytest.approx(2 * GRAVITY_MPS2)


def test_currents_noise_and_the_earths_field_doubled_alike():
    """Check 7.7.7: only their ratios count."""
    _, result, samples, parameters, _ = closed_loop()
    doubled = samples.copy()
    doubled[:, at.FIELD : at.FIELD + 3] *= 2.0
    doubled[:, at.CURRENT] *= 2.0
    source = type(SOURCE)(SOURCE.coils, SOURCE.model, current_limit_a=3.0)
    own = parameters | {
        "magnetometer_sigma_t": 6e-8,
        "earth_field_t": 9.8e-5,
        "current_a": 2.6,
        "full_scale_t": 1.6e-3,
    }
    found = RelativePoseFilter(source, 0.01, own).update(as_chunk(doubled))
    np.testing.assert_allclose(found.position_m, result.position_m, atol=1e-7)
    np.testing.assert_allclose(found.covariance, result.covariance, atol=1e-10)
    np.testing.assert_array_equal(found.fire_coil, result.fire_coil)
