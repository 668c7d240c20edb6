"""The service's log: one line when something changes, as text or as JSON, on standard error.

Every line has time, level, logger and, where one is served, the request's identifier, which the answer carries too
(`X-Request-ID`). Lines name routes by their template and things by identifiers that say nothing outside the database.
Nothing that a person typed or a sensor measured is written: an exception is named by its type and place, its own words
only where they are ours or the database's about itself. Other people's libraries are heard from warnings upwards,
because below they write rows, addresses and messages. In a demonstration, whose patients are invented, exceptions keep
their words.
"""

import json
import logging
import logging.config
import sys
import threading
import traceback
from contextvars import ContextVar
from datetime import UTC, datetime
from types import TracebackType
from typing import Any, Final

from sqlalchemy.exc import IntegrityError, OperationalError

from app.errors import TelemotionError
from app.settings import Settings

OURS: Final = ("app", "telemotion", "estimators", "uvicorn", "alembic")
"""Loggers that the setting's level holds for."""

request_id: ContextVar[str] = ContextVar("request_id", default="")
"""Of the request that is being served; empty outside one."""

logger = logging.getLogger("telemotion.service")


def configure(settings: Settings) -> None:
    """Send everything that is logged, warned of or raised into the void to standard error, in one form.

    Parameters
    ----------
    settings : Settings
        `log_level`, `log_format` and `demo` are used.
    """
    level = settings.log_level.upper()
    form = {"()": JsonLines if settings.log_format == "json" else TextLines, "with_words": settings.demo}
    logging.config.dictConfig(
        {
            "version": 1,
            "disable_existing_loggers": False,
            "formatters": {"lines": form},
            "filters": {"addresses": {"()": _NoAddresses}},
            "handlers": {
                "stderr": {
                    "class": "logging.StreamHandler",
                    "stream": "ext://sys.stderr",
                    "formatter": "lines",
                    "filters": ["addresses"],
                }
            },
            "root": {"level": "WARNING" if level != "ERROR" else level, "handlers": ["stderr"]},
            "loggers": {name: {"level": level} for name in OURS},
        }
    )
    logging.captureWarnings(True)
    sys.excepthook = _uncaught
    threading.excepthook = _uncaught_in_thread


class _Lines(logging.Formatter):
    """What both forms have in common.

    Parameters
    ----------
    with_words : bool
        Write the words of every exception.
    """

    def __init__(self, *, with_words: bool = False) -> None:
        super().__init__()
        self._with_words = with_words

    def fields(self, record: logging.LogRecord) -> dict[str, Any]:
        """Return what a line says."""
        message = record.getMessage()
        if record.name == "asyncio":
            # Further lines are the representation of a task with its exception.
            message = message.partition("\n")[0]
        when = datetime.fromtimestamp(record.created, UTC).isoformat(timespec="milliseconds")
        found = {
            "time": when.replace("+00:00", "Z"),
            "level": record.levelname.lower(),
            "logger": record.name,
            "message": message,
        }
        if request_id.get():
            found["request_id"] = request_id.get()
        if record.exc_info and record.exc_info[1] is not None:
            found["exception"] = self._exception(record.exc_info[1])
        return found

    def _exception(self, error: BaseException) -> str:
        parts = []
        seen: set[int] = set()
        while id(error) not in seen:
            seen.add(id(error))
            words = str(error) if self._with_words else safe_words(error)
            name = f"{type(error).__module__}.{type(error).__qualname__}"
            frames = "".join(traceback.format_list(traceback.extract_tb(error.__traceback__)))
            parts.append(f"{frames}{name}{': ' if words else ''}{words}")
            following = error.__cause__ or (None if error.__suppress_context__ else error.__context__)
            error = following or error
        return "\nafter:\n".join(parts)


class JsonLines(_Lines):
    """One JSON object a line."""

    def format(self, record: logging.LogRecord) -> str:
        """Return the line."""
        return json.dumps(self.fields(record), ensure_ascii=False)


class TextLines(_Lines):
    """Time, level, logger, request and message in one line; an exception on indented lines below."""

    def format(self, record: logging.LogRecord) -> str:
        """Return the line."""
        fields = self.fields(record)
        request = f" [{fields['request_id']}]" if "request_id" in fields else ""
        message = str(fields["message"]).replace("\n", "\\n").replace("\r", "\\r")
        line = f"{fields['time']} {fields['level']:<7} {fields['logger']}{request} {message}"
        if "exception" in fields:
            line += "\n    " + str(fields["exception"]).replace("\n", "\n    ")
        return line


def safe_words(error: BaseException) -> str:
    """Return what an exception says where that cannot be what somebody typed or measured; else nothing."""
    if isinstance(error, TelemotionError):
        return error.message
    if isinstance(error, OperationalError | IntegrityError):
        diagnosis = getattr(error.orig, "diag", None)
        # PostgreSQL puts the values into further lines of its message.
        return str(getattr(diagnosis, "message_primary", None) or error.orig).partition("\n")[0]
    return error.strerror or "" if isinstance(error, OSError) else ""


class _NoAddresses(logging.Filter):
    """Leaves out uvicorn's lines on WebSockets, which hold addresses with identifiers; ours say the same."""

    def filter(self, record: logging.LogRecord) -> bool:
        return not (record.name.startswith("uvicorn") and '"WebSocket %s"' in str(record.msg))


def _uncaught(kind: type[BaseException], error: BaseException, trace: TracebackType | None) -> None:
    if issubclass(kind, KeyboardInterrupt):
        return
    logger.critical("an error that nobody handled", exc_info=(kind, error, trace))


def _uncaught_in_thread(arguments: threading.ExceptHookArgs) -> None:
    if arguments.exc_value is not None and not isinstance(arguments.exc_value, SystemExit):
        logger.critical("an error that nobody handled ended a thread", exc_info=arguments.exc_value)
