"""What the edge has received since the last turn: packets, one after the other, and whose they are."""

from typing import Final, NamedTuple, Protocol

import numpy as np
from numba import types
from numpy.typing import NDArray

from app.network.placing.crc import TABLES
from app.network.placing.slot import Packets
from estimators.compiling import compiled
from estimators.kernels import VOID

JOURNAL_BYTES: Final = 4 << 20
"""A turn begins early when so much has come: three thousand packets of 17 sensors."""


class Sender(Protocol):
    """Whoever a packet came from."""

    def was_right(self) -> None:
        """Count a packet that was taken together with others."""

    def take_rare(self, data: bytes, arrival_s: float, arrival_ns: int) -> None:
        """Take a packet the general way; never raises."""


class Received(NamedTuple):
    """A packet in the journal, and when it came."""

    sender: Sender
    offset: int
    length: int
    key: int
    arrival_s: float
    arrival_ns: int


class Journal:
    """Bytes of packets, each at a multiple of eight, and a list of them.

    Attributes
    ----------
    packets : Packets
    received : list of Received
    """

    def __init__(self, size: int = JOURNAL_BYTES) -> None:
        self._words = np.zeros(size // 8, dtype=np.uint64)
        self.packets = Packets(
            self._words.view(np.uint8), self._words.view(np.int16), self._words.view(np.float32), TABLES
        )
        self.bytes = self.packets.data.data.cast("B")
        self.received: list[Received] = []
        self._end = 0

    def has_room(self, length: int) -> bool:
        """Whether a packet of this length fits."""
        return self._end + length + 8 <= len(self.bytes)

    def add(self, sender: Sender, data: memoryview, key: int, arrival_s: float, arrival_ns: int) -> None:
        """Copy a packet, masked with a key of four bytes (little endian; 0 for none)."""
        start, length = self._end, len(data)
        self.bytes[start : start + length] = data
        self.received.append(Received(sender, start, length, key, arrival_s, arrival_ns))
        self._end = (start + length + 7) & ~7

    def unmask(self) -> None:
        """Undo the masks of all packets; once a turn."""
        masked = [one for one in self.received if one.key]
        if masked:
            unmask(
                self._words,
                np.array(
                    [(one.offset // 8, (one.length + 7) // 8, one.key) for one in masked], dtype=np.int64
                ),
            )

    def clear(self) -> None:
        """Forget all packets."""
        self.received = []
        self._end = 0


@compiled(VOID(types.uint64[::1], types.int64[:, ::1]))
def unmask(words: NDArray[np.uint64], masked: NDArray[np.int64]) -> None:
    """Undo the masks of WebSocket frames in place.

    Parameters
    ----------
    words : ndarray of uint64
        The journal.
    masked : ndarray of int64, shape (N, 3)
        First word, words, and key of each; behind the end of a packet nothing is read.
    """
    for n in range(masked.shape[0]):
        key = np.uint64(masked[n, 2])
        mask = key | (key << np.uint64(32))
        for k in range(masked[n, 0], masked[n, 0] + masked[n, 1]):
            words[k] ^= mask


__all__ = ["JOURNAL_BYTES", "Journal", "Received", "Sender", "unmask"]
