"""Where feet are, live: with a delay below one second, smoothed over the last moments."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from estimators.errors import ShapeError
from estimators.gait.foot import layout as at
from estimators.gait.foot.filter import is_usable_rate
from estimators.gait.foot.parameters import FootParameters, foot_parameters
from estimators.gait.foot.samples import BRIDGED, CLIPPED, MISSING
from estimators.gait.foot.stream import COLUMNS, FootStream
from estimators.orientation._streaming import ChunkGuard, copied, usable_samples
from estimators.recording import Float, ImuChunk, SampleQuality

Bool = NDArray[np.bool_]


@dataclass(frozen=True)
class FootChunk:
    """What was released of S feet's sensors: K consecutive ticks that lie in the past.

    Attributes
    ----------
    first_tick : int
    time_step_s : float
    position_m, velocity_mps : ndarray, shape (S, K, 3)
        Of the sensor; world of each sensor with z up, origin and heading of its first sample.
    q_world_sensor : ndarray, shape (S, K, 4)
    pivot_m : ndarray, shape (S, K, 3)
        From the contact point to the sensor, sensor axes.
    position_sigma_m, attitude_sigma_rad : ndarray, shape (S, K, 3)
        One sigma; infinite before the first sample of a sensor.
    statistic : ndarray, shape (S, K)
        T of the stance detector.
    is_stance : ndarray of bool, shape (S, K)
        The foot stands, and the vertical is known: none before, in a record that begins in mid-stride or anew.
    flags : ndarray of uint8, shape (S, K)
        `FootFlag` bits.
    """

    first_tick: int
    time_step_s: float
    position_m: Float
    velocity_mps: Float
    q_world_sensor: Float
    pivot_m: Float
    position_sigma_m: Float
    attitude_sigma_rad: Float
    statistic: Float
    is_stance: Bool
    flags: NDArray[np.uint8]

    @property
    def tick_count(self) -> int:
        """Number of ticks K."""
        return int(self.flags.shape[1])


class FootTracker:
    """Streams the trajectories of S feet; one call serves all.

    The same samples give the same result, bit for bit, one by one, in uneven chunks, in one batch, or across
    `state` and `restore`. What comes back is up to `delay_ticks` old: a stance is known only when the foot's lowest
    unrest of the next half second is, and impacts are understood only after them.

    Parameters
    ----------
    sensor_count : int
    time_step_s : float
    parameters : mapping or FootParameters, optional

    Notes
    -----
    Section 6 of the page on foot tracking: eq. (2) to (15) delayed by the detector's look-ahead, eq. (16) back over
    `lag_s`, released every `release_s`.
    """

    def __init__(
        self,
        sensor_count: int,
        time_step_s: float,
        parameters: Mapping[str, Any] | FootParameters | None = None,
    ) -> None:
        self._guard = ChunkGuard(sensor_count, time_step_s)
        self._parameters = foot_parameters(parameters)
        self._rate_hz = 1.0 / time_step_s
        if not is_usable_rate(self._rate_hz):
            raise ShapeError(f"a foot cannot be followed at {self._rate_hz:.4g} Hz; use 30 to 2000 Hz")
        self._streams = [FootStream(self._rate_hz, self._parameters) for _ in range(sensor_count)]
        self._first_tick = -1

    @property
    def delay_ticks(self) -> int:
        """Most ticks between a sample and its release."""
        return self._streams[0].delay

    @property
    def parameters(self) -> dict[str, Any]:
        """Every parameter with its value and its unit in its name."""
        return asdict(self._parameters)

    def update(self, chunk: ImuChunk) -> FootChunk:
        """Take the next ticks; returns what is old enough, which may be nothing."""
        chunk = self._guard.accept(chunk)
        if self._first_tick < 0:
            self._first_tick = chunk.first_tick
        usable = usable_samples(chunk)
        kind = np.where(usable, 0, MISSING).astype(np.uint8)
        kind |= np.where((chunk.quality & SampleQuality.BRIDGED) != 0, BRIDGED, 0).astype(np.uint8)
        kind |= np.where((chunk.quality & SampleQuality.SATURATED) != 0, CLIPPED, 0).astype(np.uint8)
        for s, stream in enumerate(self._streams):
            field = None if chunk.magnetometer_t is None else chunk.magnetometer_t[s]
            stream.take(chunk.gyroscope_radps[s], chunk.accelerometer_mps2[s], field, kind[s])
        return self._collect(is_end=False)

    def finish(self) -> FootChunk:
        """Release what is left, judged without what would have come; no update may follow."""
        return self._collect(is_end=True)

    def _collect(self, is_end: bool) -> FootChunk:
        first = self._streams[0].released
        released = [stream.advance(is_end) for stream in self._streams]
        values = np.stack([values for values, _ in released])
        flags = np.stack([flags for _, flags in released])
        sigma = values[:, :, at.STATE :]
        return FootChunk(
            first_tick=max(self._first_tick, 0) + first,
            time_step_s=self._guard.time_step_s,
            position_m=values[:, :, at.P : at.P + 3],
            velocity_mps=values[:, :, at.V : at.V + 3],
            q_world_sensor=values[:, :, at.Q : at.Q + 4],
            pivot_m=values[:, :, at.PIVOT : at.PIVOT + 3],
            position_sigma_m=sigma[:, :, 0:3],
            attitude_sigma_rad=sigma[:, :, 3:6],
            statistic=values[:, :, COLUMNS - 2],
            is_stance=values[:, :, COLUMNS - 1] > 0.0,
            flags=flags,
        )

    def state(self) -> dict[str, NDArray[Any]]:
        """Return everything that the next update depends on, as arrays that can be stored."""
        arrays = {
            f"{name}_{s}": values
            for s, stream in enumerate(self._streams)
            for name, values in stream.state().items()
        }
        ticks = (self._guard.next_tick, self._first_tick, len(self._streams))
        return arrays | {"ticks": np.array(ticks, dtype=np.int64), "screen": self._guard.memory.copy()}

    def restore(self, state: Mapping[str, NDArray[Any]]) -> None:
        """Continue exactly where the instance that gave `state` stood.

        Raises
        ------
        ShapeError
            When the state is not of a tracker built alike.
        """
        if "ticks" not in state or int(state["ticks"][2]) != len(self._streams):
            raise ShapeError("the stored state is not of a tracker of as many feet")
        for s, stream in enumerate(self._streams):
            suffix = f"_{s}"
            own = {
                name.removesuffix(suffix): values for name, values in state.items() if name.endswith(suffix)
            }
            stream.restore(own)
        self._guard.memory = copied(state, "screen", self._guard.memory)
        self._guard.next_tick, self._first_tick = int(state["ticks"][0]), int(state["ticks"][1])


__all__ = ["FootChunk", "FootTracker"]
