"""Options of `telemotion upload` and `telemotion mapping`: files of other devices."""

from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import Annotated, ClassVar

import typer

from app.commands.options.words import (
    Email,
    Guess,
    Mapping,
    Password,
    RecordingFiles,
    RecordingFormat,
    Server,
    known_hemisphere,
)

Pipeline = Annotated[
    str,
    typer.Option(help="arm, gait or orientation (single sensors); default: what the sensors are worn for."),
]


@dataclass(frozen=True, kw_only=True)
class UploadOptions:
    """Upload a whole recording and wait until it is analysed; prints where to see it."""

    command: ClassVar[str] = "upload"
    runs: ClassVar[str] = "app.commands.upload:upload"

    recording: RecordingFiles
    patient: Annotated[str, typer.Option(help="Patient identifier.")]
    format: RecordingFormat = "auto"
    mapping: Mapping = None
    guess: Guess = False
    pipeline: Pipeline = ""
    rate_hz: Annotated[
        float | None,
        typer.Option("--rate", help="Samples a second of a table without time, with --guess."),
    ] = None
    force: Annotated[
        bool, typer.Option("--force", help="Estimate although units, axes or signs cannot be right.")
    ] = False
    exercise: Annotated[str, typer.Option(help="Exercise identifier; empty for a free session.")] = ""
    recorded_at: Annotated[
        datetime | None,
        typer.Option(
            help="When it was recorded, by the clocks here; default: as the file says, else now.",
            formats=["%Y-%m-%d", "%Y-%m-%dT%H:%M", "%Y-%m-%dT%H:%M:%S"],
        ),
    ] = None
    hemisphere: Annotated[
        str,
        typer.Option(
            help="north, south or unknown: where it was recorded; empty: where the service is.",
            callback=known_hemisphere,
        ),
    ] = ""
    server: Server = "http://127.0.0.1:8000"
    email: Email = ""
    password: Password = ""


@dataclass(frozen=True, kw_only=True)
class MappingOptions:
    """Write which columns of a table hold what, as far as it can be guessed, to be corrected and passed as --mapping.

    Example: telemotion mapping walk.csv --out mapping.json
    """

    command: ClassVar[str] = "mapping"
    runs: ClassVar[str] = "app.commands.mapping:mapping"

    table: RecordingFiles
    out: Annotated[Path | None, typer.Option(help="JSON file to write; default: standard output.")] = None
    pipeline: Pipeline = ""
    rate_hz: Annotated[
        float | None, typer.Option("--rate", help="Samples a second, where no column holds the time.")
    ] = None
