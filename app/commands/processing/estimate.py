"""The steps of `telemotion process` after reading: checks, estimation, output."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, cast

import numpy as np
import typer

from app import readers
from app.commands.processing.walk import analyse, write_walk
from app.errors import InvalidInput
from app.kinds.walk.shoe_arrays import as_stored as shoes_as_stored
from app.network.declaration import WALKING
from app.readers.judged import cut, judged
from app.sentences import say
from estimators import orientation as orientations
from estimators import pipelines, signals
from estimators.body import BodyDimensions, body_from_stature
from estimators.calibration import Hemisphere
from estimators.conventions import Placement
from estimators.pipelines import Frames, SessionSetup
from estimators.recording import Recording, SensorSignals


@dataclass(frozen=True)
class Asked:
    """How a recording is to be estimated; see `app.commands.process.process`."""

    format: str
    pipeline: str
    orientation: str
    rate_hz: float | None
    pose_s: tuple[float, float] | None
    parameters: dict[str, Any]
    force: bool
    hemisphere: Hemisphere


def estimate(measured: Recording, file: Path, out: Path, asked: Asked) -> None:
    """Estimate a recording and write its results.

    Parameters
    ----------
    file : Path
        From which it was read.
    out : Path
        Folder, made when absent.

    Raises
    ------
    InvalidInput
        For an unknown estimator, or readings that cannot be right.
    """
    orientation = asked.orientation or orientations.DEFAULT
    known = orientations.available(with_offline=True)
    if orientation not in known:
        raise InvalidInput(f"no estimator {orientation!r}; choose one of {', '.join(known)}")
    kind = pipelines.kind(asked.pipeline)
    shoes = shoes_as_stored(measured) if pipelines.has_shoes(measured) else None
    if not readers.reader_of(asked.format).holds_packets:
        # As an upload stores it: both are estimated from the same numbers.
        feet = measured if shoes is None else readers.as_feet(measured)
        prepared = readers.packets_of(feet, any_name=not kind.is_worn)
        measured = prepared.as_stored()
        if prepared.left_out:
            typer.echo(f"note: {say('file.left_out', names=list(prepared.left_out))}", err=True)
    setup = SessionSetup(
        pipeline=asked.pipeline,
        # The arm pipeline leaves the legs out: they need not be still in the pose.
        placements=kind.used(cast(tuple[Placement, ...], measured.placements)),
        rate_hz=asked.rate_hz or measured.nominal_rate_hz,
        orientation=orientation,
        orientation_parameters=asked.parameters,
        # As in the service for a person whom nobody measured.
        body=body_from_stature(BodyDimensions().stature_m),
    )
    setup = _checked(measured, setup, force=asked.force, hemisphere=asked.hemisphere)
    if asked.pipeline == WALKING:
        walk, forces, note = analyse(measured, shoes, setup)
        frames, used = walk.frames, setup
        out.mkdir(parents=True, exist_ok=True)
        write_walk(walk, out, forces, note)
    else:
        frames, used = pipelines.run(measured, setup, asked.pose_s, elbows_from_movement=kind.needs_pose)
        out.mkdir(parents=True, exist_ok=True)
    # What writes results loads the service: not before the estimate is there.
    from app.recordings.columns import frames_table
    from app.recordings.result_files import origin_of, setup_record, write_results

    origin = origin_of(file, asked.format)
    body = used.body if kind.needs_pose else None
    table = frames_table(frames, body, pipeline=asked.pipeline, about={**origin, "setup": setup_record(used)})
    write_results(table, used, origin, out)
    _say(frames, used, out)


def _checked(
    measured: Recording, setup: SessionSetup, *, force: bool, hemisphere: Hemisphere
) -> SessionSetup:
    """Refuse readings whose unit, axes or sign cannot be right, as an upload does; tell of the rest.

    Returns
    -------
    SessionSetup
        With what corrects accelerometers that were never calibrated.
    """
    worn: dict[str, SensorSignals] = {
        name: measured.sensors[name] for name in setup.placements if name in measured.sensors
    }
    if not worn:
        return setup
    chunk = signals.to_common_ticks(replace(measured, sensors=worn), setup.rate_hz)
    found = judged(
        cut(chunk), tuple(worn), hemisphere, is_accepted=force, remedy=say("process.correct_or_force")
    )
    for doubt in found.doubts:
        typer.echo(f"warning: {doubt}", err=True)
    for note in found.notes:
        typer.echo(f"note: {note}", err=True)
    return setup.with_devices(found.devices)


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
