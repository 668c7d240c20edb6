"""Turns of the pooled engine: what the edge received is taken together, by one compiled call a pool.

A turn begins some milliseconds after the first packet that waits for it. Packets of sessions that are in a pool are
checked, placed, estimated and written as blocks without the interpreter's lock; then Python stores and publishes them.
Rare packets, and those of sessions in no pool, take the general way, in their order. Everything runs on the event
loop's thread, except the compiled calls of pools that have much to do, which a thread makes (`step_thread`). Other code
that reads or changes a session first flushes its packets (`Lane.settle`), so that it works between two turns.
"""

import asyncio
import contextlib
import logging
import time
from collections import Counter
from collections.abc import Callable, Hashable
from typing import Any, Final

from app.ingest.websocket import metrics
from app.live.engine.journal import LENGTH, OFFSET, SENDER, Journal, Received, Sender
from app.live.engine.lane import Lane
from app.live.engine.pools import ITEMS, SESSIONS, STATUS, TICKS, SessionPool
from app.network.placing.slot import ORDINARY, RARE, WAITS
from estimators.pipelines import Pipeline

logger = logging.getLogger(__name__)

SHORTEST_WAIT_S: Final = 0.004
LONGEST_WAIT_S: Final = 0.012
"""Behind the first packet that waits for a turn."""
LATE_S: Final = 0.1
"""After a turn that lasted longer views go without: of the packets of a session in a turn only the newest is shown,
until a turn lasts half as long. What is estimated and stored stays whole."""
BEHIND_S: Final = 1.0
"""While a turn has lasted longer, and so long after it, packets that have arrived may be still to be taken."""
WAIT_PER_WORK: Final = 3.0
"""Between these a turn waits so many times as long as the one before lasted: the more there is, the more is taken
together."""
PATIENCE_S: Final = 0.25
"""Who waits for the time between two turns waits no longer."""
TRIES: Final = 3
"""So often what waits behind rare packets of a session is tried, then it is taken to be as rare: a try costs a call."""
ASKED: Final = 12
"""Packets of one pool that are worth a wake of its thread, some 0.1 ms; fewer are taken at once."""

_Items = list[tuple[Received, Lane]]
_Part = tuple[SessionPool, _Items, list[_Items]]
"""What a pool's thread works on, and what it is to work on after that."""


class PooledEngine:
    """Takes packets and gives them to their sessions, many at a time; on the event loop's thread only."""

    def __init__(self) -> None:
        self._filling, self._journals = 0, (Journal(), Journal())
        """What came since the last turn began is in one of them; what a turn works on is in the other."""
        self._open: list[_Part] = []
        """Parts of the turn that threads work on."""
        self._watched: set[int] = set()
        self._timer: asyncio.Handle | None = None
        self._is_due = False
        """Whether the next turn begins as soon as threads are done with this one."""
        self._is_between = asyncio.Event()
        self._wait_s = SHORTEST_WAIT_S
        self._pools: dict[Hashable, list[SessionPool]] = {}
        self.ordinary = 0
        """Packets that compiled code took."""
        self.rare = 0
        """Packets that took the general way."""
        self.turns = 0
        self.longest_turn_s = self._longest_since_asked_s = 0.0
        self.unshown = 0
        """Blocks that somebody would have watched, left out because turns were late."""
        self.is_late = False
        self._began_s, self._lasted_s, self._is_giving = 0.0, 0.0, False
        self.is_being_prepared: Callable[[], bool] = lambda: False
        """Asked before a session joins a pool: until the kernels are there its packets take the general way."""

    def slot_for(
        self, key: Hashable, like: Pipeline, channels: int, carried: int, recent_ticks: int
    ) -> tuple[SessionPool, int]:
        """Return a pool for a session of this key, and a free slot in it."""
        pools = self._pools.setdefault((key, recent_ticks), [])
        for pool in pools:
            if pool.free:
                return pool, pool.free.pop()
        pool = SessionPool(like, channels, carried, recent_ticks, self._journals)
        pools.append(pool)
        return pool, pool.free.pop()

    def leave(self, pool: SessionPool, slot: int) -> None:
        """Free a slot; a pool without sessions goes."""
        pool.free.append(slot)
        if len(pool.free) == SESSIONS:
            self._forget_answers(pool)
            pool.close()
            self._pools = {
                key: left
                for key, pools in self._pools.items()
                if (left := [one for one in pools if one is not pool])
            }

    def offer(self, sender: Sender, data: memoryview, key: int, arrival_s: float, arrival_ns: int) -> None:
        """Take a packet; it is given to its session within a turn.

        Parameters
        ----------
        data : memoryview
            As it came, masked.
        key : int
            The mask's four bytes, little endian; 0 for none.
        arrival_s, arrival_ns
            As of `LiveSession.receive`.
        """
        if not self._journals[self._filling].add(sender, data, key, arrival_s, arrival_ns):
            # Nothing more is read until threads are done with the other journal; then they go on with this one.
            self.finish()
            self.begin()
            self._journals[self._filling].add(sender, data, key, arrival_s, arrival_ns)
        if self._timer is None:
            self._timer = asyncio.get_running_loop().call_later(self._wait_s, self.begin)
        if self._open:
            self._end_answered()

    def turn(self) -> None:
        """Give all packets that wait to their sessions."""
        self.finish()
        self.begin()
        self.finish()

    def take(self, lane: Lane | None) -> None:
        """Give a session all of its packets that wait, for instance before it ends.

        Where none does, as after a goodbye, threads go on with the packets of others and nobody waits for them.

        Parameters
        ----------
        lane : Lane or None
            None where packets of the session go the general way: then it waits as for `turn`.
        """
        self.finish(lane)
        if any(one[SENDER].lane is lane for one in self._journals[self._filling].received):
            self.turn()

    def finish(self, lane: Lane | None = None) -> None:
        """Flush the packets that threads work on: the caller then sees a session with all of its packets.

        Parameters
        ----------
        lane : Lane, optional
            Only what has packets of this one: the rows of others may be worked on meanwhile.
        """
        while parts := [part for part in self._open if lane is None or _has(part, lane)]:
            self._end(parts[0])

    def take_longest_s(self) -> float:
        """Return how long the longest turn lasted since the last call; one that still lasts counts so far."""
        found, self._longest_since_asked_s = self._longest_since_asked_s, 0.0
        return max(found, time.perf_counter() - self._began_s) if self._open else found

    @property
    def is_behind(self) -> bool:
        """Whether somebody whose packets have arrived may look silent."""
        since_s = time.perf_counter() - self._began_s
        if self._open:
            return since_s > BEHIND_S
        return self._lasted_s > BEHIND_S and since_s < self._lasted_s + BEHIND_S

    async def between_turns(self) -> None:
        """Return when no thread works on packets: flushing sessions then does not block the event loop.

        Where packets come faster than they are worked on there is no such moment: then it returns after `PATIENCE_S`.
        """
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(PATIENCE_S):
                while self._open:
                    self._is_between.clear()
                    await self._is_between.wait()

    def begin(self) -> None:
        """Begin to give all packets that wait to their sessions; what threads have to do of it ends later.

        While threads still work on a turn the next one begins when they are done: the event loop does not wait.
        """
        if self._open:
            self._is_due = True
            return
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None
        journal = self._journals[self._filling]
        received = journal.received
        if not received:
            return
        self._began_s, self._is_giving = time.perf_counter(), True
        journal.unmask()
        journal.received = []
        self._filling = 1 - self._filling
        try:
            self._give(received)
        finally:
            self._is_giving = False
            self._close_turn()

    def _close_turn(self) -> None:
        """Forget the turn's packets, unless some are still being worked on."""
        if self._open or self._is_giving:
            return
        self._journals[1 - self._filling].clear()
        self._lasted_s = lasted_s = time.perf_counter() - self._began_s
        self.turns += 1
        self.longest_turn_s = max(self.longest_turn_s, lasted_s)
        self._longest_since_asked_s = max(self._longest_since_asked_s, lasted_s)
        self.is_late = lasted_s > (0.5 * LATE_S if self.is_late else LATE_S)
        self._wait_s = min(max(WAIT_PER_WORK * lasted_s, SHORTEST_WAIT_S), LONGEST_WAIT_S)
        self._is_between.set()
        if self._is_due:
            self._is_due = False
            self._timer = asyncio.get_running_loop().call_soon(self.begin)

    def _give(self, received: list[Received]) -> None:
        pooled: dict[SessionPool, _Items] = {}
        general: list[Received] = []
        unready: dict[Lane, _Items] = {}
        places: dict[Lane, SessionPool | None] = {}
        for one in received:
            lane: Lane | None = one[SENDER].lane
            if lane is None:
                general.append(one)
                continue
            if lane not in places:
                places[lane] = self._pool_of(lane)
            pool = places[lane]
            if pool is None:
                unready.setdefault(lane, []).append((one, lane))
            elif pool in pooled:
                pooled[pool].append((one, lane))
            else:
                pooled[pool] = [(one, lane)]
        for pool, items in pooled.items():
            if len(items) > ITEMS:
                _put_together(items)
            self._take_parts(pool, _parts_of(items))
        for one in general:
            self._take_rare(one)
        for items in unready.values():
            self._take_unready(items)

    def _take_unready(self, items: _Items) -> None:
        """Take the packets of a session that is in no pool: the first the general way, the rest as it then stands.

        A session whose link was lost is in a pool again behind its first packet. Where very many have waited, taking
        all of them the general way would make the service fall further behind.
        """
        for number, (one, lane) in enumerate(items):
            pool = self._pool_of(lane) if number else None
            if pool is not None:
                parts = _parts_of(items[number:])
                for other, _, more in self._open:
                    if other is pool:
                        more += parts
                        return
                self._take_parts(pool, parts)
                return
            self._take_rare(one)

    @staticmethod
    def _pool_of(lane: Lane) -> SessionPool | None:
        try:
            return lane.pool if lane.is_ready else None
        except Exception as error:
            logger.exception("session %s has no place in a pool", lane.session.id)
            lane.session.line.stop(error)
            return None

    def _take_parts(self, pool: SessionPool, parts: list[_Items]) -> None:
        """Take parts one after the other; the pool's thread is asked where one is worth the asking."""
        while parts:
            items = self._still_in(pool, parts.pop(0))
            if not items:
                continue
            if pool.answers is not None and len(items) >= ASKED:
                try:
                    self._fill(pool, items)
                    self._watch_answers(pool)
                    pool.ask(1 - self._filling)
                except Exception as error:
                    self._forget_answers(pool)
                    self._failed(items, error)
                    continue
                self._open.append((pool, items, parts))
                return
            parts[:0] = self._take_part(pool, items)

    def _still_in(self, pool: SessionPool, items: _Items) -> _Items:
        """Return the packets of sessions that are estimated in a pool; others take the general way.

        A session that took the general way meanwhile is asked again: its row says where it stood before.
        """
        still: _Items = []
        places: dict[Lane, SessionPool | None] = {}
        for one, lane in items:
            if lane not in places:
                is_sure = lane.is_sure and lane.session.line.is_running
                places[lane] = lane.pool if is_sure else self._pool_of(lane)
            if places[lane] is pool:
                still.append((one, lane))
            else:
                lane.forget()
                self._take_rare(one)
        return still

    def _watch_answers(self, pool: SessionPool) -> None:
        answers = pool.answers
        if answers is not None and answers not in self._watched:
            asyncio.get_running_loop().add_reader(answers, self._end_answered)
            self._watched.add(answers)

    def _forget_answers(self, pool: SessionPool) -> None:
        answers = pool.answers
        if answers in self._watched:
            asyncio.get_running_loop().remove_reader(answers)
            self._watched.discard(answers)

    def _end_answered(self) -> None:
        """End a part whose thread is done; nobody waits for one that is not.

        Asked when a pipe can be read, and with every packet: where very many sockets are read it is long until the loop
        sees the pipe, and then the part may have ended and the thread may work on the next.
        """
        for part in self._open:
            if part[0].has_answered:
                try:
                    self._end(part)
                except Exception:
                    # Whoever may just have sent something has nothing to do with it.
                    logger.exception("a part of a turn could not be ended")
                return

    def _end(self, part: _Part) -> None:
        """Give what a thread has found to the sessions, then go on with what is left for the pool."""
        pool, items, more = part
        was_giving, self._is_giving = self._is_giving, True
        try:
            self._open.remove(part)
            try:
                pool.wait()
                more[:0] = self._show(pool, items)
            except Exception as error:
                # The pipe of a thread that has ended can be read at any time; one that goes on is watched when asked.
                self._forget_answers(pool)
                self._failed(items, error)
            self._take_parts(pool, more)
        finally:
            # Whatever happened, the next turn must begin.
            self._is_giving = was_giving
            self._close_turn()

    def _fill(self, pool: SessionPool, items: _Items) -> None:
        pool.fill(
            [lane.slot for _, lane in items],
            [one[OFFSET] for one, _ in items],
            [one[LENGTH] for one, _ in items],
        )

    def _take_part(self, pool: SessionPool, items: _Items) -> list[_Items]:
        """Take a part at once; see `_show`."""
        try:
            self._fill(pool, items)
            pool.take(1 - self._filling)
            return self._show(pool, items)
        except Exception as error:
            self._failed(items, error)
            return []

    def _failed(self, items: _Items, error: Exception) -> None:
        # Nothing was stored yet: the packets are, the general way, and nothing is estimated of them any more.
        logger.error("a turn of %d packets failed", len(items), exc_info=error)
        for one, lane in items:
            lane.session.line.stop(error)
            lane.forget()
            self._take_rare(one)

    def _show(self, pool: SessionPool, items: _Items) -> list[_Items]:
        """Show, store and count what was found of a part; return the part that is to be taken next, if any."""
        rows = pool.rows()
        watched = [
            number
            for number, ((_, lane), row) in enumerate(zip(items, rows, strict=True))
            if lane.blocks.listeners and row[TICKS] and row[STATUS] == ORDINARY
        ]
        if self.is_late:
            newest = {items[number][1]: number for number in watched}
            self.unshown += len(watched) - len(newest)
            watched = sorted(newest.values())
        if watched:
            blocks = pool.blocks(watched, time.time())
            for number, block in zip(watched, blocks, strict=True):
                items[number][1].blocks.publish(block)
        now_s, journal = time.monotonic(), self._journals[1 - self._filling].bytes
        taken = 0
        for ((_, at, length, _, arrival_s, arrival_ns), lane), row in zip(items, rows, strict=True):
            if row[STATUS] != ORDINARY:
                continue
            taken += 1
            try:
                lane.took(row, bytes(journal[at : at + length]), arrival_s, arrival_ns, now_s)
            except Exception as error:
                # One session's fault must not reach the others of its turn.
                logger.exception("a packet of session %s could not be taken", lane.session.id)
                lane.session.line.stop(error)
        for slot, (_, raised) in pool.kind.errors.items():
            next(lane for _, lane in items if lane.slot == slot).session.line.stop(raised)
        self.ordinary += taken
        metrics.packets += taken
        return self._take_others(pool, items, rows) if taken < len(items) else []

    def _take_others(self, pool: SessionPool, items: _Items, rows: list[tuple[Any, ...]]) -> list[_Items]:
        """Take the packets that compiled code left; return those that it takes now, as a part."""
        waiting: _Items = []
        tried: set[Lane] = set()
        for (one, lane), row in zip(items, rows, strict=True):
            if row[STATUS] == WAITS and lane not in tried:
                tried.add(lane)
                lane.tries += 1
            if row[STATUS] == RARE or (row[STATUS] == WAITS and lane.tries > TRIES):
                lane.forget()
                self._take_rare(one)
            elif row[STATUS] == WAITS:
                lane.is_sure = False
                waiting.append((one, lane))
        # After a pause many packets of a session come at once: the frames of the first are settled, or what is rare in
        # it is taken, then come the next.
        again = self._still_in(pool, waiting)
        return [again] if again else []

    def _take_rare(self, one: Received) -> None:
        self.rare += 1
        sender, at, length, _, arrival_s, arrival_ns = one
        try:
            sender.take_rare(
                bytes(self._journals[1 - self._filling].bytes[at : at + length]), arrival_s, arrival_ns
            )
        except Exception as error:
            lane: Lane | None = sender.lane
            logger.exception("a packet could not be taken")
            if lane is not None:
                lane.session.line.stop(error)


def _parts_of(items: _Items) -> list[_Items]:
    """Return packets as the parts that one call each takes."""
    return [items[start : start + ITEMS] for start in range(0, len(items), ITEMS)]


def _put_together(items: _Items) -> None:
    """Put the packets of a session one after the other, while the caches hold what they move on; the most come last.

    A gateway that brings much at once after a pause must not hold up those that bring what is new.
    """
    counts = Counter(lane for _, lane in items)
    first = {lane: number for number, lane in enumerate(counts)}
    items.sort(key=lambda item: (counts[item[1]], first[item[1]]))


def _has(part: _Part, lane: Lane) -> bool:
    """Whether packets of a lane are in a part, or wait behind it."""
    _, items, more = part
    return any(own is lane for _, own in items) or any(own is lane for later in more for _, own in later)
