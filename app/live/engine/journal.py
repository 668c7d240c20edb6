"""The packets that the edge has received since the last turn, in order, with their session."""

from typing import Any, Final, Protocol

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

    @property
    def lane(self) -> Any:
        """The place of its session among those whose packets are taken together; None where it has none at present."""

    def take_rare(self, data: bytes, arrival_s: float, arrival_ns: int) -> None:
        """Take a packet the general way; never raises."""


Received = tuple[Sender, int, int, int, float, int]
"""A packet in the journal: sender, offset, length, key of its mask; arrival, monotonic in s and since the epoch in ns.

A plain tuple: thousands are made a second.
"""
SENDER: Final = 0
OFFSET: Final = 1
LENGTH: Final = 2
KEY: Final = 3


class Journal:
    """Bytes of packets, each at a multiple of eight, and a list of them."""

    def __init__(self, size: int = JOURNAL_BYTES) -> None:
        self._words = np.zeros(size // 8, dtype=np.uint64)
        self.packets = Packets(
            self._words.view(np.uint8), self._words.view(np.int16), self._words.view(np.float32), TABLES
        )
        self.bytes = self.packets.data.data.cast("B")
        self.received: list[Received] = []
        self._size, self._end = len(self.bytes), 0

    def add(self, sender: Sender, data: memoryview, key: int, arrival_s: float, arrival_ns: int) -> bool:
        """Copy a packet, masked with a key of four bytes (little endian; 0 for none); False when there is no room."""
        start, length = self._end, len(data)
        if start + length + 8 > self._size:
            return False
        self.bytes[start : start + length] = data
        self.received.append((sender, start, length, key, arrival_s, arrival_ns))
        self._end = (start + length + 7) & ~7
        return True

    def unmask(self) -> None:
        """Undo the masks of all packets; once a turn."""
        masked = [one for one in self.received if one[KEY]]
        if masked:
            unmask(
                self._words,
                np.array(
                    [(at // 8, (length + 7) // 8, key) for _, at, length, key, _, _ in masked], dtype=np.int64
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
