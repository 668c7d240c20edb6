"""`telemotion serve`: the service in one process."""

import uvicorn

from app.settings import Settings


def serve(host: str, port: int, settings: Settings | None = None) -> None:
    """Bring the database to the newest schema, then serve until told to stop.

    Parameters
    ----------
    host : str
        Address to listen on.
    port : int
    settings : Settings, optional
        By default from the environment; unsafe ones refuse here.

    Notes
    -----
    One process: a live session's estimator state lives in it. Per-message deflate is off because packets are
    binary and small, and access lines are the service's own (no query strings, no patient data).
    """
    from app.database import migrate
    from app.main import create_app

    settings = settings or Settings()
    migrate.upgrade(settings.database_url)
    uvicorn.run(
        create_app(settings),
        host=host,
        port=port,
        ws="websockets-sansio",
        loop="uvloop",
        http="httptools",
        ws_per_message_deflate=False,
        ws_max_size=1 << 20,
        access_log=False,
        log_level=settings.log_level,
        timeout_graceful_shutdown=10,
        server_header=False,
    )
