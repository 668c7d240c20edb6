"""The one handler that turns errors into answers: JSON `{"code", "message", "details", "sentences", "request_id"}`
with the status of the error tree. `sentences` has code and parameters of the message for who says it in another
language; the request's identifier finds the lines that the log has on it.

What a client sent never comes back in an answer (it may be a password or a name); only where in the input the
problem is. Unexpected errors are logged with their trace and answered without any detail.
"""

import contextlib
import logging
from typing import Any, cast

from fastapi import FastAPI
from fastapi.exceptions import RequestValidationError, WebSocketRequestValidationError
from fastapi.responses import JSONResponse
from fastapi.routing import iter_route_contexts
from sqlalchemy.exc import OperationalError
from sqlalchemy.exc import TimeoutError as PoolTimeout
from starlette.exceptions import HTTPException
from starlette.requests import HTTPConnection, Request
from starlette.responses import Response
from starlette.routing import compile_path
from starlette.types import ExceptionHandler
from starlette.websockets import WebSocket, WebSocketDisconnect, WebSocketDisconnected

from app.errors import TelemotionError
from app.logs import request_id
from app.schemas import Spoken
from estimators.sentences import say

logger = logging.getLogger("telemotion.errors")

_CODES = {404: "not_found", 408: "too_slow", 413: "too_large"}

CLOSE_CODES = {401: 4401, 403: 4403, 404: 4404, 409: 4409, 413: 1009, 422: 4422, 429: 4429, 503: 1013}
"""WebSocket close code by status: the private range tells a browser what a refused HTTP request would
have."""


class ErrorOut(Spoken):
    """Every refusal: a fixed code for programs, a sentence for people, facts for both."""

    code: str
    message: str
    details: dict[str, Any]
    request_id: str
    """As in the header `X-Request-ID`; finds the lines of the service's log."""


class BodyTooLarge(HTTPException):
    """Raised while a body is being received, where only FastAPI's own error type passes through the
    parser.
    """

    def __init__(self, limit_bytes: int) -> None:
        super().__init__(413, say("edge.body_too_large", limit_bytes=limit_bytes))
        self.limit_bytes = limit_bytes


class BodyTooSlow(HTTPException):
    """Raised like `BodyTooLarge` when the sender of a body stops, or is too slow for too long."""

    def __init__(self, patience_s: float) -> None:
        # What still comes of the body is no request: the connection ends with the answer.
        super().__init__(408, say("edge.body_too_slow", patience_s=patience_s), {"Connection": "close"})


def register(app: FastAPI) -> None:
    """Install the handlers."""
    handlers = {
        TelemotionError: _expected,
        HTTPException: _http,
        RequestValidationError: _invalid,
        WebSocketRequestValidationError: _invalid,
        OperationalError: _database_busy,
        PoolTimeout: _database_busy,
    }
    for kind, handler in handlers.items():
        # One function serves requests and sockets, which Starlette's type cannot say.
        app.add_exception_handler(kind, cast(ExceptionHandler, handler))


def answer(status: int, code: str, message: str, details: dict[str, Any]) -> JSONResponse:
    """Return an error answer.

    Parameters
    ----------
    details : dict
        `retry_after_s` also becomes the header `Retry-After`.
    """
    headers = {"Cache-Control": "no-store"}
    if "retry_after_s" in details:
        headers["Retry-After"] = str(int(details["retry_after_s"]))
    said = ErrorOut(code=code, message=message, details=details, request_id=request_id.get())
    return JSONResponse(said.model_dump(mode="json"), status_code=status, headers=headers)


async def _expected(connection: Request | WebSocket, error: Exception) -> Response | None:
    if not isinstance(error, TelemotionError):
        raise error
    if error.status == 500:
        logger.error("unexpected %s in %s", error.code, _where(connection), exc_info=error)
    if error.status == 503:
        error.details.setdefault("retry_after_s", 5)
    return await _send(connection, error.status, error.code, error.message, error.details)


async def _http(connection: Request | WebSocket, error: Exception) -> Response | None:
    if not isinstance(error, HTTPException):
        raise error
    if error.status_code == 400:
        # FastAPI's own word for a body that is no JSON; everywhere else input that is not understood is 422.
        return await _send(connection, 422, "invalid_input", say("edge.no_json"), {})
    if error.status_code == 405 and isinstance(connection, Request):
        return method_not_allowed(connection)
    details = {"limit_bytes": error.limit_bytes} if isinstance(error, BodyTooLarge) else {}
    code = _CODES.get(error.status_code, "http")
    message = say("edge.no_such_address") if error.status_code == 404 else error.detail
    refusal = await _send(connection, error.status_code, code, message, details)
    if refusal is not None:
        refusal.headers.update(error.headers or {})
    return refusal


def allowed_methods(request: Request) -> list[str]:
    """Return what may be done at a request's address, sorted; empty where nothing is."""
    path = request.scope["path"]
    found: set[str] = set()
    for context in iter_route_contexts(request.app.routes):
        # The client's own route matches every address and says nothing of it.
        is_page = context.path is None or context.path.endswith(":path}")
        if not is_page and context.methods and compile_path(str(context.path))[0].match(path):
            found |= context.methods
    return sorted(found)


def method_not_allowed(request: Request) -> JSONResponse:
    """Return the answer to a method that an address does not know, with those that it does."""
    allowed = ", ".join(allowed_methods(request))
    refusal = answer(405, "method_not_allowed", say("edge.method", allowed=allowed or "GET"), {})
    refusal.headers["Allow"] = allowed or "GET"
    return refusal


async def _invalid(connection: Request | WebSocket, error: Exception) -> Response | None:
    if not isinstance(error, RequestValidationError | WebSocketRequestValidationError):
        raise error
    fields = [
        {"field": ".".join(str(part) for part in problem["loc"]), "problem": str(problem["msg"])}
        for problem in error.errors()
    ]
    message = say("edge.fields", fields=[field["field"] for field in fields[:5]])
    return await _send(connection, 422, "invalid_input", message, {"fields": fields})


async def _database_busy(connection: Request | WebSocket, error: Exception) -> Response | None:
    logger.error("the database did not answer in %s", _where(connection), exc_info=error)
    message = say("edge.database_busy")
    return await _send(connection, 503, "unavailable", message, {"retry_after_s": 5})


def unexpected(connection: HTTPConnection, error: Exception) -> JSONResponse:
    """Log an error that nobody expected and return an answer that says nothing of it."""
    logger.error("unexpected %s in %s", type(error).__name__, _where(connection), exc_info=error)
    return answer(500, "internal", say("edge.unexpected"), {})


async def _send(
    connection: Request | WebSocket, status: int, code: str, message: str, details: dict[str, Any]
) -> Response | None:
    if not isinstance(connection, WebSocket):
        return answer(status, code, message, details)
    # Before the handshake this becomes a refusal (HTTP 403); after it, a close frame with the code as its
    # reason.
    # Whoever heard why by a message may have left already.
    with contextlib.suppress(WebSocketDisconnect, WebSocketDisconnected):
        await connection.close(code=CLOSE_CODES.get(status, 1011), reason=code)
    return None


def _where(connection: HTTPConnection) -> str:
    route = connection.scope.get("route")
    return getattr(route, "path", "an unknown route")
