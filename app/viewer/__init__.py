"""The 3D view: a figure that moves in a viser scene, and the proxy that decides who may see it."""

from contextlib import AsyncExitStack

from app.live.bus import MemoryBus
from app.services import Services
from app.viewer.endpoints import router
from app.viewer.service import Viewer


async def open_viewer(services: Services, stack: AsyncExitStack) -> None:
    """Make the viewer in the lifespan of the application; the stack takes every scene down.

    Parameters
    ----------
    services : Services
        With engine and bus.
    """
    viewer = Viewer(services.engine, services.get(MemoryBus), services.limits)
    await viewer.start()
    stack.push_async_callback(viewer.close)
    services.add(viewer)


__all__ = ["Viewer", "open_viewer", "router"]
