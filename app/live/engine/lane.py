"""One live session's place in the pooled engine, and what is done in Python with a packet that compiled code took."""

import struct
import time
from collections.abc import Hashable
from typing import Any, Final, Protocol

from app.live.blocks import PublishedBlock
from app.live.checks.health import LinkHealth
from app.live.checks.recent import RecentSamples
from app.live.engine.pools import (
    DURATION_US,
    FIRST_TICK,
    IS_FLAWED,
    LAST_POSITION,
    NEXT_TICK,
    ROWS_KNOWN,
    SEQUENCE,
    TICKS,
    TIME_US,
    SessionPool,
    Taken,
    pool_key,
)
from app.live.session.estimation import EstimationLine
from app.live.session.ledger import SequenceLedger
from app.live.session.states import STREAMING, StateMachine
from app.network.alignment import Aligner
from app.network.clock import PacketClock
from app.network.declaration import Declaration
from app.network.packet import HEADER_BYTES
from app.network.raw_packet import RawPacket
from estimators.pipelines import Frames, Pipeline
from estimators.recording import ImuChunk


class Pooled(Protocol):
    """What the engine needs of a live session."""

    id: str
    clock: PacketClock
    aligner: Aligner
    pipeline: Pipeline
    ledger: SequenceLedger
    health: LinkHealth
    line: EstimationLine
    machine: StateMachine

    @property
    def declaration(self) -> Declaration:
        """The network."""

    @property
    def is_plain(self) -> bool:
        """Whether all that happens to the next packet is what the pooled engine does."""

    @property
    def is_watched(self) -> bool:
        """Whether somebody wants blocks of its frames."""

    @property
    def recent(self) -> RecentSamples:
        """The newest seconds of its samples."""

    def publish_block(self, block: PublishedBlock) -> None:
        """Give a block to whoever watches."""

    def took(self, raw: RawPacket, end_s: float, arrival_s: float) -> None:
        """Store and count a packet that was placed in order; `end_s` is its session time."""

    def after_pooled(self, frames: Frames, ticks: int, chunk: ImuChunk | None) -> None:
        """Publish and store what was found in so many ticks; `chunk` where a sample is less than measured."""


class Slots(Protocol):
    """Where lanes get their places."""

    def slot_for(
        self, key: Hashable, like: Pipeline, channels: int, recent_ticks: int
    ) -> tuple[SessionPool, int]:
        """Return a pool for a session of this key, and a free slot in it."""

    def leave(self, pool: SessionPool, slot: int) -> None:
        """Free a slot; a pool without sessions goes."""


_FIELDS: Final = struct.Struct("<4sBBHBBHIQI")


class Lane:
    """Lets a session's packets be taken by compiled code whenever nothing but ordinary packets is to be expected.

    The session's clock, alignment, pipeline and newest samples go on over rows of a pool. Whatever else happens to the
    session moves them on as before; the lane notices by what they hold, and goes on from there.

    Parameters
    ----------
    session : Pooled
    engine : Slots
    """

    def __init__(self, session: Pooled, engine: Slots) -> None:
        self.session = session
        self.pool: SessionPool | None = None
        self.slot = -1
        self._engine = engine
        self._key: Hashable | None = None
        self._known: tuple[object, ...] | None = None
        self._next = (-1, -1)

    @property
    def is_ready(self) -> bool:
        """Whether compiled code may take the next packet."""
        session = self.session
        clock, aligner = session.clock, session.aligner
        if session.machine.state not in STREAMING or not session.is_plain or aligner.waiting:
            return False
        declaration, setup, known = clock.declaration, session.pipeline.setup, self._known
        if (
            self._next == (clock.highest, aligner.next_tick)
            and known is not None
            and known[0] is declaration
            and known[1] is setup
            and known[2] is aligner
        ):
            return True
        return self._enter((declaration, setup, aligner))

    def _enter(self, known: tuple[object, ...]) -> bool:
        session = self.session
        clock, aligner = session.clock, session.aligner
        if (
            not clock.declaration.clock_epochs
            or not aligner.is_in_order
            or aligner.next_sequence != clock.highest + 1
            or session.ledger.received.highest != clock.highest
        ):
            return False
        key = pool_key(session.pipeline, aligner.channel_count)
        if key is None:
            self.leave()
            return False
        if key != self._key:
            self.leave()
            self.pool, self.slot = self._engine.slot_for(
                key, session.pipeline, aligner.channel_count, session.recent.ticks
            )
            self._key = key
        pool = self.pool
        if pool is None or not pool.kind.join(self.slot, session.pipeline):
            return False
        aligner.share(pool.network, self.slot)
        session.recent.share(pool.network.recent[self.slot], pool.network.recent_quality[self.slot])
        x: Any = pool.network.slot[self.slot]
        clock.fill(x)
        aligner.fill(x)
        x["is_blocked"] = 0
        self._known, self._next = known, (clock.highest, aligner.next_tick)
        return True

    def leave(self) -> None:
        """Give the session arrays of its own and free the slot."""
        if self.pool is None:
            return
        self.pool.kind.leave(self.slot, self.session.pipeline)
        self.session.aligner.own()
        self.session.recent.own()
        self._engine.leave(self.pool, self.slot)
        self.pool, self.slot, self._key, self._known = None, -1, None, None

    def forget(self) -> None:
        """Look anew where the session stands before the next packet is taken."""
        self._next = (-2, -2)

    def took(
        self, taken: Taken, row: tuple[Any, ...], data: memoryview, arrival_s: float, arrival_ns: int
    ) -> None:
        """Do the rest for an ordinary packet: store it, carry clock and alignment on, store and count what came of it.

        Parameters
        ----------
        taken : Taken
        row : tuple
            Of the packet.
        data : memoryview
            The packet.
        arrival_s, arrival_ns
            As of `LiveSession.receive`.
        """
        session, pool = self.session, taken.pool
        sequence, time_us, duration_us = row[SEQUENCE], row[TIME_US], row[DURATION_US]
        _, sensors, sent, mask, encoding, flags, _, _, device_us, interval_us = _FIELDS.unpack_from(data)
        raw = RawPacket(
            sequence,
            device_us,
            interval_us,
            sensors,
            sent,
            mask,
            encoding,
            flags,
            bytes(data[HEADER_BYTES:]),
            arrival_ns,
        )
        next_tick, ticks = row[NEXT_TICK], row[TICKS]
        session.clock.advance(sequence, time_us, duration_us, arrival_s)
        session.aligner.advance(
            sequence, time_us + duration_us, next_tick, row[LAST_POSITION], row[ROWS_KNOWN]
        )
        pool.kind.stepped(session.pipeline, next_tick)
        self._next = (sequence, next_tick)
        session.took(raw, (time_us + duration_us) * 1e-6, arrival_s)
        if not ticks:
            return
        first_tick = row[FIRST_TICK]
        chunk = None
        if row[IS_FLAWED] or session.health.has_gaps:
            quality = pool.quality(row)
            nothing = session.recent.chunk(first_tick, first_tick + ticks, session.declaration.time_step_s)
            chunk = ImuChunk(
                first_tick,
                nothing.time_step_s,
                nothing.gyroscope_radps,
                nothing.accelerometer_mps2,
                nothing.magnetometer_t,
                quality,
            )
        session.after_pooled(taken.frames(session.pipeline, row), ticks, chunk)
        session.health.latencies_s.append(time.monotonic() - arrival_s)


__all__ = ["Lane"]
