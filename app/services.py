"""What the running service is made of; opened in the lifespan of `app.main`, found by requests here.

Rooms take what they need from `services_of(request)`; only `app.main` fills it.
"""

from dataclasses import dataclass, field
from typing import Any

from sqlalchemy import Engine
from starlette.requests import HTTPConnection

from app.limits import Limits
from app.settings import Settings


@dataclass
class Services:
    """Open resources of one running service.

    Attributes
    ----------
    settings : Settings
    engine : Engine
    limits : Limits
        What accounts and clinics hold at this moment.
    bus : app.live bus
        Publishes frames, states, health and events to views.
    recorder : app.recordings store
        Group commit of raw packets and frames.
    live : app.live runner
        Live sessions of this process.
    disk : app.recordings.disk.DiskUse
        Signals stored by clinic.
    jobs : app.recordings jobs
        Long uploads, reprocessing and comparisons.
    viewer : app.viewer
        3D views.
    sign_in_limits : app.accounts.rate_limit.SignInLimits
    refused_sign_ins : app.accounts.refusals.RefusedSignIns
    passwords : app.accounts.passwords.Passwords
    metrics : app.metrics.Registry
    readiness : app.edge.readiness.Readiness
        Whether what is sent now can be stored.
    pairing : app.accounts.pairing.PairingBook
        Codes that wait for their gateways.
    """

    settings: Settings
    engine: Engine
    bus: Any = None
    recorder: Any = None
    live: Any = None
    disk: Any = None
    jobs: Any = None
    viewer: Any = None
    sign_in_limits: Any = None
    refused_sign_ins: Any = None
    passwords: Any = None
    metrics: Any = None
    readiness: Any = None
    pairing: Any = None
    limits: Limits = field(init=False)
    extras: dict[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        settings = self.settings
        self.limits = Limits(
            {
                "views": settings.limit_views,
                "streams": settings.limit_streams,
                "sockets": settings.limit_sockets,
                "uploads": settings.limit_uploads,
                "exports": settings.limit_exports,
            }
        )


def services_of(connection: HTTPConnection) -> Services:
    """Return the services behind a request or a WebSocket.

    Parameters
    ----------
    connection : Request or WebSocket
        Any connection of an application made by `app.main.create_app`.
    """
    services: Services = connection.app.state.services
    return services
