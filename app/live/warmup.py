"""Compilation before a session needs it, so that its first packet does not wait.

A kind of session is warmed up by letting its pipeline run over moments of stillness: `Readiness` does that in threads
when the service starts, and when somebody opens a session of another kind. What is in no cache yet is compiled by
other processes (this module as a script), because compiling holds the interpreter: live frames would stand still.
What takes the packets of many sessions together is compiled beside that: sessions that come before it is there take
the general way, and change over by themselves.
"""

import asyncio
import gc
import logging
import os
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from typing import Final, cast

from app.errors import Unavailable
from app.live.engine.block_kernel import write_blocks
from app.live.engine.journal import unmask
from app.live.engine.step_thread import take_arms
from app.network.placing.kernel import place
from app.network.unpack_kernel import unpack
from app.recordings.analysis.kinds import kinds
from app.recordings.signals.frame_kernel import pack_frames, unpack_frames
from estimators import pipelines
from estimators.compiling import Kernel, NotCompiled, only_cached
from estimators.guidance.live import GuidanceRunner
from estimators.orientation import DEFAULT
from estimators.pipelines import ArmPipeline, SessionSetup
from estimators.pipelines.arm.pool import APART, CALLED
from estimators.sentences import say

logger = logging.getLogger(__name__)

SWITCH_INTERVAL_S: Final = 5e-4
PATIENCE_S: Final = 2.0
"""Loading from the cache takes less: whoever opens a session waits so long before being sent away for a while."""
COMING_BACK_S: Final = 15.0
"""Where a stop left sessions open, their gateways come back about within this, once arms can be estimated."""
PREPARING: Final = say("live.preparing")
NICENESS: Final = 5
LOOK_S: Final = 1.0
"""How often a process that compiles looks whether the service still runs."""
Kind = tuple[str, str]
"""Pipeline and orientation estimator: what decides which code runs."""
FIRST: Final[Kind] = (ArmPipeline.name, DEFAULT)
GUIDANCE: Final[Kind] = ("guidance", DEFAULT)
"""What a session needs besides where a prescription guides it: compiled apart, half a minute of it is nobody else's."""
ENGINE: Final[Kind] = ("engine", DEFAULT)
"""What takes the packets of many sessions together; until it is there they take the general way."""


def usual() -> list[Kind]:
    """Return what is made ready at the start: arms, engine, guidance, then the kinds with a filter of their own."""
    own = [name for name, kind in pipelines.available().items() if not kind.takes_estimator]
    return [FIRST, ENGINE, GUIDANCE, *((name, DEFAULT) for name in own)]


def code_of(setup: SessionSetup) -> Kind:
    """Return the kind of session that a setup asks for."""
    asks = pipelines.available()[setup.pipeline].takes_estimator
    return setup.pipeline, setup.orientation if asks else DEFAULT


def warm_up(kind: Kind) -> None:
    """Run the pipeline of a kind of session over moments of stillness, in a thread of the caller.

    A body is calibrated on the way; shoes stand; a magnetic source goes from its standstill through its first burst.
    """
    if kind == GUIDANCE:
        GuidanceRunner.prepare()
        return
    # The general way needs them, too.
    of_packets = (unmask, unpack)
    if kind == ENGINE:
        # Half of what an arm needs comes first; whoever warms up an arm meanwhile begins with the other half.
        _prepare(*APART, pack_frames, unpack_frames, take_arms, place, write_blocks, *of_packets, *CALLED)
        return
    _prepare(*of_packets)
    if kind == FIRST:
        _prepare(*CALLED[:0:-1])
    pipeline, orientation = kind
    kinds()[pipeline].warm_up(orientation)


def _prepare(*kernels: Callable[..., object]) -> None:
    for kernel in kernels:
        cast(Kernel, kernel).prepare()


def load_or_compile(kind: Kind) -> None:
    """Warm up from the cache; where something is not in it, let another process compile that first."""
    try:
        with only_cached():
            warm_up(kind)
        return
    except NotCompiled:
        logger.info("compiling for sessions of kind %s", "/".join(kind))
    if _compile(*kind).wait():
        logger.warning("compiling for sessions of kind %s failed; it is done in this process", "/".join(kind))
    warm_up(kind)


def _compile(*words: str) -> "subprocess.Popen[bytes]":
    """Start the process that compiles a kind; what two of them need one of them compiles.

    It ends with the service, also when that is killed: the next start does not compile beside it.
    """
    return subprocess.Popen([sys.executable, "-m", __name__, *words], stdin=subprocess.DEVNULL)  # noqa: S603


class Readiness:
    """Which kinds of session can be opened at once; warms up the usual ones, and others when they are asked for.

    Parameters
    ----------
    prepare : callable(kind), optional
        Blocking; run in a thread, once for each kind. By default `load_or_compile`.
    """

    def __init__(self, prepare: Callable[[Kind], None] | None = None) -> None:
        self._prepare = prepare or load_or_compile
        self._kinds: dict[Kind, asyncio.Task[None]] = {}
        self._others: asyncio.Task[None] | None = None
        self._engine_by_s = 0.0
        """When a session waits no longer for the engine, on the event loop's clock."""

    async def begin(self, others_after_s: float = 0.0) -> None:
        """Begin with the usual kinds; returns when the first is ready, or after a moment.

        Parameters
        ----------
        others_after_s : float
            The others wait so long, where whoever comes meanwhile needs the processor more: who asks for one of them
            has it prepared at once.
        """
        first = self._of(FIRST)
        self._of(ENGINE)
        self._engine_by_s = asyncio.get_running_loop().time() + PATIENCE_S
        self._others = asyncio.create_task(self._one_by_one(others_after_s), name="warm up")
        await asyncio.wait([first], timeout=PATIENCE_S)

    async def usual_ready(self) -> None:
        """Return when sessions of the usual kinds can be opened at once."""
        if self._others is not None:
            await asyncio.wait([self._others])

    def end(self) -> None:
        """Wait for nothing any more."""
        for task in (self._others, *self._kinds.values()):
            if task is not None:
                task.cancel()

    async def require(self, setup: SessionSetup) -> None:
        """Return when a session with this setup can be estimated.

        Raises
        ------
        Unavailable
            That takes longer than a moment; it goes on meanwhile.
        """
        await self._require(code_of(setup))
        left_s = self._engine_by_s - asyncio.get_running_loop().time()
        if self.is_preparing_engine and left_s > 0.0:
            # Nearly always there before the pipeline is; where it must be compiled nobody waits for it.
            await asyncio.wait([self._of(ENGINE)], timeout=left_s)

    async def require_guidance(self) -> None:
        """Return when a session can be guided; raises as `require`."""
        await self._require(GUIDANCE)

    async def _require(self, kind: Kind) -> None:
        done, _ = await asyncio.wait([self._of(kind)], timeout=PATIENCE_S)
        if not done:
            raise Unavailable(PREPARING, retry_after_s=2, reason="preparing")

    def is_ready(self, setup: SessionSetup) -> bool:
        """Say whether a session with this setup can be opened at once, as far as is known."""
        return self._is_ready(code_of(setup))

    @property
    def is_guiding(self) -> bool:
        """Whether sessions can be guided at once, as far as is known."""
        return self._is_ready(GUIDANCE)

    @property
    def is_preparing_engine(self) -> bool:
        """Whether packets had better not be taken together yet: it would be compiled in the middle of that."""
        task = self._kinds.get(ENGINE)
        return task is not None and (not task.done() or task.cancelled())

    def _is_ready(self, kind: Kind) -> bool:
        task = self._kinds.get(kind)
        return task is not None and task.done()

    async def _one_by_one(self, others_after_s: float) -> None:
        await asyncio.wait([self._of(FIRST), self._of(ENGINE)])
        await asyncio.sleep(others_after_s)
        for kind in usual():
            await asyncio.wait([self._of(kind)])

    def _of(self, kind: Kind) -> asyncio.Task[None]:
        if kind not in self._kinds:
            self._kinds[kind] = asyncio.create_task(self._warm(kind), name="warm up " + "/".join(kind))
        return self._kinds[kind]

    async def _warm(self, kind: Kind) -> None:
        try:
            await asyncio.to_thread(self._prepare, kind)
        except Exception:
            # A session of this kind says for itself what is wrong, as it would have without us.
            logger.exception("sessions of kind %s could not be prepared", "/".join(kind))


def prepare_process() -> None:
    """Set garbage collection and thread switching of this process for the live path.

    What was loaded at the start lives as long as the process: frozen, the collector does not walk it again.
    What live sessions make dies by reference counting; rarer collections of the rest are enough. Measured with
    50 sessions: the collector took half of the event loop's time, in pauses of a hundred milliseconds.

    Estimation releases the interpreter lock many times a packet. Each time a thread that encodes chunks may
    keep it for one switch interval; with the default of 5 ms that held the event loop up by tens of
    milliseconds.
    """
    gc.collect()
    gc.freeze()
    gc.set_threshold(20_000, 50, 1_000)
    sys.setswitchinterval(SWITCH_INTERVAL_S)


def _end_with_parent() -> None:
    """End this process when whoever started it has ended."""
    parent = os.getppid()

    def leave() -> None:
        while os.getppid() == parent:
            time.sleep(LOOK_S)
        os._exit(1)

    threading.Thread(target=leave, name="end-with-parent", daemon=True).start()


if __name__ == "__main__":
    os.nice(NICENESS)
    _end_with_parent()
    warm_up((sys.argv[1], sys.argv[2]))
