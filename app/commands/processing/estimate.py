"""The steps of `telemotion process` after reading: checks, estimation, output."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np
import typer

from app import readers
from app.commands.processing.walk import analyse, write_walk
from app.errors import InvalidInput
from app.kinds.walk.shoe_arrays import as_stored as shoes_as_stored
from app.network.declaration import WALKING
from app.readers.judged import cut, judged
from estimators import orientation as orientations
from estimators import pipelines, signals
from estimators.body import BodyDimensions, body_from_stature
from estimators.calibration import Hemisphere
from estimators.conventions import Placement
from estimators.pipelines import Frames, SessionSetup, ShoeWalk, Walk
from estimators.recording import Recording, SensorSignals
from estimators.sentences import say

if TYPE_CHECKING:
    import pyarrow as pa


@dataclass(frozen=True)
class Asked:
    """How a recording is to be estimated; see `ProcessOptions`."""

    format: str
    pipeline: str
    orientation: str
    rate_hz: float | None
    pose_s: tuple[float, float] | None
    parameters: dict[str, Any]
    force: bool
    hemisphere: Hemisphere


@dataclass(frozen=True)
class Estimated:
    """A recording, estimated.

    Attributes
    ----------
    setup : SessionSetup
        As it was used, with the calibration that was found.
    walk : Walk or None
        Of a walk its strides and measures.
    forces : ShoeWalk or None
        Of instrumented shoes.
    note : str
        Why there are no forces although load cells were worn; else empty.
    """

    frames: Frames
    setup: SessionSetup
    walk: Walk | None = None
    forces: ShoeWalk | None = None
    note: str = ""


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
    found = estimated(measured, asked, lambda line: typer.echo(line, err=True))
    out.mkdir(parents=True, exist_ok=True)
    if found.walk is not None:
        write_walk(found.walk, out, found.forces, found.note)
    # What writes results loads the service: not before the estimate is there.
    from app.recordings.result_files import origin_of, setup_record, write_results

    origin = origin_of(file, asked.format)
    table = table_of(found, {**origin, "setup": setup_record(found.setup)})
    write_results(table, found.setup, origin, out)
    _say(found.frames, found.setup, out)


def table_of(found: Estimated, about: dict[str, Any] | None = None) -> "pa.Table":
    """Return the frames as one table; see `app.recordings.columns.frames_table`."""
    from app.recordings.columns import frames_table

    setup = found.setup
    body = setup.body if pipelines.kind(setup.pipeline).needs_pose else None
    return frames_table(found.frames, body, pipeline=setup.pipeline, about=about)


def estimated(measured: Recording, asked: Asked, say_line: Callable[[str], None]) -> Estimated:
    """Check and estimate a recording.

    Parameters
    ----------
    say_line : callable
        Takes each warning and note as one line, as soon as it is known.

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
            say_line(f"note: {say('file.left_out', names=list(prepared.left_out))}")
    setup = SessionSetup(
        pipeline=asked.pipeline,
        # The arm pipeline leaves the legs out: they need not be still in the pose.
        placements=kind.used(cast(tuple[Placement, ...], measured.placements)),
        rate_hz=measured.nominal_rate_hz if asked.rate_hz is None else asked.rate_hz,
        orientation=orientation,
        orientation_parameters=asked.parameters,
        # As in the service for a person whom nobody measured.
        body=body_from_stature(BodyDimensions().stature_m),
    )
    setup = _checked(measured, setup, asked, say_line)
    if asked.pipeline == WALKING:
        walk, forces, note = analyse(measured, shoes, setup)
        return Estimated(walk.frames, setup, walk, forces, note)
    return Estimated(*pipelines.run(measured, setup, asked.pose_s, elbows_from_movement=kind.needs_pose))


def _checked(
    measured: Recording, setup: SessionSetup, asked: Asked, say_line: Callable[[str], None]
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
    remedy = say("process.correct_or_force")
    found = judged(cut(chunk), tuple(worn), asked.hemisphere, is_accepted=asked.force, remedy=remedy)
    for doubt in found.doubts:
        say_line(f"warning: {doubt}")
    for note in found.notes:
        say_line(f"note: {note}")
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
