"""One packet's values to SI signals with their quality: scales, clip levels and sensors that gave nothing."""

import numpy as np
from numpy.typing import NDArray

from app.network.declaration import Declaration
from app.network.packet import FLOAT32, INT16, Channel, Packet, PacketFlag
from app.network.unpack_kernel import unpack
from estimators.recording import Float, SampleQuality

STUCK_LIMIT_S = 0.5
"""A sensor that repeats the same value in every inertial channel for so long is not measuring: noise alone
moves the last bit."""
_LARGEST_COUNT = 32767.0
_BACKFILLED_QUALITY = int(SampleQuality.BACKFILLED)
_MAGNETOMETER, _LOADS = int(Channel.MAGNETOMETER), int(Channel.FORCE | Channel.MOMENT)
_BACKFILLED, _CLIPPED = int(PacketFlag.BACKFILLED), int(PacketFlag.SATURATED)
"""Plain integers: an operation on a flag costs a microsecond, and every packet has several."""


class Unpacker:
    """Unpacks the packets of one session in order.

    Parameters
    ----------
    declaration : Declaration
    has_magnetometer : bool
        Whether the signals carry a third channel; NaN in packets without one.
    clip_levels : ndarray, shape (S, 2, 2, 3)
        From which on samples count as clipped though nobody declared it, as `RecordingCheck.clip_levels`. Looked at
        with every packet: whoever finds a level writes it there.
    """

    def __init__(self, declaration: Declaration, has_magnetometer: bool, clip_levels: Float) -> None:
        self._clip_levels = clip_levels
        self.channel_count = 3 if has_magnetometer else 2
        scales = (
            declaration.gyroscope_scale,
            declaration.accelerometer_scale,
            declaration.magnetometer_scale,
        )
        clips = [
            np.inf if clip is None else 0.999 * clip
            for clip in (declaration.clip_gyroscope_radps, declaration.clip_accelerometer_mps2)
        ]
        count_clips = [
            min(clip, np.inf if scale is None else 32766.5 * scale)
            for clip, scale in zip(clips, scales[:2], strict=True)
        ]
        self._of_encoding = {
            FLOAT32: (np.ones(3), np.array(clips)),
            INT16: (np.array(scales, dtype=float), np.array(count_clips)),
        }
        self._load_scales = (declaration.force_scale, declaration.moment_scale)
        self._same_loads = np.zeros(declaration.sensor_count, dtype=np.int64)
        self._last_loads = np.full((declaration.sensor_count, 6), np.nan)
        self._stuck_ticks = max(2, round(STUCK_LIMIT_S * declaration.rate_hz))
        self._same_ticks = np.zeros(declaration.sensor_count, dtype=np.int64)
        self._last_sent = np.full((2, declaration.sensor_count, 3), np.nan)

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

    @staticmethod
    def coil_state(packet: Packet) -> Float | None:
        """Return what each sensor's coils did, shape (S, K), NaN where the sensor gave nothing; None without bit 6."""
        sent = packet.channel(Channel.COIL_STATE)
        if sent is None:
            return None
        state = np.array(sent[:, :, 0].T, dtype=np.float64)
        inertial = packet.values[:, :, :6]
        if not inertial.all():
            state[~inertial.any(axis=2).T] = np.nan
        return state

    def loads(self, packet: Packet) -> Float | None:
        """Return force and moment of each sensor's load cell, shape (S, K, 6); None without bits 3 and 4.

        NaN where a sensor gave nothing, a count is at its end, or all six values repeat a load to the last bit for
        half a second: such a cell does not measure.
        """
        if not packet.channels & _LOADS:
            return None
        loads = np.full((packet.sensor_count, packet.tick_count, 6), np.nan)
        for number, (channel, scale) in enumerate(
            zip((Channel.FORCE, Channel.MOMENT), self._load_scales, strict=True)
        ):
            sent = packet.channel(channel)
            if sent is None:
                continue
            part = loads[:, :, 3 * number : 3 * number + 3]
            part[:] = sent.transpose(1, 0, 2)
            if packet.encoding == INT16:
                part[np.abs(part) > _LARGEST_COUNT - 0.5] = np.nan
                part *= 1.0 if scale is None else scale
        loads[~packet.values[:, :, :6].any(axis=2).T] = np.nan
        self._mark_stuck(loads)
        return loads

    def _mark_stuck(self, loads: Float) -> None:
        """Leave out a load, not zero, that has stayed as it is to the last bit for long: nobody measured it."""
        before = np.concatenate([self._last_loads[:, None], loads[:, :-1]], axis=1)
        same = (loads == before).all(axis=2) & loads.any(axis=2)
        self._last_loads = loads[:, -1].copy()
        if not same.any():
            self._same_loads[:] = 0
            return
        for k in range(loads.shape[1]):
            self._same_loads = np.where(same[:, k], self._same_loads + 1, 0)
            loads[self._same_loads >= self._stuck_ticks, k] = np.nan
