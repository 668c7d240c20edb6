"""Moments of stillness that load or compile what a session will need, before its first packet."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from app.recordings.signals import frame_codec
from estimators.pipelines import Pipeline
from estimators.recording import ImuChunk


def still(sensors: int, ticks: int) -> Iterator[ImuChunk]:
    """Yield sensors at rest, upright, in packets of five ticks at 100 Hz."""
    generator = np.random.default_rng(0)
    for start in range(0, ticks, 5):
        noise = 1e-3 * generator.standard_normal((3, sensors, 5, 3))
        yield ImuChunk(
            start,
            0.01,
            noise[0],
            # Upright sensors: the z axis away from a body says where it faces.
            noise[1] + np.array([0.0, 9.81, 0.0]),
            1e-3 * noise[2] + np.array([2e-5, -4e-5, 0.0]),
            np.zeros((sensors, 5), dtype=np.uint8),
        )


def calibrate_still(pipeline: Pipeline, sensors: int) -> None:
    """Run a pipeline of worn or single sensors over a pose, calibrate it, and store what follows.

    Raises
    ------
    CalibrationError, SetupError
        The pipeline cannot be calibrated so.
    """
    chunks = list(still(sensors, 400))
    for chunk in chunks:
        pipeline.step(chunk)
    pose = ImuChunk(
        100,
        0.01,
        *(
            np.concatenate([getattr(chunk, name) for chunk in chunks[20:]], axis=1)
            for name in ("gyroscope_radps", "accelerometer_mps2", "magnetometer_t", "quality")
        ),
    )
    pipeline.calibrate(pose, "n_pose")
    frames = [
        pipeline.step(replace(chunk, first_tick=chunk.first_tick + 400)) for chunk in still(sensors, 20)
    ]
    # As it is stored and replayed.
    data, _, scale = frame_codec.pack(frames)
    frame_codec.unpack(frame_codec.FRAMES_CODEC, data, scale, 20, pipeline.layout)
