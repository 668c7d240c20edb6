"""A session of hours, simulated in blocks so that it fits into memory."""

from dataclasses import replace

import numpy as np

from estimators.magnetic import RelativePoseFilter
from estimators.recording import Float
from estimators.simulation.coils import ModuleErrors, relative_motion, relative_scene, run_closed_loop
from estimators.validation._relative_pose_runs import SOURCE, attitude_error, mean_nees

_BLOCK_S = 300.0
"""Each block begins and ends at rest in the same pose, so that blocks follow each other smoothly."""
_WHITE = ModuleErrors(force_bias_sigma_mps2=0.0, rate_bias_sigma_radps=0.0)


def long_session(hours: float, seed: int) -> tuple[list[Float], list[float]]:
    """Return position errors of each block, shape (K, 3), and its NEES per state.

    Offsets of the sensors are drawn once; the gyroscopes wander slowly on top, by a tenth of their offset an hour.
    """
    rng = np.random.default_rng([seed, 103])
    force, force_c = rng.normal(0.0, 0.02, (2, 3))
    rate, rate_c = rng.normal(0.0, np.radians(0.5), (2, 3))
    motion = relative_motion("flexion", _BLOCK_S, seed, pause_s=(_BLOCK_S - 10.0, _BLOCK_S + 10.0))
    relative = None
    errors, consistency = [], []
    for block in range(round(hours * 3600.0 / _BLOCK_S)):
        scene = relative_scene(SOURCE, motion, _BLOCK_S, errors=_WHITE, seed=100000 * seed + block)
        wander = np.radians(0.05) * np.sin(
            2.0 * np.pi * block * _BLOCK_S / 3600.0 / np.array([1.0, 1.3, 1.7])
        )
        scene = replace(
            scene,
            gyroscope_radps=scene.gyroscope_radps + rate + wander,
            source_gyroscope_radps=scene.source_gyroscope_radps + rate_c - wander,
            accelerometer_mps2=scene.accelerometer_mps2 + force,
            source_accelerometer_mps2=scene.source_accelerometer_mps2 + force_c,
        )
        if relative is None:
            relative = RelativePoseFilter(
                SOURCE, scene.time_step_s, {"mounting_direction": tuple(scene.position_m[0].tolist())}
            )
        result, _ = run_closed_loop(scene, relative, seed=block)
        # The last ten seconds bend back to the pose that the next block begins in.
        on = (scene.time_s >= 4.0) & (scene.time_s < _BLOCK_S - 10.0)
        position = (result.position_m - scene.position_m)[on]
        attitude = attitude_error(scene.q_source_sensor, result.q_source_sensor)[on]
        errors.append(position)
        consistency.append(mean_nees(np.concatenate([position, attitude], axis=1), result.covariance[on]))
    return errors, consistency


__all__ = ["long_session"]
