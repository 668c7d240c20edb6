"""One packet's values to SI signals with their quality: scales, clip levels and sensors that gave nothing."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from app.network.declaration import Declaration
from app.network.packet import FLOAT32, INT16, Packet, PacketFlag
from app.network.unpack_kernel import unpack
from estimators.channels import CARRIED, INERTIAL_WIDTH, MOTION, Channel, ChannelSpec
from estimators.recording import Float, SampleQuality

STUCK_LIMIT_S = 0.5
"""A sensor that repeats the same value in every inertial channel for so long is not measuring: noise alone
moves the last bit."""
_LARGEST_COUNT = 32767.0
_BACKFILLED_QUALITY = int(SampleQuality.BACKFILLED)
_MAGNETOMETER = int(Channel.MAGNETOMETER)
_BACKFILLED, _CLIPPED = int(PacketFlag.BACKFILLED), int(PacketFlag.SATURATED)
"""Plain integers: an operation on a flag costs a microsecond, and every packet has several."""


class Unpacker:
    """Unpacks the packets of one session in order.

    Parameters
    ----------
    has_magnetometer : bool
        Whether the signals carry a third channel; NaN in packets without one.
    clip_levels : ndarray, shape (S, 2, 2, 3)
        From which on samples count as clipped though nobody declared it, as `RecordingCheck.clip_levels`. Looked at
        with every packet: whoever finds a level writes it there.
    """

    def __init__(self, declaration: Declaration, has_magnetometer: bool, clip_levels: Float) -> None:
        self._clip_levels = clip_levels
        self.channel_count = 3 if has_magnetometer else 2
        scales = [declaration.scales.get(spec.name, np.nan) for spec in MOTION]
        clips = [0.999 * declaration.full_scales.get(spec.name, np.inf) for spec in MOTION[:2]]
        count_clips = np.fmin(clips, 32766.5 * np.array(scales[:2]))
        self._of_encoding = {
            FLOAT32: (np.ones(3), np.array(clips)),
            INT16: (np.array(scales), count_clips),
        }
        self._scales = declaration.scales
        self._same_values: dict[str, NDArray[np.int64]] = {}
        self._last_values: dict[str, Float] = {}
        self._stuck_ticks = max(2, round(STUCK_LIMIT_S * declaration.rate_hz))
        self._same_ticks = np.zeros(declaration.sensor_count, dtype=np.int64)
        self._last_sent = np.full((2, declaration.sensor_count, 3), np.nan)

    def share(self, last_sent: Float, same_ticks: NDArray[np.int64], clip_levels: Float) -> None:
        """Go on over these arrays, which another may carry on as well."""
        if self._last_sent is not last_sent:
            last_sent[...], same_ticks[...] = self._last_sent, self._same_ticks
        self._last_sent, self._same_ticks, self._clip_levels = last_sent, same_ticks, clip_levels

    def own(self, clip_levels: Float) -> None:
        """Go on over arrays of its own, and these clip levels."""
        self._last_sent, self._same_ticks = self._last_sent.copy(), self._same_ticks.copy()
        self._clip_levels = clip_levels
        self._last_values = {cell: values.copy() for cell, values in self._last_values.items()}
        self._same_values = {cell: ticks.copy() for cell, ticks in self._same_values.items()}

    def share_cells(self, last: Float, same_ticks: NDArray[np.int64]) -> None:
        """Go on over these arrays for the only cell there is, shapes (S, width) and (S,)."""
        for cell in self._last_values:
            last[...], same_ticks[...] = self._last_values[cell], self._same_values[cell]
            self._last_values[cell], self._same_values[cell] = last, same_ticks

    def state(self) -> dict[str, NDArray[Any]]:
        """Return copies of what the next packet depends on."""
        cells: dict[str, NDArray[Any]] = {
            f"last.{cell}": values.copy() for cell, values in self._last_values.items()
        }
        cells |= {f"same.{cell}": ticks.copy() for cell, ticks in self._same_values.items()}
        return {"last_sent": self._last_sent.copy(), "same_ticks": self._same_ticks.copy(), **cells}

    def restore(self, state: Mapping[str, NDArray[Any]]) -> None:
        """Go on where the instance that gave `state` stood."""
        self._last_sent, self._same_ticks = state["last_sent"].copy(), state["same_ticks"].copy()
        for name, values in state.items():
            part, _, cell = name.partition(".")
            if cell:
                (self._last_values if part == "last" else self._same_values)[cell] = values.copy()

    def fill(self, x: Any, carried: tuple[ChannelSpec, ...]) -> None:
        """Write into a record of `SLOT` how packets are unpacked that carry these channels beside motion."""
        scales, count_clips = self._of_encoding[INT16]
        x["mask"] = sum(int(spec.bit) for spec in (*MOTION[: self.channel_count], *carried))
        x["width"] = 3 * self.channel_count + sum(spec.width for spec in carried)
        columns = [self._scales.get(spec.name, 1.0) for spec in carried for _ in range(spec.width)]
        x["carried_scale"][: len(columns)] = columns
        is_declared = all(spec.name in self._scales for spec in carried)
        x["countable"] = is_declared and bool(np.isfinite(scales[: self.channel_count]).all())
        x["stuck_ticks"], x["scale"], x["count_clip"] = self._stuck_ticks, scales, count_clips
        x["clip"] = self._of_encoding[FLOAT32][1]

    def unpack(self, packet: Packet) -> tuple[Float, NDArray[np.uint8]]:
        """Return the next packet's signals and quality.

        Parameters
        ----------
        packet : Packet
            With gyroscope and accelerometer.

        Returns
        -------
        signals : ndarray, shape (channels, S, K, 3)
            Gyroscope in rad/s, accelerometer in m/s^2 and, with a magnetometer, T. NaN where missing.
        quality : ndarray of uint8, shape (S, K)
            `SampleQuality` bits.
        """
        ticks, sensors = packet.tick_count, packet.sensor_count
        used = min(3 if packet.channels & _MAGNETOMETER else 2, self.channel_count)
        scales, clips = self._of_encoding[packet.encoding]
        signals = np.empty((self.channel_count, sensors, ticks, 3))
        quality = np.empty((sensors, ticks), dtype=np.uint8)
        unpack(
            packet.values,
            scales[:used],
            clips,
            self._clip_levels,
            packet.flags & _CLIPPED != 0,
            _BACKFILLED_QUALITY if packet.flags & _BACKFILLED else 0,
            self._stuck_ticks,
            self._last_sent,
            self._same_ticks,
            signals,
            quality,
        )
        return signals, quality

    def carried(self, packet: Packet) -> dict[str, Float]:
        """Return what the packet carries beyond inertial sensors and magnetometers, by field of `ImuChunk`.

        Returns
        -------
        dict of str to ndarray, shape (S, K) or (S, K, width)
            NaN where a sensor gave nothing, a count is at its end, or all values of a cell repeat themselves, not zero,
            to the last bit for half a second: such a cell does not measure.
        """
        cells = {spec.cell for spec in CARRIED if spec.cell and packet.channels & spec.bit}
        nothing = ~packet.values[:, :, :INERTIAL_WIDTH].any(axis=2).T
        found: dict[str, Float] = {}
        for spec in CARRIED:
            sent = packet.channel(spec.bit)
            if sent is None and spec.cell not in cells:
                continue
            values = np.full((packet.sensor_count, packet.tick_count, spec.width), np.nan)
            if sent is not None:
                values[:] = sent.transpose(1, 0, 2)
                if packet.encoding == INT16:
                    values[np.abs(values) > _LARGEST_COUNT - 0.5] = np.nan
                    values *= self._scales.get(spec.name, 1.0)
                values[nothing] = np.nan
            found[spec.field] = values if spec.width > 1 else values[:, :, 0]
        for cell in cells:
            self._leave_out_stuck(cell, [found[spec.field] for spec in CARRIED if spec.cell == cell])
        return found

    def _leave_out_stuck(self, cell: str, parts: list[Float]) -> None:
        values = np.concatenate(parts, axis=2)
        sensors, ticks, width = values.shape
        last = self._last_values.setdefault(cell, np.full((sensors, width), np.nan))
        same_ticks = held = self._same_values.setdefault(cell, np.zeros(sensors, dtype=np.int64))
        before = np.concatenate([last[:, None], values[:, :-1]], axis=1)
        same = (values == before).all(axis=2) & values.any(axis=2)
        last[:] = values[:, -1]
        for k in range(ticks) if same.any() else ():
            same_ticks = np.where(same[:, k], same_ticks + 1, 0)
            for part in parts:
                part[same_ticks >= self._stuck_ticks, k] = np.nan
        held[:] = same_ticks if same.any() else 0
