"""Expected failures of a command in one line each, instead of a trace."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from json import JSONDecodeError

import typer
from pydantic import ValidationError

from app.errors import TelemotionError
from estimators.errors import EstimationError

EXIT_REFUSED = 2


@contextmanager
def in_one_line() -> Iterator[None]:
    """Say an expected failure on standard error and end with code 2."""
    try:
        yield
    except (TelemotionError, EstimationError) as error:
        _refuse(str(error))
    except ValidationError as error:
        # Settings that refuse to start, or a mapping that is none: the reasons, without the values.
        lines = []
        for problem in error.errors(include_url=False, include_input=False, include_context=False):
            place = ".".join(str(part) for part in problem["loc"])
            lines.append(f"{place + ': ' if place else ''}{problem['msg']}")
        _refuse(*lines)
    except JSONDecodeError as error:
        _refuse(f"this is no JSON: {error}")
    except Exception as error:
        words = _words_of_the_database(error)
        if words is None:
            raise
        _refuse(f"the database cannot be used: {words}")


def _words_of_the_database(error: Exception) -> str | None:
    """Return what a database complains about, without the statement, whose values are patient data; None for others."""
    # A command that uses no database has not loaded it, and gets no error of its.
    database = sys.modules.get("sqlalchemy.exc")
    if database is None or not isinstance(error, database.DBAPIError):
        return None
    from app.logs import safe_words

    return safe_words(error) or type(error).__name__


def _refuse(*lines: str) -> None:
    for line in lines:
        typer.echo(f"telemotion: {line}", err=True)
    sys.exit(EXIT_REFUSED)
