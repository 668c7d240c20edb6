"""`telemotion process`: a recording file in, columns out, without a server."""

import json
from dataclasses import replace
from pathlib import Path
from typing import cast, get_args

import numpy as np
import typer

from app.commands.mapping import guessed_mapping, mapping_from, previewed
from app.errors import InvalidInput
from app.ingest import readers
from app.ingest.declaration import SINGLE_SENSORS, WALKING, estimated
from app.recordings.walk_shoes import as_stored as shoes_as_stored
from app.sentences import say
from estimators import orientation as orientations
from estimators import pipelines, signals
from estimators.body import BodyDimensions, body_from_stature
from estimators.calibration import Hemisphere, check_recording, in_words
from estimators.conventions import Placement
from estimators.pipelines import Frames, SessionSetup
from estimators.recording import Recording, SensorSignals


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
    recording : Path
    out : Path
        Folder, made when absent.
    pipeline, orientation : str
        Keys of the registries, empty for what the sensors are worn for and the default; or `magnetic_bursts`: then see
        `process_bursts` for what is written.
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
    if pipeline == pipelines.BURSTS:
        from app.commands.process_bursts import process_bursts

        process_bursts(recording, out, format, rate, orientation, parameters)
        return
    orientation = orientation or orientations.DEFAULT
    known = orientations.available(with_offline=True)
    if orientation not in known:
        raise InvalidInput(f"no estimator {orientation!r}; choose one of {', '.join(known)}")
    if mapping and guess:
        raise InvalidInput("give --mapping or --guess, not both")
    columns = mapping_from(mapping) if mapping else None
    if guess:
        found = previewed(recording, pipeline, rate)
        columns = guessed_mapping(found, out / "mapping.json")
        format, pipeline = found.format, pipeline or found.pipeline
    elif format == "auto":
        format = "csv" if columns is not None else readers.guess(recording)
    with readers.accepting(force) as doubts:
        measured = readers.read(recording, format, columns)
    for doubt in doubts:
        typer.echo(f"warning: {doubt}", err=True)
    for line in measured.notes:
        typer.echo(f"note: {line}", err=True)
    pipeline = pipeline or readers.pipeline_for(list(measured.placements))
    shoes = shoes_as_stored(measured) if pipelines.has_shoes(measured) else None
    if format != "packet_log":
        # As an upload stores it: both are estimated from the same numbers.
        feet = measured if shoes is None else readers.as_feet(measured)
        prepared = readers.packets_of(feet, any_name=pipeline == SINGLE_SENSORS)
        measured = prepared.as_stored()
        if prepared.left_out:
            typer.echo(f"note: {say('file.left_out', names=list(prepared.left_out))}", err=True)
    setup = SessionSetup(
        pipeline=pipeline,
        # The arm pipeline leaves the legs out: they need not be still in the pose.
        placements=estimated(cast(tuple[Placement, ...], measured.placements), pipeline),
        rate_hz=rate or measured.nominal_rate_hz,
        orientation=orientation,
        orientation_parameters=json.loads(parameters),
        # As in the service for a person whom nobody measured.
        body=body_from_stature(BodyDimensions().stature_m),
    )
    _check(measured, setup, force=force, hemisphere=hemisphere)
    # What follows loads the web framework and Arrow: not for a file that is refused.
    from app.commands.process_walk import analyse, write_walk
    from app.recordings.columns import frames_table
    from app.recordings.result_files import origin_of, setup_record, write_results

    if pipeline == WALKING:
        walk, forces, note = analyse(measured, shoes, setup)
        frames, used = walk.frames, setup
        out.mkdir(parents=True, exist_ok=True)
        write_walk(walk, out, forces, note)
    else:
        frames, used = pipelines.run(measured, setup, pose, elbows_from_movement=pipeline == "arm")
        out.mkdir(parents=True, exist_ok=True)
    origin = origin_of(recording, format)
    body = used.body if pipeline == "arm" else None
    table = frames_table(frames, body, pipeline=pipeline, about={**origin, "setup": setup_record(used)})
    write_results(table, used, origin, out)
    _say(frames, used, out)


def _check(measured: Recording, setup: SessionSetup, *, force: bool, hemisphere: str) -> None:
    """Refuse readings whose unit, axes or sign cannot be right; tell of the rest."""
    if hemisphere not in get_args(Hemisphere):
        raise InvalidInput(f"no hemisphere {hemisphere!r}; it is {', '.join(get_args(Hemisphere))}")
    worn: dict[str, SensorSignals] = {
        name: measured.sensors[name] for name in setup.placements if name in measured.sensors
    }
    if not worn:
        return
    chunk = signals.to_common_ticks(replace(measured, sensors=worn), setup.rate_hz)
    findings = check_recording(chunk, tuple(worn), hemisphere=cast(Hemisphere, hemisphere))
    refused = [finding for finding in findings if finding.severity == "refuse"]
    if refused and not force:
        raise InvalidInput(
            f"the readings cannot be right. {in_words(refused)} Declare the file rightly (--mapping), or use --force"
            " to estimate it as it is."
        )
    if findings:
        typer.echo(f"warning: {in_words(findings)}", err=True)


def _say(frames: Frames, setup: SessionSetup, out: Path) -> None:
    duration_s = frames.tick_count * frames.time_step_s
    typer.echo(f"{frames.tick_count} ticks, {duration_s:.1f} s at {setup.rate_hz:g} Hz -> {out}")
    if setup.calibration is not None:
        typer.echo(f"calibration: {setup.calibration.method}, score {setup.calibration.score:.2f}")
        for reason in setup.calibration.reasons:
            typer.echo(f"  {reason}")
    for index, name in enumerate(frames.layout.angles):
        angle = np.degrees(frames.angle_rad[:, index])
        if np.isfinite(angle).any():
            low, high = np.nanmin(angle), np.nanmax(angle)
            typer.echo(f"  {name:<52} {low:8.1f} to {high:8.1f} deg")
