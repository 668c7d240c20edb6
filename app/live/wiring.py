"""Opening the live side in the lifespan of the application."""

from contextlib import AsyncExitStack

from app.live import repository
from app.live.bus import MemoryBus
from app.live.manager import LiveManager
from app.recordings import GroupCommitWriter
from app.services import Services


async def open_live(services: Services, stack: AsyncExitStack) -> None:
    """Start bus, writer and live sessions and put them into the services; the stack stops them in reverse.

    Parameters
    ----------
    services : Services
        With engine and, when closed sessions are to be analysed here, jobs.
    stack : AsyncExitStack
    """
    services.bus = MemoryBus()
    writer = GroupCommitWriter(services.engine)
    writer.start()
    stack.callback(writer.close)
    services.recorder = writer

    def analyse(session_id: str) -> None:
        repository.queue_analysis(services.engine, session_id)
        if services.jobs is not None:
            services.jobs.wake()

    live = LiveManager(services.engine, writer, services.bus, analyse)
    services.live = live
    if services.jobs is not None:
        services.jobs.subscribe(lambda done: live.task_done(done.session_id))
    await live.start()
    stack.push_async_callback(live.stop)
