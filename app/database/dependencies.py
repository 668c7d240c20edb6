"""FastAPI dependencies: a reading or a writing session for one request.

`scope="function"` ends the transaction when the endpoint function returns, before the response is sent: a
commit that fails becomes an error response and never a success that was not stored. Endpoints must therefore
return finished data, not lazy queries.
"""

from collections.abc import Iterator
from typing import Annotated

from fastapi import Depends
from starlette.requests import HTTPConnection

from app.database.unit_of_work import ReadOnlySession, WritableSession, read_only, unit_of_work
from app.services import services_of


def read_session(connection: HTTPConnection) -> Iterator[ReadOnlySession]:
    """Give a reading session for this request."""
    with read_only(services_of(connection).engine) as session:
        yield session


def write_session(connection: HTTPConnection) -> Iterator[WritableSession]:
    """Give a writing session for this request; it commits when the endpoint returns without an error."""
    with unit_of_work(services_of(connection).engine) as session:
        yield session


ReadSession = Annotated[ReadOnlySession, Depends(read_session, scope="function")]
WriteSession = Annotated[WritableSession, Depends(write_session, scope="function")]
