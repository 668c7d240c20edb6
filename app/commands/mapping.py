"""Which columns of a table hold what: from a file that a person wrote, or guessed; see docs/mapping.md."""

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import typer
from pydantic import ValidationError

from app import readers
from app.commands.options.several import as_one
from app.commands.options.tables import MappingOptions
from app.errors import InvalidInput

if TYPE_CHECKING:
    from app.readers import Guess, PipelineName, Preview
    from app.readers.tables.look import Look
    from app.readers.tables.schemas import CsvMapping


def mapping_from(path: Path) -> "CsvMapping":
    """Read a mapping file.

    Raises
    ------
    InvalidInput
        It is no JSON, or says something that is no mapping; with the signal and its columns.
    """
    from app.readers.tables.schemas import CsvMapping

    try:
        content = json.loads(path.read_text("utf-8"))
        return CsvMapping.model_validate(content)
    except ValidationError as error:
        raise InvalidInput(
            f"{path}: {'; '.join(_complaint(one, content) for one in error.errors())}"
        ) from None
    except ValueError as error:
        raise InvalidInput(f"{path} is no JSON file: {error}") from None


def mapping(options: MappingOptions) -> None:
    """Write the mapping of a table as far as it can be guessed: `telemotion mapping`.

    Raises
    ------
    InvalidInput
        A file of a known format needs no mapping.
    RecordingFormatError
        It is no table.
    """
    with as_one(options.table) as table:
        found = previewed(table, options.pipeline, options.rate_hz)
    if found.guess is None:
        raise InvalidInput(f"{table} is a file of the format {found.format}: it is read without a mapping")
    text = as_json(found.guess)
    if options.out is None:
        typer.echo(text)
    else:
        options.out.write_text(text + "\n", "utf-8")
    look = say_how_read(found)
    for line in look.missing:
        typer.echo(line, err=True)


def previewed(table: Path, pipeline: str, rate_hz: float | None) -> "Preview":
    """Say what a file seems to be, as the upload page shows it; see `preview_text`.

    Raises
    ------
    InvalidInput, RecordingFormatError
        Nobody reads it.
    """
    from app.readers.tables.preview import Preview

    format = readers.guess(table)
    reader = readers.reader_of(format)
    if format == "zipped":
        return readers.preview_zip(table, cast("PipelineName | None", pipeline or None), rate_hz)
    if not reader.needs_mapping and not readers.TEXT & reader.endings:
        # What says by itself what it is needs no guess.
        return Preview(format, cast("PipelineName", reader.pipeline or pipeline))
    asked = cast("PipelineName | None", pipeline or None)
    start, later = readers.start_of(table), readers.later_of(table)
    return readers.preview_text(table.name, start, asked, rate_hz, later)


def say_how_read(found: "Preview", hemisphere: str | None = None) -> "Look":
    """Print what each sensor of a table is taken for and what that assumes, in the sentences of the upload page.

    Parameters
    ----------
    found : Preview
        With a guess.
    hemisphere : {"north", "south", "unknown"}, optional
        Where it is taken to be recorded; None: nothing is said of it.
    """
    from app.readers.tables.look import look_at

    assert found.head is not None
    assert found.guess is not None
    look = look_at(found.head, found.guess, hemisphere=hemisphere)
    for one in look.sensors:
        typer.echo(one.sentence, err=True)
    for line in look.assumed:
        typer.echo(f"note: {line}", err=True)
    return look


def guessed_mapping(
    found: "Preview", written: Path | None, hemisphere: str | None = None
) -> "CsvMapping | None":
    """Return the guessed mapping of a table, or None for a format that needs none; say what was assumed.

    Parameters
    ----------
    written : Path or None
        Where the mapping is written, also when it is not complete.
    hemisphere : {"north", "south", "unknown"}, optional
        Where it is taken to be recorded; None: the service decides it.

    Raises
    ------
    InvalidInput
        The table does not say everything; says which columns, and where to complete the mapping.
    """
    guess = found.guess
    if guess is None:
        return None
    if written is not None:
        written.parent.mkdir(parents=True, exist_ok=True)
        written.write_text(as_json(guess) + "\n", "utf-8")
    say_how_read(found, hemisphere)
    if guess.missing:
        needs_rate = any(one.code in {"guess.no_time", "guess.counter_needs_rate"} for one in guess.missing)
        advice = (
            f"complete {written} and pass it with --mapping"
            if written
            else "write one with `telemotion mapping` and pass it with --mapping"
        )
        if needs_rate:
            advice = f"say it with --rate, {'or' if len(guess.missing) == 1 else 'and'} {advice}"
        raise InvalidInput(
            f"{' '.join(guess.missing)} {advice[:1].upper()}{advice[1:]}.",
            missing=[one.code for one in guess.missing],
        )
    from app.readers.tables.schemas import CsvMapping

    return CsvMapping.model_validate(guess.mapping)


def as_json(guess: "Guess") -> str:
    """Return a mapping as people edit it."""
    return json.dumps(guess.mapping, indent=2, ensure_ascii=False)


def _complaint(error: Any, content: Any) -> str:
    """Say what is wrong in a mapping file, with the columns of the signal it is about."""
    where = error["loc"]
    if len(where) > 1 and where[0] == "signals":
        signal = content["signals"][where[1]]
        columns = signal.get("columns") if isinstance(signal, dict) else None
        named = f" ({', '.join(map(str, columns))})" if isinstance(columns, list) else ""
        return f"signal {where[1] + 1}{named}, {'.'.join(map(str, where[2:]))}: {error['msg']}"
    return f"{'.'.join(map(str, where))}: {error['msg']}"
