"""Which numbers of which rooms `/metrics` shows; one line each, in one place.

Opened last in the lifespan, when every room stands.
"""

import asyncio
import contextlib
from collections import Counter
from collections.abc import Callable, Mapping
from contextlib import AsyncExitStack
from typing import Any, Final

from sqlalchemy import func, select

from app.accounts.refusals import RefusedSignIns
from app.database.unit_of_work import read_only
from app.edge.access_log import served
from app.edge.readiness import Readiness
from app.edge.registry import Histogram, Registry
from app.ingest.websocket import metrics as ingest
from app.live.bus import MemoryBus
from app.live.engine.turns import PooledEngine
from app.live.manager import LiveManager
from app.live.session.states import STREAMING
from app.recordings.analysis.jobs import JobDone, JobRunner
from app.recordings.models import Job
from app.recordings.signals.group_commit import GroupCommitWriter
from app.services import Services
from app.viewer.service import Viewer

LATENCY_BOUNDS_S: Final = (0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0)
LAG_BOUNDS_S: Final = (0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0)
_TURN_S: Final = 0.25

_WRITER: Final = {
    "packets_stored": "Packets that became durable.",
    "packets_duplicate": "Packets that were here before.",
    "packets_refused": "Packets refused because the store was behind; gateways send them again.",
    "frame_ticks_stored": "Ticks of live frames that became durable.",
    "frame_ticks_refused": "Ticks of live frames not stored because the store was behind.",
    "chunks_written": "Chunks of signals written.",
    "bytes_written": "Bytes of chunks written.",
    "commits": "Group commits.",
    "commit_failures": "Group commits that failed and were tried session by session.",
    "sessions_failed": "Sessions whose rows could not be written.",
}
_INGEST: Final = {
    "connections": "Connections of gateways accepted.",
    "packets": "Packets received from gateways.",
    "duplicates": "Of them, packets that were here before.",
    "errors": "Messages of gateways that were refused.",
}
_BUS: Final = {
    "published": "Messages published to views.",
    "delivered": "Messages put into the queue of a view.",
    "dropped": "Messages that a slow view lost.",
}


def _observe_turns(registry: Registry, pooled: PooledEngine) -> None:
    """Register what the pooled engine counts."""
    registry.counter(
        "live_packets_total",
        "Packets taken many at a time, and those that took the general way.",
        lambda: _by("way", Counter(pooled=pooled.ordinary, general=pooled.rare)),
    )
    registry.counter("live_turns_total", "Turns in which packets were taken.", lambda: pooled.turns)
    registry.gauge(
        "live_longest_turn_seconds", "Longest turn since the start.", lambda: pooled.longest_turn_s
    )
    registry.counter(
        "live_unshown_total",
        "Blocks that views went without because turns were late.",
        lambda: pooled.unshown,
    )


async def observe(services: Services, stack: AsyncExitStack) -> Registry:
    """Return the metrics of the running service.

    Parameters
    ----------
    services : Services
        Everything open.
    stack : AsyncExitStack
        Ends the watch over the event loop.
    """
    registry = Registry()
    _counters(registry, "ingest", _INGEST, ingest)
    _counters(registry, "store", _WRITER, services.get(GroupCommitWriter).metrics)
    _counters(registry, "bus", _BUS, services.get(MemoryBus).metrics)
    store = services.get(GroupCommitWriter).metrics
    registry.gauge("store_queued_bytes", "Bytes that wait for their commit.", lambda: store.queued_bytes)
    registry.gauge(
        "store_last_commit_seconds", "How long the last group commit took.", lambda: store.last_commit_s
    )
    registry.gauge(
        "live_sessions",
        "Sessions live here, by whether their gateway streams.",
        lambda: _by(
            "streaming",
            Counter(str(one.state in STREAMING).lower() for one in services.get(LiveManager).sessions),
        ),
    )
    admission = services.get(LiveManager).admission
    registry.gauge(
        "live_busy", "Share of a processor that the thread of live sessions uses.", lambda: admission.busy
    )
    registry.counter(
        "live_refused_total", "Times a gateway was sent away from a full machine.", lambda: admission.refused
    )
    _observe_turns(registry, services.get(LiveManager).pooled)
    registry.gauge("views", "3D scenes that stand.", lambda: services.get(Viewer).stage_count)
    registry.counter(
        "sign_ins_refused_total", "Sign-ins refused.", lambda: services.get(RefusedSignIns).refused
    )
    registry.gauge("tasks", "Long tasks waiting and running.", lambda: _tasks(services))
    ended: Counter[str] = Counter()
    services.get(JobRunner).subscribe(lambda done: _count(ended, done))
    registry.counter("tasks_ended_total", "Long tasks ended, by outcome.", lambda: _by("status", ended))
    _observe_serving(registry, services)
    latency, lag = Histogram(LATENCY_BOUNDS_S), Histogram(LAG_BOUNDS_S)
    registry.histogram("live_latency_seconds", "Packet arrival to published frame.", latency)
    registry.histogram("event_loop_lag_seconds", "By how much the event loop wakes too late.", lag)
    task = asyncio.create_task(_watch(services.get(LiveManager), latency, lag), name="observation")
    stack.push_async_callback(_end, task)
    return registry


def observe_part(services: Services, gauges: Mapping[str, tuple[str, Callable[[], float]]]) -> Registry:
    """Return the metrics of an edge or a worker.

    Parameters
    ----------
    gauges : mapping of str to (meaning, callable)
        Its own, by name.
    """
    registry = Registry()
    _counters(registry, "ingest", _INGEST, ingest)
    for name, (meaning, value) in gauges.items():
        registry.gauge(name, meaning, value)
    _observe_serving(registry, services)
    return registry


def _observe_serving(registry: Registry, services: Services) -> None:
    """Register what every process that answers requests counts."""
    registry.counter(
        "http_requests_total", "Requests answered, by status.", lambda: _by("status", served.by_status)
    )
    registry.histogram("http_request_seconds", "Time to the end of an answer.", served.seconds)
    registry.gauge(
        "ready", "1 when what is sent now can be stored.", lambda: float(not services.get(Readiness).reasons)
    )


def _counters(registry: Registry, room: str, meanings: dict[str, str], counted: Any) -> None:
    for name, meaning in meanings.items():
        registry.counter(f"{room}_{name}_total", meaning, lambda name=name: getattr(counted, name))  # type: ignore[misc]


def _by(label: str, counted: Counter[str]) -> dict[tuple[tuple[str, str], ...], float]:
    return {((label, name),): count for name, count in dict(counted).items()}


def _count(ended: Counter[str], done: JobDone) -> None:
    ended[done.status] += 1


def _tasks(services: Services) -> dict[tuple[tuple[str, str], ...], float]:
    waiting = ("queued", "running")
    with read_only(services.engine) as session:
        rows = session.execute(
            select(Job.status, func.count()).where(Job.status.in_(waiting)).group_by(Job.status)
        ).all()
    found = Counter({row[0]: row[1] for row in rows})
    return {(("status", status),): found[status] for status in waiting}


async def _watch(live: Any, latency: Histogram, lag: Histogram) -> None:
    """Take what live sessions and their thread measured since the last turn."""
    while True:
        await asyncio.sleep(_TURN_S)
        for value in live.admission.take_lags():
            lag.observe(value)
        for session in live.sessions:
            for value in session.now.health.take_latencies():
                latency.observe(value)


async def _end(task: "asyncio.Task[None]") -> None:
    task.cancel()
    with contextlib.suppress(asyncio.CancelledError):
        await task
