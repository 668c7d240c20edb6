"""Options of `telemotion upload` and `telemotion mapping`: files of other devices."""

from datetime import datetime
from pathlib import Path
from typing import Annotated

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


def upload(
    recording: RecordingFiles,
    patient: Annotated[str, typer.Option(help="Patient identifier.")],
    format: RecordingFormat = "auto",
    mapping: Mapping = None,
    guess: Guess = False,
    pipeline: Pipeline = "",
    rate: Annotated[
        float | None, typer.Option(help="Samples a second of a table without time, with --guess.")
    ] = None,
    force: Annotated[
        bool, typer.Option("--force", help="Estimate although units, axes or signs cannot be right.")
    ] = False,
    exercise: Annotated[str, typer.Option(help="Exercise identifier; empty for a free session.")] = "",
    recorded_at: Annotated[
        datetime | None,
        typer.Option(
            help="When it was recorded, by the clocks here; default: as the file says, else now.",
            formats=["%Y-%m-%d", "%Y-%m-%dT%H:%M", "%Y-%m-%dT%H:%M:%S"],
        ),
    ] = None,
    hemisphere: Annotated[
        str,
        typer.Option(
            help="north, south or unknown: where it was recorded; empty: where the service is.",
            callback=known_hemisphere,
        ),
    ] = "",
    server: Server = "http://127.0.0.1:8000",
    email: Email = "",
    password: Password = "",
) -> None:
    """Upload a whole recording and wait until it is analysed; prints where to see it."""
    from app.commands import upload as command
    from app.commands.options.several import as_one

    wanted = command.Wanted(
        patient,
        exercise or None,
        format,
        mapping,
        guess,
        pipeline,
        rate,
        force,
        recorded_at,
        hemisphere or None,
    )
    with as_one(recording) as one:
        command.upload(
            one,
            wanted,
            server,
            email,
            password,
        )


def mapping(
    table: RecordingFiles,
    out: Annotated[Path | None, typer.Option(help="JSON file to write; default: standard output.")] = None,
    pipeline: Pipeline = "",
    rate: Annotated[
        float | None, typer.Option(help="Samples a second, where no column holds the time.")
    ] = None,
) -> None:
    """Write which columns of a table hold what, as far as it can be guessed, to be corrected and passed as --mapping.

    Example: telemotion mapping walk.csv --out mapping.json
    """
    from app.commands import mapping as command
    from app.commands.options.several import as_one

    with as_one(table) as one:
        command.mapping(one, out, pipeline, rate)
