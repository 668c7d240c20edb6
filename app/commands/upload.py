"""`telemotion upload`: a whole recording to a service, with its progress."""

import asyncio
from pathlib import Path

import typer

from app import readers
from app.commands.mapping import guessed_mapping, mapping_from, previewed
from app.commands.options.several import as_one
from app.commands.options.tables import UploadOptions
from app.errors import InvalidInput, TelemotionError
from app.gateway import ServiceClient
from app.recordings.schemas import JobOut, UploadIn

POLL_S = 0.5


async def send(service: ServiceClient, path: Path, declaration: UploadIn) -> JobOut:
    """Upload one file; returns the queued task.

    Parameters
    ----------
    service : ServiceClient
        Signed in.

    Raises
    ------
    TelemotionError
        The service refused the file; the message says why.
    """
    # The declaration must come before the file, so that a wrong one is refused before anything is received.
    with path.open("rb") as file:
        response = await service.http.post(
            "/api/uploads",
            files=[
                ("declaration", (None, declaration.model_dump_json(), "application/json")),
                ("file", (path.name, file, "application/octet-stream")),
            ],
            timeout=600.0,
        )
    if not response.is_success:
        try:
            raise InvalidInput(str(response.json()["message"]))
        except (ValueError, KeyError, TypeError):
            raise InvalidInput(f"The service answered {response.status_code}.") from None
    return JobOut.model_validate(response.json())


async def finished(service: ServiceClient, session_id: str, show: bool = False) -> None:
    """Wait until an uploaded session is analysed.

    Parameters
    ----------
    show : bool
        Print progress lines.

    Raises
    ------
    TelemotionError
        The task failed; the message says why.
    """
    shown = ""
    while True:
        jobs = await service.jobs(session_id)
        for job in jobs:
            if job.status == "failed":
                raise TelemotionError(job.message or "The task failed.")
            line = f"{job.kind} {round(100 * job.progress)} %"
            if show and job.status == "running" and line != shown:
                typer.echo(line)
                shown = line
        if jobs and all(job.status == "complete" for job in jobs):
            state = await service.state(session_id)
            if state.state in {"analysed", "failed"}:
                for job in jobs if show else ():
                    if job.message:
                        typer.echo(f"note: {job.message}", err=True)
                return
        await asyncio.sleep(POLL_S)


def declaration_of(recording: Path, options: UploadOptions) -> UploadIn:
    """Return the declaration of a file, guessed where it was not said.

    Raises
    ------
    InvalidInput
        Something that is needed was not given, or is not understood.
    """
    if options.mapping and options.guess:
        raise InvalidInput("give --mapping or --guess, not both")
    format, pipeline, hemisphere = options.format, options.pipeline, options.hemisphere or None
    columns = mapping_from(options.mapping) if options.mapping else None
    if options.guess:
        found = previewed(recording, pipeline, options.rate_hz)
        columns = guessed_mapping(found, None, hemisphere)
        format, pipeline = found.format, pipeline or found.pipeline
    elif format == "auto":
        format = readers.format_of(recording, columns)
    if columns is not None and not pipeline:
        pipeline = readers.pipeline_for([signal.placement or "" for signal in columns.signals])
    if format == "csv" and columns is None:
        raise InvalidInput(
            "a table needs --guess, or a mapping that `telemotion mapping` writes to be corrected"
        )
    return UploadIn.model_validate(
        {
            "patient_id": options.patient,
            "exercise_id": options.exercise or None,
            "format": format,
            "file_name": recording.name[-200:],
            "csv": columns,
            "pipeline": pipeline or None,
            "accept_implausible": options.force,
            "hemisphere": hemisphere,
            "recorded_at": options.recorded_at and options.recorded_at.astimezone().isoformat(),
        }
    )


def upload(options: UploadOptions) -> None:
    """Run the command; see `telemotion upload --help`.

    Raises
    ------
    InvalidInput
        Something that is needed was not given, or is not understood.
    """
    if not options.email or not options.password:
        raise InvalidInput("--email and --password must be given; see `telemotion upload --help`")
    with as_one(options.recording) as recording:
        asyncio.run(_upload(recording, declaration_of(recording, options), options))


async def _upload(path: Path, declaration: UploadIn, options: UploadOptions) -> None:
    async with ServiceClient(options.server) as service:
        await service.sign_in(options.email, options.password)
        job = await send(service, path, declaration)
        typer.echo("received")
        await finished(service, job.session_id, show=True)
        typer.echo(f"analysed: {service.server}/sessions/{job.session_id}")
