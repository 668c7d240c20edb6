"""The words of `telemotion mass-centre`."""

from typing import Annotated

import typer

from app.commands.options.words import Mapping, OutFolder, Pose, Rate, RecordingFile, RecordingFormat


def mass_centre(
    recording: RecordingFile,
    out: OutFolder,
    stature: Annotated[
        float, typer.Option(help="Body height in metres; scales all lengths.", min=0.5, max=2.5)
    ] = 1.70,
    format: RecordingFormat = "auto",
    mapping: Mapping = None,
    rate: Rate = None,
    pose: Pose = None,
) -> None:
    """Find the body's centre of mass from sensors on trunk, thighs and whatever else is worn.

    Writes mass_centre.csv (ahead of and beside the ankles, above the floor, one sigma each) and mass_centre.json.
    Example: telemotion mass-centre squats.mat --stature 1.82 --out results
    """
    from app.commands import mass_centre as command

    command.mass_centre(recording, out, format, mapping, rate, pose, stature)
