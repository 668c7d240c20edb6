"""Packets of one device to the common tick of their session, in order, with gaps marked.

The result depends on the packets alone: live it waits at most the reorder window for a missing sequence, off
line it has them all, and the same code gives the complete version.
"""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from app.errors import PacketError
from app.network.clock import PacketClock
from app.network.declaration import Declaration
from app.network.packet import Packet
from app.network.placing.slot import SNAP_TICKS, Network, carried_by
from app.network.unpack import Unpacker
from estimators.channels import CARRIED, INERTIAL, Channel, ChannelSpec
from estimators.kernels.slots import into_row
from estimators.recording import Float, ImuChunk, SampleQuality
from estimators.sentences import say
from estimators.signals import bridge

REORDER_WINDOW_S = 0.150
BRIDGE_LIMIT_S = 0.200
_PIECE_TICKS = 1000
_CARRIED_BITS = sum(int(spec.bit) for spec in CARRIED)
_CARRIED = {spec.field: spec for spec in CARRIED}
_NOTHING: dict[str, Float] = {}


@dataclass(frozen=True)
class Gap:
    """Ticks for which nothing came in time: bridged when short, else missing."""

    first_tick: int
    tick_count: int
    is_bridged: bool


class Aligner:
    """Turns the admitted packets of one session into consecutive `ImuChunk`.

    Parameters
    ----------
    declaration : Declaration
        Network, scales and clip levels.
    reorder_window_s : float
        How long, in device time, a missing sequence is awaited while later ones are there.
    first_tick : int
        Where to begin; above zero when a running session is taken up again.
    """

    def __init__(
        self, declaration: Declaration, reorder_window_s: float = REORDER_WINDOW_S, first_tick: int = 0
    ) -> None:
        self._declaration = declaration
        self._step_us = 1e6 / declaration.rate_hz
        self._window_us = reorder_window_s * 1e6
        self._bridge_ticks = int(BRIDGE_LIMIT_S * declaration.rate_hz + 1e-9)
        self._unpacker: Unpacker | None = None
        self.clip_levels = np.full((declaration.sensor_count, 2, 2, 3), np.inf)
        """Levels at which a sensor was found to be cut off, see `Unpacker`; written in place."""
        self._waiting: dict[int, tuple[Packet, int]] = {}
        self._next_sequence = -1
        self._released_end_us = 0
        self._next_tick = first_tick
        self._last_position = 0.0
        self._rows = np.empty((0, declaration.sensor_count, 2, 3))
        self._rows_known = 0
        """How many of the last two rows are known, the last one first; one where the packet held only one."""
        self._last_carried = _NOTHING
        self.carried_mask = 0
        """Bits of the channels beside motion that the last packet carried."""
        self.gaps: list[Gap] = []
        """Gaps found since the caller last emptied the list."""
        self.late_packets = 0
        """Came after their place was given up; stored, and used off line."""

    @property
    def next_tick(self) -> int:
        """First tick not yet given."""
        return self._next_tick

    @property
    def next_sequence(self) -> int:
        """First packet not yet unpacked; -1 before the first."""
        return self._next_sequence

    @property
    def waiting(self) -> int:
        """Packets held back for an earlier one."""
        return len(self._waiting)

    @property
    def is_in_order(self) -> bool:
        """Whether nothing is awaited: compiled code may take the next packet."""
        return self._unpacker is not None and not self._waiting

    @property
    def channel_count(self) -> int:
        """Channels of the samples, see `Unpacker`; 0 before the first packet."""
        return 0 if self._unpacker is None else self._unpacker.channel_count

    def share(self, network: Network, slot: int) -> None:
        """Go on over the rows of a slot, which must be called after a packet; see `app.network.placing.kernel`."""
        assert self._unpacker is not None
        self._rows = into_row(self._rows, network.last_rows[slot])
        self.clip_levels = into_row(self.clip_levels, network.clip_levels[slot])
        self._unpacker.share(network.last_sent[slot], network.same_ticks[slot], self.clip_levels)
        row, first = network.carried[slot], 0
        views: dict[str, Float] = {}
        for spec in carried_by(self.carried_mask):
            own = row[:, np.newaxis, first : first + spec.width]
            views[spec.field] = own if spec.width > 1 else own[:, :, 0]
            views[spec.field][...] = self._before(spec.field, views[spec.field])
            first += spec.width
        self._last_carried = views or _NOTHING
        if network.cells:
            self._unpacker.share_cells(
                network.carried_sent[slot][:, : network.cells], network.carried_same[slot]
            )

    def own(self) -> None:
        """Go on over arrays of its own."""
        self._rows, self.clip_levels = self._rows.copy(), self.clip_levels.copy()
        self._last_carried = {name: values.copy() for name, values in self._last_carried.items()} or _NOTHING
        if self._unpacker is not None:
            self._unpacker.own(self.clip_levels)

    def state(self) -> dict[str, NDArray[Any]]:
        """Return copies of what the next packet depends on; only while `is_in_order`."""
        assert self._unpacker is not None
        assert not self._waiting
        numbers = (self._next_sequence, self._released_end_us, self._next_tick, self._rows_known)
        return {
            "numbers": np.array((*numbers, self.carried_mask, self._unpacker.channel_count), dtype=np.int64),
            "last_position": np.array(self._last_position),
            "rows": self._rows.copy(),
            "clip_levels": self.clip_levels.copy(),
            **{f"carried.{name}": values.copy() for name, values in self._last_carried.items()},
            **{f"unpacker.{name}": values for name, values in self._unpacker.state().items()},
        }

    def restore(self, state: Mapping[str, NDArray[Any]]) -> None:
        """Go on where the instance that gave `state` stood; before the first packet only."""
        numbers = [int(one) for one in state["numbers"]]
        self._next_sequence, self._released_end_us, self._next_tick, self._rows_known = numbers[:4]
        self.carried_mask, channels = numbers[4:]
        self._last_position, self._rows = float(state["last_position"]), state["rows"].copy()
        self.clip_levels[...] = state["clip_levels"]
        self._last_carried = _below(state, "carried.") or _NOTHING
        self._unpacker = Unpacker(self._declaration, channels == 3, self.clip_levels)
        self._unpacker.restore(_below(state, "unpacker."))

    def fill(self, x: Any) -> None:
        """Write into a record of `SLOT` what the next packet in order must fit."""
        assert self._unpacker is not None
        self._unpacker.fill(x, carried_by(self.carried_mask))
        x["next_tick"], x["last_position"] = self._next_tick, self._last_position
        x["rows_known"] = self._rows_known
        x["step_us"], x["rate_hz"] = self._step_us, self._declaration.rate_hz
        x["bridge_ticks"] = self._bridge_ticks

    def advance(
        self, sequence: int, end_us: int, next_tick: int, last_position: float, rows_known: int
    ) -> None:
        """Note the next packet in order, which compiled code has placed over the shared rows."""
        self._next_sequence, self._released_end_us = sequence + 1, end_us
        self._next_tick, self._last_position, self._rows_known = next_tick, last_position, rows_known

    def push(self, packet: Packet, sequence: int, time_us: int) -> ImuChunk | None:
        """Take one admitted packet; return what is now in order.

        Parameters
        ----------
        sequence : int
            Unwrapped; each at most once.
        time_us : int
            Session time of its first tick.

        Returns
        -------
        ImuChunk or None
            Continues the last one; None while an earlier packet is awaited.

        Raises
        ------
        PacketError
            `missing_channels` when gyroscope or accelerometer is not in the packet.
        """
        if packet.channels & INERTIAL != INERTIAL:
            raise PacketError(
                say("packet.channels_missing"),
                reason="missing_channels",
                sequence=packet.sequence,
            )
        if self._unpacker is None:
            has_magnetometer = bool(packet.channels & Channel.MAGNETOMETER)
            self._unpacker = Unpacker(self._declaration, has_magnetometer, self.clip_levels)
            self._rows = np.empty((self._unpacker.channel_count, self._declaration.sensor_count, 2, 3))
            self._next_sequence = sequence
            self._released_end_us = time_us
        if sequence < self._next_sequence:
            self.late_packets += 1
            return None
        if sequence == self._next_sequence and not self._waiting:
            pieces = self._place(packet, sequence, time_us)
            return pieces[0] if len(pieces) == 1 else _joined(pieces)
        self._waiting[sequence] = (packet, time_us)
        return self._release(wait=True)

    def drain(self) -> ImuChunk | None:
        """Stop waiting for missing packets: the link is silent or the session ends."""
        return self._release(wait=False)

    def _release(self, wait: bool) -> ImuChunk | None:
        pieces: list[ImuChunk] = []
        while self._waiting:
            sequence = self._next_sequence
            if sequence not in self._waiting:
                held_us = self._waiting[max(self._waiting)][1] - self._released_end_us
                if wait and held_us < self._window_us:
                    break
                sequence = min(self._waiting)
            packet, time_us = self._waiting.pop(sequence)
            pieces.extend(self._place(packet, sequence, time_us))
        return _joined(pieces)

    def _place(self, packet: Packet, sequence: int, time_us: int) -> list[ImuChunk]:
        assert self._unpacker is not None
        ticks = packet.tick_count
        self._next_sequence = sequence + 1
        self._released_end_us = time_us + ticks * packet.tick_interval_us
        signals, quality = self._unpacker.unpack(packet)
        self.carried_mask = packet.channels & _CARRIED_BITS
        carried = self._unpacker.carried(packet) if self.carried_mask else _NOTHING
        position = time_us / self._step_us
        spacing = packet.tick_interval_us / self._step_us
        first = round(position)
        drift = (ticks - 1) * (spacing - 1.0)
        if abs(position - first) > SNAP_TICKS or abs(position + drift - first) > SNAP_TICKS:
            positions: Float = position + spacing * np.arange(ticks, dtype=np.float64)
            return self._interpolate(positions, signals, quality, carried)
        skip = self._next_tick - first
        if skip >= ticks:
            return []
        if skip > 0:
            first, signals, quality = self._next_tick, signals[:, :, skip:], quality[:, skip:]
            carried = {name: values[:, skip:] for name, values in carried.items()}
        pieces = self._fill(first, signals[:, :, :2], carried) if first > self._next_tick else []
        pieces.append(self._chunk(first, signals, quality, carried))
        self._last_carried = _last(carried)
        self._next_tick = first + signals.shape[2]
        self._last_position = self._next_tick - 1.0
        self._hold(signals, min(signals.shape[2], 2))
        return pieces

    def _hold(self, signals: Float, rows: int) -> None:
        self._rows[:, :, 2 - rows :] = signals[:, :, signals.shape[2] - rows :]
        self._rows_known = rows

    @property
    def _last_row(self) -> Float | None:
        return self._rows[:, :, 1] if self._rows_known else None

    def _interpolate(
        self,
        position: Float,
        signals: Float,
        quality: NDArray[np.uint8],
        carried: dict[str, Float],
    ) -> list[ImuChunk]:
        """Place samples that lie between common ticks, at `position` ticks, shape (K,)."""
        pieces: list[ImuChunk] = []
        spacing = 1.5 * (position[-1] - position[0]) / max(1, position.shape[0] - 1) or 1.5
        last = self._last_row
        if last is None or position[0] - self._last_position - 1.0 > self._bridge_ticks:
            pieces = self._fill(max(self._next_tick, int(np.ceil(position[0] - 1e-9))), None)
        else:
            position = np.concatenate([[self._last_position], position])
            signals = np.concatenate([last[:, :, np.newaxis], signals], axis=2)
            quality = np.concatenate([np.zeros_like(quality[:, :1]), quality], axis=1)
            carried = {
                name: np.concatenate([self._before(name, values), values], axis=1)
                for name, values in carried.items()
            }
        tick = np.arange(self._next_tick, int(np.floor(position[-1] + 1e-9)) + 1)
        self._last_position, self._last_carried = float(position[-1]), _last(carried)
        self._hold(signals, 1)
        if not tick.size:
            return pieces
        left = np.clip(np.searchsorted(position, tick, side="right") - 1, 0, max(0, position.shape[0] - 2))
        right = np.minimum(left + 1, position.shape[0] - 1)
        width = position[right] - position[left]
        weight = np.clip((tick - position[left]) / np.where(width > 0, width, 1.0), 0.0, 1.0)[:, np.newaxis]
        values = (1.0 - weight) * signals[:, :, left] + weight * signals[:, :, right]
        flags = quality[:, left] | quality[:, right]
        wide = width > spacing
        if wide.any():
            flags[:, wide] |= np.uint8(SampleQuality.BRIDGED)
            self.gaps.append(Gap(int(tick[wide][0]), int(wide.sum()), True))
        nothing = np.isnan(values[0]).any(axis=2)
        values[:, nothing] = np.nan
        flags[nothing] = (flags[nothing] & ~np.uint8(SampleQuality.BRIDGED)) | np.uint8(SampleQuality.MISSING)
        carried = {
            name: _at_ticks(_CARRIED[name], values, left, right, weight, wide)
            for name, values in carried.items()
        }
        pieces.append(self._chunk(self._next_tick, values, flags, carried))
        self._next_tick += tick.size
        return pieces

    def _fill(self, first: int, rows: Float | None, carried: dict[str, Float] = _NOTHING) -> list[ImuChunk]:
        """Fill from the next tick up to `first`: with a curve to the first of `rows` when the gap is short.

        Gyroscope and accelerometer leave and reach it with the slopes of the rows outside, the magnetometer and
        what of `carried` says so follow the chord.
        """
        start, count = self._next_tick, first - self._next_tick
        if count <= 0:
            return []
        self._next_tick = first
        last = self._last_row
        if last is None or rows is None or count > self._bridge_ticks:
            self.gaps.append(Gap(start, count, False))
            return list(self._missing(start, count))
        self.gaps.append(Gap(start, count, True))
        weight = (np.arange(1, count + 1) / (count + 1))[:, np.newaxis]
        row, slope, last_slope = rows[:, :, 0], _slope(rows), _slope(self._rows[:, :, 2 - self._rows_known :])
        signals = last[:, :, np.newaxis] + weight * (row - last)[:, :, np.newaxis]
        unknown = np.full_like(last[:2], np.nan)
        signals[:2] = bridge(
            last[:2, :, np.newaxis],
            (unknown if last_slope is None else last_slope[:2])[:, :, np.newaxis],
            row[:2, :, np.newaxis],
            (unknown if slope is None else slope[:2])[:, :, np.newaxis],
            count + 1.0,
            weight,
            (count + 1.0) * self._step_us * 1e-6,
        )
        quality = np.full(signals.shape[1:3], SampleQuality.BRIDGED, dtype=np.uint8)
        nothing = np.isnan(signals[0]).any(axis=2)
        signals[:, nothing] = np.nan
        quality[nothing] = SampleQuality.MISSING
        left = np.zeros(count, dtype=np.intp)
        chords = {
            name: _at_ticks(
                _CARRIED[name],
                np.concatenate([self._before(name, values), values[:, :1]], axis=1),
                left,
                left + 1,
                weight,
                left == 0,
            )
            for name, values in carried.items()
            if _CARRIED[name].gap == "chord"
        }
        return [self._chunk(start, signals, quality, chords)]

    def _missing(self, start: int, count: int) -> Iterator[ImuChunk]:
        assert self._unpacker is not None
        shape = (self._unpacker.channel_count, self._declaration.sensor_count, min(count, _PIECE_TICKS), 3)
        nothing = np.full(shape, np.nan)
        quality = np.full(shape[1:3], SampleQuality.MISSING, dtype=np.uint8)
        for offset in range(0, count, _PIECE_TICKS):
            ticks = min(_PIECE_TICKS, count - offset)
            yield self._chunk(start + offset, nothing[:, :, :ticks], quality[:, :ticks])

    def _chunk(
        self,
        first: int,
        signals: Float,
        quality: NDArray[np.uint8],
        carried: dict[str, Float] = _NOTHING,
    ) -> ImuChunk:
        return ImuChunk(
            first,
            self._declaration.time_step_s,
            signals[0],
            signals[1],
            signals[2] if signals.shape[0] == 3 else None,
            quality,
            **carried,
        )

    def _before(self, name: str, values: Float) -> Float:
        """Return the last value that was sent, shape (S, 1, ...)."""
        resting = np.full_like(values[:, :1], _CARRIED[name].resting)
        return self._last_carried.get(name, resting)


def _below(state: Mapping[str, NDArray[Any]], prefix: str) -> dict[str, NDArray[Any]]:
    return {
        name.removeprefix(prefix): values.copy() for name, values in state.items() if name.startswith(prefix)
    }


def _last(carried: dict[str, Float]) -> dict[str, Float]:
    return {name: values[:, -1:] for name, values in carried.items()} if carried else _NOTHING


def _at_ticks(
    spec: ChannelSpec,
    values: Float,
    left: NDArray[np.intp],
    right: NDArray[np.intp],
    weight: Float,
    wide: NDArray[np.bool_],
) -> Float:
    """Return a carried channel at common ticks by its gap rule; `weight` of the right sample, shape (ticks, 1)."""
    if spec.gap == "nearest":
        return values[:, np.where(weight[:, 0] < 0.5, left, right)]
    weight = weight if values.ndim == 3 else weight[:, 0]
    found = (1.0 - weight) * values[:, left] + weight * values[:, right]
    if spec.gap == "never":
        found[:, wide] = np.nan
    return found


def _slope(rows: Float | None) -> Float | None:
    """Return the change from the first to the second of two rows, shape (channels, sensors, 2, 3)."""
    return None if rows is None or rows.shape[2] < 2 else rows[:, :, 1] - rows[:, :, 0]


def align_chunks(
    packets: Iterable[Packet], hello: Mapping[str, Any] | Declaration, piece_ticks: int = 500
) -> Iterator[ImuChunk]:
    """Align stored packets, in the order of their sequence, piece by piece.

    Parameters
    ----------
    packets : iterable of Packet
        Every stored packet once, in the order of the unwrapped sequence; `Packet.sequence` is as sent.
    hello : mapping or Declaration
        What the session stored of its hello, clock epochs included.
    piece_ticks : int
        About how many ticks a chunk holds.

    Yields
    ------
    ImuChunk
        Consecutive from tick 0. Packets whose time contradicts their order are left out.
    """
    declaration = hello if isinstance(hello, Declaration) else Declaration.from_dict(hello)
    clock = PacketClock(declaration)
    aligner = Aligner(declaration, reorder_window_s=-np.inf)
    pieces: list[ImuChunk] = []
    held = 0
    for packet in packets:
        try:
            place = clock.admit(packet)
            chunk = None if place.is_duplicate else aligner.push(packet, place.sequence, place.time_us)
        except PacketError:
            continue
        if chunk is not None:
            pieces.append(chunk)
            held += chunk.tick_count
        if held >= piece_ticks:
            yield ImuChunk.join(pieces)
            pieces, held = [], 0
    rest = aligner.drain()
    if rest is not None:
        pieces.append(rest)
    if pieces:
        yield ImuChunk.join(pieces)


def align_all(packets: Iterable[Packet], hello: Mapping[str, Any] | Declaration) -> ImuChunk | None:
    """Align all stored packets into one chunk; None when there is nothing. See `align_chunks`."""
    return _joined(list(align_chunks(packets, hello)))


def _joined(pieces: list[ImuChunk]) -> ImuChunk | None:
    return ImuChunk.join(pieces) if pieces else None
