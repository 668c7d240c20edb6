"""Words of the commands that estimate a recording, alone or with what was measured beside it."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, ClassVar

import typer

from app.commands.options.words import (
    Guess,
    Hemisphere,
    Mapping,
    OutFolder,
    Pose,
    Rate,
    RecordingFile,
    RecordingFiles,
    RecordingFormat,
)


@dataclass(frozen=True, kw_only=True)
class ProcessOptions:
    """Estimate a recording without a server; writes frames.parquet, frames.csv, columns.json, setup.json.

    Example: telemotion process walk.mat --pipeline orientation --orientation vqf --out results
    """

    command: ClassVar[str] = "process"
    runs: ClassVar[str] = "app.commands.process:process"

    recording: RecordingFiles
    out: OutFolder
    pipeline: Annotated[
        str,
        typer.Option(
            help="arm (joint angles), gait (feet and strides), orientation (single sensors) or magnetic_bursts;"
            " default: what the sensors are worn for."
        ),
    ] = ""
    orientation: Annotated[
        str, typer.Option(help="Orientation estimator, e.g. vqf; empty for the default.")
    ] = ""
    format: RecordingFormat = "auto"
    mapping: Mapping = None
    guess: Guess = False
    rate_hz: Rate = None
    pose_s: Pose = None
    parameters: Annotated[str, typer.Option(help="Estimator parameters as JSON.")] = "{}"
    force: Annotated[
        bool, typer.Option("--force", help="Estimate although units, axes or signs cannot be right.")
    ] = False
    hemisphere: Hemisphere = ""


@dataclass(frozen=True, kw_only=True)
class MassCentreOptions:
    """Find the body's centre of mass from sensors on trunk, thighs and whatever else is worn.

    Writes mass_centre.csv (ahead of and beside the ankles, above the floor, one sigma each) and mass_centre.json.
    Example: telemotion mass-centre squats.mat --stature 1.82 --out results
    """

    command: ClassVar[str] = "mass-centre"
    runs: ClassVar[str] = "app.commands.mass_centre:mass_centre"

    recording: RecordingFile
    out: OutFolder
    stature_m: Annotated[
        float, typer.Option("--stature", help="Body height in metres; scales all lengths.", min=0.5, max=2.5)
    ] = 1.70
    format: RecordingFormat = "auto"
    mapping: Mapping = None
    rate_hz: Rate = None
    pose_s: Pose = None


@dataclass(frozen=True, kw_only=True)
class FuseOptions:
    """Fuse a sensor with a marker of a camera system: gaps filled, motion at the rate of the sensor.

    Aligns the clocks by the movement; writes motion.csv (smoothed), filter.csv (what was known at each moment),
    lagged.csv (with --lag: a moment later), residuals.csv, gaps.csv and report.json. Markers in a CSV are columns
    NAME_x, NAME_y, NAME_z and time_s. Example:

    telemotion fuse walk.tml walk.c3d --sensor foot_right --marker RHEE --out results
    """

    command: ClassVar[str] = "fuse"
    runs: ClassVar[str] = "app.commands.fuse:fuse"

    recording: RecordingFile
    markers: Annotated[
        Path, typer.Argument(help="Markers of a camera system: C3D or CSV.", exists=True, dir_okay=False)
    ]
    out: OutFolder
    sensor: Annotated[
        str, typer.Option(help="Sensor that moved with the marker; needed when there are several.")
    ] = ""
    format: RecordingFormat = "auto"
    mapping: Mapping = None
    rate_hz: Annotated[
        float | None,
        typer.Option("--rate", help="Tick rate in Hz; default: the recording's.", min=10, max=10000),
    ] = None
    marker: Annotated[str, typer.Option(help="Name of the marker; default: the one seen most.")] = ""
    cluster: Annotated[
        list[str] | None,
        typer.Option(help="Another marker of the same rigid body, three or more: aligns by rate too."),
    ] = None
    up: Annotated[str, typer.Option(help="Axis of the laboratory that points up: x, y, z, -x, -y or -z.")] = (
        "z"
    )
    unit: Annotated[str, typer.Option(help="Of a CSV of markers: mm, cm, m or inch.")] = "mm"
    marker_rate_hz: Annotated[
        float | None,
        typer.Option("--marker-rate", help="Frames a second of a CSV without a column time_s."),
    ] = None
    delimiter: Annotated[str, typer.Option(help="Of a CSV of markers.")] = ","
    lever_arm_m: Annotated[
        tuple[float, float, float] | None,
        typer.Option(
            "--lever-arm", help="From sensor to marker in sensor axes (m), if measured; default: found."
        ),
    ] = None
    largest_offset_s: Annotated[
        float | None, typer.Option("--largest-offset", help="How far the clocks can be apart (s).")
    ] = None
    lag_s: Annotated[
        float | None, typer.Option("--lag", help="Also report what is known so many seconds later.")
    ] = None


@dataclass(frozen=True, kw_only=True)
class CalibrateOptions:
    """Find moment, place and direction of each coil of a magnetic source from a bench recording.

    Example: telemotion calibrate-source bench.tml --places places.csv --serial S-12 --out S-12.json
    """

    command: ClassVar[str] = "calibrate-source"
    runs: ClassVar[str] = "app.commands.calibrate_source:calibrate_source"

    recording: Annotated[
        Path,
        typer.Argument(
            help="Packet log of a session in which the sensor was laid at places around the source.",
            exists=True,
            dir_okay=False,
        ),
    ]
    places: Annotated[
        Path | None,
        typer.Option(
            help="CSV: x, y, z in metres from the middle of the source along its axes, a line for each place; - leaves"
            " one out. Without it the places that were found are listed.",
            exists=True,
            dir_okay=False,
        ),
    ] = None
    serial: Annotated[str, typer.Option(help="Serial number of the source.")] = ""
    name: Annotated[str, typer.Option(help="Its name; default: the serial number.")] = ""
    out: Annotated[Path | None, typer.Option(help="JSON file to write, for the clinic's page.")] = None
    source: Annotated[str, typer.Option(help="Placement of the source; default: pelvis, sternum, foot.")] = ""
    sensor: Annotated[str, typer.Option(help="Placement of the sensor; default: the first other one.")] = ""
    ruler_mm: Annotated[
        float, typer.Option(help="How well the places were measured, one sigma.", min=0.05, max=20)
    ] = 1.0
    turns: Annotated[float, typer.Option(help="Of a coil as designed.", min=1, max=5000)] = 50.0
    radius_cm: Annotated[float, typer.Option(help="Of a coil as designed.", min=0.5, max=50)] = 5.5
    offset_cm: Annotated[
        float, typer.Option(help="From the middle of the source to a coil, along its axis.", min=0, max=50)
    ] = 6.0
    current_limit_a: Annotated[
        float, typer.Option("--current-limit", help="Of the driver, in A.", min=0.01, max=9.9)
    ] = 1.5
