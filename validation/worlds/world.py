"""A random world: one sensor, its readings on common ticks, the truth, and the conditions that were drawn."""

from dataclasses import dataclass, replace
from typing import Final
from zlib import crc32

import numpy as np
from numpy.typing import NDArray

from estimators import orientation, rotation
from estimators.conventions import GRAVITY_MPS2
from estimators.recording import Float, ImuChunk, Recording, SampleQuality, SensorSignals
from estimators.signals import to_common_ticks
from validation.worlds.conditions import Conditions, conditions_of, stream
from validation.worlds.device import Readings, read
from validation.worlds.field import field_along
from validation.worlds.motion import acceleration, moved

TUNING_SEEDS: Final = 10_000
"""Seeds below this are worlds that anybody may tune on."""
_JUDGED_SEEDS: Final = 1_000_000_000
_FINE_HZ: Final = 800.0
_LEAST_FINE: Final = 4
_UP: Final = np.array([0.0, 0.0, GRAVITY_MPS2])
_LOST_SHARE: Final = 0.05
_SHORT_S, _LONG_S = (0.01, 0.15), (0.3, 2.0)
_FREEZE_S: Final = (1.0, 5.0)
_SOUND_START_S: Final = 1.0
_MOST_JITTER: Final = 0.4


@dataclass(frozen=True)
class World:
    """One recording with its truth.

    Attributes
    ----------
    chunk : ImuChunk
        One sensor; quality flags as a reader sets them.
    q_earth_sensor : ndarray, shape (K, 4)
        Truth at the ticks, of the sensor.
    is_measured : ndarray of bool, shape (K,)
        Something was measured: False where samples are MISSING or the sensor as a whole repeats itself.
    gyroscope_clip_radps, accelerometer_clip_mps2 : float, or None
        End of the range of a triad that is cut off, whether the recording declares it or not.
    """

    chunk: ImuChunk
    q_earth_sensor: Float
    is_measured: NDArray[np.bool_]
    conditions: Conditions
    gyroscope_clip_radps: float | None
    accelerometer_clip_mps2: float | None


def world_seed(seed: int) -> int:
    """Return the seed of the world that an experiment draws for one of its own seeds.

    Seeds below `TUNING_SEEDS` are taken as they are. All others are moved by a digest of the names and versions of our
    filter and smoother: nobody can have tuned a version on the worlds that judge it.
    """
    if seed < TUNING_SEEDS:
        return seed
    kinds = orientation.available(with_offline=True)
    judged = " ".join(f"{name} {kinds[name].version}" for name in ("telemotion", "telemotion_smoother"))
    return TUNING_SEEDS + (crc32(judged.encode()) + seed) % _JUDGED_SEEDS


def draw(seed: int, conditions: Conditions | None = None) -> World:
    """Draw a world; the same seed gives the same bits.

    Parameters
    ----------
    conditions : Conditions, optional
        Instead of those of the seed.
    """
    drawn = conditions_of(seed) if conditions is None else conditions
    q, true = _true_readings(drawn, seed)
    found = read(drawn, true, stream(seed, "device"))
    generator = stream(seed, "link")
    found, frozen = _frozen(drawn, found, generator)
    stamps = np.arange(len(q)) / drawn.rate_hz
    jitter = drawn.jitter * generator.normal(size=len(q) - 2)
    # Stamps of neighbours never change places, and the grid of ticks begins and ends with the samples.
    stamps[1:-1] += np.clip(jitter, -_MOST_JITTER, _MOST_JITTER) / drawn.rate_hz
    arrives = _arrives(drawn, len(q), generator)
    signals = SensorSignals(
        stamps[arrives],
        found.gyroscope_radps[arrives],
        found.accelerometer_mps2[arrives],
        found.magnetometer_t[arrives] if drawn.axes == 9 else None,
    )
    declared = drawn.is_range_declared
    chunk = to_common_ticks(
        Recording({"imu": signals}, drawn.rate_hz),
        drawn.rate_hz,
        gyroscope_clip_radps=found.gyroscope_clip_radps if declared else None,
        accelerometer_clip_mps2=found.accelerometer_clip_mps2 if declared else None,
    )
    is_measured = (chunk.quality[0] & int(SampleQuality.MISSING)) == 0
    if drawn.freeze == "whole":
        is_measured[frozen] = False
    return World(chunk, q, is_measured, drawn, found.gyroscope_clip_radps, found.accelerometer_clip_mps2)


def _true_readings(conditions: Conditions, seed: int) -> tuple[Float, Readings]:
    """Return attitudes at the samples, and what an ideal device reads.

    A sample of the gyroscope is the mean over the sampling interval that ends with the attitude; one of the
    accelerometer likewise, or the value at its end.
    """
    fine = max(_LEAST_FINE, int(np.ceil(_FINE_HZ / conditions.rate_hz)))
    step_s = 1.0 / (conditions.rate_hz * fine)
    count = int(conditions.duration_s * conditions.rate_hz)
    time_s = np.arange(-fine, (count - 1) * fine + 1, dtype=np.float64) * step_s
    q, place = moved(conditions, time_s, stream(seed, "motion"))
    ends = fine * np.arange(1, count + 1)
    steps = rotation.log(rotation.multiply(rotation.conjugate(q[:-1]), q[1:])) / step_s
    force = rotation.rotate(rotation.conjugate(q), acceleration(place, step_s) + _UP)
    if conditions.is_averaging:
        middle = 0.5 * (force[1:] + force[:-1])
        samples = middle.reshape(count, fine, 3).mean(axis=1)
    else:
        samples = force[ends]
    late = np.maximum(ends - round(conditions.delay_s / step_s), 0)
    field, iron = field_along(conditions, time_s[late], place[late], stream(seed, "field"))
    seen = rotation.rotate(rotation.conjugate(q[late]), field) + iron
    return q[ends], Readings(steps.reshape(count, fine, 3).mean(axis=1), samples, seen)


def _frozen(
    conditions: Conditions, found: Readings, generator: np.random.Generator
) -> tuple[Readings, slice]:
    """Let a triad, or the whole sensor, repeat one value for some seconds."""
    count, rate_hz = len(found.gyroscope_radps), conditions.rate_hz
    lasts = round(generator.uniform(*_FREEZE_S) * rate_hz)
    first = int(generator.integers(round(0.2 * count), round(0.8 * count)))
    ticks = slice(first, min(first + lasts, count))
    names = [
        name
        for name in ("gyroscope_radps", "accelerometer_mps2", "magnetometer_t")
        if conditions.freeze == "whole" or name.startswith(conditions.freeze)
    ]
    held = {name: getattr(found, name).copy() for name in names}
    for values in held.values():
        values[ticks] = values[ticks.start - 1]
    return replace(found, **held), ticks


def _arrives(conditions: Conditions, count: int, generator: np.random.Generator) -> NDArray[np.bool_]:
    """Return which samples are not lost; a burst may be longer than what is bridged."""
    arrives = np.ones(count, dtype=np.bool_)
    if conditions.loss == "none":
        return arrives
    sound = round(_SOUND_START_S * conditions.rate_hz)
    left = _LOST_SHARE * count * generator.uniform(0.2, 1.6)
    while left > 0:
        is_long = conditions.loss == "long" and generator.random() < 0.1
        burst = max(1, round(generator.uniform(*(_LONG_S if is_long else _SHORT_S)) * conditions.rate_hz))
        start = int(generator.integers(sound, count - 1))
        arrives[start : start + burst] = False
        left -= burst
    arrives[-1] = True
    return arrives
