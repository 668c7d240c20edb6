"""`telemotion process`: a recording file in, columns out, without a server."""

import json
from pathlib import Path
from typing import TYPE_CHECKING, Final, cast

import typer

from app import readers
from app.commands.mapping import guessed_mapping, mapping_from, previewed
from app.commands.options.recordings import ProcessOptions
from app.commands.options.several import as_one
from app.errors import InvalidInput

if TYPE_CHECKING:
    from estimators.calibration import Hemisphere

_BURSTS: Final = "magnetic_bursts"


def process(options: ProcessOptions) -> None:
    """Estimate a recording and write its results; for bursts see `app.commands.processing.bursts`.

    Raises
    ------
    InvalidInput
        When a word is unknown, the file cannot be read as declared, or its readings are implausible.
    """
    with as_one(options.recording) as recording:
        if options.pipeline == _BURSTS:
            from app.commands.processing.bursts import process_bursts

            process_bursts(recording, options)
        else:
            _process(recording, options)


def _process(recording: Path, options: ProcessOptions) -> None:
    given, format, pipeline = json.loads(options.parameters), options.format, options.pipeline
    hemisphere = options.hemisphere or "north"
    if options.mapping and options.guess:
        raise InvalidInput("give --mapping or --guess, not both")
    columns = mapping_from(options.mapping) if options.mapping else None
    if options.guess:
        found = previewed(recording, pipeline, options.rate_hz)
        columns = guessed_mapping(found, options.out / "mapping.json", hemisphere)
        format, pipeline = found.format, pipeline or found.pipeline
    elif format == "auto":
        format = readers.format_of(recording, columns)
    with readers.accepting(options.force) as doubts:
        measured = readers.read(recording, format, columns)
    for doubt in doubts:
        typer.echo(f"warning: {doubt}", err=True)
    for line in measured.notes:
        typer.echo(f"note: {line}", err=True)
    pipeline = pipeline or readers.pipeline_for(list(measured.placements))
    # What follows loads the estimators: not for a file that is refused.
    from app.commands.processing.estimate import Asked, estimate

    asked = Asked(
        format,
        pipeline,
        options.orientation,
        options.rate_hz,
        options.pose_s,
        given,
        options.force,
        cast("Hemisphere", hemisphere),
    )
    estimate(measured, recording, options.out, asked)
