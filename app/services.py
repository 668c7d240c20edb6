"""The parts of the running service; opened in the lifespan of `app.main`, found by requests here.

Rooms take what they need from `services_of(request)`, by its type; only what opens the service adds to it.
"""

from typing import TypeVar, cast

from sqlalchemy import Engine
from starlette.requests import HTTPConnection

from app.limits import Limits
from app.settings import Settings

One = TypeVar("One")


class Services:
    """Open resources of one running service, one of each type.

    Attributes
    ----------
    limits : Limits
        What accounts and clinics hold at this moment.
    """

    def __init__(self, settings: Settings, engine: Engine) -> None:
        self.settings = settings
        self.engine = engine
        self.limits = Limits(
            {
                "views": settings.limit_views,
                "streams": settings.limit_streams,
                "sockets": settings.limit_sockets,
                "uploads": settings.limit_uploads,
                "exports": settings.limit_exports,
            }
        )
        self._open: dict[type, object] = {}

    def add(self, one: One, *kinds: type) -> One:
        """Make a resource known by its type, and by others that it stands for; return it."""
        for kind in (type(one), *kinds):
            self._open[kind] = one
        return one

    def has(self, kind: type) -> bool:
        """Whether a resource of a type is open: an edge has no store of signals."""
        return kind in self._open

    def get(self, kind: type[One]) -> One:
        """Return the resource of a type.

        Raises
        ------
        LookupError
            It is not open: a mistake in the order in which the service is opened.
        """
        if kind not in self._open:
            raise LookupError(f"the service has no {kind.__name__} yet")
        return cast(One, self._open[kind])


def services_of(connection: HTTPConnection) -> Services:
    """Return the services behind a request or a WebSocket.

    Parameters
    ----------
    connection : Request or WebSocket
        Any connection of an application made by `app.main.create_app`.
    """
    services: Services = connection.app.state.services
    return services
