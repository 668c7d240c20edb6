"""Puts the service together: resources, routes, limits and the client. Nothing imports this module but the
command line.
"""

import logging
from collections.abc import AsyncIterator, Sequence
from contextlib import AsyncExitStack, asynccontextmanager
from functools import partial
from typing import Protocol

from anyio import to_thread
from fastapi import APIRouter, FastAPI
from sqlalchemy import Engine

from app import processes
from app import tables as tables
from app.accounts.audit_reading import note_ended
from app.accounts.credentials.passwords import Passwords
from app.accounts.credentials.rate_limit import Counting, LeakyCounter, SignInLimits
from app.accounts.credentials.stored_limit import StoredCounter
from app.accounts.endpoints import router as accounts_router
from app.accounts.pairing import PairingBook
from app.accounts.refusals import RefusedSignIns
from app.accuracy import router as accuracy_router
from app.assessment.comparisons import compare_task
from app.assessment.course.endpoints import router as course_router
from app.assessment.design.endpoints import router as design_router
from app.assessment.endpoints import router as assessment_router
from app.assessment.patient_endpoints import router as follow_up_router
from app.assessment.records import ended_again
from app.assessment.records.endpoints import router as records_router
from app.assessment.worries.endpoints import router as worries_router
from app.database import ended
from app.database import engine as database_engine
from app.database.migrate import require_newest
from app.database.unit_of_work import unit_of_work
from app.database.writer_lock import WriterLock, writer_lock
from app.edge import error_answers
from app.edge.access_log import AccessLog
from app.edge.client import client_router
from app.edge.demonstration import router as demonstration_router
from app.edge.documentation import router as documentation_router
from app.edge.health import router as health_router
from app.edge.hosts import KnownHosts
from app.edge.metrics import router as metrics_router
from app.edge.middleware import BodyLimit, SecurityHeaders, UnexpectedErrors, WholeAddresses
from app.edge.readiness import Readiness, storing_checks
from app.edge.readiness import router as readiness_router
from app.edge.slow_senders import TimedBodies
from app.exercises.endpoints import router as exercises_router
from app.ingest.marker_task import fuse
from app.ingest.markers import FILE_LIMIT_BYTES as MARKER_LIMIT_BYTES
from app.ingest.markers import router as markers_router
from app.ingest.preview import router as preview_router
from app.ingest.upload import MULTIPART_SLACK_BYTES
from app.ingest.upload import router as upload_router
from app.ingest.upload_task import upload
from app.live.bus import MemoryBus
from app.live.endpoints import router as live_router
from app.live.ingest_socket import router as ingest_router
from app.live.manager import LiveManager
from app.live.replay import router as replay_router
from app.live.service import LiveService, SteeredLiveService
from app.live.session.opening import Place
from app.live.watch_socket import router as watch_router
from app.live.wrong_tickets import WrongTickets
from app.observation import observe
from app.patients.endpoints import router as patients_router
from app.recordings.analysis.jobs import Handler, JobRunner
from app.recordings.analysis.kinds import kind_routers, kinds
from app.recordings.analysis.reprocess import reprocess
from app.recordings.answers.endpoints import router as answers_router
from app.recordings.endpoints import router as sessions_router
from app.recordings.files_in_passing import remove_orphans
from app.recordings.series_endpoints import router as series_router
from app.recordings.service import queue_closing
from app.recordings.signals.disk import DiskUse
from app.recordings.signals.group_commit import GroupCommitWriter
from app.services import Services
from app.settings import Settings
from app.version import service_version
from app.viewer import open_viewer
from app.viewer import router as viewer_router

logger = logging.getLogger("telemotion.service")


class Opening(Protocol):
    """Opens the resources of a process, as `open_services` does."""

    async def __call__(
        self, settings: Settings, stack: AsyncExitStack, lock: WriterLock, passwords: Passwords | None = None
    ) -> Services:
        """Return what is open."""


def create_app(
    settings: Settings | None = None,
    *,
    passwords: Passwords | None = None,
    lock: WriterLock | None = None,
    opening: Opening | None = None,
    first_routers: Sequence[APIRouter] = (),
) -> FastAPI:
    """Make the application; nothing is opened before its lifespan starts.

    Parameters
    ----------
    settings : Settings, optional
        Read from the environment when absent; unsafe ones raise here.
    passwords : Passwords, optional
        Another cost of password hashing.
    lock : WriterLock, optional
        Of the database; taken in the lifespan when it is not held yet.
    opening : Opening
        By default `open_services`: everything in this process.
    first_routers : sequence of APIRouter
        Matched before those of the rooms.
    """
    opened = opening or open_services
    settings = settings or Settings()
    lock = lock or writer_lock(settings.database_url, "telemotion service", settings.base_url)

    @asynccontextmanager
    async def lifespan(app: FastAPI) -> AsyncIterator[None]:
        async with AsyncExitStack() as stack:
            app.state.services = await opened(settings, stack, lock, passwords)
            logger.info("service %s is open at %s", service_version(), settings.base_url)
            yield
        logger.info("service is closed")

    app = FastAPI(
        title="Telemotion",
        version=service_version(),
        description="Body-worn sensors in; motion and comparison with the therapist's template out.",
        lifespan=lifespan,
        openapi_url=None,
        docs_url=None,
        redoc_url=None,
    )
    error_answers.register(app)
    app.add_middleware(
        BodyLimit,
        default_bytes=settings.request_limit_bytes,
        by_path={
            "/api/uploads": settings.upload_limit_bytes + MULTIPART_SLACK_BYTES,
            "/api/sessions/*/markers": MARKER_LIMIT_BYTES + MULTIPART_SLACK_BYTES,
        },
    )
    app.add_middleware(
        TimedBodies,
        floor_bytes_per_s=settings.request_floor_bytes_per_s,
        patience_s=settings.request_patience_seconds,
    )
    app.add_middleware(WholeAddresses)
    app.add_middleware(UnexpectedErrors)
    app.add_middleware(KnownHosts, settings=settings)
    app.add_middleware(SecurityHeaders, settings=settings)
    app.add_middleware(AccessLog)
    for router in (*first_routers, *all_routers()):
        app.include_router(router)
    app.include_router(client_router(settings))
    return app


async def open_services(
    settings: Settings, stack: AsyncExitStack, lock: WriterLock, passwords: Passwords | None = None
) -> Services:
    """Open every resource in order; the stack closes them in reverse.

    Parameters
    ----------
    stack : AsyncExitStack
        Closed by the caller when the service stops.
    lock : WriterLock
        Held from before anything is read until everything is closed.

    Raises
    ------
    Conflict
        The database has not been migrated to this version, or another process holds it.
    """
    services = await open_foundation(settings, stack, lock, passwords)
    engine = services.engine
    bus = services.add(MemoryBus())
    writer = GroupCommitWriter(engine)
    writer.start()
    stack.push_async_callback(partial(to_thread.run_sync, writer.close))
    services.add(writer)

    await to_thread.run_sync(remove_orphans, engine, settings)
    prepare_processes()
    jobs = JobRunner(engine, settings, job_handlers())
    await to_thread.run_sync(jobs.start)
    stack.push_async_callback(partial(to_thread.run_sync, jobs.stop))
    services.add(jobs)

    def analyse(session_id: str) -> None:
        with unit_of_work(engine) as session:
            queue_closing(session, session_id)
        jobs.wake()

    live = LiveManager(
        engine,
        writer,
        bus,
        on_closed=analyse,
        limits=services.limits,
        longest_s=settings.session_limit_hours * 3600.0,
        place=Place(settings.hemisphere, settings.time_zone),
        confirmation_hours=settings.implant_confirmation_hours,
    )
    await live.start()
    stack.push_async_callback(live.stop)
    services.add(live, LiveService, SteeredLiveService)
    jobs.subscribe(lambda done: live.task_done(done.session_id))

    await open_viewer(services, stack)
    readiness = services.add(Readiness(storing_checks(settings, engine, lock, writer)))
    await readiness.start()
    stack.push_async_callback(readiness.stop)
    services.add(await observe(services, stack))
    return services


async def open_foundation(
    settings: Settings,
    stack: AsyncExitStack,
    lock: WriterLock,
    passwords: Passwords | None = None,
    *,
    is_one_of_many: bool = False,
) -> Services:
    """Open what every process that serves requests needs: the database, and who may sign in; see `open_services`.

    One of many processes counts what failed in the database, with the others.
    """
    await to_thread.run_sync(lock.take)
    stack.callback(lock.release)
    engine = database_engine.create(settings)
    stack.callback(engine.dispose)
    await to_thread.run_sync(require_newest, engine)
    await to_thread.run_sync(_keep_ended, engine, settings)
    services = Services(settings=settings, engine=engine)
    services.add(await to_thread.run_sync(Passwords) if passwords is None else passwords)
    counting: Counting = LeakyCounter
    if is_one_of_many:
        counting = partial(StoredCounter, engine=engine, settings=settings)
    services.add(SignInLimits(counting=counting))
    services.add(PairingBook(settings, counting=counting))
    services.add(WrongTickets())
    refused = services.add(RefusedSignIns(engine, settings))
    stack.push_async_callback(partial(to_thread.run_sync, refused.close))
    services.add(DiskUse(engine, settings))
    return services


def _keep_ended(engine: Engine, settings: Settings) -> None:
    """Bring the register of what was ended for good up to the database, and the database up to the register."""
    register = ended.path_of(settings)
    note_ended(engine, register)
    if said := ended_again.in_words(ended_again.apply(engine, settings, ended.read(register))):
        logger.warning("this database is older than the register of erasures and revocations: %s", said)


def prepare_processes() -> None:
    """Let the process that children are forked from import what they will run."""
    tasks = [handler.__module__ for handler in job_handlers().values()]
    own = [type(kind).__module__ for kind in kinds().values()]
    processes.prepare(["app.assessment.exports.patient", *tasks, *own])


def job_handlers() -> dict[str, Handler]:
    """Return what can be done in the background, by kind of task."""
    return {"reprocess": reprocess, "upload": upload, "compare": compare_task, "markers": fuse}


def all_routers() -> list[APIRouter]:
    """Return the routers of every room, in the order in which paths are matched."""
    return [
        health_router,
        readiness_router,
        metrics_router,
        documentation_router,
        accounts_router,
        patients_router,
        exercises_router,
        sessions_router,
        answers_router,
        series_router,
        *kind_routers(),
        replay_router,
        live_router,
        watch_router,
        ingest_router,
        upload_router,
        preview_router,
        markers_router,
        assessment_router,
        design_router,
        course_router,
        records_router,
        worries_router,
        follow_up_router,
        accuracy_router,
        demonstration_router,
        viewer_router,
    ]
