"""PostgreSQL by TLS: the server of the tests is built without it, so this speaks TLS in front of its socket."""

import asyncio
import contextlib
import ssl
import struct
import threading
from collections.abc import Iterator
from contextlib import contextmanager

from sqlalchemy import URL, make_url

from tests.patience import PATIENCE_S
from tests.ports import free_port
from tests.scaled.tls.certificates import Authority

_REQUEST = struct.Struct("!II")
_TLS, _GSS = 80877103, 80877104


class _Front:
    def __init__(self, authority: Authority, path: str) -> None:
        self._path = path
        self._context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
        self._context.load_cert_chain(authority.certificate, authority.key)
        self.encrypted = self.refused = 0

    async def take(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        with contextlib.suppress(OSError, EOFError, asyncio.CancelledError):
            while True:
                length, code = _REQUEST.unpack(await reader.readexactly(_REQUEST.size))
                if (length, code) != (_REQUEST.size, _GSS):
                    break
                writer.write(b"N")
            if (length, code) == (_REQUEST.size, _TLS):
                writer.write(b"S")
                await writer.drain()
                await writer.start_tls(self._context)
                self.encrypted += 1
                await self._pass_on(reader, writer)
            else:
                self.refused += 1
        writer.close()

    async def _pass_on(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        inner_reader, inner_writer = await asyncio.open_unix_connection(self._path)
        ways = [
            asyncio.create_task(_copy(reader, inner_writer)),
            asyncio.create_task(_copy(inner_reader, writer)),
        ]
        await asyncio.wait(ways, return_when=asyncio.FIRST_COMPLETED)
        for one in ways:
            one.cancel()
        await asyncio.gather(*ways, return_exceptions=True)
        inner_writer.close()


async def _copy(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
    while data := await reader.read(1 << 16):
        writer.write(data)
        await writer.drain()


@contextmanager
def by_tls(url: str, authority: Authority) -> Iterator[tuple[str, _Front]]:
    """Give the address by TLS of a database whose server listens at a socket of this machine, and what came there.

    Parameters
    ----------
    url : str
        As `Database.make` returns it.
    authority : Authority
        Whose certificate is shown, and asked for in the address.
    """
    parsed: URL = make_url(url)
    front = _Front(authority, f"{parsed.query['host']}/.s.PGSQL.{parsed.query.get('port', 5432)}")
    port, loop, begun = free_port(), asyncio.new_event_loop(), threading.Event()

    async def serve() -> None:
        async with await asyncio.start_server(front.take, "127.0.0.1", port):
            begun.set()
            await ended.wait()
        others = asyncio.all_tasks() - {asyncio.current_task()}
        for one in others:
            one.cancel()
        await asyncio.gather(*others, return_exceptions=True)

    ended = asyncio.Event()
    thread = threading.Thread(target=loop.run_until_complete, args=(serve(),), daemon=True)
    thread.start()
    assert begun.wait(PATIENCE_S)
    try:
        query = {"sslmode": "verify-full", "sslrootcert": str(authority.ca)}
        yield (
            parsed.set(host="127.0.0.1", port=port, query=query).render_as_string(hide_password=False),
            front,
        )
    finally:
        loop.call_soon_threadsafe(ended.set)
        thread.join(10.0)
        loop.close()
