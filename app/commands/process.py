"""`telemotion process`: a recording file in, columns out, without a server."""

import json
from pathlib import Path
from typing import TYPE_CHECKING, Final, cast

import typer

from app import readers
from app.commands.mapping import guessed_mapping, mapping_from, previewed
from app.errors import InvalidInput

if TYPE_CHECKING:
    from estimators.calibration import Hemisphere

_BURSTS: Final = "magnetic_bursts"


def process(
    recording: Path,
    out: Path,
    pipeline: str,
    orientation: str,
    format: str,
    mapping: Path | None,
    rate: float | None,
    pose: tuple[float, float] | None,
    parameters: str,
    force: bool = False,
    hemisphere: str = "north",
    guess: bool = False,
) -> None:
    """Estimate a recording and write `frames.parquet`, `frames.csv`, `columns.json` and `setup.json`.

    Parameters
    ----------
    out : Path
        Folder, made when absent.
    pipeline, orientation : str
        Keys of the registries, empty for what the sensors are worn for and the default; or `magnetic_bursts`: then see
        `processing.bursts` for what is written.
    format : str
        `auto` goes by the file's ending and content.
    mapping : Path or None
        JSON with the fields of `CsvMapping`; see docs/mapping.md.
    rate : float or None
        Common tick rate; None keeps that of the recording.
    pose : (float, float) or None
        Interval of the N-pose in recording time; None looks for the first stillness.
    parameters : str
        Estimator parameters as JSON.
    force : bool
        Estimate although the readings are implausible.
    hemisphere : str
        `north`, `south` or `unknown`, for the sign of the field.
    guess : bool
        Guess the mapping of a table from the names of its columns, as the upload page does.

    Raises
    ------
    InvalidInput
        When a word is unknown, the file cannot be read as declared, or its readings are implausible.
    """
    if pipeline == _BURSTS:
        from app.commands.processing.bursts import process_bursts

        process_bursts(recording, out, format, rate, orientation, parameters)
        return
    given = json.loads(parameters)
    if mapping and guess:
        raise InvalidInput("give --mapping or --guess, not both")
    columns = mapping_from(mapping) if mapping else None
    if guess:
        found = previewed(recording, pipeline, rate)
        columns = guessed_mapping(found, out / "mapping.json", hemisphere)
        format, pipeline = found.format, pipeline or found.pipeline
    elif format == "auto":
        format = readers.format_of(recording, columns)
    with readers.accepting(force) as doubts:
        measured = readers.read(recording, format, columns)
    for doubt in doubts:
        typer.echo(f"warning: {doubt}", err=True)
    for line in measured.notes:
        typer.echo(f"note: {line}", err=True)
    pipeline = pipeline or readers.pipeline_for(list(measured.placements))
    # What follows loads the estimators: not for a file that is refused.
    from app.commands.processing.estimate import Asked, estimate

    estimate(
        measured,
        recording,
        out,
        Asked(format, pipeline, orientation, rate, pose, given, force, cast("Hemisphere", hemisphere)),
    )
