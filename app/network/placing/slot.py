"""Where the next packet of a pooled session stands: a record a session, read and written by compiled code.

`app.network.clock` and `app.network.alignment` hold the same numbers as Python objects; a session of the pooled engine
has both, and whichever way takes a packet carries both on.
"""

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from estimators.channels import CARRIED, ChannelSpec
from estimators.kernels import record
from estimators.kernels.slots import sparse_zeros
from estimators.recording import Float

MOST_TICKS: Final = 65
"""Common ticks of a packet: of the longest, and one more off the grid; one with more takes the general way."""
SNAP_TICKS: Final = 0.05
"""Device ticks this close to the common tick are taken as they are; others are interpolated."""
MOST_CARRIED: Final = sum(spec.width for spec in CARRIED)
SLOT: Final = record(
    [
        # Clock: what must come next, the epoch in force, and the newest packet.
        ("next_sequence", "i8"),
        ("epoch_device_us", "i8"),
        ("epoch_session_us", "i8"),
        ("highest_time_us", "i8"),
        ("highest_duration_us", "i8"),
        # Alignment: the common tick that comes next, the place of the last sample, how many last rows are known.
        ("next_tick", "i8"),
        ("last_position", "f8"),
        ("rows_known", "i8"),
        ("step_us", "f8"),
        ("rate_hz", "f8"),
        ("bridge_ticks", "i8"),
        # Declaration: what a packet must be, SI values of a count, clip levels of floats and of counts.
        ("mask", "i8"),
        # Values of a sensor and tick, and SI values of a count of those that are carried beside motion.
        ("width", "i8"),
        ("carried_scale", "f8", MOST_CARRIED),
        ("countable", "i8"),
        ("stuck_ticks", "i8"),
        ("scale", "f8", 3),
        ("clip", "f8", 2),
        ("count_clip", "f8", 2),
        # Row, among those of the session, for the frames of the next tick.
        ("frame_row", "i8"),
        # Status of a packet that was not taken in this turn, else ordinary: those behind it wait with it.
        ("blocked", "i8"),
    ]
)
"""All sessions of a pool have the same sensors; what differs between them is here."""

ITEM: Final = record(
    [
        ("slot", "i8"),
        # In the journal, in bytes; the offset is a multiple of eight.
        ("offset", "i8"),
        ("length", "i8"),
        # Filled by `place`.
        ("status", "i8"),
        ("sequence", "i8"),
        ("time_us", "i8"),
        ("duration_us", "i8"),
        ("next_tick", "i8"),
        ("last_position", "f8"),
        ("rows_known", "i8"),
        ("first_tick", "i8"),
        ("ticks", "i8"),
        # First value in `Placed.signals`, first quality in `Placed.quality`, row for the frames of the first tick.
        ("signals_at", "i8"),
        ("quality_at", "i8"),
        ("tick_at", "i8"),
        ("is_flawed", "i8"),
        # It says that it comes after a lost link.
        ("is_backfilled", "i8"),
    ]
)
"""One packet of a turn."""

ORDINARY, RARE, WAITS = 0, 1, 2
"""An ordinary packet is wholly taken by compiled code. Others changed nothing: a rare one takes the general way. One
that waits found no room for its frames, or stands behind a rare one: it comes again when those before are settled."""


class Network(NamedTuple):
    """Pooled rows of what is known of the sensors of N sessions, sessions leading.

    Attributes
    ----------
    slot : ndarray of SLOT, shape (N,)
    last_sent : ndarray, shape (N, 2, S, 3)
        As `Unpacker` carries it on.
    same_ticks : ndarray of int64, shape (N, S)
    clip_levels : ndarray, shape (N, S, 2, 2, 3)
    last_rows : ndarray, shape (N, C, S, 2, 3)
        The last two rows of samples, as `Aligner` carries them on.
    recent : ndarray, shape (N, R, C, S, 3)
        The newest R ticks in a ring, tick modulo R.
    recent_quality : ndarray of uint8, shape (N, R, S)
    carried, carried_sent : ndarray, shape (N, S, W)
        The last values of the channels that are carried beside motion, as `Aligner` and `Unpacker` carry them on.
    carried_same : ndarray of int64, shape (N, S)
        For how long the cells of a sensor have repeated themselves.
    cells : int
        How many of the W belong to cells; the first ones.
    """

    slot: NDArray[np.void]
    last_sent: Float
    same_ticks: NDArray[np.int64]
    clip_levels: Float
    last_rows: Float
    recent: Float
    recent_quality: NDArray[np.uint8]
    carried: Float
    carried_sent: Float
    carried_same: NDArray[np.int64]
    cells: int


class Packets(NamedTuple):
    """Where packets lie, and what checks them.

    Attributes
    ----------
    data : ndarray of uint8
        The packets, one after the other.
    counts, numbers : ndarray of int16 and float32
        The memory of `data`.
    tables : ndarray of uint32, shape (8, 256)
        `crc.TABLES`.
    """

    data: NDArray[np.uint8]
    counts: NDArray[np.int16]
    numbers: NDArray[np.float32]
    tables: NDArray[np.uint32]


class Placed(NamedTuple):
    """Samples of all items of a turn at common ticks, one after the other; shapes (C, S, K, 3) and (S, K) each.

    The rest is room for one packet between the common ticks: its samples with the one before it, its own, where they
    are; and a scale for numbers that are sent as they are.

    Attributes
    ----------
    signals : ndarray, shape (values,)
    quality : ndarray of uint8, shape (samples,)
    carried : ndarray, shape (values,)
        Of channels beside motion, shape (S, K, W) each.
    sent, own : ndarray, shape (values of a packet,)
    sent_quality, own_quality : ndarray of uint8, shape (samples of a packet,)
    places : ndarray, shape (MOST_TICKS + 1,)
    ones : ndarray, shape (3,)
    """

    signals: Float
    quality: NDArray[np.uint8]
    carried: Float
    sent: Float
    sent_quality: NDArray[np.uint8]
    own: Float
    own_quality: NDArray[np.uint8]
    places: Float
    ones: Float


def carried_by(mask: int) -> tuple[ChannelSpec, ...]:
    """Return the channels beside motion that packets with this mask carry to estimators, in payload order."""
    return tuple(spec for spec in CARRIED if mask & spec.bit)


def network_rows(sessions: int, channels: int, sensors: int, recent_ticks: int, mask: int = 0) -> Network:
    """Return rows for so many sessions; memory is used only where a session is.

    Parameters
    ----------
    mask : int
        Bits of the channels that are carried beside motion.
    """
    carried = carried_by(mask)
    each = (sessions, sensors, sum(spec.width for spec in carried))
    return Network(
        np.zeros(sessions, dtype=SLOT),
        np.zeros((sessions, 2, sensors, 3)),
        np.zeros((sessions, sensors), dtype=np.int64),
        np.zeros((sessions, sensors, 2, 2, 3)),
        np.zeros((sessions, channels, sensors, 2, 3)),
        sparse_zeros((sessions, recent_ticks, channels, sensors, 3)),
        sparse_zeros((sessions, recent_ticks, sensors), np.uint8),
        np.zeros(each),
        np.zeros(each),
        np.zeros((sessions, sensors), dtype=np.int64),
        sum(spec.width for spec in carried if spec.cell),
    )


def room_for(channels: int, sensors: int, most_ticks: int, mask: int = 0) -> Placed:
    """Return room for a turn of so many common ticks; `mask` as of `network_rows`."""
    samples, packet = sensors * most_ticks, sensors * (MOST_TICKS + 1)
    return Placed(
        np.empty(3 * channels * samples),
        np.empty(samples, dtype=np.uint8),
        np.empty(samples * sum(spec.width for spec in carried_by(mask))),
        np.empty(3 * channels * packet),
        np.empty(packet, dtype=np.uint8),
        np.empty(3 * channels * packet),
        np.empty(packet, dtype=np.uint8),
        np.empty(MOST_TICKS + 1),
        np.ones(3),
    )
