"""Pools of live sessions with equal sensors and settings: rows, free slots, and the compiled calls of a turn."""

import os
from collections.abc import Hashable, Iterator, Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from app.live.blocks import HEAD_WORDS, PublishedBlock, block_heads, column_names
from app.live.checks.recent import LATE_TICKS
from app.live.engine.block_kernel import write_blocks
from app.live.engine.journal import Journal
from app.live.engine.step_thread import StepThread, Take, asked, take_arms
from app.network.placing.kernel import place
from app.network.placing.slot import (
    ITEM,
    MOST_TICKS,
    ORDINARY,
    WAITS,
    Network,
    carried_by,
    network_rows,
    room_for,
)
from estimators.channels import CARRIED
from estimators.compiling import unchecked
from estimators.pipelines import Frames, Pipeline
from estimators.pipelines.arm.pool import ArmPool
from estimators.pipelines.pooled import STRETCH, Pool, StepPool
from estimators.pipelines.relative.pool import RelativePool
from estimators.pipelines.walk.pool import WalkPool

SESSIONS: Final = 128
"""Of a pool; its arrays are made at once, and memory is used where a session is."""
FRAME_ROWS: Final = LATE_TICKS
"""Ticks of a session whose frames wait until they are stored and shown to whoever wants all of them."""
CORES: Final = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
"""With one a thread that estimates would only take the loop's time."""
ITEMS: Final = 64
"""Packets of one call: between calls the interpreter's lock is taken, and a turn's memory stays small."""
KINDS: Final[tuple[type[Pool], ...]] = (ArmPool, RelativePool, WalkPool, StepPool)
"""Of pools, those with a compiled step first; the last takes any pipeline."""
_STEP_FIELDS: Final = ("slot", "first_tick", "ticks", "signals_at", "quality_at", "tick_at")
_PLACES: Final = {name: place for place, name in enumerate(ITEM.names or ())}
STATUS, SEQUENCE, TIME_US, DURATION_US = (
    _PLACES[n] for n in ("status", "sequence", "time_us", "duration_us")
)
NEXT_TICK, LAST_POSITION, ROWS_KNOWN = (_PLACES[n] for n in ("next_tick", "last_position", "rows_known"))
FIRST_TICK, TICKS, TICK_AT, IS_FLAWED = (_PLACES[n] for n in ("first_tick", "ticks", "tick_at", "is_flawed"))
QUALITY_AT, IS_BACKFILLED = _PLACES["quality_at"], _PLACES["is_backfilled"]
"""Places of the values of a row."""


def pool_key(pipeline: Pipeline, channels: int, carried: int) -> Hashable | None:
    """Return what sessions of a pool have in common; None for one that can be in none.

    Parameters
    ----------
    channels : int
        Of motion.
    carried : int
        Bits of those beside it.
    """
    cells = {spec.cell for spec in carried_by(carried) if spec.cell}
    if any(spec.cell in cells and not carried & spec.bit for spec in CARRIED):
        # Half a cell takes the general way.
        return None
    kind, key = _kind_of(pipeline)
    return kind, channels, carried, key


def _kind_of(pipeline: Pipeline) -> tuple[type[Pool], Hashable]:
    """Return the first kind of pool that takes a pipeline as it stands, and its key there."""
    return next((kind, key) for kind in KINDS if (key := kind.key(pipeline)) is not None)


def _columns(carried: int) -> dict[str, slice]:
    """Return where the channels beside motion are, by field of `ImuChunk`."""
    found, first = {}, 0
    for spec in carried_by(carried):
        found[spec.field] = slice(first, first + spec.width)
        first += spec.width
    return found


class SessionPool:
    """Rows for some sessions of one kind."""

    def __init__(
        self,
        like: Pipeline,
        channels: int,
        carried: int,
        recent_ticks: int,
        journals: tuple[Journal, Journal],
    ) -> None:
        sensors = len(like.setup.placements)
        most_ticks = ITEMS * MOST_TICKS
        rows = SESSIONS * FRAME_ROWS
        self.kind = _kind_of(like)[0](like, channels, SESSIONS, rows, _columns(carried))
        self.sensors = sensors
        self.network: Network = network_rows(SESSIONS, channels, sensors, recent_ticks, carried)
        self.free = list(range(SESSIONS))[::-1]
        self._items = np.zeros(ITEMS, dtype=ITEM)
        self._stretches = np.zeros(ITEMS, dtype=STRETCH)
        self._filled = tuple(self._items[name] for name in ("slot", "offset", "length"))
        self._stepped = tuple((self._stretches[name], self._items[name]) for name in _STEP_FIELDS)
        self._placed = room_for(channels, sensors, most_ticks, carried)
        self._carried = _columns(carried)
        self.has_coils = "coil_state" in self._carried
        """Whether the sensors say which coil is on."""
        self._width = len(column_names(like.layout))
        self._numbers = np.empty(most_ticks * (self._width + HEAD_WORDS), dtype=np.float32)
        self._words = self._numbers.view(np.uint32)
        none = np.empty((0, 3), dtype=np.int64), np.empty((0, HEAD_WORDS), dtype=np.uint32)
        write_blocks(*none, self.kind.columns, self._words, self._numbers)
        self._write = unchecked(write_blocks)
        self._time_step_s = 1.0 / like.setup.rate_hz
        self._count = 0
        self._thread: StepThread | None = None
        self._journals = journals
        self._take: Take | None = None
        if isinstance(self.kind, ArmPool):
            self._take = self._take_arms(self.kind)
            if CORES > 1:
                self._thread = StepThread(self._take)

    def _take_arms(self, kind: ArmPool) -> Take:
        arrays = (
            self._items,
            self._stretches,
            self._journals[0].packets,
            self._journals[1].packets,
            self.network,
            self._placed,
            *kind.arrays,
        )
        # Asked for their types once, with nothing to take: a wrong one would be read as if it were right.
        take_arms(asked(0, 0, FRAME_ROWS), np.empty(1, dtype=np.uint8), *arrays)
        take = unchecked(take_arms)
        return lambda request, byte: take(request, byte, *arrays)

    @property
    def answers(self) -> int | None:
        """File descriptor that can be read once what `ask` asked for is done; None where a pool has no thread."""
        return None if self._thread is None else self._thread.answers

    @property
    def has_answered(self) -> bool:
        """Whether what `ask` asked for is done; only while something is asked for."""
        assert self._thread is not None
        return self._thread.has_answered

    def fill(self, slots: Sequence[int], offsets: Sequence[int], lengths: Sequence[int]) -> None:
        """Note which packets are to be taken next, up to `ITEMS`, in the order in which they came.

        Parameters
        ----------
        offsets, lengths : sequence of int
            Where they lie in the journal.
        """
        self._count = count = len(slots)
        for field, values in zip(self._filled, (slots, offsets, lengths), strict=True):
            field[:count] = values

    def take(self, journal: int) -> None:
        """Take them, from the first or the second journal, which is unmasked."""
        if self._take is not None:
            self._take(asked(self._count, journal, FRAME_ROWS), np.empty(1, dtype=np.uint8))
            return
        packets = self._journals[journal].packets
        place(self._items, self._count, packets, self.network, self._placed, FRAME_ROWS)
        for stretches, items in self._stepped:
            stretches[: self._count] = items[: self._count]
        self.kind.step(
            self._stretches, self._count, self._placed.signals, self._placed.quality, self._placed.carried
        )

    def ask(self, journal: int) -> None:
        """Let the pool's thread take them; `wait` before anything else."""
        assert self._thread is not None
        self._thread.ask(self._count, journal, FRAME_ROWS)

    def wait(self) -> None:
        """Wait until they are taken; raises what taking them raised."""
        assert self._thread is not None
        self._thread.wait()

    def rows(self) -> list[tuple[Any, ...]]:
        """Return what was found of them: values of `ITEM`."""
        items = self._items[: self._count]
        for slot, (first, _) in self.kind.errors.items():
            # What came before in the same call was estimated.
            items["ticks"][first:][items["slot"][first:] == slot] = 0
        rows: list[tuple[Any, ...]] = items.tolist()
        return rows

    def close(self) -> None:
        """Let the pool's thread end."""
        if self._thread is not None:
            self._thread.close()
            self._thread = None

    def frames(self, first_tick: int, row: int, ticks: int) -> Frames:
        """Return a copy of what was found in some ticks that wait.

        Parameters
        ----------
        first_tick : int
            Number of the first tick wanted.
        row : int
            Of its frames, as `take` returned it.
        """
        assert row // FRAME_ROWS == (row + ticks - 1) // FRAME_ROWS, "frames of another session"
        return self.kind.frames(first_tick, row, row + ticks)

    def carried(self, row: tuple[Any, ...], name: str) -> NDArray[np.float64] | None:
        """Return a channel of a packet that comes beside motion, shape (S, K, width); None where it has none."""
        part = self._carried.get(name)
        if part is None:
            return None
        width, samples = self.network.carried.shape[2], self.sensors * row[TICKS]
        first = width * row[QUALITY_AT]
        found = self._placed.carried[first : first + width * samples]
        return found.reshape(self.sensors, row[TICKS], width)[:, :, part]

    def settled(self, slot: int) -> None:
        """Let the rows of a session's frames be written again."""
        x: Any = self.network.slot[slot]
        x["frame_row"] = 0
        # Where a rare packet stands before what waits, the session's row is filled again before any other is taken.
        if x["blocked"] == WAITS:
            x["blocked"] = ORDINARY

    def quality(self, row: tuple[Any, ...]) -> NDArray[np.uint8]:
        """Return a copy of a packet's quality, shape (S, K)."""
        at, ticks = row[QUALITY_AT], row[TICKS]
        return self._placed.quality[at : at + self.sensors * ticks].reshape(self.sensors, ticks).copy()

    def blocks(self, numbers: Sequence[int], published_at_s: float) -> Iterator[PublishedBlock]:
        """Yield the block of each packet that is wanted.

        Parameters
        ----------
        numbers : sequence of int
            Of the packets among those that were taken last; each has ticks.
        published_at_s : float
            Since the epoch.
        """
        items = self._items[np.array(numbers)]
        ticks = items["ticks"]
        heads = block_heads(ticks, self._width, items["first_tick"], self._time_step_s, published_at_s)
        sizes = HEAD_WORDS + ticks * self._width
        places = np.zeros((len(items), 3), dtype=np.int64)
        places[:, 0], places[:, 1] = items["tick_at"], ticks
        sizes[:-1].cumsum(out=places[1:, 2])
        self._write(places, heads, self.kind.columns, self._words, self._numbers)
        written = self._numbers.data.cast("B")
        for start, size in zip((4 * places[:, 2]).tolist(), (4 * sizes).tolist(), strict=True):
            yield PublishedBlock(bytes(written[start : start + size]))
