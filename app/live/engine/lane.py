"""One live session's place in the pooled engine, and what is done in Python with a packet that compiled code took."""

import logging
import math
import threading
from collections.abc import Callable, Hashable, Sequence
from typing import Any, Final, Protocol

from app.live.bus import Channel
from app.live.checks.health import LinkHealth
from app.live.checks.recent import RecentSamples
from app.live.engine.pools import (
    DURATION_US,
    FIRST_TICK,
    FRAME_ROWS,
    IS_BACKFILLED,
    IS_FLAWED,
    LAST_POSITION,
    NEXT_TICK,
    ROWS_KNOWN,
    SEQUENCE,
    TICK_AT,
    TICKS,
    TIME_US,
    SessionPool,
    pool_key,
)
from app.live.session.estimation import EstimationLine
from app.live.session.ledger import SequenceLedger
from app.live.session.states import STREAMING, StateMachine
from app.network.alignment import Aligner
from app.network.clock import PacketClock, SkewEstimator
from app.network.declaration import Declaration
from app.network.packet_run import PacketRun, runs_of
from estimators.pipelines import Frames, Pipeline
from estimators.recording import Float, ImuChunk

logger = logging.getLogger(__name__)

SETTLE_TICKS: Final = 160
"""A session whose frames take up more rows is settled before its next packet."""


TakenPacket = tuple[tuple[Any, ...], bytes, float, int]
"""A packet that compiled code took, and that is not settled yet: its row of `ITEM`, its bytes, and when it came
(monotonic, s; since the epoch, ns). A plain tuple: thousands are made a second."""
ROW: Final = 0
MESSAGE: Final = 1
ARRIVAL_S: Final = 2
ARRIVAL_NS: Final = 3


class Parts:
    """Parts of a live session that packets move on."""

    def __init__(self, declaration: Declaration, pipeline: Pipeline, first_tick: int) -> None:
        self.clock = PacketClock(declaration)
        self.aligner = Aligner(declaration, first_tick=first_tick)
        self.ledger = SequenceLedger()
        self.skew = SkewEstimator()
        self.health = LinkHealth(declaration.placements, declaration.time_step_s)
        self.pipeline = pipeline
        self.key: tuple[tuple[object, ...], bytes] | None = None
        """Of checkpoints, behind what it was made of."""


class Pooled(Protocol):
    """What the engine needs of a live session: its parts as they stood when its lane was last settled."""

    id: str
    now: Parts
    line: EstimationLine
    machine: StateMachine
    channels: dict[str, Channel]
    guidance: Any
    actuation: Any

    @property
    def is_plain(self) -> bool:
        """Whether all that happens to the next packet is what the pooled engine does."""

    @property
    def recent(self) -> RecentSamples:
        """The newest seconds of its samples."""

    def show(self, frames: Frames, *, is_live: bool) -> None:
        """Publish frames to the subscribers; `is_live` where they came as they were measured."""

    def watch_source(self, first_tick: int, coil_state: Float | None) -> None:
        """Look whether a coil is on that nobody asked for."""

    def took(self, taken: Sequence[TakenPacket], runs: Sequence[PacketRun], *, is_live: bool) -> None:
        """Store and count packets that were placed in order, all of them as they were measured or none."""

    def after_pooled(self, frames: Frames, whole: Sequence[int], chunk: ImuChunk | None) -> None:
        """Store and count what was found.

        `whole` has the ticks of each packet whose samples were all measured; `chunk` those of the last that is not so.
        """


class Slots(Protocol):
    """Where lanes get their places."""

    is_being_prepared: Callable[[], bool]
    """Whether no session may join yet."""

    def slot_for(
        self, key: Hashable, like: Pipeline, channels: int, carried: int, recent_ticks: int
    ) -> tuple[SessionPool, int]:
        """Return a pool for a session of this key, and a free slot in it."""

    def leave(self, pool: SessionPool, slot: int) -> None:
        """Free a slot; a pool without sessions goes."""

    def finish(self, lane: "Lane | None" = None) -> None:
        """End what is being worked on for a session, or for any."""


class Lane:
    """Lets a session's packets be taken by compiled code whenever nothing but ordinary packets is to be expected.

    The session's clock, alignment, pipeline and newest samples go on over rows of a pool. Whatever else happens to the
    session moves them on as before; the lane notices by what they hold, and goes on from there.
    """

    def __init__(self, session: Pooled, engine: Slots) -> None:
        self.session = session
        self.blocks = session.channels["blocks"]
        """Where the blocks of its frames go."""
        self.is_sure = False
        """Whether nothing can have moved the session since `is_ready` last looked at it closely."""
        self.taken = 0
        """Packets that compiled code took."""
        self.tries = 0
        """Calls that left packets waiting behind a rare one, since compiled code took the last."""
        self._frames = session.channels["frames"]
        self.pool: SessionPool | None = None
        self.slot = -1
        self._engine = engine
        self._key: Hashable | None = None
        self._known: tuple[object, ...] | None = None
        self._next = (-1, -1)
        self._taken: list[TakenPacket] = []
        self._ticks = self._rows = 0
        self._thread = threading.get_ident()

    @property
    def is_ready(self) -> bool:
        """Whether compiled code may take the next packet."""
        session = self.session
        if self._rows > SETTLE_TICKS and self.pool is not None:
            # Nothing of it is on its way through a turn: its rows are free once it is settled. What that finds may move
            # the session, so it comes before the questions.
            self.settle()
            self.pool.settled(self.slot)
            self._rows, self.is_sure = 0, False
        if session.machine.state not in STREAMING:
            return False
        if self.is_sure and session.line.is_idle:
            return True
        self.is_sure = False
        parts = session.now
        clock, aligner = parts.clock, parts.aligner
        if not session.is_plain or aligner.waiting:
            return False
        declaration, setup, known = clock.declaration, parts.pipeline.setup, self._known
        if (
            self._next == (clock.highest, aligner.next_tick)
            and known is not None
            and known[0] is declaration
            and known[1] is setup
            and known[2] is aligner
        ):
            self.is_sure = True
        else:
            self.is_sure = self._enter((declaration, setup, aligner))
        return self.is_sure

    def _enter(self, known: tuple[object, ...]) -> bool:
        if self._engine.is_being_prepared():
            return False
        self.settle()
        session, parts = self.session, self.session.now
        clock, aligner, pipeline = parts.clock, parts.aligner, parts.pipeline
        if (
            not clock.declaration.clock_epochs
            or not aligner.is_in_order
            or aligner.next_sequence != clock.highest + 1
            or parts.ledger.received.highest != clock.highest
        ):
            return False
        key = pool_key(pipeline, aligner.channel_count, aligner.carried_mask)
        if key is None:
            self.leave()
            return False
        if key != self._key:
            self.leave()
            self.pool, self.slot = self._engine.slot_for(
                key, pipeline, aligner.channel_count, aligner.carried_mask, session.recent.ticks
            )
            self._key = key
        pool = self.pool
        if pool is None or not pool.kind.join(self.slot, pipeline):
            return False
        aligner.share(pool.network, self.slot)
        session.recent.share(pool.network.recent[self.slot], pool.network.recent_quality[self.slot])
        x: Any = pool.network.slot[self.slot]
        clock.fill(x)
        aligner.fill(x)
        x["blocked"] = x["frame_row"] = 0
        self._known, self._next = known, (clock.highest, aligner.next_tick)
        return True

    def leave(self) -> None:
        """Give the session arrays of its own and free the slot."""
        if self.pool is None:
            return
        self.settle()
        self.pool.kind.leave(self.slot, self.session.now.pipeline)
        self.session.now.aligner.own()
        self.session.recent.own()
        self._engine.leave(self.pool, self.slot)
        self.pool, self.slot, self._key, self._known = None, -1, None, None
        self.is_sure = False

    def forget(self) -> None:
        """Look again where the session stands before the next packet is taken."""
        self.settle()
        self._next, self.is_sure = (-2, -2), False

    @property
    def newest_arrival_s(self) -> float:
        """Monotonic time at which the newest packet came that is not settled; minus infinity where none is."""
        return self._taken[-1][ARRIVAL_S] if self._taken else -math.inf

    def took(
        self, row: tuple[Any, ...], message: bytes, arrival_s: float, arrival_ns: int, now_s: float
    ) -> None:
        """Take note of a packet that compiled code took; what is not wanted at once is done for some together.

        Parameters
        ----------
        row : tuple
            Of the packet.
        message : bytes
            The packet.
        arrival_s, arrival_ns
            As of `LiveSession.receive`.
        now_s : float
            Monotonic time at which what was found of it has been shown.
        """
        session, is_backfilled = self.session, row[IS_BACKFILLED]
        if self._taken and self._taken[-1][ROW][IS_BACKFILLED] != is_backfilled:
            # What came as it was measured is counted apart from what was filled in.
            self.settle()
        self.taken += 1
        self.tries = 0
        self._taken.append((row, message, arrival_s, arrival_ns))
        ticks = row[TICKS]
        self._ticks += ticks
        if not ticks:
            return
        assert self.pool is not None
        self._rows = row[TICK_AT] + ticks - self.slot * FRAME_ROWS
        health = session.now.health
        if not is_backfilled:
            health.latencies_s.append(now_s - arrival_s)
        guidance = session.guidance
        if (
            self._frames.listeners
            or (guidance is not None and guidance.is_following)
            or session.actuation is not None
        ):
            frames = self.pool.frames(row[FIRST_TICK], row[TICK_AT], ticks)
            session.show(frames, is_live=not is_backfilled)
        if self.pool.has_coils or session.actuation is not None:
            coils = self.pool.carried(row, "coil_state")
            session.watch_source(row[FIRST_TICK], None if coils is None else coils[:, :, 0])
        if row[IS_FLAWED] or health.has_gaps:
            self.settle()
            # What is found of a sensor may move the session.
            self.is_sure = False

    def settle(self) -> None:
        """Let the session's parts stand where its rows stand: carry them on over the packets since, store and count.

        Other threads than the event loop's see the session as it stood when it was last settled.
        """
        if threading.get_ident() != self._thread:
            return
        self._engine.finish(self)
        taken, pool = self._taken, self.pool
        if not taken or pool is None:
            return
        try:
            self._settle(taken, pool)
        except Exception as error:
            logger.exception("packets of session %s could not be settled", self.session.id)
            self.session.line.stop(error)

    def _settle(self, taken: list[TakenPacket], pool: SessionPool) -> None:
        ticks, self._taken, self._ticks = self._ticks, [], 0
        session, parts, last = self.session, self.session.now, taken[-1][ROW]
        sequence, next_tick = last[SEQUENCE], last[NEXT_TICK]
        rows, is_live = [one[ROW] for one in taken], not last[IS_BACKFILLED]
        parts.clock.advance([row[TIME_US] for row in rows], sequence, last[DURATION_US], taken[-1][ARRIVAL_S])
        parts.aligner.advance(
            sequence, last[TIME_US] + last[DURATION_US], next_tick, last[LAST_POSITION], last[ROWS_KNOWN]
        )
        pool.kind.stepped(parts.pipeline, next_tick)
        if pool.network.slot[self.slot]["next_sequence"] == sequence + 1:
            # Compiled code has taken no packet behind this one whose frames lie in further rows.
            pool.settled(self.slot)
            self._rows = 0
        self._next = (sequence, next_tick)
        messages, arrivals_ns = [one[MESSAGE] for one in taken], [one[ARRIVAL_NS] for one in taken]
        session.took(taken, runs_of(rows[0][SEQUENCE], messages, arrivals_ns), is_live=is_live)
        if not ticks:
            return
        shown = [row for row in rows if row[TICKS]]
        # Packets behind these may have none: where a pipeline raised.
        frames = pool.frames(shown[0][FIRST_TICK], shown[0][TICK_AT], ticks)
        whole, chunk = [row[TICKS] for row in shown], None
        if last[TICKS] and (last[IS_FLAWED] or parts.health.has_gaps):
            first_tick, step_s = next_tick - whole.pop(), parts.clock.declaration.time_step_s
            chunk = session.recent.chunk(first_tick, next_tick, step_s)
        session.after_pooled(frames, whole, chunk)
