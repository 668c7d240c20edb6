"""Where feet are, live: with a delay below one second, smoothed over the last moments."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from estimators.errors import ShapeError
from estimators.gait._stance import Windows
from estimators.gait.foot import layout as at
from estimators.gait.foot.filter import is_usable_rate
from estimators.gait.foot.live import ordinary_kernel
from estimators.gait.foot.live.rows import (
    BRIDGED,
    CLIPPED,
    MISSING,
    PIECE_TICKS,
    FootRows,
    Sizes,
    foot_rows,
    sizes_of,
)
from estimators.gait.foot.live.stream import FootStream
from estimators.gait.foot.parameters import FootParameters, foot_parameters
from estimators.gait.foot.trajectory import COAST_S
from estimators.orientation._streaming import ChunkGuard, copied, usable_samples
from estimators.recording import Float, ImuChunk, SampleQuality

Bool = NDArray[np.bool_]
Released = tuple[Float, NDArray[np.uint8]]
"""Values (S, K, COLUMNS) and flags (S, K)."""
_NO_FIELD = np.empty((0, 0, 3))


@dataclass(frozen=True)
class FootChunk:
    """What was released of S feet's sensors: K consecutive ticks that lie in the past.

    Attributes
    ----------
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
        The foot stands, and the vertical is known: none before, in a record that begins in mid-stride or again.
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
        chosen, windows = self._parameters, Windows.at_rate(self._rate_hz, self._parameters)
        block = max(1, round(chosen.release_s * self._rate_hz))
        self._sizes = sizes_of(windows, block, block * max(1, round(chosen.lag_s / chosen.release_s)))
        self._rows: FootRows = foot_rows(sensor_count, self._sizes)
        self._streams = [
            FootStream(self._rate_hz, chosen, windows, self._sizes, self._rows, s)
            for s in range(sensor_count)
        ]
        self._scales = np.array([chosen.moving_gyroscope_radps, chosen.moving_accelerometer_mps2])
        self._first_tick = -1

    def go_on_over(self, rows: FootRows) -> None:
        """Hold everything in other rows from now on, of as many feet; nothing happens where they are its own already.

        A pool hands over a session's part of its rows, so that compiled code finds what the tracker left.
        """
        if rows.foot.ctypes.data == self._rows.foot.ctypes.data:
            return
        for name in FootRows._fields:
            getattr(rows, name)[...] = getattr(self._rows, name)
        self._rows = rows
        self._streams = [stream.over(rows, s) for s, stream in enumerate(self._streams)]

    def own(self) -> None:
        """Hold everything in rows of its own again."""
        self.go_on_over(FootRows._make(values.copy() for values in self._rows))

    @property
    def is_plain(self) -> bool:
        """Whether nothing of a new stretch is still to be released, of any foot."""
        return all(stream.is_plain for stream in self._streams)

    @property
    def delay_ticks(self) -> int:
        """Most ticks between a sample and its release."""
        return self._sizes.ahead + self._sizes.lag + self._sizes.block

    @property
    def constants(self) -> tuple[Sizes, float, float, Float, Float, Float, Float]:
        """What `ordinary_kernel.release` takes behind the rows and the first of them, in its order."""
        one = self._streams[0]
        return (
            self._sizes,
            1.0 / self._rate_hz,
            COAST_S * self._rate_hz,
            self._scales,
            one.judged.decision,
            one.judged.noise,
            one.settings,
        )

    @property
    def parameters(self) -> dict[str, Any]:
        """Every parameter with its value and its unit in its name."""
        return asdict(self._parameters)

    def update(self, chunk: ImuChunk) -> FootChunk:
        """Take the next ticks; returns what is old enough, which may be nothing."""
        return self._chunk(self._streams[0].released, self.released(chunk))

    def finish(self) -> FootChunk:
        """Release what is left, judged without what would have come; no update may follow."""
        return self._chunk(self._streams[0].released, self._advance(is_end=True))

    def released(self, chunk: ImuChunk) -> Released:
        """Take the next ticks as `update`; returns values, shape (S, K, COLUMNS), and flags, shape (S, K)."""
        chunk = _as_compiled(self._guard.accept(chunk))
        if self._first_tick < 0:
            self._first_tick = chunk.first_tick
        if chunk.tick_count <= PIECE_TICKS:
            return self._take(chunk)
        parts = [
            self._take(chunk.ticks(start, min(start + PIECE_TICKS, chunk.tick_count)))
            for start in range(0, chunk.tick_count, PIECE_TICKS)
        ]
        values, flags = (np.concatenate(some, axis=1) for some in zip(*parts, strict=True))
        return values, flags

    def _take(self, piece: ImuChunk) -> Released:
        field = _NO_FIELD if piece.magnetometer_t is None else piece.magnetometer_t
        if self.is_plain and ordinary_kernel.take(
            self._rows, 0, piece.gyroscope_radps, piece.accelerometer_mps2, field, piece.quality
        ):
            return self._ordinary()
        usable = usable_samples(piece)
        kind = np.where(usable, 0, MISSING).astype(np.uint8)
        kind |= np.where((piece.quality & SampleQuality.BRIDGED) != 0, BRIDGED, 0).astype(np.uint8)
        kind |= np.where((piece.quality & SampleQuality.SATURATED) != 0, CLIPPED, 0).astype(np.uint8)
        for s, stream in enumerate(self._streams):
            own = None if piece.magnetometer_t is None else piece.magnetometer_t[s]
            stream.take(piece.gyroscope_radps[s], piece.accelerometer_mps2[s], own, kind[s])
        return self._advance(is_end=False)

    def _ordinary(self) -> Released:
        """Release what may be, all of it as usual."""
        sizes, streams = self._sizes, self._streams
        first = streams[0].released
        blocks = (streams[0].samples.stop - sizes.ahead - first - sizes.lag) // sizes.block
        ticks = max(blocks, 0) * sizes.block
        values = np.empty((len(streams), ticks, at.COLUMNS))
        flags = np.empty((len(streams), ticks), dtype=np.uint8)
        if not ticks:
            return values, flags
        ordinary_kernel.release(self._rows, 0, *self.constants, values, flags)
        for s, stream in enumerate(streams):
            stream.widen(first, values[s], flags[s])
        return values, flags

    def _advance(self, is_end: bool) -> Released:
        released = [stream.advance(is_end) for stream in self._streams]
        return np.stack([values for values, _ in released]), np.stack([flags for _, flags in released])

    def _chunk(self, first: int, released: Released) -> FootChunk:
        values, flags = released
        return FootChunk(
            first_tick=max(self._first_tick, 0) + first,
            time_step_s=self._guard.time_step_s,
            position_m=values[:, :, at.P : at.P + 3],
            velocity_mps=values[:, :, at.V : at.V + 3],
            q_world_sensor=values[:, :, at.Q : at.Q + 4],
            pivot_m=values[:, :, at.PIVOT : at.PIVOT + 3],
            position_sigma_m=values[:, :, at.POSITION_SIGMA : at.ATTITUDE_SIGMA],
            attitude_sigma_rad=values[:, :, at.ATTITUDE_SIGMA : at.STATISTIC],
            statistic=values[:, :, at.STATISTIC],
            is_stance=values[:, :, at.STANDS] > 0.0,
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


def _as_compiled(chunk: ImuChunk) -> ImuChunk:
    """Return the chunk in the numbers that compiled code takes; nearly every one has them."""
    gyroscope, force, field = chunk.gyroscope_radps, chunk.accelerometer_mps2, chunk.magnetometer_t
    if (
        gyroscope.dtype == force.dtype == np.float64
        and (field is None or field.dtype == np.float64)
        and chunk.quality.dtype == np.uint8
    ):
        return chunk
    return replace(
        chunk,
        gyroscope_radps=gyroscope.astype(np.float64),
        accelerometer_mps2=force.astype(np.float64),
        magnetometer_t=None if field is None else field.astype(np.float64),
        quality=chunk.quality.astype(np.uint8),
    )
