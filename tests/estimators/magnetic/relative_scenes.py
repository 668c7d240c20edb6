"""A short session of the relative-pose filter, shared by its tests."""

import functools

import numpy as np

from estimators.magnetic import RelativeChunk, RelativePoseFilter, perpendicular_source
from estimators.magnetic.relative import layout as at
from estimators.simulation.coils import SourceFaults, relative_motion, relative_scene, run_closed_loop

SOURCE = perpendicular_source(0.06)


@functools.cache
def closed_loop(movement="flexion", seconds=9.0, seed=1, faults=None):
    """Return scene, result, samples and parameters; the arrays are shared: do not write to them."""
    scene = relative_scene(SOURCE, relative_motion(movement, seconds, seed), seconds, seed=seed)
    parameters = {"mounting_direction": tuple(scene.position_m[0].tolist())}
    relative = RelativePoseFilter(SOURCE, 0.01, parameters)
    result, samples = run_closed_loop(scene, relative, faults or SourceFaults(), seed)
    return scene, result, samples, parameters, relative


def as_chunk(samples, first=0):
    """Return samples of the loop as the network would deliver them."""
    return RelativeChunk(
        first,
        0.01,
        samples[:, at.GYROSCOPE : at.GYROSCOPE + 3],
        samples[:, at.ACCELEROMETER : at.ACCELEROMETER + 3],
        samples[:, at.FIELD : at.FIELD + 3],
        samples[:, at.SOURCE_GYROSCOPE : at.SOURCE_GYROSCOPE + 3],
        samples[:, at.SOURCE_ACCELEROMETER : at.SOURCE_ACCELEROMETER + 3],
        samples[:, at.COIL].astype(np.int64),
        samples[:, at.CURRENT],
    )
