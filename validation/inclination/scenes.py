"""Movements and sensors of Luinge and Veltink (2005) as the inclination method page prescribes them (4.2).

A trial is 4 s of stillness, the task, and 4 s of stillness again, at 100 Hz. The gyroscope gives the mean rate since
the last sample, the accelerometer the specific force with the acceleration by second difference of the position.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.signal import butter, sosfilt
from scipy.spatial.transform import Rotation

from estimators import orientation, rotation
from estimators.conventions import GRAVITY_MPS2
from estimators.recording import Float, ImuChunk

STEP_S = 0.01
STILL_S = 4.0
STILL_SAMPLES = 400
GYROSCOPE_SD_RADPS = 0.01
ACCELEROMETER_SD_MPS2 = 0.1
RAMP_RADPS2 = float(np.radians(2.0 * 0.25 / 60.0))
"""Offset rise: 2 degrees/s per degree Celsius at a quarter of a degree a minute."""
RAMP_SIGNS = np.array([1.0, -1.0, 1.0])
LIFTING_S = (7.0, 6.0, 5.0, 5.0, 4.0, 3.5, 3.5, 3.0, 3.0, 2.0)
CONSISTENT = {"rest_update": False, "bias_walk_degps_per_sqrt_s": 3e-3}
"""The consistent filter (A5) with the paper's own drift of the offset and without rest update, as the page has it."""

Pose = Callable[[Float], tuple[Rotation, Float]]
"""Time since the task began to attitude R_GS and position in m."""


@dataclass(frozen=True)
class Trial:
    """What one sensor saw, with its true attitude.

    `attitude` are the true quaternions earth-sensor, shape (N, 4).
    """

    attitude: Float
    gyroscope_radps: Float
    accelerometer_mps2: Float


def _bump(u: Float) -> Float:
    return np.asarray(0.5 - 0.5 * np.cos(2.0 * np.pi * np.clip(u, 0.0, 1.0)))


def lifting(
    interval_s: float, pelvis: bool, generator: np.random.Generator, duration_s: float = 120.0
) -> Pose:
    """S1: crates lifted from stack to stack, one every `interval_s`; the sensor is on the trunk or the pelvis."""
    cycles = int(duration_s / interval_s)
    heights = np.radians(np.linspace(75.0, 25.0, 6)) * min(1.0, interval_s / 3.5)
    reach = generator.uniform(0.9, 1.1, size=(cycles, 2))
    lean = np.radians(generator.uniform(-8.0, 8.0, size=(cycles, 2)))
    turn_sign = np.where(np.arange(cycles) // 6 % 2 == 0, 1.0, -1.0)
    number = np.arange(cycles) % 6
    first, second = heights[5 - number] * reach[:, 0], heights[number] * reach[:, 1]
    share = 0.55 if pelvis else 1.0
    lever = np.array([-0.10, 0.0, 0.05]) if pelvis else np.array([-0.08, 0.0, 0.38])

    def pose(time_s: Float) -> tuple[Rotation, Float]:
        cycle = np.clip(np.floor(time_s / interval_s).astype(int), 0, cycles - 1)
        u = np.clip(time_s / interval_s - cycle, 0.0, 1.0)
        down, up, across = _bump(u / 0.5), _bump((u - 0.5) / 0.5), _bump((u - 0.25) / 0.75)
        flexion = first[cycle] * down + second[cycle] * up
        lateral = lean[cycle, 0] * down + lean[cycle, 1] * up
        twist = np.radians(50.0) * turn_sign[cycle] * across
        attitude = Rotation.from_euler("ZYX", np.stack([twist, share * flexion, share * lateral], axis=1))
        shift = np.stack(
            [-0.12 * flexion / np.radians(75.0), 0.35 * turn_sign[cycle] * across, np.zeros_like(u)], axis=1
        )
        return attitude, attitude.apply(lever) + shift

    return pose


Segments = tuple[tuple[float, float, float, float], ...]
EATING: Segments = (
    (0, 10, 0.25, 20),
    (10, 30, 0.45, 25),
    (30, 50, 0.6, 30),
    (50, 80, 0.5, 25),
    (80, 90, 0.3, 45),
)
MORNING: Segments = (
    (0, 10, 0.8, 40),
    (10, 20, 0.7, 40),
    (20, 30, 0.6, 20),
    (30, 50, 0.9, 45),
    (50, 80, 2.5, 15),
)
"""Start and end in s, frequency in Hz, amplitude in degrees of each part of the task."""


def daily_task(segments: Segments, generator: np.random.Generator) -> Pose:
    """S2 and S3: the forearm while eating or at the morning toilet."""
    harmonics = (1, 2)
    size = generator.uniform(0.5, 1.0, size=(len(segments), 2, 3, 2))
    pace = generator.uniform(0.85, 1.15, size=(len(segments), 3, 2))
    phase = generator.uniform(0.0, 2.0 * np.pi, size=(len(segments), 2, 3, 2))
    base = np.radians(generator.uniform(-30.0, 30.0, size=(len(segments), 3)))

    def pose(time_s: Float) -> tuple[Rotation, Float]:
        angles, position = np.zeros((len(time_s), 3)), np.zeros((len(time_s), 3))
        for number, (start, end, frequency_hz, amplitude_deg) in enumerate(segments):
            inside = (time_s >= start) & (time_s < end)
            t = time_s[inside, None]
            edge = np.clip(np.minimum(t - start, end - t) / 0.8, 0.0, 1.0)
            window = edge**3 * (10.0 - 15.0 * edge + 6.0 * edge**2)
            total, moved = np.broadcast_to(base[number], (len(t), 3)).copy(), np.zeros((len(t), 3))
            for column, h in enumerate(harmonics):
                turn = 2.0 * np.pi * frequency_hz * h
                total += (
                    np.radians(amplitude_deg / h)
                    * size[number, 0, :, column]
                    * np.sin(turn * pace[number, :, column] * t + phase[number, 0, :, column])
                )
                reach_m = np.minimum(0.25 / h, 2.0 / h / turn**2 * size[number, 1, :, column])
                moved += reach_m * np.sin(turn * t + phase[number, 1, :, column])
            angles[inside], position[inside] = window * total, window * moved
        return Rotation.from_euler("ZYX", angles), position

    return pose


def record(
    pose: Pose, task_s: float, generator: np.random.Generator, *, length_s: float | None = None
) -> Trial:
    """Sample a task with still seconds before and after.

    Parameters
    ----------
    generator : Generator
        Sensor noise.
    length_s : float, optional
        Of the whole trial, longer than needed: the sensor lies still at the end.
    """
    samples = round((length_s or task_s + 2.0 * STILL_S) / STEP_S)
    time_s = np.arange(-1, samples) * STEP_S - STILL_S
    inner = np.clip(time_s, 0.0, task_s)
    attitude, middle = pose(inner)
    moving = (time_s > 0.0) & (time_s < task_s)
    step = 1e-3
    before, after = pose(inner - step)[1], pose(inner + step)[1]
    acceleration = np.where(moving[:, None], (before - 2.0 * middle + after) / step**2, 0.0)[1:]
    q = rotation.from_scipy(attitude)
    turned = rotation.log(rotation.multiply(rotation.conjugate(q[:-1]), q[1:]))
    shape = (samples, 3)
    force = rotation.rotate(rotation.conjugate(q[1:]), acceleration + np.array([0.0, 0.0, GRAVITY_MPS2]))
    return Trial(
        attitude=q[1:],
        gyroscope_radps=turned / STEP_S + generator.normal(size=shape) * GYROSCOPE_SD_RADPS,
        accelerometer_mps2=force + generator.normal(size=shape) * ACCELEROMETER_SD_MPS2,
    )


def to_chunk(trials: Sequence[Trial], offset_radps: Float | None = None) -> ImuChunk:
    """Make trials of one length the sensors of a network, with an offset (N, 3) or (S, N, 3) on the gyroscope."""
    rate = np.stack([trial.gyroscope_radps for trial in trials])
    return ImuChunk(
        first_tick=0,
        time_step_s=STEP_S,
        gyroscope_radps=rate if offset_radps is None else rate + offset_radps,
        accelerometer_mps2=np.stack([trial.accelerometer_mps2 for trial in trials]),
        magnetometer_t=None,
        quality=np.zeros(rate.shape[:2], dtype=np.uint8),
    )


def estimate(
    chunk: ImuChunk, name: str, parameters: dict[str, float | bool], *, zeroed: bool = True
) -> orientation.OrientationResult:
    """Run a filter; with `zeroed` the offset is first measured over the still seconds (A2)."""
    filter_ = orientation.create(name, chunk.sensor_count, chunk.time_step_s, parameters)
    if zeroed:
        filter_.set_gyroscope_bias(
            chunk.gyroscope_radps[:, :STILL_SAMPLES].mean(axis=1),
            GYROSCOPE_SD_RADPS / np.sqrt(STILL_SAMPLES),
        )
    return filter_.update(chunk)


def gyroscope_only(chunk: ImuChunk, attitude: Float) -> Float:
    """Strapdown integration from the end of the first stillness on, offset fixed; starts at the truth, (S, N, 4)."""
    bias = chunk.gyroscope_radps[:, :STILL_SAMPLES].mean(axis=1, keepdims=True)
    q = attitude.copy()
    turns = rotation.exp((chunk.gyroscope_radps - bias) * STEP_S)
    for k in range(STILL_SAMPLES, q.shape[1]):
        q[:, k] = rotation.multiply(q[:, k - 1], turns[:, k])
    return q


def accelerometer_only(chunk: ImuChunk) -> Float:
    """A7: force through a causal Butterworth low-pass of order 4 at 5 Hz, as direction of the vertical, (S, N, 3)."""
    sections = butter(4, 5.0, fs=1.0 / STEP_S, output="sos")
    start = chunk.accelerometer_mps2[:, :1]
    smooth = start + sosfilt(sections, chunk.accelerometer_mps2 - start, axis=1)
    return np.asarray(smooth / np.linalg.norm(smooth, axis=-1, keepdims=True))


def vertical_in_sensor(q: Float) -> Float:
    """Z_S, the vertical in sensor axes."""
    return rotation.rotate(rotation.conjugate(q), np.broadcast_to([0.0, 0.0, 1.0], (*q.shape[:-1], 3)))


def inclination_errors_deg(vertical: Float, attitude: Float) -> Float:
    """Angle between found and true vertical, valid at any size (A8.2)."""
    true = vertical_in_sensor(attitude)
    return np.asarray(
        np.degrees(
            np.arctan2(np.linalg.norm(np.cross(vertical, true), axis=-1), (vertical * true).sum(axis=-1))
        )
    )


def error_vectors_deg(q: Float, attitude: Float) -> Float:
    """A8.1: rotation vector in the earth frame from truth to estimate."""
    return np.degrees(rotation.log(rotation.multiply(q, rotation.conjugate(attitude))))


def seconds(samples: int) -> Float:
    """Time of each sample, s."""
    return np.arange(samples, dtype=np.float64) * STEP_S


def root_mean_square(values: Float) -> float:
    """Root mean square over all elements."""
    return float(np.sqrt(np.mean(np.square(values))))
