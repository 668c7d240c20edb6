"""Arguments and options that several commands share."""

from pathlib import Path
from typing import Annotated

import typer

from app.readers.formats import names

Port = Annotated[int, typer.Option(help="TCP port to listen on.", min=1, max=65535)]
Server = Annotated[str, typer.Option(help="Address of the service.", envvar="TELEMOTION_SERVER")]
Email = Annotated[
    str, typer.Option(help="E-mail of an account that may treat the patient.", envvar="TELEMOTION_EMAIL")
]


def _shows(context: typer.Context, parameter: typer.CallbackParam) -> bool:
    """Return whether a value stands on the command line, where the list of processes shows it to everybody."""
    source = context.get_parameter_source(parameter.name or "")
    return source is not None and source.name == "COMMANDLINE"


def _warn_of_a_shown_password(context: typer.Context, parameter: typer.CallbackParam, value: str) -> str:
    if value and _shows(context, parameter):
        typer.echo(
            "the list of processes shows --password to everybody on this machine; set TELEMOTION_PASSWORD instead",
            err=True,
        )
    return value


def _refuse_a_shown_password(context: typer.Context, parameter: typer.CallbackParam, value: str) -> str:
    if value and _shows(context, parameter):
        raise typer.BadParameter(
            "it would show in the list of processes; leave it out to be asked, set TELEMOTION_PASSWORD, or name a file"
            " with --password-file"
        )
    return value


Password = Annotated[
    str,
    typer.Option(
        help="Its password; better given by TELEMOTION_PASSWORD.",
        envvar="TELEMOTION_PASSWORD",
        callback=_warn_of_a_shown_password,
    ),
]
NewPassword = Annotated[
    str,
    typer.Option(
        help="Refused, because it would show; TELEMOTION_PASSWORD is read.",
        envvar="TELEMOTION_PASSWORD",
        callback=_refuse_a_shown_password,
    ),
]
PasswordFile = Annotated[
    Path | None,
    typer.Option(help="File whose first line is the password.", exists=True, dir_okay=False, readable=True),
]

RecordingFile = Annotated[Path, typer.Argument(help="A recording file.", exists=True, dir_okay=False)]
RecordingFiles = Annotated[
    list[Path],
    typer.Argument(
        help="A recording file; or several tables of one recording that share a clock.",
        exists=True,
        dir_okay=False,
    ),
]
OutFolder = Annotated[Path, typer.Option(help="Folder for the results; made when absent.")]
RecordingFormat = Annotated[
    str,
    typer.Option(help=f"Of the recording: auto, {', '.join(names())}."),
]
Rate = Annotated[
    float | None, typer.Option("--rate", help="Common tick rate in Hz; default: the recording's.")
]
Pose = Annotated[
    tuple[float, float] | None,
    typer.Option("--pose", help="Start and end (s) of the N-pose; default: first stillness."),
]
Mapping = Annotated[
    Path | None,
    typer.Option(
        help="JSON file that says which CSV columns of the recording hold what; see docs/mapping.md."
    ),
]
Guess = Annotated[
    bool,
    typer.Option(
        "--guess",
        help="Guess how to read a table from the names of its columns and its numbers; `telemotion mapping` writes"
        " the guess to correct it.",
    ),
]


def known_hemisphere(value: str) -> str:
    """Refuse a word that is no hemisphere, before anything is read."""
    if value not in ("", "north", "south", "unknown"):
        raise typer.BadParameter("it is north, south or unknown")
    return value


Hemisphere = Annotated[
    str,
    typer.Option(
        help="north, south or unknown: where it was recorded; tells a reversed accelerometer. Default: as the service"
        " has it from TELEMOTION_HEMISPHERE, else north.",
        envvar="TELEMOTION_HEMISPHERE",
        callback=known_hemisphere,
    ),
]
