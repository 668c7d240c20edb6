"""Packets of a turn to samples at common ticks: checks, clock, order, unpacking, stamps off the grid; compiled.

What `decode_packet`, `PacketClock`, `Unpacker` and `Aligner` do to a packet that comes next in its session, in one
call for the packets of many sessions, with the same numbers to the last bit. Whatever else comes (a gap, a repeated or
reordered packet, one that fills a gap, another clock, a wrong byte) changes nothing here and is left to them.
"""

import math
from typing import Final

import numpy as np
from numba import types
from numpy.typing import NDArray

from app.network.packet import (
    HEADER,
    HEADER_BYTES,
    MAGIC,
    MAX_TICK_INTERVAL_US,
    MAX_TICKS,
    MIN_TICK_INTERVAL_US,
    OFFSETS,
    VALUE_LIMIT,
    PacketFlag,
)
from app.network.placing.crc import crc32
from app.network.placing.slot import (
    ITEM,
    MOST_TICKS,
    ORDINARY,
    RARE,
    SLOT,
    SNAP_TICKS,
    WAITS,
    Network,
    Packets,
    Placed,
)
from app.network.unpack_kernel import unpack
from estimators.compiling import compiled
from estimators.kernels import VOID, Record, borrowing, bundle, rows
from estimators.recording import Float, SampleQuality

_MAGIC: Final = int.from_bytes(MAGIC, "little")
_SENSORS, _TICKS, _ENCODING, _FLAGS = (
    OFFSETS[name] for name in ("sensor_count", "tick_count", "encoding", "flags")
)
_MAGIC_FIELD, _CHANNELS, _RESERVED, _SEQUENCE, _TIME, _INTERVAL, _CRC = (
    (OFFSETS[name], HEADER[name].itemsize)
    for name in ("magic", "channels", "reserved", "sequence", "device_time_us", "tick_interval_us", "crc")
)
"""Where a field begins in a packet, and of those that are more than a byte how many they are."""
_CLIPPED, _BACKFILLED = int(PacketFlag.SATURATED), int(PacketFlag.BACKFILLED)
_FLOAT32, _INT16 = 0, 1
_BRIDGED, _MISSING, _FILLED_IN = (
    int(SampleQuality.BRIDGED),
    int(SampleQuality.MISSING),
    int(SampleQuality.BACKFILLED),
)
_NUMBERS, _QUALITIES = types.float64[::1], types.uint8[::1]
_INERTIAL: Final = 6
"""Values of gyroscope and accelerometer, the first of a sensor."""
_LARGEST_COUNT: Final = 32766.5
"""A count beyond is at its end."""
_LONGEST_GAP_US: Final = 1_000_000
"""A later packet leaves a gap that the general way fills, or starts another clock."""


@borrowing("u8(u1[::1], i8, UniTuple(i8, 2))")
def _number(data: NDArray[np.uint8], packet: int, field: tuple[int, int]) -> np.uint64:
    """Return a field of the packet that begins at `packet` as a number, little endian."""
    first, size = field
    value = np.uint64(0)
    for k in range(size):
        value |= np.uint64(data[packet + first + k]) << np.uint64(8 * k)
    return value


@borrowing()
def _has_place(item: Record, x: Record, packets: Packets, sensors: int) -> bool:
    """Check header, order and clock, and note them in the item; True when the packet comes next in its session."""
    at, size, journal, tables = item.offset, item.length, packets.data, packets.tables
    if size < HEADER_BYTES or _number(journal, at, _MAGIC_FIELD) != np.uint64(_MAGIC):
        return False
    ticks, mask, encoding, flags = (
        int(journal[at + _TICKS]),
        int(_number(journal, at, _CHANNELS)),
        int(journal[at + _ENCODING]),
        int(journal[at + _FLAGS]),
    )
    interval_us = int(_number(journal, at, _INTERVAL))
    if (
        journal[at + _SENSORS] != sensors
        or not 0 < ticks <= MAX_TICKS
        or mask != x.mask
        or encoding > _INT16
        or flags & ~(_CLIPPED | _BACKFILLED) != 0
        or _number(journal, at, _RESERVED) != 0
        or not MIN_TICK_INTERVAL_US <= interval_us <= MAX_TICK_INTERVAL_US
        or not 0.9 < interval_us * 1e-6 * x.rate_hz < 1.1
        or (encoding == _INT16 and x.countable == 0)
        or size != HEADER_BYTES + ticks * sensors * x.width * (2 if encoding == _INT16 else 4)
    ):
        return False
    sequence = x.next_sequence
    if _number(journal, at, _SEQUENCE) != np.uint64(sequence) & np.uint64(0xFFFFFFFF):
        return False
    # Session time; a counter that has wrapped is far away and rare.
    time_us = x.epoch_session_us + (np.int64(_number(journal, at, _TIME)) - x.epoch_device_us)
    gap_us = time_us - (x.highest_time_us + x.highest_duration_us)
    if gap_us < -(interval_us // 2) or gap_us > _LONGEST_GAP_US:
        return False
    computed = crc32(
        journal, at + HEADER_BYTES, at + size, crc32(journal, at, at + _CRC[0], np.uint32(0), tables), tables
    )
    if np.uint64(computed) != _number(journal, at, _CRC):
        return False
    item.sequence, item.time_us, item.ticks = sequence, time_us, ticks
    item.duration_us = ticks * interval_us
    item.is_backfilled = flags & _BACKFILLED != 0
    return True


@borrowing()
def _unpacked(
    s: int,
    x: Record,
    item: Record,
    packets: Packets,
    network: Network,
    ones: Float,
    signals: Float,
    quality: NDArray[np.uint8],
) -> None:
    """Unpack the item's values at the ticks of the device."""
    channels, sensors, ticks = signals.shape[0], signals.shape[1], signals.shape[2]
    width, at = x.width, item.offset + HEADER_BYTES
    is_clipped = packets.data[item.offset + _FLAGS] & _CLIPPED != 0
    every = _FILLED_IN if item.is_backfilled else 0
    size = ticks * sensors * width
    levels, last, same = network.clip_levels[s], network.last_sent[s], network.same_ticks[s]
    if packets.data[item.offset + _ENCODING] == _INT16:
        sent = packets.counts[at // 2 : at // 2 + size].reshape((ticks, sensors, width))
        scale, clip = x.scale[:channels], x.count_clip[:]
        unpack(sent, scale, clip, levels, is_clipped, every, x.stuck_ticks, last, same, signals, quality)
    else:
        given = packets.numbers[at // 4 : at // 4 + size].reshape((ticks, sensors, width))
        scale, clip = ones[:channels], x.clip[:]
        unpack(given, scale, clip, levels, is_clipped, every, x.stuck_ticks, last, same, signals, quality)


@borrowing()
def _carry(s: int, x: Record, item: Record, packets: Packets, network: Network, carried: Float) -> None:
    """Unpack what comes beside motion into `carried`, shape (S, K, W); as `Unpacker.carried`."""
    sensors, ticks, columns = carried.shape
    width, first, at = x.width, x.width - columns, item.offset + HEADER_BYTES
    is_counts = packets.data[item.offset + _ENCODING] == _INT16
    for i in range(sensors):
        for k in range(ticks):
            row = (k * sensors + i) * width
            nothing, same = True, network.cells > 0
            for c in range(_INERTIAL):
                if is_counts:
                    nothing &= packets.counts[at // 2 + row + c] == 0
                else:
                    nothing &= packets.numbers[at // 4 + row + c] == 0.0
            is_any = False
            for c in range(columns):
                if is_counts:
                    value = float(packets.counts[at // 2 + row + first + c])
                    value = np.nan if abs(value) > _LARGEST_COUNT else value * x.carried_scale[c]
                else:
                    value = float(packets.numbers[at // 4 + row + first + c])
                if nothing:
                    value = np.nan
                if c < network.cells:
                    same &= value == network.carried_sent[s, i, c]
                    is_any |= value != 0.0
                network.carried_sent[s, i, c] = value
                carried[i, k, c] = value
            network.carried_same[s, i] = network.carried_same[s, i] + 1 if same and is_any else 0
            if network.carried_same[s, i] >= x.stuck_ticks:
                for c in range(network.cells):
                    carried[i, k, c] = np.nan
        for c in range(columns):
            network.carried[s, i, c] = carried[i, ticks - 1, c]


@borrowing()
def _are_usable(item: Record, packets: Packets) -> bool:
    """Whether every number sent as it is can be one."""
    if packets.data[item.offset + _ENCODING] == _INT16:
        return True
    first = (item.offset + HEADER_BYTES) // 4
    for k in range(first, first + (item.length - HEADER_BYTES) // 4):  # noqa: SIM110 - compiled as it stands
        if not abs(packets.numbers[k]) <= VALUE_LIMIT:
            return False
    return True


@borrowing()
def _interpolated(
    position: Float,
    first: int,
    sent: Float,
    sent_quality: NDArray[np.uint8],
    values: Float,
    quality: NDArray[np.uint8],
) -> None:
    """Write samples at common ticks from `first` on, of samples at `position`; as `Aligner` off the grid."""
    count = position.shape[0]
    left = 0
    for k in range(quality.shape[1]):
        tick = float(first + k)
        while left < count - 2 and position[left + 1] <= tick:
            left += 1
        right = min(left + 1, count - 1)
        width = position[right] - position[left]
        weight = min(max((tick - position[left]) / (width if width > 0 else 1.0), 0.0), 1.0)
        for s in range(quality.shape[0]):
            for c in range(values.shape[0]):
                for a in range(3):
                    values[c, s, k, a] = (1.0 - weight) * sent[c, s, left, a] + weight * sent[c, s, right, a]
            flag = sent_quality[s, left] | sent_quality[s, right]
            nothing = False
            for a in range(3):
                nothing |= math.isnan(values[0, s, k, a])
            if nothing:
                flag = (flag & np.uint8(~_BRIDGED & 0xFF)) | np.uint8(_MISSING)
                for c in range(values.shape[0]):
                    for a in range(3):
                        values[c, s, k, a] = np.nan
            quality[s, k] = flag


@borrowing()
def _keep_last(s: int, x: Record, network: Network, signals: Float, rows_known: int) -> None:
    """Carry on the last rows of samples."""
    ticks = signals.shape[2]
    for c in range(signals.shape[0]):
        for i in range(signals.shape[1]):
            for a in range(3):
                network.last_rows[s, c, i, 1, a] = signals[c, i, ticks - 1, a]
                if rows_known == 2:
                    network.last_rows[s, c, i, 0, a] = signals[c, i, ticks - 2, a]
    x.rows_known = rows_known


@borrowing()
def _remember(s: int, item: Record, network: Network, signals: Float, quality: NDArray[np.uint8]) -> None:
    """Write the ticks into the ring of the newest, and say whether one of them is less than measured."""
    length = network.recent.shape[1]
    item.is_flawed = 0
    # A tick of all sensors lies together: what is written for a packet is one stretch of memory.
    for k in range(quality.shape[1]):
        at = (item.first_tick + k) % length
        for i in range(quality.shape[0]):
            network.recent_quality[s, at, i] = quality[i, k]
            if quality[i, k] & ~_FILLED_IN:
                item.is_flawed = 1
        for c in range(signals.shape[0]):
            for i in range(quality.shape[0]):
                for a in range(3):
                    network.recent[s, at, c, i, a] = signals[c, i, k, a]


@borrowing()
def _on_grid(position: float, spacing: float, ticks: int) -> bool:
    first = np.rint(position)
    drift = (ticks - 1) * (spacing - 1.0)
    return not (abs(position - first) > SNAP_TICKS or abs(position + drift - first) > SNAP_TICKS)


@borrowing()
def _between(
    s: int,
    item: Record,
    x: Record,
    packets: Packets,
    network: Network,
    placed: Placed,
    position: float,
    spacing: float,
) -> bool:
    """Place samples between common ticks; False, and nothing changed, when there is a hole before or in them."""
    channels, sensors, ticks = network.last_rows.shape[1], network.last_rows.shape[2], item.ticks
    # What comes beside motion has rules of its own between the common ticks.
    if network.carried.shape[2] or x.rows_known == 0 or position - x.last_position - 1.0 > x.bridge_ticks:
        return False
    places = placed.places[: ticks + 1]
    places[0] = x.last_position
    for k in range(ticks):
        places[k + 1] = position + spacing * k
    last = places[ticks]
    before = places[ticks] - position if ticks > 1 else 0.0
    limit = 1.5 * before / max(1, ticks - 1)
    if limit == 0.0:
        limit = 1.5
    count = math.floor(last + 1e-9) + 1 - x.next_tick
    if count > MOST_TICKS:
        return False
    for k in range(ticks):
        # A tick in a stretch this wide is bridged, and a step back is none of ours.
        if places[k + 1] - places[k] > limit or places[k + 1] <= places[k]:
            return False
    samples = sensors * ticks
    sent = placed.sent[: 3 * channels * (samples + sensors)].reshape((channels, sensors, ticks + 1, 3))
    sent_quality = placed.sent_quality[: samples + sensors].reshape((sensors, ticks + 1))
    own = placed.own[: 3 * channels * samples].reshape((channels, sensors, ticks, 3))
    own_quality = placed.own_quality[:samples].reshape((sensors, ticks))
    _unpacked(s, x, item, packets, network, placed.ones, own, own_quality)
    for c in range(channels):
        for i in range(sensors):
            for a in range(3):
                sent[c, i, 0, a] = network.last_rows[s, c, i, 1, a]
                for k in range(ticks):
                    sent[c, i, k + 1, a] = own[c, i, k, a]
    for i in range(sensors):
        sent_quality[i, 0] = 0
        for k in range(ticks):
            sent_quality[i, k + 1] = own_quality[i, k]
    item.first_tick, item.ticks = x.next_tick, max(count, 0)
    x.last_position = last
    _keep_last(s, x, network, own, 1)
    if count > 0:
        total = channels * sensors * count * 3
        first, start = item.signals_at, item.quality_at
        signals = placed.signals[first : first + total].reshape((channels, sensors, count, 3))
        quality = placed.quality[start : start + sensors * count].reshape((sensors, count))
        _interpolated(places, x.next_tick, sent, sent_quality, signals, quality)
        x.next_tick += count
    return True


@borrowing()
def _placed(
    s: int,
    item: Record,
    x: Record,
    packets: Packets,
    network: Network,
    placed: Placed,
) -> bool:
    """Unpack a packet that comes next, on the common ticks or between them; False, and nothing changed, at a gap."""
    channels, sensors, ticks = network.last_rows.shape[1], network.last_rows.shape[2], item.ticks
    position = item.time_us / x.step_us
    spacing = (item.duration_us // ticks) / x.step_us
    if not _on_grid(position, spacing, ticks):
        return _between(s, item, x, packets, network, placed, position, spacing)
    if int(np.rint(position)) != x.next_tick:
        return False
    total = channels * sensors * ticks * 3
    signals = placed.signals[item.signals_at : item.signals_at + total].reshape((channels, sensors, ticks, 3))
    quality = placed.quality[item.quality_at : item.quality_at + sensors * ticks].reshape((sensors, ticks))
    _unpacked(s, x, item, packets, network, placed.ones, signals, quality)
    item.first_tick = x.next_tick
    x.next_tick += ticks
    x.last_position = x.next_tick - 1.0
    _keep_last(s, x, network, signals, min(ticks, 2))
    return True


@borrowing()
def _is_before(item: Record, x: Record, packets: Packets) -> bool:
    """Whether a packet stands before the next one that is expected, by its sequence."""
    if item.length < HEADER_BYTES:
        return False
    ahead = (np.int64(_number(packets.data, item.offset, _SEQUENCE)) - x.next_sequence) & 0xFFFFFFFF
    return bool(ahead > 0x7FFFFFFF)


@borrowing()
def _take(
    item: Record, x: Record, packets: Packets, network: Network, placed: Placed, frame_rows: int
) -> None:
    """Place one packet, or leave it: to the general way, or until those before it are settled."""
    s = item.slot
    channels, sensors = network.last_rows.shape[1], network.last_rows.shape[2]
    if x.blocked == ORDINARY:
        if x.frame_row + MOST_TICKS > frame_rows:
            x.blocked = WAITS
        elif not (
            _has_place(item, x, packets, sensors)
            and _are_usable(item, packets)
            and _placed(s, item, x, packets, network, placed)
        ):
            x.blocked = RARE
    elif x.blocked == RARE and not _is_before(item, x, packets):
        # It may be ordinary once the rare one before it was taken; what stands further back never is.
        x.blocked = WAITS
    item.status = x.blocked
    if item.status != ORDINARY:
        item.ticks = 0
        return
    item.tick_at = s * frame_rows + x.frame_row
    x.frame_row += item.ticks
    item.next_tick, item.last_position, item.rows_known = x.next_tick, x.last_position, x.rows_known
    x.next_sequence = item.sequence + 1
    x.highest_time_us, x.highest_duration_us = item.time_us, item.duration_us
    columns = network.carried.shape[2]
    if columns:
        a, b = item.quality_at * columns, (item.quality_at + sensors * item.ticks) * columns
        _carry(s, x, item, packets, network, placed.carried[a:b].reshape((sensors, item.ticks, columns)))
    if item.ticks > 0:
        first, at, samples = item.signals_at, item.quality_at, sensors * item.ticks
        _remember(
            s,
            item,
            network,
            placed.signals[first : first + 3 * channels * samples].reshape(
                (channels, sensors, item.ticks, 3)
            ),
            placed.quality[at : at + samples].reshape((sensors, item.ticks)),
        )


PACKETS: Final = bundle(Packets, types.uint8[::1], types.int16[::1], types.float32[::1], types.uint32[:, ::1])
NETWORK: Final = bundle(
    Network,
    rows(SLOT),
    types.float64[:, :, :, ::1],
    types.int64[:, ::1],
    types.float64[:, :, :, :, ::1],
    types.float64[:, :, :, :, ::1],
    types.float64[:, :, :, :, ::1],
    types.uint8[:, :, ::1],
    types.float64[:, :, ::1],
    types.float64[:, :, ::1],
    types.int64[:, ::1],
    types.int64,
)
PLACED: Final = bundle(
    Placed,
    _NUMBERS,
    _QUALITIES,
    _NUMBERS,
    _NUMBERS,
    _QUALITIES,
    _NUMBERS,
    _QUALITIES,
    _NUMBERS,
    _NUMBERS,
)


@compiled(VOID(rows(ITEM), types.int64, PACKETS, NETWORK, PLACED, types.int64))
def place(
    items: NDArray[np.void],
    count: int,
    packets: Packets,
    network: Network,
    placed: Placed,
    frame_rows: int,
) -> None:
    """Place the packets of a turn, in their order.

    Parameters
    ----------
    items : ndarray of ITEM
        Of sessions of one pool; a session may come more than once. Filled from `status` on.
    count : int
        How many items there are.
    network : Network
        Carried on for the sessions of ordinary packets.
    placed : Placed
        Written from its start on.
    frame_rows : int
        How many rows for frames each session has.
    """
    channels, sensors = network.last_rows.shape[1], network.last_rows.shape[2]
    samples = 0
    for n in range(count):
        item = items[n]
        item.ticks = item.is_flawed = 0
        item.signals_at, item.quality_at, item.tick_at = 3 * channels * samples, samples, 0
        _take(item, network.slot[item.slot], packets, network, placed, frame_rows)
        samples += sensors * item.ticks
