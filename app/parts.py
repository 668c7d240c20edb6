"""Puts edges and workers together, of the same rooms as the service in one process; see `docs/scaling.md`."""

import asyncio
import contextlib
import logging
import os
import socket
from collections.abc import Callable, Mapping
from contextlib import AsyncExitStack
from functools import partial
from typing import Any, Final

import httpx
import nats
from anyio import to_thread
from fastapi import FastAPI
from sqlalchemy import Engine, make_url

from app.accounts.credentials.passwords import Passwords
from app.database.base import new_id
from app.database.writer_lock import RunnerLock, WriterLock
from app.edge.readiness import Check, Readiness, storing_checks
from app.edge.registry import Registry
from app.errors import TelemotionError
from app.live.bus import MemoryBus
from app.live.service import LiveService, SteeredLiveService
from app.live.warmup import Readiness as Warmth
from app.live.warmup import prepare_process
from app.main import create_app, job_handlers, open_foundation, prepare_processes
from app.observation import observe_part
from app.recordings.analysis.jobs import JobDone, JobRunner
from app.recordings.files_in_passing import remove_orphans
from app.scaled import fencing
from app.scaled.broker import Broker, connect, user_of
from app.scaled.edge.feed import FeedBus
from app.scaled.edge.forwarding import forwarding_router
from app.scaled.edge.service import EdgeLiveService
from app.scaled.fencing import holders
from app.scaled.mqtt.callout import callout_of
from app.scaled.mqtt.listener import open_listener
from app.scaled.wire import Answer, Request, partition_of, subject
from app.scaled.worker.sessions import OfWorker
from app.scaled.worker.worker import Worker
from app.services import Services
from app.settings import Settings
from app.viewer import open_viewer

logger = logging.getLogger("telemotion.service")

TASKS_TURN_S: Final = 1.0
LONGEST_UPLOAD_S: Final = 86400.0
"""An uploaded file that is older belongs to no upload that is still under way at some edge."""


def process_name(kind: str) -> str:
    """Return a name that no other process has; PostgreSQL retains 63 bytes of it."""
    return f"{kind}-{socket.gethostname()[:24]}-{os.getpid()}-{new_id()[:8]}"


# --- edge -----------------------------------------------------------------------------------------------------


def create_edge(settings: Settings, lock: WriterLock) -> FastAPI:
    """Make the application of an edge."""
    return create_app(settings, lock=lock, opening=open_edge, first_routers=[forwarding_router()])


async def open_edge(
    settings: Settings, stack: AsyncExitStack, lock: WriterLock, passwords: Passwords | None = None
) -> Services:
    """Open what an edge needs; see `app.main.open_services`."""
    services = await open_foundation(settings, stack, lock, passwords, is_one_of_many=True)
    name = process_name("edge")
    broker = services.add(await connect(settings, name, is_edge=True))
    stack.push_async_callback(broker.close)
    # Below its user's name nobody else may hear what workers send it.
    feed = services.add(
        FeedBus(broker, f"{user_of(settings)}.{name}", partial(holders, services.engine)), MemoryBus
    )
    await feed.start()
    stack.push_async_callback(feed.stop)
    prepare_processes()
    # Never started: workers look at the queue by themselves.
    services.add(JobRunner(services.engine, settings, job_handlers()))
    hours = settings.implant_confirmation_hours
    side = services.add(EdgeLiveService(services.engine, broker, feed, services.limits, hours), LiveService)
    stack.push_async_callback(side.stop)
    measured: dict[str, tuple[str, Callable[[], float]]] = {
        "gateways": ("Gateways connected.", lambda: side.session_count)
    }
    await open_viewer(services, stack)
    await _watch_readiness(services, stack, lock)
    if settings.mqtt:
        listener = open_listener(settings, broker, side)
        await listener.start()
        stack.push_async_callback(listener.stop)
        measured["mqtt_gateways"] = ("Of them by MQTT.", lambda: listener.count)
    services.add(observe_part(services, measured))
    return services


async def _watch_readiness(
    services: Services, stack: AsyncExitStack, lock: WriterLock, more: Mapping[str, Check] | None = None
) -> None:
    broker = services.get(Broker)
    checks = storing_checks(services.settings, services.engine, lock, broker)
    checks["broker"] = checks.pop("group_commit")
    checks |= more or {}
    readiness = services.add(Readiness(checks))
    await readiness.start()
    stack.push_async_callback(readiness.stop)


# --- worker ---------------------------------------------------------------------------------------------------


def create_worker(settings: Settings, lock: WriterLock, name: str) -> FastAPI:
    """Make the application of a worker, which answers what edges pass on."""
    app: FastAPI = create_app(settings, lock=lock, opening=_WorkerOpening(name, lambda: app))
    return app


def named(settings: Settings, name: str) -> Settings:
    """Return the settings with the name of the process on its connections to the database."""
    url = make_url(settings.database_url).update_query_dict({"application_name": name})
    return settings.model_copy(update={"database_url": url.render_as_string(hide_password=False)})


class _WorkerOpening:
    """Opens what a worker needs; see `app.main.open_services`."""

    def __init__(self, name: str, app: Any) -> None:
        self._name, self._app = name, app

    async def __call__(
        self, settings: Settings, stack: AsyncExitStack, lock: WriterLock, passwords: Passwords | None = None
    ) -> Services:
        services = await open_foundation(settings, stack, lock, passwords, is_one_of_many=True)
        fencing.install(services.engine)
        broker = services.add(await connect(settings, self._name))
        stack.push_async_callback(broker.close)
        prepare_processes()
        warmth = Warmth()
        await warmth.begin()
        stack.callback(warmth.end)
        # Whoever takes a dead worker's sessions must show them at once.
        await warmth.usual_ready()
        prepare_process()
        shared = OfWorker(settings=settings, limits=services.limits, readiness=warmth)
        stack.push_async_callback(partial(to_thread.run_sync, shared.check.close))
        measuring = asyncio.create_task(
            shared.admission.run(shared.pooled.take_longest_s), name="live admission"
        )
        stack.callback(measuring.cancel)
        worker = services.add(
            Worker(broker, services.engine, shared, self._name), LiveService, SteeredLiveService
        )
        services.add(worker.bus, MemoryBus)
        if settings.mqtt:
            callout = callout_of(settings, services.engine, broker)
            await callout.start()
            stack.push_async_callback(callout.stop)
        tasks = Tasks(services, broker)
        await tasks.start()
        stack.push_async_callback(tasks.stop)
        await worker.look_for_others()
        await _watch_readiness(services, stack, lock, {"sessions": worker.ahead.trouble})
        services.add(_observe_worker(services, worker, shared))
        transport = httpx.ASGITransport(app=self._app())
        # Edges ask as soon as a partition is held: by then everything is open.
        await worker.start(partial(answer, transport, settings.base_url))
        stack.push_async_callback(worker.stop)
        return services


async def answer(transport: httpx.ASGITransport, base_url: str, request: Request) -> Answer:
    """Answer a request that an edge passes on, as if it had come here."""
    transport.client = request.client
    async with httpx.AsyncClient(transport=transport, base_url=base_url, trust_env=False) as client:
        response = await client.request(
            request.method, request.target, headers=request.headers, content=request.body
        )
    return Answer(response.status_code, list(response.headers.raw), response.content)


def _observe_worker(services: Services, worker: Worker, shared: OfWorker) -> Registry:
    return observe_part(
        services,
        {
            "partitions_held": ("Partitions that this worker holds.", lambda: len(worker.partitions)),
            "live_sessions": ("Sessions live here.", lambda: worker.session_count),
            "stream_waiting": (
                "Messages of the streams that are not read yet.",
                lambda: sum(one.waiting for one in worker.partitions.values()),
            ),
            "late_packets": (
                "Packets that came out of the streams after their session was closed.",
                lambda: shared.late_packets,
            ),
            "refused_messages": (
                "Messages of the streams that are not from an edge of this service.",
                lambda: shared.refused_messages,
            ),
            "live_busy": (
                "Share of a processor that the thread of live sessions uses.",
                lambda: shared.admission.busy,
            ),
            "live_longest_turn_seconds": (
                "Longest turn since the start.",
                lambda: shared.pooled.longest_turn_s,
            ),
        },
    )


class Tasks:
    """Works off the queue of long tasks, which the workers share, while the database knows that this one lives."""

    def __init__(self, services: Services, broker: Broker) -> None:
        self._services, self._broker = services, broker
        self._lock = RunnerLock(services.settings.database_url, "telemotion tasks")
        self._runner: JobRunner | None = None
        self._loop = asyncio.get_running_loop()
        self._task: asyncio.Task[None] | None = None

    async def start(self) -> None:
        """Begin to work, as soon as the database knows this one."""
        # Whoever changes a session here wakes nobody: the queue is looked at twice a second.
        self._services.add(self._made())
        self._task = asyncio.create_task(self._run(), name="tasks")

    async def stop(self) -> None:
        """Let another worker go on."""
        if self._task is not None:
            self._task.cancel()
            await asyncio.gather(self._task, return_exceptions=True)
        if self._runner is not None:
            await to_thread.run_sync(self._runner.stop)
        await to_thread.run_sync(self._lock.release)

    def _made(self) -> JobRunner:
        return JobRunner(self._services.engine, self._services.settings, job_handlers(), self._lock)

    async def _run(self) -> None:
        while True:
            try:
                await self._turn()
            except Exception:
                logger.exception("the queue of tasks could not be looked at")
            await asyncio.sleep(TASKS_TURN_S)

    async def _turn(self) -> None:
        engine: Engine = self._services.engine
        if self._runner is None:
            await to_thread.run_sync(self._lock.take)
            await to_thread.run_sync(remove_orphans, engine, self._services.settings, LONGEST_UPLOAD_S)
            runner = self._made()
            runner.subscribe(self._done)
            await to_thread.run_sync(runner.start)
            self._runner = runner
            logger.info("long tasks are worked off here")
        elif await to_thread.run_sync(self._lock.trouble) is not None:
            runner, self._runner = self._runner, None
            await to_thread.run_sync(runner.stop)

    def _done(self, done: JobDone) -> None:
        self._loop.call_soon_threadsafe(self._tell, done.session_id)

    def _tell(self, session_id: str) -> None:
        async def publish() -> None:
            with contextlib.suppress(nats.errors.Error, TelemotionError):
                partition = partition_of(session_id, self._broker.partitions)
                await self._broker.client.publish(subject("done", partition), session_id.encode())

        self._published = asyncio.create_task(publish(), name="task done")
