"""The pipeline of one live session, fed in order.

A few ticks are estimated at once on the event loop: measured, that is cheaper than the way to a thread and
back. What takes longer (a filled gap, a calibration) runs in a thread, and what comes meanwhile waits in
order behind it.
"""

import asyncio
from collections import deque
from collections.abc import Callable

from estimators.pipelines import Frames, Pipeline
from estimators.recording import ImuChunk

INLINE_TICKS = 64
"""Chunks up to this length are estimated at once; longer ones in a thread, piece by piece."""
PIECE_TICKS = 200

After = Callable[[ImuChunk, Frames, float | None], None]


class EstimationLine:
    """Feeds a pipeline and hands its frames on, on the event loop's thread.

    Parameters
    ----------
    after : callable(chunk, frames, arrival_s)
        Takes the frames of each chunk, in order.
    failed : callable(error)
        Called once when the pipeline raises; nothing is estimated afterwards.
    """

    def __init__(self, pipeline: Pipeline, after: After, failed: Callable[[Exception], None]) -> None:
        self.pipeline = pipeline
        self.is_running = True
        self.waiting_ticks = 0
        self._after = after
        self._failed = failed
        self._waiting: deque[tuple[ImuChunk, float | None] | Callable[[], None]] = deque()
        self._worker: asyncio.Task[None] | None = None

    @property
    def is_idle(self) -> bool:
        """Whether the next ticks could be estimated at once."""
        return self.is_running and self._worker is None

    def push(self, chunk: ImuChunk, arrival_s: float | None) -> None:
        """Take the next ticks; `arrival_s` is None when their latency means nothing."""
        if not self.is_running:
            return
        if self._worker is None and chunk.tick_count <= INLINE_TICKS:
            try:
                frames = self.pipeline.step(chunk)
            except Exception as error:
                self.stop(error)
            else:
                self._after(chunk, frames, arrival_s)
            return
        self._waiting.append((chunk, arrival_s))
        self.waiting_ticks += chunk.tick_count
        self._start()

    def call(self, work: Callable[[], None]) -> None:
        """Run `work` in a thread between two steps, in order with the chunks."""
        self._waiting.append(work)
        self._start()

    def stop(self, error: Exception) -> None:
        """Estimate nothing more."""
        if self.is_running:
            self.is_running = False
            self._waiting.clear()
            self.waiting_ticks = 0
            self._failed(error)

    async def drained(self) -> None:
        """Wait until nothing waits any more."""
        while self._worker is not None:
            await asyncio.shield(self._worker)

    def _start(self) -> None:
        if self._worker is None and self.is_running:
            self._worker = asyncio.create_task(self._work(), name="estimation backlog")

    async def _work(self) -> None:
        try:
            while self._waiting and self.is_running:
                item = self._waiting.popleft()
                if callable(item):
                    await asyncio.to_thread(item)
                else:
                    await self._step_through(*item)
        except Exception as error:
            self.stop(error)
        finally:
            self._worker = None

    async def _step_through(self, chunk: ImuChunk, arrival_s: float | None) -> None:
        for start in range(0, chunk.tick_count, PIECE_TICKS):
            piece = chunk.ticks(start, min(start + PIECE_TICKS, chunk.tick_count))
            frames = await asyncio.to_thread(self.pipeline.step, piece)
            self._after(piece, frames, arrival_s)
        self.waiting_ticks -= chunk.tick_count
