"""Where a packet stands: unwrapped sequence, session time, and how the device clock runs against ours.

Session time is device time from the first packet on, so it depends on the packets alone and a stored session
can be aligned again, bit for bit. Arrival times only tell the skew and bridge a restart of the device clock.
"""

import math
from array import array
from collections import deque
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

from app.errors import PacketError
from app.network.declaration import ClockEpoch, Declaration
from app.network.packet import Packet
from app.network.raw_packet import RawPacket
from estimators.sentences import Sentence, say

MAX_GAP_US = 600_000_000
"""A session with a longer hole is two sessions."""
_REMEMBERED = 4096
"""Packets whose times are known; one that comes again later is a duplicate whatever it says."""
_SKEW_EVERY_S = 10.0
_WRAP_32 = 1 << 32
_WRAP_64 = 1 << 64
_SEQUENCE_JUMP = 1_000_000


@dataclass(frozen=True, slots=True)
class Admitted:
    """A packet's place in its session.

    Attributes
    ----------
    sequence : int
        Unwrapped: never falls back to zero.
    time_us : int
        Session time of the first tick.
    is_duplicate : bool
        The same packet came before.
    """

    sequence: int
    time_us: int
    is_duplicate: bool


class PacketClock:
    """Gives every packet of one session its place, or says why it has none.

    Parameters
    ----------
    declaration : Declaration
        With the clock epochs known so far, if the session was met before.
    """

    def __init__(self, declaration: Declaration) -> None:
        self.declaration = declaration
        self.time_errors = 0
        # Rings by sequence: a dictionary of an hour of packets would weigh more than all else of a session.
        self._sequences = array("q", [-1]) * _REMEMBERED
        self._times = array("q", [0]) * _REMEMBERED
        self._highest = -1
        self._highest_time_us = 0
        self._highest_duration_us = 0
        self._highest_arrival_s: float | None = None
        self._is_new_connection = False

    @property
    def highest(self) -> int:
        """Highest sequence admitted; -1 before the first."""
        return self._highest

    @property
    def session_time_us(self) -> int:
        """End of the newest packet."""
        return self._highest_time_us + self._highest_duration_us if self._highest >= 0 else 0

    def begin_connection(self) -> None:
        """Allow the next new packet to start a new clock: the device may have been switched off."""
        self._is_new_connection = True

    def admit(self, packet: Packet | RawPacket, arrival_s: float | None = None) -> Admitted:
        """Find the packet's place.

        Parameters
        ----------
        packet : Packet or RawPacket
            Its values are not looked at.
        arrival_s : float, optional
            Monotonic server time of arrival.

        Raises
        ------
        PacketError
            `time_backwards`, `time_jump`, `sequence_jump` or `sequence_reused`. The packet is not
            admitted and nothing else changes.
        """
        sequence = self._unwrap_sequence(packet.sequence)
        if not self.declaration.clock_epochs:
            self._add_epoch(ClockEpoch(0, packet.device_time_us, 0))
        time_us = self._place_in_epoch(sequence, packet.device_time_us)
        slot = sequence % _REMEMBERED
        if self._sequences[slot] == sequence:
            if self._times[slot] != time_us:
                raise PacketError(
                    say("packet.sequence_reused"),
                    reason="sequence_reused",
                    sequence=packet.sequence,
                )
            return Admitted(sequence, time_us, is_duplicate=True)
        duration_us = packet.tick_count * packet.tick_interval_us
        if sequence > self._highest:
            time_us = self._check_newest(packet, sequence, time_us, arrival_s)
            self._highest = sequence
            self._highest_time_us = time_us
            self._highest_duration_us = duration_us
            self._highest_arrival_s = arrival_s
            self._is_new_connection = False
        elif time_us + duration_us > self._highest_time_us + packet.tick_interval_us // 2:
            raise self._time_error(
                packet, "time_backwards", say("packet.time_later", time_us=packet.device_time_us)
            )
        self._remember(sequence, time_us)
        return Admitted(sequence, time_us, is_duplicate=False)

    def _check_newest(
        self, packet: Packet | RawPacket, sequence: int, time_us: int, arrival_s: float | None
    ) -> int:
        if self._highest < 0:
            return time_us
        steps = sequence - self._highest
        gap_us = time_us - self.session_time_us
        backwards = gap_us < -(packet.tick_interval_us // 2)
        too_far = gap_us > MAX_GAP_US or gap_us > 60_000_000 + 2 * steps * self._highest_duration_us
        declared = self._is_new_connection and any(
            epoch.first_sequence == sequence for epoch in self.declaration.clock_epochs
        )
        if self._is_new_connection and not declared and (backwards or too_far):
            elapsed_us = 1_000_000
            if arrival_s is not None and self._highest_arrival_s is not None:
                elapsed_us = round(1e6 * (arrival_s - self._highest_arrival_s))
            time_us = self.session_time_us + min(max(elapsed_us, 0), MAX_GAP_US)
            self._add_epoch(ClockEpoch(sequence, packet.device_time_us, time_us))
            return time_us
        if backwards:
            raise self._time_error(
                packet, "time_backwards", say("packet.time_before", time_us=packet.device_time_us)
            )
        if too_far:
            raise self._time_error(
                packet,
                "time_jump",
                say("packet.time_ahead", time_us=packet.device_time_us, gap_s=gap_us / 1e6),
            )
        if steps > _SEQUENCE_JUMP:
            raise PacketError(
                say("packet.sequence_jump", steps=steps),
                reason="sequence_jump",
                sequence=packet.sequence,
            )
        return time_us

    def _time_error(self, packet: Packet | RawPacket, reason: str, what: Sentence) -> PacketError:
        self.time_errors += 1
        return PacketError(
            what,
            reason=reason,
            sequence=packet.sequence,
        )

    def _unwrap_sequence(self, raw: int) -> int:
        if self._highest < 0:
            return raw
        step = (raw - self._highest + (_WRAP_32 >> 1)) % _WRAP_32 - (_WRAP_32 >> 1)
        sequence = self._highest + step
        return sequence if sequence >= 0 else sequence + _WRAP_32

    def _place_in_epoch(self, sequence: int, device_us: int) -> int:
        """Return session time, with the wraps of a 64-bit or (71 minutes) 32-bit counter undone."""
        epochs = self.declaration.clock_epochs
        epoch = epochs[-1]
        if sequence < epoch.first_sequence:
            epoch = next((one for one in reversed(epochs) if sequence >= one.first_sequence), epochs[0])
        elapsed_us = (device_us - epoch.device_start_us + (_WRAP_64 >> 1)) % _WRAP_64 - (_WRAP_64 >> 1)
        if device_us < _WRAP_32 and epoch.device_start_us < _WRAP_32:
            expected_us = self._highest_time_us - epoch.session_start_us
            elapsed_us += _WRAP_32 * round((expected_us - elapsed_us) / _WRAP_32)
        return epoch.session_start_us + elapsed_us

    def _add_epoch(self, epoch: ClockEpoch) -> None:
        self.declaration = replace(self.declaration, clock_epochs=(*self.declaration.clock_epochs, epoch))

    def advance(self, times_us: Sequence[int], sequence: int, duration_us: int, arrival_s: float) -> None:
        """Note the next packets in order, whose places another has found; see `admit`.

        Parameters
        ----------
        times_us : sequence of int
            Session time of each.
        sequence, duration_us, arrival_s
            Of the last.
        """
        self._highest, self._highest_time_us, self._highest_duration_us = sequence, times_us[-1], duration_us
        self._highest_arrival_s = arrival_s
        self._is_new_connection = False
        sequences, times = self._sequences, self._times
        for number, time_us in enumerate(times_us, sequence + 1 - len(times_us)):
            slot = number % _REMEMBERED
            sequences[slot], times[slot] = number, time_us

    def state(self) -> tuple[int, int, int]:
        """Return sequence, session time and duration of the newest packet, us."""
        return self._highest, self._highest_time_us, self._highest_duration_us

    def restore(self, state: tuple[int, int, int]) -> None:
        """Go on behind a packet, as `state` gave it; earlier ones that come again are known to the store only."""
        self._highest, self._highest_time_us, self._highest_duration_us = state
        self._remember(self._highest, self._highest_time_us)

    def fill(self, x: Any) -> None:
        """Write into a record of `SLOT` what the next packet in order must fit; there must be an epoch."""
        epoch = self.declaration.clock_epochs[-1]
        x["next_sequence"] = self._highest + 1
        x["epoch_device_us"] = (epoch.device_start_us + (_WRAP_64 >> 1)) % _WRAP_64 - (_WRAP_64 >> 1)
        x["epoch_session_us"] = epoch.session_start_us
        x["highest_time_us"], x["highest_duration_us"] = self._highest_time_us, self._highest_duration_us

    def _remember(self, sequence: int, time_us: int) -> None:
        slot = sequence % _REMEMBERED
        self._sequences[slot], self._times[slot] = sequence, time_us


class SkewEstimator:
    """How fast the device clock runs against the server's, from the quickest packets.

    Delay on the way is never negative, so the lower envelope of arrival minus device time is the clock; its
    slope is the skew. One minimum a second over the last two minutes, then a line under them.
    """

    def __init__(self, window_s: int = 120) -> None:
        self._minima: deque[tuple[float, float]] = deque(maxlen=window_s)
        self._second = -1
        self._found: tuple[float, float | None] = (-math.inf, None)

    def add(self, arrived: Iterable[tuple[float, float]]) -> None:
        """Take device time (of its last tick) and monotonic arrival time of each packet, s."""
        for device_s, arrival_s in arrived:
            delay = arrival_s - device_s
            second = int(device_s)
            if second == self._second:
                if delay < self._minima[-1][1]:
                    self._minima[-1] = (device_s, delay)
            elif second > self._second:
                self._second = second
                self._minima.append((device_s, delay))

    def reset(self) -> None:
        """Forget: the device clock started again or the stream was resumed."""
        self._minima.clear()
        self._second, self._found = -1, (-math.inf, None)

    @property
    def skew_ppm(self) -> float | None:
        """Server seconds per device second minus one, in 1e-6.

        None before 20 s, and when it is no clock at all: more than 2000 ppm, so not sent in real time. Found again
        every few seconds; clocks drift slowly.
        """
        if len(self._minima) < 20 or self._minima[-1][0] - self._minima[0][0] < 20.0:
            return None
        newest_s = self._minima[-1][0]
        if newest_s - self._found[0] >= _SKEW_EVERY_S:
            slope = _slope_under(self._minima)
            self._found = (newest_s, None if abs(slope) > 2e-3 else 1e6 * slope)
        return self._found[1]


def _slope_under(points: Iterable[tuple[float, float]]) -> float:
    """Slope of the line below all points with the smallest sum of distances to them.

    It is the edge of the lower convex hull that spans the mean of x (the dual of that linear program). Points (x, y)
    come with rising x.
    """
    hull: list[tuple[float, float]] = []
    total = count = 0.0
    for x, y in points:
        total, count = total + x, count + 1.0
        while len(hull) >= 2:
            (xa, ya), (xb, yb) = hull[-2:]
            if (yb - ya) * (x - xa) < (y - ya) * (xb - xa):
                break
            hull.pop()
        hull.append((x, y))
    for (xa, ya), (xb, yb) in pairwise(hull):
        if xb * count >= total:
            return (yb - ya) / (xb - xa)
    return 0.0
