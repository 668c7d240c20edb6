"""Simulated sensors in scenes that fool an orientation filter: swings, clips, freezes, fields that are off."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Final

import numpy as np

from estimators import rotation
from estimators.conventions import GRAVITY_MPS2
from estimators.recording import Float, ImuChunk

STEP_S: Final = 0.01
_REST_S, _LASTS_S = 4.0, 90.0
_FINE: Final = 10
"""Steps between two samples, over which a gyroscope turns and an accelerometer takes the mean."""
_FIELD_T: Final = np.array([0.0, 20e-6, -45e-6])
_UP: Final = np.array([0.0, 0.0, GRAVITY_MPS2])
_NOISE: Final = np.array([[0.002, 0.02, 0.3e-6], [0.005, 0.05, 0.6e-6], [0.01, 0.15, 1.2e-6]])
"""White noise of a sample of good, common and poor devices: rad/s, m/s^2, tesla."""
_BIAS_SD: Final = np.array([np.radians(0.5), 0.03, 0.3e-6])
_SCALE_SD: Final = np.array([0.003, 0.002, 0.003])
_COUNTS: Final = np.array([np.radians(0.06), 0.005, 0.15e-6])
_OFF_DEG: Final = 5.0
_CLIP_SHARE: Final = 0.7
_LEAST_RANGE_RADPS: Final = np.radians(250.0)
FROZEN_S: Final = 4.0
"""How long a freeze lasts."""
_BLOCK: Final = 8
_FOREIGN_S: Final = (30.0, 75.0)
_FOREIGN_DEG, _FOREIGN_STRENGTH = 40.0, 1.25
SCENES: Final = (
    "arm swings",
    "swings at constant length",
    "circles at constant length",
    "gyroscope clipped",
    "gyroscope frozen",
    "accelerometer frozen",
    "magnetometer frozen",
    "whole sensor frozen",
    "a block repeated",
    "whole field off",
    "foreign field for a time",
)


def scene(title: str, seeds: Sequence[int]) -> tuple[ImuChunk, Float]:
    """Return the readings of one sensor a seed, of devices good, common and poor in turn, and the truth.

    Parameters
    ----------
    title : str
        Of `SCENES`.

    Returns
    -------
    ImuChunk
        Rests for some seconds, then moves; 90 s at 100 Hz, rounded to the counts of a device of 16 bits.
    q_earth_sensor : ndarray, shape (S, K, 4)
    """
    parts = []
    for seed in seeds:
        generator = np.random.default_rng([seed, SCENES.index(title)])
        q, place = _motion(title, generator)
        parts.append((*_readings(title, q, place, seed % len(_NOISE), generator), q[::_FINE]))
    gyroscope, accelerometer, magnetometer, truth = (np.stack(part) for part in zip(*parts, strict=True))
    quality = np.zeros(truth.shape[:2], dtype=np.uint8)
    chunk = ImuChunk(0, STEP_S, gyroscope, accelerometer, magnetometer, quality)
    return (_frozen(chunk, title, seeds) if "frozen" in title or "block" in title else chunk), truth


def frozen_ticks(seed: int) -> slice:
    """Return the ticks of a freeze, in the middle of movement."""
    first = round((30.0 + np.random.default_rng([seed, 99]).uniform(0.0, 10.0)) / STEP_S)
    return slice(first, first + round(FROZEN_S / STEP_S))


def _motion(title: str, generator: np.random.Generator) -> tuple[Float, Float]:
    """Return attitude, and place in the earth frame, in fine steps."""
    step_s = STEP_S / _FINE
    time_s = step_s * np.arange(round(_LASTS_S / STEP_S) * _FINE)
    begun = np.clip((time_s - _REST_S) / 2.0, 0.0, 1.0)
    fade = begun**2 * (3.0 - 2.0 * begun)
    length_m = generator.uniform(0.25, 0.9)
    phase = generator.uniform(0.0, 2.0 * np.pi, 3)
    steady = "constant" in title
    # A person does not swing like a machine: size and pace come and go, unless the scene is about just that.
    sway = (0.0 if steady else 0.35) * np.sin(2.0 * np.pi * generator.uniform(0.03, 0.08) * time_s + phase[2])
    is_fast = "clipped" in title
    frequency = generator.uniform(1.2, 1.7) if is_fast else generator.uniform(0.3, 1.2)
    about = 2.0 * np.pi * frequency * time_s + phase[0] + 1.5 * sway
    amplitude = np.radians(generator.uniform(45.0 if is_fast else 30.0, 60.0)) * (1.0 + sway) * fade
    heading = generator.uniform(-np.pi, np.pi) + fade * 0.6 * np.sin(2.0 * np.pi * 0.05 * time_s + phase[1])
    swing = amplitude * np.sin(about)
    aside = amplitude * np.cos(about) if "circles" in title else 0.25 * amplitude * np.sin(0.5 * about)
    twist = 0.0 * swing if steady else 0.8 * amplitude * np.sin(0.7 * about + phase[1])
    turns = [
        rotation.exp(angle[:, None] * np.eye(3)[axis])
        for angle, axis in ((heading, 2), (aside, 0), (swing, 1), (twist, 2))
    ]
    limb = turns[0]
    for turn in turns[1:]:
        limb = rotation.multiply(limb, turn)
    place = rotation.rotate(limb, np.array([0.0, 0.0, -length_m]))
    return rotation.multiply(limb, rotation.normalize(generator.normal(size=4))), place


def _readings(
    title: str, q: Float, place: Float, device: int, generator: np.random.Generator
) -> tuple[Float, Float, Float]:
    fine_s = STEP_S / _FINE
    push = np.gradient(np.gradient(place, fine_s, axis=0), fine_s, axis=0)
    force = rotation.rotate(rotation.conjugate(q), push + _UP)
    steps = rotation.log(rotation.multiply(rotation.conjugate(q[:-1]), q[1:])) / fine_s
    steps = np.vstack((steps[:1], steps))
    ticks = len(q) // _FINE
    # A sample is the mean over the interval that ends with it.
    at = _FINE * np.arange(ticks)
    span = np.maximum(at[:, None] - np.arange(_FINE), 0)
    readings = [steps[span].mean(axis=1), force[span].mean(axis=1), _field(title, q[::_FINE])]
    for kind, values in enumerate(readings):
        values *= 1.0 + _SCALE_SD[kind] * generator.normal(size=3)
        values += _BIAS_SD[kind] * generator.normal(size=3)
        values += _NOISE[device, kind] * generator.normal(size=values.shape)
        if kind == 0 and "clipped" in title:
            level = max(_LEAST_RANGE_RADPS, _CLIP_SHARE * np.abs(values).max())
            np.clip(values, -level, level, out=values)
        readings[kind] = _COUNTS[kind] * np.rint(values / _COUNTS[kind])
    return readings[0], readings[1], readings[2]


def _field(title: str, q: Float) -> Float:
    """Return the field in the sensor: of the earth, turned as a whole, or of another place for a time."""
    field = np.broadcast_to(_FIELD_T, (len(q), 3))
    if title == "whole field off":
        field = rotation.rotate(rotation.about_z(np.radians(_OFF_DEG)), field)
    if title == "foreign field for a time":
        time_s = STEP_S * np.arange(len(q))
        come = np.clip((time_s - _FOREIGN_S[0]) / 2.0, 0.0, 1.0) - np.clip(
            (time_s - _FOREIGN_S[1]) / 2.0, 0.0, 1.0
        )
        other = _FOREIGN_STRENGTH * rotation.rotate(rotation.about_z(np.radians(_FOREIGN_DEG)), _FIELD_T)
        field = field + come[:, None] * (other - field)
    return rotation.rotate(rotation.conjugate(q), field)


def _frozen(chunk: ImuChunk, title: str, seeds: Sequence[int]) -> ImuChunk:
    """Let one triad or all of them give their last value, or their last samples, again and again."""
    assert chunk.magnetometer_t is not None
    triads: dict[str, Any] = {
        "gyroscope_radps": chunk.gyroscope_radps.copy(),
        "accelerometer_mps2": chunk.accelerometer_mps2.copy(),
        "magnetometer_t": chunk.magnetometer_t.copy(),
    }
    length = _BLOCK if "block" in title else 1
    for name, values in triads.items():
        if "whole" in title or "block" in title or title.split()[0] in name:
            for s, seed in enumerate(seeds):
                ticks = frozen_ticks(seed)
                count = ticks.stop - ticks.start
                values[s, ticks] = values[s, ticks.start - length + np.arange(count) % length]
    return replace(chunk, **triads)
