"""A session of hours, simulated in blocks so that it fits into memory."""

import itertools
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from estimators.magnetic import RelativePoseFilter
from estimators.recording import Float
from estimators.simulation.coils import (
    ModuleErrors,
    RelativeScene,
    relative_motion,
    relative_scene,
    run_closed_loop,
)
from validation.relative_pose.runs import SOURCE, attitude_error, mean_nees

_BLOCK_S = 300.0
"""Each block begins and ends at rest in the same pose, so that blocks follow each other smoothly."""
_CLEAN = ModuleErrors(0.0, 0.0, 1e-12, 0.0, 0.0)
_NOISE = ModuleErrors()


def _blocks(clean: RelativeScene, seed: int) -> Iterator[RelativeScene]:
    """Yield the movement again and again, with the errors of one pair of modules.

    Offsets are drawn once; the gyroscopes wander slowly on top, by a tenth of their offset an hour.
    """
    rng = np.random.default_rng([seed, 103])
    force, force_c = rng.normal(0.0, _NOISE.force_bias_sigma_mps2, (2, 3))
    rate, rate_c = rng.normal(0.0, _NOISE.rate_bias_sigma_radps, (2, 3))
    shape = clean.gyroscope_radps.shape
    for block in itertools.count():
        hours = block * _BLOCK_S / 3600.0
        wander = np.radians(0.05) * np.sin(2.0 * np.pi * hours / np.array([1.0, 1.3, 1.7]))
        draw = np.random.default_rng([seed, 109, block])
        noise = draw.standard_normal((5, *shape))
        yield replace(
            clean,
            gyroscope_radps=clean.gyroscope_radps + rate + wander + _NOISE.rate_sigma_radps * noise[0],
            source_gyroscope_radps=clean.source_gyroscope_radps
            + rate_c
            - wander
            + _NOISE.rate_sigma_radps * noise[1],
            accelerometer_mps2=clean.accelerometer_mps2 + force + _NOISE.force_sigma_mps2 * noise[2],
            source_accelerometer_mps2=clean.source_accelerometer_mps2
            + force_c
            + _NOISE.force_sigma_mps2 * noise[3],
            ambient_t=clean.ambient_t + _NOISE.magnetometer_sigma_t * noise[4],
        )


def long_session(hours: float, seed: int) -> tuple[list[Float], list[float]]:
    """Return position errors of each block, shape (K, 3), and its NEES per state; one filter goes through."""
    motion = relative_motion("flexion", _BLOCK_S, seed, end_s=_BLOCK_S - 10.0)
    clean = relative_scene(SOURCE, motion, _BLOCK_S, errors=_CLEAN, seed=seed)
    relative = RelativePoseFilter(
        SOURCE, clean.time_step_s, {"mounting_direction": tuple(clean.position_m[0].tolist())}
    )
    errors, consistency = [], []
    # The last ten seconds bend back to the pose that the next block begins in.
    on = (clean.time_s >= 4.0) & (clean.time_s < _BLOCK_S - 10.0)
    for block, scene in enumerate(itertools.islice(_blocks(clean, seed), round(hours * 3600.0 / _BLOCK_S))):
        result, _ = run_closed_loop(scene, relative, seed=block)
        position = (result.position_m - scene.position_m)[on]
        attitude = attitude_error(scene.q_source_sensor, result.q_source_sensor)[on]
        errors.append(position)
        consistency.append(mean_nees(np.concatenate([position, attitude], axis=1), result.covariance[on]))
    return errors, consistency
